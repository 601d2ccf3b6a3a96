#include "retain/keeper.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

namespace plc::retain {
namespace {

/// How long an answer is waited for before the others are stored.
constexpr core::TimeNs kPatienceNs = 20'000'000;
constexpr core::TimeNs kPollNs = 1'000'000;
/// Between attempts on a disk that refuses.
constexpr core::TimeNs kRetryNs = 1'000'000'000;
/// Between two times at which the same trouble is told.
constexpr core::TimeNs kSayNs = 60'000'000'000;

std::int64_t time_of_day_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Keeper::Keeper(runtime::Resource& resource, KeeperOptions options)
    : resource_(resource),
      options_(std::move(options)),
      kept_(find_kept(resource, options_.what)),
      gatherer_(resource, kept_),
      store_(options_.folder, kept_.layout),
      values_(kept_.layout.bytes) {}

Keeper::~Keeper() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

Restored Keeper::restore(Start start) {
  Restored out;
  gatherer_.copy_initial(values_);
  std::error_code error;
  const bool missing =
      !std::filesystem::exists(path(), error) && (!error || error == std::errc::no_such_file_or_directory);
  if (missing || start == Start::kOrigin) return out;
  out.found = true;
  auto stored = read_file(path());
  if (!stored) {
    out.problem = stored.error();
    return out;
  }
  out.carried = carry_over(stored->layout, stored->values, kept_.layout, values_, start);
  out.sequence = stored->sequence;
  out.time_of_day_ns = stored->time_of_day_ns;
  out.program_time_ns = program_time_ns_ = stored->program_time_ns;
  gatherer_.restore(values_);
  return out;
}

void Keeper::start() {
  if (!empty() && !thread_.joinable()) thread_.start("plc-retain", [this] { run(); });
}

void Keeper::run() {
  const core::MonotonicClock clock;
  for (bool ending = false; !ending;) {
    const core::TimeNs begin = clock.now_ns();
    ask();
    const core::TimeNs patience = std::min(kPatienceNs, options_.interval_ns);
    while (!ending && !answered() && clock.now_ns() - begin < patience) ending = wait(kPollNs);
    store(clock.now_ns());
    if (!ending) ending = wait(std::max(begin + options_.interval_ns - clock.now_ns(), kPollNs));
  }
}

bool Keeper::wait(core::TimeNs ns) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::nanoseconds(ns), [this] { return ending_; });
}

void Keeper::store(core::TimeNs now_ns) {
  program_time_ns_ = std::max(program_time_ns_, gatherer_.take(values_));
  if (any_stored_ && values_ == stored_) return;
  if (failing_ && now_ns < retry_ns_) return;
  const std::string problem = store_.write(values_, program_time_ns_, time_of_day_ns());
  if (problem.empty()) {
    stored_ = values_;
    any_stored_ = true;
    if (told_) say({"retained values are stored again"});
    failing_ = told_ = false;
    return;
  }
  retry_ns_ = now_ns + kRetryNs;
  if (!failing_ && (!said_ns_ || now_ns - *said_ns_ >= kSayNs)) {
    said_ns_ = now_ns;
    told_ = true;
    say({fmt::format("{}: retained values are not stored, and it is tried again: {}",
                     core::info(core::Code::P7613).name, problem),
         core::Severity::kWarning});
  }
  failing_ = true;
}

void Keeper::stop(std::span<const std::uint32_t> running) {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  program_time_ns_ = std::max(program_time_ns_, gatherer_.take(values_));
  for (std::uint32_t task = 0; task < resource_.task_count(); ++task) {
    if (std::find(running.begin(), running.end(), task) == running.end()) gatherer_.answer_for(task);
  }
  const core::MonotonicClock clock;
  retry_ns_ = 0;
  store(clock.now_ns());
}

void Keeper::say(Message message) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(std::move(message));
}

std::vector<Message> Keeper::messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

}  // namespace plc::retain
