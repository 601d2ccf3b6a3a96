#include "runtime/sched/estimate.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "bytecode/type_map.h"
#include "runtime/link/body_reader.h"
#include "runtime/link/link.h"
#include "runtime/sched/longest_path.h"
#include "stdlib/library.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::ImagePou;
using bytecode::ImageType;
using bytecode::Opcode;
using bytecode::OperandKind;
using bytecode::Space;
using bytecode::TypeKind;

/// Number of a leaf's bytes as an integer of its type.
std::int64_t integer_at(const std::byte* from, core::Rep rep) {
  const auto read = [from]<class T>(T value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<std::int64_t>(value);
  };
  switch (rep) {
    case core::Rep::kI8:
      return read(std::int8_t{});
    case core::Rep::kU8:
      return read(std::uint8_t{});
    case core::Rep::kI16:
      return read(std::int16_t{});
    case core::Rep::kU16:
      return read(std::uint16_t{});
    case core::Rep::kI32:
      return read(std::int32_t{});
    case core::Rep::kU32:
      return read(std::uint32_t{});
    default:
      return read(std::int64_t{});
  }
}

class Estimator {
 public:
  Estimator(const Image& image, std::uint32_t task, const CostTable& costs, std::uint32_t loop_budget)
      : image_(image),
        costs_(costs),
        loop_budget_(loop_budget),
        body_(image.tasks[task].body),
        pous_(reached_pous(image, body_)),
        layout_(lay_out_task()),
        bindings_(image, body_, pous_, layout_),
        reader_(image, bindings_),
        costs_of_pous_(image.pous.size()),
        mine_(image.globals.size(), false) {
    for (const bytecode::ImageType& type : image.types) parts_.push_back(bytecode::parts_of(type, parts_));
    for (const std::string& key : image.functions) {
      const stdlib::Overload* const overload = stdlib::overload_with_key(key);
      const double declared = overload == nullptr ? 1 : std::max<double>(overload->spec->param_count, 1);
      function_costs_.push_back({named(costs.functions, key), declared});
    }
    for (const bytecode::ImageBlock& block : image.blocks) block_costs_.push_back(named(costs.blocks, block.name));
    for_each_instruction(image.pous[body_], [&](const Decoded& d) {
      if (d.opcode != Opcode::kWriteN) return;
      for (std::uint32_t f = 0; f < d.operands[1]; ++f) {
        mine_[d.operands[0] + f] = image.globals[d.operands[0] + f].writers == 1;
      }
    });
  }

  TaskEstimate run() {
    for (auto pou = pous_.rbegin(); pou != pous_.rend(); ++pou) costs_of_pous_[*pou] = body_cost(*pou);
    result_.scan = costs_[CostKind::kScan] + costs_of_pous_[body_] +
                   costs_[CostKind::kFetch] * static_cast<double>(library_used());
    result_.table_bytes = layout_.total - (layout_.instance - layout_.constants);
    list_body();
    return std::move(result_);
  }

 private:
  TaskLayout lay_out_task() const {
    std::vector<std::uint8_t> reached(image_.pous.size(), 0);
    for (const std::uint32_t pou : pous_) reached[pou] = 1;
    return lay_out(image_, body_, reached);
  }

  /// Functions and blocks of the library that are anywhere in the task.
  [[nodiscard]] std::size_t library_used() const {
    std::set<std::pair<bool, std::uint32_t>> used;
    for (const std::uint32_t pou : pous_) {
      for_each_instruction(image_.pous[pou], [&used](const Decoded& d) {
        const bool block = d.opcode == Opcode::kRunTb || d.opcode == Opcode::kRunAt || d.opcode == Opcode::kRunVia;
        if (block || d.opcode == Opcode::kCallStd) used.emplace(block, d.operands[0]);
      });
    }
    return used.size();
  }

  // ---- bodies -----------------------------------------------------------------------------------------------------

  /// A body as steps; `code` has the instruction that each of them begins with.
  struct Body {
    std::vector<Step> steps;
    std::vector<Decoded> code;
  };

  Cost body_cost(std::uint32_t pou) {
    pou_ = pou;
    const Body body = steps_of(pou);
    std::vector<Loop> loops = loops_of(body.steps);
    const std::vector<bool> reached = reached_steps(body.steps);
    for (Loop& loop : loops) {
      if (!reached[loop.last]) continue;  // what FOR from 5 to 4 leaves
      const std::optional<double> known = rounds_of_for(body, loop);
      loop.counted = known.has_value();
      loop.rounds = known.value_or(kAssumedRounds * static_cast<double>(loop.backs.size()));
      loop.rounds = std::min<double>(loop.rounds, loop_budget_);
      if (!known) result_.assumed.push_back({pou, source_of(image_, pou, body.code[loop.last].word)});
    }
    return longest_path(body.steps, std::move(loops));
  }

  static std::vector<bool> reached_steps(const std::vector<Step>& steps) {
    std::vector<bool> reached(steps.size() + 1, false);
    reached[0] = true;
    for (std::uint32_t s = 0; s < steps.size(); ++s) {
      if (!reached[s]) continue;
      if (steps[s].falls) reached[s + 1] = true;
      if (steps[s].target != kNoStep) reached[steps[s].target] = true;
    }
    return reached;
  }

  Body steps_of(std::uint32_t pou) {
    reader_.open(pou);
    const std::vector<std::uint32_t>& code = reader_.code();
    Body body;
    std::vector<std::uint32_t> step_at(code.size(), kNoStep);
    bool joined = false;  // with the comparison before
    for (std::uint32_t word = 0; word < code.size();) {
      const Decoded d = decode(code, word);
      step_at[word] = static_cast<std::uint32_t>(body.steps.size());
      Step step;
      if (d.opcode == Opcode::kBoolRun) {
        step.cost = cost_of_records(reader_.records(d, word));
      } else {
        word = d.next;
        if (!std::exchange(joined, reader_.fused_jump(d).has_value())) {
          step.cost = joined ? costs_[CostKind::kTest] : cost_of(d);
        }
        step.falls = d.opcode != Opcode::kReturn && d.opcode != Opcode::kJump && d.opcode != Opcode::kLoopJump;
      }
      body.steps.push_back(step);
      body.code.push_back(d);
    }
    for (std::size_t s = 0; s < body.steps.size(); ++s) {
      if (const auto target = BodyReader::target_of(body.code[s])) body.steps[s].target = step_at[*target];
    }
    return body;
  }

  [[nodiscard]] Cost cost_of_records(const std::vector<GeneralRecord>& records) const {
    Cost cost;
    for (const BoolSegment& segment : cut_into_segments(records)) {
      const bool wide = segment.form == BoolSegment::Form::kGeneral;
      cost += costs_[CostKind::kRun] + costs_[wide ? CostKind::kWideRecord : CostKind::kRecord] * segment.count;
    }
    return cost;
  }

  // ---- instructions -----------------------------------------------------------------------------------------------

  [[nodiscard]] Cost cost_of(const Decoded& d) const {
    const CostKind kind = cost_kind(d.opcode);
    Cost cost = kind == CostKind::kCount ? Cost{} : costs_[kind];
    switch (d.opcode) {
      case Opcode::kMoveStr:
      case Opcode::kMoveWstr:
        cost += bytes(std::min(reader_.leaf_type(d.operands[0]).size, reader_.leaf_type(d.operands[1]).size));
        break;
      case Opcode::kCopy:
        cost += bytes(image_.types[d.operands[2]].size);
        break;
      case Opcode::kQueuePut:
      case Opcode::kQueueGet:
        cost += bytes(image_.types[d.operands[3]].size);
        break;
      case Opcode::kRunTb:
        cost += block(d.operands[0]);
        break;
      case Opcode::kCallPou:
        cost += costs_of_pous_[d.operands[0]];
        break;
      case Opcode::kCallFn:
        cost += costs_of_pous_[d.operands[0]] + arguments(d);
        break;
      case Opcode::kCallStd:
        cost += standard(d);
        break;
      case Opcode::kLoadAt:
      case Opcode::kStoreAt:
      case Opcode::kLoadVia:
      case Opcode::kStoreVia:
        return access(d);
      case Opcode::kRefAt:
      case Opcode::kRefVia:
        cost += indices(d);
        break;
      case Opcode::kAdrAt:
      case Opcode::kAdrVia:
      case Opcode::kAdrPtr:
      case Opcode::kRefPtr:
        cost += pointer(d);
        break;
      case Opcode::kLoadPtr:
      case Opcode::kStorePtr:
        cost += pointer(d) + value_bytes(reader_.path_of(d).type) * kBytesOneByOne;
        break;
      case Opcode::kRunAt:
      case Opcode::kRunVia:
        cost += indices(d) + costs_[CostKind::kBlock] + block(d.operands[0]);
        break;
      case Opcode::kCallAt:
      case Opcode::kCallVia:
        cost += indices(d) + costs_[CostKind::kCall] + costs_of_pous_[d.operands[0]];
        break;
      case Opcode::kReadN:
      case Opcode::kWriteN:
      case Opcode::kWriteChangedN:
        cost += globals(d.operands[0], d.operands[1], d.opcode == Opcode::kReadN);
        break;
      default:
        break;
    }
    return cost;
  }

  [[nodiscard]] Cost bytes(std::uint32_t count) const { return costs_[CostKind::kByte] * count; }
  /// Bytes that moving a value of the type takes beyond the instruction.
  [[nodiscard]] Cost value_bytes(std::uint32_t type) const {
    const TypeKind kind = image_.types[type].kind;
    return kind == TypeKind::kScalar || kind == TypeKind::kRef ? Cost{} : bytes(image_.types[type].size);
  }
  [[nodiscard]] Cost indices(const Decoded& d) const {
    return costs_[CostKind::kIndex] * static_cast<double>(reader_.path_of(d).indices.size());
  }
  /// Pointers are looked up: what that takes, in accesses by a reference, beyond the first; and a byte that is not
  /// copied as it lies, in bytes that are.
  static constexpr double kLookUp = 4;
  static constexpr double kBytesOneByOne = 20;
  [[nodiscard]] Cost pointer(const Decoded& d) const { return indices(d) + costs_[CostKind::kAccess] * kLookUp; }
  /// In the form that the linker gives it.
  [[nodiscard]] Cost access(const Decoded& d) const {
    const ResolvedPath path = reader_.path_of(d);
    const bool via = d.opcode == Opcode::kLoadVia || d.opcode == Opcode::kStoreVia;
    const bool load = d.opcode == Opcode::kLoadAt || d.opcode == Opcode::kLoadVia;
    const TypeKind kind = image_.types[path.type].kind;
    if (!via && path.indices.empty()) {
      const bool scalar = kind == TypeKind::kScalar || kind == TypeKind::kRef;
      return scalar ? costs_[CostKind::kMove] : costs_[CostKind::kCopy] + value_bytes(path.type);
    }
    if (quick_access(image_, path, load, via)) {
      return costs_[path.indices.empty() ? CostKind::kAccess : CostKind::kElement] +
             (via && !path.indices.empty() ? costs_[CostKind::kAccess] : Cost{});
    }
    return costs_[CostKind::kAccess] + indices(d) + value_bytes(path.type);
  }

  /// One call each, of the one called `name` or else of the slowest.
  using Named = std::map<std::string, double, std::less<>>;
  static Cost named(const Named& known, std::string_view name) {
    auto found = known.find(name);
    if (found == known.end()) {
      found = std::max_element(known.begin(), known.end(),
                               [](const auto& a, const auto& b) { return a.second < b.second; });
    }
    return found == known.end() ? Cost{} : Cost{found->second, found->second};
  }
  [[nodiscard]] Cost block(std::uint32_t index) const { return block_costs_[index]; }

  /// Functions of strings were measured on strings of the default capacity, those that take any number of arguments on
  /// as many as they declare; what they do grows with either at most in proportion.
  [[nodiscard]] Cost standard(const Decoded& d) const {
    const LibraryCost& function = function_costs_[d.operands[0]];
    double times = std::max(1.0, static_cast<double>(d.items - 1) / function.declared);
    std::uint32_t capacity = core::kDefaultStringCapacity;
    for (std::uint32_t i = 0; i < d.items; ++i) {
      const ImageType& type = reader_.leaf_type(d.list[i]);
      if (type.kind == TypeKind::kString) capacity = std::max<std::uint32_t>(capacity, type.capacity);
    }
    times *= static_cast<double>(capacity) / core::kDefaultStringCapacity;
    return function.call * times + costs_[CostKind::kArgument] * d.items;
  }

  [[nodiscard]] Cost arguments(const Decoded& d) const {
    const ImagePou& function = image_.pous[d.operands[0]];
    Cost cost = bytes(static_cast<std::uint32_t>(function.frame_initial.size()));
    for (std::uint32_t i = 0; i < d.items; ++i) {
      const bytecode::ImageField& parameter = image_.types[function.frame_type].fields[d.list[2 * i]];
      cost += costs_[CostKind::kArgument] + value_bytes(parameter.type);
    }
    return cost;
  }

  // ---- globals ----------------------------------------------------------------------------------------------------

  /// What a task alone writes stays in its own copy of the table (runtime/memory/exchange.h): it is exported, and never
  /// imported.
  [[nodiscard]] Cost globals(std::uint32_t first, std::uint32_t count, bool import) const {
    const auto& fields = image_.types[image_.global_type].fields;
    Cost cost;
    for (std::uint32_t f = first; f < first + count; ++f) {
      const bytecode::ImageGlobal& global = image_.globals[f];
      const bool overlapping = image_.options.profile == core::AddressProfile::kOverlay && !global.address.empty();
      if (fields[f].constant) continue;
      if (global.writers > 1 || overlapping) {
        cost += costs_[CostKind::kShared] * static_cast<double>(parts_[fields[f].type]);
      } else if (mine_[f] != import) {
        cost += costs_[import ? CostKind::kImportByte : CostKind::kExportByte] * image_.types[fields[f].type].size;
      }
    }
    return cost;
  }
  /// Bodies of tasks go straight on.
  void list_body() {
    pou_ = body_;
    for_each_instruction(image_.pous[body_], [&](const Decoded& d) {
      using What = BodyStep::What;
      BodyStep step{What::kOther, 0, 0, cost_of(d).first};
      switch (d.opcode) {
        case Opcode::kReadN:
        case Opcode::kWriteN:
        case Opcode::kWriteChangedN:
        case Opcode::kRaisePriority:
          step.what = d.opcode == Opcode::kRaisePriority ? What::kRaise : What::kCopy;
          step.first = d.operands[0];
          step.count = d.operands[1];
          break;
        case Opcode::kReschedule:
          step.what = What::kReschedule;
          break;
        case Opcode::kLock:
          step.what = What::kLock;
          break;
        case Opcode::kUnlock:
          step.what = What::kUnlock;
          break;
        default:
          break;
      }
      result_.body.push_back(step);
    });
  }

  // ---- loops that count from constant to constant ------------------------------------------------------------------
  // FOR becomes (frontend-st/lower_loops.cpp):   MOVE i, initial
  //                                       first: ..
  //                                              LT t, i, limit     (GT downwards)
  //                                              COND_JUMP t, out
  //                                              ADD i, i, step     (SUB downwards; a RANGE after it for subranges)
  //                                        last: LOOP_JUMP first

  [[nodiscard]] std::optional<std::int64_t> constant(std::uint32_t operand) const {
    if (bytecode::space_of(operand) != Space::kConst) return std::nullopt;
    const core::Rep rep = bytecode::rep_of(reader_.leaf_type(operand));
    if (core::rep_bytes(rep) == 0 || rep == core::Rep::kF32 || rep == core::Rep::kF64) return std::nullopt;
    return integer_at(image_.const_bytes.data() + bytecode::offset_of(operand), rep);
  }

  /// How often the jump back is taken; nothing when the code does not say.
  [[nodiscard]] std::optional<double> rounds_of_for(const Body& body, const Loop& loop) const {
    if (loop.backs.size() != 1 || loop.last < loop.first + 3 || loop.first == 0) return std::nullopt;
    const std::vector<Decoded>& code = body.code;
    std::uint32_t at = loop.last - 1;
    const std::uint32_t control = code[at].operands[0];
    if (is_one_of(code[at].opcode, Opcode::kRangeI8, Opcode::kRangeU64)) {
      const std::uint32_t checked = code[at].operands[1];
      if (code[--at].operands[0] != checked) return std::nullopt;
    }
    const Decoded& count = code[at];
    const bool up = is_one_of(count.opcode, Opcode::kAdd8, Opcode::kAdd64);
    const bool down = is_one_of(count.opcode, Opcode::kSub8, Opcode::kSub64);
    if ((!up && !down) || count.operands[1] != control || at < loop.first + 2) return std::nullopt;
    const Decoded& leave = code[at - 1];
    const Decoded& compare = code[at - 2];
    const bool goes_on = up ? is_one_of(compare.opcode, Opcode::kLtI8, Opcode::kLtU64)
                            : is_one_of(compare.opcode, Opcode::kGtI8, Opcode::kGtU64);
    if (leave.opcode != Opcode::kCondJump || !goes_on || compare.operands[0] != leave.operands[0] ||
        compare.operands[1] != control || body.steps[at - 1].target <= loop.last) {
      return std::nullopt;
    }
    const Decoded& start = code[loop.first - 1];
    if (!is_one_of(start.opcode, Opcode::kMove8, Opcode::kMove64) || start.operands[0] != control) return std::nullopt;
    const auto initial = constant(start.operands[1]);
    const auto limit = constant(compare.operands[2]);
    const auto step = constant(count.operands[2]);
    if (!initial || !limit || !step || *step <= 0 || changes(code, loop.first, at - 1, control)) return std::nullopt;
    // Patterns of 64 bits without sign order otherwise beyond the middle; no loop counts there.
    const double distance = up ? static_cast<double>(*limit) - static_cast<double>(*initial)
                               : static_cast<double>(*initial) - static_cast<double>(*limit);
    return distance <= 0 ? 0 : std::ceil(distance / static_cast<double>(*step));
  }
  static bool is_one_of(Opcode opcode, Opcode first, Opcode last) { return opcode >= first && opcode <= last; }

  /// True when a step of [first, last) may write the leaf `control` or gives it away.
  [[nodiscard]] bool changes(const std::vector<Decoded>& code, std::uint32_t first, std::uint32_t last,
                             std::uint32_t control) const {
    const bool global = bytecode::space_of(control) == Space::kGlobal;
    for (std::uint32_t s = first; s < last; ++s) {
      const Decoded& d = code[s];
      const bytecode::Operands& operands = bytecode::info(d.opcode).operands;
      for (std::uint32_t i = 0; i < operands.count; ++i) {
        switch (operands.specs[i].kind) {
          case OperandKind::kOut:
          case OperandKind::kValueOut:
          case OperandKind::kBaseOut:
            if (d.operands[i] == control) return true;
            break;
          case OperandKind::kBaseIn:
            if ((d.opcode == Opcode::kRefAt || d.opcode == Opcode::kAdrAt) && d.operands[i] == control) return true;
            break;
          case OperandKind::kStdArgs:
            if (d.list[0] == control) return true;
            break;
          case OperandKind::kFnArgs:
            for (std::uint32_t a = 0; a < d.items; ++a) {
              if (d.list[2 * a + 1] == control && is_output(d.operands[0], d.list[2 * a])) return true;
            }
            break;
          case OperandKind::kPou:
            if (global) return true;
            break;
          default:
            break;
        }
      }
    }
    return false;
  }
  [[nodiscard]] bool is_output(std::uint32_t pou, std::uint32_t parameter) const {
    return image_.types[image_.pous[pou].frame_type].fields[parameter].role != bytecode::FieldRole::kInput;
  }

  const Image& image_;
  const CostTable& costs_;
  std::uint32_t loop_budget_;
  std::uint32_t body_;
  std::vector<std::uint32_t> pous_;
  TaskLayout layout_;
  Bindings bindings_;
  BodyReader reader_;
  std::vector<Cost> costs_of_pous_;   ///< one execution each, by POU of the image
  std::vector<bool> mine_;            ///< globals that this task alone writes
  std::vector<std::uint64_t> parts_;  ///< leaves of each type
  struct LibraryCost {
    Cost call;
    double declared = 1;  ///< arguments it was measured with
  };
  std::vector<LibraryCost> function_costs_;  ///< parallel to Image::functions
  std::vector<Cost> block_costs_;            ///< parallel to Image::blocks
  std::uint32_t pou_ = 0;
  TaskEstimate result_;
};

}  // namespace

TaskEstimate estimate_task(const Image& image, std::uint32_t task, const CostTable& costs, std::uint32_t loop_budget) {
  return Estimator(image, task, costs, loop_budget).run();
}

}  // namespace plc::runtime
