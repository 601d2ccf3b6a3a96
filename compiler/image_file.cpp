#include "compiler/image_file.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/text.h"

namespace plc::compiler {

using core::Code;

bool has_extension(std::string_view path, std::string_view extension) {
  return path.size() >= extension.size() && core::iequals(path.substr(path.size() - extension.size()), extension);
}

bool is_image_path(const std::string& path) { return has_extension(path, ".pbc"); }

bool can_open(const std::string& path, core::Diagnostics& diagnostics) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && std::ifstream(path)) return true;
  core::SourceRef at;
  at.file = diagnostics.add_file(path);
  diagnostics.report(Code::P7001, at, {}, "file cannot be opened for reading",
                     "give the path of a PLCopen XML file, an ST file or an image made by plc compile");
  return false;
}

std::optional<bytecode::VerifiedImage> load_image(std::span<const std::byte> bytes, const std::string& path,
                                                  core::Diagnostics& diagnostics) {
  core::SourceRef at;
  at.file = diagnostics.add_file(path);
  core::Result<bytecode::Image> image = bytecode::load(bytes);
  if (!image) {
    diagnostics.report(image.error().code, at, {}, image.error().message, image.error().help);
    return std::nullopt;
  }
  // WHY: loading looks at the drawings unpacked, which are many times as large as all else; a runtime gives that back.
  if (!image->drawings.empty()) ::malloc_trim(0);
  return bytecode::verify(std::move(*image), diagnostics);
}

std::optional<bytecode::VerifiedImage> load_image(const std::string& path, core::Diagnostics& diagnostics) {
  std::error_code ignored;
  const std::uintmax_t size = std::filesystem::file_size(path, ignored);
  if (size > kMaxImageBytes) {
    core::SourceRef at;
    at.file = diagnostics.add_file(path);
    diagnostics.report(Code::P6001, at, {},
                       fmt::format("file has {} bytes, an image at most {}", size, kMaxImageBytes));
    return std::nullopt;
  }
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  return load_image(std::as_bytes(std::span(bytes)), path, diagnostics);
}

std::string describe(const core::CompileOptions& options) {
  std::vector<std::string> texts;
  core::for_each_choice(
      [&](const auto& choice) { texts.push_back(fmt::format("{}={}", choice.name, word_of(choice, options))); });
  for (const core::Switch& flag : core::kSwitches) {
    if (flag.stored) texts.push_back(fmt::format("{}={}", flag.name, options.*flag.value ? "yes" : "no"));
  }
  for (const core::Texts& row : core::kTexts) {
    for (const std::string& text : options.*row.value) texts.push_back(fmt::format("{}={}", row.name, text));
  }
  if (!options.pou.empty()) texts.push_back("pou=" + options.pou);
  return fmt::format("{}", fmt::join(texts, " "));
}

}  // namespace plc::compiler
