// The libraries of taskblocks that come with PICARD, one a folder.
#pragma once

#include <array>

#include "picard/taskblock.h"

namespace plc::blocks {

const picard_library* control_library();
const picard_library* filters_library();
const picard_library* signals_library();
const picard_library* motion_library();

inline std::array<const picard_library*, 4> linked_libraries() {
  return {filters_library(), signals_library(), control_library(), motion_library()};
}

}  // namespace plc::blocks
