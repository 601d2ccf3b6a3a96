#include "shadow/player.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "runtime/link/link.h"
#include "runtime/sched/task.h"

namespace plc::shadow {

core::Result<std::unique_ptr<Player>> Player::make(const RecordFile& file, core::Diagnostics& diagnostics) {
  auto image = bytecode::load(file.head().image);
  if (!image) return image.error();
  auto verified = bytecode::verify(std::move(*image), diagnostics);
  if (!verified) {
    return core::Problem{core::Code::P7630, "the image of the recording is not sound", {}};
  }
  std::unique_ptr<Player> made(new Player(file));
  made->replays_.resize(verified->image().tasks.size());
  runtime::ProgramOptions options;
  options.loop_budget = file.head().loop_budget;
  made->zone_ = core::TimeZone::load(file.head().zone);
  if (made->zone_) options.zone = &*made->zone_;
  auto resource = runtime::Resource::load_replicas(std::move(*verified), made->replays_, options);
  if (!resource) return resource.error();
  made->resource_ = std::move(*resource);
  const bytecode::Image& linked = made->resource_->image();
  made->order_ = runtime::priority_order(linked);
  made->globals_ = linked.global_initial;
  made->tasks_.resize(linked.tasks.size());
  for (std::uint32_t t = 0; t < made->tasks_.size(); ++t)
    made->tasks_[t].replica.emplace(made->resource_->program(t), made->replays_[t]);
  const bytecode::ImageType& globals = linked.types[linked.global_type];
  for (std::uint32_t t = 0; t < made->tasks_.size(); ++t) {
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(linked, linked.tasks[t].body)) {
      for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
        const std::uint32_t bytes = linked.types[globals.fields[f].type].size;
        const bool of_others = !range.exported && !made->resource_->globals().exporters(f).empty();
        if (bytes != 0 && !of_others) made->tasks_[t].seen.push_back({globals.fields[f].offset, bytes});
      }
    }
  }
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
    if (!block || block->table.size() != task.replica->table_bytes()) {
      ++damaged_blocks_;
      continue;
    }
    task.block = std::move(*block);
    task.at = 0;
    task.fresh = true;
    task.gap = task.any ? info.first_scan != task.next_scan : info.first_scan != 0;
  }
  runtime::RecordHead head;
  std::memcpy(&head, task.record.data(), sizeof head);
  task.now_ns = head.now_ns;
  task.at += task.record.size();
}

Player::Task* Player::next_task() {
  Task* next = nullptr;
  for (const std::uint32_t t : order_) {
    Task& task = tasks_[t];
    if (!task.record.empty() && (next == nullptr || task.now_ns < next->now_ns)) next = &task;
  }
  return next;
}

std::optional<PlayedScan> Player::step() {
  Task* const next = next_task();
  if (next == nullptr) return {};
  Task& task = *next;
  PlayedScan played;
  played.task = static_cast<std::uint32_t>(next - tasks_.data());
  played.after_gap = std::exchange(task.gap, false);
  // Not before: what the scan before it left may still be looked at.
  if (std::exchange(task.fresh, false)) task.replica->load(task.block.table);
  played.outcome = task.replica->run(task.record);
  played.scan = task.replica->head().scan;
  played.now_ns = task.replica->head().now_ns;
  task.next_scan = played.scan + 1;
  task.any = true;
  const std::byte* const local = task.replica->program().table().data();
  for (const Task::Part& part : task.seen) std::memcpy(&globals_[part.at], local + part.at, part.bytes);
  advance(task);
  return played;
}

void Player::show_globals() { resource_->globals().reset(globals_); }

}  // namespace plc::shadow
