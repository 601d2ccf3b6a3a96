#include "io-drivers/driver.h"

#include <algorithm>

namespace plc::io {

std::string_view quality_word(Quality quality) {
  switch (quality) {
    case Quality::kNever:
      return "never";
    case Quality::kGood:
      return "good";
    case Quality::kLost:
      break;
  }
  return "lost";
}

InputStatus input_status(std::string_view variable, core::TimeNs read_at_ns, bool connected, core::TimeNs now_ns) {
  if (read_at_ns < 0) return {variable, Quality::kNever, 0};
  // It may have been read after `now_ns` was taken.
  return {variable, connected ? Quality::kGood : Quality::kLost, std::max<core::TimeNs>(now_ns - read_at_ns, 0)};
}

}  // namespace plc::io
