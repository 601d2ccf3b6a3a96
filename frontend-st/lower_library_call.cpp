// Calls of what the library has: standard functions and those of several outputs, bounds of arrays, queues.
#include "core/text.h"
#include "frontend-st/lowering.h"
#include "frontend-st/static_type.h"
#include "frontend-st/suggestions.h"
#include "ir/queues.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::Role;
using ir::TypeKind;
using ir::TypeRef;
using ir::ValueId;

namespace {
std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }
}  // namespace

// INT_TO_BYTE(TRUNC(x)): the function tells the type where all of its overloads have one, and none that a DINT, which
// an open result is by itself, widens to.
Lowering::Expected Lowering::argument_type(std::string_view name, std::size_t i) {
  const auto overloads = stdlib::overloads_named(name);
  const core::TypeId type = overloads.front().param_type(i);
  const bool one = std::all_of(overloads.begin(), overloads.end(),
                               [&](const stdlib::Overload& o) { return o.param_type(i) == type; });
  const bool is_whole = core::in_category(type, core::kAnyInt | core::kAnyBit) && type != core::TypeId::kBool;
  const bool decides = type == core::TypeId::kDint || !stdlib::widens(core::TypeId::kDint, type);
  return one && is_whole && decides ? Expected(ir::ref_of(type)) : std::nullopt;
}

std::optional<Operand> Lowering::call_standard(NodeId id, std::string_view name, Expected expected) {
  const stdlib::Overload& first = stdlib::overloads_named(name).front();
  const stdlib::FunctionSpec& spec = *first.spec;
  // Room for every argument written: too many of them are builder_.call's to report, which lists what would fit.
  std::size_t count = spec.param_count;
  std::size_t written = 0;
  for (NodeId a = node(id).b; a != kNoNode; a = node(a).next) ++written;
  const bool named = written != 0 && node(node(id).b).argument != ArgumentKind::kPositional;
  if (spec.extensible || !named) count = std::max(count, written);
  std::vector<Parameter> parameters;
  count = std::min(count, stdlib::kMaxArguments);
  for (std::uint32_t i = 0; i < count; ++i) {
    parameters.push_back({stdlib::pin_name(spec, i), Role::kInput, i, {}, std::string(stdlib::pin_alias(spec, i))});
  }
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;

  std::optional<ValueId> enable;
  bool fine = true;
  if (arguments.en != kNoNode) {
    enable = condition(arguments.en, "input \"EN\" of " + std::string(name));
    fine = enable.has_value();
  }
  std::size_t used = 0;
  for (const Bound& b : arguments.bound) used = std::max<std::size_t>(used, b.parameter + 1u);
  std::vector<Operand> operands(used);
  for (Operand& o : operands) o.at = at(id);
  const bool wants_enum = expected && types()[*expected].kind == TypeKind::kEnum;
  const auto lower_arguments = [&] {
    for (const Bound& b : arguments.bound) {
      const auto given = value(node(b.argument).a, wants_enum ? expected : argument_type(name, b.parameter));
      fine = fine && given.has_value();
      if (given) operands[b.parameter] = *given;
    }
    return fine;
  };
  if (!enable && arguments.eno == kNoNode) {
    if (!lower_arguments()) return std::nullopt;
    const auto result = builder_.call(name, operands, at(id), expected_of(name, expected));
    if (!result) return std::nullopt;
    return operand(*result, id);
  }
  if (!fine) return std::nullopt;
  const ir::LabelId skip = builder_.new_label();
  const ir::LabelId done = builder_.new_label();
  if (enable) builder_.jump_if_not(*enable, skip);
  if (!lower_arguments()) return std::nullopt;
  builder_.clear_event();
  const auto result = builder_.call(name, operands, at(id), expected_of(name, expected));
  if (!result) return std::nullopt;
  const std::uint32_t kept = builder_.hidden("en", builder_.type_of(*result));
  const ValueId eno = builder_.eno();
  builder_.store(builder_.variable(kept), *result);
  if (arguments.eno != kNoNode && !deliver(arguments.eno, eno)) return std::nullopt;
  builder_.jump(done);
  builder_.bind(skip);
  if (arguments.eno != kNoNode && enable && !deliver(arguments.eno, builder_.constant_bool(false))) return std::nullopt;
  builder_.bind(done);
  return operand(builder_.load(builder_.variable(kept)), id);
}

// LOWER_BOUND(array, dimension), UPPER_BOUND(array, dimension).
std::optional<Operand> Lowering::call_array_bound(NodeId id, ir::ArrayBound bound) {
  const std::vector<Parameter> parameters{{"ARR", Role::kInput, 0, {}, {}}, {"DIM", Role::kInput, 1, {}, {}}};
  const std::string name(name_text(node(id).a));
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;
  if (arguments.bound.size() != parameters.size() || arguments.en != kNoNode || arguments.eno != kNoNode) {
    report(Code::P4010, at(id), name + " takes an array and the number of a dimension",
           "write " + name + "(values, 1)");
    return std::nullopt;
  }
  const Bound& first = arguments.bound[arguments.bound[0].parameter == 0 ? 0 : 1];
  const Bound& second = arguments.bound[arguments.bound[0].parameter == 0 ? 1 : 0];
  const auto array = place(node(first.argument).a, false);
  const auto dimension = value(node(second.argument).a, std::nullopt);
  if (!array || !dimension) return std::nullopt;
  auto result = ir::array_bound(builder_, bound, builder_.type_of(*array), *dimension, at(id));
  if (result) result->text = std::string(text(id));
  return result;
}

// QUEUE_PUT(queue, value), QUEUE_GET(queue, OUT => value), QUEUE_COUNT(queue), QUEUE_SPACE(queue): calls of the
// function that is made for this queue.
std::optional<Operand> Lowering::call_queue(NodeId id, ir::QueueFunction function, bool as_statement) {
  NodeId queue = kNoNode;
  for (NodeId argument = node(id).b; argument != kNoNode && queue == kNoNode; argument = node(argument).next) {
    const bool named = node(argument).argument != ArgumentKind::kPositional;
    if (!named || core::iequals(name_text(argument), "QUEUE")) queue = argument;
  }
  const std::string what = "in-out \"QUEUE\" of " + std::string(name_text(node(id).a));
  if (queue == kNoNode) {
    report(Code::P4010, at(id), what + " is not given", "name the global array that is the queue");
    return std::nullopt;
  }
  const auto where = place(node(queue).a, true);
  if (!where) return std::nullopt;
  const auto made = ir::queue_function(builder_, function, *where, at(queue), what);
  if (!made) return std::nullopt;
  return call_function(id, *made, as_statement);
}

// SPLIT_DATE(IN := d, YEAR => y): all outputs are computed before the first is delivered, whose variable may be read by
// the place of another.
std::optional<Operand> Lowering::call_bundle(NodeId id, const stdlib::BundleSpec& bundle, bool as_statement) {
  const std::string name(bundle.name);
  if (!as_statement) {
    report(Code::P4009, at(id), "function " + quoted(name) + " has no result to use in an expression",
           "call it as a statement of its own and take its outputs with =>");
    return std::nullopt;
  }
  std::vector<Parameter> parameters{
      {std::string(bundle.input.name), Role::kInput, 0, ir::ref_of(bundle.input.type.fixed), {}}};
  for (std::uint32_t i = 0; i < bundle.outputs.size(); ++i) {
    const stdlib::FunctionSpec& output = *bundle.outputs[i];
    parameters.push_back({std::string(stdlib::output_name(output)),
                          Role::kOutput,
                          i,
                          ir::ref_of(stdlib::usual_output_type(output)),
                          {}});
  }
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;
  std::optional<ValueId> enable;
  ir::LabelId skip{};
  ir::LabelId done{};
  if (arguments.en != kNoNode) {
    enable = condition(arguments.en, "input \"EN\" of " + name);
    if (!enable) return std::nullopt;
    skip = builder_.new_label();
    done = builder_.new_label();
    builder_.jump_if_not(*enable, skip);
  }
  Operand given;
  given.at = at(id);
  for (const Bound& bound : arguments.bound) {
    if (parameters[bound.parameter].role != Role::kInput) continue;
    const auto written = value(node(bound.argument).a, parameters[0].type);
    if (!written) return std::nullopt;
    given = *written;
  }
  const auto input = builder_.convert(given, parameters[0].type, "input " + quoted(parameters[0].name) + " of " + name);
  if (!input) return std::nullopt;
  if (arguments.eno != kNoNode) builder_.clear_event();
  const Operand argument = operand(*input, id);
  std::vector<std::pair<NodeId, ValueId>> deliveries;
  for (const Bound& bound : arguments.bound) {
    const Parameter& parameter = parameters[bound.parameter];
    if (parameter.role != Role::kOutput) continue;
    const stdlib::FunctionSpec& output = *bundle.outputs[parameter.index];
    TypeRef type = parameter.type;
    const auto target = static_type(ast_, source_, node(bound.argument).a, builder_.module(), &builder_.pou());
    const auto wanted = target ? types().elementary_of(*target) : std::nullopt;
    if (wanted && stdlib::output_takes(output, *wanted)) type = ir::ref_of(*wanted);
    const auto result = builder_.call(output.name, std::span(&argument, 1), at(id), type);
    if (!result) return std::nullopt;
    deliveries.emplace_back(bound.argument, *result);
  }
  std::optional<ValueId> eno;
  if (arguments.eno != kNoNode) eno = builder_.eno();
  bool fine = true;
  for (const auto& [target, result] : deliveries) fine = deliver(target, result) && fine;
  if (eno) fine = deliver(arguments.eno, *eno) && fine;
  if (enable) {
    builder_.jump(done);
    builder_.bind(skip);
    if (eno) fine = deliver(arguments.eno, builder_.constant_bool(false)) && fine;
    builder_.bind(done);
  }
  if (!fine) return std::nullopt;
  return Operand{};
}

}  // namespace plc::st
