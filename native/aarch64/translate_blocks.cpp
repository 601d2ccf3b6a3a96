// Blocks of the library that cost less than a call: edges, bistables, counters (stdlib/blocks/). Each does what
// the step of its row does, byte by byte, whatever its ports and states hold.
#include <string_view>

#include "native/library_rows.h"
#include "native/translate.h"

namespace plc::native {
namespace {

using stdlib::BlockSpec;

/// The ports of one instance.
class Ports {
 public:
  Ports(Assembly& s, const BlockSpec& spec, std::uint32_t operand) : s_(s), spec_(spec), operand_(operand) {}

  [[nodiscard]] std::uint32_t operand(std::string_view port) const {
    return operand_ + stdlib::field_named(spec_, port)->offset;
  }
  void load(std::uint32_t to, std::string_view port, unsigned bytes) const {
    s_.load_from(s_.at(operand(port), bytes), bytes, to);
  }
  void store(std::string_view port, unsigned bytes, std::uint32_t from) const {
    s_.store_to(s_.at(operand(port), bytes), bytes, from);
  }

 private:
  Assembly& s_;
  const BlockSpec& spec_;
  std::uint32_t operand_;
};

// ---- edges and bistables

void edge(Assembly& s, const Ports& p, bool rising) {
  s.load(2, p.operand("CLK"), 1);
  if (!rising) s.a.eor(a64::w2, a64::w2, 1);
  p.load(0, "M", 1);
  p.store("M", 1, 2);
  s.a.bic(a64::w0, a64::w2, a64::w0);
  s.store(p.operand("Q"), 1, 0);
}

void set_dominant(Assembly& s, const Ports& p) {
  p.load(0, "Q1", 1);
  p.load(1, "R", 1);
  p.load(2, "S1", 1);
  s.a.bic(a64::w0, a64::w0, a64::w1);
  s.a.orr(a64::w0, a64::w0, a64::w2);
  s.store(p.operand("Q1"), 1, 0);
}

void reset_dominant(Assembly& s, const Ports& p) {
  p.load(0, "S", 1);
  p.load(1, "Q1", 1);
  p.load(2, "R1", 1);
  s.a.orr(a64::w0, a64::w0, a64::w1);
  s.a.bic(a64::w0, a64::w0, a64::w2);
  s.store(p.operand("Q1"), 1, 0);
}

// ---- counters

/// The value that counting up, or down, does not pass.
std::uint64_t last_of(Type type, bool up) {
  const unsigned bits = 8 * bytes_of(type) - (is_signed(type) ? 1 : 0);
  const std::uint64_t greatest = ~std::uint64_t{0} >> (64 - bits);
  if (up) return greatest;
  return is_signed(type) ? ~greatest : 0;
}

/// CTU: up, Q when CV has reached PV. CTD: down, Q when CV is not above 0. Neither passes the end of its type.
void counter(Assembly& s, const Ports& p, Type type, bool up) {
  const unsigned bytes = bytes_of(type);
  const bool with_sign = is_signed(type);
  const a64::Gp count = gp(0, bytes);
  const a64::Gp other = gp(3, bytes);
  const a64::Gp zero = gp(Assembly::kZero, bytes);
  s.load(1, p.operand(up ? "CU" : "CD"), 1);
  p.load(2, up ? "CU_M" : "CD_M", 1);
  p.store(up ? "CU_M" : "CD_M", 1, 1);
  s.a.bic(a64::w1, a64::w1, a64::w2);  // the step: 1 on an edge
  s.forget();
  s.load_extended(0, p.operand("CV"), type);
  s.load_extended(4, p.operand("PV"), type);
  p.load(5, up ? "R" : "LD", 1);
  // No step from the last value on.
  s.constant(other, last_of(type, up));
  s.a.cmp(count, other);
  s.a.csel(a64::w1, a64::wzr, a64::w1, Condition::kEQ);
  if (up) {
    s.a.add(count, count, gp(1, bytes));
  } else {
    s.a.sub(count, count, gp(1, bytes));
  }
  s.a.cmp(a64::w5, 0);
  s.a.csel(count, up ? zero : gp(4, bytes), count, Condition::kNE);
  p.store("CV", bytes, 0);
  s.a.cmp(count, up ? gp(4, bytes) : zero);
  if (up) {
    s.a.cset(a64::w0, with_sign ? Condition::kGE : Condition::kHS);
  } else {
    s.a.cset(a64::w0, with_sign ? Condition::kLE : Condition::kEQ);
  }
  s.store(p.operand("Q"), 1, 0);
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
    case Block::kOffDelay:
    case Block::kPulse:
      return false;  // a call of the step is no more code
    case Block::kCountUp:
    case Block::kCountDown:
      counter(s, p, *machine_type(stdlib::field_named(*row->spec, "CV")->type), row->block == Block::kCountUp);
      break;
  }
  return true;
}

}  // namespace plc::native
