// Interpreter: runs resolved code (link.h), direct threaded.
//
// In: a Machine (one task's memory and counters) and the entry of a body. Out: changed memory, events, perhaps a fault.
// Two instances of one template: fixed bodies take operands as offsets from the table, relative ones add the instance
// where the operand's top bit says so. Does not belong here: images, names, threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bytecode/opcode.h"
#include "core/clock.h"
#include "runtime/interpreter/events.h"
#include "runtime/memory/exchange.h"
#include "runtime/program.h"
#include "stdlib/library.h"

namespace plc::runtime {

/// Instructions of resolved code: those of images, then the linker's own.
enum class ResolvedOp : std::uint16_t {
#define PLC_OPCODE(Name, mnemonic, operands, events, cost, function, meaning) k##Name,
#include "bytecode/opcodes.def"
#define PLC_INTERNAL_OP(Name, words, meaning) k##Name,
#include "runtime/interpreter/internal_ops.def"
  kCount
};

/// How a body's operands become addresses.
enum class Addressing : std::uint8_t {
  kFixed,     ///< offset from the start of the task's table
  kRelative,  ///< the same, or with the top bit set an offset from the current instance
};
inline constexpr std::uint32_t kRelativeBit = 0x80000000u;

/// The instruction that starts at stream position `position` is code word `word` of POU `pou`.
struct CodeMark {
  std::uint32_t position = 0;
  std::uint32_t pou = 0;
  std::uint32_t word = 0;
};

class Objects;
class Probes;
class QueueEnd;
class Taskblocks;

/// What a running task works on. One thread.
struct Machine {
  std::byte* table = nullptr;
  const std::uint32_t* code = nullptr;
  std::span<const CodeMark> marks;  ///< ascending positions
  Exchange* exchange = nullptr;
  EventTable* events = nullptr;
  Taskblocks* taskblocks = nullptr;  ///< null when the task runs none
  QueueEnd* queues = nullptr;        ///< one for each queue of the image
  stdlib::StepContext step{};
  std::uint64_t event_count = 0;  ///< since the start; ENO compares it with its value at CLEAR_EVENT
  std::uint64_t task_tag = 0;
  std::uint32_t global_bytes = 0;
  std::uint32_t constants_begin = 0;  ///< nothing is written through a handle that points into the constants
  std::uint32_t constants_end = 0;
  /// LOOP_JUMPs this scan may still take. Others may set it to 0 again and again until the scan ends.
  std::atomic<std::uint32_t> loops_left{0};
  /// Position in the code of the last loop jump, program or taskblock call: where a scan is that does not end.
  std::atomic<std::uint32_t> place{0};
  Fault fault;                       ///< of a scan that ended in one; what it was before, else
  const Objects* objects = nullptr;  ///< what pointers lead to; null when the task uses none
  Probes* probes = nullptr;          ///< of a replica that somebody looks at
};

/// Executes the body at stream position `entry`, whose instance is at table offset `instance`. False: machine.fault is
/// set. RT: C recursion is bounded by the image's call depth.
bool run_body(Machine& machine, Addressing addressing, std::uint32_t entry, std::uint32_t instance) noexcept;

/// The handler word that resolved code of this addressing starts an instruction with.
std::uint32_t handler_word(Addressing addressing, ResolvedOp op);

}  // namespace plc::runtime
