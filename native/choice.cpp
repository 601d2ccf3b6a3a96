#include "native/choice.h"

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

std::optional<Choice> choice_at(const std::uint32_t* code, std::span<const LinkedInstruction> instructions,
                                std::size_t i, const std::function<std::size_t(std::uint32_t)>& jumps_to) {
  const std::uint32_t* const words = code + instructions[i].position;
  const Form form = operation_of(instructions[i].op).form;
  const bool compares = form == Form::kCompareJumpUnless || form == Form::kCompareJumpIf;
  if (!compares && form != Form::kJumpUnless && form != Form::kJumpIf) return std::nullopt;
  Choice choice;
  choice.condition = words[1];
  choice.value = form == Form::kJumpUnless || form == Form::kCompareJumpUnless;
  choice.compares = compares;

  // Nobody jumps to what lies between the jump and where it goes, nor, if there are two parts, between these.
  const auto walk = [&](std::size_t from, std::uint32_t position) -> std::optional<Stretch> {
    Stretch found{from, from};
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
  choice.taken = *taken;
  choice.end = taken->last;
  choice.other = {choice.end, choice.end};
  const LinkedInstruction& last = instructions[taken->last - 1];
  if (operation_of(last.op).form != Form::kJump) return choice;
  const auto other = walk(taken->last, target_of(Form::kJump, code + last.position));
  if (!other || jumps_to(over) != 1) return std::nullopt;
  --choice.taken.last;
  choice.other = *other;
  choice.end = other->last;
  return choice;
}

std::optional<std::vector<std::uint32_t>> written_by(const Emitter& emitter, const std::uint32_t* code,
                                                     std::span<const LinkedInstruction> instructions,
                                                     const Choice& choice) {
  std::vector<std::uint32_t> written;
  for (const Stretch& part : {choice.taken, choice.other}) {
    for (std::size_t n = part.first; n < part.last; ++n) {
      const std::uint32_t position = instructions[n].position;
      const auto operand = computes_integer(emitter, {code + position, position, operation_of(instructions[n].op)});
      if (!operand || *operand == choice.condition) return std::nullopt;
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
