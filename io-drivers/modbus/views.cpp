#include "io-drivers/modbus/views.h"

#include <algorithm>
#include <iterator>

namespace plc::modbus {

const View* view_of(const runtime::Location& location) {
  const auto* const view = std::find_if(std::begin(kViews), std::end(kViews), [&](const View& v) {
    return v.area == location.area && v.bits == location.bits;
  });
  return view == std::end(kViews) ? nullptr : view;
}

}  // namespace plc::modbus
