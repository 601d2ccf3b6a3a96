#include "native/assembly.h"

#include <algorithm>

namespace plc::native {
namespace {

constexpr std::uint32_t kOffsetRegister = 16;
/// The longest distance of a page that one instruction adds.
constexpr std::uint32_t kFarthestPage = 0xfff000;

}  // namespace

std::uint32_t Assembly::free(std::uint32_t n) const { return n < holder() ? n : n + 1; }

Assembly::Place Assembly::place_of(std::uint32_t operand) const {
  if (relative && (operand & runtime::kRelativeBit) != 0) return {kInstance, operand & ~runtime::kRelativeBit};
  return {kTable, operand};
}

std::uint32_t Assembly::page(std::uint32_t base, std::uint32_t offset) {
  for (std::uint32_t i = 0; i < pages_.size(); ++i) {
    if (pages_[i].base == base && pages_[i].offset == offset) return kFirstPage + i;
  }
  const auto i = static_cast<std::uint32_t>(next_page_);
  next_page_ = (next_page_ + 1) % pages_.size();
  pages_[i] = {base, offset};
  a.add(a64::x(kFirstPage + i), a64::x(base), offset);
  return kFirstPage + i;
}

a64::Mem Assembly::at(std::uint32_t operand, unsigned bytes) {
  expect_stored(operand);
  const Place place = place_of(operand);
  // A distance counts in units of what is there, of which 12 bits can be named.
  const bool aligned = place.offset % bytes == 0;
  if (aligned && place.offset / bytes < kPageBytes) {
    return a64::ptr(a64::x(place.base), static_cast<std::int32_t>(place.offset));
  }
  const std::uint32_t in_page = place.offset % kPageBytes;
  if (aligned && place.offset - in_page <= kFarthestPage) {
    return a64::ptr(a64::x(page(place.base, place.offset - in_page)), static_cast<std::int32_t>(in_page));
  }
  constant(a64::x(kOffsetRegister), place.offset);
  return a64::ptr(a64::x(place.base), a64::x(kOffsetRegister));
}

void Assembly::address(const a64::Gp& to, std::uint32_t operand) {
  expect_stored(operand);
  const Place place = place_of(operand);
  const std::uint32_t in_page = place.offset % kPageBytes;
  if (place.offset - in_page > kFarthestPage) {
    constant(a64::x(kOffsetRegister), place.offset);
    a.add(to, a64::x(place.base), a64::x(kOffsetRegister));
  } else if (place.offset == in_page) {
    a.add(to, a64::x(place.base), in_page);
  } else {
    a.add(to, a64::x(place.base), place.offset - in_page);
    if (in_page != 0) a.add(to, to, in_page);
  }
}

void Assembly::constant(const a64::Gp& to, std::uint64_t value) {
  const unsigned parts = to.isGpX() ? 4 : 2;
  const auto part = [value](unsigned n) { return static_cast<std::uint32_t>(value >> (16 * n) & 0xffff); };
  unsigned zeros = 0;
  unsigned ones = 0;
  for (unsigned n = 0; n < parts; ++n) {
    zeros += part(n) == 0 ? 1 : 0;
    ones += part(n) == 0xffff ? 1 : 0;
  }
  // The rest is what most parts are.
  const bool inverted = ones > zeros;
  const std::uint32_t rest = inverted ? 0xffff : 0;
  bool first = true;
  for (unsigned n = 0; n < parts; ++n) {
    if (part(n) == rest && !(first && n + 1 == parts)) continue;
    if (!first) {
      a.movk(to, part(n), 16 * n);
    } else if (inverted) {
      a.movn(to, part(n) ^ 0xffffu, 16 * n);
    } else {
      a.movz(to, part(n), 16 * n);
    }
    first = false;
  }
}

void Assembly::load_from(const a64::Mem& from, unsigned bytes, std::uint32_t to) {
  switch (bytes) {
    case 1:
      a.ldrb(a64::w(to), from);
      break;
    case 2:
      a.ldrh(a64::w(to), from);
      break;
    default:
      a.ldr(gp(to, bytes), from);
      break;
  }
}

void Assembly::store_to(const a64::Mem& to, unsigned bytes, std::uint32_t from) {
  switch (bytes) {
    case 1:
      a.strb(a64::w(from), to);
      break;
    case 2:
      a.strh(a64::w(from), to);
      break;
    default:
      a.str(gp(from, bytes), to);
      break;
  }
}

void Assembly::load(std::uint32_t to, std::uint32_t operand, unsigned bytes) {
  if (holds(operand, bytes)) {
    if (to != holder()) a.mov(gp(to, bytes), gp(holder(), bytes));
    return;
  }
  overwrite(to, false);
  load_from(at(operand, bytes), bytes, to);
}

void Assembly::load_extended(std::uint32_t to, std::uint32_t operand, Type type) {
  const unsigned bytes = bytes_of(type);
  if (bytes >= 4) return load(to, operand, bytes);
  const bool with_sign = is_signed(type);
  if (holds(operand, bytes)) {
    const a64::Gp from = a64::w(holder());
    if (bytes == 1) {
      with_sign ? a.sxtb(a64::w(to), from) : a.uxtb(a64::w(to), from);
    } else {
      with_sign ? a.sxth(a64::w(to), from) : a.uxth(a64::w(to), from);
    }
    return;
  }
  overwrite(to, false);
  const a64::Mem from = at(operand, bytes);
  if (!with_sign) {
    load_from(from, bytes, to);
  } else if (bytes == 1) {
    a.ldrsb(a64::w(to), from);
  } else {
    a.ldrsh(a64::w(to), from);
  }
}

std::uint32_t Assembly::value(std::uint32_t to, std::uint32_t operand, unsigned bytes) {
  if (holds(operand, bytes)) return holder();
  load(to, operand, bytes);
  return to;
}

std::uint32_t Assembly::extended_value(std::uint32_t to, std::uint32_t operand, Type type) {
  if (bytes_of(type) >= 4) return value(to, operand, bytes_of(type));
  load_extended(to, operand, type);
  return to;
}

void Assembly::store(std::uint32_t operand, unsigned bytes, std::uint32_t from) {
  if (begin_store(operand)) store_to(at(operand, bytes), bytes, from);
  hold({operand, bytes, false, from});
}

void Assembly::load_real(std::uint32_t to, std::uint32_t operand, Type type) {
  if (holds_real(operand, type)) {
    if (to != holder()) a.fmov(vec(to, type), vec(holder(), type));
    return;
  }
  overwrite(to, true);
  a.ldr(vec(to, type), at(operand, bytes_of(type)));
}

std::uint32_t Assembly::real_value(std::uint32_t to, std::uint32_t operand, Type type) {
  if (holds_real(operand, type)) return holder();
  load_real(to, operand, type);
  return to;
}

void Assembly::store_real(std::uint32_t operand, Type type, std::uint32_t from) {
  if (begin_store(operand)) a.str(vec(from, type), at(operand, bytes_of(type)));
  hold({operand, bytes_of(type), true, from});
}

void Assembly::jump_on(Condition condition, const asmjit::Label& target) {
  const asmjit::Label skip = a.newLabel();
  a.b(asmjit::arm::negateCond(condition), skip);
  a.b(target);
  a.bind(skip);  // only this jump comes here: what is known of registers stays
}

}  // namespace plc::native
