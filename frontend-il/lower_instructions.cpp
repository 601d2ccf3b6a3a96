// Instructions: each becomes an expression or statement of ST whose leaf is the accumulator, so that types,
// conversions and calls follow the same rules.
#include <algorithm>
#include <utility>

#include "core/text.h"
#include "frontend-il/lowering.h"
#include "frontend-st/names.h"
#include "frontend-st/static_type.h"
#include "frontend-st/suggestions.h"

namespace plc::il {

using core::Code;
using ir::Operand;
using ir::TypeKind;
using st::kNoNode;
using st::Node;
using st::NodeId;
using st::NodeKind;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

// Numbers of what is given to the lowering of ST.
constexpr std::uint32_t kAccumulator = 0;
constexpr std::uint32_t kInner = 1;  ///< the value of a bracket

}  // namespace

void Lowering::fail(Code code, std::uint32_t at, std::string message, std::string help) {
  builder_.report(code, source_.locate(at), std::move(message), std::move(help));
  if (core::info(code).severity == core::Severity::kError) fine_ = false;
}

void Lowering::set(const std::optional<Operand>& value) {
  accumulator_ = {};
  accumulator_.state = value ? Accumulator::State::kValue : Accumulator::State::kFailed;
  if (value) accumulator_.value = *value;
  if (!value) fine_ = false;
}

std::optional<Operand> Lowering::needed(std::uint32_t begin) {
  if (accumulator_.state == Accumulator::State::kEmpty) {
    fail(Code::P4507, begin, "the accumulator has no value here", "begin with LD");
    accumulator_.state = Accumulator::State::kFailed;
  }
  if (accumulator_.state != Accumulator::State::kValue) return std::nullopt;
  if (accumulator_.called) {
    fail(Code::P4508, begin,
         "the accumulator is read after the call in line " + std::to_string(source_.locate(*accumulator_.called).line) +
             " and has the value of before",
         "load the value again: the standard leaves the accumulator undefined after CAL");
    accumulator_.called.reset();
  }
  return accumulator_.value;
}

Lowering::Expected Lowering::type_of(const Operand& operand) {
  if (operand.kind != Operand::Kind::kValue) return std::nullopt;
  return builder_.type_of(operand.value);
}

NodeId Lowering::given(const Instruction& one, std::uint32_t number, const Operand& operand) {
  st_.give(number, operand);
  Node node;
  node.kind = NodeKind::kGiven;
  node.given = number;
  node.begin = node.name = one.begin;
  node.end = node.name_end = one.end;
  return listing_.ast.add(node);
}

NodeId Lowering::negated(NodeId operand) {
  Node node;
  node.kind = NodeKind::kUnary;
  node.op = st::Operator::kNot;
  node.begin = listing_.ast[operand].begin;
  node.end = listing_.ast[operand].end;
  node.a = operand;
  return listing_.ast.add(node);
}

std::optional<NodeId> Lowering::right_of(const Instruction& one, NodeId operand, const Operand& accumulator,
                                         bool literal) {
  if (!one.negated) return operand;
  const Expected type = type_of(accumulator);
  if (!literal || !type) return negated(operand);
  const auto value = st_.value(negated(operand), type);
  if (!value) return std::nullopt;
  return given(one, kInner, *value);
}

NodeId Lowering::binary(const Instruction& one, NodeId left, NodeId right) {
  Node node;
  node.kind = NodeKind::kBinary;
  node.op = one.op;
  node.begin = one.begin;
  node.end = std::max(one.end, listing_.ast[right].end);
  node.a = left;
  node.b = right;
  return listing_.ast.add(node);
}

void Lowering::lower(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  builder_.set_source(at(one));
  builder_.probe_reached(ir::ProbeKey::text(at(one), ir::ProbeSide::kWhole));
  execute(one, index);
  // Beside an instruction stands what it leaves in the accumulator.
  if (accumulator_.state == Accumulator::State::kValue) {
    builder_.probe(ir::ProbeKey::text(at(one), ir::ProbeSide::kOutput), accumulator_.value);
  }
}

void Lowering::execute(const Instruction& one, std::uint32_t index) {
  switch (one.kind) {
    case Kind::kLoad:
      return load(one, index);
    case Kind::kStore:
      return store(one);
    case Kind::kSet:
    case Kind::kReset:
      return set_or_reset(one);
    case Kind::kNot:
      return negate(index);
    case Kind::kBinary:
      return one.opens ? open_bracket(index) : combine(index);
    case Kind::kClose:
      return close_bracket(index);
    case Kind::kJump:
    case Kind::kReturn:
      return end(one);
    case Kind::kCall:
      return call(index);
    case Kind::kInput:
      return give_input(one, one.operand);
    case Kind::kFunction:
      return call_function(one, index);
    case Kind::kBroken:
      return set(std::nullopt);
  }
}

void Lowering::load(const Instruction& one, std::uint32_t index) {
  const bool literal = one.negated && listing_.ast[one.operand].kind == NodeKind::kLiteral;
  auto value = st_.value(one.negated ? negated(one.operand) : one.operand,
                         literal ? wanted_type(block_, index + 1) : std::nullopt);
  // A structure is what it is now, whatever is written to it before it is stored.
  if (value && value->kind == Operand::Kind::kValue && !types().rep_of(builder_.type_of(value->value))) {
    const ir::PlaceId copy = builder_.variable(builder_.hidden("loaded", builder_.type_of(value->value)));
    if (builder_.assign(copy, *value, "the accumulator")) {
      value->value = builder_.load(copy);
    } else {
      value.reset();
    }
  }
  set(value);
}

void Lowering::store(const Instruction& one) {
  const auto value = needed(one.begin);
  if (!value) {
    // What is wrong with the operand is an error of its own.
    for (NodeId to = one.operand; to != kNoNode; to = listing_.ast[to].next) st_.place(to, true);
    return;
  }
  for (NodeId to = one.operand; to != kNoNode; to = listing_.ast[to].next) {
    const NodeId accumulator = given(one, kAccumulator, *value);
    Node node;
    node.kind = NodeKind::kAssign;
    node.begin = listing_.ast[to].begin;
    node.end = listing_.ast[to].end;
    node.a = to;
    node.b = one.negated ? negated(accumulator) : accumulator;
    fine_ = st_.statements(listing_.ast.add(node)) && fine_;
  }
}

void Lowering::set_or_reset(const Instruction& one) {
  const auto value = needed(one.begin);
  for (NodeId to = one.operand; to != kNoNode; to = listing_.ast[to].next) {
    const auto type = st::static_type(listing_.ast, source_, to, builder_.module(), &builder_.pou());
    const TypeKind kind = type ? types()[*type].kind : TypeKind::kElementary;
    // S and R of an instance are its inputs of these names (IEC 61131-3:2013, table 70).
    if (kind == TypeKind::kBlock || kind == TypeKind::kPou) {
      give_input(one, to);
      continue;
    }
    const auto where = st_.place(to, true);
    if (!where) {
      fine_ = fine_ && st_.stub_used();
      continue;
    }
    if (builder_.type_of(*where) != ir::kBoolType) {
      fail(Code::P4101, one.begin,
           std::string(word(one)) + " needs a variable of type BOOL, " +
               quoted(source_.slice(listing_.ast[to].begin, listing_.ast[to].end)) + " is " +
               types().name_of(builder_.type_of(*where)));
      continue;
    }
    const auto condition =
        value ? builder_.convert(*value, ir::kBoolType, "the accumulator before " + quoted(word(one))) : std::nullopt;
    if (!condition) {
      fine_ = false;
      continue;
    }
    const ir::ValueId before = builder_.load(*where);
    builder_.store(*where, one.kind == Kind::kSet ? builder_.logic(ir::Op::kOr, before, *condition)
                                                  : builder_.logic(ir::Op::kAnd, before, builder_.not_(*condition)));
  }
}

void Lowering::negate(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  const auto value = needed(one.begin);
  if (!value) return;
  const Expected expected = expected_after(index, *value);
  set(st_.value(negated(given(one, kAccumulator, *value)), expected));
}

/// The type that what is made of a literal is to have: of what it meets later.
Lowering::Expected Lowering::expected_after(std::uint32_t index, const Operand& accumulator) {
  if (accumulator.kind == Operand::Kind::kValue) return std::nullopt;
  return wanted_type(block_, index + 1);
}

// ADD 1, 2 is ADD 1 and ADD 2.
void Lowering::combine(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  for (NodeId operand = one.operand; operand != kNoNode;) {
    const NodeId next = std::exchange(listing_.ast.nodes[operand].next, kNoNode);
    const auto value = needed(one.begin);
    if (!value) {
      st_.value(operand, std::nullopt);
    } else {
      const auto right = right_of(one, operand, *value, listing_.ast[operand].kind == NodeKind::kLiteral);
      const NodeId left = given(one, kAccumulator, *value);
      set(right ? st_.value(binary(one, left, *right), expected_after(index, *value)) : std::nullopt);
    }
    operand = next;
  }
}

void Lowering::open_bracket(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  const auto value = needed(one.begin);
  brackets_.push_back({index, accumulator_});
  accumulator_ = {};
  if (one.operand == kNoNode) return;
  set(st_.value(one.operand, value ? type_of(*value) : std::nullopt));
}

void Lowering::close_bracket(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  if (brackets_.empty()) return set(std::nullopt);  // its beginning was reported
  const Bracket bracket = brackets_.back();
  brackets_.pop_back();
  const auto inner = needed(one.begin);
  const Instruction& opener = listing_.instructions[bracket.instruction];
  accumulator_ = bracket.before;
  if (!inner || accumulator_.state != Accumulator::State::kValue) {
    accumulator_ = {};
    accumulator_.state = Accumulator::State::kFailed;
    return;
  }
  builder_.set_source(at(opener));
  const NodeId left = given(opener, kAccumulator, accumulator_.value);
  const bool literal = inner->kind != Operand::Kind::kValue;
  const auto right = right_of(opener, given(opener, kInner, *inner), accumulator_.value, literal);
  const Expected expected = expected_after(index, accumulator_.value);
  set(right ? st_.value(binary(opener, left, *right), expected) : std::nullopt);
}

std::optional<ir::ValueId> Lowering::condition(const Instruction& one) {
  const auto value = needed(one.begin);
  if (!value) return std::nullopt;
  const auto out = builder_.convert(*value, ir::kBoolType, "the condition of " + std::string(word(one)));
  fine_ = fine_ && out;
  return out;
}

void Lowering::end(const Instruction& one) {
  if (one.condition != Condition::kAlways) jump_condition_ = condition(one);
  if (one.kind != Kind::kReturn || gives_value_) return;
  if (one.condition == Condition::kAlways) return builder_.ret();
  if (!jump_condition_) return;
  const ir::LabelId stay = builder_.new_label();
  one.condition == Condition::kIfTrue ? builder_.jump_if_not(*jump_condition_, stay)
                                      : builder_.jump_if(*jump_condition_, stay);
  builder_.ret();
  builder_.bind(stay);
}

void Lowering::call(std::uint32_t index) {
  const Instruction& one = listing_.instructions[index];
  const NodeId callee = listing_.ast[one.operand].a;
  const Node& named = listing_.ast[callee];
  const std::string_view name = source_.slice(named.begin, named.end);
  if (named.kind == NodeKind::kName && st::names_function(builder_.module(), builder_.pou(), name)) {
    if (one.condition != Condition::kAlways) {
      fail(Code::P4509, one.begin, quoted(name) + " is a function, which " + quoted(word(one)) + " does not call",
           "jump over it: JMPC and JMPCN have conditions, functions have none");
      return set(std::nullopt);
    }
    fail(Code::P4510, one.begin, quoted(name) + " is a function and is called with CAL",
         "the name of a function is an operator by itself: " + core::uppered(name));
    Instruction function = one;
    function.kind = Kind::kFunction;
    function.formal = listing_.ast[one.operand].b != kNoNode || named.end < listing_.ast[one.operand].end;
    if (!function.formal) {
      function.begin = named.begin;
      function.end = named.end;
      function.operand = kNoNode;
    }
    return call_function(function, index);
  }
  ir::LabelId stay{};
  if (one.condition != Condition::kAlways) {
    const auto asked = condition(one);
    stay = builder_.new_label();
    if (asked) {
      one.condition == Condition::kIfTrue ? builder_.jump_if_not(*asked, stay) : builder_.jump_if(*asked, stay);
    }
  }
  Node node;
  node.kind = NodeKind::kCallStatement;
  node.begin = listing_.ast[one.operand].begin;
  node.end = listing_.ast[one.operand].end;
  node.a = one.operand;
  fine_ = st_.statements(listing_.ast.add(node)) && fine_;
  if (stay.valid()) builder_.bind(stay);
  if (accumulator_.state == Accumulator::State::kValue) accumulator_.called = one.begin;
}

// The accumulator goes to one input, and the instance runs.
void Lowering::give_input(const Instruction& one, NodeId instance) {
  const auto value = needed(one.begin);
  if (!value) return;
  Node argument;
  argument.kind = NodeKind::kArgument;
  argument.argument = st::ArgumentKind::kInput;
  argument.begin = argument.name = one.begin;
  argument.end = argument.name_end = one.end;
  argument.a = given(one, kAccumulator, *value);
  Node call;
  call.kind = NodeKind::kCall;
  call.begin = listing_.ast[instance].begin;
  call.end = listing_.ast[instance].end;
  call.b = listing_.ast.add(argument);
  call.a = instance;
  Node statement;
  statement.kind = NodeKind::kCallStatement;
  statement.begin = one.begin;
  statement.end = call.end;
  statement.a = listing_.ast.add(call);
  fine_ = st_.statements(listing_.ast.add(statement)) && fine_;
}

void Lowering::call_function(const Instruction& one, std::uint32_t index) {
  const NodeId callee = one.formal ? listing_.ast[one.operand].a : kNoNode;
  const std::string_view name =
      callee == kNoNode ? word(one) : source_.slice(listing_.ast[callee].begin, listing_.ast[callee].end);
  ir::Module& module = builder_.module();
  if (!st::names_function(module, builder_.pou(), name)) {
    const st::Named named = st::find_name(module, builder_.pou(), name);
    const bool stub = !named.is_place() && module.options.stub_missing;
    if (!stub && builder_.is_broken(name, at(one))) return set(std::nullopt);
    if (!stub) {
      std::string help = operator_meant(name);
      if (help.empty()) help = st::function_meant(module, builder_.pou(), name);
      if (named.is_place()) help = "an instance is called with CAL, a value loaded with LD";
      if (help.empty()) help = "an instruction begins with an operator, as LD, or with the name of a function";
      fail(Code::P4502, one.begin, quoted(name) + " is neither an operator nor a function", std::move(help));
      return set(std::nullopt);
    }
  }
  NodeId call = one.operand;
  if (!one.formal) {
    const auto value = needed(one.begin);
    if (!value) return;
    Node function;
    function.kind = NodeKind::kName;
    function.begin = function.name = one.begin;
    function.end = function.name_end = one.end;
    Node node;
    node.kind = NodeKind::kCall;
    node.begin = one.begin;
    node.end = one.end;
    node.a = listing_.ast.add(function);
    const auto add = [&](NodeId argument_value) {
      Node argument;
      argument.kind = NodeKind::kArgument;
      argument.begin = listing_.ast[argument_value].begin;
      argument.end = listing_.ast[argument_value].end;
      argument.a = argument_value;
      return listing_.ast.add(argument);
    };
    NodeId last = node.b = add(given(one, kAccumulator, *value));
    for (NodeId operand = one.operand; operand != kNoNode;) {
      const NodeId next = std::exchange(listing_.ast.nodes[operand].next, kNoNode);
      const NodeId argument = add(operand);
      listing_.ast.nodes[last].next = argument;
      last = argument;
      operand = next;
    }
    node.end = std::max(node.end, listing_.ast[last].end);
    call = listing_.ast.add(node);
  }
  const auto pou = module.pou_by_name.find(name);
  const bool own = pou != module.pou_by_name.end() && module.pous[pou->second].kind == ir::PouKind::kFunction;
  const bool has_result = own ? module.pous[pou->second].return_type.valid() : stdlib::bundle_named(name) == nullptr;
  if (has_result) return set(st_.value(call, wanted_type(block_, index + 1)));
  Node statement;
  statement.kind = NodeKind::kCallStatement;
  statement.begin = one.begin;
  statement.end = listing_.ast[call].end;
  statement.a = call;
  fine_ = st_.statements(listing_.ast.add(statement)) && fine_;
}

}  // namespace plc::il
