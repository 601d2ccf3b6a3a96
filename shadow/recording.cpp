#include "shadow/recording.h"

#include <cstring>

namespace plc::shadow {

using runtime::RecordHead;
using runtime::RecordKind;

core::Result<std::unique_ptr<Recording>> Recording::start(runtime::Resource& resource, Sink sink,
                                                          const RecordingOptions& options) {
  std::unique_ptr<Recording> made(new Recording(resource, std::move(sink), options));
  for (std::uint32_t t = 0; t < resource.task_count(); ++t) {
    Task& task = *made->tasks_.emplace_back(std::make_unique<Task>());
    CrashMemory* const crash = options.crash_memory;
    auto ring = runtime::RecordRing::make(options.ring_bytes, options.most_record_bytes,
                                          crash != nullptr ? crash->ring_file(t) : -1);
    if (!ring) return ring.error();
    task.ring = std::move(*ring);
    runtime::Program& program = resource.program(t);
    const std::span<std::byte> table(program.table().data(), program.table().layout().total);
    task.recorder.emplace(*task.ring, table);
    made->begin(t, 0, table);
    program.set_recorder(&*task.recorder);
  }
  return made;
}

Recording::~Recording() {
  for (std::uint32_t t = 0; t < tasks_.size(); ++t) resource_.program(t).set_recorder(nullptr);
}

void Recording::drain() {
  for (std::uint32_t t = 0; t < tasks_.size(); ++t) {
    runtime::RecordRing& ring = *tasks_[t]->ring;
    for (auto record = ring.next(); !record.empty(); record = ring.next()) take(t, record);
  }
}

void Recording::take(std::uint32_t t, std::span<const std::byte> record) {
  Task& task = *tasks_[t];
  RecordHead head;
  std::memcpy(&head, record.data(), sizeof head);
  switch (head.kind) {
    case RecordKind::kScan: {
      faults_ += (head.flags & runtime::kFaulted) != 0 ? 1 : 0;
      if (!task.block.open()) break;
      if (task.block.empty()) task.block_began_ns = head.now_ns;
      const bool follows = task.block.add(record);
      // A scan whose loops were cut cannot be executed again, nor what follows it.
      if (!follows || (head.flags & runtime::kCut) != 0) {
        flush(task);
        ++task.gaps;
      }
      if (task.block.record_bytes() >= options_.block_bytes || head.now_ns - task.block_began_ns >= options_.block_ns)
        task.recorder->ask();
      break;
    }
    case RecordKind::kLost:
      if (task.block.open()) ++task.gaps;
      flush(task);
      break;
    case RecordKind::kCheckpointed:
      flush(task);
      begin(t, head.scan, task.recorder->checkpoint());
      task.recorder->give_back();
      break;
  }
  if (!task.block.open()) task.recorder->ask();
}

void Recording::begin(std::uint32_t t, std::uint64_t first_scan, std::span<const std::byte> table) {
  Task& task = *tasks_[t];
  task.block.begin(t, first_scan, table);
  if (options_.crash_memory != nullptr) options_.crash_memory->begin_block(t, first_scan, task.ring->position(), table);
}

void Recording::flush(Task& task) {
  if (!task.block.open()) return;
  if (before_end_) before_end_(task.block.info().task);
  if (!task.block.empty()) {
    std::vector<std::byte> bytes = task.block.pack();
    task.stored_bytes += bytes.size();
    if (!bytes.empty()) sink_(task.block.info(), std::move(bytes));
  }
  task.block.close();
}

void Recording::finish() {
  drain();
  for (const auto& task : tasks_) flush(*task);
}

RecordingCounts Recording::counts(std::uint32_t t) const {
  const Task& task = *tasks_[t];
  return {task.recorder->scans(), task.recorder->lost(), task.recorder->bytes(), task.stored_bytes, task.gaps};
}

}  // namespace plc::shadow
