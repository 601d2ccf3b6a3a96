#include "shadow/shadow.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace plc::shadow {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Between two times of taking records. More often only takes cache lines away from the tasks.
constexpr milliseconds kPeriod{100};
/// The same while somebody looks.
constexpr milliseconds kViewPeriod{16};
/// The same while replicas are behind: they go on, and who waits for them has its turn.
constexpr milliseconds kBehindPeriod{1};
/// Who leaves out scans, since they come faster than they are executed again, takes half of a processor for so long.
constexpr std::chrono::seconds kSlow{30};
/// Scans that are left out for so long are said.
constexpr std::chrono::seconds kSurelySlow{2};
/// A viewer waits at most so long for the replicas.
constexpr milliseconds kFollowAtOnce{10};
/// The same of an observer alone.
constexpr milliseconds kObserveAtOnce{60};
/// After a fault the recording has so much of what followed.
constexpr milliseconds kAfterFault{1000};
/// A plant that faults again and again does not fill the disk.
constexpr std::chrono::seconds kBetweenFaults{60};
constexpr std::string_view kLeftOut = "; scans are left out of the recording until it can be written";

}  // namespace

core::Result<std::unique_ptr<Shadow>> Shadow::start(runtime::Resource& resource, ShadowOptions options,
                                                    RecordingHead head) {
  std::unique_ptr<Shadow> made(new Shadow(std::move(options), std::move(head)));
  Shadow* const self = made.get();
  self->file_head_ = file_head(self->head_);
  if (const auto problem = self->open_folder()) {
    self->say(core::Severity::kWarning,
              fmt::format("{}: {}{}", core::info(problem->code).name, problem->message, kLeftOut));
    self->in_trouble_ = true;
  }
  if (!self->options_.crash_folder.empty()) self->make_crash_memory(resource);
  RecordingOptions recording_options = self->options_.recording;
  recording_options.crash_memory = self->crash_memory_.get();
  auto recording = Recording::start(
      resource,
      [self](const BlockInfo& info, std::vector<std::byte> block) {
        self->history_.add(info.first_ns, info.last_ns, block);
        if (self->options_.folder) self->unwritten_.push_back(std::move(block));
      },
      recording_options);
  if (!recording) return recording.error();
  self->recording_ = std::move(*recording);
  self->recording_->set_before_end([self](std::uint32_t task) {
    // What is not executed now is not executed at all: a check has to, a viewer would miss a pulse, an observer a scan.
    if (!self->follower_) return;
    const bool viewed = self->viewers_.load(std::memory_order_relaxed) != 0;
    Follower::Deadline deadline;
    if (!self->options_.check) {
      if (!viewed && self->observer_.load(std::memory_order_relaxed) == nullptr) return;
      deadline = steady_clock::now() + (viewed ? kFollowAtOnce : kObserveAtOnce);
    }
    if (!self->follower_->follow(task, *self->recording_->open_block(task), deadline)) self->leaves_out_scans();
  });
  self->tasks_ = static_cast<std::uint32_t>(resource.task_count());
  if (self->options_.check) self->make_follower();
  self->thread_.start("plc-record", [self] { self->run(); });
  return made;
}

Shadow::~Shadow() { stop(false); }

void Shadow::make_follower() {
  core::Diagnostics diagnostics;
  // WHY without the lock: it takes half a second for a large project, and whoever asks for anything would wait.
  auto made = Follower::make(head_, options_.prepare, diagnostics);
  const std::lock_guard lock(mutex_);
  follower_failed_ = !made;
  if (made) {
    follower_ = std::move(*made);
    follower_->set_observer(observer_.load());
  } else {
    say(core::Severity::kWarning, "no scan can be executed again here: " + made.error().message);
  }
}

void Shadow::leaves_out_scans() {
  const auto now = steady_clock::now();
  if (now >= slow_until_) slow_since_ = now;
  slow_until_ = now + kSlow;
  // Not when somebody has begun to look just now: blocks of several tasks end at the same time.
  if (now - slow_since_ < kSurelySlow || std::exchange(slow_said_, true)) return;
  say(core::Severity::kWarning,
      "scans come faster than they can be executed again beside the plant: alarms, live drawings and values of tasks "
      "do without some of them");
}

void Shadow::follow(Follower::Deadline deadline) {
  if (!follower_) return;
  followed_ = true;
  for (std::uint32_t task = 0; task < tasks_; ++task) {
    const BlockBuilder* const block = recording_->open_block(task);
    if (block != nullptr) followed_ = follower_->follow(task, *block, deadline) && followed_;
  }
  for (const Difference& found : follower_->take_differences()) {
    // On the same machine every scan gives what it gave.
    say(core::Severity::kError,
        fmt::format(
            "{}: scan {} of task \"{}\": {} is not as a replica has it; this is a fault of PICARD: please report "
            "it with a recording",
            core::info(core::Code::P7632).name, found.scan,
            follower_->replicas().resource().program(found.task).task().name, found.what));
  }
}

void Shadow::sum_counts() {
  counts_ = {};
  for (std::uint32_t task = 0; task < tasks_; ++task) {
    const RecordingCounts one = recording_->counts(task);
    counts_.scans += one.scans;
    counts_.lost += one.lost;
    counts_.record_bytes += one.record_bytes;
    counts_.stored_bytes += one.stored_bytes;
    counts_.gaps += one.gaps;
  }
}

void Shadow::turn() {
  const bool viewed = viewers_.load(std::memory_order_relaxed) != 0;
  const bool looked_at = viewed || options_.check || observer_.load(std::memory_order_relaxed) != nullptr;
  if (looked_at && !follower_ && !follower_failed_) make_follower();
  {
    const std::lock_guard lock(mutex_);
    recording_->drain();
    if (looked_at) {
      follow(options_.check ? Follower::Deadline{} : steady_clock::now() + (viewed ? kFollowAtOnce : kObserveAtOnce));
    } else {
      followed_ = false;  // who looks next waits for the scans until then
    }
    sum_counts();
  }
  store();
  const std::uint64_t faults = recording_->faults();
  if (faults != std::exchange(faults_seen_, faults) && !fault_due_ && !options_.fault_folder.empty()) {
    const auto now = steady_clock::now();
    if (!fault_saved_ || now - *fault_saved_ > kBetweenFaults) fault_due_ = now + kAfterFault;
  }
  if (fault_due_ && steady_clock::now() >= *fault_due_) store_fault();
}

std::optional<core::Problem> Shadow::open_folder() {
  if (!options_.folder || folder_) return {};
  auto folder = RecordFolder::open(*options_.folder, head_);
  if (!folder) return folder.error();
  const std::lock_guard lock(mutex_);
  folder_ = std::move(*folder);
  return {};
}

void Shadow::store() {
  for (const std::vector<std::byte>& block : std::exchange(unwritten_, {})) {
    const bool written = !open_folder() && folder_->write(block);
    if (written && in_trouble_) say(core::Severity::kNote, "the recording is written again");
    if (!written && !in_trouble_) {
      say(core::Severity::kWarning, folder_->problem()->message + std::string(kLeftOut));
    }
    in_trouble_ = !written;
  }
}

void Shadow::store_fault() {
  fault_due_.reset();
  fault_saved_ = steady_clock::now();
  const auto saved = save_recording(options_.fault_folder, "fault", recording(), options_.fault_files);
  if (saved) {
    say(core::Severity::kNote, fmt::format("what led to the fault is in {0}; plc replay {0} --until fault", *saved));
  } else {
    say(core::Severity::kWarning, "what led to the fault could not be written: " + saved.error().message);
  }
}

void Shadow::make_crash_memory(runtime::Resource& resource) {
  std::error_code error;
  const std::filesystem::path state = std::filesystem::absolute(options_.fault_folder, error).parent_path();
  // Where there is none yet, others would take what this plant leaves for that of one that is gone.
  std::filesystem::create_directories(state, error);
  CrashMemory::Sizes sizes{options_.recording.ring_bytes, options_.recording.most_record_bytes, {}, state.string()};
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    sizes.table_bytes.push_back(resource.program(task).table().layout().total);
  }
  auto made = CrashMemory::make(options_.crash_folder, file_head_, sizes);
  if (made) {
    crash_memory_ = std::move(*made);
  } else {
    say(core::Severity::kWarning, made.error().message + "; " + made.error().help);
  }
}

void Shadow::store_left() {
  const std::vector<std::byte> left = CrashMemory::take_left(options_.crash_folder);
  if (left.empty()) return;
  const auto saved = save_recording(options_.fault_folder, "crash", left, options_.fault_files);
  if (saved) {
    say(core::Severity::kNote,
        fmt::format("plc-run has died before this start; what led to it is in {0}; plc replay {0}", *saved));
  } else {
    say(core::Severity::kWarning, "what led to the death of plc-run could not be written: " + saved.error().message);
  }
}

std::vector<std::byte> Shadow::recording() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::vector<std::byte>> open;
  for (std::uint32_t task = 0; task < tasks_; ++task) {
    const BlockBuilder* const block = recording_->open_block(task);
    if (block != nullptr && !block->empty()) open.push_back(block->pack());
  }
  return history_.recording(file_head_, open);
}

void Shadow::say(core::Severity severity, std::string text) {
  const std::lock_guard lock(said_mutex_);
  messages_.push_back({severity, std::move(text)});
}

std::vector<ShadowMessage> Shadow::messages() {
  const std::lock_guard lock(said_mutex_);
  return std::exchange(messages_, {});
}

core::TimeNs Shadow::history_ns() const {
  const std::lock_guard lock(mutex_);
  std::optional<core::TimeNs> begin = history_.begin_ns(), end = history_.end_ns();
  for (std::uint32_t task = 0; task < tasks_; ++task) {
    const BlockBuilder* const block = recording_->open_block(task);
    if (block == nullptr || block->empty()) continue;
    begin = std::min(begin.value_or(block->info().first_ns), block->info().first_ns);
    end = std::max(end.value_or(block->info().last_ns), block->info().last_ns);
  }
  return begin && end ? *end - *begin : 0;
}

RecordingCounts Shadow::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void Shadow::run() {
  if (crash_memory_) store_left();
  while (!ends_.load(std::memory_order_acquire)) {
    const auto began = steady_clock::now();
    turn();
    const auto ended = steady_clock::now();
    std::unique_lock lock(wake_mutex_);
    const bool looked_at = viewers_.load(std::memory_order_relaxed) != 0;
    const bool follows = looked_at || observer_.load(std::memory_order_relaxed) != nullptr;
    const bool behind = follows && follower_ && !followed_;
    const auto worked = std::chrono::duration_cast<milliseconds>(ended - began);
    // Not longer than rings have room.
    const milliseconds pause = ended < slow_until_ ? std::clamp(worked, kBehindPeriod, kPeriod) : kBehindPeriod;
    const milliseconds rest = looked_at ? kViewPeriod : kPeriod;
    wake_.wait_for(lock, behind ? pause : rest, [this, looked_at] {
      return ends_.load(std::memory_order_relaxed) || (!looked_at && viewers_.load(std::memory_order_relaxed) != 0);
    });
  }
}

void Shadow::stop(bool whole) {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(wake_mutex_);
    ends_.store(true, std::memory_order_release);
  }
  wake_.notify_one();
  thread_.join();
  turn();
  if (fault_due_) store_fault();
  if (!whole) return;
  {
    const std::lock_guard lock(mutex_);
    recording_->finish();
    sum_counts();
  }
  store();
}

void Shadow::observe(ScanObserver& observer) {
  const std::lock_guard lock(mutex_);
  observer_.store(&observer);
  if (follower_) follower_->set_observer(&observer);
}

Shadow::Viewer::Viewer(Shadow& shadow) : shadow_(shadow) {
  {
    const std::lock_guard lock(shadow_.wake_mutex_);
    shadow_.viewers_.fetch_add(1, std::memory_order_relaxed);
  }
  shadow_.wake_.notify_one();
}

Shadow::Viewer::~Viewer() { shadow_.viewers_.fetch_sub(1, std::memory_order_relaxed); }

bool Shadow::Viewer::read(const std::function<void(Follower&)>& read) {
  const std::lock_guard lock(shadow_.mutex_);
  if (!shadow_.follower_ || !shadow_.followed_) return false;
  shadow_.follower_->replicas().show_globals();
  read(*shadow_.follower_);
  return true;
}

}  // namespace plc::shadow
