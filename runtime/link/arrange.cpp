#include "runtime/link/arrange.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "runtime/interpreter/bool_run.h"
#include "runtime/interpreter/operations.h"
#include "runtime/interpreter/value_runs.h"
#include "runtime/link/link_bool.h"
#include "stdlib/library.h"

namespace plc::runtime {
namespace {

/// Instructions that are arranged at once: scratch memory bounds it, and the compile time of what is quadratic.
constexpr std::size_t kMostItems = kScratchBytes / sizeof(std::uint64_t);
/// Boolean records with fewer inputs join those with more when no more than these are ready.
constexpr std::size_t kFewRecords = 8;

/// Instructions after which the value of one has been stored.
constexpr std::size_t kLatency = 3;

constexpr std::uint32_t kLiveIn = 0xffffffffu;

/// What is executed by one loop: boolean records by their number of inputs, blocks of one type, instructions of one
/// opcode.
struct Kind {
  enum class Form : std::uint8_t { kRecords, kBlocks, kValues } form = Form::kValues;
  std::uint64_t what = 0;  ///< inputs; the step; ResolvedOp
  friend auto operator<=>(const Kind&, const Kind&) = default;
};

/// One instruction, or one record of boolean logic.
struct Item {
  std::uint32_t kind = 0;                  ///< into kinds
  std::uint32_t truth = 0;                 ///< of a record
  std::uint8_t inputs = 0;                 ///< operands after the first
  std::array<std::uint32_t, 6> operand{};  ///< out, inputs; of a block, its place
  std::array<std::uint32_t, 6> bytes{};
};

/// Instructions of one kind that wait for no other. Those whose inputs have been stored for a while come first: loads
/// wait for stores that are not done; among them, those that most others wait for in line.
class Ready {
 public:
  /// `at`: when its inputs are there; never before those pushed earlier.
  void push(std::uint32_t item, std::size_t at) { later_.emplace_back(at, item); }
  [[nodiscard]] std::size_t size() const { return now_.size() + later_.size(); }
  void advance(std::size_t now, const std::vector<std::uint32_t>& heights) {
    while (!later_.empty() && later_.front().first <= now) {
      now_.push_back(later_.front().second);
      std::push_heap(now_.begin(), now_.end(), Lower{heights});
      later_.pop_front();
    }
  }
  [[nodiscard]] std::uint32_t highest(const std::vector<std::uint32_t>& heights) const {
    std::uint32_t highest = now_.empty() ? 0 : heights[now_.front()];
    for (const auto& [at, item] : later_) highest = std::max(highest, heights[item]);
    return highest;
  }
  /// Both have some.
  [[nodiscard]] bool better_than(const Ready& other, const std::vector<std::uint32_t>& heights) const {
    if (now_.empty() != other.now_.empty()) return other.now_.empty();
    return now_.empty() ? later_.front() < other.later_.front() : Lower{heights}(other.now_.front(), now_.front());
  }
  std::uint32_t pop(const std::vector<std::uint32_t>& heights) {
    if (now_.empty()) {
      const std::uint32_t item = later_.front().second;
      later_.pop_front();
      return item;
    }
    std::pop_heap(now_.begin(), now_.end(), Lower{heights});
    const std::uint32_t item = now_.back();
    now_.pop_back();
    return item;
  }

 private:
  struct Lower {
    const std::vector<std::uint32_t>& heights;
    bool operator()(std::uint32_t x, std::uint32_t y) const {
      return heights[x] != heights[y] ? heights[x] < heights[y] : x > y;
    }
  };
  std::vector<std::uint32_t> now_;  ///< heap
  std::deque<std::pair<std::size_t, std::uint32_t>> later_;
};

/// Loops for two, four and five inputs: the fewer, the fewer loads.
std::uint32_t inputs_of(std::uint32_t truth) {
  if (!ignores_last_input(truth)) return 5;
  const auto ignores = [truth](std::uint32_t mask, unsigned shift) { return ((truth >> shift ^ truth) & mask) == 0; };
  return ignores(0x00ff, 8) && ignores(0x0f0f, 4) ? 2 : 4;
}

class Arranger {
 public:
  Arranger(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch)
      : words_(words), code_(code), scratch_(scratch) {
    for (const stdlib::BlockSpec& block : stdlib::blocks()) {
      blocks_.emplace(reinterpret_cast<std::uint64_t>(block.step), &block);
    }
  }

  void arrange(const LinkedBlock& block) {
    addressing_ = block.addressing;
    const std::size_t start = words_.size();
    const std::size_t arranged = code_.arranged.size();
    Program::LinkReport report = code_.report;
    std::size_t before = 0;  // runs in the order of the code
    std::optional<std::uint32_t> kind;
    items_.clear();
    const auto add = [&](const Item& item) {
      if (item.kind != kind) ++before;
      kind = item.kind;
      if (items_.size() == kMostItems) arrange_items();
      items_.push_back(item);
    };
    std::size_t i = block.first;
    for (; code_.instructions[i].position != block.end; ++i) read(code_.instructions[i], add);
    arrange_items();
    if ((code_.report.runs - report.runs) * 4 > before * 3) {
      words_.resize(start);
      code_.arranged.resize(arranged);
      code_.report = report;
      return;
    }
    if (code_.instructions[i].op == ResolvedOp::kReturn) {
      put_handler(ResolvedOp::kReturn);
    } else {
      put_handler(ResolvedOp::kJump);
      words_.push_back(block.end);
    }
    words_[block.position + 1] = static_cast<std::uint32_t>(start);
  }

 private:
  // ---- reading

  std::uint32_t kind_number(Kind kind) {
    const auto [at, is_new] = kind_numbers_.try_emplace(kind, static_cast<std::uint32_t>(kinds_.size()));
    if (is_new) kinds_.push_back(kind);
    return at->second;
  }

  template <class Add>
  void read(const LinkedInstruction& instruction, Add add) {
    // A copy: arranging what is there already makes the code longer.
    const std::uint32_t position = instruction.position;
    const auto word = [&](std::uint32_t i) { return words_[position + i]; };
    switch (instruction.op) {
      case ResolvedOp::kBoolRun4:
      case ResolvedOp::kBoolRun5: {
        const std::uint32_t count = word(1), window = word(2), records = word(3);
        for (std::uint32_t r = 0; r < count; ++r) {
          const auto record = load_field<ShortRecord>(
              reinterpret_cast<const unsigned char*>(words_.data() + records + std::size_t{r} * kShortRecordWords));
          std::array<std::uint32_t, 5> in{};
          for (std::size_t k = 0; k < in.size(); ++k) in[k] = window + record.in[k];
          add(record_item(record.truth, window + record.out, in));
        }
        return;
      }
      case ResolvedOp::kBoolRun: {
        const std::uint32_t count = word(1);
        for (std::uint32_t r = 0; r < count; ++r) {
          const auto record = load<GeneralRecord>(words_.data() + position + 2 + std::size_t{r} * kGeneralRecordWords);
          add(record_item(record.truth, record.out, std::to_array(record.in)));
        }
        return;
      }
      case ResolvedOp::kRunTb: {
        const auto step = load<std::uint64_t>(words_.data() + position + 1);
        Item item;
        item.kind = kind_number({Kind::Form::kBlocks, step});
        item.operand[0] = word(3);
        item.bytes[0] = blocks_.at(step)->size;
        add(item);
        return;
      }
      default: {
        const ValueOp& op = *value_op(instruction.op);
        Item item;
        item.kind = kind_number({Kind::Form::kValues, static_cast<std::uint64_t>(instruction.op)});
        item.inputs = op.inputs;
        for (std::uint32_t i = 0; i <= op.inputs; ++i) {
          item.operand[i] = word(op.first + i);
          item.bytes[i] = i == 0 ? op.out_bytes : op.in_bytes[i - 1];
        }
        add(item);
        return;
      }
    }
  }
  Item record_item(std::uint32_t truth, std::uint32_t out, const std::array<std::uint32_t, 5>& in) {
    Item item;
    const std::uint32_t inputs = inputs_of(truth);
    item.kind = kind_number({Kind::Form::kRecords, inputs});
    item.truth = truth;
    item.inputs = static_cast<std::uint8_t>(inputs);
    item.operand[0] = out;
    std::copy_n(in.begin(), inputs, item.operand.begin() + 1);
    item.bytes.fill(1);
    return item;
  }
  [[nodiscard]] bool is(const Item& item, Kind::Form form) const { return kinds_[item.kind].form == form; }

  // ---- who waits for whom

  /// Finds bytes that are always used together, numbered by address.
  void find_cells() {
    bounds_.clear();
    for (const Item& item : items_) {
      for (std::size_t i = 0; i <= item.inputs; ++i) {
        bounds_.push_back(item.operand[i]);
        bounds_.push_back(item.operand[i] + item.bytes[i]);
      }
    }
    std::sort(bounds_.begin(), bounds_.end());
    bounds_.erase(std::unique(bounds_.begin(), bounds_.end()), bounds_.end());
  }
  [[nodiscard]] std::size_t cell_at(std::uint32_t operand) const {
    return static_cast<std::size_t>(std::lower_bound(bounds_.begin(), bounds_.end(), operand) - bounds_.begin());
  }
  template <class Visit>
  void for_cells(const Item& item, std::size_t operand, Visit visit) const {
    for (std::size_t c = cell_at(item.operand[operand]); bounds_[c] != item.operand[operand] + item.bytes[operand];
         ++c) {
      visit(c);
    }
  }
  [[nodiscard]] bool is_one_cell(const Item& item, std::size_t operand) const {
    return bounds_[cell_at(item.operand[operand]) + 1] == item.operand[operand] + item.bytes[operand];
  }

  /// Values that are overwritten after their last reader, if they and all their readers are operands of their own:
  /// those move to scratch memory.
  void find_moving() {
    const auto count = static_cast<std::uint32_t>(items_.size());
    moves_.assign(count, 0);
    definition_.assign(std::size_t{count} * 6, kLiveIn);
    std::vector<std::uint32_t> last(bounds_.size(), kLiveIn);  // writer, by cell
    std::vector<std::uint8_t> fixed(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Item& item = items_[i];
      const bool block = is(item, Kind::Form::kBlocks);
      for (std::size_t in = block ? 0 : 1; in <= item.inputs; ++in) {
        const bool whole = !block && is_one_cell(item, in);
        for_cells(item, in, [&](std::size_t c) {
          if (last[c] == kLiveIn) return;
          if (whole) {
            definition_[std::size_t{i} * 6 + in] = last[c];
          } else {
            fixed[last[c]] = 1;
          }
        });
      }
      if (block || !is_one_cell(item, 0)) fixed[i] = 1;
      for_cells(item, 0, [&](std::size_t c) {
        if (last[c] != kLiveIn) moves_[last[c]] = 1;
        last[c] = i;
      });
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      if (fixed[i] != 0) moves_[i] = 0;
    }
  }

  void find_edges() {
    edges_.clear();
    waits_.assign(items_.size(), 0);
    const auto edge = [this](std::uint32_t from, std::uint32_t to) {
      if (from == kLiveIn || from == to) return;
      edges_.emplace_back(from, to);
      ++waits_[to];
    };
    std::vector<std::uint32_t> writer(bounds_.size(), kLiveIn);  // of those that do not move
    std::vector<std::vector<std::uint32_t>> readers(bounds_.size());
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      const Item& item = items_[i];
      const bool block = is(item, Kind::Form::kBlocks);
      for (std::size_t in = block ? 0 : 1; in <= item.inputs; ++in) {
        const std::uint32_t definition = definition_[std::size_t{i} * 6 + in];
        if (definition != kLiveIn && moves_[definition] != 0) {
          edge(definition, i);
          continue;
        }
        for_cells(item, in, [&](std::size_t c) {
          edge(writer[c], i);
          readers[c].push_back(i);
        });
      }
      if (moves_[i] != 0) continue;
      for_cells(item, 0, [&](std::size_t c) {
        edge(writer[c], i);
        for (const std::uint32_t reader : readers[c]) edge(reader, i);
        readers[c].clear();
        writer[c] = i;
      });
    }
    std::sort(edges_.begin(), edges_.end());
  }

  // ---- order

  void arrange_items() {
    find_cells();
    make_moves();
    find_moving();
    find_edges();
    find_heights();
    count_uses();
    ready_.assign(kinds_.size(), {});
    now_ = 0;
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      if (waits_[i] == 0) ready_[items_[i].kind].push(i, 0);
    }
    std::vector<std::uint32_t> run;
    while (now_ != items_.size()) {
      const std::uint32_t kind = best_kind();
      run.clear();
      while (const auto item = take(kind)) run.push_back(*item);
      put_run(kinds_[kind], run);
      ++code_.report.runs;
    }
    code_.report.arranged += items_.size();
    items_.clear();
  }
  /// Records that only copy their input, as coils at outputs of blocks do, are moves: a third of the steps.
  void make_moves() {
    constexpr std::uint32_t kCopies = 0xaaaaaaaau;
    for (Item& item : items_) {
      if (!is(item, Kind::Form::kRecords) || item.truth != kCopies) continue;
      item.kind = kind_number({Kind::Form::kValues, static_cast<std::uint64_t>(ResolvedOp::kMoveBool)});
      item.inputs = 1;
    }
  }
  /// How many instructions wait for each other after each one.
  void find_heights() {
    heights_.assign(items_.size(), 0);
    for (auto edge = edges_.rbegin(); edge != edges_.rend(); ++edge) {
      heights_[edge->first] = std::max(heights_[edge->first], heights_[edge->second] + 1);
    }
  }
  /// That of the instruction which most others wait for in line, or else the one with most instructions: a kind that
  /// waits long for its turn makes more runs.
  [[nodiscard]] std::uint32_t best_kind() const {
    std::uint32_t best = 0;
    std::pair<std::uint32_t, std::size_t> most{};
    for (std::uint32_t kind = 0; kind < ready_.size(); ++kind) {
      if (ready_[kind].size() == 0) continue;
      const std::pair found{ready_[kind].highest(heights_), ready_[kind].size()};
      if (found <= most) continue;
      most = found;
      best = kind;
    }
    return best;
  }
  /// The instruction that comes next in a run of a kind.
  std::optional<std::uint32_t> take(std::uint32_t kind) {
    Ready* best = nullptr;
    const auto consider = [&](Ready& ready) {
      if (ready.size() == 0) return;
      ready.advance(now_, heights_);
      if (best == nullptr || ready.better_than(*best, heights_)) best = &ready;
    };
    consider(ready_[kind]);
    for (std::uint32_t other = 0; other < ready_.size() && kinds_[kind].form == Kind::Form::kRecords; ++other) {
      const bool fewer = kinds_[other].form == Kind::Form::kRecords && kinds_[other].what < kinds_[kind].what;
      if (fewer && ready_[other].size() <= kFewRecords) consider(ready_[other]);
    }
    if (best == nullptr) return std::nullopt;
    const std::uint32_t item = best->pop(heights_);
    ++now_;
    const auto first = std::lower_bound(edges_.begin(), edges_.end(), std::pair{item, 0u});
    for (auto edge = first; edge != edges_.end() && edge->first == item; ++edge) {
      if (--waits_[edge->second] == 0) ready_[items_[edge->second].kind].push(edge->second, now_ + kLatency);
    }
    return item;
  }

  // ---- writing

  void count_uses() {
    free_.clear();
    slots_ = 0;
    slot_of_.assign(items_.size(), 0);
    uses_.assign(items_.size(), 0);
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      for (std::size_t in = 1; in <= items_[i].inputs; ++in) {
        const std::uint32_t definition = definition_[std::size_t{i} * 6 + in];
        if (definition != kLiveIn) ++uses_[definition];
      }
    }
  }

  std::uint32_t handler(ResolvedOp op) {
    code_.arranged.push_back({static_cast<std::uint32_t>(words_.size()), op});
    return handler_word(addressing_, op);
  }
  void put_handler(ResolvedOp op) { words_.push_back(handler(op)); }

  /// The item with its operands where its values are now.
  Item placed(std::uint32_t number) {
    Item item = items_[number];
    for (std::size_t in = 1; in <= item.inputs; ++in) {
      const std::uint32_t definition = definition_[std::size_t{number} * 6 + in];
      if (definition == kLiveIn || moves_[definition] == 0) continue;
      item.operand[in] = scratch_ + slot_of_[definition] * static_cast<std::uint32_t>(sizeof(std::uint64_t));
      if (--uses_[definition] == 0) free_.push_back(slot_of_[definition]);
    }
    if (moves_[number] != 0) {
      if (free_.empty()) free_.push_back(slots_++);
      slot_of_[number] = free_.back();
      item.operand[0] = scratch_ + free_.back() * static_cast<std::uint32_t>(sizeof(std::uint64_t));
      if (uses_[number] != 0) free_.pop_back();
    }
    return item;
  }

  void put_run(const Kind& kind, const std::vector<std::uint32_t>& run) {
    switch (kind.form) {
      case Kind::Form::kRecords:
        put_records(run, static_cast<std::uint32_t>(kind.what));
        return;
      case Kind::Form::kBlocks:
        put_handler(ResolvedOp::kBlockRun);
        put_pointer(addressing_ == Addressing::kFixed
                        ? reinterpret_cast<std::uint64_t>(blocks_.at(kind.what)->step_each)
                        : kind.what);
        words_.push_back(static_cast<std::uint32_t>(run.size()));
        for (const std::uint32_t number : run) words_.push_back(items_[number].operand[0]);
        return;
      case Kind::Form::kValues: {
        const ValueOp& op = *value_op(static_cast<ResolvedOp>(kind.what));
        put_handler(ResolvedOp::kValueRun);
        put_pointer(reinterpret_cast<std::uint64_t>(op.run[static_cast<std::size_t>(addressing_)]));
        words_.push_back(static_cast<std::uint32_t>(run.size()));
        for (const std::uint32_t number : run) {
          const Item item = placed(number);
          words_.insert(words_.end(), item.operand.begin(), item.operand.begin() + 1 + item.inputs);
        }
        return;
      }
    }
  }
  void put_pointer(std::uint64_t pointer) {
    words_.push_back(static_cast<std::uint32_t>(pointer));
    words_.push_back(static_cast<std::uint32_t>(pointer >> 32));
  }
  void put_records(const std::vector<std::uint32_t>& run, std::uint32_t inputs) {
    std::vector<GeneralRecord> records;
    for (const std::uint32_t number : run) {
      const Item item = placed(number);
      GeneralRecord record;
      record.truth = item.truth;
      record.out = item.operand[0];
      // What is ignored must lie in the window all the same.
      for (std::size_t k = 0; k < std::size(record.in); ++k) record.in[k] = item.operand[k < item.inputs ? k + 1 : 1];
      records.push_back(record);
    }
    for (const BoolSegment& segment : cut_into_segments(records)) {
      const ResolvedOp op = segment.form == BoolSegment::Form::kGeneral ? ResolvedOp::kBoolRun
                            : inputs == 2                               ? ResolvedOp::kBoolRun2
                            : inputs == 4                               ? ResolvedOp::kBoolRun4
                                                                        : ResolvedOp::kBoolRun5;
      append_segment(words_, handler(op), segment, std::span(records).subspan(segment.first, segment.count));
    }
  }

  std::vector<std::uint32_t>& words_;
  LinkedCode& code_;
  std::uint32_t scratch_;
  Addressing addressing_ = Addressing::kFixed;
  std::unordered_map<std::uint64_t, const stdlib::BlockSpec*> blocks_;  ///< by step
  std::vector<Kind> kinds_;
  std::map<Kind, std::uint32_t> kind_numbers_;
  std::vector<Item> items_;
  std::vector<std::uint32_t> bounds_;      ///< of cells, ascending
  std::vector<std::uint32_t> definition_;  ///< the item that an operand reads the value of, if it is one whole cell
  std::vector<std::uint8_t> moves_;        ///< values that lie in scratch memory
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
  std::vector<std::uint32_t> waits_;  ///< how many items an item still waits for
  std::vector<std::uint32_t> heights_;
  std::vector<Ready> ready_;  ///< by kind
  std::size_t now_ = 0;       ///< instructions that have their place
  std::vector<std::uint32_t> slot_of_, uses_, free_;
  std::uint32_t slots_ = 0;
};

}  // namespace

void arrange(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch) {
  Arranger arranger(words, code, scratch);
  for (const LinkedBlock& block : code.blocks) arranger.arrange(block);
}

}  // namespace plc::runtime
