#include "native/library_rows.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace plc::native {

using core::TypeId;
using stdlib::BlockSpec;
using stdlib::Kernel;
using stdlib::Overload;

namespace {
/// Numbers and bits: types that count nothing but themselves.
bool is_number(TypeId id) { return core::in_category(id, core::kAnyNum | core::kAnyBit); }

}  // namespace

std::optional<Type> machine_type(TypeId id) {
  switch (core::rep_of(id)) {
    case core::Rep::kBool:
    case core::Rep::kU8:
      return Type::kU8;
    case core::Rep::kI8:
      return Type::kI8;
    case core::Rep::kI16:
      return Type::kI16;
    case core::Rep::kU16:
      return Type::kU16;
    case core::Rep::kI32:
      return Type::kI32;
    case core::Rep::kU32:
      return Type::kU32;
    case core::Rep::kI64:
      return Type::kI64;
    case core::Rep::kU64:
      return Type::kU64;
    case core::Rep::kF32:
      return Type::kF32;
    case core::Rep::kF64:
      return Type::kF64;
    default:
      return std::nullopt;
  }
}

std::optional<FunctionRow> function_of(Kernel kernel) {
  const Overload* const overload = stdlib::overload_with_kernel(kernel);
  if (overload == nullptr) return std::nullopt;
  const auto type = machine_type(overload->spec->t_categories != 0 ? overload->t : overload->param_type(0));
  if (!type) return std::nullopt;
  static constexpr std::pair<std::string_view, Function> kNames[] = {
      {"SEL", Function::kSelect},     {"MIN", Function::kLeast},       {"MAX", Function::kGreatest},
      {"LIMIT", Function::kLimit},    {"ABS", Function::kAbsolute},    {"SQRT", Function::kSquareRoot},
      {"NOT", Function::kNot},        {"SHL", Function::kShiftLeft},   {"SHR", Function::kShiftRight},
      {"ROL", Function::kRotateLeft}, {"ROR", Function::kRotateRight}, {"*_TO_*", Function::kConvert},
      {"TO_*", Function::kConvert}};
  const std::string_view name = overload->spec->name;
  const auto found =
      std::find_if(std::begin(kNames), std::end(kNames), [name](const auto& row) { return row.first == name; });
  if (found == std::end(kNames)) return std::nullopt;
  switch (found->second) {
    case Function::kAbsolute:
      if (is_real(*type) || !is_signed(*type)) return std::nullopt;
      break;
    case Function::kShiftLeft:
    case Function::kShiftRight:
    case Function::kRotateLeft:
    case Function::kRotateRight:
      if (overload->t == TypeId::kBool) return std::nullopt;
      break;
    case Function::kConvert:
      if (!is_number(overload->t) || !is_number(overload->u)) return std::nullopt;
      break;
    default:
      break;
  }
  return FunctionRow{found->second, overload, *type};
}

std::optional<BlockRow> block_of(stdlib::Step step) {
  // Rows whose steps are one function differ in their names alone.
  const auto blocks = stdlib::blocks();
  const auto spec = std::find_if(blocks.begin(), blocks.end(), [step](const BlockSpec& b) { return b.step == step; });
  if (spec == blocks.end()) return std::nullopt;
  // "TON", or "TON_LTIME".
  const std::string_view name = spec->name.substr(0, spec->name.find('_'));
  static constexpr std::pair<std::string_view, Block> kNames[] = {
      {"R_TRIG", Block::kRisingEdge}, {"F_TRIG", Block::kFallingEdge}, {"SR", Block::kSetDominant},
      {"RS", Block::kResetDominant},  {"TON", Block::kOnDelay},        {"TOF", Block::kOffDelay},
      {"TP", Block::kPulse},          {"CTU", Block::kCountUp},        {"CTD", Block::kCountDown}};
  for (const auto& [known, block] : kNames) {
    if (known == spec->name || known == name) return BlockRow{block, &*spec};
  }
  return std::nullopt;
}

}  // namespace plc::native
