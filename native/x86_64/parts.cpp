#include "native/x86_64/parts.h"

#include <limits>
#include <optional>

#include "runtime/interpreter/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using stdlib::Event;

constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();

/// One index: six words (runtime/interpreter/operations.h).
struct Index {
  explicit Index(const std::uint32_t* words)
      : operand(words[0]),
        count(words[1]),
        stride(words[2]),
        lower(runtime::load<std::int64_t>(words + 3)),
        rep(static_cast<core::Rep>(words[5])) {}
  std::uint32_t operand, count, stride;
  std::int64_t lower;
  core::Rep rep;

  [[nodiscard]] unsigned bytes() const { return core::rep_bytes(rep); }
  /// Powers of two that addresses multiply with.
  [[nodiscard]] std::optional<unsigned> shift() const {
    switch (stride) {
      case 1:
        return 0;
      case 2:
        return 1;
      case 4:
        return 2;
      case 8:
        return 3;
      default:
        return std::nullopt;
    }
  }
};

/// The number of the element, below the count, in the register returned, which is rax unless a loop keeps it; else to
/// `outside`, unless it is known to be `inside`. Uses rax and rcx.
x86::Gp element_number(Assembly& s, const Index& index, bool inside, const asmjit::Label& outside) {
  const auto holder = s.in_register(index.operand, index.bytes());
  asmjit::Operand number;
  if (holder) {
    number = gp(*holder, index.bytes());
  } else {
    number = s.at(index.operand, index.bytes());
  }
  x86::Gp element = x86::rax;
  if (index.rep == core::Rep::kI32 && index.lower > kLeast && index.lower + index.count <= kMost) {
    // 32 bits wrap, but not back into the array: no index is 2^32 below one inside. Upper halves are zero then, as they
    // are in what loops keep.
    const auto distance = static_cast<std::int32_t>(index.lower);
    if (const auto kept = s.kept(index.operand); kept && distance == 0) {
      element = gp(*kept, 8);
    } else if (holder && distance != 0) {
      s.a.lea(element.r32(), x86::ptr(gp(*holder, 8), -distance));
    } else {
      s.a.emit(x86::Inst::kIdMov, element.r32(), number);
      if (distance != 0) s.a.sub(element.r32(), distance);
    }
    if (inside) return element;
    s.a.cmp(element.r32(), index.count);
    s.a.jae(outside);
    return element;
  }
  switch (index.rep) {
    case core::Rep::kI8:
    case core::Rep::kI16:
      s.a.emit(x86::Inst::kIdMovsx, element, number);
      break;
    case core::Rep::kU8:
    case core::Rep::kU16:
      s.a.emit(x86::Inst::kIdMovzx, element.r32(), number);
      break;
    case core::Rep::kI32:
      s.a.emit(x86::Inst::kIdMovsxd, element, number);
      break;
    case core::Rep::kU32:
      s.a.emit(x86::Inst::kIdMov, element.r32(), number);
      break;
    default:
      s.a.emit(x86::Inst::kIdMov, element, number);
      break;
  }
  if (index.rep == core::Rep::kU64 && !inside) {
    s.a.test(element, element);
    s.a.js(outside);
  }
  if (index.lower < kLeast || index.lower > kMost) {
    s.a.mov(x86::rcx, index.lower);
    s.a.sub(element, x86::rcx);
  } else if (index.lower != 0) {
    s.a.sub(element, index.lower);
  }
  if (inside) return element;
  if (index.count <= kMost) {
    s.a.cmp(element, index.count);
  } else {
    s.a.mov(x86::ecx, index.count);
    s.a.cmp(element, x86::rcx);
  }
  s.a.jae(outside);
  return element;
}

bool is_path(const Instruction& i) {
  return i.operation.form == Form::kLoadPath || i.operation.form == Form::kStorePath;
}
bool is_inside(const Instruction& i, std::uint32_t index) { return index < 32 && (i.known.inside >> index & 1) != 0; }
/// No index can leave its array.
bool is_inside(const Instruction& i) {
  for (std::uint32_t index = 0; index < (is_path(i) ? i.words[4] : 1); ++index) {
    if (!is_inside(i, index)) return false;
  }
  return true;
}

/// Where an element is whose indices are inside, and whose only one, or last one but one, a loop keeps: after its row.
/// Nothing for others. Uses rax, rcx and registers of rows.
std::optional<x86::Mem> place_in_row(Assembly& s, std::uint32_t place, const Index& index, std::optional<Index> last,
                                     unsigned bytes, const asmjit::Label& outside) {
  if (!s.kept(index.operand) || (index.rep != core::Rep::kI16 && index.rep != core::Rep::kI32)) return std::nullopt;
  if (last ? !last->shift() : index.shift().has_value()) return std::nullopt;
  std::int32_t distance = 0;
  const x86::Gp base = s.base(place, distance);
  const Assembly::Row like{base.id(), index.operand, index.lower, index.count, index.stride};
  const Assembly::Row* row = s.find_row(like);
  if (row == nullptr) {
    row = &s.add_row(like);
    const x86::Gp address = gp(row->reg, 8);
    s.a.imul(address, element_number(s, index, true, outside), static_cast<std::int32_t>(index.stride));
    s.a.add(address, base);
    s.forget();
  }
  const std::int64_t ahead = distance + row->ahead * index.stride;
  if (ahead != static_cast<std::int32_t>(ahead)) {
    s.forget_rows();
    return std::nullopt;
  }
  const x86::Gp address = gp(row->reg, 8);
  std::optional<x86::Gp> element;
  if (last) element = element_number(s, *last, true, outside);
  s.forget();
  if (!element) return x86::ptr(address, static_cast<std::int32_t>(ahead), bytes);
  return x86::ptr(address, *element, *last->shift(), static_cast<std::int32_t>(ahead), bytes);
}

/// Words: the value, place, index (6) or path. Where the part is; else to `outside`. Uses rax, rcx and rsi.
x86::Mem part_place(Assembly& s, const Instruction& i, unsigned bytes, const asmjit::Label& outside) {
  const bool path = is_path(i);
  const std::uint32_t place = i.words[2] + (path ? i.words[3] : 0);
  const std::uint32_t count = path ? i.words[4] : 1;
  const std::uint32_t* words = i.words + (path ? 5 : 3);
  if (!is_inside(i)) {
    s.forget_rows();  // an event is raised by a call
  } else if (count <= 2) {
    const auto last = count == 2 ? std::optional(Index(words + runtime::kIndexWords)) : std::nullopt;
    if (const auto found = place_in_row(s, place, Index(words), last, bytes, outside)) return *found;
  }
  bool far = false;  // rsi holds a distance
  const auto add = [&](const x86::Gp& element, std::uint32_t stride) {
    s.forget_rows();
    s.a.imul(far ? x86::rax : x86::rsi, element, static_cast<std::int32_t>(stride));
    if (far) s.a.add(x86::rsi, x86::rax);
    far = true;
  };
  for (std::uint32_t n = 0; n + 1 < count; ++n, words += runtime::kIndexWords) {
    const Index index(words);
    add(element_number(s, index, is_inside(i, n), outside), index.stride);
    s.forget();
  }
  const Index last(words);
  const x86::Gp element = element_number(s, last, is_inside(i, count - 1), outside);
  s.forget();
  const auto shift = last.shift();
  if (!shift) add(element, last.stride);
  std::int32_t distance = 0;
  const x86::Gp base = s.base(place, distance);
  if (!far) return x86::ptr(base, element, *shift, distance, bytes);
  s.a.add(x86::rsi, base);
  if (!shift) return x86::ptr(x86::rsi, distance, bytes);
  return x86::ptr(x86::rsi, element, *shift, distance, bytes);
}

}  // namespace

void load_part(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const std::uint32_t out = i.words[1];
  const asmjit::Label outside = s.a.newLabel();
  const asmjit::Label done = s.a.newLabel();
  const x86::Mem part = part_place(s, i, bytes, outside);
  const auto real = s.kept(out, true);
  if (real && i.known.passes_on) return s.pass_on(out, part);
  const std::uint32_t to = s.kept(out).value_or(reg::kDx);
  if (real) {
    s.a.emit(bytes == 4 ? x86::Inst::kIdMovss : x86::Inst::kIdMovsd, x86::xmm(*real), part);
  } else if (bytes < 4) {
    s.a.movzx(gp(to, 4), part);
  } else {
    s.a.mov(gp(to, bytes), part);
  }
  s.a.bind(done);
  if (!is_inside(i)) {
    s.cold_path([&s, outside, done, position = i.position, real, to] {
      s.a.bind(outside);
      s.raise(position, static_cast<int>(Event::kBadIndex));
      if (real) {
        s.a.xorps(x86::xmm(*real), x86::xmm(*real));
      } else {
        s.a.xor_(gp(to, 4), gp(to, 4));
      }
      s.a.jmp(done);
    });
  }
  if (!real) s.store(out, bytes, to);
}

void store_part(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const std::uint32_t in = i.words[1];
  const asmjit::Label outside = s.a.newLabel();
  const asmjit::Label done = s.a.newLabel();
  const auto real = bytes < 4 ? std::nullopt : s.in_register(in, bytes == 4 ? Type::kF32 : Type::kF64);
  // What is held may lie where the address is made.
  const std::uint32_t from = s.kept(in).value_or(reg::kDx);
  if (!real) s.load(from, in, bytes);
  const x86::Mem part = part_place(s, i, bytes, outside);
  if (real) {
    s.a.emit(bytes == 4 ? x86::Inst::kIdMovss : x86::Inst::kIdMovsd, part, x86::xmm(*real));
  } else {
    s.a.mov(part, gp(from, bytes));
  }
  s.forget();  // any variable may be an element
  s.a.bind(done);
  if (is_inside(i)) return;
  s.cold_path([&s, outside, done, position = i.position] {
    s.a.bind(outside);
    s.raise(position, static_cast<int>(Event::kBadIndex));
    s.a.jmp(done);
  });
}

}  // namespace plc::native
