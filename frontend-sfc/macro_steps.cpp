#include "frontend-sfc/macro_steps.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/text.h"

namespace plc::sfc {

using core::Code;
using core::ElementKind;
using plcopen::Body;
using plcopen::Connection;
using plcopen::Element;
using plcopen::Pin;

namespace {

template <class Visit>
void each_wire(Element& element, const Visit& visit) {
  const auto of = [&](Pin& pin) {
    for (Connection& connection : pin.connections) visit(connection);
  };
  for (Pin& pin : element.inputs) of(pin);
  for (Pin& pin : element.in_outs) of(pin);
  if (element.chart) of(element.chart->condition);
}

/// Gives the elements of `inner` ids that none of `taken` has, and their wires with them.
void renumber(Body& inner, std::set<std::int64_t>& taken) {
  std::map<std::int64_t, std::int64_t> changed;
  std::int64_t next = taken.empty() ? 1 : *taken.rbegin() + 1;
  for (Element& element : inner.elements) {
    std::int64_t& id = element.at.local_id;
    if (id < 0 || taken.insert(id).second) continue;
    while (!taken.insert(next).second) ++next;
    changed.emplace(id, next);
    id = next;
  }
  for (Element& element : inner.elements) {
    // Conditions are shared with the project, which stays as it is.
    if (element.chart) element.chart = std::make_shared<plcopen::ChartPart>(*element.chart);
    each_wire(element, [&](Connection& connection) {
      const auto found = changed.find(connection.ref_local_id);
      if (found != changed.end()) connection.ref_local_id = found->second;
    });
  }
}

/// The only step for which `is` holds; null when there is none, or several.
template <class Is>
Element* only_step(Body& body, const Is& is) {
  Element* found = nullptr;
  for (Element& element : body.elements) {
    if (element.kind != ElementKind::kStep || !is(element)) continue;
    if (found != nullptr) return nullptr;
    found = &element;
  }
  return found;
}

/// Where the macro step is entered: the step that is marked as initial, or the one that nothing leads to.
Element* entry_of(Body& inner) {
  if (Element* const marked = only_step(inner, [](const Element& step) { return step.chart->initial; })) return marked;
  return only_step(inner, [&](const Element& step) {
    const bool wired =
        std::any_of(step.inputs.begin(), step.inputs.end(), [](const Pin& pin) { return !pin.connections.empty(); });
    const bool jumped = std::any_of(inner.elements.begin(), inner.elements.end(), [&](const Element& other) {
      return other.kind == ElementKind::kJumpStep && core::iequals(other.text, step.text);
    });
    return !wired && !jumped;
  });
}

/// Where the macro step is left: the step that nothing follows.
Element* exit_of(Body& inner) {
  std::set<std::int64_t> followed;
  for (Element& element : inner.elements) {
    if (element.kind == ElementKind::kActionBlock) continue;
    each_wire(element, [&](const Connection& connection) { followed.insert(connection.ref_local_id); });
  }
  return only_step(inner, [&](const Element& step) { return !followed.contains(step.at.local_id); });
}

class Expansion {
 public:
  Expansion(const std::string& pou, core::Diagnostics& diagnostics) : pou_(pou), diagnostics_(diagnostics) {}

  Body run(const Body& body) {
    Body out = body;
    out.elements.clear();
    std::set<std::int64_t> taken;
    for (const Element& element : body.elements) taken.insert(element.at.local_id);
    std::map<std::int64_t, std::int64_t> exits;
    std::map<std::string, std::string> entries;  // by the folded name of the macro step
    for (const Element& element : body.elements) {
      if (element.kind != ElementKind::kMacroStep) {
        out.elements.push_back(element);
        if (element.chart) out.elements.back().chart = std::make_shared<plcopen::ChartPart>(*element.chart);
        continue;
      }
      const bool drawn = element.chart->macro && element.chart->macro->language == plcopen::Language::kSfc;
      Body inner = drawn ? run(*element.chart->macro) : Body{};
      renumber(inner, taken);
      Element* const entry = entry_of(inner);
      Element* const exit = exit_of(inner);
      if (entry == nullptr || exit == nullptr) {
        refuse(element, drawn, entry != nullptr);
        continue;
      }
      exits.emplace(element.at.local_id, exit->at.local_id);
      if (!element.text.empty()) entries.emplace(core::folded(element.text), entry->text);
      entry->chart->initial = false;
      entry->inputs.insert(entry->inputs.end(), element.inputs.begin(), element.inputs.end());
      out.drawn_elements += inner.drawn_elements;
      out.flags.insert(out.flags.end(), inner.flags.begin(), inner.flags.end());
      std::move(inner.elements.begin(), inner.elements.end(), std::back_inserter(out.elements));
      std::move(inner.closed_branches.begin(), inner.closed_branches.end(), std::back_inserter(out.closed_branches));
    }
    for (Element& element : out.elements) {
      each_wire(element, [&](Connection& connection) {
        const auto found = exits.find(connection.ref_local_id);
        if (found != exits.end()) connection.ref_local_id = found->second;
      });
      const auto entry =
          element.kind == ElementKind::kJumpStep ? entries.find(core::folded(element.text)) : entries.end();
      if (entry != entries.end()) element.text = entry->second;
    }
    return out;
  }

 private:
  void refuse(const Element& macro, bool drawn, bool has_entry) {
    const std::string name = "macro step" + (macro.text.empty() ? std::string() : " \"" + macro.text + '"');
    if (!drawn) {
      diagnostics_.report(Code::P3120, macro.at, pou_, name + " has no chart in it",
                          "draw the steps that it stands for");
    } else if (!has_entry) {
      diagnostics_.report(Code::P3120, macro.at, pou_, name + " has no single step to enter it by",
                          "begin its chart with one step that nothing leads to, or mark one as initial");
    } else {
      diagnostics_.report(
          Code::P3120, macro.at, pou_, name + " has no single step to leave it from",
          "end its chart with one step that nothing follows: what comes after the macro step waits for it");
    }
  }

  const std::string& pou_;
  core::Diagnostics& diagnostics_;
};

}  // namespace

bool has_macro_steps(const Body& body) {
  return std::any_of(body.elements.begin(), body.elements.end(),
                     [](const Element& element) { return element.kind == ElementKind::kMacroStep; });
}

Body expand_macro_steps(const Body& body, const std::string& pou, core::Diagnostics& diagnostics) {
  return Expansion(pou, diagnostics).run(body);
}

}  // namespace plc::sfc
