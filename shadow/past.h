// Past: a recording that somebody looks into: any scan of any task, with what a POU had at its probes in it.
//
// In: the bytes of a recording. Out: which scans there are; scans executed again. What leads to a scan runs as it did,
// native where that was asked for; only scans that are looked into run with probes. Threads: one. Does not belong here:
// where recordings come from, drawings.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "shadow/follower.h"
#include "shadow/player.h"
#include "shadow/probe_view.h"

namespace plc::shadow {

class Past {
 public:
  /// P7630 when it is no recording, as Player::make() otherwise. `prepare`: makes what scans run in; may be empty.
  static core::Result<std::unique_ptr<Past>> open(std::vector<std::byte> recording, const Follower::Prepare& prepare);

  [[nodiscard]] runtime::Resource& resource() { return player_->resource(); }
  [[nodiscard]] Player& player() { return *player_; }
  /// `now` of the first and of the last scan; 0 when there is none.
  [[nodiscard]] core::TimeNs begin_ns() const { return player_->begin_ns().value_or(0); }
  [[nodiscard]] core::TimeNs end_ns() const { return player_->end_ns().value_or(0); }

  struct Scans {
    std::uint64_t first = 0, last = 0;
  };
  /// Of a task; nothing when none is here. Not all between them need be.
  [[nodiscard]] std::optional<Scans> scans(std::uint32_t task) const;
  /// The scan of this number, else the last one before it that is here, else the first one.
  [[nodiscard]] std::optional<std::uint64_t> nearest(std::uint32_t task, std::uint64_t scan) const;
  /// The last scan whose `now` is not later, else the first one.
  [[nodiscard]] std::optional<std::uint64_t> scan_at(std::uint32_t task, core::TimeNs now_ns) const;

  /// Executes `scan` of `task`, which nearest() gave, with these views looked at, after what leads to it, and calls
  /// read() with it. False when it is not here, or cannot be looked into.
  bool look(std::uint32_t task, std::uint64_t scan, std::span<const runtime::ProbedPou> views,
            const std::function<void(const runtime::RecordHead&)>& read);
  /// Executes all scans of all tasks with from_ns <= `now` <= until_ns, and calls seen() after each of them; with
  /// nothing before the first one. False from seen(): no more.
  void run(core::TimeNs from_ns, core::TimeNs until_ns, const std::function<bool(const PlayedScan*)>& seen);
  /// The blocks of a task, ascending.
  [[nodiscard]] std::span<const BlockInfo> blocks(std::uint32_t task) const { return blocks_[task]; }

 private:
  explicit Past(RecordFile file) : file_(std::move(file)) {}
  [[nodiscard]] const BlockInfo* block_of(std::uint32_t task, std::uint64_t scan) const;

  RecordFile file_;
  std::unique_ptr<Player> player_;
  std::vector<std::vector<BlockInfo>> blocks_;  ///< by task
  /// What was executed last, while nothing has moved the player since: the next scan needs no way back.
  std::optional<std::pair<std::uint32_t, std::uint64_t>> done_;
};

}  // namespace plc::shadow
