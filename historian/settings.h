// What the historian keeps, and how long.
//
// In: nothing. Out: plain data. Does not belong here: reading files (io-drivers/config/read_historian.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/source_ref.h"

namespace plc::historian {

struct Settings {
  std::vector<std::string> tags;           ///< patterns of paths
  std::vector<core::SourceRef> tags_at;    ///< of each, where it is written; or none
  core::TimeNs interval_ns = 100'000'000;  ///< between two samples
  std::uint32_t days = 30;
  std::uint64_t most_bytes = 5'000'000'000;
  std::string folder;  ///< empty: the state folder
};

}  // namespace plc::historian
