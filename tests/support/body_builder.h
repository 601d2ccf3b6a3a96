// Builds drawn bodies for unit tests without XML: elements with ids, positions and wires.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "plcopen/project.h"

namespace plc::test {

class BodyBuilder {
 public:
  explicit BodyBuilder(plcopen::Language language) { body_.language = language; }

  /// Adds an element without pins at (x, y); `text` is its variable, expression, name or block type.
  plcopen::Element& add(core::ElementKind kind, std::int64_t id, std::string text, std::int32_t x, std::int32_t y) {
    plcopen::Element e;
    e.kind = kind;
    e.text = std::move(text);
    e.x = x;
    e.y = y;
    e.has_position = true;
    e.at = {static_cast<std::uint32_t>(body_.elements.size() + 1), 1, id, 0, kind};
    e.text_at = e.at;
    body_.elements.push_back(std::move(e));
    return body_.elements.back();
  }
  /// A plain input (contact, coil, outVariable, ..) fed by the elements `from`.
  static void feed(plcopen::Element& e, std::vector<std::int64_t> from) { pin(e, "", std::move(from)); }
  /// A named block input fed by the elements `from`; `output` names the pin at the far end.
  static plcopen::Pin& pin(plcopen::Element& e, std::string name, std::vector<std::int64_t> from,
                           std::string output = {}) {
    plcopen::Pin p;
    p.name = std::move(name);
    p.has_point_in = true;
    p.at = e.at;
    for (std::int64_t id : from) p.connections.push_back({id, output, e.at, false, {}});
    e.inputs.push_back(std::move(p));
    return e.inputs.back();
  }
  static plcopen::Pin& out(plcopen::Element& e, std::string name) {
    plcopen::Pin p;
    p.name = std::move(name);
    p.has_point_out = true;
    p.at = e.at;
    e.outputs.push_back(std::move(p));
    return e.outputs.back();
  }

  [[nodiscard]] const plcopen::Body& body() const { return body_; }

 private:
  plcopen::Body body_;
};

}  // namespace plc::test
