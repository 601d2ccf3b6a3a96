// Replayed: every scan of every task of a resource is recorded, and executed again alone, in any engine, from its
// record; whatever differs is a fault.
//
// In: a resource that runs, the engine of the replicas. Out: after each scan what differs between table, events, fault
// and record, in words. Does not belong here: files of records.
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/record/recorder.h"
#include "runtime/record/replay.h"
#include "tests/support/engines.h"

namespace plc::test {

class Replayed {
 public:
  /// Begins with the tables as they are. Null, and why, when the linker or the engine refuses a replica.
  static std::unique_ptr<Replayed> make(const bytecode::VerifiedImage& image, runtime::Resource& resource,
                                        const runtime::ProgramOptions& options, const Engine& engine,
                                        std::string& problem, std::size_t most_record_bytes = kMostBytes) {
    std::unique_ptr<Replayed> made(new Replayed(resource));
    for (std::uint32_t t = 0; t < resource.task_count(); ++t) {
      Task& task = *made->tasks_.emplace_back(std::make_unique<Task>());
      auto ring = runtime::RecordRing::make(kRingBytes, most_record_bytes);
      if (!ring) return refuse(ring.error(), problem);
      task.ring = std::move(*ring);
      runtime::Program& program = resource.program(t);
      task.recorder.emplace(*task.ring, std::span(program.table().data(), program.table().layout().total));
      auto replica = runtime::Program::link_replica(image, t, task.replay, options);
      if (!replica) return refuse(replica.error(), problem);
      task.replica = std::move(*replica);
      if (engine.compile) {
        auto compiled = engine.compile(*task.replica);
        if (!compiled) return refuse(compiled.error(), problem);
        task.replica->install(std::move(*compiled));
      }
      made->load(t);
      program.set_recorder(&*task.recorder);
    }
    return made;
  }
  ~Replayed() {
    for (std::uint32_t t = 0; t < tasks_.size(); ++t) resource_.program(t).set_recorder(nullptr);
  }
  Replayed(const Replayed&) = delete;
  Replayed& operator=(const Replayed&) = delete;

  /// The table of the task now is what the next scan begins with.
  void load(std::uint32_t t) {
    Task& task = *tasks_[t];
    load_whole(task, t);
  }

  /// Executes again what was recorded since the last call. What differs, or an empty text. Between scans of the task.
  std::string check(std::uint32_t t) {
    std::size_t scans = 0;
    if (std::string different = follow(t, &scans); !different.empty()) return different;
    if (scans == 0) return "nothing was recorded";
    if (std::string different = difference(t); !different.empty()) return different;
    return load_whole(*tasks_[t], t) ? "" : "the table has what no table may have";
  }
  /// The same, without a look at the table of the task, which may run.
  std::string follow(std::uint32_t t, std::size_t* scans = nullptr) {
    Task& task = *tasks_[t];
    for (auto record = task.ring->next(); !record.empty(); record = task.ring->next()) {
      runtime::RecordHead head;
      std::memcpy(&head, record.data(), sizeof head);
      if (head.kind != runtime::RecordKind::kScan) continue;
      bytes_ += head.bytes;
      if (scans != nullptr) ++*scans;
      if (std::string different = check(task, record); !different.empty()) return different;
    }
    return {};
  }
  /// Changes each record of a scan before it is executed: leaves out what a hook that is not there would not have told.
  void change_records(std::function<std::vector<std::byte>(std::span<const std::byte>)> change) {
    change_ = std::move(change);
  }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  runtime::Recorder& recorder(std::uint32_t t) { return *tasks_[t]->recorder; }
  runtime::RecordRing& ring(std::uint32_t t) { return *tasks_[t]->ring; }
  runtime::Program& replica(std::uint32_t t) { return *tasks_[t]->replica; }
  /// One record in the replica of a task.
  std::string execute(std::uint32_t t, std::span<const std::byte> record) { return check(*tasks_[t], record); }
  /// Where the tables of a task and its replica differ, or an empty text.
  std::string difference(std::uint32_t t) {
    const std::byte* const x = resource_.program(t).table().data();
    const std::byte* const y = tasks_[t]->replica->table().data();
    const std::size_t size = tasks_[t]->replica->table().layout().total;
    const auto [at, other] = std::mismatch(x, x + size, y);
    if (at == x + size) return {};
    return "byte " + std::to_string(at - x) + " of the table is " + std::to_string(static_cast<int>(*at)) +
           ", executed again " + std::to_string(static_cast<int>(*other));
  }

 private:
  static constexpr std::size_t kRingBytes = 1 << 20;
  static constexpr std::size_t kMostBytes = 256 * 1024;
  struct Task {
    std::unique_ptr<runtime::RecordRing> ring;
    std::optional<runtime::Recorder> recorder;
    runtime::Replay replay;
    std::unique_ptr<runtime::Program> replica;
  };

  explicit Replayed(runtime::Resource& resource) : resource_(resource) {}
  static std::unique_ptr<Replayed> refuse(const core::Problem& why, std::string& problem) {
    problem = why.message;
    return nullptr;
  }
  /// False when the types of the table refuse it.
  bool load_whole(Task& task, std::uint32_t t) {
    return task.replay.load({resource_.program(t).table().data(), task.replica->table().layout().total});
  }
  std::string check(Task& task, std::span<const std::byte> record) {
    std::vector<std::byte> changed;
    if (change_) {
      changed = change_(record);
      record = changed;
    }
    task.replay.begin(record);
    const runtime::RecordHead& head = task.replay.head();
    const std::uint64_t before = task.replica->event_total();
    const runtime::Fault fault = task.replica->execute({head.now_ns, head.start_ns, head.utc_ns});
    const runtime::RecordedFault found{static_cast<std::uint32_t>(fault.kind), fault.pou, fault.word, fault.taskblock};
    if (!(task.replay.fault() == (fault ? found : runtime::RecordedFault{}))) return "another fault";
    if (!task.replay.finished()) return "the record does not fit the scan";
    if (task.replica->event_total() - before != head.events) return "other events";
    const std::span<const std::byte> table(task.replica->table().data(), task.replica->table().layout().total);
    if (runtime::check_of_slice(table, head.slice) != head.check) {
      return "bytes from " + std::to_string(head.slice * runtime::kSliceBytes) + " on of the table after scan " +
             std::to_string(head.scan);
    }
    return {};
  }

  runtime::Resource& resource_;
  std::vector<std::unique_ptr<Task>> tasks_;
  std::function<std::vector<std::byte>(std::span<const std::byte>)> change_;
  std::uint64_t bytes_ = 0;
};

}  // namespace plc::test
