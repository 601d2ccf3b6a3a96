// Which form of names for variables is the faster one on this processor: from rip, or from a register.
//
// A boolean ladder in which coils are read soon after they were written takes two and a half times as long from a
// register on some processors (AMD Zen 5), which forward what was stored sooner to a place named from rip; others run
// that form slower (docs/adr/0021). So both are timed: 64 rungs on 96 BOOLs, in turns, a millisecond in all.
#include "native/naming.h"

#include <asmjit/x86.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>

#include "native/code_memory.h"

namespace plc::native {
namespace {

namespace x86 = asmjit::x86;

constexpr std::size_t kVariables = 96, kRungs = 64;
alignas(64) std::array<std::uint8_t, kVariables> variables{};

using Ladder = void (*)();

/// Rungs of three contacts and a coil on variables that a fixed sequence of numbers chooses.
core::Result<CodeMemory> make_ladder(bool from_code) {
  asmjit::CodeHolder code;
  code.init(asmjit::Environment::host());
  x86::Assembler a(&code);
  const auto base = reinterpret_cast<std::uint64_t>(variables.data());
  std::uint32_t number = 1;
  const auto variable = [&] {
    number = number * 1664525u + 1013904223u;
    const std::uint32_t offset = (number >> 16) % kVariables;
    x86::Mem at = from_code ? x86::ptr(base + offset, 1) : x86::ptr(x86::rdx, static_cast<std::int32_t>(offset), 1);
    if (from_code) at.setRel();
    return at;
  };
  a.mov(x86::rdx, base);
  for (std::size_t rung = 0; rung < kRungs; ++rung) {
    a.movzx(x86::eax, variable());
    a.and_(x86::al, variable());
    a.or_(x86::al, variable());
    a.mov(variable(), x86::al);
  }
  a.ret();
  code.flatten();
  bool reached = true;
  auto memory = CodeMemory::make(code.codeSize(), variables.data(), [&](std::span<std::byte> to, std::uint64_t at) {
    reached = code.relocateToBase(at) == asmjit::kErrorOk;
    if (reached) code.copyFlattenedData(to.data(), to.size());
  });
  if (memory && !reached) return core::Problem{core::Code::P9001, "out of reach", {}};
  return memory;
}

std::int64_t time_ns(Ladder ladder) {
  constexpr int kScans = 500;
  const auto begin = std::chrono::steady_clock::now();
  for (int scan = 0; scan < kScans; ++scan) ladder();
  return std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
}

bool measure() {
  constexpr int kTurns = 8;
  const auto by_code = make_ladder(true), by_register = make_ladder(false);
  if (!by_code || !by_register) return false;
  const auto ladder = [](const CodeMemory& memory) { return std::bit_cast<Ladder>(memory.data()); };
  std::int64_t code_ns = std::numeric_limits<std::int64_t>::max(), register_ns = code_ns;
  for (int turn = 0; turn < kTurns; ++turn) {
    code_ns = std::min(code_ns, time_ns(ladder(*by_code)));
    register_ns = std::min(register_ns, time_ns(ladder(*by_register)));
  }
  return code_ns < register_ns;
}

}  // namespace

bool names_from_code() {
  static const bool kFaster = measure();
  return kFaster;
}

}  // namespace plc::native
