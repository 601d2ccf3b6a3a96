// Location: a direct address as bits of its area.
//
// In: addresses as images have them: "%QX0.3", "%MW7". Out: where the bits lie, and the address of a place after it.
// Does not belong here: variables (process_image.h), addresses as written in sources (frontend-st/addresses.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plc::runtime {

/// One location, or the first of an array.
struct Location {
  char area = 'I';              ///< 'I', 'Q' or 'M'
  std::uint32_t bits = 1;       ///< of one element: 1, 8, 16, 32 or 64
  std::uint64_t first_bit = 0;  ///< from the start of the area, a multiple of `bits`
  bool dotted = false;          ///< bits: written with a byte, "%QX1.3", not "%QX11"
};

/// Nothing for unlocated ("%I*") and hierarchical addresses ("%IW0.0.1"): they have no number in the area.
std::optional<Location> parse_location(std::string_view address);
/// Address of the element `index` places further: "%QX1.7" + 1 is "%QX2.0".
std::string location_text(const Location& location, std::uint32_t index);

}  // namespace plc::runtime
