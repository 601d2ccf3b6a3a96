#include "runtime/packed_schedule.h"

#include <algorithm>
#include <utility>

#include "runtime/packed_run.h"

namespace plc::runtime {
namespace {

/// Chunks that run in the time of an instruction that is not logic.
constexpr std::int32_t kChunksOfOther = 2;

/// List scheduling: each chunk takes the records that most others wait for, among those whose results have a bit.
class Scheduler {
 public:
  Scheduler(std::span<const ScheduleNode> nodes, std::vector<ScheduleEdge> edges, std::vector<ScheduleValue> values,
            std::size_t bits, std::int32_t gap)
      : nodes_(nodes), edges_(std::move(edges)), values_(std::move(values)), gap_(gap) {
    // Those from before the stretch have theirs from the beginning.
    std::vector<bool> is_written(values_.size(), false);
    for (const ScheduleNode& node : nodes) {
      for (const std::uint32_t value : node.writes) is_written[value] = true;
    }
    free_ = static_cast<std::ptrdiff_t>(bits) - std::count(is_written.begin(), is_written.end(), false);
    std::sort(edges_.begin(), edges_.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
    waits_.assign(nodes.size(), 0);
    earliest_.assign(nodes.size(), 0);
    first_edge_.assign(nodes.size() + 1, 0);
    for (const ScheduleEdge& edge : edges_) {
      ++waits_[edge.to];
      ++first_edge_[edge.from + 1];
    }
    for (std::size_t i = 1; i < first_edge_.size(); ++i) first_edge_[i] += first_edge_[i - 1];
    heights_.assign(nodes.size(), 0);
    for (auto edge = edges_.rbegin(); edge != edges_.rend(); ++edge) {
      const std::int32_t behind = heights_[edge->to] + edge->delay + (nodes_[edge->to].logic ? 0 : kChunksOfOther);
      heights_[edge->from] = std::max(heights_[edge->from], behind);
    }
  }

  std::vector<Segment> run() {
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      if (waits_[n] == 0) ready_[nodes_[n].logic ? 1 : 0].push_back(n);
    }
    std::vector<std::uint32_t>& others = ready_[0];
    std::vector<std::uint32_t>& logic = ready_[1];
    std::vector<Segment> segments(1);
    while (!others.empty() || !logic.empty()) {
      if (logic.empty() || (!others.empty() && highest(others) >= highest(logic))) {
        release_held();
        while (!others.empty()) put_others(segments.back());
        time_ += gap_;
        segments.emplace_back().first = time_;
      } else {
        put_chunk(segments.back());
      }
    }
    return segments;
  }

 private:
  [[nodiscard]] std::int32_t highest(const std::vector<std::uint32_t>& ready) const {
    std::int32_t highest = 0;
    for (const std::uint32_t n : ready) highest = std::max(highest, heights_[n]);
    return highest;
  }

  void put_others(Segment& segment) {
    std::vector<std::uint32_t> now = std::exchange(ready_[0], {});
    std::stable_sort(now.begin(), now.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return nodes_[a].kind < nodes_[b].kind; });
    for (const std::uint32_t n : now) {
      segment.others.push_back(n);
      placed(n);
    }
  }

  /// Whether there is a bit for what the record computes.
  [[nodiscard]] bool fits(std::uint32_t node) const {
    std::ptrdiff_t needed = static_cast<std::ptrdiff_t>(nodes_[node].writes.size());
    for (const std::uint32_t value : nodes_[node].reads) {
      if (values_[value].readers == 1 && !values_[value].held) --needed;
    }
    return needed <= 0 || needed <= free_;
  }
  void take_bits(std::uint32_t node) {
    for (const std::uint32_t value : nodes_[node].reads) {
      if (--values_[value].readers == 0 && !values_[value].held) ++free_;
    }
    for (const std::uint32_t value : nodes_[node].writes) {
      --free_;
      if (values_[value].held) held_.push_back(value);
    }
  }
  void release_held() {
    for (const std::uint32_t value : held_) {
      values_[value].held = false;
      if (values_[value].readers == 0) ++free_;
    }
    held_.clear();
  }

  void put_chunk(Segment& segment) {
    std::vector<std::uint32_t>& ready = ready_[1];
    std::vector<std::uint32_t>& chunk = segment.chunks.emplace_back();
    while (chunk.size() < kChunkRecords) {
      auto best = ready.end(), without_bit = ready.end();
      for (auto r = ready.begin(); r != ready.end(); ++r) {
        if (earliest_[*r] > time_) continue;
        auto& better = fits(*r) ? best : without_bit;
        if (better == ready.end() || heights_[*r] > heights_[*better]) better = r;
      }
      // Nothing else can run, now or later.
      if (best == ready.end() && chunk.empty()) best = without_bit;
      if (best == ready.end()) break;
      const std::uint32_t node = *best;
      ready.erase(best);
      chunk.push_back(node);
      placed(node);
    }
    ++time_;
  }

  void placed(std::uint32_t node) {
    take_bits(node);
    for (std::uint32_t e = first_edge_[node]; e != first_edge_[node + 1]; ++e) {
      const ScheduleEdge& edge = edges_[e];
      earliest_[edge.to] = std::max(earliest_[edge.to], time_ + edge.delay);
      if (--waits_[edge.to] == 0) ready_[nodes_[edge.to].logic ? 1 : 0].push_back(edge.to);
    }
  }

  std::span<const ScheduleNode> nodes_;
  std::vector<ScheduleEdge> edges_;
  std::vector<std::uint32_t> waits_, first_edge_;  ///< by node: how many it waits for; its edges
  std::vector<std::int32_t> earliest_, heights_;   ///< by node: chunk; chunks that follow at least
  std::vector<std::uint32_t> ready_[2];            ///< others, logic
  std::vector<ScheduleValue> values_;              ///< what is left of them
  std::vector<std::uint32_t> held_;                ///< written in this segment
  std::int32_t gap_;
  std::ptrdiff_t free_ = 0;  ///< bits
  std::int32_t time_ = 0;
};

}  // namespace

std::vector<Segment> schedule(std::span<const ScheduleNode> nodes, std::vector<ScheduleEdge> edges,
                              std::vector<ScheduleValue> values, std::size_t bits, std::int32_t gap) {
  return Scheduler(nodes, std::move(edges), std::move(values), bits, gap).run();
}

}  // namespace plc::runtime
