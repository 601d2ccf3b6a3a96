// Statements that only tests have (ir/test_calls.def). Each becomes a call of the component through which a test talks
// to its runner; what an ASSERT_ compares is kept in hidden variables when it fails.
#include <algorithm>

#include "frontend-st/lowering.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::TestCall;
using ir::TypeKind;
using ir::TypeRef;
using ir::ValueId;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// The standard function that compares "actual" with the first argument, which stands on its right side.
std::string_view comparison_of(TestCall call) {
  switch (call) {
    case TestCall::kAssertEq:
      return "EQ";
    case TestCall::kAssertNe:
      return "NE";
    case TestCall::kAssertLt:
      return "LT";
    case TestCall::kAssertLe:
      return "LE";
    case TestCall::kAssertGt:
      return "GT";
    default:
      return "GE";
  }
}

std::size_t argument_count(const ir::TestCallInfo& info) {
  return 1 + static_cast<std::size_t>(std::count(info.arguments.begin(), info.arguments.end(), ','));
}

}  // namespace

bool Lowering::refuse_test_call(NodeId id, const ir::TestCallInfo& info, const std::string& why) {
  report(Code::P7901, at(id), std::string(info.name) + ": " + why,
         "write " + std::string(info.name) + "(" + std::string(info.arguments) + ");");
  return false;
}

bool Lowering::test_call(NodeId id, const ir::TestCallInfo& info) {
  std::vector<NodeId> arguments;
  for (NodeId one = node(id).b; one != kNoNode; one = node(one).next) {
    if (node(one).argument != ArgumentKind::kPositional)
      return refuse_test_call(one, info, "arguments are given without names");
    arguments.push_back(node(one).a);
  }
  const bool asserts = info.call <= TestCall::kAssertNear;
  std::string message;
  std::size_t wanted = argument_count(info);
  if (asserts && arguments.size() == wanted + 1) {
    const std::string_view last = text(arguments.back());
    if (!last.starts_with('\'')) return refuse_test_call(arguments.back(), info, "the last argument is a text in ''");
    message = last.substr(1, last.size() - 2);
    arguments.pop_back();
  }
  if (info.call == TestCall::kRunCycles && arguments.empty()) wanted = 0;
  if (arguments.size() != wanted) {
    return refuse_test_call(
        id, info, "has " + std::to_string(arguments.size()) + " arguments, and needs " + std::to_string(wanted));
  }
  switch (info.call) {
    case TestCall::kAssertTrue:
    case TestCall::kAssertFalse:
      return assert_condition(id, info, arguments[0], std::move(message));
    case TestCall::kAssertNear:
      return assert_near(id, info, arguments, std::move(message));
    case TestCall::kAdvanceTime:
      return advance_time(id, arguments[0]);
    case TestCall::kRunCycles:
      return run_cycles(id, info, arguments);
    case TestCall::kSetClock:
      return set_clock(arguments[0]);
    case TestCall::kMock:
      return mock(id, info, arguments[0], arguments[1]);
    case TestCall::kUnmock:
      return mock(id, info, arguments[0], kNoNode);
    default:
      return assert_comparison(id, info, arguments, std::move(message));
  }
}

void Lowering::call_host(TestCall call, std::initializer_list<std::pair<const char*, ValueId>> inputs) {
  const PlaceId host = builder_.variable(builder_.pou().by_name.find(ir::kTestHostName)->second);
  const TypeRef number = ir::ref_of(core::TypeId::kUdint);
  builder_.store(*builder_.member(host, ir::kTestHostCall), integer(number, static_cast<std::int64_t>(call)));
  for (const auto& [name, given] : inputs) builder_.store(*builder_.member(host, name), given);
  builder_.run(host);
}

std::string Lowering::keep_for_message(std::string_view hint, ValueId kept) {
  const std::uint32_t variable = builder_.hidden(hint, builder_.type_of(kept));
  builder_.store(builder_.variable(variable), kept);
  return builder_.pou().variables[variable].name;
}

// The values are stored where the assertion fails alone: most hold.
void Lowering::assert_that(NodeId id, ir::Assertion assertion, ValueId holds, std::span<const ValueId> kept) {
  ir::TestBench& bench = *builder_.module().bench;
  const ir::LabelId good = builder_.new_label();
  builder_.jump_if(holds, good);
  std::string* const names[] = {&assertion.expected, &assertion.got, &assertion.tolerance};
  static constexpr std::string_view kHints[] = {"expected", "got", "tolerance"};
  for (std::size_t i = 0; i < kept.size(); ++i) *names[i] = keep_for_message(kHints[i], kept[i]);
  builder_.bind(good);
  assertion.at = at(id);
  assertion.test = builder_.pou_index();
  const auto site = static_cast<std::int64_t>(bench.assertions.size());
  bench.assertions.push_back(std::move(assertion));
  call_host(bench.assertions.back().call,
            {{ir::kTestHostSite, integer(ir::ref_of(core::TypeId::kUdint), site)}, {ir::kTestHostHolds, holds}});
}

bool Lowering::assert_condition(NodeId id, const ir::TestCallInfo& info, NodeId argument, std::string message) {
  const auto given = condition(argument, "condition of " + std::string(info.name));
  if (!given) return false;
  const ValueId holds = info.call == TestCall::kAssertTrue ? *given : builder_.not_(*given);
  assert_that(id, {info.call, {}, 0, std::string(text(argument)), std::move(message), {}, {}, {}}, holds, {});
  return true;
}

std::optional<Lowering::Compared> Lowering::compared_values(const ir::TestCallInfo& info, NodeId first, NodeId second) {
  auto got = value(second, std::nullopt);
  if (!got) return std::nullopt;
  const auto type_of = [this](const Operand& operand) -> Expected {
    return operand.kind == Operand::Kind::kValue ? std::optional(builder_.type_of(operand.value)) : std::nullopt;
  };
  auto expected = value(first, type_of(*got));
  if (!expected) return std::nullopt;
  const std::string what = "argument of " + std::string(info.name);
  const auto settled = [&](const Operand& operand, Expected type) {
    return operand.kind != Operand::Kind::kValue && type ? builder_.convert(operand, *type, what)
                                                         : builder_.settle(operand, type);
  };
  const auto right = settled(*expected, type_of(*got));
  const auto left = settled(*got, right ? Expected(builder_.type_of(*right)) : std::nullopt);
  if (!left || !right) return std::nullopt;
  for (const auto& [side, written] : {std::pair(*left, second), std::pair(*right, first)}) {
    const TypeRef type = builder_.type_of(side);
    if (types().elementary_of(type)) continue;
    refuse_test_call(
        written, info,
        quoted(text(written)) + " is of type " + types().name_of(type) + ", compare its elements or members");
    return std::nullopt;
  }
  return Compared{*right, *left};
}

bool Lowering::assert_comparison(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments,
                                 std::string message) {
  const auto both = compared_values(info, arguments[0], arguments[1]);
  if (!both) return false;
  const auto holds = compare(comparison_of(info.call), both->got, both->expected, id);
  if (!holds) return false;
  const ValueId kept[] = {both->expected, both->got};
  assert_that(id, {info.call, {}, 0, std::string(text(arguments[1])), std::move(message), {}, {}, {}}, *holds, kept);
  return true;
}

std::optional<ValueId> Lowering::as_lreal(NodeId id, const Operand& given, std::string_view what) {
  const TypeRef lreal = ir::ref_of(core::TypeId::kLreal);
  if (given.kind == Operand::Kind::kValue) {
    const auto type = types().elementary_of(builder_.type_of(given.value));
    if (type && core::in_category(*type, core::kAnyInt))
      return builder_.call(std::string(core::name_of(*type)) + "_TO_LREAL", std::span(&given, 1), at(id));
  }
  return builder_.convert(given, lreal, what);
}

// Numbers are compared as LREAL, durations as what they are.
bool Lowering::assert_near(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments,
                           std::string message) {
  const auto got = value(arguments[1], std::nullopt);
  if (!got) return false;
  const TypeRef type = got->kind == Operand::Kind::kValue ? builder_.type_of(got->value) : ir::kBoolType;
  const bool time = type == ir::ref_of(core::TypeId::kTime) || type == ir::ref_of(core::TypeId::kLtime);
  const std::string what = "argument of " + std::string(info.name);
  ValueId values[3];  // expected, got, tolerance
  constexpr std::size_t kOrder[] = {1, 0, 2};
  for (const std::size_t i : kOrder) {
    const auto given = i == 1 ? got : value(arguments[i], time ? type : ir::ref_of(core::TypeId::kLreal));
    const auto one = !given ? std::nullopt
                     : time ? builder_.convert(*given, type, what)
                            : as_lreal(arguments[i], *given, what);
    if (!one) return false;
    values[i] = *one;
  }
  const auto call = [&](std::string_view function, ValueId a, ValueId b) { return compare(function, a, b, id); };
  const auto highest = call("ADD", values[0], values[2]);
  const auto lowest = call("SUB", values[0], values[2]);
  if (!highest || !lowest) return false;
  const auto below = call("LE", values[1], *highest);
  const auto above = call("GE", values[1], *lowest);
  if (!below || !above) return false;
  assert_that(id, {info.call, {}, 0, std::string(text(arguments[1])), std::move(message), {}, {}, {}},
              builder_.logic(ir::Op::kAnd, *below, *above), values);
  return true;
}

bool Lowering::advance_time(NodeId id, NodeId argument) {
  const TypeRef time = ir::ref_of(core::TypeId::kTime);
  auto given = value(argument, time);
  if (!given) return false;
  const bool wide = given->kind == Operand::Kind::kValue &&
                    types().elementary_of(builder_.type_of(given->value)) == core::TypeId::kLtime;
  const auto span = wide ? builder_.call("LTIME_TO_TIME", std::span(&*given, 1), at(id))
                         : builder_.convert(*given, time, "argument of ADVANCE_TIME");
  if (!span) return false;
  call_host(TestCall::kAdvanceTime, {{ir::kTestHostSpan, *span}});
  return true;
}

bool Lowering::set_clock(NodeId argument) {
  const TypeRef wide = ir::ref_of(core::TypeId::kLdt);
  const auto given = value(argument, wide);
  const auto date = given ? builder_.convert(*given, wide, "argument of SET_CLOCK") : std::nullopt;
  if (!date) return false;
  call_host(TestCall::kSetClock, {{ir::kTestHostDate, *date}});
  return true;
}

bool Lowering::run_cycles(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments) {
  if (!builder_.module().bench->runs_tasks) {
    report(Code::P7903, at(id), std::string(info.name) + ": no task of the project runs a program",
           "call function blocks of the test itself, with ADVANCE_TIME between the calls; or give the project a task");
    return false;
  }
  const TypeRef number = ir::ref_of(core::TypeId::kLint);
  std::optional<ValueId> count = integer(number, 1);
  if (!arguments.empty()) {
    const auto given = value(arguments[0], number);
    count = given ? builder_.convert(*given, number, "argument of RUN_CYCLES") : std::nullopt;
  }
  if (!count) return false;
  call_host(TestCall::kRunCycles, {{ir::kTestHostCycles, *count}});
  return true;
}

// The output's value and whether it is mocked are hidden variables of the POU that runs the block (Builder::run).
bool Lowering::mock(NodeId id, const ir::TestCallInfo& info, NodeId output, NodeId given) {
  const auto where = place(output, true);
  if (!where) return false;
  const ir::Place target = builder_.body().places[where->index];
  const auto refuse = [&] {
    report(Code::P7905, at(id),
           std::string(info.name) + ": " + quoted(text(output)) + " is no output of a block " +
               "that is a variable of a program or function block",
           "name the output by its path, as in Main.pump.Running");
    return false;
  };
  if (target.kind != ir::Place::Kind::kField) return refuse();
  const ir::Place instance = builder_.body().places[target.parent.index];
  const bool own = instance.kind == ir::Place::Kind::kInstance;
  const bool inner =
      instance.kind == ir::Place::Kind::kField && types()[builder_.type_of(instance.parent)].kind == TypeKind::kPou;
  if (!own && !inner) return refuse();
  const std::uint32_t owner = own ? builder_.pou_index() : types()[builder_.type_of(instance.parent)].pou;
  const std::vector<ir::Mock>& mocks = builder_.module().pous[owner].mocks;
  const auto found = std::find_if(mocks.begin(), mocks.end(), [&](const ir::Mock& one) {
    return one.variable == instance.index && one.output == target.index;
  });
  if (found == mocks.end()) return refuse();
  const ir::Mock made = *found;
  const auto hidden = [&](std::uint32_t variable) {
    return own ? builder_.variable(variable) : builder_.field(instance.parent, variable);
  };
  if (given == kNoNode) {
    builder_.store(hidden(made.active), builder_.constant_bool(false));
    return true;
  }
  const auto wanted = value(given, builder_.type_of(*where));
  if (!wanted || !builder_.assign(hidden(made.value), *wanted, "mocked output " + quoted(text(output)))) return false;
  builder_.store(hidden(made.active), builder_.constant_bool(true));
  builder_.store(*where, builder_.load(hidden(made.value)));
  return true;
}

}  // namespace plc::st
