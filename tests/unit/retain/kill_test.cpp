// The process is killed at random points of its writes: what is read afterwards is a whole set of one scan, and never
// older than the last that was stored. PLC_RETAIN_KILLS=10000 kills as often, and looks at the age too.
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <random>
#include <thread>

#include "retain/keeper.h"
#include "tests/unit/retain/plant.h"

namespace plc::test {
namespace {

/// Elements that all have the number of the scan; the second program keeps more of them.
std::string project(int elements) {
  return with_task("PROGRAM Main VAR RETAIN a : ARRAY [1.." + std::to_string(elements) +
                   "] OF DINT; END_VAR VAR i, n : DINT; END_VAR\n  n := a[1] + 1; FOR i := 1 TO " +
                   std::to_string(elements) + " DO a[i] := n; END_FOR; END_PROGRAM\n");
}

/// What the child tells before it dies.
struct Shared {
  std::atomic<std::int32_t> stored{0};  ///< number of the scan that was stored last
  static constexpr std::size_t kScans = 1 << 16;
  std::atomic<core::TimeNs> ended[kScans] = {};  ///< when the scan of this number ended
};

std::int32_t number_at(const std::vector<std::byte>& values, std::size_t at) {
  std::int32_t number = 0;
  std::memcpy(&number, values.data() + at, sizeof number);
  return number;
}

/// Scans and stores as fast as it can, until it is killed.
[[noreturn]] void scan_and_store(runtime::Resource& resource, const std::string& folder, Shared& shared) {
  retain::Keeper keeper(resource, {folder});
  if (keeper.restore(retain::Start::kWarm).problem) _exit(3);
  for (core::TimeNs now = 0;; ++now) {
    keeper.ask();
    if (resource.program(0).execute({now})) _exit(4);
    resource.program(0).offer_kept();
    keeper.store(now);
    if (!keeper.messages().empty()) _exit(5);
    const std::byte* const table = resource.program(0).table().data() + resource.program(0).table().layout().instance;
    std::int32_t number = 0;
    std::memcpy(&number, table, sizeof number);
    shared.stored.store(number);
  }
}

/// As plc-run does: a task of 1 ms, and the thread of the keeper.
[[noreturn]] void run_as_plc_run(runtime::Resource& resource, const std::string& folder, Shared& shared) {
  retain::Keeper keeper(resource, {folder});
  if (keeper.restore(retain::Start::kWarm).problem) _exit(3);
  keeper.start();
  core::MonotonicClock clock;
  for (core::TimeNs next = clock.now_ns();; next += 1'000'000) {
    clock.sleep_until_ns(next);
    if (resource.program(0).execute({next})) _exit(4);
    const std::byte* const table = resource.program(0).table().data() + resource.program(0).table().layout().instance;
    std::int32_t number = 0;
    std::memcpy(&number, table, sizeof number);
    shared.ended[static_cast<std::size_t>(number) % Shared::kScans].store(clock.now_ns());
    resource.program(0).offer_kept();
  }
}

class Kills {
 public:
  Kills()
      : shared_(new (::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))
                    Shared),
        resources_{load_text(project(3'000)), load_text(project(4'000))} {}
  ~Kills() { ::munmap(shared_, sizeof(Shared)); }
  Kills(const Kills&) = delete;
  Kills& operator=(const Kills&) = delete;

  using Child = void (*)(runtime::Resource&, const std::string&, Shared&);
  /// Kills the child `after` that time, and gives the number that every element of the file has.
  std::int32_t kill_child(Child child, std::size_t program, core::TimeNs after, core::TimeNs& killed_at) {
    const pid_t pid = ::fork();
    if (pid == 0) child(*resources_[program], folder(), *shared_);
    core::MonotonicClock clock;
    clock.sleep_until_ns(clock.now_ns() + after);
    killed_at = clock.now_ns();
    ::kill(pid, SIGKILL);
    int status = 0;
    ::waitpid(pid, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status)) << "exit code " << WEXITSTATUS(status);
    const auto stored = retain::read_file(folder() + "/retain");
    if (!stored) {
      // Killed before anything was stored at all.
      EXPECT_EQ(stored.error().code, core::Code::P7001) << stored.error().message;
      return 0;
    }
    const std::int32_t number = number_at(stored->values, 0);
    for (std::size_t at = 0; at < stored->values.size(); at += 4) {
      if (number_at(stored->values, at) == number) continue;
      // A changed program begins with what fits, and its own initial values for the rest, until its first scan.
      ADD_FAILURE() << "mixed: " << number << " and " << number_at(stored->values, at) << " at " << at;
      break;
    }
    return number;
  }
  [[nodiscard]] Shared& shared() { return *shared_; }
  [[nodiscard]] std::string folder() const { return scratch_.file("state"); }

 private:
  ScratchFolder scratch_;
  Shared* shared_;
  std::unique_ptr<runtime::Resource> resources_[2];
};

TEST(Kill, NeverALostOrMixedSet) {
  const char* const wanted = std::getenv("PLC_RETAIN_KILLS");
  const int kills = wanted == nullptr ? 300 : std::atoi(wanted);
  Kills run;
  std::mt19937 random(7);
  // Of a slow disk, too, kills hit every part of what is done.
  constexpr core::TimeNs kTried = 500'000'000, kLeast = 12'000'000;
  core::TimeNs killed_at = 0;
  run.kill_child(scan_and_store, 0, kTried, killed_at);
  std::int32_t least = run.shared().stored.load();
  const auto most = static_cast<std::uint32_t>(std::max(kLeast, 4 * kTried / std::max(1, least)));
  for (int kill = 0; kill < kills && !testing::Test::HasFailure(); ++kill) {
    const std::int32_t number = run.kill_child(scan_and_store, kill / 5 % 2, random() % most, killed_at);
    // What was stored is there; the scan that was being stored may be.
    least = std::max(least, run.shared().stored.load());
    ASSERT_GE(number, least) << "after kill " << kill;
    least = number;
  }
  EXPECT_GT(least, kills / 2);
}

TEST(Kill, NothingIsOlderThan200Milliseconds) {
  const char* const wanted = std::getenv("PLC_RETAIN_KILLS");
  if (wanted == nullptr) GTEST_SKIP() << "takes long: PLC_RETAIN_KILLS=10000 measures the age";
  Kills run;
  std::mt19937 random(11);
  core::TimeNs oldest = 0;
  for (int kill = 0; kill < std::atoi(wanted) / 50 && !testing::Test::HasFailure(); ++kill) {
    core::TimeNs killed_at = 0;
    const std::int32_t number = run.kill_child(run_as_plc_run, 0, 300'000'000 + random() % 200'000'000, killed_at);
    // The scan after the one that was stored is the oldest that is lost.
    const core::TimeNs lost = run.shared().ended[static_cast<std::size_t>(number + 1) % Shared::kScans].load();
    if (lost != 0) oldest = std::max(oldest, killed_at - lost);
  }
  std::cout << "oldest scan that was lost: " << oldest / 1'000'000 << " ms before the kill\n";
  EXPECT_LE(oldest, 200'000'000);
}

}  // namespace
}  // namespace plc::test
