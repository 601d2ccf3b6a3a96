// hmi::read_document on arbitrary bytes: it must end and report; what it takes is written and read again as the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "hmi/document.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  core::Diagnostics diagnostics;
  const auto document = hmi::read_document({reinterpret_cast<const char*>(data), size}, "pages.toml", diagnostics);
  for (const core::Diagnostic& diagnostic : diagnostics.all()) static_cast<void>(diagnostics.render_one(diagnostic));
  require(document.has_value() != diagnostics.has_errors());
  if (!document) return 0;
  for (const hmi::Page& page : document->pages) {
    for (const hmi::Element& element : page.elements) {
      require(element.x >= 0 && element.width > 0 && element.x + element.width <= page.columns);
      require(element.y >= 0 && element.height > 0 && element.y + element.height <= page.rows);
    }
  }
  for (const hmi::Offer& offer : hmi::offers_of(*document))
    require(!offer.low || !offer.high || *offer.low < *offer.high);
  const std::string text = hmi::write_document(*document);
  const auto again = hmi::read_document(text, "pages.toml", diagnostics);
  require(again.has_value() && hmi::write_document(*again) == text);
  return 0;
}
