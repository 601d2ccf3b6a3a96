#include "engineering/diagram_search.h"

#include <algorithm>
#include <utility>

#include "bytecode/drawn_lines.h"
#include "core/text.h"
#include "engineering/drawn_place.h"
#include "shadow/writers.h"

namespace plc::engineering {
namespace {

using bytecode::DrawnBody;
using bytecode::DrawnElement;
using core::ElementKind;

constexpr std::string_view kOfNames = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.[]%";

/// Calls visit(name, what follows) for each name, path or number in a text as long as it returns true.
template <class Visit>
void each_name(std::string_view text, Visit&& visit) {
  for (std::size_t at = text.find_first_of(kOfNames); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_not_of(kOfNames, at), text.size());
    if (!visit(text.substr(at, end - at), text.substr(end))) return;
    at = text.find_first_of(kOfNames, end);
  }
}

bool is_assigned(std::string_view rest) { return core::trimmed(rest).starts_with(":="); }

/// "Level" of "Tank.Level".
std::string_view last_part(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos ? name : name.substr(dot + 1);
}

}  // namespace

bool DiagramSearch::add(Found one) {
  more = found.size() >= most;
  if (!more) found.push_back(std::move(one));
  return !more;
}

template <class Visit>
void DiagramSearch::each_text(const DrawnBody& body, Visit&& visit) const {
  for (std::uint32_t i = 0; i < body.elements.size(); ++i) {
    const DrawnElement& e = body.elements[i];
    const bool writes =
        e.kind == ElementKind::kCoil || e.kind == ElementKind::kOutVariable || e.kind == ElementKind::kInOutVariable;
    if (!visit(i, e.line, std::string_view(e.text), writes)) return;
    if (!e.instance.empty() && !visit(i, e.line, std::string_view(e.instance), false)) return;
    if (!e.code.empty() && !visit(i, e.line, std::string_view(e.code), false)) return;
    for (const bytecode::DrawnPin& pin : e.pins) {
      if (!pin.text.empty() && !visit(i, e.line, std::string_view(pin.text), pin.output)) return;
    }
    for (const bytecode::DrawnAction& action : e.actions) {
      if (!visit(i, action.line, std::string_view(action.text), true)) return;
    }
  }
  if (!body.elements.empty()) return;
  const bytecode::DrawnLines lines(body);
  for (std::size_t row = 0; row < lines.count(); ++row) {
    const auto line = body.text_line + static_cast<std::uint32_t>(row);
    if (!visit(kNoElement, line, lines.line(row), false)) return;
  }
}

void DiagramSearch::find_text(const DrawnPou* only) {
  const std::string wanted = core::folded(text);
  for (const DrawnPou& pou : book_.pous) {
    if (only != nullptr && only != &pou) continue;
    for (std::size_t b = 0; b < pou.bodies.size() && !more; ++b) {
      std::uint32_t last = kNoElement - 1;  // an element once
      each_text(*pou.bodies[b], [&](std::uint32_t element, std::uint32_t line, std::string_view at, bool writes) {
        if (element == last || core::folded(at).find(wanted) == std::string::npos) return true;
        if (element != kNoElement) last = element;
        return add({&pou, b, element, line, std::string(core::trimmed(at)), writes});
      });
    }
  }
}

void DiagramSearch::find_uses(const DrawnPou& in, const DrawnInstance* instance) {
  runtime::Resource& resource = diagrams_.resource();
  const auto meant = instance == nullptr ? std::nullopt : shadow::place_in(resource, instance->at.path, text);
  if (meant) {
    const runtime::Access access(resource);
    const std::string below = instance->at.path + "." + text;
    path = access.find(below) ? below : text;
  }
  for (const DrawnPou& pou : book_.pous) {
    if (more) return;
    const bool here = &pou == &in;
    const auto on = here ? std::optional<DrawnInstance>() : diagrams_.instance(pou, {}, {});
    if (!here && (!meant || !on)) continue;
    const std::string base = here ? instance == nullptr ? std::string() : instance->at.path : on->at.path;
    for (std::size_t b = 0; b < pou.bodies.size() && !more; ++b) {
      each_text(*pou.bodies[b], [&](std::uint32_t element, std::uint32_t line, std::string_view at, bool writes) {
        bool uses = false, assigned = false;
        each_name(at, [&](std::string_view name, std::string_view rest) {
          if (!core::iequals(last_part(name), last_part(text))) return true;
          if (!here || !core::iequals(name, text)) {
            if (!meant) return true;
            const auto is = shadow::place_in(resource, base, name);
            if (!is || is->task != meant->task || is->offset != meant->offset) return true;
          }
          uses = true;
          assigned = assigned || (element == kNoElement && is_assigned(rest));
          return !assigned;
        });
        return !uses || add({&pou, b, element, line, std::string(core::trimmed(at)), writes || assigned});
      });
    }
  }
}

}  // namespace plc::engineering
