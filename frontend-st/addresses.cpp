#include "frontend-st/addresses.h"

#include <charconv>

#include "core/text.h"
#include "frontend-st/lexer.h"

namespace plc::st {
namespace {
constexpr std::size_t kMaxPath = 8;
}

std::string Address::text() const {
  std::string out = {'%', area};
  if (unlocated) return out + '*';
  out += size;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i != 0) out += '.';
    out += std::to_string(path[i]);
  }
  return out;
}

std::uint32_t Address::bits() const {
  switch (size) {
    case 'B':
      return 8;
    case 'W':
      return 16;
    case 'D':
      return 32;
    case 'L':
      return 64;
    default:
      return 1;
  }
}

core::TypeId Address::type() const {
  switch (size) {
    case 'B':
      return core::TypeId::kByte;
    case 'W':
      return core::TypeId::kWord;
    case 'D':
      return core::TypeId::kDword;
    case 'L':
      return core::TypeId::kLword;
    default:
      return core::TypeId::kBool;
  }
}

std::optional<Address> parse_address(std::string_view text, std::string& problem) {
  Address out;
  std::size_t i = 1;
  if (text.size() < 2 || text[0] != '%') {
    problem = "an address begins with %";
    return std::nullopt;
  }
  out.area = core::upper(text[i++]);
  if (out.area != 'I' && out.area != 'Q' && out.area != 'M') {
    problem = "the area is I, Q or M";
    return std::nullopt;
  }
  if (i < text.size() && !is_digit(text[i]) && text[i] != '*') {
    out.size = core::upper(text[i++]);
    if (std::string_view("XBWDL").find(out.size) == std::string_view::npos) {
      problem = "the size letter is X, B, W, D or L";
      return std::nullopt;
    }
  }
  if (text.substr(i) == "*") {
    out.unlocated = true;
    return out;
  }
  while (true) {
    std::uint32_t number = 0;
    const auto [stop, error] = std::from_chars(text.data() + i, text.data() + text.size(), number);
    if (error != std::errc{}) {
      problem = error == std::errc::result_out_of_range ? "a number is too large" : "a number is missing";
      return std::nullopt;
    }
    out.path.push_back(number);
    i = static_cast<std::size_t>(stop - text.data());
    if (i == text.size()) break;
    if (text[i] != '.' || out.path.size() == kMaxPath) {
      problem = "numbers are separated by dots";
      return std::nullopt;
    }
    ++i;
  }
  if (out.size == 'X' && out.path.size() == 2 && out.path[1] > 7) {
    problem = "bit " + std::to_string(out.path[1]) + " of a byte, bits are 0 to 7";
    return std::nullopt;
  }
  return out;
}

}  // namespace plc::st
