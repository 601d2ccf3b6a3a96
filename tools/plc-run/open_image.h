// open_image(): the image that plc-run runs.
//
// In: an image file, or a project and its compile options. Out: a verified image. A project is compiled by `plc
// compile` in a process of its own, whose memory goes with it: a runtime stays up for years. Does not belong here:
// compiling.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/options.h"
#include "tools/cli.h"

namespace plc::tools {

struct ImageRequest {
  std::string file;
  core::CompileOptions options;
  std::vector<std::string> libraries;
  std::string configuration;  ///< plc.toml with more libraries, or empty
};

/// All messages are on stderr. The exit code when there is nothing to go on with; else `image` is set.
std::optional<int> open_image(Command command, const ImageRequest& request,
                              std::optional<bytecode::VerifiedImage>& image);

/// An image of ours, which has no options of a command line.
std::optional<int> open_stored_image(const std::string& file, std::optional<bytecode::VerifiedImage>& image);

}  // namespace plc::tools
