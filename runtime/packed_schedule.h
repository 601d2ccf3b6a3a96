// Places the instructions of a packed stretch (link_packed.h): boolean records into chunks, everything else between
// runs of chunks. Compile time.
//
// In: which instructions wait for which. Out: segments in the order in which they run. Does not belong here: what the
// instructions are, and which bits they use.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace plc::runtime {

struct ScheduleNode {
  bool logic = false;                        ///< a boolean record
  std::uint32_t kind = 0;                    ///< of everything else: those of one kind run side by side
  std::vector<std::uint32_t> reads, writes;  ///< values that need a bit for some time
};
/// A value that needs a bit from where it is written to where it is last read.
struct ScheduleValue {
  std::uint32_t readers = 0;  ///< records
  bool held = false;          ///< at least to the end of the segment in which it is written
};
/// `to`, which has the higher number, is placed at least `delay` chunks after `from`. Where one of them is not logic,
/// `to` runs behind `from`.
struct ScheduleEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  std::int32_t delay = 0;
};

/// Chunks, and what runs behind them.
struct Segment {
  std::int32_t first = 0;  ///< time of the first chunk; chunks follow each other, segments are apart
  std::vector<std::vector<std::uint32_t>> chunks;  ///< nodes; at most kChunkRecords each
  std::vector<std::uint32_t> others;               ///< nodes that are not logic, in order
  [[nodiscard]] std::int32_t end() const { return first + static_cast<std::int32_t>(chunks.size()); }
};

/// Nodes are numbered in an order in which they may run. `bits`: how many values may be there at a time; more if there
/// is no other way. `gap`: chunks between two segments, by which results are there.
std::vector<Segment> schedule(std::span<const ScheduleNode> nodes, std::vector<ScheduleEdge> edges,
                              std::vector<ScheduleValue> values, std::size_t bits, std::int32_t gap);

}  // namespace plc::runtime
