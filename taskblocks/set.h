// The libraries of taskblocks that come with PICARD, one a folder.
#pragma once

#include "picard/taskblock.h"

namespace plc::blocks {

const picard_library* control_library();
const picard_library* filters_library();

}  // namespace plc::blocks
