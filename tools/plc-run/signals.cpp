#include "tools/plc-run/signals.h"

#include <atomic>
#include <csignal>

#include "core/clock.h"

namespace plc::tools {
namespace {

constexpr core::TimeNs kPrintPatienceNs = 2'000'000'000;
/// The plant that signals stop, once there is one.
std::atomic<io::Plant*> running{nullptr};
/// Number of the first signal to stop, 0 = none, and when it came.
std::atomic<int> signalled{0};
std::atomic<core::TimeNs> signalled_ns{0};
std::atomic<bool> report_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<core::TimeNs>::is_always_lock_free);

void on_report_signal(int) { report_wanted.store(true, std::memory_order_relaxed); }

void on_signal(int signal) {
  int none = 0;
  if (signalled.compare_exchange_strong(none, signal)) signalled_ns.store(core::MonotonicClock().now_ns());
  io::Plant* const plant = running.load(std::memory_order_relaxed);
  if (plant != nullptr) plant->request_stop();
}

}  // namespace

void handle_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    ::sigaction(signal, nullptr, &before);
    // A hang-up that the parent process set to be ignored (nohup) stays so; SIGINT, which shells ignore for what they
    // run in the background, is a request to stop all the same.
    if (signal != SIGHUP || before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
  action.sa_handler = on_report_signal;
  ::sigaction(SIGUSR1, &action, nullptr);
  // It means nothing here; who takes it for SIGUSR1 must not end control.
  static_cast<void>(::signal(SIGUSR2, SIG_IGN));
  // WHY: a reader that goes away (plc-run .. | head) must not take the outputs' safe state with it.
  static_cast<void>(::signal(SIGPIPE, SIG_IGN));
  // A limit on the size of files is an error of who writes one, as a full disk is.
  static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
}

void let_signals_stop(io::Plant* plant) {
  running.store(plant, std::memory_order_relaxed);
  if (plant != nullptr && signalled.load(std::memory_order_relaxed) != 0) plant->request_stop();
}

int signal_to_stop() { return signalled.load(); }

bool printing_takes_too_long() {
  return signalled.load() != 0 && core::MonotonicClock().now_ns() - signalled_ns.load() > kPrintPatienceNs;
}

bool take_wish_for_report() { return report_wanted.exchange(false, std::memory_order_relaxed); }

}  // namespace plc::tools
