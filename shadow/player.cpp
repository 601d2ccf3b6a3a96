#include "shadow/player.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "runtime/sched/task.h"

namespace plc::shadow {

core::Result<std::unique_ptr<Player>> Player::make(const RecordFile& file, core::Diagnostics& diagnostics) {
  auto replicas = ReplicaSet::make(file.head(), diagnostics);
  if (!replicas) return replicas.error();
  std::unique_ptr<Player> made(new Player(file));
  made->replicas_ = std::move(*replicas);
  made->tasks_.resize(made->replicas_->task_count());
  for (const BlockInfo& block : file.blocks()) {
    if (block.task < made->tasks_.size()) made->tasks_[block.task].blocks.push_back(&block);
  }
  for (Task& task : made->tasks_) {
    std::stable_sort(task.blocks.begin(), task.blocks.end(),
                     [](const BlockInfo* a, const BlockInfo* b) { return a->first_scan < b->first_scan; });
    made->advance(task);
  }
  return made;
}

std::optional<core::TimeNs> Player::begin_ns() const {
  std::optional<core::TimeNs> begin;
  for (const Task& task : tasks_) {
    if (!task.blocks.empty())
      begin = std::min(begin.value_or(task.blocks.front()->first_ns), task.blocks.front()->first_ns);
  }
  return begin;
}

std::optional<core::TimeNs> Player::end_ns() const {
  std::optional<core::TimeNs> end;
  for (const Task& task : tasks_) {
    if (!task.blocks.empty()) end = std::max(end.value_or(task.blocks.back()->last_ns), task.blocks.back()->last_ns);
  }
  return end;
}

core::TimeNs Player::time_of(const Task& task, const runtime::RecordHead& head) const {
  if (!count_releases_ || head.now_ns < head.start_ns) return head.now_ns;
  return head.start_ns + (head.now_ns - head.start_ns) / task.grid_ns * task.grid_ns;
}

void Player::count_releases() {
  const bytecode::Image& image = replicas_->resource().image();
  // An event task is released by what others write: in the instants of the fastest of them.
  std::optional<core::TimeNs> shortest_ns;
  for (const bytecode::ImageTask& task : image.tasks) {
    if (!task.single.empty()) continue;
    const core::TimeNs grid_ns = runtime::grid_period(task);
    shortest_ns = std::min(shortest_ns.value_or(grid_ns), grid_ns);
  }
  count_releases_ = true;
  for (std::size_t t = 0; t < tasks_.size(); ++t) {
    Task& task = tasks_[t];
    const core::TimeNs own_ns = runtime::grid_period(image.tasks[t]);
    task.grid_ns = image.tasks[t].single.empty() ? own_ns : shortest_ns.value_or(own_ns);
    if (task.record.empty()) continue;
    runtime::RecordHead head;
    std::memcpy(&head, task.record.data(), sizeof head);
    task.now_ns = time_of(task, head);
  }
}

std::optional<core::TimeNs> Player::missing_from_ns() {
  std::optional<core::TimeNs> missing;
  for (std::size_t t = 0; t < tasks_.size(); ++t) {
    const Task& task = tasks_[t];
    const bytecode::ImageTask& declared = replicas_->resource().image().tasks[t];
    if (!declared.single.empty() || declared.period_ns <= 0 || task.blocks.empty()) continue;
    const auto block = file_.load(*task.blocks.back());
    if (!block) continue;
    runtime::RecordHead last;
    for_each_record(block->records, [&last](std::span<const std::byte> one) {
      std::memcpy(&last, one.data(), sizeof last);
      return true;
    });
    // A task that was stopped has no further scans to miss.
    if ((last.flags & (runtime::kFaulted | runtime::kCut | runtime::kRevoked)) != 0) continue;
    const core::TimeNs next_ns = time_of(task, last) + declared.period_ns;
    missing = std::min(missing.value_or(next_ns), next_ns);
  }
  return missing;
}

void Player::advance(Task& task) {
  for (;;) {
    task.record = {};
    for_each_record(std::span<const std::byte>(task.block.records).subspan(task.at),
                    [&task](std::span<const std::byte> one) {
                      task.record = one;
                      return false;
                    });
    if (!task.record.empty()) break;
    if (task.next_block == task.blocks.size()) return;
    const BlockInfo& info = *task.blocks[task.next_block++];
    auto block = file_.load(info);
    const auto number = static_cast<std::uint32_t>(&task - tasks_.data());
    if (!block || block->table.size() != replicas_->replica(number).table_bytes()) {
      ++damaged_blocks_;
      continue;
    }
    task.block = std::move(*block);
    task.at = 0;
    task.fresh = true;
    task.gap = task.known ? info.first_scan != task.next_scan : info.first_scan != 0;
  }
  runtime::RecordHead head;
  std::memcpy(&head, task.record.data(), sizeof head);
  task.now_ns = time_of(task, head);
  task.at += task.record.size();
}

void Player::go_to_block(Task& task, std::size_t block) {
  task.next_block = block;
  task.block = {};
  task.at = 0;
  if (block < task.blocks.size()) {
    task.known = true;
    task.next_scan = task.blocks[block]->first_scan;
  }
  advance(task);
}

Player::Task* Player::next_task() {
  Task* next = nullptr;
  for (const std::uint32_t t : replicas_->order()) {
    Task& task = tasks_[t];
    if (!task.record.empty() && (next == nullptr || task.now_ns < next->now_ns)) next = &task;
  }
  return next;
}

std::optional<Player::Upcoming> Player::upcoming() {
  const Task* const next = next_task();
  if (next == nullptr) return {};
  return Upcoming{static_cast<std::uint32_t>(next - tasks_.data()), next->record, !next->gap};
}

std::optional<PlayedScan> Player::step() {
  Task* const next = next_task();
  if (next == nullptr) return {};
  Task& task = *next;
  PlayedScan played;
  played.task = static_cast<std::uint32_t>(next - tasks_.data());
  played.after_gap = std::exchange(task.gap, false);
  std::string before;  // this scan, what is not as the block has it
  // Not loaded earlier: what the scan before it left may still be looked at.
  if (std::exchange(task.fresh, false)) {
    if (!played.after_gap && replicas_->follows(played.task))
      before = replicas_->difference(played.task, task.block.table);
    if (!replicas_->load(played.task, task.block.table)) before = "a value of the table";
  }
  played.outcome = replicas_->run(played.task, task.record);
  if (played.outcome.equal && !before.empty()) {
    played.outcome.equal = false;
    played.outcome.differs = before + ", before the scan,";
  }
  played.scan = replicas_->replica(played.task).head().scan;
  played.now_ns = replicas_->replica(played.task).head().now_ns;
  task.next_scan = played.scan + 1;
  task.known = true;
  advance(task);
  return played;
}

void Player::seek(core::TimeNs now_ns) {
  for (std::uint32_t t = 0; t < tasks_.size(); ++t) {
    Task& task = tasks_[t];
    // The last block that begins before the time is past; the first one when none does.
    const auto after = std::partition_point(task.blocks.begin(), task.blocks.end(),
                                            [now_ns](const BlockInfo* block) { return block->first_ns <= now_ns; });
    const auto block = static_cast<std::size_t>(after - task.blocks.begin());
    go_to_block(task, block == 0 ? 0 : block - 1);
    replicas_->load(t, task.block.table);
  }
  while (next_ns().value_or(now_ns + 1) <= now_ns) step();
}

bool Player::seek(std::uint32_t task, std::uint64_t scan) {
  if (task >= tasks_.size()) return false;
  const auto& blocks = tasks_[task].blocks;
  const auto block = std::find_if(blocks.begin(), blocks.end(), [scan](const BlockInfo* one) {
    return one->first_scan <= scan && scan - one->first_scan < one->scans;
  });
  if (block == blocks.end()) return false;
  seek((*block)->first_ns - 1);
  while (const auto played = step()) {
    if (played->task == task && played->scan >= scan) return played->scan == scan;
  }
  return false;
}

}  // namespace plc::shadow
