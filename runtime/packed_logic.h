// What a packed stretch (link_packed.h) computes: its values, and the records that read and write them, as few and as
// little dependent on each other as can be. Compile time.
//
// In: instructions in an order in which they may run. Out: the same, where a record may have taken over what others
// computed for it. Does not belong here: when records run, and where values lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace plc::runtime {

/// No value, no node.
inline constexpr std::uint32_t kNoNumber = 0xffffffffu;
/// Of a record: a truth table has 64 bits.
inline constexpr std::size_t kMostPackedInputs = 6;

/// A cell is a range of bytes that are always used together; those of records are one byte.
struct StretchItem {
  bool logic = false;                 ///< a boolean record
  std::uint32_t kind = 0;             ///< of another instruction: those of one kind should run side by side
  std::uint32_t truth = 0;            ///< of a record, over its inputs
  std::vector<std::uint32_t> reads;   ///< cells; of a record, its inputs, at most 5
  std::vector<std::uint32_t> writes;  ///< cells, each once; of a record, one
};

struct PackedCell {
  std::uint32_t operand = 0;
  bool logic = false;              ///< of a record
  bool logic_writes = false;       ///< a record writes it
  std::uint32_t last = kNoNumber;  ///< value behind the stretch
};

/// What a cell holds from where it is written to where it is written again.
struct PackedValue {
  std::uint32_t cell = 0;
  std::uint32_t writer = kNoNumber;  ///< node; none: from before the stretch
  bool logic = false;                ///< the writer is a record
  bool read_by_other = false;
  std::uint32_t readers = 0;  ///< records
};

/// An item, with the same number.
struct PackedNode {
  bool logic = false;
  bool gone = false;                   ///< part of its readers, or read by nobody
  std::uint64_t truth = 0;             ///< over `in`
  std::vector<std::uint32_t> in, out;  ///< values; a record writes one
};

class PackedLogic {
 public:
  /// `places`: operands of the cells.
  PackedLogic(std::span<const StretchItem> items, std::span<const std::uint32_t> places);

  /// A record whose result only another one reads becomes part of that, if its inputs are still what they were.
  void join_records();
  /// A record computes itself what it would have to wait for, as far as it can: small ladders take as long as the
  /// longest way from record to record, not as there are records. False when nothing has changed.
  bool shorten_ways();

  [[nodiscard]] const std::vector<PackedCell>& cells() const { return cells_; }
  [[nodiscard]] const std::vector<PackedValue>& values() const { return values_; }
  [[nodiscard]] const std::vector<PackedNode>& nodes() const { return nodes_; }
  [[nodiscard]] const PackedCell& cell_of(std::uint32_t value) const { return cells_[values_[value].cell]; }
  /// The value is in its cell behind the stretch.
  [[nodiscard]] bool is_last(std::uint32_t value) const { return cell_of(value).last == value; }

 private:
  template <class Visit>
  void for_records(Visit visit);
  [[nodiscard]] bool is_needed(std::uint32_t value) const;
  [[nodiscard]] const PackedNode& writer_of(std::uint32_t value) const { return nodes_[values_[value].writer]; }
  bool join(PackedNode& reader, const std::vector<std::uint32_t>& joined);
  void remove(PackedNode& node);

  std::vector<PackedCell> cells_;
  std::vector<PackedValue> values_;
  std::vector<PackedNode> nodes_;
};

/// The truth table of a record over `inputs`, which are at least all that it has.
std::uint64_t truth_over(const PackedNode& record, const std::vector<std::uint32_t>& inputs);

}  // namespace plc::runtime
