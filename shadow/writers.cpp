#include "shadow/writers.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "bytecode/drawn_lines.h"
#include "core/text.h"

namespace plc::shadow {
namespace {

using bytecode::DrawnBody;
using bytecode::DrawnElement;
using core::ElementKind;
using runtime::Place;

/// What is looked at beyond that costs more than it tells.
constexpr std::size_t kMostRows = 200'000;
constexpr std::size_t kMostInstances = 10'000;

bool is_name(std::string_view text) {
  if (text.empty() || text.size() > 500) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isalnum(u) != 0 || u >= 0x80 || c == '_' || c == '.' || c == '[' || c == ']' || c == ',' || c == '%';
  });
}

/// The variable that a statement writes: "a" of "a := b;", and of "ST a" in IL.
std::string_view written_by(std::string_view statement, bool instructions) {
  if (!instructions) {
    const std::size_t at = statement.find(":=");
    return at == std::string_view::npos ? std::string_view() : core::trimmed(statement.substr(0, at));
  }
  const std::size_t end = statement.find_first_of(" \t");
  if (end == std::string_view::npos) return {};
  const std::string word = core::folded(statement.substr(0, end));
  const std::string st = core::folded("ST"), stn = core::folded("STN"), s = core::folded("S"), r = core::folded("R");
  if (word != st && word != stn && word != s && word != r) return {};
  const std::string_view rest = core::trimmed(statement.substr(end));
  return rest.substr(0, rest.find_first_of(" \t(;"));
}

}  // namespace

std::optional<Place> place_in(runtime::Resource& resource, std::string_view instance, std::string_view name) {
  if (!is_name(name)) return {};
  const runtime::Access access(resource);
  if (auto found = access.find(std::string(instance) + "." + std::string(name))) return *found;
  if (auto found = access.find(name)) return *found;
  return {};
}

Writers::Writers(runtime::Resource& resource, const bytecode::Drawings& drawings) : resource_(resource) {
  const bytecode::Image& image = resource.image();
  std::vector<std::vector<std::uint32_t>> reached;
  for (std::uint32_t task = 0; task < resource.task_count(); ++task)
    reached.push_back(reached_by(resource.program(task)));
  for (const DrawnBody& body : drawings.bodies) {
    for (std::uint32_t pou = 0; pou < image.pous.size(); ++pou) {
      if (!core::iequals(image.pous[pou].name, body.name) || image.pous[pou].kind == bytecode::PouKind::kFunction)
        continue;
      for (std::uint32_t task = 0; task < resource.task_count(); ++task) {
        auto found = instances_of(resource.program(task), pou, kMostInstances, &reached[task]);
        if (found.empty()) continue;
        instances_.push_back(std::move(found));
        add_body(body, pou, task, instances_.size() - 1);
      }
    }
  }
}

void Writers::add_body(const DrawnBody& body, std::uint32_t pou, std::uint32_t task, std::size_t instances) {
  Writer writer;
  writer.body = &body;
  writer.pou = pou;
  const auto put = [&](Writer::Kind kind, std::uint32_t element, std::size_t pin, std::string_view name) {
    writer.kind = kind;
    writer.element = element;
    writer.pin = static_cast<std::uint32_t>(pin);
    writer.name = std::string(name);
    add(writer, task, instances);
  };
  for (std::uint32_t i = 0; i < body.elements.size(); ++i) {
    const DrawnElement& e = body.elements[i];
    if (e.kind == ElementKind::kCoil) put(Writer::Kind::kCoil, i, 0, e.text);
    const bool variable = e.kind == ElementKind::kOutVariable || e.kind == ElementKind::kInOutVariable;
    if (variable) put(Writer::Kind::kVariable, i, 0, e.text);
    if (e.kind == ElementKind::kBlock && !e.instance.empty()) put(Writer::Kind::kInstance, i, 0, e.instance);
    for (std::size_t pin = 0; pin < e.pins.size(); ++pin) {
      if (e.pins[pin].output && !e.pins[pin].text.empty()) put(Writer::Kind::kVariable, i, pin, e.pins[pin].text);
    }
    for (std::size_t action = 0; action < e.actions.size(); ++action)
      put(Writer::Kind::kAction, i, action, e.actions[action].text);
  }
  if (body.statements.empty()) return;
  const bytecode::DrawnLines lines(body);
  for (const bytecode::DrawnStatement& statement : body.statements) {
    writer.line = statement.line;
    writer.column = statement.column;
    const std::string_view name =
        written_by(lines.from(statement.line, statement.column), body.language == bytecode::DrawnLanguage::kIl);
    if (!name.empty()) put(Writer::Kind::kStatement, 0, 0, name);
  }
}

void Writers::add(Writer writer, std::uint32_t task, std::size_t instances) {
  if (rows_.size() >= kMostRows) return;
  const PouInstance& first = instances_[instances].front();
  const auto place = place_in(resource_, first.path, writer.name);
  if (!place || (place->task != Place::kGlobal && place->task != task)) return;
  const bytecode::Image& image = resource_.image();
  Row row;
  row.place = *place;
  row.bytes = image.types[place->type].size;
  writer.task = task;
  const std::uint32_t begin = first.view.instance;
  const std::uint32_t size = image.types[image.pous[writer.pou].instance_type].size;
  // A task's copy of the globals lies where they lie in the global table: an offset is of either, never of both.
  row.in_instance = place->offset >= begin && place->offset - begin < size;
  if (row.in_instance) row.place.offset -= begin;
  row.writer = std::move(writer);
  row.instances = instances;
  rows_.push_back(std::move(row));
}

std::vector<Writer> Writers::of(const Place& place) const {
  std::vector<Writer> exact, whole;
  for (const Row& row : rows_) {
    const bool here =
        row.in_instance ? place.task == row.writer.task || place.task == Place::kGlobal : place.task == row.place.task;
    if (!here) continue;
    const bool part = row.writer.kind == Writer::Kind::kInstance;
    const auto covers = [&](std::uint32_t offset) {
      return part ? place.offset >= offset && place.offset - offset < row.bytes : place.offset == offset;
    };
    for (const PouInstance& instance : instances_[row.instances]) {
      if (!covers(row.place.offset + (row.in_instance ? instance.view.instance : 0))) continue;
      Writer writer = row.writer;
      writer.instance = instance;
      (part ? whole : exact).push_back(std::move(writer));
      // Of a variable that is no part of the instance each instance writes.
      if (row.in_instance) break;
    }
  }
  return exact.empty() ? whole : exact;
}

}  // namespace plc::shadow
