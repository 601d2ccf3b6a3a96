#include "tools/plc-run/component_faults.h"

#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <cstring>

#include "runtime/taskblocks.h"

namespace plc::tools {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
/// For the handler alone.
constexpr std::size_t kHandlerStackBytes = 65536;

runtime::Resource* watched = nullptr;
constinit thread_local runtime::Program* program_here = nullptr;
std::array<struct sigaction, kCrashes.size()> before{};

/// A line put together without allocation; what does not fit is cut off.
class Line {
 public:
  void add(const char* text) noexcept {
    for (; *text != '\0' && length_ + 1 < sizeof text_; ++text) text_[length_++] = *text;
  }
  void print() noexcept {
    text_[length_++] = '\n';
    // WHY: nothing is left to report it to when this fails; a reader that stalls must not keep the process from its
    // end.
    pollfd out{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&out, 1, 0) != 1) return;
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text_, length_);
  }

 private:
  char text_[512];
  std::size_t length_ = 0;
};

void say_where() noexcept {
  const char* const made = runtime::Taskblocks::making();
  const char* const fired = program_here != nullptr ? program_here->running_taskblock() : nullptr;
  if (made == nullptr && program_here == nullptr) return;
  Line line;
  line.add("plc-run: crashed in ");
  if (made != nullptr) {
    line.add("taskblock ");
    line.add(made);
    line.add(", while it was made ready");
  } else if (fired != nullptr) {
    line.add("taskblock ");
    line.add(fired);
    line.add(" (task ");
    line.add(program_here->task().name.c_str());
    line.add(")");
  } else {
    line.add("task ");
    line.add(program_here->task().name.c_str());
    line.add(", outside of its taskblocks");
  }
  line.print();
}

/// Async-signal-safe: reads what does not change any more, writes a line, and gives way to who was there before.
void on_crash(int signal, siginfo_t* info, void* /*context*/) {
  say_where();
  for (std::size_t i = 0; i < kCrashes.size(); ++i) {
    if (kCrashes[i] == signal) ::sigaction(signal, &before[i], nullptr);
  }
  // What the processor found, it finds again on return; a signal that was sent has to be sent again.
  if (info->si_code <= 0) static_cast<void>(::raise(signal));
}

}  // namespace

void name_crashes(runtime::Resource& resource) {
  watched = &resource;
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (std::size_t i = 0; i < kCrashes.size(); ++i) ::sigaction(kCrashes[i], &action, &before[i]);
}

void watch_task_thread(std::uint32_t task) {
  // Never given back: a thread ends only with the process.
  void* const memory = ::mmap(nullptr, kHandlerStackBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory != MAP_FAILED) {
    stack_t stack{};
    stack.ss_sp = memory;
    stack.ss_size = kHandlerStackBytes;
    ::sigaltstack(&stack, nullptr);
  }
  program_here = &watched->program(task);
}

// RT:
runtime::Program* program_of_thread() noexcept { return program_here; }

}  // namespace plc::tools
