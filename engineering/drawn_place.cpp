#include "engineering/drawn_place.h"

#include <nlohmann/json.hpp>

#include "core/source_ref.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kFields[] = {
    text("pou", "Whose drawing"),
    integer("body", "Worksheet, from 0"),
    optional(integer("element", "Of a drawing: its number, data-e")),
    text("kind", "\"contact\", \"coil\", \"block\" and so on; of a text \"line\""),
    text("text", "What stands there, cut to 200 bytes"),
    integer("network", "Rung or network, from 1; 0: none"),
    integer("line", "In the file; 0: none"),
};

constexpr std::size_t kMostText = 200;

}  // namespace

const Record kDrawnPlace = {"DrawnPlace", "A place in a drawing or text.", kFields};

Json place_json(const DrawnPou& pou, std::size_t body, std::uint32_t element, std::uint32_t line,
                const std::string& text) {
  Json json = {{"pou", pou.name}, {"body", body}};
  std::string shown = text;
  if (shown.size() > kMostText) {
    std::size_t end = kMostText;
    while (end > 0 && (static_cast<unsigned char>(shown[end]) & 0xc0u) == 0x80u) --end;
    shown.resize(end);
    shown += "…";
  }
  const bytecode::DrawnBody& drawn = *pou.bodies[body];
  if (element == kNoElement || element >= drawn.elements.size()) {
    json.update({{"kind", "line"}, {"text", std::move(shown)}, {"network", 0}, {"line", line}});
    return json;
  }
  const bytecode::DrawnElement& e = drawn.elements[element];
  json.update({{"element", element},
               {"kind", core::element_word(e.kind)},
               {"text", std::move(shown)},
               {"network", e.network},
               {"line", e.line}});
  return json;
}

}  // namespace plc::engineering
