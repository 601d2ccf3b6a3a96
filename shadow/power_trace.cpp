#include "shadow/power_trace.h"

#include <algorithm>

#include "core/text.h"

namespace plc::shadow {

using bytecode::DrawnElement;
using bytecode::DrawnKey;
using core::ElementKind;

const Shown* Flow::at(DrawnKey key) const {
  key.pou = 0;
  const auto found = std::lower_bound(map->points.begin(), map->points.end(), key,
                                      [](const bytecode::ProbePoint& p, const DrawnKey& k) { return p.key < k; });
  if (found == map->points.end() || found->key != key) return nullptr;
  return &shown[static_cast<std::size_t>(found - map->points.begin())];
}

std::optional<bool> Flow::power(const DrawnKey& key) const {
  const Shown* const found = at(key);
  if (found == nullptr || !found->ran || !found->is_bool || !found->known) return {};
  return found->on;
}

PowerTrace::PowerTrace(const bytecode::DrawnBody& body, const Flow& now, const Flow* before)
    : body_(body), now_(now), before_(before) {
  for (const bytecode::DrawnWire& wire : body.wires)
    sources_.emplace(Pin{wire.to, wire.to_pin}, Pin{wire.from, wire.from_pin});
}

DrawnKey PowerTrace::key(Pin pin) const {
  const DrawnElement& element = body_.elements[pin.first];
  return bytecode::key_of(0, element, element.pins[pin.second]);
}

bool PowerTrace::changed(Pin pin) const {
  if (before_ == nullptr) return false;
  const auto is = now(pin), was = before_->power(key(pin));
  return is && was && *is != *was;
}

std::optional<PowerTrace::Pin> PowerTrace::first_input(std::uint32_t element) const {
  const auto& pins = body_.elements[element].pins;
  for (std::uint32_t i = 0; i < pins.size(); ++i) {
    if (!pins[i].output) return Pin{element, i};
  }
  return {};
}

std::optional<PowerTrace::Pin> PowerTrace::source_of(Pin input) const {
  const auto [begin, end] = sources_.equal_range(input);
  if (begin == end) return {};
  for (auto it = begin; it != end; ++it) {
    if (changed(it->second)) return it->second;
  }
  const bool on = now(input).value_or(false);
  for (auto it = begin; it != end; ++it) {
    if (now(it->second) == on) return it->second;
  }
  return begin->second;
}

std::optional<PowerTrace::Pin> PowerTrace::through(Pin output) const {
  const DrawnElement& e = body_.elements[output.first];
  switch (e.kind) {
    case ElementKind::kContact: {
      const auto input = first_input(output.first);
      if (!input || changed(*input)) return input;
      // The one element between power and none is what is looked for; where none comes in, it is further up.
      const auto in = now(*input), out = now(output);
      return in == false && out != true ? input : std::nullopt;
    }
    case ElementKind::kCoil:
      return first_input(output.first);
    case ElementKind::kContinuation:
      for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
        const DrawnElement& other = body_.elements[i];
        if (other.kind == ElementKind::kConnector && core::iequals(other.text, e.text)) return first_input(i);
      }
      return {};
    case ElementKind::kBlock:
      for (std::uint32_t i = 0; i < e.pins.size(); ++i) {
        if (!e.pins[i].output && changed({output.first, i})) return Pin{output.first, i};
      }
      return {};
    default:
      return {};
  }
}

PowerTrace::End PowerTrace::from(std::uint32_t element, std::uint32_t pin) {
  Pin input{element, pin};
  std::set<Pin> seen;
  while (seen.insert(input).second) {
    const bytecode::DrawnPin& drawn = body_.elements[input.first].pins[input.second];
    if (!drawn.text.empty()) return {input.first, drawn.text, {}, now(input)};
    const auto source = source_of(input);
    if (!source) return {input.first, {}, {}, now(input)};
    if (const auto next = through(*source)) {
      input = *next;
      continue;
    }
    const DrawnElement& e = body_.elements[source->first];
    const bool named =
        e.kind == ElementKind::kContact || e.kind == ElementKind::kInVariable || e.kind == ElementKind::kInOutVariable;
    auto value = now_.power(bytecode::key_of(0, e));
    // A contact shows whether it conducts.
    if (e.kind == ElementKind::kContact && value) {
      if (e.modifiers.edge != bytecode::DrawnEdge::kNone)
        value.reset();
      else
        value = *value != e.modifiers.negated;
    } else if (!value) {
      value = now(*source);
    }
    const std::string& output = e.pins[source->second].name;
    return {source->first, named ? e.text : std::string(),
            e.instance.empty() || output.empty() ? std::string() : e.instance + "." + output, value};
  }
  return {input.first, {}, {}, now(input)};
}

}  // namespace plc::shadow
