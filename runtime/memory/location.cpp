#include "runtime/memory/location.h"

#include <charconv>

namespace plc::runtime {

std::optional<Location> parse_location(std::string_view address) {
  constexpr std::string_view kSizes = "XBWDL";
  constexpr std::uint32_t kBits[] = {1, 8, 16, 32, 64};
  if (address.size() < 4 || address[0] != '%') return std::nullopt;
  Location location;
  location.area = address[1];
  const std::size_t size = kSizes.find(address[2]);
  if (std::string_view("IQM").find(location.area) == std::string_view::npos || size == std::string_view::npos) {
    return std::nullopt;
  }
  location.bits = kBits[size];
  const char* const end = address.data() + address.size();
  std::uint32_t first = 0;
  auto [at, error] = std::from_chars(address.data() + 3, end, first);
  if (error != std::errc{}) return std::nullopt;
  location.first_bit = std::uint64_t{first} * location.bits;
  if (at == end) return location;
  std::uint32_t bit = 0;
  if (*at != '.' || location.bits != 1) return std::nullopt;
  const auto second = std::from_chars(at + 1, end, bit);
  if (second.ec != std::errc{} || second.ptr != end || bit > 7) return std::nullopt;
  location.dotted = true;
  location.first_bit = std::uint64_t{first} * 8 + bit;
  return location;
}

std::string location_text(const Location& location, std::uint32_t index) {
  std::string text = {'%', location.area};
  const std::uint64_t number = location.first_bit / location.bits + index;
  switch (location.bits) {
    case 8:
      return text + 'B' + std::to_string(number);
    case 16:
      return text + 'W' + std::to_string(number);
    case 32:
      return text + 'D' + std::to_string(number);
    case 64:
      return text + 'L' + std::to_string(number);
    default:
      text += 'X';
      if (!location.dotted) return text + std::to_string(number);
      return text + std::to_string(number / 8) + '.' + std::to_string(number % 8);
  }
}

}  // namespace plc::runtime
