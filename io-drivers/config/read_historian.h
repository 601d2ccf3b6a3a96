// historian.toml: which variables are kept, how often and how long (docs/guides/pages.md).
//
// In: text. Out: settings, not yet looked up in a project. Does not belong here: keeping (historian/).
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "core/diagnostics.h"
#include "historian/settings.h"
#include "io-drivers/config/keys.h"

namespace plc::io {

/// The keys of [historian].
std::span<const KeyInfo> historian_keys();
/// Nothing when the file has no good table; what is wrong is reported with its place (P7301 to P7306).
std::optional<historian::Settings> read_historian(std::string_view text, std::string_view file,
                                                  core::Diagnostics& diagnostics);

}  // namespace plc::io
