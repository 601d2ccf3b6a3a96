#include "core/duration.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string>

#include "core/text.h"

namespace plc::core {
namespace {

struct Unit {
  std::string_view name;
  double ns;
};
constexpr Unit kUnits[] = {{"ns", 1},   {"us", 1e3}, {"ms", 1e6},   {"min", 60e9},
                           {"m", 60e9}, {"s", 1e9},  {"h", 3600e9}, {"d", 86400e9}};

}  // namespace

std::optional<TimeNs> parse_duration_ns(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 2 && iequals(text.substr(0, 2), "T#")) text.remove_prefix(2);
  if (text.empty()) return std::nullopt;
  double total_ns = 0;
  while (!text.empty()) {
    std::size_t digits = 0;
    while (digits < text.size() && (std::isdigit(static_cast<unsigned char>(text[digits])) || text[digits] == '.')) {
      ++digits;
    }
    if (digits == 0) return std::nullopt;
    char* end = nullptr;
    const std::string number(text.substr(0, digits));
    const double value = std::strtod(number.c_str(), &end);
    if (end != number.c_str() + number.size()) return std::nullopt;
    text.remove_prefix(digits);
    double factor = text.empty() ? 1e9 : 0;
    for (const Unit& unit : kUnits) {
      if (factor == 0 && text.size() >= unit.name.size() && iequals(text.substr(0, unit.name.size()), unit.name)) {
        factor = unit.ns;
        text.remove_prefix(unit.name.size());
      }
    }
    if (factor == 0) return std::nullopt;
    total_ns += value * factor;
  }
  if (total_ns > 9e18) return std::nullopt;
  return static_cast<std::int64_t>(std::llround(total_ns));
}

}  // namespace plc::core
