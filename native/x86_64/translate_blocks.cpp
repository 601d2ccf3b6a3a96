// Blocks of the library that cost less than a call: edges, bistables, timers, counters (stdlib/blocks/). Each does what
// the step of its row does, byte by byte, whatever its ports and states hold.
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types.h"
#include "native/library_rows.h"
#include "native/translate.h"
#include "stdlib/blocks/timers.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using stdlib::BlockSpec;
using TimerPorts = stdlib::fb::TimerPorts;
constexpr int kIdle = TimerPorts::kIdle, kArmed = TimerPorts::kArmed, kDone = TimerPorts::kDone;

/// The ports of one instance.
class Ports {
 public:
  Ports(Assembly& s, const BlockSpec& spec, std::uint32_t operand) : s_(s), spec_(spec), operand_(operand) {}

  [[nodiscard]] const BlockSpec& spec() const { return spec_; }
  [[nodiscard]] std::uint32_t operand() const { return operand_; }
  [[nodiscard]] std::uint32_t operand(std::string_view port) const {
    return operand_ + stdlib::field_named(spec_, port)->offset;
  }
  [[nodiscard]] x86::Mem bit(std::string_view port) const { return s_.at(operand(port), 1); }
  [[nodiscard]] x86::Mem value(std::string_view port, unsigned bytes) const { return s_.at(operand(port), bytes); }

  /// Stores two bits that lie side by side, as one store where the registers allow: a processor writes less to its
  /// cache at a time than it reads. The second byte of `low` is lost.
  void store_both(std::string_view first, std::uint32_t low, std::string_view second, std::uint32_t high) const {
    if (low <= kLastWithTwoBytes && high <= kLastWithTwoBytes && operand(second) == operand(first) + 1) {
      s_.a.mov(x86::gpb_hi(low), gp(high, 1));
      s_.a.mov(value(first, 2), gp(low, 2));
      return;
    }
    s_.a.mov(bit(first), gp(low, 1));
    s_.a.mov(bit(second), gp(high, 1));
  }

 private:
  static constexpr std::uint32_t kLastWithTwoBytes = reg::kDx;

  Assembly& s_;
  const BlockSpec& spec_;
  std::uint32_t operand_;
};

/// An input, extended, in some register.
struct Input {
  std::uint32_t number = 0;
  bool owed = false;  ///< it is not stored yet
};
/// Takes the input at `operand`: where it is owed, or from memory into `to`.
Input take_input(Assembly& s, std::uint32_t to, std::uint32_t operand) {
  if (const auto owed = s.take_deferred(operand)) {
    s.forget();
    if (!owed->extended) s.a.movzx(gp(owed->number, 4), gp(owed->number, 1));
    return {owed->number, true};
  }
  s.load_extended(to, operand, Type::kU8);
  return {to, false};
}

// ---- edges and bistables

/// to = in AND NOT before; all of `before` and `in` but their lowest bits is zero. `before` is lost.
void rising(Assembly& s, std::uint32_t to, std::uint32_t in, std::uint32_t before) {
  if (s.has_andn()) {
    s.a.andn(gp(to, 4), gp(before, 4), gp(in, 4));
    return;
  }
  s.a.xor_(gp(before, 4), 1);
  s.a.and_(gp(before, 4), gp(in, 4));
  if (to != before) s.a.mov(gp(to, 4), gp(before, 4));
}

/// M is the input, negated for F_TRIG. No jump: an input that changes with each scan would be mispredicted.
void edge(Assembly& s, const Ports& p, bool is_rising) {
  const Input in = take_input(s, reg::kAx, p.operand("CLK"));
  s.forget();
  if (in.owed) s.a.mov(p.bit("CLK"), gp(in.number, 1));
  if (!is_rising) s.a.xor_(gp(in.number, 4), 1);
  const std::uint32_t q = in.number == reg::kCx ? reg::kAx : reg::kCx;
  s.a.movzx(gp(q, 4), p.bit("M"));
  rising(s, q, in.number, q);
  p.store_both("Q", q, "M", in.number);
  s.hold_bit(p.operand("Q"), q);
}

void set_dominant(Assembly& s, const Ports& p) {
  s.load(reg::kAx, p.operand("Q1"), 1);
  s.a.cmp(x86::al, p.bit("R"));
  s.a.seta(x86::al);
  s.a.or_(x86::al, p.bit("S1"));
  s.store(p.operand("Q1"), 1, reg::kAx);
}

void reset_dominant(Assembly& s, const Ports& p) {
  s.load(reg::kAx, p.operand("S"), 1);
  s.a.or_(x86::al, p.bit("Q1"));
  s.a.cmp(x86::al, p.bit("R1"));
  s.a.seta(x86::al);
  s.store(p.operand("Q1"), 1, reg::kAx);
}

// ---- timers

/// What a block does that is not at rest: its step, on a cold path. One call for all of them keeps the code of programs
/// with thousands of timers inside the caches, and what inputs at random cost is a mispredicted jump either way.
void call_step(Assembly& s, const BlockSpec& spec, std::uint32_t ports) {
  s.pass_step(1);
  s.pass_address(0, ports);
  s.call_address(reinterpret_cast<std::uint64_t>(spec.step));
}

/// Ports with which a timer leaves everything as it is. M is as IN, which is the index here; Q is, too, or FALSE.
struct Steady {
  int state[2];
  bool q_is_in;
};
constexpr Steady kOnDelay = {{kIdle, kDone}, true};
constexpr Steady kOffDelay = {{kIdle, kArmed}, true};
constexpr Steady kPulse = {{kIdle, kDone}, false};

static_assert(offsetof(TimerPorts, q) - offsetof(TimerPorts, in) < 4 &&
              offsetof(TimerPorts, m) - offsetof(TimerPorts, in) < 4 &&
              offsetof(TimerPorts, state) - offsetof(TimerPorts, in) < 4);

/// A timer: nothing, where its four bytes say that there is nothing to do, or its step. They are looked at together,
/// with what they are to be computed from IN: without a jump that would depend on it. Q is in the register of IN after
/// it.
void timer(Assembly& s, const Ports& p, const Steady& steady) {
  const std::uint32_t first = p.operand("IN");
  const auto byte = [&](std::string_view port, int value) {
    return static_cast<std::uint32_t>(value) << 8 * (p.operand(port) - first);
  };
  const auto pattern = [&](int in) {
    return byte("IN", in) | byte("M", in) | byte("STATE", steady.state[in]) | byte("Q", steady.q_is_in ? in : 0);
  };
  const asmjit::Label changes = s.a.newLabel();
  const asmjit::Label end = s.a.newLabel();
  const Input in = take_input(s, reg::kCx, first);
  // WHY values in registers: a comparison with memory is no one step with the jump after it.
  const auto [wanted, found] = in.number == reg::kDx ? std::pair(reg::kSi, reg::kDi)
                                                     : std::pair(reg::kDx, in.number == reg::kSi ? reg::kDi : reg::kSi);
  s.a.imul(gp(wanted, 4), gp(in.number, 4), static_cast<std::int32_t>(pattern(1) - pattern(0)));
  if (pattern(0) != 0) s.a.add(gp(wanted, 4), pattern(0));
  s.a.mov(gp(found, 4), s.at(first, 4));
  s.a.cmp(gp(wanted, 4), gp(found, 4));
  s.a.jne(changes);
  if (!steady.q_is_in) s.a.xor_(gp(in.number, 4), gp(in.number, 4));
  s.land(end);
  s.hold_bit(p.operand("Q"), in.number);
  s.cold_path([&s, p, changes, end, in] {
    s.a.bind(changes);
    if (in.owed) s.a.mov(p.bit("IN"), gp(in.number, 1));
    call_step(s, p.spec(), p.operand());
    s.a.movzx(gp(in.number, 4), p.bit("Q"));
    s.a.jmp(end);
  });
}

// ---- counters

/// CTU: Q when CV has reached PV. CTD: Q when CV is not above 0. If there is no edge and the status bytes already have
/// their final values, nothing is stored; most counters stand still. Otherwise their step runs.
void counter(Assembly& s, const Ports& p, core::Rep rep, bool up) {
  const unsigned bytes = core::rep_bytes(rep);
  const bool with_sign =
      rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32 || rep == core::Rep::kI64;
  const char* const edge = up ? "CU" : "CD";
  const char* const reset = up ? "R" : "LD";
  const char* const memory = up ? "CU_M" : "CD_M";
  std::vector<std::uint32_t> unused = {reg::kSi, reg::kDx, reg::kCx, reg::kAx};
  const auto owed_edge = s.take_deferred(p.operand(edge));
  const auto owed_reset = s.take_deferred(p.operand(reset));
  s.forget();
  std::erase_if(unused, [&](std::uint32_t number) {
    return (owed_edge && number == owed_edge->number) || (owed_reset && number == owed_reset->number);
  });
  const auto take = [&unused] {
    const std::uint32_t number = unused.back();
    unused.pop_back();
    return number;
  };
  const auto input = [&](const std::optional<Assembly::DeferredStore>& owed, std::string_view port) {
    const std::uint32_t number = owed ? owed->number : take();
    if (!owed) {
      s.a.movzx(gp(number, 4), p.bit(port));
    } else if (!owed->extended) {
      s.a.movzx(gp(number, 4), gp(number, 1));
    }
    return number;
  };
  const std::uint32_t in = input(owed_edge, edge);
  const std::uint32_t back = input(owed_reset, reset);
  const std::uint32_t q = take();
  const std::uint32_t number = take();
  const x86::Gp count = gp(number, bytes);
  if (bytes < 4) {
    s.a.movzx(gp(number, 4), p.value("CV", bytes));
  } else {
    s.a.mov(count, p.value("CV", bytes));
  }
  s.a.xor_(gp(q, 4), gp(q, 4));
  if (up) {
    s.a.cmp(count, p.value("PV", bytes));
    s.a.set(with_sign ? x86::CondCode::kGE : x86::CondCode::kAE, gp(q, 1));
  } else {
    s.a.test(count, count);
    s.a.set(with_sign ? x86::CondCode::kLE : x86::CondCode::kE, gp(q, 1));
  }
  const std::uint32_t first = p.operand(edge);
  const auto byte = [&](std::string_view port) { return std::int32_t{1} << 8 * (p.operand(port) - first); };
  const asmjit::Label changes = s.a.newLabel(), end = s.a.newLabel();
  // Two that no input is owed in.
  std::vector<std::uint32_t> others = {reg::kDi, 8, 9, 10};
  std::erase_if(others, [in, back](std::uint32_t other) { return other == in || other == back; });
  const x86::Gp wanted = gp(others[0], 4), other = gp(others[1], 4);
  s.a.test(gp(back, 4), gp(back, 4));
  s.a.jnz(changes);
  s.a.imul(wanted, gp(in, 4), byte(edge) | byte(memory));
  s.a.imul(other, gp(q, 4), byte("Q"));
  s.a.add(wanted, other);
  s.a.mov(other, s.at(first, 4));
  s.a.cmp(wanted, other);
  s.a.jne(changes);
  s.land(end);
  s.hold_bit(p.operand("Q"), q);
  s.cold_path([=, &s] {
    s.a.bind(changes);
    if (owed_edge) s.a.mov(p.bit(edge), gp(in, 1));
    if (owed_reset) s.a.mov(p.bit(reset), gp(back, 1));
    call_step(s, p.spec(), p.operand());
    s.a.movzx(gp(q, 4), p.bit("Q"));
    s.a.jmp(end);
  });
}

}  // namespace

bool translate_block(Assembly& s, stdlib::Step step, std::uint32_t ports) {
  const auto row = block_of(step);
  if (!row) return false;
  const Ports p(s, *row->spec, ports);
  switch (row->block) {
    case Block::kRisingEdge:
    case Block::kFallingEdge:
      edge(s, p, row->block == Block::kRisingEdge);
      break;
    case Block::kSetDominant:
      set_dominant(s, p);
      break;
    case Block::kResetDominant:
      reset_dominant(s, p);
      break;
    case Block::kOnDelay:
      timer(s, p, kOnDelay);
      break;
    case Block::kOffDelay:
      timer(s, p, kOffDelay);
      break;
    case Block::kPulse:
      timer(s, p, kPulse);
      break;
    case Block::kCountUp:
    case Block::kCountDown:
      counter(s, p, core::rep_of(stdlib::field_named(*row->spec, "CV")->type), row->block == Block::kCountUp);
      break;
  }
  return true;
}

}  // namespace plc::native
