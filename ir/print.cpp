#include <fmt/format.h>

#include <bit>
#include <iterator>

#include "ir/check.h"
#include "ir/text.h"

namespace plc::ir {

namespace {

/// An index as it may have been written.
std::string index_text(const Module& module, const Pou& pou, ValueId index) {
  const Inst& inst = pou.body.insts[index.index];
  if (inst.op == Op::kLoad) return place_text(module, pou, PlaceId{inst.a});
  if (inst.op == Op::kConst) return constant_text(module.types, pou.body.constants[inst.a]);
  return "..";
}

}  // namespace

std::string place_text(const Module& module, const Pou& pou, PlaceId place, bool value_ids) {
  const Place& p = pou.body.places[place.index];
  switch (p.kind) {
    case Place::Kind::kGlobal: {
      const Global& g = module.globals[p.index];
      const std::string& name = g.variable.name.empty() ? g.variable.address : g.variable.name;
      return g.list.empty() ? name : g.list + "." + name;
    }
    case Place::Kind::kInstance:
    case Place::Kind::kFrame:
      return module.owner_of(pou).variables[p.index].name;
    case Place::Kind::kSelf:
      return module.owner_of(pou).name;
    case Place::Kind::kDeref: {
      const Inst& inst = pou.body.insts[p.index];
      if (inst.op == Op::kPointerRef && pou.body.insts[inst.a].op == Op::kLoad) {
        return place_text(module, pou, PlaceId{pou.body.insts[inst.a].a}, value_ids) + "^";
      }
      const bool through = module.types[inst.type].kind == TypeKind::kPointer;
      // A member of a union is reached through the address of the union.
      if (inst.op == Op::kAddress) return place_text(module, pou, PlaceId{inst.a}, value_ids);
      if (inst.op == Op::kLoad || inst.op == Op::kMakeRef) {
        return place_text(module, pou, PlaceId{inst.a}, value_ids) + (through ? "^" : "");
      }
      return "referenced value";
    }
    case Place::Kind::kField: {
      const Type& type = module.types[pou.body.places[p.parent.index].type];
      std::string name;
      if (type.kind == TypeKind::kStruct) name = type.fields[p.index].name;
      if (type.kind == TypeKind::kBlock) name = std::string(type.block->fields[p.index].name);
      if (type.kind == TypeKind::kPou) name = module.pous[type.pou].variables[p.index].name;
      return place_text(module, pou, p.parent, value_ids) + "." + name;
    }
    case Place::Kind::kElement: {
      const Type& type = module.types[pou.body.places[p.parent.index].type];
      return fmt::format("{}[{}]", place_text(module, pou, p.parent, value_ids),
                         type.lower + static_cast<std::int64_t>(p.index));
    }
    case Place::Kind::kPart: {
      const auto rep = module.types.rep_of(p.type).value_or(core::Rep::kBool);
      const std::string word = place_text(module, pou, p.parent, value_ids);
      if (rep == core::Rep::kBool) return fmt::format("{}.{}", word, p.index);
      const std::uint32_t bits = core::rep_bytes(rep) * 8;
      return fmt::format("{}.%{}{}", word, bits == 8 ? 'B' : bits == 16 ? 'W' : 'D', p.index / bits);
    }
    case Place::Kind::kCharacter:
    case Place::Kind::kElementAt:
      return fmt::format("{}[{}]", place_text(module, pou, p.parent, value_ids),
                         value_ids ? fmt::format("%{}", p.index) : index_text(module, pou, ValueId{p.index}));
  }
  return {};
}

std::string constant_text(const TypeTable& types, const Constant& constant) {
  const Type& type = types[constant.type];
  if (type.kind == TypeKind::kString) {
    std::string text = "'";
    for (const char c : constant.text) {
      const auto byte = static_cast<unsigned char>(c);
      text += byte >= 0x20 && byte < 0x7f && c != '\'' && c != '$' ? std::string(1, c) : fmt::format("${:02X}", byte);
    }
    return text + "'";
  }
  const auto rep = types.rep_of(constant.type).value_or(Rep::kU64);
  switch (rep) {
    case Rep::kBool:
      return constant.bits != 0 ? "TRUE" : "FALSE";
    case Rep::kF32:
      return fmt::format("{}", std::bit_cast<float>(static_cast<std::uint32_t>(constant.bits)));
    case Rep::kF64:
      return fmt::format("{}", std::bit_cast<double>(constant.bits));
    case Rep::kI8:
      return fmt::format("{}", static_cast<int>(static_cast<std::int8_t>(constant.bits)));
    case Rep::kI16:
      return fmt::format("{}", static_cast<std::int16_t>(constant.bits));
    case Rep::kI32:
      return fmt::format("{}", static_cast<std::int32_t>(constant.bits));
    case Rep::kI64:
      return fmt::format("{}", static_cast<std::int64_t>(constant.bits));
    default:
      return fmt::format("{}", constant.bits);
  }
}

namespace {

std::string_view role_word(Role role) {
  switch (role) {
    case Role::kInput:
      return "VAR_INPUT";
    case Role::kOutput:
      return "VAR_OUTPUT";
    case Role::kInOut:
      return "VAR_IN_OUT";
    case Role::kLocal:
      return "VAR";
    case Role::kTemp:
      return "VAR_TEMP";
    case Role::kExternal:
      return "VAR_EXTERNAL";
    case Role::kReturnValue:
      return "RETURN";
    case Role::kHidden:
      return "HIDDEN";
    case Role::kQueue:
      return "QUEUE";
  }
  return {};
}

class Printer {
 public:
  explicit Printer(const Module& module) : module_(module) {}

  std::string run() {
    for (const Global& g : module_.globals) {
      line("VAR_GLOBAL {}{}", g.list.empty() ? "" : g.list + ".", variable(g.variable));
    }
    for (const Task& t : module_.tasks) {
      line("TASK {} interval {} ns priority {}{}", t.name, t.period_ns, t.priority,
           t.single.empty() ? "" : " single " + t.single);
      for (const ProgramInstance& p : t.programs) line("  PROGRAM {} : {}", p.name, module_.pous[p.pou].name);
    }
    for (const Pou& p : module_.pous) pou(p);
    return std::move(out_);
  }

 private:
  template <class... Args>
  void line(fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), text, std::forward<Args>(args)...);
    out_ += '\n';
  }

  std::string variable(const Variable& v) {
    std::string text = v.name;
    if (!v.address.empty()) text += (text.empty() ? "AT " : " AT ") + v.address;
    text += " : " + module_.types.name_of(v.type);
    for (const InitItem& item : v.initial) {
      text += " :=";
      for (const std::uint32_t step : item.path) text += fmt::format(" .{}", step);
      text += " " + constant_text(module_.types, item.value);
    }
    if (v.constant) text += " CONSTANT";
    if (v.retain) text += " RETAIN";
    if (v.persistent) text += " PERSISTENT";
    if (v.nonretain) text += " NON_RETAIN";
    if (v.in_frame) text += " [frame]";
    return text;
  }

  void pou(const Pou& p) {
    static constexpr std::string_view kWords[] = {"PROGRAM", "FUNCTION_BLOCK", "FUNCTION"};
    line("{} {}{}{}", p.owner == Pou::kDeclared ? kWords[static_cast<std::size_t>(p.kind)] : "ACTION", p.name,
         p.return_type.valid() ? " : " + module_.types.name_of(p.return_type) : "", p.stub ? " [stub]" : "");
    for (const Variable& v : p.variables) line("  {} {}", role_word(v.role), variable(v));
    for (std::uint32_t i = 0; i < p.body.insts.size(); ++i) instruction(p, i);
  }

  void instruction(const Pou& p, std::uint32_t index) {
    const Inst& inst = p.body.insts[index];
    std::string text = operation(p, inst);
    const bool makes_value = inst.type.valid();
    text = makes_value ? fmt::format("  %{} := {}", index, text) : "  " + text;
    const SourceRef& at = p.body.sources[inst.source];
    if (at.local_id >= 0) {
      text = fmt::format("{:<52} ; {} {}", text, core::element_word(at.kind), at.local_id);
    } else if (at.line != 0 && at.kind != core::ElementKind::kNone) {
      text = fmt::format("{:<52} ; {} line {}", text, core::element_word(at.kind), at.line);
    }
    line("{}", text);
  }

  std::string operation(const Pou& p, const Inst& inst) {
    const auto place = [&](std::uint32_t id) { return place_text(module_, p, PlaceId{id}, true); };
    switch (inst.op) {
      case Op::kConst:
        return constant_text(module_.types, p.body.constants[inst.a]);
      case Op::kLoad:
        return "load " + place(inst.a);
      case Op::kStore:
        return fmt::format("store {} := %{}", place(inst.a), inst.b);
      case Op::kCopy:
        return fmt::format("copy {} := {}", place(inst.a), place(inst.b));
      case Op::kAnd:
        return fmt::format("%{} and %{}", inst.a, inst.b);
      case Op::kOr:
        return fmt::format("%{} or %{}", inst.a, inst.b);
      case Op::kXor:
        return fmt::format("%{} xor %{}", inst.a, inst.b);
      case Op::kNot:
        return fmt::format("not %{}", inst.a);
      case Op::kCall:
        return stdlib::key_of(*p.body.functions[inst.a]) + arguments(p, inst);
      case Op::kCallPou:
        return "call " + module_.pous[inst.a].name + call_arguments(p, inst);
      case Op::kRun:
        return "run " + place(inst.a) + (inst.b == 0 ? "" : ", action " + module_.pous[inst.b - 1].name);
      case Op::kLabel:
        return fmt::format("L{}:", inst.a);
      case Op::kJump:
        return fmt::format("jump L{}", inst.a);
      case Op::kJumpIf:
        return fmt::format("jump L{} if %{}", inst.a, inst.b);
      case Op::kJumpIfNot:
        return fmt::format("jump L{} if not %{}", inst.a, inst.b);
      case Op::kReturn:
        return "return";
      case Op::kClearEvent:
        return "clear event";
      case Op::kEno:
        return "eno";
      case Op::kMakeRef:
        return "ref " + place(inst.a);
      case Op::kSameRef:
        return fmt::format("same reference %{} %{}", inst.a, inst.b);
      case Op::kAddress:
        return "address of " + place(inst.a);
      case Op::kPointerRef:
        return fmt::format("ref through pointer %{}", inst.a);
      case Op::kPointerTo32:
        return fmt::format("32-bit address of %{}", inst.a);
      case Op::kPointerFrom32:
        return fmt::format("pointer of 32-bit address %{}", inst.a);
      case Op::kExtract:
        return fmt::format("extract %{} bit {} as {}", inst.a, inst.b, module_.types.name_of(inst.type));
      case Op::kInsert:
        return fmt::format("insert %{} bit {} := %{}", inst.a, inst.count, inst.b);
      case Op::kRange:
        return fmt::format("range %{} in {}", inst.a, module_.types.name_of(inst.type));
    }
    return {};
  }

  static std::string arguments(const Pou& p, const Inst& inst) {
    std::string text = "(";
    for (std::uint32_t i = 0; i < inst.count; ++i) {
      text += fmt::format("{}%{}", i ? ", " : "", p.body.args[inst.b + i].index);
    }
    return text + ")";
  }

  std::string call_arguments(const Pou& p, const Inst& inst) {
    std::string text = "(";
    for (std::uint32_t i = 0; i < inst.count; ++i) {
      const CallArg& arg = p.body.call_args[inst.b + i];
      const std::string& name = module_.pous[inst.a].variables[arg.variable].name;
      text += i ? ", " : "";
      text += arg.kind == CallArg::Kind::kOutput
                  ? fmt::format("{} => {}", name, place_text(module_, p, arg.place, true))
                  : fmt::format("{} := %{}", name, arg.value.index);
    }
    return text + ")";
  }

  const Module& module_;
  std::string out_;
};

}  // namespace

std::string print(const Module& module) { return Printer(module).run(); }

}  // namespace plc::ir
