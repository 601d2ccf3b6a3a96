#include "tools/plc-run/end_guard.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>

#include "tools/plc-run/relaunch.h"

namespace plc::tools {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::string_view kSentence =
    "plc-run: warning: the end takes too long: perhaps a disk hangs; it ends now, and what is not written is lost\n";
/// How often is looked, and for how long the sentence is waited for.
constexpr milliseconds kTick{250}, kShortestTick{5}, kSayPatience{500};

/// Whoever reads stderr may hang as well, and a file may be on the disk that hangs: a thread of its own, left behind.
void say() {
  const auto said = std::make_shared<std::atomic<bool>>(false);
  std::thread([said] {
    pollfd out{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&out, 1, 0) == 1) static_cast<void>(!::write(STDERR_FILENO, kSentence.data(), kSentence.size()));
    *said = true;
  }).detach();
  for (milliseconds waited{0}; waited < kSayPatience && !*said; waited += kShortestTick)
    std::this_thread::sleep_for(kShortestTick);
}

}  // namespace

void EndGuard::begin(int code, milliseconds patience, Alive alive) {
  expect(code);
  try {
    thread_.start("plc-end", [this, patience, alive = std::move(alive)] { run(patience, alive); });
  } catch (const std::exception&) {
    // No thread to be had: the end takes as long as it takes.
  }
}

void EndGuard::run(milliseconds patience, const Alive& alive) {
  milliseconds tick = std::min(kTick, patience / 4);
  if (alive.every.count() > 0) tick = std::min(tick, alive.every);
  tick = std::max(tick, kShortestTick);
  Clock::duration left = patience;
  Clock::time_point looked = Clock::now(), told = looked;
  std::uint32_t reader = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, tick, [this] { return done_; })) return;
    }
    const Clock::time_point now = Clock::now();
    const Clock::duration passed = now - std::exchange(looked, now);
    if (rests_) {
      told = now;
      continue;
    }
    if (alive.every.count() > 0 && now - told >= alive.every) {
      told = now;
      alive.tell();
    }
    const std::uint32_t waits = reader_;
    if (std::exchange(reader, waits) != waits) continue;
    // WHY no more: when this thread itself did not run, the others may not have run either.
    left -= std::min<Clock::duration>(passed, 2 * tick);
    if (left <= Clock::duration::zero()) break;
  }
  try {
    say();
  } catch (const std::exception&) {
    // Without a word, then.
  }
  // WHY not exit(): it would wait for the threads that hang.
  ::_exit(Relaunch::instance().end(code_));
}

EndGuard::~EndGuard() {
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

}  // namespace plc::tools
