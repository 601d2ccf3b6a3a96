#include "io-drivers/guardian/guardian.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iostream>
#include <iterator>
#include <mutex>
#include <new>
#include <optional>
#include <set>

#include "runtime/sched/priority.h"
#include "runtime/sched/thread_settings.h"

namespace plc::io {

struct GuardianPage {
  enum State : std::uint32_t { kRunning, kStopping, kFinished };
  /// One task; a cache line each, since tasks count on different cores.
  struct alignas(64) Slot {
    std::atomic<std::uint64_t> pulses{0};
    std::atomic<bool> stopped{false};
  };

  explicit GuardianPage(std::uint32_t slot_count) : slots(slot_count) {
    for (std::uint32_t i = 0; i < slots; ++i) new (&slot(i)) Slot;
  }
  Slot& slot(std::uint32_t task) { return reinterpret_cast<Slot*>(reinterpret_cast<std::byte*>(this) + 64)[task]; }
  static std::size_t bytes(std::uint32_t slot_count) { return 64 + slot_count * sizeof(Slot); }

  std::atomic<std::uint32_t> state{kRunning};
  const std::uint32_t slots;
};
static_assert(sizeof(GuardianPage) <= 64 && std::atomic<std::uint64_t>::is_always_lock_free);

// RT:
void Pulse::after_scan(const runtime::ReleaseContext& context) noexcept {
  if (context.task >= page_.slots) return;
  page_.slot(context.task).pulses.fetch_add(1, std::memory_order_relaxed);
}

// RT:
void Pulse::task_stopped(std::uint32_t task) noexcept {
  if (task < page_.slots) page_.slot(task).stopped.store(true, std::memory_order_relaxed);
}

void Pulse::stopping() noexcept {
  std::uint32_t running = GuardianPage::kRunning;
  page_.state.compare_exchange_strong(running, GuardianPage::kStopping, std::memory_order_release);
}

void Pulse::finished() noexcept { page_.state.store(GuardianPage::kFinished, std::memory_order_release); }

namespace {

constexpr core::TimeNs kMs = 1'000'000;
/// Between two looks: a quarter of the time-out, within these.
constexpr core::TimeNs kShortestLook = 5 * kMs;
constexpr core::TimeNs kLongestLook = 250 * kMs;
/// For a killed runtime to be gone. One that is stuck in the kernel is not waited for longer.
constexpr int kReapTries = 200;
constexpr core::TimeNs kReapPause = 5 * kMs;

timespec timespec_of(core::TimeNs ns) { return {ns / 1'000'000'000, ns % 1'000'000'000}; }

std::string seconds(core::TimeNs ns) { return fmt::format("{:.3g} s", static_cast<double>(ns) / 1e9); }

/// Signals the guardian takes itself; all blocked, so that sigtimedwait() sees them. SIGTSTP only so that it is not
/// stopped: a runtime that a terminal stopped is a hang like any other.
sigset_t guarded_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGUSR1, SIGCHLD, SIGTSTP, SIGTTIN, SIGTTOU}) {
    // A signal that the parent process set to be ignored (nohup) is no request to stop.
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;
    sigaddset(&set, signal);
  }
  return set;
}

class Guardian {
 public:
  Guardian(const GuardianOptions& options, const std::vector<Driver*>& drivers, GuardianPage& page, pid_t runtime)
      : options_(options), drivers_(drivers), page_(page), runtime_(runtime), seen_(options.watched.size()) {}

  [[noreturn]] void run() {
    become_hard_to_disturb();
    const core::TimeNs look_ns = options_.hang_timeout_ns == 0
                                     ? kLongestLook
                                     : std::clamp(options_.hang_timeout_ns / 4, kShortestLook, kLongestLook);
    const sigset_t signals = guarded_signals();
    const timespec wait = timespec_of(look_ns);
    core::TimeNs last_ns = clock_.now_ns();
    for (;;) {
      siginfo_t signal{};
      const int number = ::sigtimedwait(&signals, &signal, &wait);
      // First: a wish for the end counts also when the runtime is gone by now, to be started anew.
      if (number > 0 && number != SIGCHLD) forward(number, signal);
      int status = 0;
      if (::waitpid(runtime_, &status, WNOHANG) == runtime_) end(status);
      const core::TimeNs now_ns = clock_.now_ns();
      // WHY at most two looks: when the guardian itself did not run, the runtime may not have run either.
      if (const auto reason = trouble(std::min(now_ns - last_ns, 2 * look_ns))) {
        ::kill(runtime_, SIGKILL);
        act(*reason + "; it was killed");
      }
      last_ns = now_ns;
      for (Driver* const driver : drivers_) driver->release_if_gone();
    }
  }

 private:
  /// As far as the system permits it; the guardian does its work without, too.
  static void become_hard_to_disturb() {
    ::prctl(PR_SET_NAME, "plc-guardian");
    static_cast<void>(::signal(SIGPIPE, SIG_IGN));
    if (const int fd = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC); fd >= 0) {
      [[maybe_unused]] const auto written = ::write(fd, "-900", 4);
      ::close(fd);
    }
    // WHY not MCL_CURRENT alone: that would copy every page shared with the runtime.
    ::mlockall(MCL_CURRENT | MCL_ONFAULT);
    // WHY above the tasks: one that spins must not keep the guardian from seeing it.
    static_cast<void>(runtime::set_fifo(::pthread_self(), runtime::kWatchdogPriority));
  }

  void forward(int number, const siginfo_t& signal) {
    if (number == SIGTSTP || number == SIGTTIN || number == SIGTTOU) return;
    // SIGUSR1 asks for a report, all others for the end.
    asked_to_stop_ = asked_to_stop_ || number != SIGUSR1;
    // A terminal sends its signals to the runtime as well.
    if (signal.si_code != SI_KERNEL) ::kill(runtime_, number);
  }

  /// Why the runtime must be killed, or nothing. `elapsed_ns` since the last look.
  std::optional<std::string> trouble(core::TimeNs elapsed_ns) {
    const std::uint32_t state = page_.state.load(std::memory_order_acquire);
    // Outputs are safe once it is finished; what it still prints may take its time, unless it was asked to end.
    const bool finished = state == GuardianPage::kFinished;
    if (finished ? !asked_to_stop_ : options_.hang_timeout_ns == 0) return std::nullopt;
    if (asked_to_stop_ || state == GuardianPage::kStopping) {
      stopping_ns_ += elapsed_ns;
      if (stopping_ns_ < options_.stop_timeout_ns) return std::nullopt;
      return "did not end within " + seconds(options_.stop_timeout_ns) + " of an orderly stop";
    }
    for (std::size_t i = 0; i < options_.watched.size(); ++i) {
      const WatchedTask& task = options_.watched[i];
      GuardianPage::Slot& slot = page_.slot(task.task);
      if (slot.stopped.load(std::memory_order_relaxed)) continue;
      const std::uint64_t pulses = slot.pulses.load(std::memory_order_relaxed);
      Seen& seen = seen_[i];
      seen.still_ns = pulses == seen.pulses ? seen.still_ns + elapsed_ns : 0;
      seen.pulses = pulses;
      core::TimeNs limit_ns = std::max(options_.hang_timeout_ns, 3 * task.period_ns);
      if (pulses == 0) limit_ns = std::max(limit_ns, options_.start_timeout_ns);
      if (seen.still_ns < limit_ns) continue;
      return "has not completed a cycle of task \"" + task.name + "\" for " + seconds(seen.still_ns);
    }
    return std::nullopt;
  }

  [[noreturn]] void end(int status) {
    reaped_ = true;
    if (WIFEXITED(status)) {
      if (page_.state.load(std::memory_order_acquire) == GuardianPage::kFinished) leave(WEXITSTATUS(status));
      act(fmt::format("ended with code {} without having made its outputs safe", WEXITSTATUS(status)));
    }
    act(fmt::format("was killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status))));
  }

  [[noreturn]] void act(const std::string& reason) {
    for (int left = kReapTries; !reaped_ && left > 0; --left) {
      reaped_ = ::waitpid(runtime_, nullptr, WNOHANG) != 0;
      const timespec pause = timespec_of(kReapPause);
      if (!reaped_) ::nanosleep(&pause, nullptr);
    }
    std::vector<Driver*> with_outputs;
    std::ranges::copy_if(drivers_, std::back_inserter(with_outputs), &Driver::has_outputs);
    std::mutex mutex;
    std::set<const Driver*> driven;
    for_all_at_once(with_outputs, [&](Driver& driver) {
      if (!driver.drive_safe()) return;
      const std::scoped_lock lock(mutex);
      driven.insert(&driver);
    });
    std::string safe, unsafe;
    for (const Driver* const driver : with_outputs) {
      std::string& list = driven.contains(driver) ? safe : unsafe;
      list += (list.empty() ? "" : ", ") + std::string(driver->name());
    }
    std::string text = fmt::format("plc-run guardian: the runtime (process {}) {}", runtime_, reason);
    if (!safe.empty()) text += "; the outputs of " + safe + " have their safe values";
    if (!unsafe.empty()) text += "; THE OUTPUTS OF " + unsafe + " COULD NOT BE MADE SAFE";
    text += '\n';
    // A reader that stalls does not keep this process either.
    pollfd out{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&out, 1, 0) == 1) {
      [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
    }
    leave(kGuardianExit);
  }

  [[noreturn]] void leave(int code) { ::_exit(options_.ended ? options_.ended(code, asked_to_stop_) : code); }

  struct Seen {
    std::uint64_t pulses = 0;
    core::TimeNs still_ns = 0;
  };
  const GuardianOptions& options_;
  const std::vector<Driver*>& drivers_;
  GuardianPage& page_;
  pid_t runtime_;
  core::MonotonicClock clock_;
  std::vector<Seen> seen_;
  bool asked_to_stop_ = false;
  bool reaped_ = false;
  core::TimeNs stopping_ns_ = 0;
};

core::Problem cannot_start(const char* what) {
  return {core::Code::P7410, fmt::format("the guardian cannot start: {}: {}", what, std::strerror(errno)),
          "without it outputs keep their values when plc-run dies; enabled = false in [guardian] accepts that"};
}

}  // namespace

core::Result<std::unique_ptr<Pulse>> start_guardian(const GuardianOptions& options,
                                                    const std::vector<Driver*>& drivers) {
  std::uint32_t slots = 0;
  for (const WatchedTask& task : options.watched) slots = std::max(slots, task.task + 1);
  void* const memory = ::mmap(nullptr, GuardianPage::bytes(slots), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) return cannot_start("shared memory");
  auto& page = *new (memory) GuardianPage(slots);
  auto pulse = std::make_unique<Pulse>(page);

  std::cout.flush();
  std::cerr.flush();
  static_cast<void>(std::fflush(nullptr));
  static_cast<void>(
      ::signal(SIGCHLD, SIG_DFL));  // an ignored one, inherited from a caller, would hide the runtime's end
  // Blocked across the split: a signal that comes now waits for the guardian, which forwards it.
  const sigset_t guarded = guarded_signals();
  sigset_t before;
  ::sigprocmask(SIG_BLOCK, &guarded, &before);
  const pid_t guardian = ::getpid();
  const pid_t child = ::fork();
  if (child > 0) Guardian(options, drivers, page, child).run();
  if (child < 0) {
    const core::Problem problem = cannot_start("second process");
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    ::munmap(memory, GuardianPage::bytes(slots));
    return problem;
  }
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != guardian) {
    // It died before it could be noticed; nothing runs yet, and nothing will.
    for (Driver* const driver : drivers) driver->close();
    ::_exit(kGuardianExit);
  }
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  return pulse;
}

}  // namespace plc::io
