#include "tools/plc-run/open_image.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <span>
#include <system_error>

#include "core/diagnostics.h"
#include "tools/command_line.h"

namespace plc::tools {
namespace {

/// A file in memory.
class MemoryFile {
 public:
  MemoryFile() : file_(::memfd_create("picard-image", MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (at_ != MAP_FAILED) ::munmap(at_, size_);
    if (file_ >= 0) ::close(file_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return file_; }
  std::span<const std::byte> bytes() {
    struct stat status {};
    if (::fstat(file_, &status) != 0 || status.st_size == 0) return {};
    size_ = static_cast<std::size_t>(status.st_size);
    at_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file_, 0);
    if (at_ == MAP_FAILED) return {};
    return {static_cast<const std::byte*>(at_), size_};
  }

 private:
  int file_;
  void* at_ = MAP_FAILED;
  std::size_t size_ = 0;
};

/// The compiler that was installed beside this program.
std::string compiler_path() {
  std::error_code ignored;
  return (std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / "plc").string();
}

/// Runs `plc compile` with the image on `output` and what it says on `said`. Its exit code; nothing when it could not
/// run to its end.
std::optional<int> run_compiler(const ImageRequest& request, int output, int said) {
  std::vector<std::string> words = {compiler_path(), "compile", "--drawings", "-o", "-"};
  const std::vector<std::string> flags = compile_arguments(request.options, request.libraries);
  words.insert(words.end(), flags.begin(), flags.end());
  if (request.options.show_all) words.emplace_back("--all");
  if (!request.configuration.empty()) words.insert(words.end(), {"--config", request.configuration});
  words.insert(words.end(), {"--", request.file});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  if (said >= 0) posix_spawn_file_actions_adddup2(&actions, said, STDERR_FILENO);
  pid_t child = 0;
  const int refused = ::posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) {
    complain("plc-run", fmt::format("{} cannot be run: {}", words[0], std::strerror(refused)),
             refused == EAGAIN || refused == ENOMEM
                 ? "a project is compiled in a process of its own: allow one more (TasksMax, ulimit -u), or give an "
                   "image made by plc compile"
                 : "plc and plc-run are installed side by side; or give an image made by plc compile");
    return std::nullopt;
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  complain("plc-run", fmt::format("the compiler was ended by signal {}", WTERMSIG(status)));
  return std::nullopt;
}

}  // namespace

std::optional<int> open_stored_image(const std::string& file, std::optional<bytecode::VerifiedImage>& image) {
  core::Diagnostics diagnostics;
  if (!can_open(file, diagnostics)) return diagnostics.render_with_lines(std::cerr), kExitUsage;
  image = load_image(file, diagnostics);
  diagnostics.render_with_lines(std::cerr);
  return image ? std::nullopt : std::optional(kExitErrors);
}

std::optional<int> open_image(Command command, const ImageRequest& request,
                              std::optional<bytecode::VerifiedImage>& image) {
  if (const auto code = refuse_options_of_image(command, request.file)) return code;
  core::Diagnostics diagnostics;
  if (is_image_path(request.file)) {
    return open_stored_image(request.file, image);
  } else {
    MemoryFile made;
    if (made.descriptor() < 0) {
      complain("plc-run", fmt::format("no memory for the image: {}", std::strerror(errno)));
      return kExitErrors;
    }
    // By way of this process, so that it becomes part of the log.
    MemoryFile said;
    const auto code = run_compiler(request, made.descriptor(), said.descriptor());
    const std::span<const std::byte> text = said.bytes();
    std::cerr.write(reinterpret_cast<const char*>(text.data()), static_cast<std::streamsize>(text.size()));
    if (!code) return kExitErrors;
    if (*code != kExitOk) return code;
    image = load_image(made.bytes(), request.file, diagnostics);
  }
  diagnostics.render_with_lines(std::cerr);
  return image ? std::nullopt : std::optional(kExitErrors);
}

}  // namespace plc::tools
