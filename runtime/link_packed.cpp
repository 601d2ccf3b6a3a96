#include "runtime/link_packed.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "runtime/packed_run.h"

namespace plc::runtime {
namespace {

constexpr std::size_t kWordBits = 64;
constexpr std::size_t kMostBits = kMostPackedWords * kWordBits;
/// Longer ones never have so few variables that this pays.
constexpr std::size_t kMostRecords = 1024;
constexpr std::int32_t kNever = -1;
/// A result can be read two chunks later, see packed_run.h.
constexpr std::int32_t kDelay = 2;

/// Processor cycles, measured. A call waits for bytes that were stored just before.
constexpr std::size_t kCyclesOfCall = 35, kCyclesOfWindow = 12, kCyclesOfSingle = 4;
constexpr std::array<std::size_t, kMostPackedWords> kCyclesOfChunk = {7, 10};
constexpr std::array<double, 6> kCyclesOfRecord = {2.5, 2.5, 2.5, 3.4, 3.4, 4};  ///< of a loop over them, by inputs

/// What has a bit for itself: a byte of the table in the whole run, or one value of scratch memory.
struct Cell {
  std::uint32_t operand = 0;
  bool scratch = false;
  bool read_first = false;          ///< comes from the table
  bool needed = false;              ///< goes to the table
  std::int32_t written = kNever;    ///< scratch: the chunk that writes it
  std::int32_t last_read = kNever;  ///< scratch: the last chunk that reads it
  std::uint32_t bit = kMostBits;
};

struct Record {
  std::uint32_t truth = 0;
  std::vector<std::uint32_t> in;  ///< cells
  std::uint32_t out = 0;          ///< cell
  std::uint32_t height = 0;       ///< chunks that follow at least
  std::int32_t chunk = kNever;
};

/// `to` runs at least `delay` chunks after `from`.
struct Edge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  std::int32_t delay = 0;
};

class Packer {
 public:
  std::optional<PackedWords> pack(std::span<const LogicRecord> records) {
    if (!read(records)) return std::nullopt;
    place_in_chunks();
    for (std::size_t words = 1; words <= kMostPackedWords; ++words) {
      choose_windows(words);
      const bool pays = saves(words, records);
      if (!give_bits(words)) continue;
      PackedWords packed = words == 1 ? write<1>() : write<2>();
      packed.pays = pays;
      return packed;
    }
    return std::nullopt;
  }

 private:
  // ---- reading

  /// False when there are too many variables.
  bool read(std::span<const LogicRecord> records) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> cell_of;  // operand, its cell now; few of them
    std::vector<std::int32_t> writer;                              // by cell
    std::vector<std::vector<std::uint32_t>> readers;               // by cell, since it was written
    const auto new_cell = [&](std::uint32_t operand, bool scratch) {
      cells_.push_back({operand, scratch});
      writer.push_back(kNever);
      readers.emplace_back();
      return static_cast<std::uint32_t>(cells_.size() - 1);
    };
    const auto find = [&](std::uint32_t operand) {
      return std::find_if(cell_of.begin(), cell_of.end(), [&](const auto& c) { return c.first == operand; });
    };
    for (std::uint32_t i = 0; i < records.size(); ++i) {
      const LogicRecord& from = records[i];
      Record record;
      record.truth = from.record.truth;
      for (std::size_t k = 0; k < from.inputs; ++k) {
        auto at = find(from.record.in[k]);
        if (at == cell_of.end()) {
          cell_of.emplace_back(from.record.in[k], new_cell(from.record.in[k], false));
          at = cell_of.end() - 1;
        }
        const std::uint32_t cell = at->second;
        if (writer[cell] == kNever) {
          cells_[cell].read_first = true;
        } else {
          edges_.push_back({static_cast<std::uint32_t>(writer[cell]), i, kDelay});
        }
        readers[cell].push_back(i);
        record.in.push_back(cell);
      }
      auto at = find(from.record.out);
      if (at == cell_of.end()) {
        cell_of.emplace_back(from.record.out, new_cell(from.record.out, from.scratch));
        at = cell_of.end() - 1;
      } else if (from.scratch) {
        at->second = new_cell(from.record.out, true);
      }
      record.out = at->second;
      if (cell_of.size() > kMostBits) return false;
      if (writer[record.out] != kNever) edges_.push_back({static_cast<std::uint32_t>(writer[record.out]), i, 1});
      for (const std::uint32_t reader : readers[record.out]) {
        if (reader != i) edges_.push_back({reader, i, 1 - kDelay});
      }
      writer[record.out] = static_cast<std::int32_t>(i);
      readers[record.out].clear();
      cells_[record.out].needed = from.needed;
      records_.push_back(std::move(record));
    }
    return true;
  }

  // ---- order

  /// List scheduling: each chunk takes the records that most others wait for.
  void place_in_chunks() {
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) { return a.from < b.from; });
    for (auto edge = edges_.rbegin(); edge != edges_.rend(); ++edge) {
      const auto behind = static_cast<std::int32_t>(records_[edge->to].height) + edge->delay;
      records_[edge->from].height =
          std::max(records_[edge->from].height, static_cast<std::uint32_t>(std::max(behind, 0)));
    }
    std::vector<std::uint32_t> waits(records_.size(), 0), first_edge(records_.size() + 1, 0);
    std::vector<std::int32_t> earliest(records_.size(), 0);
    for (const Edge& edge : edges_) {
      ++waits[edge.to];
      ++first_edge[edge.from + 1];
    }
    for (std::size_t i = 1; i < first_edge.size(); ++i) first_edge[i] += first_edge[i - 1];
    std::vector<std::uint32_t> ready;
    for (std::uint32_t i = 0; i < records_.size(); ++i) {
      if (waits[i] == 0) ready.push_back(i);
    }
    std::size_t left = records_.size();
    for (std::int32_t chunk = 0; left != 0; ++chunk) {
      chunks_.emplace_back();
      while (chunks_.back().size() < kChunkRecords) {
        auto best = ready.end();
        for (auto r = ready.begin(); r != ready.end(); ++r) {
          if (earliest[*r] <= chunk && (best == ready.end() || records_[*r].height > records_[*best].height)) best = r;
        }
        if (best == ready.end()) break;
        const std::uint32_t record = *best;
        ready.erase(best);
        chunks_.back().push_back(record);
        records_[record].chunk = chunk;
        --left;
        for (std::uint32_t e = first_edge[record]; e != first_edge[record + 1]; ++e) {
          const Edge& edge = edges_[e];
          // Not before: a chunk does not look back at those in front of it.
          earliest[edge.to] = std::max(earliest[edge.to], std::max(chunk + edge.delay, chunk - 1));
          if (--waits[edge.to] == 0) ready.push_back(edge.to);
        }
      }
    }
    for (const Record& record : records_) {
      cells_[record.out].written = std::max(cells_[record.out].written, record.chunk);
      for (const std::uint32_t cell : record.in) {
        cells_[cell].last_read = std::max(cells_[cell].last_read, record.chunk);
      }
    }
  }

  // ---- bits

  /// Each window is where most of the table's cells lie that have none yet.
  void choose_windows(std::size_t words) {
    for (Cell& cell : cells_) cell.bit = kMostBits;
    windows_ = 0;
    for (; windows_ < words; ++windows_) {
      std::vector<std::uint32_t> operands;
      for (const Cell& cell : cells_) {
        if (!cell.scratch && cell.bit == kMostBits) operands.push_back(cell.operand);
      }
      std::sort(operands.begin(), operands.end());
      std::size_t most = 0;
      for (std::size_t first = 0, end = 0; first < operands.size(); ++first) {
        while (end < operands.size() && operands[end] - operands[first] < kPackedWindowBytes) ++end;
        if (end - first <= most) continue;
        most = end - first;
        window_[windows_] = operands[first];
      }
      if (most < kPackedWindowBytes / 8) return;
      for (Cell& cell : cells_) {
        const std::uint32_t bit = cell.operand - window_[windows_];
        if (!cell.scratch && cell.bit == kMostBits && bit < kPackedWindowBytes) {
          cell.bit = static_cast<std::uint32_t>(windows_ * kWordBits) + bit;
        }
      }
    }
  }

  /// Windows are chosen.
  [[nodiscard]] bool saves(std::size_t words, std::span<const LogicRecord> records) const {
    double loop = 0;
    for (const LogicRecord& record : records) loop += kCyclesOfRecord[record.inputs];
    std::size_t cycles = kCyclesOfCall + windows_ * kCyclesOfWindow + chunks_.size() * kCyclesOfChunk[words - 1];
    for (const Cell& cell : cells_) {
      if (cell.bit == kMostBits)
        cycles += (std::size_t{is_read(cell)} + std::size_t{is_written(cell)}) * kCyclesOfSingle;
    }
    return static_cast<double>(cycles) < loop;
  }
  static bool is_read(const Cell& cell) { return cell.read_first; }
  static bool is_written(const Cell& cell) { return cell.written != kNever && cell.needed; }

  /// A bit for each cell outside of windows; values of scratch memory use bits one after the other. False when there
  /// are not enough.
  bool give_bits(std::size_t words) {
    constexpr std::int32_t kAlways = 0x7fffffff;
    struct Bit {
      std::int32_t written = -kAlways, last_read = -kAlways;  // of the cell that had it last
    };
    std::array<Bit, kMostBits> bits;
    for (const Cell& cell : cells_) {
      if (cell.bit != kMostBits) bits[cell.bit].last_read = kAlways;
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].bit == kMostBits) order.push_back(i);
    }
    const auto begin = [this](std::uint32_t i) { return cells_[i].scratch ? cells_[i].written : kNever; };
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return begin(a) < begin(b); });
    for (const std::uint32_t i : order) {
      Cell& cell = cells_[i];
      const std::int32_t written = begin(i);
      std::size_t bit = 0;
      while (bit < words * kWordBits && (bits[bit].last_read > written + kDelay - 1 || bits[bit].written >= written)) {
        ++bit;
      }
      if (bit == words * kWordBits) return false;
      cell.bit = static_cast<std::uint32_t>(bit);
      const bool to_the_end = !cell.scratch || cell.needed;
      bits[bit] = {written, to_the_end ? kAlways : std::max(cell.last_read, written)};
    }
    return true;
  }

  // ---- writing

  template <class T>
  void put(PackedWords& packed, const T& value) const {
    const std::size_t at = packed.words.size();
    packed.words.resize(at + sizeof value / sizeof(std::uint32_t));
    std::memcpy(packed.words.data() + at, &value, sizeof value);
  }
  [[nodiscard]] bool in_window(const Cell& cell) const {
    return !cell.scratch && cell.bit / kWordBits < windows_ &&
           cell.operand - window_[cell.bit / kWordBits] == cell.bit % kWordBits;
  }

  template <std::size_t kWords>
  PackedWords write() const {
    PackedWords packed;
    packed.bits = kWords;
    packed.chunks = static_cast<std::uint32_t>(chunks_.size());
    PackedHeader header;
    header.windows = static_cast<std::uint32_t>(windows_);
    std::copy(window_.begin(), window_.end(), header.window);
    std::vector<PackedBit> gathers, scatters;
    for (const Cell& cell : cells_) {
      const std::uint64_t bit = std::uint64_t{1} << (cell.bit % kWordBits);
      if (in_window(cell)) {
        if (is_written(cell)) header.written[cell.bit / kWordBits] |= bit;
        continue;
      }
      if (is_read(cell)) {
        header.gathered[cell.bit / kWordBits] |= bit;
        gathers.push_back({cell.operand, cell.bit});
      }
      if (is_written(cell)) scatters.push_back({cell.operand, cell.bit});
    }
    header.gathers = static_cast<std::uint32_t>(gathers.size());
    header.scatters = static_cast<std::uint32_t>(scatters.size());
    put(packed, header);
    for (const PackedBit& gather : gathers) put(packed, gather);
    for (const PackedBit& scatter : scatters) put(packed, scatter);
    for (const std::vector<std::uint32_t>& chunk : chunks_) put(packed, chunk_of<kWords>(chunk));
    return packed;
  }

  template <std::size_t kWords>
  [[nodiscard]] PackedChunk<kWords> chunk_of(std::vector<std::uint32_t> numbers) const {
    PackedChunk<kWords> chunk;
    // The last one is the lowest bit.
    std::sort(numbers.begin(), numbers.end(), [this](std::uint32_t a, std::uint32_t b) {
      return cells_[records_[a].out].bit > cells_[records_[b].out].bit;
    });
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Record& record = records_[numbers[i]];
      const std::size_t r = kChunkRecords - numbers.size() + i;
      std::vector<std::uint32_t> bits;
      for (const std::uint32_t cell : record.in) bits.push_back(cells_[cell].bit);
      std::sort(bits.begin(), bits.end());
      bits.erase(std::unique(bits.begin(), bits.end()), bits.end());
      for (const std::uint32_t bit : bits) {
        chunk.records[r].in[bit / kWordBits] |= std::uint64_t{1} << (bit % kWordBits);
        if (bit < kWordBits) ++chunk.inputs[r];
      }
      chunk.records[r].truth = truth_of(record, bits);
      const std::uint32_t out = cells_[record.out].bit;
      chunk.out[out / kWordBits] |= std::uint64_t{1} << (out % kWordBits);
      if (out < kWordBits) ++chunk.outputs;
    }
    return chunk;
  }
  /// The truth table over `bits`, ascending, instead of over the record's inputs.
  [[nodiscard]] std::uint64_t truth_of(const Record& record, const std::vector<std::uint32_t>& bits) const {
    std::uint64_t truth = 0;
    for (std::uint32_t index = 0; index < 1u << bits.size(); ++index) {
      std::uint32_t old = 0;
      for (std::size_t k = 0; k < record.in.size(); ++k) {
        const auto at = std::lower_bound(bits.begin(), bits.end(), cells_[record.in[k]].bit) - bits.begin();
        old |= (index >> at & 1u) << k;
      }
      truth |= std::uint64_t{record.truth >> old & 1u} << index;
    }
    return truth;
  }

  std::vector<Cell> cells_;
  std::vector<Record> records_;
  std::vector<Edge> edges_;
  std::vector<std::vector<std::uint32_t>> chunks_;
  std::array<std::uint32_t, kMostPackedWords> window_{};
  std::size_t windows_ = 0;
};

}  // namespace

std::optional<PackedWords> pack(std::span<const LogicRecord> records) {
  if (records.size() > kMostRecords || packed_run(1) == nullptr) return std::nullopt;
  return Packer{}.pack(records);
}

}  // namespace plc::runtime
