#include "runtime/link_packed.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "runtime/packed_columns.h"
#include "runtime/packed_run.h"
#include "runtime/packed_schedule.h"

namespace plc::runtime {
namespace {

constexpr std::size_t kWordBits = 64;
constexpr std::uint32_t kMostBits = kMostPackedWords * kWordBits;

/// Processor cycles, measured. A call waits for bytes that were stored just before.
constexpr double kCyclesOfStretch = 20, kCyclesOfRun = 15, kCyclesOfWindow = 12, kCyclesOfSingle = 4;
constexpr double kCyclesOfChunk[kMostPackedWords][2] = {{7.5, 5.5}, {10, 7}};    ///< with a delay of 2, of 3
constexpr std::array<double, 6> kCyclesOfRecord = {2.5, 2.5, 2.5, 3.4, 3.4, 4};  ///< of a loop over them, by inputs

/// A window with fewer cells costs more than they do one by one.
constexpr std::size_t kFewestInWindow = 8;

/// Where a value is, from where it is written to where it is read last. Cells of a window have one bit in the whole
/// stretch; of the others, each value has its own.
struct Life {
  std::uint32_t bit = kMostBits;
  std::int32_t begin = -1, end = -1;  ///< chunks
};
struct Place {
  std::uint32_t segment = 0;
  std::int32_t time = 0;  ///< of a record: its chunk
};

/// A byte of the table that becomes a bit, or the other way round, at one end of a packed run.
struct Single {
  std::uint32_t segment = 0;
  std::uint32_t value = 0;
};

class Packer {
 public:
  Packer(std::span<const StretchItem> items, std::span<const std::uint32_t> places, std::uint32_t scratch)
      : items_(items),
        scratch_(scratch),
        logic_(items, places),
        cells_(logic_.cells()),
        values_(logic_.values()),
        nodes_(logic_.nodes()) {}

  std::optional<PackedStretch> pack() {
    logic_.join_records();
    try_forms();
    if (logic_.shorten_ways()) try_forms();
    return std::move(best_);
  }

 private:
  void try_forms() {
    bool fits = false;
    for (std::size_t words = 1; words <= kMostPackedWords && !fits; ++words) {
      choose_windows(words);
      if (bits_at_first() > words * kWordBits) continue;
      for (const std::int32_t delay : {2, 3}) {
        form_ = {words, delay};
        place_nodes();
        if (!order_second_window()) continue;
        find_lives();
        if (!give_bits()) continue;
        fits = true;
        if (best_ && cycles() >= cycles_) continue;
        cycles_ = cycles();
        best_ = words == 1 ? write<1>() : write<2>();
        best_->pays = cycles_ < cycles_of_loops();
      }
    }
  }

  // ---- windows

  /// The windows together hold as many of the records' cells as windows can. Where values replace each other that
  /// nobody knows from before the stretch, each has a bit of its own.
  void choose_windows(std::size_t words) {
    std::vector<std::uint32_t> written(cells_.size(), 0);
    std::vector<bool> known(cells_.size(), false);
    for (const PackedValue& value : values_) {
      if (value.logic) ++written[value.cell];
      if (value.writer == kNoNumber && value.readers != 0) known[value.cell] = true;
    }
    std::vector<std::uint32_t> open;
    bits_.assign(cells_.size(), kMostBits);
    for (std::uint32_t c = 0; c < cells_.size(); ++c) {
      const bool stays = written[c] == 1 && values_[cells_[c].last].logic;
      if (known[c] || stays) open.push_back(c);
    }
    // The window at each of them: where it ends, and which of those from here on holds most.
    std::vector<std::size_t> end(open.size() + 1, open.size()), fullest = end;
    const auto held = [&end](std::size_t window) {
      const std::size_t cells = end[window] - window;
      return cells < kFewestInWindow ? 0 : cells;
    };
    std::size_t first = open.size();
    const auto held_with_next = [&](std::size_t window) {
      return held(window) + (words == 2 ? held(fullest[end[window]]) : 0);
    };
    for (std::size_t i = open.size(); i-- != 0;) {
      end[i] = end[i + 1];
      while (cells_[open[end[i] - 1]].operand - cells_[open[i]].operand >= kPackedWindowBytes) --end[i];
      fullest[i] = held(i) >= held(fullest[i + 1]) ? i : fullest[i + 1];
      if (held_with_next(i) >= held_with_next(first)) first = i;
    }
    windows_ = 0;
    window_ = {};
    for (const std::size_t window : {first, words == 2 ? fullest[end[first]] : open.size()}) {
      if (held(window) == 0) continue;
      window_[windows_] = cells_[open[window]].operand;
      for (std::size_t i = window; i != end[window]; ++i) {
        bits_[open[i]] = static_cast<std::uint32_t>(windows_ * kWordBits) + cells_[open[i]].operand - window_[windows_];
      }
      ++windows_;
    }
  }

  /// That hold something when the stretch begins.
  [[nodiscard]] std::size_t bits_at_first() const {
    std::size_t bits = bits_.size() - static_cast<std::size_t>(std::count(bits_.begin(), bits_.end(), kMostBits));
    for (std::uint32_t v = 0; v < values_.size(); ++v) bits += is_single(v) && values_[v].writer == kNoNumber ? 1 : 0;
    return bits;
  }

  // ---- order

  [[nodiscard]] bool is_in_window(std::uint32_t cell) const { return bits_[cell] != kMostBits; }
  [[nodiscard]] bool is_fixed(std::uint32_t value) const { return is_in_window(values_[value].cell); }
  /// Needs a bit for itself.
  [[nodiscard]] bool is_single(std::uint32_t value) const {
    const PackedValue& v = values_[value];
    if (is_fixed(value) || !cells_[v.cell].logic || (v.writer != kNoNumber && nodes_[v.writer].gone)) return false;
    return v.logic || v.readers != 0;
  }
  /// Goes to the table behind the run that computes it.
  [[nodiscard]] bool is_scattered(std::uint32_t value) const {
    const PackedValue& v = values_[value];
    return v.logic && (v.read_by_other || (logic_.is_last(value) && !is_fixed(value)));
  }

  void place_nodes() {
    std::vector<std::uint32_t> number_of(nodes_.size(), kNoNumber), node_of;
    std::vector<ScheduleNode> scheduled;
    std::vector<ScheduleValue> values;
    std::vector<std::uint32_t> value_numbers(values_.size(), kNoNumber);
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      if (!is_single(v)) continue;
      value_numbers[v] = static_cast<std::uint32_t>(values.size());
      values.push_back({values_[v].readers, is_scattered(v)});
    }
    const auto numbers = [&](const std::vector<std::uint32_t>& of) {
      std::vector<std::uint32_t> result;
      for (const std::uint32_t v : of) {
        if (value_numbers[v] != kNoNumber) result.push_back(value_numbers[v]);
      }
      return result;
    };
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      const PackedNode& node = nodes_[n];
      if (node.gone) continue;
      number_of[n] = static_cast<std::uint32_t>(node_of.size());
      node_of.push_back(n);
      scheduled.push_back({node.logic, items_[n].kind, {}, numbers(node.out)});
      if (node.logic) scheduled.back().reads = numbers(node.in);
    }
    std::vector<ScheduleEdge> edges = find_edges();
    for (ScheduleEdge& edge : edges) edge = {number_of[edge.from], number_of[edge.to], edge.delay};
    const auto single = static_cast<std::size_t>(std::count(bits_.begin(), bits_.end(), kMostBits));
    const std::size_t free = form_.words * kWordBits - (cells_.size() - single);
    segments_ = schedule(scheduled, std::move(edges), std::move(values), free, form_.delay);
    places_.assign(nodes_.size(), {});
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      std::int32_t time = segments_[s].first;
      for (std::vector<std::uint32_t>& chunk : segments_[s].chunks) {
        for (std::uint32_t& node : chunk) {
          node = node_of[node];
          places_[node] = {s, time};
        }
        ++time;
      }
      for (std::uint32_t& node : segments_[s].others) {
        node = node_of[node];
        places_[node].segment = s;
      }
    }
  }

  [[nodiscard]] std::vector<ScheduleEdge> find_edges() const {
    std::vector<ScheduleEdge> edges;
    std::vector<Users> users(cells_.size());
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      const PackedNode& node = nodes_[n];
      if (node.gone) continue;
      for (const std::uint32_t in : node.in) {
        const std::uint32_t from = values_[in].writer;
        if (from != kNoNumber) edges.push_back({from, n, node.logic && nodes_[from].logic ? form_.delay : 0});
        users[values_[in].cell].readers[node.logic ? 1 : 0].push_back(n);
      }
      for (const std::uint32_t out : node.out) {
        const std::uint32_t c = values_[out].cell;
        add_writer(n, users[c], is_in_window(c), edges);
      }
    }
    return edges;
  }
  /// Of a cell so far, as far as others wait for them; not logic, logic.
  struct Users {
    std::vector<std::uint32_t> readers[2], writers[2];
  };
  void add_writer(std::uint32_t n, Users& users, bool fixed, std::vector<ScheduleEdge>& edges) const {
    const bool logic = nodes_[n].logic;
    const auto wait = [&](const std::vector<std::uint32_t>& nodes, std::int32_t delay) {
      for (const std::uint32_t node : nodes) {
        if (node != n) edges.push_back({node, n, delay});
      }
    };
    wait(users.readers[0], 0);
    wait(users.writers[0], 0);
    // Records on values that have bits of their own do not wait for each other.
    const bool apart = logic && !fixed;
    if (!apart) {
      wait(users.readers[1], logic ? 1 - form_.delay : 0);
      wait(users.writers[1], logic ? 1 : 0);
      users = {};
    }
    users.writers[logic ? 1 : 0].push_back(n);
  }

  // ---- columns

  static std::uint64_t column_of(std::uint32_t bit) { return std::uint64_t{1} << (bit % kWordBits); }

  /// Visits each input of a record: its value, its chunk.
  template <class Visit>
  void for_inputs(Visit visit) const {
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      if (!nodes_[n].logic || nodes_[n].gone) continue;
      for (const std::uint32_t value : nodes_[n].in) visit(value, static_cast<std::size_t>(places_[n].time));
    }
  }

  /// Gives the second window's bytes bits in columns that the chunks which read them need for nothing else.
  bool order_second_window() {
    columns_.assign(static_cast<std::size_t>(segments_.back().end()), 0);
    take_columns(0);
    if (windows_ < 2) return true;
    std::array<std::uint64_t, kPackedWindowBytes> blocked{};
    for_inputs([&](std::uint32_t value, std::size_t chunk) {
      const std::uint32_t cell = values_[value].cell;
      if (is_of_word(cell, 1)) blocked[cells_[cell].operand - window_[1]] |= columns_[chunk];
    });
    const std::optional<WindowBits> bits = order_window(blocked);
    if (!bits) return false;
    bit_of_byte_ = *bits;
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
      if (is_of_word(cell, 1)) bits_[cell] = kWordBits + bit_of_byte_[cells_[cell].operand - window_[1]];
    }
    take_columns(1);
    return true;
  }
  [[nodiscard]] bool is_of_word(std::uint32_t cell, std::uint32_t word) const {
    return is_in_window(cell) && bits_[cell] / kWordBits == word;
  }
  void take_columns(std::uint32_t word) {
    for_inputs([&](std::uint32_t value, std::size_t chunk) {
      const std::uint32_t cell = values_[value].cell;
      if (is_of_word(cell, word)) columns_[chunk] |= column_of(bits_[cell]);
    });
  }

  // ---- bits

  /// What comes from the table and goes to it, and how long values live.
  void find_lives() {
    gathers_.clear();
    scatters_.clear();
    first_ = kNoNumber;
    last_ = 0;
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      if (segments_[s].chunks.empty()) continue;
      first_ = std::min(first_, s);
      last_ = s;
    }
    lives_.assign(values_.size(), {});
    for_inputs([&](std::uint32_t value, std::size_t chunk) {
      lives_[value].end = std::max(lives_[value].end, static_cast<std::int32_t>(chunk));
    });
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      const PackedValue& value = values_[v];
      const PackedCell& cell = cells_[value.cell];
      Life& life = lives_[v];
      life.bit = bits_[value.cell];
      if (!cell.logic || (value.writer != kNoNumber && nodes_[value.writer].gone)) continue;
      if (value.logic) {
        const auto [segment, time] = places_[value.writer];
        life.begin = time;
        life.end = std::max(life.end, time);
        if (!is_scattered(v)) continue;
        scatters_.push_back({segment, v});
        // As long as a chunk of this run could write it.
        life.end = std::max(life.end, segments_[segment].end() - 1 + form_.delay);
      } else if (value.writer != kNoNumber || !is_fixed(v)) {
        if (value.readers == 0 && !(is_fixed(v) && cell.logic_writes)) continue;
        std::uint32_t segment = value.writer == kNoNumber ? first_ : places_[value.writer].segment + 1;
        while (segment < segments_.size() && segments_[segment].chunks.empty()) ++segment;
        if (segment >= segments_.size()) continue;
        gathers_.push_back({segment, v});
        // No chunk in front of this run has it.
        life.begin = segments_[segment].first - form_.delay;
      }
    }
  }

  /// A bit for each value outside of windows; they use bits one after the other. False when there are not enough.
  bool give_bits() {
    constexpr std::int32_t kAlways = 0x7fffffff;
    struct Bit {
      std::int32_t begin = -kAlways, end = -kAlways;  // of the value that had it last
    };
    std::array<Bit, kMostBits> bits;
    for (const std::uint32_t bit : bits_) {
      if (bit != kMostBits) bits[bit].end = kAlways;
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      if (is_single(v)) order.push_back(v);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return lives_[a].begin < lives_[b].begin; });
    std::vector<std::vector<std::size_t>> chunks(values_.size());
    for_inputs([&](std::uint32_t value, std::size_t chunk) { chunks[value].push_back(chunk); });
    for (const std::uint32_t v : order) {
      Life& life = lives_[v];
      std::uint64_t blocked = 0;
      for (const std::size_t chunk : chunks[v]) blocked |= columns_[chunk];
      std::uint32_t bit = 0;
      while (bit < form_.words * kWordBits && (bits[bit].end > life.begin + form_.delay - 1 ||
                                               bits[bit].begin >= life.begin || (blocked & column_of(bit)) != 0)) {
        ++bit;
      }
      if (bit == form_.words * kWordBits) return false;
      life.bit = bit;
      bits[bit] = {life.begin, life.end};
      for (const std::size_t chunk : chunks[v]) columns_[chunk] |= column_of(bit);
    }
    return true;
  }

  // ---- cost

  [[nodiscard]] std::size_t runs() const {
    return static_cast<std::size_t>(
        std::count_if(segments_.begin(), segments_.end(), [](const Segment& s) { return !s.chunks.empty(); }));
  }
  [[nodiscard]] double cycles() const {
    std::size_t chunks = 0;
    for (const Segment& segment : segments_) chunks += segment.chunks.size();
    return kCyclesOfStretch + kCyclesOfRun * static_cast<double>(runs()) +
           kCyclesOfWindow * static_cast<double>(windows_) +
           kCyclesOfSingle * static_cast<double>(gathers_.size() + scatters_.size()) +
           kCyclesOfChunk[form_.words - 1][form_.delay - 2] * static_cast<double>(chunks);
  }
  /// Other instructions cut them in as many runs.
  [[nodiscard]] double cycles_of_loops() const {
    double cycles = kCyclesOfRun * static_cast<double>(runs());
    for (const StretchItem& item : items_) {
      if (item.logic) cycles += kCyclesOfRecord[item.reads.size()];
    }
    return cycles;
  }

  // ---- writing

  template <std::size_t kWords>
  PackedStretch write() const {
    PackedStretch packed;
    packed.form = form_;
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      if (!segments_[s].chunks.empty()) packed.steps.push_back(run_of<kWords>(s));
      if (!segments_[s].others.empty()) packed.steps.push_back({segments_[s].others, 0, {}});
    }
    return packed;
  }

  template <class T>
  static void put(PackedStep& run, const T& value) {
    const std::size_t at = run.words.size();
    run.words.resize(at + sizeof value / sizeof(std::uint32_t));
    std::memcpy(run.words.data() + at, &value, sizeof value);
  }

  template <std::size_t kWords>
  [[nodiscard]] PackedStep run_of(std::uint32_t segment) const {
    PackedStep run;
    run.chunks = static_cast<std::uint32_t>(segments_[segment].chunks.size());
    PackedHeader header;
    header.begins = segment == first_ ? 1 : 0;
    header.ends = segment == last_ ? 1 : 0;
    header.state = scratch_;
    header.windows = static_cast<std::uint32_t>(windows_);
    std::copy(window_.begin(), window_.end(), header.window);
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
      if (!is_in_window(cell) || !cells_[cell].logic_writes) continue;
      const std::size_t word = bits_[cell] / kWordBits;
      header.written[word] |= std::uint64_t{1} << (cells_[cell].operand - window_[word]);
    }
    std::vector<PackedBit> singles;
    for (const Single& gather : gathers_) {
      if (gather.segment != segment) continue;
      const std::uint32_t bit = lives_[gather.value].bit;
      header.gathered[bit / kWordBits] |= column_of(bit);
      singles.push_back({logic_.cell_of(gather.value).operand, bit});
      ++header.gathers;
    }
    for (const Single& scatter : scatters_) {
      if (scatter.segment != segment) continue;
      singles.push_back({logic_.cell_of(scatter.value).operand, lives_[scatter.value].bit});
      ++header.scatters;
    }
    put(run, header);
    if (kWords == 2) put(run, order());
    for (const PackedBit& single : singles) put(run, single);
    for (const std::vector<std::uint32_t>& chunk : segments_[segment].chunks) put(run, chunk_of<kWords>(chunk));
    return run;
  }

  [[nodiscard]] PackedOrder order() const {
    PackedOrder order;
    for (std::uint32_t byte = 0; byte < kPackedWindowBytes; ++byte) {
      const std::uint8_t bit = bit_of_byte_[byte];
      order.bit_of_byte[byte] = bit % kLaneBytes;
      order.byte_of_bit[bit] = byte % kLaneBytes;
    }
    return order;
  }

  template <std::size_t kWords>
  [[nodiscard]] PackedChunk<kWords> chunk_of(std::vector<std::uint32_t> numbers) const {
    PackedChunk<kWords> chunk;
    const auto out_of = [this](std::uint32_t node) { return lives_[nodes_[node].out[0]].bit; };
    // The last one is the lowest bit.
    std::sort(numbers.begin(), numbers.end(), [&](std::uint32_t a, std::uint32_t b) { return out_of(a) > out_of(b); });
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const PackedNode& node = nodes_[numbers[i]];
      PackedRecord& record = chunk.records[kChunkRecords - numbers.size() + i];
      std::vector<std::uint32_t> in = node.in;  // ascending by column
      std::sort(in.begin(), in.end(), [this](std::uint32_t a, std::uint32_t b) {
        return lives_[a].bit % kWordBits < lives_[b].bit % kWordBits;
      });
      for (const std::uint32_t value : in) {
        const std::uint32_t bit = lives_[value].bit;
        record.in |= column_of(bit);
        if constexpr (kWords == 2) chunk.from_first |= bit < kWordBits ? column_of(bit) : 0;
      }
      record.truth = truth_over(node, in);
      const std::uint32_t out = out_of(numbers[i]);
      if (out < kWordBits) {
        chunk.out |= column_of(out);
        if constexpr (kWords == 2) ++chunk.first_outputs;
      } else if constexpr (kWords == 2) {
        chunk.second_out |= column_of(out);
      }
    }
    return chunk;
  }

  std::span<const StretchItem> items_;
  std::uint32_t scratch_;
  PackedLogic logic_;
  const std::vector<PackedCell>& cells_;
  const std::vector<PackedValue>& values_;
  const std::vector<PackedNode>& nodes_;  ///< by item
  PackedForm form_;
  std::vector<std::uint32_t> bits_;  ///< by cell: its bit, in a window
  std::vector<Segment> segments_;
  std::vector<Place> places_;           ///< by node
  std::vector<Life> lives_;             ///< by value
  std::vector<std::uint64_t> columns_;  ///< by chunk: those of its inputs
  WindowBits bit_of_byte_{};            ///< of the second window
  std::vector<Single> gathers_, scatters_;
  std::uint32_t first_ = kNoNumber, last_ = 0;  ///< segments that have chunks
  std::array<std::uint32_t, kMostPackedWords> window_{};
  std::size_t windows_ = 0;
  std::optional<PackedStretch> best_;
  double cycles_ = 0;  ///< of the best one
};

}  // namespace

std::optional<PackedStretch> pack(std::span<const StretchItem> items, std::span<const std::uint32_t> places,
                                  std::uint32_t scratch) {
  if (packed_run({}) == nullptr) return std::nullopt;
  return Packer(items, places, scratch).pack();
}

}  // namespace plc::runtime
