// plcopen::read on arbitrary bytes: it must end, report, and account for every element of what it accepts. Whatever it
// accepts can be drawn, packed for an image, and becomes a picture.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "bytecode/drawings.h"
#include "drawings/make.h"
#include "pictures/picture.h"
#include "plcopen/reader.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  plcopen::ReadLimits limits;
  limits.max_bytes = 1 << 20;
  limits.max_depth = 40;
  limits.max_elements = 5'000;
  limits.max_attributes = 50;
  limits.max_name = 64;
  limits.max_text = 4'096;
  core::Diagnostics diagnostics;
  const auto project =
      plcopen::read_memory({reinterpret_cast<const char*>(data), size}, "input.xml", diagnostics, limits);
  for (const core::Diagnostic& diagnostic : diagnostics.all()) static_cast<void>(diagnostics.render_one(diagnostic));
  require(project != nullptr || diagnostics.has_errors());
  if (project == nullptr) return 0;
  std::size_t elements = 0;
  for (const plcopen::ReportRow& row : project->report) {
    require(row.count > 0 && row.first_line > 0);
    require(row.fate == plcopen::Fate::kUsed || !row.reason.empty());
    elements += row.count;
  }
  require(elements >= 1 && elements <= limits.max_elements);
  for (const plcopen::Pou& pou : project->pous) {
    require(pou.name.size() <= limits.max_name);
    for (const plcopen::Body& body : pou.bodies) {
      require(body.language == plcopen::Language::kSfc || body.drawn_elements >= body.elements.size());
      require(body.text.size() <= limits.max_text);
      for (const plcopen::Element& element : body.elements) require(element.at.line > 0 && element.at.column > 0);
    }
  }
  const bytecode::Drawings drawn = drawings::make(*project, diagnostics);
  const auto again = bytecode::unpack(bytecode::pack(drawn));
  require(again && *again == drawn);
  std::vector<pictures::PicturedBody> bodies;
  for (const bytecode::DrawnBody& body : drawn.bodies) bodies.push_back({&body, body.name, 0});
  require(pictures::svg("fuzz", bodies).ends_with("</svg>\n"));
  return 0;
}
