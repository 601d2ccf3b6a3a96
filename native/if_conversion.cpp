#include "native/if_conversion.h"

#include <algorithm>
#include <string_view>

#include "native/library_rows.h"
#include "native/loops.h"
#include "runtime/interpreter/operations.h"

namespace plc::native {

using runtime::LinkedInstruction;

namespace {

/// What is computed in vain should be less than a wrong guess costs.
constexpr std::size_t kMostInstructions = 4;

}  // namespace

std::optional<ShortIf> short_if_at(const std::uint32_t* code, std::span<const LinkedInstruction> instructions,
                                   std::size_t i, const std::function<std::size_t(std::uint32_t)>& jumps_to) {
  const std::uint32_t* const words = code + instructions[i].position;
  const Form form = operation_of(instructions[i].op).form;
  const bool compares = form == Form::kCompareJumpUnless || form == Form::kCompareJumpIf;
  if (!compares && form != Form::kJumpUnless && form != Form::kJumpIf) return std::nullopt;
  ShortIf short_if;
  short_if.condition = words[1];
  short_if.value = form == Form::kJumpUnless || form == Form::kCompareJumpUnless;
  short_if.compares = compares;

  // No jump leads to what lies between the jump and where it goes, nor, if there are two parts, between these.
  const auto walk = [&](std::size_t from, std::uint32_t position) -> std::optional<Branch> {
    Branch found{from, from};
    while (found.last < instructions.size() && instructions[found.last].position < position) {
      if (found.last != from && jumps_to(instructions[found.last].position) != 0) return std::nullopt;
      if (++found.last - from > kMostInstructions) return std::nullopt;
    }
    const bool reached = found.last < instructions.size() && instructions[found.last].position == position;
    return reached ? std::optional(found) : std::nullopt;
  };
  const std::uint32_t over = target_of(form, words);
  if (over <= instructions[i].position) return std::nullopt;
  const auto taken = walk(i + 1, over);
  if (!taken || taken->first == taken->last || jumps_to(instructions[i + 1].position) != 0) return std::nullopt;
  short_if.taken = *taken;
  short_if.end = taken->last;
  short_if.other = {short_if.end, short_if.end};
  const LinkedInstruction& last = instructions[taken->last - 1];
  if (operation_of(last.op).form != Form::kJump) return short_if;
  const auto other = walk(taken->last, target_of(Form::kJump, code + last.position));
  if (!other || jumps_to(over) != 1) return std::nullopt;
  --short_if.taken.last;
  short_if.other = *other;
  short_if.end = other->last;
  return short_if;
}

std::optional<std::vector<std::uint32_t>> written_by(const Emitter& emitter, const std::uint32_t* code,
                                                     std::span<const LinkedInstruction> instructions,
                                                     const ShortIf& short_if) {
  std::vector<std::uint32_t> written;
  for (const Branch& part : {short_if.taken, short_if.other}) {
    for (std::size_t n = part.first; n < part.last; ++n) {
      const std::uint32_t position = instructions[n].position;
      const auto operand = computes_integer(emitter, {code + position, position, operation_of(instructions[n].op)});
      if (!operand || *operand == short_if.condition) return std::nullopt;
      if (std::find(written.begin(), written.end(), *operand) == written.end()) written.push_back(*operand);
    }
  }
  return written;
}

std::optional<std::uint32_t> computes_integer(const Emitter& emitter, const Instruction& instruction) {
  switch (instruction.operation.form) {
    case Form::kMove:
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
      if (is_real(instruction.operation.type)) return std::nullopt;
      return instruction.words[1];
    case Form::kCallLibrary:
      if (!plain_shift(emitter, instruction.words)) return std::nullopt;
      return instruction.words[4];
    default:
      return std::nullopt;
  }
}

std::optional<std::uint64_t> plain_shift(const Emitter& emitter, const std::uint32_t* words) {
  const stdlib::Overload* const overload =
      stdlib::overload_with_kernel(runtime::load_pointer<stdlib::Kernel>(words + 1));
  if (overload == nullptr || overload->t == core::TypeId::kBool) return std::nullopt;
  const std::string_view name = overload->spec->name;
  if (name != "SHL" && name != "SHR" && name != "ROL" && name != "ROR") return std::nullopt;
  const auto value = machine_type(overload->t);
  const auto by = machine_type(overload->u);
  if (!value || !by) return std::nullopt;
  const auto known = emitter.constant(words[6], bytes_of(*by));
  return known && *known < std::uint64_t{bytes_of(*value)} * 8 ? known : std::nullopt;
}

}  // namespace plc::native
