#include "tools/plc-run/relaunch.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#include "tools/cli.h"
#include "tools/plc-run/signals.h"

namespace plc::tools {
namespace {

constexpr const char* kVariable = "PICARD_RELAUNCH";
constexpr const char* kSelf = "/proc/self/exe";
constexpr const char* kOomScore = "/proc/self/oom_score_adj";

/// At the beginning of the file: where the text is that counts.
struct Newest {
  std::uint64_t offset = sizeof(Newest);
  std::uint64_t size = 0;
};

Newest newest_in(int file) {
  Newest newest;
  return ::pread(file, &newest, sizeof newest, 0) == sizeof newest ? newest : Newest{};
}

/// Without the place in the file, which the guardian and the runtime share.
std::string read_newest(int file) {
  const Newest newest = newest_in(file);
  std::string text(newest.size, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t got = ::pread(file, text.data() + done, text.size() - done, static_cast<off_t>(newest.offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return {};
    done += static_cast<std::size_t>(got);
  }
  return text;
}

}  // namespace

Relaunch& Relaunch::instance() {
  static Relaunch relaunch;
  return relaunch;
}

void Relaunch::begin(int argc, char** argv) {
  arguments_.assign(argv, argv + argc);
  first_process_ = ::getpid();
  std::getline(std::ifstream(kOomScore), oom_score_);
  sched_param now{};
  policy_ = ::sched_getscheduler(0);
  if (::sched_getparam(0, &now) == 0) priority_ = now.sched_priority;
  if (const char* const number = std::getenv(kVariable)) {
    int file = -1;
    const std::string_view digits = number;
    std::from_chars(digits.data(), digits.data() + digits.size(), file);
    if (file > STDERR_FILENO && ::fcntl(file, F_SETFD, FD_CLOEXEC) == 0) {
      handed_over_ = read_newest(file);
      ::close(file);
    }
    ::unsetenv(kVariable);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
  }
  text_ = ::memfd_create("picard-relaunch", MFD_CLOEXEC);
  void* const shared =
      ::mmap(nullptr, sizeof *trial_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (shared != MAP_FAILED) trial_ = new (shared) std::atomic<bool>(false);
}

void Relaunch::hand_over(std::string_view text) const {
  if (text_ < 0) return;
  const Newest before = newest_in(text_);
  Newest next;
  // Not where the one is that counts until then: a process that dies in between leaves that one.
  if (before.offset < sizeof(Newest) + text.size()) next.offset = before.offset + before.size;
  next.size = text.size();
  for (std::uint64_t at = next.offset; !text.empty();) {
    const ssize_t written = ::pwrite(text_, text.data(), text.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    at += static_cast<std::uint64_t>(written);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  // Where it cannot be written, the one before counts.
  [[maybe_unused]] const ssize_t written = ::pwrite(text_, &next, sizeof next, 0);
}

void Relaunch::set_trial(bool trial) {
  if (trial_ != nullptr) trial_->store(trial);
}

bool Relaunch::on_trial() const { return trial_ != nullptr && trial_->load(); }

bool Relaunch::has_guardian() const { return ::getpid() != first_process_; }

// The runtime is its child, until somebody else adopts it.
int Relaunch::dead_guardian() const { return has_guardian() && ::getppid() != first_process_ ? first_process_ : 0; }

int Relaunch::end(int code) const {
  // A runtime with a guardian is its child: that one starts anew, when nothing of this process holds a device any more.
  const bool again = code == kExitRelaunch || (code != kExitOk && on_trial() && signal_to_stop() == 0);
  if (!again || has_guardian()) return code;
  execute();
  if (signal_to_stop() != 0) return code == kExitRelaunch ? kExitOk : code;
  complain("plc-run", fmt::format("cannot be started anew: {}", std::strerror(errno)));
  return kExitErrors;
}

int Relaunch::guardian_ended(int code, bool asked) const {
  if (!asked && (code == kExitRelaunch || (code != kExitOk && on_trial()))) execute();
  if (code != kExitRelaunch) return code;
  return asked ? kExitOk : kExitErrors;
}

std::string Relaunch::own_path() {
  std::error_code ignored;
  const std::string path = std::filesystem::read_symlink(kSelf, ignored).string();
  return std::filesystem::exists(path, ignored) ? path : kSelf;
}

/// Returns when it fails, or a signal wants an end.
void Relaunch::execute() const {
  // One that comes from now on waits for the next process, which it ends.
  sigset_t all;
  sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, nullptr);
  if (signal_to_stop() != 0) return;
  // What a process leaves to the program that it becomes: back to how it was.
  sched_param before{};
  before.sched_priority = priority_;
  ::sched_setscheduler(0, policy_, &before);
  if (!oom_score_.empty()) std::ofstream(kOomScore) << oom_score_;
  if (text_ >= 0) {
    ::fcntl(text_, F_SETFD, 0);
    ::setenv(kVariable, std::to_string(text_).c_str(), 1);
  }
  if (sockets_ > 0) {
    for (int i = 0; i < sockets_; ++i) ::fcntl(SD_LISTEN_FDS_START + i, F_SETFD, 0);
    ::setenv("LISTEN_FDS", std::to_string(sockets_).c_str(), 1);
    ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
  }
  std::vector<char*> words;
  for (const std::string& word : arguments_) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execv(own_path().c_str(), words.data());
  ::execv(kSelf, words.data());  // an upgrade has replaced the file: this one goes on
}

}  // namespace plc::tools
