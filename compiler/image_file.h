// Image files: which they are, how they are loaded, and their compile options in words.
//
// In: a path. Out: a verified image, or what is wrong with the file. Does not belong here: compiling (compile.h).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "bytecode/image.h"
#include "core/diagnostics.h"
#include "core/options.h"

namespace plc::compiler {

/// Larger images are neither written nor read.
inline constexpr std::size_t kMaxImageBytes = std::size_t{512} << 20;

/// True when the path names a compiled image (by its ".pbc").
bool is_image_path(const std::string& path);
/// Whether a path ends in an extension, in any letter case.
bool has_extension(std::string_view path, std::string_view extension);

/// True when the file can be opened for reading; reports P7001 otherwise. A pipe or a device is not opened: that may
/// block, or never come to an end.
bool can_open(const std::string& path, core::Diagnostics& diagnostics);

/// The image in `bytes`, which `path` stands for in messages. Nothing after an error.
std::optional<bytecode::VerifiedImage> load_image(std::span<const std::byte> bytes, const std::string& path,
                                                  core::Diagnostics& diagnostics);
/// The same of a file that can be opened.
std::optional<bytecode::VerifiedImage> load_image(const std::string& path, core::Diagnostics& diagnostics);

/// "order=drawing compat=none profile=separate coherence=wait-free stub-missing=no"
std::string describe(const core::CompileOptions& options);

}  // namespace plc::compiler
