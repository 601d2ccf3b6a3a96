// A build without npm: no pages.
#include "web/files.h"

namespace plc::web {
std::span<const engineering::PageFile> files() { return {}; }
}  // namespace plc::web
