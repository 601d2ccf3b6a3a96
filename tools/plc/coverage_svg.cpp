#include "tools/plc/coverage_svg.h"

#include <map>
#include <utility>

#include "core/text.h"
#include "pictures/picture.h"

namespace plc::tools {

std::string coverage_svg(const bytecode::DrawnBody& body, const tests::CoverageReport& coverage) {
  std::map<std::int64_t, const bytecode::DrawnElement*> elements;
  for (const bytecode::DrawnElement& e : body.elements) elements.emplace(e.local_id, &e);
  pictures::Marks marks;
  for (std::uint32_t s = 0; s < coverage.sites().size(); ++s) {
    const ir::CoverSite& site = coverage.sites()[s];
    const bool drawn = site.kind == ir::CoverKind::kContact || site.kind == ir::CoverKind::kCoil;
    const auto element = elements.find(site.at.local_id);
    if (!drawn || !core::iequals(site.pou, body.name) || element == elements.end()) continue;
    const bool first = coverage.seen(s, 0), second = coverage.seen(s, 1);
    pictures::Mark mark;
    mark.look = first && second   ? pictures::Look::kSeen
                : first || second ? pictures::Look::kHalf
                                  : pictures::Look::kUnseen;
    const ir::CoverKindInfo& kind = ir::info(site.kind);
    if (first != second) mark.text = "not " + std::string(first ? kind.second : kind.first);
    if (!first && !second) mark.text = "never";
    marks[bytecode::key_of(0, *element->second)] = std::move(mark);
  }
  const pictures::PicturedBody pictured{&body, body.name + ": green was seen in every state, amber in one, red in none",
                                        0};
  return pictures::svg("Coverage of " + body.name, {&pictured, 1}, marks);
}

}  // namespace plc::tools
