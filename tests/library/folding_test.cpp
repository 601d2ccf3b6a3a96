// Constant folding: what the compiler computes of constants is what the kernel gives, and it computes all that is exact
// and without an event, and nothing else.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/library/values.h"
#include "tests/support/module_builder.h"

namespace plc::test {
namespace {

constexpr std::size_t kLists = 200;

/// The call on constants, as the front ends make it; the bits of the result if that is a constant.
std::optional<std::uint64_t> folded(const Overload& overload, std::span<const Value> arguments, ir::Builder& builder) {
  std::vector<ir::Operand> operands;
  for (const Value& argument : arguments) {
    operands.push_back(ir::Operand::of(builder.constant({ir::ref_of(argument.type), argument.bits, {}}), {}));
  }
  const auto result = builder.call(overload.name, operands, {}, ir::ref_of(overload.result_type()));
  if (!result) {
    ADD_FAILURE() << stdlib::key_of(overload) << shown(arguments) << " is refused";
    return std::nullopt;
  }
  const ir::Inst& inst = builder.body().insts[result->index];
  if (inst.op != ir::Op::kConst) return std::nullopt;
  EXPECT_EQ(builder.type_of(*result), ir::ref_of(overload.result_type())) << stdlib::key_of(overload);
  return builder.body().constants[inst.a].bits;
}

/// Functions of BOOL that become logic of the body, or nothing at all: no calls that could be folded.
bool is_logic(const Overload& overload) {
  for (const std::string_view name : {"AND", "OR", "XOR", "NOT", "EQ", "NE", "SEL", "MOVE"}) {
    if (overload.name == name && overload.t == TypeId::kBool) return true;
  }
  return false;
}

/// TO_BIG_ENDIAN makes NaNs of other bits than the one NaN that images hold.
bool is_foreign_nan(const Value& value) {
  return core::in_category(value.type, core::kAnyReal) && std::isnan(real_of(value)) &&
         value != real_value(value.type, real_of(value));
}

TEST(Folding, GivesWhatTheKernelGivesWhereItIsExactAndWithoutEvent) {
  for (const Overload& overload : stdlib::overloads()) {
    const std::size_t count = overload.spec->param_count;
    bool scalar = !is_string(overload.result_type());
    for (std::size_t i = 0; i < count; ++i) scalar = scalar && !is_string(overload.param_type(i));
    if (!scalar || is_logic(overload)) continue;
    ModuleBuilder module;
    ir::Builder builder = module.body(module.pou("P"));
    for (const Arguments& list : argument_lists(overload, count, kLists)) {
      const std::vector<Value> arguments = values_of(list);
      const Outcome kernel = call_kernel(overload, arguments);
      const auto got = folded(overload, arguments, builder);
      const bool computes = overload.spec->foldable && kernel.event == Event::kNone && !is_foreign_nan(kernel.result);
      ASSERT_EQ(got.has_value(), computes) << stdlib::key_of(overload) << shown(arguments);
      if (!got) continue;
      ASSERT_EQ(*got, kernel.result.bits) << stdlib::key_of(overload) << shown(arguments);
    }
  }
}

}  // namespace
}  // namespace plc::test
