#include <atomic>
#include <thread>

#include "tests/taskblocks/faulty/component.h"

namespace {
/// OUT follows a thread that ready() starts, as components do whose work must not hold up the cycle.
class StartsAThread final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Works on a thread of its own."};
  picard::Input<bool> go{this, "GO", "not used"};
  picard::Output<double> out{this, "OUT", "rounds of the thread"};

  ~StartsAThread() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  void ready() override {
    thread_ = std::thread([this] {
      for (; !stop_; ++rounds_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  }
  void fire() override { out = rounds_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<int> rounds_{0};
  std::thread thread_;
};
}  // namespace

PICARD_LIBRARY("starts_a_thread", "1.0.0", StartsAThread)
