#include "shadow/follower.h"

#include <utility>

namespace plc::shadow {

core::Result<std::unique_ptr<Follower>> Follower::make(const RecordingHead& head, const Prepare& prepare,
                                                       core::Diagnostics& diagnostics) {
  auto replicas = ReplicaSet::make(head, diagnostics);
  if (!replicas) return replicas.error();
  std::unique_ptr<Follower> made(new Follower);
  made->replicas_ = std::move(*replicas);
  made->tasks_.resize(made->replicas_->task_count());
  if (prepare) prepare(made->replicas_->resource());
  return made;
}

void Follower::found(std::uint32_t task, std::uint64_t scan, std::string what) {
  // What follows in the block differs by it, too.
  if (std::exchange(tasks_[task].differs, true)) return;
  differences_.push_back({task, scan, std::move(what)});
}

void Follower::enter(std::uint32_t task, const BlockBuilder& block) {
  Task& mine = tasks_[task];
  const std::uint64_t first = block.info().first_scan;
  if (mine.in_block && mine.next_scan == first && replicas_->follows(task)) {
    if (std::string what = replicas_->difference(task, block.block().table); !what.empty())
      found(task, first - 1, std::move(what));
  }
  replicas_->load(task, block.block().table);
  mine = {true, first, first, 0, false};
}

bool Follower::follow(std::uint32_t task, const BlockBuilder& block, Deadline deadline) {
  constexpr std::uint32_t kBetweenLooks = 64;  // at the clock, scans
  Task& mine = tasks_[task];
  if (!mine.in_block || mine.first_scan != block.info().first_scan) enter(task, block);
  std::uint32_t scans = 0;
  bool all = true;
  for_each_record(std::span<const std::byte>(block.block().records).subspan(mine.at),
                  [&](std::span<const std::byte> record) {
                    if (deadline && ++scans % kBetweenLooks == 0 && std::chrono::steady_clock::now() > *deadline) {
                      all = false;
                      return false;
                    }
                    mine.at += record.size();
                    const Replica::Outcome outcome = replicas_->run(task, record);
                    if (!outcome.ran) return true;
                    const runtime::RecordHead& head = replicas_->replica(task).head();
                    const std::uint64_t scan = head.scan;
                    mine.next_scan = scan + 1;
                    if (observer_ != nullptr) observer_->after_scan(*replicas_, {task, scan, head.now_ns, head.utc_ns});
                    if (!outcome.equal) found(task, scan, outcome.differs);
                    return true;
                  });
  return all;
}

}  // namespace plc::shadow
