// The pages of plc-run, as the build has made them from src/ with npm's esbuild.
#pragma once

#include <span>

#include "engineering/pages.h"

namespace plc::web {

/// All files; none when the program was built without npm. They live as long as the program.
std::span<const engineering::PageFile> files();

}  // namespace plc::web
