#include "taskblocks/shared_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <thread>

namespace plc::taskblocks {
namespace {

using core::Problem;

constexpr const char* kBuildHelp =
    "build it as a shared object against the SDK of this version of PICARD, as taskblocks/template does";

Problem refused(const std::string& path, const std::string& why, std::string help) {
  return {core::Code::P7801, path + ": " + why, std::move(help)};
}

/// Whether somebody else than root and this user may change it. Access lists count: their mask shows as the bits of the
/// group.
std::string writable_by_others(const struct stat& status) {
  if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
    return fmt::format("belongs to user {}, neither root nor the one who runs this", status.st_uid);
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return fmt::format("may be written by {}", (status.st_mode & S_IWOTH) != 0 ? "everybody" : "its group");
  }
  return {};
}

/// Code is loaded from places only where nobody else can have put it. `path` has no links in it.
std::optional<Problem> check_place(const std::string& path) {
  const auto refuse = [&path](const std::string& what, const std::string& why) {
    return refused(path, what + " " + why,
                   "code that controls the plant must come from root or from the user of the service: "
                   "chown root it, and chmod go-w it");
  };
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return refused(path, std::strerror(errno), {});
  if (!S_ISREG(status.st_mode)) return refused(path, "it is no file", "give the path of a shared object");
  if (const std::string why = writable_by_others(status); !why.empty()) return refuse("it", why);
  bool own_folder = true;
  for (std::string folder = path; folder != "/"; own_folder = false) {
    const std::size_t slash = folder.rfind('/');
    folder.resize(slash == 0 ? 1 : slash);
    if (::stat(folder.c_str(), &status) != 0) return refused(path, folder + ": " + std::strerror(errno), {});
    // In a folder like /tmp everybody may add entries, and nobody may replace those of others. That is good enough
    // above, but not beside the library, where the system looks for what it needs.
    if (!own_folder && (status.st_mode & S_ISVTX) != 0) status.st_mode &= ~static_cast<mode_t>(S_IWGRP | S_IWOTH);
    if (const std::string why = writable_by_others(status); !why.empty()) return refuse("the folder " + folder, why);
  }
  return std::nullopt;
}

/// How far a trial came, and what it found; both processes see it.
struct Trial {
  enum Stage : int { kLoading, kDescribing, kRefused, kGood };
  std::atomic<int> stage{kLoading};
  char message[1024]{};
  char help[256]{};
};
static_assert(std::atomic<int>::is_always_lock_free);

std::optional<Problem> load(const std::string& path, Registry& registry, Trial* trial) {
  void* const library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    // It names the file itself, mostly.
    std::string why = ::dlerror();
    if (why.rfind(path + ": ", 0) == 0) why.erase(0, path.size() + 2);
    return refused(path, why, kBuildHelp);
  }
  const auto entry = reinterpret_cast<picard_entry>(::dlsym(library, PICARD_ENTRY));
  if (entry == nullptr) {
    return refused(path, "it has no function " PICARD_ENTRY "()",
                   "list its classes: PICARD_LIBRARY(name, version, ..)");
  }
  if (trial != nullptr) trial->stage = Trial::kDescribing;
  return registry.add(entry(), path);
}

void copy(const std::string& from, char* to, std::size_t bytes) {
  const std::size_t length = std::min(from.size(), bytes - 1);
  std::memcpy(to, from.data(), length);
  to[length] = '\0';
}

/// The child. Whatever happens here happens to nobody else.
[[noreturn]] void run_trial(const std::string& path, Registry& registry, Trial& trial) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_DUMPABLE, 0);  // a crash is what this is for: no core files
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::signal(signal, SIG_DFL);
  // What its static objects print must not get into the output of a command.
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  if (const auto problem = load(path, registry, &trial)) {
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
std::optional<Problem> try_out(const std::string& path, Registry& registry, std::chrono::milliseconds time) {
  void* const page = ::mmap(nullptr, sizeof(Trial), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return refused(path, std::strerror(errno), {});
  const auto unmap = [](Trial* trial) { ::munmap(trial, sizeof *trial); };
  const std::unique_ptr<Trial, decltype(unmap)> trial(new (page) Trial(), unmap);
  // What is buffered is printed once, even when the library calls exit().
  std::cout.flush();
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) return refused(path, std::string("no process to try it in: ") + std::strerror(errno), {});
  if (child == 0) run_trial(path, registry, *trial);
  int status = 0;
  const bool in_time = ended_in_time(child, time, status);
  const int stage = trial->stage;
  if (stage == Trial::kGood) return std::nullopt;
  if (stage == Trial::kRefused) return Problem{core::Code::P7801, trial->message, trial->help};
  const char* const when = stage == Trial::kLoading ? "while it was loaded" : "while it described its blocks";
  const char* const help = stage == Trial::kLoading
                               ? "its static objects are made then: what may fail belongs into ready()"
                               : "constructors of its blocks run then: what may fail belongs into ready()";
  if (!in_time) return refused(path, fmt::format("it came to no end within {} ms, {}", time.count(), when), help);
  if (WIFSIGNALED(status)) {
    return refused(
        path, fmt::format("it crashed {}: signal {}, {}", when, WTERMSIG(status), ::strsignal(WTERMSIG(status))), help);
  }
  return refused(path, fmt::format("it ended the process {}, with exit code {}", when, WEXITSTATUS(status)), help);
}

}  // namespace

std::optional<Problem> load_shared_library(const std::string& path, Registry& registry,
                                           std::chrono::milliseconds trial_time) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
  if (real == nullptr) {
    return refused(path, std::strerror(errno),
                   "give the path of a shared object; in plc.toml it begins where that lies");
  }
  const std::string file = real.get();
  if (auto problem = check_place(file)) return problem;
  if (auto problem = try_out(file, registry, trial_time)) return problem;
  return load(file, registry, nullptr);
}

}  // namespace plc::taskblocks
