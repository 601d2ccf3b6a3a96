// The numbered rules of the verifier, derived from rules.def.
//
// Out: identity and meaning of each rule, for the verifier, its tests and docs/reference/verifier.md.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/diagnostics.h"

namespace plc::bytecode {

enum class Rule : std::uint16_t {
#define PLC_RULE(id, meaning) k##id,
#include "bytecode/rules.def"
};

struct RuleInfo {
  std::string_view id;  ///< "V107"
  std::string_view meaning;
  core::Code code;  ///< what a broken rule is reported as
};
std::span<const RuleInfo> rules();
const RuleInfo& info(Rule rule);

/// Longest list of broken rules one verify() reports; an image that breaks more is refused all the same.
inline constexpr std::size_t kMaxReports = 64;
/// Memory of all tasks of an image together (V209).
inline constexpr std::uint64_t kMaxTotalBytes = std::uint64_t{4} * 0x3fffffffu;
/// Words one pass through a task may take (V407).
inline constexpr std::uint64_t kMaxTaskWork = std::uint64_t{1} << 30;
/// Tasks of an image (V415).
inline constexpr std::size_t kMaxTasks = 1024;

}  // namespace plc::bytecode
