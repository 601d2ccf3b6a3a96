#include "runtime/interpreter.h"

#include <algorithm>
#include <cstring>

#include "core/types.h"
#include "runtime/bool_run.h"
#include "runtime/handle.h"
#include "runtime/operations.h"
#include "stdlib/arithmetic.h"

// Labels as values and computed goto are extensions of both compilers; a switch would funnel every dispatch through one
// indirect jump.
#pragma GCC diagnostic ignored "-Wpedantic"

// The label addresses that one call hands out must hold for all calls: no inlining, no cloning.
#if defined(__clang__)
#define PLC_ONE_COPY __attribute__((noinline))
#else
#define PLC_ONE_COPY __attribute__((noinline, noclone))
#endif

namespace plc::runtime {
namespace {

using stdlib::Event;

/// Addresses of the handlers, indexed by ResolvedOp; handler words are distances from that of Return.
using Labels = const void* const*;

/// With `labels` set: hands them out and executes nothing.
template <Addressing kAddressing>
PLC_ONE_COPY bool interpret(Machine& m, const std::uint32_t* pc, std::uint32_t instance, Labels* labels) noexcept {
  static const void* const kLabels[] = {
#define PLC_OPCODE(Name, mnemonic, operands, events, function, meaning) &&op_##Name,
#include "bytecode/opcodes.def"
#define PLC_INTERNAL_OP(Name, words, meaning) &&op_##Name,
#include "runtime/internal_ops.def"
  };
  static_assert(std::size(kLabels) == static_cast<std::size_t>(ResolvedOp::kCount));
  if (labels != nullptr) {
    *labels = kLabels;
    return true;
  }

  std::byte* const table = m.table;
  const std::uint32_t* const code = m.code;
  std::uint64_t events_at_clear = m.event_count;
  const auto offset_of = [instance](std::uint32_t operand) -> std::uint32_t {
    if constexpr (kAddressing == Addressing::kFixed) {
      static_cast<void>(instance);
      return operand;
    } else {
      const std::uint32_t mask = 0u - (operand >> 31);
      return (operand & ~kRelativeBit) + (mask & instance);
    }
  };
  const auto at = [&](std::uint32_t operand) -> std::byte* { return table + offset_of(operand); };
  const auto bytes_at = [&](std::uint32_t operand) { return reinterpret_cast<std::uint8_t*>(at(operand)); };

#define PLC_NEXT(words)                                                            \
  do {                                                                             \
    pc += (words);                                                                 \
    goto*(static_cast<const char*>(&&op_Return) + static_cast<std::int32_t>(*pc)); \
  } while (false)
#define PLC_MOVE(Name, T)                    \
  op_##Name : {                              \
    store<T>(at(pc[1]), load<T>(at(pc[2]))); \
    PLC_NEXT(3);                             \
  }
#define PLC_BINARY(Name, T, Result, expression)                \
  op_##Name : {                                                \
    const T a = load<T>(at(pc[2]));                            \
    const T b = load<T>(at(pc[3]));                            \
    store<Result>(at(pc[1]), static_cast<Result>(expression)); \
    PLC_NEXT(4);                                               \
  }
#define PLC_DIVISION(Name, T)                      \
  op_##Name : {                                    \
    const T a = load<T>(at(pc[2]));                \
    const T b = load<T>(at(pc[3]));                \
    Event event = Event::kNone;                    \
    store<T>(at(pc[1]), stdlib::div(a, b, event)); \
    if (event != Event::kNone) [[unlikely]]        \
      raise(m, pc, event);                         \
    PLC_NEXT(4);                                   \
  }
// Families, as in opcodes.def.
#define PLC_INTS(Name, expression)                               \
  PLC_BINARY(Name##8, std::uint8_t, std::uint8_t, expression)    \
  PLC_BINARY(Name##16, std::uint16_t, std::uint16_t, expression) \
  PLC_BINARY(Name##32, std::uint32_t, std::uint32_t, expression) \
  PLC_BINARY(Name##64, std::uint64_t, std::uint64_t, expression)
#define PLC_REALS(Name, expression)               \
  PLC_BINARY(Name##F32, float, float, expression) \
  PLC_BINARY(Name##F64, double, double, expression)
#define PLC_EQUALS(Name, expression)                            \
  PLC_BINARY(Name##8, std::uint8_t, std::uint8_t, expression)   \
  PLC_BINARY(Name##16, std::uint16_t, std::uint8_t, expression) \
  PLC_BINARY(Name##32, std::uint32_t, std::uint8_t, expression) \
  PLC_BINARY(Name##64, std::uint64_t, std::uint8_t, expression) \
  PLC_BINARY(Name##F32, float, std::uint8_t, expression)        \
  PLC_BINARY(Name##F64, double, std::uint8_t, expression)
#define PLC_ORDERS(Name, expression)                             \
  PLC_BINARY(Name##I8, std::int8_t, std::uint8_t, expression)    \
  PLC_BINARY(Name##U8, std::uint8_t, std::uint8_t, expression)   \
  PLC_BINARY(Name##I16, std::int16_t, std::uint8_t, expression)  \
  PLC_BINARY(Name##U16, std::uint16_t, std::uint8_t, expression) \
  PLC_BINARY(Name##I32, std::int32_t, std::uint8_t, expression)  \
  PLC_BINARY(Name##U32, std::uint32_t, std::uint8_t, expression) \
  PLC_BINARY(Name##I64, std::int64_t, std::uint8_t, expression)  \
  PLC_BINARY(Name##U64, std::uint64_t, std::uint8_t, expression) \
  PLC_BINARY(Name##F32, float, std::uint8_t, expression)         \
  PLC_BINARY(Name##F64, double, std::uint8_t, expression)
#define PLC_INTEGER_TYPES(Macro, Name)                                                               \
  Macro(Name##I8, std::int8_t) Macro(Name##U8, std::uint8_t) Macro(Name##I16, std::int16_t)          \
      Macro(Name##U16, std::uint16_t) Macro(Name##I32, std::int32_t) Macro(Name##U32, std::uint32_t) \
          Macro(Name##I64, std::int64_t) Macro(Name##U64, std::uint64_t)
#define PLC_RANGE(Name, T)                                \
  op_##Name : {                                           \
    const T value = load<T>(at(pc[2]));                   \
    const T lower = load<T>(at(pc[3]));                   \
    const T upper = load<T>(at(pc[4]));                   \
    if (value < lower || value > upper) [[unlikely]] {    \
      store<T>(at(pc[1]), value < lower ? lower : upper); \
      raise(m, pc, Event::kOutOfRange);                   \
    } else {                                              \
      store<T>(at(pc[1]), value);                         \
    }                                                     \
    PLC_NEXT(5);                                          \
  }
#define PLC_MODULO(Name, T) PLC_BINARY(Name, T, T, stdlib::mod_wrap(a, b))

  PLC_NEXT(0);

  // ---- control
op_Return:
  return true;
op_Jump : {
  pc = code + pc[1];
  PLC_NEXT(0);
}
op_CondJump : {
  pc = *bytes_at(pc[1]) != 0 ? pc + 3 : code + pc[2];
  PLC_NEXT(0);
}
op_LoopJump : {
  if (m.loops_left == 0) [[unlikely]] {
    fail(m, pc, FaultKind::kLoopBudget);
    return false;
  }
  --m.loops_left;
  pc = code + pc[1];
  PLC_NEXT(0);
}

  // ---- data
  PLC_MOVE(MoveBool, std::uint8_t)
  PLC_MOVE(Move8, std::uint8_t)
  PLC_MOVE(Move16, std::uint16_t)
  PLC_MOVE(Move32, std::uint32_t)
  PLC_MOVE(Move64, std::uint64_t)
  PLC_MOVE(MoveF32, std::uint32_t)
  PLC_MOVE(MoveF64, std::uint64_t)
  PLC_MOVE(MoveRef, std::uint64_t)
op_MoveStr : {
  if (!copy_string(at(pc[1]), at(pc[2]), pc[3], 1)) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(4);
}
op_MoveWstr : {
  if (!copy_string(at(pc[1]), at(pc[2]), pc[3], 2)) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(4);
}
op_Copy : {
  std::memmove(at(pc[1]), at(pc[2]), pc[3]);
  PLC_NEXT(4);
}

  // ---- boolean logic as data
op_BoolRun4 : {
  const std::uint32_t count = pc[1];
  const std::uint32_t* const records = code + pc[3];
  run_short<4>(bytes_at(pc[2]), records, count);
  pc = records + std::size_t{count} * kShortRecordWords;
  PLC_NEXT(0);
}
op_BoolRun5 : {
  const std::uint32_t count = pc[1];
  const std::uint32_t* const records = code + pc[3];
  run_short<5>(bytes_at(pc[2]), records, count);
  pc = records + std::size_t{count} * kShortRecordWords;
  PLC_NEXT(0);
}
op_BoolRun : {
  const std::uint32_t* record = pc + 2;
  const std::uint32_t* const end = record + std::size_t{pc[1]} * kGeneralRecordWords;
  for (; record != end; record += kGeneralRecordWords) {
    const std::uint32_t index = *bytes_at(record[2]) + 2u * *bytes_at(record[3]) +
                                4u * (*bytes_at(record[4]) + 2u * *bytes_at(record[5])) + 16u * *bytes_at(record[6]);
    *bytes_at(record[1]) = static_cast<std::uint8_t>((record[0] >> (index & 31u)) & 1u);
  }
  pc = end;
  PLC_NEXT(0);
}

  // ---- function blocks, taskblocks and POUs
op_RunTb : {
  load_pointer<stdlib::Step>(pc + 1)(at(pc[3]), m.step);
  PLC_NEXT(4);
}
op_RunRef : {
  std::byte* const ports = target(m, load<Handle>(at(pc[3])), pc[4], Use::kWrite);
  if (ports != nullptr) [[likely]] {
    load_pointer<stdlib::Step>(pc + 1)(ports, m.step);
  } else {
    raise(m, pc, Event::kNullReference);
  }
  PLC_NEXT(5);
}
op_CallPouFixed : {
  if (!interpret<Addressing::kFixed>(m, code + pc[1], 0, nullptr)) [[unlikely]]
    return false;
  PLC_NEXT(2);
}
op_CallPou : {
  if (!interpret<Addressing::kRelative>(m, code + pc[1], offset_of(pc[2]), nullptr)) [[unlikely]]
    return false;
  PLC_NEXT(3);
}
op_CallRef : {
  const std::byte* const place = target(m, load<Handle>(at(pc[2])), pc[3], Use::kWrite);
  if (place != nullptr) [[likely]] {
    const auto callee = static_cast<std::uint32_t>(place - table);
    if (!interpret<Addressing::kRelative>(m, code + pc[1], callee, nullptr)) [[unlikely]]
      return false;
  } else {
    raise(m, pc, Event::kNullReference);
  }
  PLC_NEXT(4);
}
op_CallFn : {
  // Words: frame, frame bytes, initial bytes (2), entry, inputs, outputs, then 4 per argument: to, from, bytes or kind,
  // capacities.
  std::memcpy(table + pc[1], load_pointer<const std::byte*>(pc + 3), pc[2]);
  const std::uint32_t* argument = pc + 8;
  for (const std::uint32_t* const end = argument + std::size_t{pc[6]} * 4; argument != end; argument += 4) {
    if (!pass(at(argument[0]), at(argument[1]), argument[2], argument[3])) [[unlikely]]
      raise(m, pc, Event::kTruncated);
  }
  if (!interpret<Addressing::kFixed>(m, code + pc[5], 0, nullptr)) [[unlikely]]
    return false;
  for (const std::uint32_t* const end = argument + std::size_t{pc[7]} * 4; argument != end; argument += 4) {
    if (!pass(at(argument[0]), at(argument[1]), argument[2], argument[3])) [[unlikely]]
      raise(m, pc, Event::kTruncated);
  }
  pc = argument;
  PLC_NEXT(0);
}
op_CallStd : {
  const void* arguments[stdlib::kMaxArguments];
  const std::uint32_t count = pc[3];
  for (std::uint32_t i = 0; i < count; ++i) arguments[i] = at(pc[5 + i]);
  const Event event = load_pointer<stdlib::Kernel>(pc + 1)(at(pc[4]), arguments, count);
  if (event != Event::kNone) [[unlikely]]
    raise(m, pc, event);
  PLC_NEXT(5 + count);
}
op_ClearEvent : {
  events_at_clear = m.event_count;
  PLC_NEXT(1);
}
op_Eno : {
  *bytes_at(pc[1]) = m.event_count == events_at_clear ? 1 : 0;
  PLC_NEXT(2);
}

  // ---- checked references
op_MakeRef : {
  store<Handle>(at(pc[1]), handle_of(m, offset_of(pc[2]), pc[3]));
  PLC_NEXT(4);
}
op_IndexRef : {
  // Words: out, ref, index, array type, element type, element bytes, count, lower bound (2).
  const Handle array = load<Handle>(at(pc[2]));
  const std::uint64_t element = load<std::uint64_t>(at(pc[3])) - load<std::uint64_t>(pc + 8);
  Handle result{};
  if (target(m, array, pc[4], Use::kRead) == nullptr) [[unlikely]] {
    raise(m, pc, Event::kNullReference);
  } else if (element >= pc[7]) [[unlikely]] {
    raise(m, pc, Event::kBadIndex);
  } else {
    result = Handle::make(array.tag(), pc[5], array.offset() + static_cast<std::uint32_t>(element) * pc[6]);
  }
  store<Handle>(at(pc[1]), result);
  PLC_NEXT(10);
}
op_FieldRef : {
  // Words: out, ref, structure type, field type, field offset.
  const Handle structure = load<Handle>(at(pc[2]));
  Handle result{};
  if (target(m, structure, pc[3], Use::kRead) != nullptr) {
    result = Handle::make(structure.tag(), pc[4], structure.offset() + pc[5]);
  }
  store<Handle>(at(pc[1]), result);
  PLC_NEXT(6);
}
op_CopyFrom : {
  // Words: to, ref, type, bytes, zeros of the type (2).
  const std::byte* from = target(m, load<Handle>(at(pc[2])), pc[3], Use::kRead);
  if (from == nullptr) [[unlikely]] {
    from = load_pointer<const std::byte*>(pc + 5);
    raise(m, pc, Event::kNullReference);
  }
  std::memmove(at(pc[1]), from, pc[4]);
  PLC_NEXT(7);
}
op_CopyTo : {
  // Words: ref, from, type, bytes.
  std::byte* const to = target(m, load<Handle>(at(pc[1])), pc[3], Use::kWrite);
  if (to != nullptr) [[likely]] {
    std::memmove(to, at(pc[2]), pc[4]);
  } else {
    raise(m, pc, Event::kNullReference);
  }
  PLC_NEXT(5);
}

  // ---- arithmetic, comparison, bit strings
  PLC_INTS(Add, stdlib::add(a, b))
  PLC_REALS(Add, stdlib::add(a, b))
  PLC_INTS(Sub, stdlib::sub(a, b))
  PLC_REALS(Sub, stdlib::sub(a, b))
  PLC_INTS(Mul, stdlib::mul(a, b))
  PLC_REALS(Mul, stdlib::mul(a, b))
  PLC_INTEGER_TYPES(PLC_DIVISION, Div)
  PLC_REALS(Div, stdlib::canonical(a / b))
  PLC_INTEGER_TYPES(PLC_MODULO, Mod)
  PLC_EQUALS(Eq, a == b)
  PLC_EQUALS(Ne, a != b)
  PLC_ORDERS(Lt, a < b)
  PLC_ORDERS(Le, a <= b)
  PLC_ORDERS(Gt, a > b)
  PLC_ORDERS(Ge, a >= b)
  PLC_INTS(And, a & b)
  PLC_INTS(Or, a | b)
  PLC_INTS(Xor, a ^ b)

  // ---- parts of integers and bit strings, subranges
op_Extract : {
  // Words: out, the byte that holds the bit, bit in it. Wider parts are moves.
  *bytes_at(pc[1]) = static_cast<std::uint8_t>((*bytes_at(pc[2]) >> pc[3]) & 1u);
  PLC_NEXT(4);
}
op_Insert : {
  // Words: the byte that holds the bit, part, bit in it.
  std::uint8_t* const byte = bytes_at(pc[1]);
  *byte = static_cast<std::uint8_t>((*byte & ~(1u << pc[3])) | (std::uint32_t{*bytes_at(pc[2])} << pc[3]));
  PLC_NEXT(4);
}
  PLC_INTEGER_TYPES(PLC_RANGE, Range)

  // ---- exchange
op_ReadN : {
  m.exchange->import(pc[1]);
  PLC_NEXT(2);
}
op_WriteN : {
  m.exchange->export_range(pc[1]);
  PLC_NEXT(2);
}
op_WriteChangedN : {
  m.exchange->export_range(pc[1]);
  PLC_NEXT(2);
}
}

Labels labels_of(Addressing addressing) {
  Machine none;
  Labels labels = nullptr;
  if (addressing == Addressing::kFixed) {
    interpret<Addressing::kFixed>(none, nullptr, 0, &labels);
  } else {
    interpret<Addressing::kRelative>(none, nullptr, 0, &labels);
  }
  return labels;
}

}  // namespace

// RT:
bool run_body(Machine& machine, Addressing addressing, std::uint32_t entry, std::uint32_t instance) noexcept {
  const std::uint32_t* const pc = machine.code + entry;
  return addressing == Addressing::kFixed ? interpret<Addressing::kFixed>(machine, pc, instance, nullptr)
                                          : interpret<Addressing::kRelative>(machine, pc, instance, nullptr);
}

std::uint32_t handler_word(Addressing addressing, ResolvedOp op) {
  const Labels labels = labels_of(addressing);
  const auto address = [labels](ResolvedOp of) {
    return static_cast<const char*>(labels[static_cast<std::size_t>(of)]);
  };
  const auto distance = address(op) - address(ResolvedOp::kReturn);
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(distance));
}

}  // namespace plc::runtime
