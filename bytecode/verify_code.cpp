#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// One instruction under check: what its operands name, for the rules that relate operands to each other.
struct Instruction {
  std::size_t word = 0;            // of the opcode
  std::uint32_t items = 0;         // of its list
  std::uint32_t type = kNone;      // type(): what it works on, or where its path starts
  std::uint32_t end = kNone;       // type where its path ends
  std::uint32_t executed = kNone;  // type of block() or pou()
  std::uint32_t pou = kNone;
  const stdlib::Overload* function = nullptr;
  std::uint32_t in_target = kNone;  // types that its references refer to
  std::uint32_t out_target = kNone;
  std::uint32_t bit = 0;  // imm()
  std::uint32_t first_global = kNone;
  bool raises = false;                  // a copy at the ceiling of its globals, if that is more urgent
  std::array<std::uint32_t, 3> bits{};  // widths of its leaves
  std::size_t leaves = 0;
};

class CodeVerifier {
 public:
  CodeVerifier(const Image& image, Report& report, LeafMaps& maps,
               const std::vector<const stdlib::Overload*>& functions, const ImagePou& pou, PouFacts& facts)
      : image_(image),
        report_(report),
        functions_(functions),
        pou_(pou),
        facts_(facts),
        code_(pou.code),
        types_{image.global_type, pou.instance_type, pou.frame_type, image.const_type},
        maps_{&maps.of(types_[0]), &maps.of(types_[1]), &maps.of(types_[2]), &maps.of(types_[3])} {}

  void run() {
    find_starts();
    if (report_.clean()) {
      for (std::size_t at = 0; at < code_.size() && !report_.full();) at = check_instruction(at);
      merge_calls();
    }
    check_debug();
    for (const ImageQueuePort& port : pou_.queue_ports) facts_.queues.push_back({port.queue, port.takes});
  }

 private:
  void broken(Rule rule, const std::string& what) { report_.broken(rule, pou_, here_.word, what); }

  static std::uint32_t opcode_of(std::uint32_t word) { return word & 0xffffu; }

  /// Finds the starts of instructions; everything after relies on each being whole.
  void find_starts() {
    starts_.resize(code_.size());
    std::uint32_t last = kNone;
    for (std::size_t at = 0; at < code_.size();) {
      here_.word = at;
      last = opcode_of(code_[at]);
      if (last >= opcodes().size()) return broken(Rule::kV301, fmt::format("opcode {}", last));
      const std::size_t length = length_at(at);
      if (length == 0) return;
      if (length > code_.size() - at) return broken(Rule::kV302, "the code ends inside the instruction");
      starts_[at] = true;
      at += length;
    }
    if (last != static_cast<std::uint32_t>(Opcode::kReturn)) broken(Rule::kV303, "the code ends without RETURN");
  }

  /// Words of the instruction, 0 after reporting a list that does not belong there.
  std::size_t length_at(std::size_t at) {
    const OpcodeInfo& op = info(static_cast<Opcode>(opcode_of(code_[at])));
    const std::uint32_t items = code_[at] >> 16;
    std::size_t length = 1;
    bool list = false;
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      const OperandKind kind = op.operands.specs[i].kind;
      const std::uint32_t item = words_per_item(kind);
      length += item == 0 ? 1 : std::size_t{item} * items;
      list = list || item != 0;
      if (items == 0 && (kind == OperandKind::kRecords || kind == OperandKind::kStdArgs)) {
        broken(Rule::kV306, fmt::format("{} with an empty list", op.mnemonic));
        return 0;
      }
    }
    if (items != 0 && !list) {
      broken(Rule::kV306, fmt::format("{} with {} list items", op.mnemonic, items));
      return 0;
    }
    return length;
  }

  std::size_t check_instruction(std::size_t at) {
    const OpcodeInfo& op = info(static_cast<Opcode>(opcode_of(code_[at])));
    here_ = Instruction{};
    here_.word = at;
    here_.items = code_[at] >> 16;
    type_before_places(op);
    std::size_t word = at + 1;
    for (std::uint8_t i = 0; i < op.operands.count && !report_.full(); ++i) {
      const OperandSpec& spec = op.operands.specs[i];
      const std::uint32_t item = words_per_item(spec.kind);
      const std::size_t length = item == 0 ? 1 : std::size_t{item} * here_.items;
      if (item == 0) {
        check_operand(op, spec, code_[word]);
      } else {
        check_list(spec.kind, std::span(code_).subspan(word, length));
      }
      word += length;
    }
    check_critical(op);
    check_references();
    check_part(static_cast<Opcode>(opcode_of(code_[at])));
    facts_.work += word - at;
    return word;
  }

  /// A place may come before the type() operand that names its type, a value before the path that leads to its type.
  void type_before_places(const OpcodeInfo& op) {
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      if (op.operands.specs[i].kind != OperandKind::kType) continue;
      const std::uint32_t type = code_[here_.word + 1 + i];
      if (type < image_.types.size()) here_.type = type;
    }
    if (op.operands.count != 0 && op.operands.specs[op.operands.count - 1].kind == OperandKind::kPath) walk_path(op);
  }

  [[nodiscard]] bool makes_reference() const {
    const auto opcode = static_cast<Opcode>(code_[here_.word] & 0xffffu);
    return opcode == Opcode::kRefAt || opcode == Opcode::kRefVia || opcode == Opcode::kRefPtr;
  }

  /// Finds where the path of the instruction ends; reports steps that lead nowhere.
  void walk_path(const OpcodeInfo& op) {
    if (here_.type == kNone) return;  // reported as an operand
    // What a reference is made to may be written through it.
    bool written = makes_reference();
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      const OperandKind kind = op.operands.specs[i].kind;
      written = written || kind == OperandKind::kBaseOut || kind == OperandKind::kValueIn ||
                kind == OperandKind::kBlock || kind == OperandKind::kPou;
    }
    const std::uint32_t* item = &code_[here_.word] + words_of(op.operands, 0);
    std::uint32_t type = here_.type;
    for (std::uint32_t i = 0; i < here_.items; ++i, item += kPathWords) {
      const auto next = follow_path(image_, type, item[0], item[1]);
      if (!next) return broken(Rule::kV316, fmt::format("step {} to {} of type {}", item[0], item[1], type));
      if (item[0] == static_cast<std::uint32_t>(PathStep::kIndex)) check_leaf_word(item[1], kMWord, false);
      if (written && next->constant) broken(Rule::kV309, fmt::format("field {} of type {}", item[1], type));
      type = next->type;
    }
    here_.end = type;
    // The copy of a value costs its bytes.
    facts_.work += image_.types[type].size / 8;
  }

  void check_operand(const OpcodeInfo& op, const OperandSpec& spec, std::uint32_t word) {
    switch (spec.kind) {
      case OperandKind::kIn:
      case OperandKind::kOut:
        check_leaf(spec, word);
        return;
      case OperandKind::kPlaceIn:
        // The copy of a value costs its bytes.
        if (here_.type != kNone) facts_.work += image_.types[here_.type].size / 8;
        check_place(word, here_.type, false);
        return;
      case OperandKind::kPlaceOut:
        if (here_.type != kNone) facts_.work += image_.types[here_.type].size / 8;
        check_place(word, here_.type, true);
        return;
      case OperandKind::kPlaceInOut:
        check_place(word, here_.executed, true);
        return;
      case OperandKind::kBaseIn:
        check_place(word, here_.type, false);
        return;
      case OperandKind::kBaseOut:
        check_place(word, here_.type, true);
        return;
      case OperandKind::kValueIn:
      case OperandKind::kValueOut:
        if (here_.end != kNone) check_value(word, here_.end, spec.kind == OperandKind::kValueOut, Rule::kV317);
        return;
      case OperandKind::kTarget:
        check_target(op, word);
        return;
      case OperandKind::kType:
        if (word >= image_.types.size()) broken(Rule::kV310, fmt::format("type {}", word));
        return;
      case OperandKind::kPou:
        if (word >= image_.pous.size()) return broken(Rule::kV310, fmt::format("POU {}", word));
        here_.pou = word;
        here_.executed = image_.pous[word].instance_type;
        check_callee(op, word);
        return;
      case OperandKind::kBlock:
        if (word >= image_.blocks.size()) return broken(Rule::kV310, fmt::format("block {}", word));
        here_.executed = image_.blocks[word].type;
        return;
      case OperandKind::kFunction:
        if (word >= functions_.size()) return broken(Rule::kV310, fmt::format("function {}", word));
        here_.function = functions_[word];
        return;
      case OperandKind::kQueue:
        check_queue(word);
        return;
      case OperandKind::kGlobal:
        if (pou_.kind != PouKind::kTask) broken(Rule::kV408, fmt::format("{} in {}", op.mnemonic, pou_.name));
        here_.first_global = word;
        return;
      case OperandKind::kCount:
        check_globals(op, word);
        return;
      case OperandKind::kImm:
        here_.bit = word;
        return;
      case OperandKind::kPath:
      case OperandKind::kRecords:
      case OperandKind::kStdArgs:
      case OperandKind::kFnArgs:
        return;
    }
  }

  void check_queue(std::uint32_t queue) {
    if (queue >= image_.queues.size()) return broken(Rule::kV318, fmt::format("queue {}", queue));
    const auto opcode = static_cast<Opcode>(opcode_of(code_[here_.word]));
    if (opcode != Opcode::kQueueCount) facts_.queues.push_back({queue, opcode == Opcode::kQueueGet});
    if (here_.type == kNone || same_type(image_, image_.queues[queue].type, here_.type)) return;
    broken(Rule::kV318,
           fmt::format("type {}, elements of queue {} have type {}", here_.type, queue, image_.queues[queue].type));
  }

  static std::string_view space_name(Space space) {
    constexpr std::string_view kNames[] = {"globals", "instance", "frame", "constants"};
    return kNames[static_cast<std::size_t>(space)];
  }
  static std::string describe(std::uint32_t word) {
    return fmt::format("byte {} of the {}", offset_of(word), space_name(space_of(word)));
  }

  /// The rules of every operand in a space; false when it is no use to look further.
  bool check_space(std::uint32_t word, bool written) {
    if (space_of(word) == Space::kInstance && pou_.kind == PouKind::kFunction) {
      broken(Rule::kV311, describe(word));
      return false;
    }
    if (written && space_of(word) == Space::kConst) {
      broken(Rule::kV309, describe(word));
      return false;
    }
    return true;
  }

  /// Checks a leaf operand; returns its representation, or nothing after a report.
  std::optional<Rep> check_leaf_word(std::uint32_t word, RepMask reps, bool written) {
    if (!check_space(word, written)) return std::nullopt;
    const std::uint8_t leaf = maps_[static_cast<std::size_t>(space_of(word))]->at(offset_of(word));
    const unsigned rep = (leaf & 0x7fu) - 1u;
    if ((leaf & 0x7fu) == 0 || ((reps >> rep) & 1u) == 0) {
      broken(Rule::kV307, describe(word));
      return std::nullopt;
    }
    if (written && (leaf & LeafMap::kConstantLeaf) != 0) {
      broken(Rule::kV309, describe(word));
      return std::nullopt;
    }
    return static_cast<Rep>(rep);
  }

  std::uint32_t root_of(std::uint32_t word) const { return types_[static_cast<std::size_t>(space_of(word))]; }
  /// Type that the reference leaf at `word` refers to.
  std::uint32_t target_of(std::uint32_t word) const {
    const auto leaf = find_leaf(image_, root_of(word), offset_of(word));
    return leaf ? image_.types[leaf->type].element : kNone;
  }

  void check_leaf(const OperandSpec& spec, std::uint32_t word) {
    const bool written = spec.kind == OperandKind::kOut;
    const auto rep = check_leaf_word(word, spec.reps, written);
    if (!rep) return;
    if (here_.leaves < here_.bits.size()) here_.bits[here_.leaves] = *rep == Rep::kBool ? 1 : core::rep_bytes(*rep) * 8;
    ++here_.leaves;
    if (*rep == Rep::kRef) (written ? here_.out_target : here_.in_target) = target_of(word);
  }

  /// Checks a place of type `wanted`; kNone was reported already.
  void check_place(std::uint32_t word, std::uint32_t wanted, bool written) {
    if (wanted == kNone || !check_space(word, written)) return;
    const auto found = find_place(image_, root_of(word), offset_of(word), wanted);
    if (!found) return broken(Rule::kV308, fmt::format("{} for type {}", describe(word), wanted));
    if (written && found->constant) return broken(Rule::kV309, describe(word));
    const bool constants = space_of(word) == Space::kConst;
    if (makes_reference() && (found->constant || constants)) broken(Rule::kV314, describe(word));
    if (constants && static_cast<Opcode>(opcode_of(code_[here_.word])) == Opcode::kAdrAt) {
      broken(Rule::kV314, describe(word));
    }
  }

  void check_target(const OpcodeInfo& op, std::uint32_t word) {
    if (word >= code_.size() || !starts_[word])
      return broken(Rule::kV304, fmt::format("{} to word {}", op.mnemonic, word));
    const bool backward = op.events == Events::kBudget;
    // An empty endless loop is a jump to itself.
    if (backward ? word > here_.word : word <= here_.word) {
      broken(Rule::kV305, fmt::format("{} to word {}", op.mnemonic, word));
    }
  }

  void check_callee(const OpcodeInfo& op, std::uint32_t callee) {
    bool function = false, in_place = false;
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      function = function || op.operands.specs[i].kind == OperandKind::kFnArgs;
      in_place = in_place || op.operands.specs[i].kind == OperandKind::kPlaceInOut;
    }
    const PouKind kind = image_.pous[callee].kind;
    const bool fits = function ? kind == PouKind::kFunction
                               : kind == PouKind::kFunctionBlock || (in_place && kind == PouKind::kProgram);
    if (!fits) broken(Rule::kV401, fmt::format("{} of {}", op.mnemonic, image_.pous[callee].name));
    // The frame of a function is set up at each call.
    if (function) facts_.work += image_.pous[callee].frame_initial.size() / 8;
    facts_.calls.push_back({callee, 1});
  }

  void check_critical(const OpcodeInfo& op) {
    const auto opcode = static_cast<Opcode>(opcode_of(code_[here_.word]));
    if (pou_.kind == PouKind::kTask) return check_section(op, opcode);
    const bool critical = opcode == Opcode::kReschedule || opcode == Opcode::kLock || opcode == Opcode::kUnlock;
    if (critical) broken(Rule::kV408, fmt::format("{} in {}", op.mnemonic, pou_.name));
  }

  /// Word by word, which is enough: nothing in a section jumps, and a jump into one finds less held than here.
  void check_section(const OpcodeInfo& op, Opcode opcode) {
    const std::string_view held = locked_ ? "before UNLOCK" : raised_ ? "before RESCHEDULE" : "without LOCK";
    bool fits = !locked_ && !raised_;
    switch (opcode) {
      case Opcode::kReadN:
      case Opcode::kWriteN:
      case Opcode::kWriteChangedN:
        raised_ = raised_ || here_.raises;
        return;
      case Opcode::kRaisePriority:
      case Opcode::kReschedule:
        fits = !locked_;
        raised_ = opcode == Opcode::kRaisePriority;
        break;
      case Opcode::kLock:
        locked_ = true;
        break;
      case Opcode::kUnlock:
        fits = locked_;
        locked_ = false;
        break;
      default:
        break;
    }
    if (!fits) broken(Rule::kV416, fmt::format("{} {}", op.mnemonic, held));
  }

  void check_globals(const OpcodeInfo& op, std::uint32_t count) {
    const std::uint64_t first = here_.first_global;
    if (first + count > image_.globals.size() || count == 0) {
      return broken(Rule::kV409, fmt::format("{} of {} globals from {}", op.mnemonic, count, first));
    }
    const auto& fields = image_.types[image_.global_type].fields;
    const ImageField& last = fields[first + count - 1];
    facts_.work += (last.offset + std::uint64_t{image_.types[last.type].size} - fields[first].offset) / 8;
    const auto opcode = static_cast<Opcode>(opcode_of(code_[here_.word]));
    if (opcode == Opcode::kWriteN || opcode == Opcode::kWriteChangedN) facts_.exports.push_back({first, count});
    const auto range = std::span(image_.globals).subspan(first, count);
    here_.raises = image_.options.coherence == core::Coherence::kPriorityCeiling &&
                   std::any_of(range.begin(), range.end(), [](const ImageGlobal& g) { return g.writers == 1; });
  }

  void check_list(OperandKind kind, std::span<const std::uint32_t> words) {
    if (kind == OperandKind::kRecords) check_records(words);
    if (kind == OperandKind::kStdArgs) check_std_args(words);
    if (kind == OperandKind::kFnArgs) check_fn_args(words);
  }

  void check_records(std::span<const std::uint32_t> words) {
    for (std::size_t i = 0; i < words.size() && !report_.full(); i += kRecordWords) {
      check_leaf_word(words[i + 1], kMBool, true);
      for (std::size_t in = 2; in < kRecordWords; ++in) check_leaf_word(words[i + in], kMBool, false);
    }
  }

  void check_std_args(std::span<const std::uint32_t> words) {
    if (here_.function == nullptr) return;
    const stdlib::Overload& function = *here_.function;
    const std::size_t args = words.size() - 1;
    const std::size_t declared = function.spec->param_count;
    const bool extended = function.spec->extensible && args >= declared && args <= stdlib::kMaxArguments;
    if (args != declared && !extended) {
      return broken(Rule::kV505, fmt::format("{} arguments for {}, which takes {}", args, function.name, declared));
    }
    check_std_leaf(words[0], function.result_type(), true);
    for (std::size_t i = 0; i < args; ++i) check_std_leaf(words[i + 1], function.param_type(i), false);
  }
  void check_std_leaf(std::uint32_t word, core::TypeId type, bool written) {
    constexpr RepMask kAny = (1u << core::kRepCount) - 1u;
    const auto rep = check_leaf_word(word, kAny, written);
    if (rep && *rep != core::rep_of(type)) {
      broken(Rule::kV506, fmt::format("{} is {}, {} takes {}", describe(word), core::rep_name(*rep),
                                      here_.function->name, core::name_of(type)));
    }
  }

  void check_fn_args(std::span<const std::uint32_t> words) {
    if (here_.pou == kNone) return;
    const ImageType& frame = image_.types[image_.pous[here_.pou].frame_type];
    for (std::size_t i = 0; i < words.size() && !report_.full(); i += 2) {
      if (words[i] >= frame.fields.size() || !is_parameter(frame.fields[words[i]].role)) {
        broken(Rule::kV403, fmt::format("variable {}", words[i]));
        continue;
      }
      check_fn_arg(frame.fields[words[i]], words[i + 1]);
    }
  }
  static bool is_parameter(FieldRole role) {
    return role == FieldRole::kInput || role == FieldRole::kOutput || role == FieldRole::kInOut ||
           role == FieldRole::kReturnValue;
  }
  void check_fn_arg(const ImageField& parameter, std::uint32_t word) {
    const ImageType& type = image_.types[parameter.type];
    facts_.work += type.size / 8;
    const bool written = parameter.role == FieldRole::kOutput || parameter.role == FieldRole::kReturnValue;
    if (parameter.role == FieldRole::kInOut && type.kind != TypeKind::kRef) {
      return broken(Rule::kV404, fmt::format("{} for {}", describe(word), parameter.name));
    }
    check_value(word, parameter.type, written, Rule::kV404);
  }
  /// A leaf or place that is read or written as one of type `wanted`.
  void check_value(std::uint32_t word, std::uint32_t wanted, bool written, Rule rule) {
    if (!check_space(word, written)) return;
    const ImageType& type = image_.types[wanted];
    const bool aggregate = type.kind == TypeKind::kStruct || type.kind == TypeKind::kArray;
    const auto found = aggregate ? find_place(image_, root_of(word), offset_of(word), wanted)
                                 : find_leaf(image_, root_of(word), offset_of(word));
    const bool fits = found && (aggregate || leaf_fits(image_, image_.types[found->type], type));
    if (!fits) return broken(rule, fmt::format("{} for type {}", describe(word), wanted));
    if (written && found->constant) broken(Rule::kV309, describe(word));
  }
  /// What the references of the instruction refer to follows from the other operands it has.
  void check_references() {
    if (here_.type == kNone || here_.end == kNone) {
      if (here_.in_target != kNone && here_.out_target != kNone) expect_same(here_.out_target, here_.in_target);
      return;
    }
    if (here_.in_target != kNone) expect_same(here_.in_target, here_.type);
    if (here_.out_target != kNone) expect_same(here_.out_target, here_.end);
    if (here_.executed != kNone) expect_same(here_.end, here_.executed);
  }
  void expect_same(std::uint32_t found, std::uint32_t wanted) {
    if (!same_type(image_, found, wanted)) broken(Rule::kV313, fmt::format("type {}, not {}", found, wanted));
  }

  void check_part(Opcode opcode) {
    if (opcode != Opcode::kExtract && opcode != Opcode::kInsert) return;
    const bool insert = opcode == Opcode::kInsert;
    if (here_.leaves != (insert ? 3u : 2u)) return;  // reported
    const std::uint32_t word = here_.bits[1];
    const std::uint32_t part = here_.bits[insert ? 2 : 0];
    const bool inside = part < word && here_.bit < word && here_.bit % part == 0;
    if (!inside || (insert && here_.bits[0] != word)) {
      broken(Rule::kV315, fmt::format("{} bits at bit {} of {}", part, here_.bit, word));
    }
  }

  void merge_calls() {
    std::vector<CallEdge>& calls = facts_.calls;
    std::sort(calls.begin(), calls.end(), [](const CallEdge& a, const CallEdge& b) { return a.callee < b.callee; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < calls.size(); ++i) {
      if (kept != 0 && calls[kept - 1].callee == calls[i].callee) {
        calls[kept - 1].times += calls[i].times;
      } else {
        calls[kept++] = calls[i];
      }
    }
    calls.resize(kept);
  }

  void check_debug() {
    std::size_t next = 0;
    for (const DebugEntry& entry : pou_.debug) {
      here_.word = entry.word;
      if (entry.word < next || entry.word >= code_.size() ||
          (entry.at.line != 0 && entry.at.file >= image_.files.size())) {
        return broken(Rule::kV312, "debug entry out of order or place");
      }
      next = std::size_t{entry.word} + 1;
    }
  }

  const Image& image_;
  Report& report_;
  const std::vector<const stdlib::Overload*>& functions_;
  const ImagePou& pou_;
  PouFacts& facts_;
  const std::vector<std::uint32_t>& code_;
  std::array<std::uint32_t, 4> types_;  // structure of each Space
  std::array<const LeafMap*, 4> maps_;  // and its leaves
  std::vector<bool> starts_;
  bool locked_ = false, raised_ = false;  // by the body of a task, so far
  Instruction here_;
};

}  // namespace

void verify_code(const Image& image, Report& report, std::vector<PouFacts>& facts) {
  std::vector<const stdlib::Overload*> functions;
  for (const std::string& key : image.functions) functions.push_back(stdlib::overload_with_key(key));
  LeafMaps maps(image);
  facts.resize(image.pous.size());
  for (std::size_t i = 0; i < image.pous.size() && !report.full(); ++i) {
    CodeVerifier(image, report, maps, functions, image.pous[i], facts[i]).run();
  }
}

}  // namespace plc::bytecode
