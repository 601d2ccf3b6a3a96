#include "shadow/past.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace plc::shadow {

core::Result<std::unique_ptr<Past>> Past::open(std::vector<std::byte> recording, const Follower::Prepare& prepare) {
  auto file = RecordFile::read(std::move(recording), "memory");
  if (!file) return file.error();
  std::unique_ptr<Past> made(new Past(std::move(*file)));
  core::Diagnostics diagnostics;
  auto player = Player::make(made->file_, diagnostics);
  if (!player) return player.error();
  made->player_ = std::move(*player);
  if (prepare) prepare(made->resource());
  made->blocks_.resize(made->player_->replicas().task_count());
  for (const BlockInfo& block : made->file_.blocks()) {
    if (block.task < made->blocks_.size() && block.scans != 0) made->blocks_[block.task].push_back(block);
  }
  for (std::vector<BlockInfo>& blocks : made->blocks_) {
    std::stable_sort(blocks.begin(), blocks.end(),
                     [](const BlockInfo& a, const BlockInfo& b) { return a.first_scan < b.first_scan; });
  }
  return made;
}

std::optional<Past::Scans> Past::scans(std::uint32_t task) const {
  if (task >= blocks_.size() || blocks_[task].empty()) return {};
  const BlockInfo& last = blocks_[task].back();
  return Scans{blocks_[task].front().first_scan, last.first_scan + last.scans - 1};
}

const BlockInfo* Past::block_of(std::uint32_t task, std::uint64_t scan) const {
  const std::vector<BlockInfo>& blocks = blocks_[task];
  const auto after = std::partition_point(blocks.begin(), blocks.end(),
                                          [scan](const BlockInfo& block) { return block.first_scan <= scan; });
  return after == blocks.begin() ? nullptr : &*(after - 1);
}

std::optional<std::uint64_t> Past::nearest(std::uint32_t task, std::uint64_t scan) const {
  const auto all = scans(task);
  if (!all) return {};
  const BlockInfo* const block = block_of(task, scan);
  if (block == nullptr) return all->first;
  return std::min(scan, block->first_scan + block->scans - 1);
}

std::optional<std::uint64_t> Past::scan_at(std::uint32_t task, core::TimeNs now_ns) const {
  const auto all = scans(task);
  if (!all) return {};
  const std::vector<BlockInfo>& blocks = blocks_[task];
  const auto after = std::partition_point(blocks.begin(), blocks.end(),
                                          [now_ns](const BlockInfo& block) { return block.first_ns <= now_ns; });
  if (after == blocks.begin()) return all->first;
  const auto block = file_.load(*(after - 1));
  std::uint64_t found = (after - 1)->first_scan;
  if (!block) return found;
  for_each_record(std::span<const std::byte>(block->records), [&](std::span<const std::byte> record) {
    runtime::RecordHead head;
    std::memcpy(&head, record.data(), sizeof head);
    if (head.now_ns > now_ns) return false;
    found = head.scan;
    return true;
  });
  return found;
}

bool Past::look(std::uint32_t task, std::uint64_t scan, std::span<const runtime::ProbedPou> views,
                const std::function<void(const runtime::RecordHead&)>& read) {
  if (task >= blocks_.size()) return false;
  const BlockInfo* const block = block_of(task, scan);
  if (block == nullptr || scan - block->first_scan >= block->scans) return false;
  const auto done = std::exchange(done_, std::nullopt);
  if (!done || done->first != task || done->second >= scan || done->second + 1 < block->first_scan)
    player_->seek(block->first_ns - 1);
  runtime::Program& program = resource().program(task);
  while (const auto next = player_->upcoming()) {
    runtime::RecordHead head;
    std::memcpy(&head, next->record.data(), sizeof head);
    if (next->task != task || head.scan < scan) {
      player_->step();
      continue;
    }
    if (head.scan != scan || program.look_at(views)) return false;
    const auto played = player_->step();
    if (played && played->outcome.ran) read(head);
    static_cast<void>(program.look_at({}));
    done_ = {task, scan};
    return played && played->outcome.ran;
  }
  return false;
}

void Past::run(core::TimeNs from_ns, core::TimeNs until_ns, const std::function<bool(const PlayedScan*)>& seen) {
  done_.reset();
  player_->seek(from_ns - 1);
  if (!seen(nullptr)) return;
  while (player_->next_ns().value_or(until_ns + 1) <= until_ns) {
    const auto played = player_->step();
    if (!played || !seen(&*played)) return;
  }
}

}  // namespace plc::shadow
