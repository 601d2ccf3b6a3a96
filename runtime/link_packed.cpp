#include "runtime/link_packed.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "runtime/packed_run.h"
#include "runtime/packed_schedule.h"

namespace plc::runtime {
namespace {

constexpr std::size_t kWordBits = 64;
constexpr std::size_t kMostBits = kMostPackedWords * kWordBits;
/// Of a record: a truth table has 64 bits.
constexpr std::size_t kMostInputs = 6;
constexpr std::uint32_t kNone = 0xffffffffu;

/// Processor cycles, measured. A call waits for bytes that were stored just before.
constexpr double kCyclesOfStretch = 20, kCyclesOfRun = 15, kCyclesOfWindow = 12, kCyclesOfSingle = 4;
constexpr std::array<double, kMostPackedWords> kCyclesOfChunk = {7, 10};
constexpr std::array<double, 6> kCyclesOfRecord = {2.5, 2.5, 2.5, 3.4, 3.4, 4};  ///< of a loop over them, by inputs

/// What is read and written at once. Those of a window have one bit in the whole stretch; of the others, each value has
/// one from where it is computed to where it is last read.
struct Cell {
  std::uint32_t operand = 0;
  bool logic = false;             ///< of a record
  bool logic_writes = false;      ///< a record writes it
  std::uint32_t bit = kMostBits;  ///< in a window
  std::uint32_t last = kNone;     ///< value behind the stretch
  [[nodiscard]] bool fixed() const { return bit != kMostBits; }
};

struct Value {
  std::uint32_t cell = 0;
  std::uint32_t writer = kNone;  ///< node; none: from before the stretch
  bool logic = false;            ///< the writer is a record
  bool read_by_other = false;
  std::uint32_t readers = 0;  ///< records
  std::uint32_t bit = kMostBits;
  std::int32_t begin = 0, end = 0;  ///< chunks: that writes it, that reads it last
};

struct Node {
  bool logic = false;
  bool gone = false;  ///< part of its only reader, or read by nobody
  std::uint64_t truth = 0;
  std::vector<std::uint32_t> in, out;  ///< values; a record writes one
  std::uint32_t segment = 0;
};

/// A byte of the table that becomes a bit, or the other way round, at one end of a packed run.
struct Single {
  std::uint32_t segment = 0;
  std::uint32_t value = 0;
};

class Packer {
 public:
  Packer(std::span<const StretchItem> items, std::span<const std::uint32_t> places, std::uint32_t scratch)
      : items_(items), scratch_(scratch) {
    for (const std::uint32_t place : places) cells_.push_back({place});
  }

  std::optional<PackedStretch> pack() {
    read();
    join_records();
    for (std::size_t words = 1; words <= kMostPackedWords; ++words) {
      choose_windows(words);
      place_nodes(words);
      find_lives();
      if (!give_bits(words)) continue;
      PackedStretch packed = words == 1 ? write<1>() : write<2>();
      packed.pays = cycles(words) < cycles_of_loops();
      return packed;
    }
    return std::nullopt;
  }

 private:
  // ---- values

  void read() {
    std::vector<std::uint32_t> now(cells_.size(), kNone);
    const auto new_value = [&](std::uint32_t cell, std::uint32_t writer, bool logic) {
      values_.push_back({cell, writer, logic});
      now[cell] = static_cast<std::uint32_t>(values_.size() - 1);
      return now[cell];
    };
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      const StretchItem& item = items_[i];
      Node node;
      node.logic = item.logic;
      node.truth = item.truth;
      for (const std::uint32_t cell : item.reads) {
        const std::uint32_t value = now[cell] != kNone ? now[cell] : new_value(cell, kNone, false);
        node.in.push_back(value);
        if (item.logic) {
          cells_[cell].logic = true;
        } else {
          values_[value].read_by_other = true;
        }
      }
      if (item.logic) reduce(node);
      for (const std::uint32_t value : node.in) values_[value].readers += item.logic ? 1 : 0;
      for (const std::uint32_t cell : item.writes) {
        node.out.push_back(new_value(cell, i, item.logic));
        if (!item.logic) continue;
        cells_[cell].logic = true;
        cells_[cell].logic_writes = true;
      }
      nodes_.push_back(std::move(node));
    }
    for (std::size_t c = 0; c < cells_.size(); ++c) cells_[c].last = now[c];
  }
  [[nodiscard]] bool is_last(std::uint32_t value) const { return cells_[values_[value].cell].last == value; }

  /// The truth table over `inputs` instead of over those it has: each value has a bit in `index_of`.
  template <class IndexOf>
  static std::uint64_t table_over(std::size_t inputs, IndexOf index_of, std::uint64_t truth) {
    std::uint64_t table = 0;
    for (std::uint32_t index = 0; index < 1u << inputs; ++index) table |= (truth >> index_of(index) & 1u) << index;
    return table;
  }
  /// Each input once, and only those that the result depends on.
  static void reduce(Node& node) {
    std::vector<std::uint32_t> inputs;
    for (const std::uint32_t value : node.in) {
      if (std::find(inputs.begin(), inputs.end(), value) == inputs.end()) inputs.push_back(value);
    }
    set_inputs(node, std::move(inputs));
    for (std::size_t k = node.in.size(); k-- > 0;) {
      const std::uint64_t apart = std::uint64_t{1} << k;
      bool depends = false;
      for (std::uint64_t index = 0; index < std::uint64_t{1} << node.in.size(); ++index) {
        depends = depends || ((node.truth >> index ^ node.truth >> (index ^ apart)) & 1u) != 0;
      }
      if (depends) continue;
      std::vector<std::uint32_t> others = node.in;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      node.truth = table_over(
          others.size(), [k](std::uint32_t index) { return (index & ((1u << k) - 1)) | (index >> k << (k + 1)); },
          node.truth);
      node.in = std::move(others);
    }
  }
  /// `inputs` hold all that the node reads.
  static void set_inputs(Node& node, std::vector<std::uint32_t> inputs) {
    node.truth = table_over(
        inputs.size(), [&](std::uint32_t index) { return index_in(node.in, inputs, index); }, node.truth);
    node.in = std::move(inputs);
  }
  /// The index over values `to`, all of which are in `from`, for an index over `from`.
  static std::uint32_t index_in(const std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& from,
                                std::uint32_t index) {
    std::uint32_t result = 0;
    for (std::size_t k = 0; k < to.size(); ++k) {
      const auto at = std::find(from.begin(), from.end(), to[k]) - from.begin();
      result |= (index >> at & 1u) << k;
    }
    return result;
  }

  /// A record whose result only another one reads becomes part of that, if its inputs are still what they were.
  void join_records() {
    std::vector<std::uint32_t> now(cells_.size(), kNone);
    const auto unchanged = [&](std::uint32_t value) {
      const std::uint32_t current = now[values_[value].cell];
      return current == kNone ? values_[value].writer == kNone : current == value;
    };
    for (Node& node : nodes_) {
      for (std::size_t k = 0; node.logic && k < node.in.size();) {
        const Value& value = values_[node.in[k]];
        const bool alone = value.logic && value.readers == 1 && !value.read_by_other && !is_last(node.in[k]);
        if (alone && std::all_of(nodes_[value.writer].in.begin(), nodes_[value.writer].in.end(), unchanged) &&
            join(node, k, nodes_[value.writer])) {
          k = 0;
        } else {
          ++k;
        }
      }
      for (const std::uint32_t out : node.out) now[values_[out].cell] = out;
    }
    // Whatever nobody reads: from the last one on.
    for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
      if (!node->logic || node->gone) continue;
      const Value& out = values_[node->out[0]];
      if (out.readers != 0 || out.read_by_other || is_last(node->out[0])) continue;
      node->gone = true;
      for (const std::uint32_t value : node->in) --values_[value].readers;
    }
  }
  /// Input `k` of the reader is what `from` computes.
  bool join(Node& reader, std::size_t k, Node& from) {
    std::vector<std::uint32_t> inputs = reader.in;
    inputs.erase(inputs.begin() + static_cast<std::ptrdiff_t>(k));
    const std::size_t before = inputs.size();
    for (const std::uint32_t value : from.in) {
      if (std::find(inputs.begin(), inputs.begin() + static_cast<std::ptrdiff_t>(before), value) ==
          inputs.begin() + static_cast<std::ptrdiff_t>(before)) {
        inputs.push_back(value);
      }
    }
    if (inputs.size() > kMostInputs) return false;
    const std::uint32_t joined = reader.in[k];
    reader.truth = table_over(
        inputs.size(),
        [&](std::uint32_t index) {
          const std::uint32_t result = from.truth >> index_in(from.in, inputs, index) & 1u;
          std::uint32_t old = 0;
          for (std::size_t i = 0; i < reader.in.size(); ++i) {
            const std::uint32_t bit =
                reader.in[i] == joined
                    ? result
                    : index >> (std::find(inputs.begin(), inputs.end(), reader.in[i]) - inputs.begin()) & 1u;
            old |= bit << i;
          }
          return old;
        },
        reader.truth);
    for (const std::uint32_t value : from.in) {
      const auto end = inputs.begin() + static_cast<std::ptrdiff_t>(before);
      if (std::find(inputs.begin(), end, value) != end) --values_[value].readers;
    }
    reader.in = std::move(inputs);
    values_[joined].readers = 0;
    from.gone = true;
    return true;
  }

  // ---- windows

  /// Each window is where most of the records' cells lie that have no bit yet. Where values replace each other that
  /// nobody knows from before the stretch, each has a bit of its own.
  void choose_windows(std::size_t words) {
    std::vector<std::uint32_t> written(cells_.size(), 0);
    std::vector<bool> known(cells_.size(), false);
    for (const Value& value : values_) {
      if (value.logic) ++written[value.cell];
      if (value.writer == kNone && value.readers != 0) known[value.cell] = true;
    }
    std::vector<std::uint32_t> open;
    for (std::uint32_t c = 0; c < cells_.size(); ++c) {
      cells_[c].bit = kMostBits;
      const bool stays = written[c] == 1 && values_[cells_[c].last].logic;
      if (known[c] || stays) open.push_back(c);
    }
    windows_ = 0;
    for (; windows_ < words; ++windows_) {
      std::size_t most = 0;
      std::size_t best = 0;
      for (std::size_t first = 0, end = 0; first < open.size(); ++first) {
        while (end < open.size() && cells_[open[end]].operand - cells_[open[first]].operand < kPackedWindowBytes) ++end;
        if (end - first <= most) continue;
        most = end - first;
        best = first;
      }
      if (most < kPackedWindowBytes / 8) return;
      window_[windows_] = cells_[open[best]].operand;
      for (std::size_t i = best; i != best + most; ++i) {
        cells_[open[i]].bit =
            static_cast<std::uint32_t>(windows_ * kWordBits) + cells_[open[i]].operand - window_[windows_];
      }
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best),
                 open.begin() + static_cast<std::ptrdiff_t>(best + most));
    }
  }

  // ---- order

  [[nodiscard]] bool is_fixed(std::uint32_t value) const { return cells_[values_[value].cell].fixed(); }
  /// Needs a bit for itself.
  [[nodiscard]] bool is_single(std::uint32_t value) const {
    const Value& v = values_[value];
    if (is_fixed(value) || !cells_[v.cell].logic || (v.writer != kNone && nodes_[v.writer].gone)) return false;
    return v.logic || v.readers != 0;
  }
  /// Goes to the table behind the run that computes it.
  [[nodiscard]] bool is_scattered(std::uint32_t value) const {
    const Value& v = values_[value];
    return v.logic && (v.read_by_other || (is_last(value) && !is_fixed(value)));
  }

  void place_nodes(std::size_t words) {
    std::vector<std::uint32_t> number_of(nodes_.size(), kNone), node_of;
    std::vector<ScheduleNode> scheduled;
    std::vector<ScheduleValue> values;
    std::vector<std::uint32_t> value_numbers(values_.size(), kNone);
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      if (!is_single(v)) continue;
      value_numbers[v] = static_cast<std::uint32_t>(values.size());
      values.push_back({values_[v].readers, is_scattered(v)});
    }
    const auto numbers = [&](const std::vector<std::uint32_t>& of) {
      std::vector<std::uint32_t> result;
      for (const std::uint32_t v : of) {
        if (value_numbers[v] != kNone) result.push_back(value_numbers[v]);
      }
      return result;
    };
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      const Node& node = nodes_[n];
      if (node.gone) continue;
      number_of[n] = static_cast<std::uint32_t>(node_of.size());
      node_of.push_back(n);
      scheduled.push_back({node.logic, items_[n].kind, {}, numbers(node.out)});
      if (node.logic) scheduled.back().reads = numbers(node.in);
    }
    std::vector<ScheduleEdge> edges = find_edges();
    for (ScheduleEdge& edge : edges) edge = {number_of[edge.from], number_of[edge.to], edge.delay};
    const auto fixed =
        static_cast<std::size_t>(std::count_if(cells_.begin(), cells_.end(), [](const Cell& c) { return c.fixed(); }));
    segments_ = schedule(scheduled, std::move(edges), std::move(values), words * kWordBits - fixed);
    times_.assign(nodes_.size(), 0);
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      std::int32_t time = segments_[s].first;
      for (std::vector<std::uint32_t>& chunk : segments_[s].chunks) {
        for (std::uint32_t& node : chunk) {
          node = node_of[node];
          nodes_[node].segment = s;
          times_[node] = time;
        }
        ++time;
      }
      for (std::uint32_t& node : segments_[s].others) {
        node = node_of[node];
        nodes_[node].segment = s;
      }
    }
  }

  [[nodiscard]] std::vector<ScheduleEdge> find_edges() const {
    std::vector<ScheduleEdge> edges;
    std::vector<Users> users(cells_.size());
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      const Node& node = nodes_[n];
      if (node.gone) continue;
      for (const std::uint32_t in : node.in) {
        const std::uint32_t from = values_[in].writer;
        if (from != kNone) edges.push_back({from, n, node.logic && nodes_[from].logic ? kPackedDelay : 0});
        users[values_[in].cell].readers[node.logic ? 1 : 0].push_back(n);
      }
      for (const std::uint32_t out : node.out) {
        const std::uint32_t c = values_[out].cell;
        add_writer(n, users[c], cells_[c].fixed(), edges);
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
      wait(users.readers[1], logic ? 1 - kPackedDelay : 0);
      wait(users.writers[1], logic ? 1 : 0);
      users = {};
    }
    users.writers[logic ? 1 : 0].push_back(n);
  }

  // ---- bits

  /// What comes from the table and goes to it, and how long values live.
  void find_lives() {
    gathers_.clear();
    scatters_.clear();
    first_ = kNone;
    last_ = 0;
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      if (segments_[s].chunks.empty()) continue;
      first_ = std::min(first_, s);
      last_ = s;
    }
    for (Value& value : values_) value.begin = value.end = -1;
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      if (!nodes_[n].logic || nodes_[n].gone) continue;
      for (const std::uint32_t in : nodes_[n].in) values_[in].end = std::max(values_[in].end, times_[n]);
    }
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      Value& value = values_[v];
      const Cell& cell = cells_[value.cell];
      value.bit = cell.bit;
      if (!cell.logic || (value.writer != kNone && nodes_[value.writer].gone)) continue;
      if (value.logic) {
        value.begin = times_[value.writer];
        value.end = std::max(value.end, value.begin);
        if (!is_scattered(v)) continue;
        const std::uint32_t segment = nodes_[value.writer].segment;
        scatters_.push_back({segment, v});
        // As long as a chunk of this run could write it.
        value.end = std::max(value.end, segments_[segment].end() - 1 + kPackedDelay);
      } else if (value.writer != kNone || !cell.fixed()) {
        if (value.readers == 0 && !(cell.fixed() && cell.logic_writes)) continue;
        std::uint32_t segment = value.writer == kNone ? first_ : nodes_[value.writer].segment + 1;
        while (segment < segments_.size() && segments_[segment].chunks.empty()) ++segment;
        if (segment >= segments_.size()) continue;
        gathers_.push_back({segment, v});
        // No chunk in front of this run has it.
        value.begin = segments_[segment].first - kPackedDelay;
      }
    }
  }

  /// A bit for each value outside of windows; they use bits one after the other. False when there are not enough.
  bool give_bits(std::size_t words) {
    constexpr std::int32_t kAlways = 0x7fffffff;
    struct Bit {
      std::int32_t begin = -kAlways, end = -kAlways;  // of the value that had it last
    };
    std::array<Bit, kMostBits> bits;
    for (const Cell& cell : cells_) {
      if (cell.fixed()) bits[cell.bit].end = kAlways;
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t v = 0; v < values_.size(); ++v) {
      if (is_single(v)) order.push_back(v);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return values_[a].begin < values_[b].begin; });
    for (const std::uint32_t v : order) {
      Value& value = values_[v];
      std::size_t bit = 0;
      while (bit < words * kWordBits &&
             (bits[bit].end > value.begin + kPackedDelay - 1 || bits[bit].begin >= value.begin)) {
        ++bit;
      }
      if (bit == words * kWordBits) return false;
      value.bit = static_cast<std::uint32_t>(bit);
      bits[bit] = {value.begin, value.end};
    }
    return true;
  }

  // ---- cost

  [[nodiscard]] std::size_t runs() const {
    return static_cast<std::size_t>(
        std::count_if(segments_.begin(), segments_.end(), [](const Segment& s) { return !s.chunks.empty(); }));
  }
  [[nodiscard]] double cycles(std::size_t words) const {
    std::size_t chunks = 0;
    for (const Segment& segment : segments_) chunks += segment.chunks.size();
    return kCyclesOfStretch + kCyclesOfRun * static_cast<double>(runs()) +
           kCyclesOfWindow * static_cast<double>(windows_) +
           kCyclesOfSingle * static_cast<double>(gathers_.size() + scatters_.size()) +
           kCyclesOfChunk[words - 1] * static_cast<double>(chunks);
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
    packed.bits = kWords;
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
  static std::uint64_t bit_of(std::uint32_t bit) { return std::uint64_t{1} << (bit % kWordBits); }

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
    for (const Cell& cell : cells_) {
      if (cell.fixed() && cell.logic_writes) header.written[cell.bit / kWordBits] |= bit_of(cell.bit);
    }
    std::vector<PackedBit> singles;
    for (const Single& gather : gathers_) {
      if (gather.segment != segment) continue;
      const Value& value = values_[gather.value];
      header.gathered[value.bit / kWordBits] |= bit_of(value.bit);
      singles.push_back({cells_[value.cell].operand, value.bit});
      ++header.gathers;
    }
    for (const Single& scatter : scatters_) {
      if (scatter.segment != segment) continue;
      const Value& value = values_[scatter.value];
      singles.push_back({cells_[value.cell].operand, value.bit});
      ++header.scatters;
    }
    put(run, header);
    for (const PackedBit& single : singles) put(run, single);
    for (const std::vector<std::uint32_t>& chunk : segments_[segment].chunks) put(run, chunk_of<kWords>(chunk));
    return run;
  }

  template <std::size_t kWords>
  [[nodiscard]] PackedChunk<kWords> chunk_of(std::vector<std::uint32_t> numbers) const {
    PackedChunk<kWords> chunk;
    const auto out_of = [this](std::uint32_t node) { return values_[nodes_[node].out[0]].bit; };
    // The last one is the lowest bit.
    std::sort(numbers.begin(), numbers.end(), [&](std::uint32_t a, std::uint32_t b) { return out_of(a) > out_of(b); });
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Node& node = nodes_[numbers[i]];
      const std::size_t r = kChunkRecords - numbers.size() + i;
      std::vector<std::uint32_t> in = node.in;  // ascending by bit
      std::sort(in.begin(), in.end(),
                [this](std::uint32_t a, std::uint32_t b) { return values_[a].bit < values_[b].bit; });
      for (const std::uint32_t value : in) {
        const std::uint32_t bit = values_[value].bit;
        chunk.records[r].in[bit / kWordBits] |= bit_of(bit);
        if (bit < kWordBits) ++chunk.inputs[r];
      }
      chunk.records[r].truth = table_over(
          in.size(), [&](std::uint32_t index) { return index_in(node.in, in, index); }, node.truth);
      const std::uint32_t out = out_of(numbers[i]);
      chunk.out[out / kWordBits] |= bit_of(out);
      if (out < kWordBits) ++chunk.outputs;
    }
    return chunk;
  }

  std::span<const StretchItem> items_;
  std::uint32_t scratch_;
  std::vector<Cell> cells_;
  std::vector<Value> values_;
  std::vector<Node> nodes_;  ///< by item
  std::vector<Segment> segments_;
  std::vector<std::int32_t> times_;  ///< by node: its chunk
  std::vector<Single> gathers_, scatters_;
  std::uint32_t first_ = kNone, last_ = 0;  ///< segments that have chunks
  std::array<std::uint32_t, kMostPackedWords> window_{};
  std::size_t windows_ = 0;
};

}  // namespace

std::optional<PackedStretch> pack(std::span<const StretchItem> items, std::span<const std::uint32_t> places,
                                  std::uint32_t scratch) {
  if (packed_run(1) == nullptr) return std::nullopt;
  return Packer(items, places, scratch).pack();
}

}  // namespace plc::runtime
