#include "native/assembly.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "native/machine_layout.h"
#include "native/translate.h"

namespace plc::native {

namespace machine {
x86::Mem loops_left() { return x86::dword_ptr(x86::rbx, kLoopsLeft); }
x86::Mem place() { return x86::dword_ptr(x86::rbx, kPlace); }
x86::Mem event_count() { return x86::qword_ptr(x86::rbx, kEventCount); }
x86::Mem step() { return x86::ptr(x86::rbx, kStep); }
x86::Mem now() { return x86::qword_ptr(x86::rbx, kNow); }
}  // namespace machine

x86::Gp gp(std::uint32_t number, unsigned bytes) {
  switch (bytes) {
    case 1:
      return x86::gpb(number);
    case 2:
      return x86::gpw(number);
    case 4:
      return x86::gpd(number);
    default:
      return x86::gpq(number);
  }
}

x86::Mem Assembly::at(std::uint32_t operand, unsigned bytes) {
  if (kept(operand) || kept(operand, true)) refuse("a variable of a loop is not in the table");
  expect_stored(operand);
  return place(operand, bytes);
}
x86::Mem Assembly::place(std::uint32_t operand, unsigned bytes) const {
  if (from_code && !(relative && (operand & runtime::kRelativeBit) != 0)) {
    x86::Mem at = x86::ptr(address_of(operand), bytes);
    at.setRel();
    return at;
  }
  std::int32_t distance = 0;
  const x86::Gp from = base(operand, distance);
  return x86::ptr(from, distance, bytes);
}

void Assembly::address(const x86::Gp& to, std::uint32_t operand) {
  expect_stored(operand);
  a.lea(to, place(operand, 0));
}

x86::Gp Assembly::base(std::uint32_t operand, std::int32_t& distance) const {
  const bool of_instance = relative && (operand & runtime::kRelativeBit) != 0;
  distance = static_cast<std::int32_t>(of_instance ? operand & ~runtime::kRelativeBit : operand);
  return of_instance ? x86::r13 : x86::rbp;
}

std::optional<std::uint32_t> Assembly::kept(std::uint32_t operand, bool real) const {
  if (kept_ == nullptr) return std::nullopt;
  for (const Kept::Variable& variable : kept_->variables) {
    if (variable.what.operand == operand && variable.what.real == real) return variable.reg;
  }
  return std::nullopt;
}
std::optional<std::uint32_t> Assembly::in_register(std::uint32_t operand, unsigned bytes) const {
  if (holds(operand, bytes)) return held_.reg;
  return kept(operand);
}
std::optional<std::uint32_t> Assembly::in_register(std::uint32_t operand, Type real) const {
  if (holds_real(operand, real)) return held_.reg;
  return kept(operand, true);
}
asmjit::Operand Assembly::value(std::uint32_t operand, unsigned bytes) {
  if (const auto number = in_register(operand, bytes)) return gp(*number, bytes);
  if (const auto known = constant(operand, bytes)) {
    const unsigned unused = 64 - 8 * bytes;
    const std::int64_t number = static_cast<std::int64_t>(*known << unused) >> unused;
    if (number == static_cast<std::int32_t>(number)) return asmjit::imm(number);
  }
  return at(operand, bytes);
}
asmjit::Operand Assembly::real_value(std::uint32_t operand, Type type) {
  if (passed_ && passed_->first == operand) return std::exchange(passed_, std::nullopt)->second;
  if (const auto number = in_register(operand, type)) return x86::xmm(*number);
  return at(operand, bytes_of(type));
}

void Assembly::load(std::uint32_t to, std::uint32_t operand, unsigned bytes) {
  const unsigned wide = bytes == 8 ? 8 : 4;
  if (const auto from = in_register(operand, bytes)) {
    if (to == *from) return;
    overwrite(to, false);
    a.mov(gp(to, wide), gp(*from, wide));
    return;
  }
  overwrite(to, false);
  if (const auto from = kept(operand, true)) {
    a.emit(bytes == 8 ? x86::Inst::kIdMovq : x86::Inst::kIdMovd, gp(to, bytes), x86::xmm(*from));
  } else if (const auto known = constant(operand, bytes)) {
    a.mov(gp(to, wide), *known);
  } else if (bytes < 4) {
    // Narrow loads are extended: a register that keeps its upper part would wait for who wrote it.
    a.movzx(gp(to, 4), at(operand, bytes));
  } else {
    a.mov(gp(to, bytes), at(operand, bytes));
  }
}

void Assembly::load_extended(std::uint32_t to, std::uint32_t operand, Type type) {
  const unsigned bytes = bytes_of(type);
  if (bytes >= 4) return load(to, operand, bytes);
  const auto number = in_register(operand, bytes);
  if (!holds(operand, bytes)) overwrite(to, false);
  const auto id = is_signed(type) ? x86::Inst::kIdMovsx : x86::Inst::kIdMovzx;
  if (number) {
    a.emit(id, gp(to, 4), gp(*number, bytes));
  } else {
    a.emit(id, gp(to, 4), at(operand, bytes));
  }
}

void Assembly::store(std::uint32_t operand, unsigned bytes, std::uint32_t from) {
  const unsigned wide = bytes == 8 ? 8 : 4;
  if (const auto to = kept(operand)) {
    if (*to != from) a.mov(gp(*to, wide), gp(from, wide));
    return forget();
  }
  if (const auto to = kept(operand, true)) {
    a.emit(bytes == 8 ? x86::Inst::kIdMovq : x86::Inst::kIdMovd, x86::xmm(*to), gp(from, bytes));
    return forget();
  }
  if (begin_store(operand)) a.mov(at(operand, bytes), gp(from, bytes));
  hold({operand, bytes, false, from});
}

void Assembly::store_change(std::uint32_t operand, std::uint32_t from) {
  if (held_.operand == operand) forget();
  const x86::Mem to = at(operand, 1);
  a.cmp(to, gp(from, 1));
  store_if_not_equal(to, gp(from, 1));
}
void Assembly::store_port(std::uint32_t operand, unsigned bytes, std::uint64_t value) {
  if (held_.operand == operand) forget();
  const x86::Mem to = at(operand, bytes);
  const std::int64_t number = static_cast<std::int64_t>(value << (64 - 8 * bytes)) >> (64 - 8 * bytes);
  if (bytes == 1) {
    // As store_change(). WHY through a register: a comparison of memory with a constant is no one step with the jump
    // after it.
    const x86::Gp found = gp(unused(), 4);
    a.movzx(found, to);
    a.cmp(found, static_cast<std::uint8_t>(value));
    store_if_not_equal(to, asmjit::imm(number));
  } else if (number == static_cast<std::int32_t>(number)) {
    a.mov(to, number);
  } else {
    const x86::Gp known = gp(unused(), 8);
    a.mov(known, value);
    a.mov(to, known);
  }
}
std::optional<Assembly::DeferredStore> Assembly::take_deferred(std::uint32_t operand) {
  const auto owed = std::find_if(deferred_.begin(), deferred_.end(),
                                 [operand](const DeferredStore& bit) { return bit.operand == operand; });
  if (owed == deferred_.end()) return std::nullopt;
  const DeferredStore bit = *owed;
  deferred_.erase(owed);
  return bit;
}
std::uint32_t Assembly::unused() const {
  // One more than may be held and owed.
  constexpr std::uint32_t kAny[] = {reg::kDx, reg::kCx, reg::kSi, reg::kDi};
  return *std::find_if(std::begin(kAny), std::prev(std::end(kAny)), [this](std::uint32_t number) {
    return held_.reg != number && std::none_of(deferred_.begin(), deferred_.end(),
                                               [number](const DeferredStore& bit) { return bit.number == number; });
  });
}
void Assembly::store_if_not_equal(const x86::Mem& to, const asmjit::Operand& value) {
  const asmjit::Label changed = label();
  const asmjit::Label done = label();
  a.jne(changed);
  a.bind(done);
  cold_path([this, changed, done, to, value] {
    a.bind(changed);
    a.emit(x86::Inst::kIdMov, to, value);
    a.jmp(done);
  });
}

void Assembly::load_real(std::uint32_t to, std::uint32_t operand, Type type) {
  const bool f32 = type == Type::kF32;
  const x86::Xmm value = x86::xmm(to);
  if (const auto from = in_register(operand, type)) {
    if (to == *from) return;
    overwrite(to, true);
    a.movaps(value, x86::xmm(*from));
    return;
  }
  overwrite(to, true);
  if (const auto from = kept(operand)) {
    a.emit(f32 ? x86::Inst::kIdMovd : x86::Inst::kIdMovq, value, gp(*from, bytes_of(type)));
  } else if (f32) {
    a.movss(value, at(operand, 4));
  } else {
    a.movsd(value, at(operand, 8));
  }
}

void Assembly::store_real(std::uint32_t operand, Type type, std::uint32_t from) {
  if (const auto to = kept(operand, true)) {
    if (*to != from) a.movaps(x86::xmm(*to), x86::xmm(from));
    return forget();
  }
  const bool f32 = type == Type::kF32;
  if (const auto to = kept(operand)) {
    a.emit(f32 ? x86::Inst::kIdMovd : x86::Inst::kIdMovq, gp(*to, bytes_of(type)), x86::xmm(from));
    return forget();
  }
  if (!begin_store(operand)) {
    // It is only held.
  } else if (f32) {
    a.movss(at(operand, 4), x86::xmm(from));
  } else {
    a.movsd(at(operand, 8), x86::xmm(from));
  }
  hold({operand, bytes_of(type), true, from});
}

// ---- rows

namespace {
constexpr std::uint32_t kRowRegisters[] = {reg::kSi, reg::kDi};
}

const Assembly::Row* Assembly::find_row(const Row& like) const {
  const auto row = std::find_if(rows_.begin(), rows_.end(), [&like](const Row& r) { return r.is_like(like); });
  return row == rows_.end() ? nullptr : &*row;
}
const Assembly::Row& Assembly::add_row(Row row) {
  if (rows_.size() == std::size(kRowRegisters)) rows_.erase(rows_.begin());
  row.reg = rows_.empty() || rows_[0].reg != kRowRegisters[0] ? kRowRegisters[0] : kRowRegisters[1];
  rows_.push_back(row);
  return rows_.back();
}
void Assembly::begin(const Instruction& instruction) {
  // Those with code that leaves the registers of rows alone, and whose rare cases do not call.
  switch (instruction.operation.form) {
    case Form::kDiv:
      if (is_real(instruction.operation.type)) return;
      break;
    case Form::kMove:
    case Form::kLoadElement:
    case Form::kStoreElement:
    case Form::kLoadPath:
    case Form::kStorePath:
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
    case Form::kCompare:
    case Form::kCompareJumpUnless:
    case Form::kCompareJumpIf:
      return;
    default:
      break;
  }
  forget_rows();
}
void Assembly::end(const Instruction& instruction) {
  const Form form = instruction.operation.form;
  if (rows_.empty() || form == Form::kStoreElement || form == Form::kStorePath) return;
  const std::uint32_t* const w = instruction.words;
  std::optional<std::int64_t> added;
  if (form == Form::kAdd || form == Form::kSub) {
    const unsigned unused = 64 - 8 * bytes_of(instruction.operation.type);
    if (const auto number = w[1] == w[2] ? constant(w[3], bytes_of(instruction.operation.type)) : std::nullopt) {
      added = static_cast<std::int64_t>(*number << unused) >> unused;
      if (form == Form::kSub) added = -*added;
    }
  }
  // So near that an index of 16 bits that wraps is not in its array any more.
  constexpr std::int64_t kFar = 1 << 14;
  std::erase_if(rows_, [&](Row& row) {
    if (row.operand != w[1]) return false;
    row.ahead += added.value_or(0);
    return !added || row.ahead > kFar || row.ahead < -kFar || row.count > kFar;
  });
}

// ---- loops

void Assembly::enter_loop(const Loop& loop) {
  // Not those that calls take arguments in: arguments are there before registers are written back.
  static constexpr std::uint32_t kIntegers[] = {8, 9, 10, 11, 12, 15};
  static constexpr std::uint32_t kFirstReal = 2, kReals = 14;
  auto kept = std::make_shared<Kept>();
  std::size_t integers = 0;
  std::uint32_t reals = 0;
  kept->budget = kIntegers[integers++];
  for (const LoopVariable& variable : loop.variables) {
    if (!variable.real && constant(variable.operand, variable.bytes)) continue;
    if (variable.real && reals < kReals) {
      kept->variables.push_back({variable, kFirstReal + reals++});
    } else if (!variable.real && integers < std::size(kIntegers)) {
      kept->variables.push_back({variable, kIntegers[integers++]});
    }
  }
  forget();
  kept_ = std::move(kept);
  read_back();
}

void Assembly::read_back() {
  if (kept_ == nullptr) return;
  a.xor_(gp(kept_->budget, 4), gp(kept_->budget, 4));
  for (const auto& [variable, number] : kept_->variables) {
    const x86::Mem from = place(variable.operand, variable.bytes);
    if (variable.real) {
      a.emit(variable.bytes == 4 ? x86::Inst::kIdMovss : x86::Inst::kIdMovsd, x86::xmm(number), from);
    } else if (variable.bytes < 4) {
      a.movzx(gp(number, 4), from);
    } else {
      a.mov(gp(number, variable.bytes), from);
    }
  }
}

void Assembly::write_back() {
  if (kept_ == nullptr) return;
  a.add(machine::loops_left(), gp(kept_->budget, 4));
  for (const auto& [variable, number] : kept_->variables) {
    if (!variable.written) continue;
    const x86::Mem to = place(variable.operand, variable.bytes);
    if (variable.real) {
      a.emit(variable.bytes == 4 ? x86::Inst::kIdMovss : x86::Inst::kIdMovsd, to, x86::xmm(number));
    } else {
      a.mov(to, gp(number, variable.bytes));
    }
  }
}

void Assembly::make_one_nan(std::uint32_t operand, Type type) {
  const bool f32 = type == Type::kF32;
  forget();
  const std::uint32_t number = kept(operand, true).value_or(0);
  load_real(number, operand, type);
  one_nan(number, f32);
  store_real(operand, type, number);
}

void Assembly::one_nan(std::uint32_t number, bool f32) {
  const x86::Xmm value = x86::xmm(number);
  const asmjit::Label nan = label();
  const asmjit::Label done = label();
  a.emit(f32 ? x86::Inst::kIdUcomiss : x86::Inst::kIdUcomisd, value, value);
  a.jp(nan);
  a.bind(done);
  cold_path([this, nan, done, value, f32] {
    a.bind(nan);
    if (f32) {
      a.mov(x86::eax, 0x7fc00000u);
      a.movd(value, x86::eax);
    } else {
      a.mov(x86::rax, 0x7ff8000000000000u);
      a.movq(value, x86::rax);
    }
    a.jmp(done);
  });
}

namespace {
constexpr std::uint32_t kCopies[] = {reg::kSi, reg::kDi};
}

bool Assembly::keeps(std::span<const std::uint32_t> written) const {
  return written.size() <= std::size(kCopies) &&
         std::all_of(written.begin(), written.end(),
                     [this](std::uint32_t operand) { return kept(operand).has_value(); });
}
void Assembly::begin_both_branches(std::span<const std::uint32_t> written) {
  auto copies = std::make_shared<Kept>(*kept_);
  forget();
  forget_rows();  // copies lie where they do
  for (std::size_t n = 0; n < written.size(); ++n) {
    a.mov(gp(kCopies[n], 8), gp(*kept(written[n]), 8));
    for (Kept::Variable& variable : copies->variables) {
      if (variable.what.operand == written[n]) variable.reg = kCopies[n];
    }
  }
  written_.assign(written.begin(), written.end());
  other_ = std::exchange(kept_, std::move(copies));
}
void Assembly::other_branch() {
  forget();
  std::swap(kept_, other_);
}
void Assembly::end_both_branches(std::uint32_t condition, bool value) {
  forget();
  if (const auto number = kept(condition)) {
    a.test(gp(*number, 1), gp(*number, 1));
  } else {
    a.cmp(at(condition, 1), 0);
  }
  std::swap(kept_, other_);
  std::vector<std::uint32_t> copies;
  for (const std::uint32_t operand : written_) copies.push_back(*kept(operand));
  std::swap(kept_, other_);
  for (std::size_t n = 0; n < copies.size(); ++n) {
    a.emit(value ? x86::Inst::kIdCmovnz : x86::Inst::kIdCmovz, gp(*kept(written_[n]), 8), gp(copies[n], 8));
  }
  other_.reset();
}

}  // namespace plc::native
