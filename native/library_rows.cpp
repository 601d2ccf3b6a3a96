#include "native/library_rows.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace plc::native {

using core::TypeId;
using stdlib::BlockSpec;
using stdlib::Kernel;
using stdlib::Overload;

const Overload* overload_of(Kernel kernel) {
  static const auto known = [] {
    std::unordered_map<Kernel, const Overload*> map;
    for (const Overload& overload : stdlib::overloads()) map.try_emplace(overload.kernel, &overload);
    return map;
  }();
  const auto found = known.find(kernel);
  return found == known.end() ? nullptr : found->second;
}

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

bool is_number(TypeId id) { return core::in_category(id, core::kAnyNum | core::kAnyBit); }

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
