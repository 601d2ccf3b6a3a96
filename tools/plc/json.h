// Diagnostics as one JSON document, for editors and scripts: check --json and config check --json.
//
// In: files that were checked. Out: text. Does not belong here: when to print it.
#pragma once

#include <string>
#include <vector>

#include "core/diagnostics.h"

namespace plc::tools {

struct CheckedFile {
  std::string file;
  bool ok = false;
  core::Diagnostics diagnostics;
};

/// {"files": [..], "diagnostics": [..]}, with a line end.
std::string diagnostics_json(const std::vector<CheckedFile>& files);

}  // namespace plc::tools
