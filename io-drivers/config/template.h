// The texts that follow from the rows of keys: the plc.toml that `plc config init` writes (every key with its default
// and documentation, every located variable of the project with a line that would connect it, all commented out), and
// the reference page.
//
// In: rows, a resource. Out: text that read_configuration() and bind() accept, as it is and with every setting
// uncommented; Markdown. Does not belong here: files.
#pragma once

#include <string>
#include <string_view>

#include "io-drivers/config/keys.h"
#include "runtime/resource.h"

namespace plc::io {

/// `project` is the file's name, for the comments at the top. One driver for each of the kinds in `types`, in this
/// order; the first that takes a variable gets it.
std::string configuration_template(runtime::Resource& resource, std::string_view project, DriverTypes types);

/// docs/reference/configuration.md, but for its first line.
std::string configuration_reference(DriverTypes types);

/// A name as a key of TOML: as it is, or in quotes where the grammar wants them.
std::string toml_key(std::string_view name);

}  // namespace plc::io
