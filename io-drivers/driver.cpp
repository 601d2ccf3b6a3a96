#include "io-drivers/driver.h"

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

}  // namespace plc::io
