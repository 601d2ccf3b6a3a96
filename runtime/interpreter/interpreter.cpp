#include "runtime/interpreter/interpreter.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "core/types.h"
#include "runtime/interpreter/bool_run.h"
#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/operations.h"
#include "runtime/interpreter/paths.h"
#include "runtime/interpreter/pointer_ops.h"
#include "runtime/interpreter/value_ops.h"
#include "runtime/interpreter/value_runs.h"
#include "runtime/memory/queue.h"
#include "runtime/probes.h"
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
#define PLC_OPCODE(Name, mnemonic, operands, events, cost, function, meaning) &&op_##Name,
#include "bytecode/opcodes.def"
#define PLC_INTERNAL_OP(Name, words, meaning) &&op_##Name,
#include "runtime/interpreter/internal_ops.def"
  };
  static_assert(std::size(kLabels) == static_cast<std::size_t>(ResolvedOp::kCount));
  if (labels != nullptr) {
    *labels = kLabels;
    return true;
  }

  std::byte* const table = m.table;
  const std::uint32_t* const code = m.code;
  std::uint64_t events_at_clear = m.event_count;
  // WHY copies: what a lambda refers to lies in memory as soon as one of them is a call.
  const auto at = [table, instance](std::uint32_t operand) { return place<kAddressing>(table, instance, operand); };
  const auto bytes_at = [at](std::uint32_t operand) { return reinterpret_cast<std::uint8_t*>(at(operand)); };
  const auto element_i16 = [at](const std::uint32_t* index) {
    return static_cast<std::uint64_t>(load<std::int16_t>(at(index[0]))) - load<std::uint64_t>(index + 3);
  };
  const auto element_i32 = [at](const std::uint32_t* index) {
    return static_cast<std::uint64_t>(load<std::int32_t>(at(index[0]))) - load<std::uint64_t>(index + 3);
  };
  const auto element_any = [at](const std::uint32_t* index) { return element_of(index, at(index[0])); };

#define PLC_NEXT(words)                                                            \
  do {                                                                             \
    pc += (words);                                                                 \
    goto*(static_cast<const char*>(&&op_Return) + static_cast<std::int32_t>(*pc)); \
  } while (false)
#define PLC_COMPARE_JUMP(Name, T, expression, sense)      \
  op_##Name : {                                           \
    const T a = load<T>(at(pc[2]));                       \
    const T b = load<T>(at(pc[3]));                       \
    const bool result = expression;                       \
    *bytes_at(pc[1]) = static_cast<std::uint8_t>(result); \
    pc = sense result ? code + pc[4] : pc + 5;            \
    PLC_NEXT(0);                                          \
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
// Parts of values: the access itself, then where it goes to.
#define PLC_LOAD(T, place)  \
  T value{};                \
  if (fine) [[likely]]      \
    value = load<T>(place); \
  store<T>(at(pc[1]), value);
#define PLC_STORE(T, place) \
  if (fine) [[likely]]      \
    store<T>(place, load<T>(at(pc[1])));
// Words: value, place, index (6).
#define PLC_ACCESS_AT(Name, T, element_at, Access)      \
  op_##Name : {                                         \
    const std::uint64_t element = element_at(pc + 3);   \
    const bool fine = element < pc[4];                  \
    if (!fine) [[unlikely]]                             \
      raise(m, pc, Event::kBadIndex);                   \
    Access(T, at(pc[2]) + element * pc[5]) PLC_NEXT(9); \
  }
// Words: value, ref, type, offset, index (6).
#define PLC_ACCESS_VIA(Name, T, element_at, Access)                                       \
  op_##Name : {                                                                           \
    std::byte* const whole = target(m, load<Handle>(at(pc[2])), pc[3], PLC_USE_##Access); \
    const std::uint64_t element = element_at(pc + 5);                                     \
    const bool fine = whole != nullptr && element < pc[6];                                \
    if (!fine) [[unlikely]]                                                               \
      raise(m, pc, whole == nullptr ? Event::kNullReference : Event::kBadIndex);          \
    Access(T, whole + pc[4] + element * pc[7]) PLC_NEXT(11);                              \
  }
// Words: value, ref, type, offset.
#define PLC_SCALAR_VIA(Name, T, Access)                                                   \
  op_##Name : {                                                                           \
    std::byte* const whole = target(m, load<Handle>(at(pc[2])), pc[3], PLC_USE_##Access); \
    const bool fine = whole != nullptr;                                                   \
    if (!fine) [[unlikely]]                                                               \
      raise(m, pc, Event::kNullReference);                                                \
    Access(T, whole + pc[4]) PLC_NEXT(5);                                                 \
  }
#define PLC_USE_PLC_LOAD Use::kRead
#define PLC_USE_PLC_STORE Use::kWrite
#define PLC_LOAD_SCALAR_VIA(Name, T) PLC_SCALAR_VIA(Name, T, PLC_LOAD)
#define PLC_STORE_SCALAR_VIA(Name, T) PLC_SCALAR_VIA(Name, T, PLC_STORE)
#define PLC_SIZES(Macro, Name)                                                               \
  Macro(Name##8, std::uint8_t) Macro(Name##16, std::uint16_t) Macro(Name##32, std::uint32_t) \
      Macro(Name##64, std::uint64_t)
#define PLC_INDICES(Macro, Name, T) \
  Macro(Name##I16, T, element_i16) Macro(Name##I32, T, element_i32) Macro(Name##Any, T, element_any)
#define PLC_INDEX_FORMS(Macro, Name)          \
  PLC_INDICES(Macro, Name##8, std::uint8_t)   \
  PLC_INDICES(Macro, Name##16, std::uint16_t) \
  PLC_INDICES(Macro, Name##32, std::uint32_t) PLC_INDICES(Macro, Name##64, std::uint64_t)

  PLC_NEXT(0);

  // ---- control
op_Return:
  return true;
op_Jump : {
  pc = code + pc[1];
  PLC_NEXT(0);
}
op_BlockStart : {
  pc = code + pc[1];
  PLC_NEXT(0);
}
op_CondJump : {
  pc = *bytes_at(pc[1]) != 0 ? pc + 3 : code + pc[2];
  PLC_NEXT(0);
}
op_JumpIf : {
  pc = *bytes_at(pc[1]) != 0 ? code + pc[2] : pc + 3;
  PLC_NEXT(0);
}
op_LoopJump : {
  // One writer of the budget but for those who set it to 0: load and store instead of a locked subtraction.
  const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
  m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
  if (left == 0) [[unlikely]] {
    fail(m, pc, FaultKind::kLoopBudget);
    return false;
  }
  m.loops_left.store(left - 1, std::memory_order_relaxed);
  pc = code + pc[1];
  PLC_NEXT(0);
}

#define PLC_FUSED_JUMP(Name, T, expression) \
  PLC_COMPARE_JUMP(Name##Unless, T, expression, !) PLC_COMPARE_JUMP(Name##If, T, expression, )
#include "runtime/interpreter/fused_jumps.def"

  // ---- data
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
op_BoolRun2 : {
  const std::uint32_t count = pc[1];
  const std::uint32_t* const records = code + pc[3];
  run_short<2>(bytes_at(pc[2]), records, count);
  pc = records + std::size_t{count} * kShortRecordWords;
  PLC_NEXT(0);
}
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
  for (; record != end; record += kGeneralRecordWords) run_general(record, bytes_at);
  pc = end;
  PLC_NEXT(0);
}

  // ---- function blocks, taskblocks and POUs
op_RunTb : {
  load_pointer<stdlib::Step>(pc + 1)(at(pc[3]), m.step);
  PLC_NEXT(4);
}
op_ValueRun : {
  pc = load_pointer<ValueRun>(pc + 1)(table, instance, pc + 4, pc[3]);
  PLC_NEXT(0);
}
op_BlockRun : {
  const std::uint32_t* place = pc + 4;
  const std::uint32_t* const end = place + pc[3];
  if constexpr (kAddressing == Addressing::kFixed) {
    load_pointer<stdlib::StepEach>(pc + 1)(table, place, pc[3], m.step);
  } else {
    const auto step = load_pointer<stdlib::Step>(pc + 1);
    for (; place != end; ++place) step(at(*place), m.step);
  }
  pc = end;
  PLC_NEXT(0);
}
op_RunTaskblock : {
  m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
  const Taskblocks::Status status = m.taskblocks->run(at(pc[1]));
  if (status != Taskblocks::Status::kFine && !settle_taskblock(m, pc, status)) [[unlikely]]
    return false;
  PLC_NEXT(2);
}
op_Probe:
  m.probes->run(pc[1], pc[2], pc[3], table, instance);
  PLC_NEXT(4);
op_CallPouFixed : {
  m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
  if (!interpret<Addressing::kFixed>(m, code + pc[1], 0, nullptr)) [[unlikely]]
    return false;
  PLC_NEXT(2);
}
op_EnterPou : {
  m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
  events_at_clear = m.event_count;
  pc = code + pc[1];
  PLC_NEXT(0);
}
op_CallPou : {
  if (!interpret<Addressing::kRelative>(m, code + pc[1], static_cast<std::uint32_t>(at(pc[2]) - table), nullptr))
      [[unlikely]]
    return false;
  PLC_NEXT(3);
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
// Functions of the library without a call; words as those of CALL_STD.
#define PLC_LIBRARY_OP(Name, meaning, Out, inputs, expression) \
  op_##Name : {                                                \
    compute<value::Name>(pc + 4, at);                          \
    PLC_NEXT(5 + kInputs<value::Name>);                        \
  }
#include "runtime/interpreter/library_ops.def"
op_ClearEvent : {
  events_at_clear = m.event_count;
  PLC_NEXT(1);
}
op_Eno : {
  *bytes_at(pc[1]) = m.event_count == events_at_clear ? 1 : 0;
  PLC_NEXT(2);
}

// ---- parts of values: one index at most
#define PLC_LOAD_AT(Name, T, element_at) PLC_ACCESS_AT(Name, T, element_at, PLC_LOAD)
#define PLC_STORE_AT(Name, T, element_at) PLC_ACCESS_AT(Name, T, element_at, PLC_STORE)
#define PLC_LOAD_VIA(Name, T, element_at) PLC_ACCESS_VIA(Name, T, element_at, PLC_LOAD)
#define PLC_STORE_VIA(Name, T, element_at) PLC_ACCESS_VIA(Name, T, element_at, PLC_STORE)
  PLC_INDEX_FORMS(PLC_LOAD_AT, LoadAt)
  PLC_INDEX_FORMS(PLC_STORE_AT, StoreAt)
  PLC_INDEX_FORMS(PLC_LOAD_VIA, LoadVia)
  PLC_INDEX_FORMS(PLC_STORE_VIA, StoreVia)
  PLC_SIZES(PLC_LOAD_SCALAR_VIA, LoadVia)
  PLC_SIZES(PLC_STORE_SCALAR_VIA, StoreVia)

  // ---- parts of values: several indices
#define PLC_LOAD_PATH(Name, T)                                                         \
  op_##Name : {                                                                        \
    const std::byte* const from = follow<kAddressing>(m, instance, at(pc[2]), pc + 3); \
    if (from == nullptr) [[unlikely]]                                                  \
      raise(m, pc, Event::kBadIndex);                                                  \
    store<T>(at(pc[1]), from == nullptr ? T{} : load<T>(from));                        \
    PLC_NEXT(3 + path_words(pc + 3));                                                  \
  }
#define PLC_STORE_PATH(Name, T)                                                \
  op_##Name : {                                                                \
    std::byte* const to = follow<kAddressing>(m, instance, at(pc[2]), pc + 3); \
    if (to == nullptr) [[unlikely]]                                            \
      raise(m, pc, Event::kBadIndex);                                          \
    else                                                                       \
      store<T>(to, load<T>(at(pc[1])));                                        \
    PLC_NEXT(3 + path_words(pc + 3));                                          \
  }
  PLC_SIZES(PLC_LOAD_PATH, LoadPath)
  PLC_SIZES(PLC_STORE_PATH, StorePath)

  // ---- parts of values: any path
op_LoadAt : {
  // Words: out, place, bytes, capacities, zeros (2), path.
  const std::byte* from = part_at<kAddressing>(m, instance, pc, pc[2], pc + 7);
  if (from == nullptr) [[unlikely]]
    from = load_pointer<const std::byte*>(pc + 5);
  if (!pass(at(pc[1]), from, pc[3], pc[4])) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(7 + path_words(pc + 7));
}
op_StoreAt : {
  // Words: in, place, bytes, capacities, path.
  std::byte* const to = part_at<kAddressing>(m, instance, pc, pc[2], pc + 5);
  if (to != nullptr && !pass(to, at(pc[1]), pc[3], pc[4])) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(5 + path_words(pc + 5));
}
op_RefAt : {
  // Words: out, place, type of the part, path.
  const std::byte* const part = part_at<kAddressing>(m, instance, pc, pc[2], pc + 4);
  store<Handle>(at(pc[1]), part == nullptr ? Handle{} : handle_of(m, part, pc[3]));
  PLC_NEXT(4 + path_words(pc + 4));
}
op_RunAt : {
  // Words: step (2), place, path.
  std::byte* const ports = part_at<kAddressing>(m, instance, pc, pc[3], pc + 4);
  if (ports != nullptr) [[likely]] {
    m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
    load_pointer<stdlib::Step>(pc + 1)(ports, m.step);
    if (!settle_step(m, pc)) [[unlikely]]
      return false;
  }
  PLC_NEXT(4 + path_words(pc + 4));
}
op_CallAt : {
  // Words: entry, place, path.
  const std::byte* const callee = part_at<kAddressing>(m, instance, pc, pc[2], pc + 3);
  if (callee != nullptr && !interpret<Addressing::kRelative>(
                               m, code + pc[1], static_cast<std::uint32_t>(callee - table), nullptr)) [[unlikely]]
    return false;
  PLC_NEXT(3 + path_words(pc + 3));
}
op_LoadVia : {
  // Words: out, ref, type, bytes, capacities, zeros (2), path.
  const std::byte* from = part_via<kAddressing>(m, instance, pc, pc[2], pc[3], Use::kRead, pc + 8);
  if (from == nullptr) [[unlikely]]
    from = load_pointer<const std::byte*>(pc + 6);
  if (!pass(at(pc[1]), from, pc[4], pc[5])) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(8 + path_words(pc + 8));
}
op_StoreVia : {
  // Words: in, ref, type, bytes, capacities, path.
  std::byte* const to = part_via<kAddressing>(m, instance, pc, pc[2], pc[3], Use::kWrite, pc + 6);
  if (to != nullptr && !pass(to, at(pc[1]), pc[4], pc[5])) [[unlikely]]
    raise(m, pc, Event::kTruncated);
  PLC_NEXT(6 + path_words(pc + 6));
}
op_RefVia : {
  // Words: out, ref, type, type of the part, path.
  const std::byte* const part = part_via<kAddressing>(m, instance, pc, pc[2], pc[3], Use::kRead, pc + 5);
  store<Handle>(at(pc[1]), part == nullptr ? Handle{} : handle_of(m, part, pc[4]));
  PLC_NEXT(5 + path_words(pc + 5));
}
op_RunVia : {
  // Words: step (2), ref, type, path.
  std::byte* const ports = part_via<kAddressing>(m, instance, pc, pc[3], pc[4], Use::kWrite, pc + 5);
  if (ports != nullptr) [[likely]] {
    m.place.store(static_cast<std::uint32_t>(pc - code), std::memory_order_relaxed);
    load_pointer<stdlib::Step>(pc + 1)(ports, m.step);
    if (!settle_step(m, pc)) [[unlikely]]
      return false;
  }
  PLC_NEXT(5 + path_words(pc + 5));
}
op_CallVia : {
  // Words: entry, ref, type, path.
  const std::byte* const callee = part_via<kAddressing>(m, instance, pc, pc[2], pc[3], Use::kWrite, pc + 4);
  if (callee != nullptr && !interpret<Addressing::kRelative>(
                               m, code + pc[1], static_cast<std::uint32_t>(callee - table), nullptr)) [[unlikely]]
    return false;
  PLC_NEXT(4 + path_words(pc + 4));
}

  // ---- pointers: paths in the layout that they see (runtime/pointers/)
op_AdrAt : {
  // Words: out, place, type of the part, path.
  store(at(pc[1]), address_of(m, pc, part_at<kAddressing>(m, instance, pc, pc[2], pc + 4), pc[3]));
  PLC_NEXT(4 + path_words(pc + 4));
}
op_AdrVia : {
  // Words: out, ref, type, type of the part, path.
  const std::byte* const part = part_via<kAddressing>(m, instance, pc, pc[2], pc[3], Use::kRead, pc + 5);
  store(at(pc[1]), address_of(m, pc, part, pc[4]));
  PLC_NEXT(5 + path_words(pc + 5));
}
op_AdrPtr : {
  // Words: out, pointer, path.
  store(at(pc[1]), part_of(load<Pointer>(at(pc[2])), moved<kAddressing>(m, instance, pc, pc[2], pc + 3)));
  PLC_NEXT(3 + path_words(pc + 3));
}
op_LoadPtr : {
  // Words: out, pointer, type of the part, capacity, zeros (2), path.
  load_through(m, pc, moved<kAddressing>(m, instance, pc, pc[2], pc + 7), pc + 3, at(pc[1]));
  PLC_NEXT(7 + path_words(pc + 7));
}
op_StorePtr : {
  // Words: in, pointer, type of the part, capacity, path.
  store_through(m, pc, moved<kAddressing>(m, instance, pc, pc[2], pc + 5), pc + 3, at(pc[1]));
  PLC_NEXT(5 + path_words(pc + 5));
}
op_RefPtr : {
  // Words: out, pointer, type of the part, path.
  store(at(pc[1]), handle_through(m, pc, moved<kAddressing>(m, instance, pc, pc[2], pc + 4), pc[3]));
  PLC_NEXT(4 + path_words(pc + 4));
}
op_PtrTo32:
  store(at(pc[1]), pointer_to_32(m, pc, load<Pointer>(at(pc[2]))));
  PLC_NEXT(3);
op_PtrFrom32:
  store(at(pc[1]), pointer_from_32(m, pc, load<std::uint32_t>(at(pc[2]))));
  PLC_NEXT(3);

// ---- moves, arithmetic, comparison, bit strings
#define PLC_VALUE_OP(Name, Result, inputs, expression) \
  op_##Name : {                                        \
    compute<value::Name>(pc + 1, at);                  \
    PLC_NEXT(2 + kInputs<value::Name>);                \
  }
#include "runtime/interpreter/value_ops.def"
  PLC_INTEGER_TYPES(PLC_DIVISION, Div)

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
op_WriteN:
op_WriteChangedN:
  m.exchange->export_range(pc[1]);
  PLC_NEXT(2);
op_RaisePriority : {
  m.exchange->raise(pc[1]);
  PLC_NEXT(2);
}
op_Reschedule : {
  m.exchange->reschedule();
  PLC_NEXT(1);
}
op_QueuePut : {
  *bytes_at(pc[1]) = m.queues[pc[2]].put(at(pc[3])) ? 1 : 0;
  PLC_NEXT(4);
}
op_QueueGet : {
  *bytes_at(pc[1]) = m.queues[pc[2]].take(at(pc[3])) ? 1 : 0;
  PLC_NEXT(4);
}
op_QueueCount : {
  store<std::uint32_t>(at(pc[1]), m.queues[pc[2]].elements());
  PLC_NEXT(3);
}
op_QueueSpace : {
  store<std::uint32_t>(at(pc[1]), m.queues[pc[2]].room());
  PLC_NEXT(3);
}
op_Lock : {
  m.exchange->lock();
  PLC_NEXT(1);
}
op_Unlock : {
  m.exchange->unlock();
  PLC_NEXT(1);
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
