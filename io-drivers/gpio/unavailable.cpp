// No libgpiod in this build (-DPICARD_GPIO=OFF): configurations with GPIO lines are understood, and run with
// --simulate-io.
#include "io-drivers/gpio/gpio_lines.h"

namespace plc::io {
namespace {

core::Problem absent(const LinesRequest& request) {
  return {core::Code::P7401, "GPIO chip \"" + request.chip + "\" cannot be opened: this program was built without GPIO",
          "build it with -DPICARD_GPIO=ON, or run with --simulate-io"};
}

}  // namespace

GpioAccess kernel_gpio() {
  return {[](const LinesRequest& request) -> std::optional<core::Problem> { return absent(request); },
          [](const LinesRequest& request) -> core::Result<std::unique_ptr<GpioLines>> { return absent(request); }};
}

}  // namespace plc::io
