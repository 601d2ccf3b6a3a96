#include "taskblocks/shared_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <thread>
#include <vector>

#include "taskblocks/library_files.h"

namespace plc::taskblocks {
namespace {

using core::Problem;

constexpr const char* kBuildHelp =
    "build it as a shared object against the SDK of this version of PICARD, as taskblocks/template does";

/// How far a trial came, and what it found; both processes see it.
struct Trial {
  enum Stage : int { kLoading, kDescribing, kRefused, kGood };
  std::atomic<int> stage{kLoading};
  char message[1024]{};
  char help[256]{};
};
static_assert(std::atomic<int>::is_always_lock_free);

/// `files`: the library at the end.
std::optional<Problem> load(const std::vector<std::string>& files, const LibraryUse& use, Trial* trial) {
  const std::string& path = files.back();
  std::string why;
  void* const library = open_library(files, why);
  if (library == nullptr) return library_refused(path, why, kBuildHelp);
  void* const entry = ::dlsym(library, use.entry);
  if (entry == nullptr) {
    return library_refused(path, fmt::format("it has no function {}()", use.entry), use.missing_help);
  }
  if (trial != nullptr) trial->stage = Trial::kDescribing;
  return use.take(entry, path);
}

void copy(const std::string& from, char* to, std::size_t bytes) {
  const std::size_t length = std::min(from.size(), bytes - 1);
  std::memcpy(to, from.data(), length);
  to[length] = '\0';
}

/// The child. Whatever happens here happens to nobody else.
[[noreturn]] void run_trial(const std::vector<std::string>& files, const LibraryUse& use, Trial& trial) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_DUMPABLE, 0);  // a crash is what this is for: no core files
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) static_cast<void>(::signal(signal, SIG_DFL));
  // What its static objects print must not get into the output of a command.
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  if (const auto problem = load(files, use, &trial)) {
    copy(problem->message, trial.message, sizeof trial.message);
    copy(problem->help, trial.help, sizeof trial.help);
    trial.stage = Trial::kRefused;
  } else {
    trial.stage = Trial::kGood;
  }
  ::_exit(0);
}

/// Waits for the child; false when it had to be killed.
bool ended_in_time(pid_t child, std::chrono::milliseconds time, int& status) {
  const auto deadline = std::chrono::steady_clock::now() + time;
  for (;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return true;
    if (std::chrono::steady_clock::now() >= deadline || (ended < 0 && errno != EINTR)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ::kill(child, SIGKILL);
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return false;
}

/// Loads the library in a process of its own: static objects and constructors of a faulty one throw, crash, or never
/// come to an end.
std::optional<Problem> try_out(const std::vector<std::string>& files, const LibraryUse& use,
                               std::chrono::milliseconds time) {
  const std::string& path = files.back();
  void* const page = ::mmap(nullptr, sizeof(Trial), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return library_refused(path, std::strerror(errno), {});
  const auto unmap = [](Trial* trial) { ::munmap(trial, sizeof *trial); };
  const std::unique_ptr<Trial, decltype(unmap)> trial(new (page) Trial(), unmap);
  // What is buffered is printed once, even when the library calls exit().
  std::cout.flush();
  static_cast<void>(std::fflush(nullptr));
  const pid_t child = ::fork();
  if (child < 0) return library_refused(path, std::string("no process to try it in: ") + std::strerror(errno), {});
  if (child == 0) run_trial(files, use, *trial);
  int status = 0;
  const bool in_time = ended_in_time(child, time, status);
  const int stage = trial->stage;
  if (stage == Trial::kGood) return std::nullopt;
  if (stage == Trial::kRefused) return Problem{core::Code::P7801, trial->message, trial->help};
  const char* const when = stage == Trial::kLoading ? "while it was loaded" : "while it described its blocks";
  const char* const help = stage == Trial::kLoading
                               ? "its static objects are made then: what may fail belongs into ready()"
                               : "constructors of its blocks run then: what may fail belongs into ready()";
  if (!in_time)
    return library_refused(path, fmt::format("it came to no end within {} ms, {}", time.count(), when), help);
  if (WIFSIGNALED(status)) {
    return library_refused(
        path, fmt::format("it crashed {}: signal {}, {}", when, WTERMSIG(status), ::strsignal(WTERMSIG(status))), help);
  }
  return library_refused(path, fmt::format("it ended the process {}, with exit code {}", when, WEXITSTATUS(status)),
                         help);
}

}  // namespace

std::optional<Problem> load_library(const std::string& path, const LibraryUse& use,
                                    std::chrono::milliseconds trial_time) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
  if (real == nullptr) {
    return library_refused(path, std::strerror(errno),
                           "give the path of a shared object; in plc.toml it begins where that lies");
  }
  const auto files = check_library_files(real.get());
  if (!files) return files.error();
  if (auto problem = try_out(*files, use, trial_time)) return problem;
  return load(*files, use, nullptr);
}

std::optional<Problem> load_shared_library(const std::string& path, Registry& registry,
                                           std::chrono::milliseconds trial_time) {
  const LibraryUse use{PICARD_ENTRY,
                       [&registry](void* entry, const std::string& file) {
                         return registry.add(reinterpret_cast<picard_entry>(entry)(), file);
                       },
                       "list its classes: PICARD_LIBRARY(name, version, ..)"};
  return load_library(path, use, trial_time);
}

}  // namespace plc::taskblocks
