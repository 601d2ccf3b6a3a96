// Literals take types, values are widened, constants folded; what the third edition does not widen and other tools do
// is converted with a note. Rules: IEC 61131-3:2013, 6.3.2 (literals), figure 12 (implicit widening), stdlib/idioms.h;
// what a mismatch is called: P41xx.
#include "ir/convert.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <utility>

#include "ir/pointers.h"
#include "stdlib/arithmetic.h"

namespace plc::ir {

using core::Code;
using stdlib::Idiom;
using stdlib::Overload;

namespace {

std::uint64_t mask_of_width(std::uint32_t bytes) { return bytes >= 8 ? ~0ull : (1ull << (bytes * 8)) - 1; }

double real_of_int(const Operand& operand) {
  return operand.int_is_unsigned ? static_cast<double>(static_cast<std::uint64_t>(operand.int_value))
                                 : static_cast<double>(operand.int_value);
}

/// The bits of a number as elementary type `id` (integers truncated to the width; the caller checked the range).
std::uint64_t literal_bits(const Operand& operand, TypeId id) {
  const Rep rep = core::rep_of(id);
  const double real = operand.kind == Operand::Kind::kRealLiteral ? operand.real_value : real_of_int(operand);
  if (rep == Rep::kF32) return std::bit_cast<std::uint32_t>(static_cast<float>(real));
  if (rep == Rep::kF64) return std::bit_cast<std::uint64_t>(real);
  return static_cast<std::uint64_t>(operand.int_value) & mask_of_width(core::rep_bytes(rep));
}

bool is_unsigned(Rep rep) {
  return rep == Rep::kBool || rep == Rep::kU8 || rep == Rep::kU16 || rep == Rep::kU32 || rep == Rep::kU64;
}

/// An integer constant's value, sign-extended from its representation.
std::int64_t integer_value(std::uint64_t bits, Rep rep) {
  const std::uint32_t bytes = core::rep_bytes(rep);
  if (is_unsigned(rep) || bytes == 8) return static_cast<std::int64_t>(bits);
  const unsigned shift = 64 - bytes * 8;
  return static_cast<std::int64_t>(bits << shift) >> shift;
}

const Constant* constant_of(Builder& builder, ValueId value) {
  const Inst& inst = builder.body().insts[value.index];
  return inst.op == Op::kConst ? &builder.body().constants[inst.a] : nullptr;
}

bool is_scalar(Rep rep) { return rep != Rep::kStr && rep != Rep::kWstr && rep != Rep::kRef; }

/// The bits of a NaN that is not the canonical one: a REAL whose bytes were reversed may be one.
bool is_foreign_nan(std::uint64_t bits, Rep rep) {
  if (rep == Rep::kF32) {
    const auto real = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    return std::isnan(real) &&
           std::bit_cast<std::uint32_t>(stdlib::canonical(real)) != static_cast<std::uint32_t>(bits);
  }
  if (rep != Rep::kF64) return false;
  const auto real = std::bit_cast<double>(bits);
  return std::isnan(real) && std::bit_cast<std::uint64_t>(stdlib::canonical(real)) != bits;
}

/// Runs the kernel on constants. Nothing when an argument is not constant, a string is involved, an event happens (an
/// event has to be counted where the program runs), or the result is none that images hold as a constant.
std::optional<Constant> fold(Builder& builder, const Overload& overload, std::span<const ValueId> args,
                             TypeRef result_type) {
  if (!overload.spec->foldable || overload.kernel == nullptr) return std::nullopt;
  if (!is_scalar(core::rep_of(overload.result_type()))) return std::nullopt;
  for (std::size_t i = 0; i < args.size(); ++i) {
    if (constant_of(builder, args[i]) == nullptr || !is_scalar(core::rep_of(overload.param_type(i))))
      return std::nullopt;
  }
  std::vector<std::uint64_t> values(args.size());
  std::vector<const void*> pointers(args.size());
  for (std::size_t i = 0; i < args.size(); ++i) {
    // Little-endian: the low bytes of the 64-bit image are the value of any narrower representation.
    values[i] = constant_of(builder, args[i])->bits;
    pointers[i] = &values[i];
  }
  static_assert(std::endian::native == std::endian::little, "constants are kept little-endian");
  alignas(8) std::uint64_t result = 0;
  const stdlib::Event event = overload.kernel(&result, pointers.data(), static_cast<std::uint32_t>(args.size()));
  if (event != stdlib::Event::kNone) return std::nullopt;
  const Rep rep = core::rep_of(overload.result_type());
  if (is_foreign_nan(result, rep)) return std::nullopt;
  Constant folded;
  folded.type = result_type;
  folded.bits = result & mask_of_width(core::rep_bytes(rep));
  return folded;
}

bool in_limits(const Type& subrange, std::int64_t value) {
  if (is_unsigned(core::rep_of(subrange.elementary))) {
    return static_cast<std::uint64_t>(value) >= static_cast<std::uint64_t>(subrange.lower) &&
           static_cast<std::uint64_t>(value) <= static_cast<std::uint64_t>(subrange.upper);
  }
  return value >= subrange.lower && value <= subrange.upper;
}

}  // namespace

std::string text_of(const Operand& operand) {
  if (!operand.text.empty()) return operand.text;
  if (operand.kind == Operand::Kind::kRealLiteral) return fmt::format("{}", operand.real_value);
  if (operand.int_is_unsigned) return fmt::format("{}", static_cast<std::uint64_t>(operand.int_value));
  return fmt::format("{}", operand.int_value);
}

bool is_literal_text(const Operand& operand) {
  return operand.text.size() > 1 && (operand.text.front() == '"' || operand.text.front() == '\'') &&
         operand.text.back() == operand.text.front();
}

std::string quotes_help(const Operand& operand) {
  const std::string inner = operand.text.substr(1, operand.text.size() - 2);
  return operand.text.front() == '"'
             ? fmt::format("{} is a WSTRING; a STRING is written in single quotes: '{}'", operand.text, inner)
             : fmt::format("{} is a STRING; a WSTRING is written in double quotes: \"{}\"", operand.text, inner);
}

stdlib::Arg literal_arg(const Operand& operand) {
  stdlib::Arg arg;
  arg.kind = stdlib::Arg::Kind::kIntLiteral;
  arg.int_value = operand.int_value;
  arg.int_is_unsigned = operand.int_is_unsigned;
  arg.based = operand.text.find('#') != std::string::npos;
  return arg;
}

ValueId call_or_fold(Builder& builder, const Overload& overload, std::span<const ValueId> args, TypeRef result_type) {
  if (const auto constant = fold(builder, overload, args, result_type)) return builder.constant(*constant);
  return builder.call_overload(overload, args, result_type);
}

const Overload* conversion(TypeId from, TypeId to) {
  for (const Overload& o : stdlib::overloads_named(fmt::format("{}_TO_{}", core::name_of(from), core::name_of(to)))) {
    if (o.spec->param_count == 1 && o.param_type(0) == from && o.result_type() == to) return &o;
  }
  return nullptr;
}

core::Code code_of(Idiom idiom) {
  switch (idiom) {
    case Idiom::kBitArithmetic:
      return Code::P4330;
    case Idiom::kIntegerBits:
      return Code::P4331;
    case Idiom::kMixedSigns:
      return Code::P4332;
    case Idiom::kMixedBits:
      return Code::P4333;
    case Idiom::kBoolNumber:
      return Code::P4334;
    case Idiom::kLiteralBits:
      return Code::P4335;
    case Idiom::kIntegerPower:
      return Code::P4336;
    case Idiom::kIntoReal:
      return Code::P4337;
    case Idiom::kShiftCount:
      return Code::P4338;
    case Idiom::kNone:
      break;
  }
  return Code::P9001;
}

namespace {

class Converter {
 public:
  Converter(Builder& builder, const What& what) : builder_(builder), what_(what) {}

  std::optional<ValueId> convert(const Operand& operand, TypeRef to) {
    if (operand.kind == Operand::Kind::kUnconnected) {
      builder_.report(Code::P4106, operand.at, fmt::format("{} is not connected", what_()),
                      "wire it or give it a value");
      return std::nullopt;
    }
    const Type target = types()[to];
    if (target.kind == TypeKind::kPointer || is_pointer(builder_, operand)) {
      if (operand.kind == Operand::Kind::kValue && builder_.type_of(operand.value) == to) return operand.value;
      return convert_pointer(builder_, operand, to, what_);
    }
    const auto id = types().elementary_of(to);
    if (operand.kind != Operand::Kind::kValue)
      return id ? literal(operand, to, target, *id) : literal_misfit(operand, to);
    const TypeRef from = builder_.type_of(operand.value);
    if (from == to) return operand.value;
    const auto from_id = types().elementary_of(from);
    if (!id || !from_id || target.kind == TypeKind::kEnum) return misfit(operand, from, to);
    ValueId value = operand.value;
    if (*from_id != *id) {
      const TypeRef base = target.kind == TypeKind::kSubrange ? ref_of(*id) : to;
      auto made = widen(operand, *from_id, *id, base);
      if (!made) made = convert_loosely(operand, from, *from_id, *id, base, to);
      if (!made) return misfit(operand, from, to);
      value = *made;
    }
    return target.kind == TypeKind::kSubrange ? limit(operand, value, to, target) : value;
  }

 private:
  TypeTable& types() { return builder_.module().types; }

  std::optional<ValueId> misfit(const Operand& operand, TypeRef from, TypeRef to) {
    // BYTE + WORD is a WORD for who wrote it.
    if (const Builder::Narrow* const narrow = builder_.narrow_of(operand.value)) from = ref_of(narrow->type);
    const auto from_id = types().elementary_of(from);
    const auto id = types().elementary_of(to);
    std::string help;
    if (from_id && id && types()[to].kind != TypeKind::kEnum && conversion(*from_id, *id) != nullptr) {
      help = fmt::format("convert with {}_TO_{}", core::name_of(*from_id), core::name_of(*id));
    } else if (types()[to].kind == TypeKind::kEnum) {
      help = fmt::format("use a value of the enumeration {}", types().name_of(to));
    }
    if (id && core::in_category(*id, core::kAnyString) && is_literal_text(operand)) help = quotes_help(operand);
    const std::string given = operand.text.empty() ? "a value" : '"' + operand.text + '"';
    builder_.report(Code::P4101, operand.at,
                    fmt::format("{} needs {}, {} is {}", what_(), types().name_of(to), given, types().name_of(from)),
                    std::move(help));
    return std::nullopt;
  }

  std::optional<ValueId> literal_misfit(const Operand& operand, TypeRef to) {
    const auto id = types().elementary_of(to);
    std::string help;
    if (types()[to].kind == TypeKind::kEnum) {
      help = fmt::format("use a value of the enumeration {}", types().name_of(to));
    } else if (id && core::in_category(*id, core::kAnyDuration)) {
      help = fmt::format("write a duration: {}", operand.kind == Operand::Kind::kIntLiteral
                                                     ? fmt::format("T#{}ms", text_of(operand))
                                                     : std::string("T#1.5s"));
    } else if (operand.kind == Operand::Kind::kRealLiteral && id && core::in_category(*id, core::kAnyInt)) {
      help = fmt::format("write an integer, or convert with REAL_TO_{}", core::name_of(*id));
    } else if (id && operand.kind == Operand::Kind::kIntLiteral && core::in_category(*id, core::kAnySigned)) {
      stdlib::Arg as_bits = literal_arg(operand);
      as_bits.based = true;
      if (stdlib::literal_fits_by_bits(as_bits, *id)) {
        help = fmt::format("write 16#{:X} where its bits are meant", static_cast<std::uint64_t>(operand.int_value));
      }
    }
    builder_.report(Code::P4107, operand.at,
                    fmt::format("{} needs {}, literal {} is none", what_(), types().name_of(to), text_of(operand)),
                    std::move(help));
    return std::nullopt;
  }

  std::optional<ValueId> literal(const Operand& operand, TypeRef to, const Type& target, TypeId id) {
    if (target.kind == TypeKind::kEnum) return literal_misfit(operand, to);
    if (operand.kind == Operand::Kind::kRealLiteral) {
      if (!core::in_category(id, core::kAnyReal)) return literal_misfit(operand, to);
    } else if (!core::in_category(id, core::kAnyReal) && !stdlib::literal_fits(literal_arg(operand), id)) {
      if (!stdlib::literal_fits_by_bits(literal_arg(operand), id)) return literal_misfit(operand, to);
      note_bits(operand, to, id);
    }
    Constant constant;
    constant.type = to;
    constant.bits = literal_bits(operand, id);
    const double real = operand.kind == Operand::Kind::kRealLiteral ? operand.real_value : 0;
    if (core::rep_of(id) == Rep::kF32 && std::isinf(static_cast<float>(real)) && !std::isinf(real)) {
      return literal_misfit(operand, to);
    }
    if (target.kind == TypeKind::kSubrange && !in_limits(target, integer_value(constant.bits, core::rep_of(id)))) {
      return outside(operand, to, target);
    }
    return builder_.constant(constant);
  }

  std::optional<ValueId> widen(const Operand& operand, TypeId from, TypeId to, TypeRef result) {
    if (!stdlib::widens(from, to)) return std::nullopt;
    const Overload* overload = conversion(from, to);
    if (overload == nullptr) return std::nullopt;
    const ValueId arg = operand.value;
    return call_or_fold(builder_, *overload, std::span(&arg, 1), result);
  }

  /// What other tools convert without being told: with a note, where none was given for the value yet.
  std::optional<ValueId> convert_loosely(const Operand& operand, TypeRef from, TypeId from_id, TypeId id, TypeRef base,
                                         TypeRef to) {
    const Builder::Narrow* const known = builder_.narrow_of(operand.value);
    const TypeId narrow = known != nullptr ? known->type : from_id;
    Idiom idiom = stdlib::implicit_conversion(narrow, id);
    if (known != nullptr) {
      if (idiom == Idiom::kNone && narrow != id && !stdlib::widens(narrow, id)) return std::nullopt;
      idiom = known->noted ? Idiom::kNone : known->idiom;
    } else if (idiom == Idiom::kNone) {
      return std::nullopt;
    }
    const Overload* const overload = conversion(from_id, id);
    if (overload == nullptr) return std::nullopt;
    if (idiom != Idiom::kNone) {
      const std::string given = operand.text.empty() ? "a value" : '"' + operand.text + '"';
      builder_.report(
          code_of(idiom), operand.at,
          fmt::format("{} of type {} takes {} of type {}", what_(), types().name_of(to), given, types().name_of(from)),
          fmt::format("{}_TO_{} says so everywhere", core::name_of(from_id), core::name_of(id)));
    }
    const ValueId arg = operand.value;
    return call_or_fold(builder_, *overload, std::span(&arg, 1), base);
  }

  void note_bits(const Operand& operand, TypeRef to, TypeId id) {
    const Rep rep = core::rep_of(id);
    const std::uint64_t bits = literal_bits(operand, id);
    const std::string value = is_unsigned(rep) ? fmt::format("{}", bits) : fmt::format("{}", integer_value(bits, rep));
    builder_.report(Code::P4335, operand.at,
                    fmt::format("{} of type {} takes the bits of literal {}, which are {}", what_(),
                                types().name_of(to), text_of(operand), value),
                    "write " + value);
  }

  std::optional<ValueId> outside(const Operand& operand, TypeRef to, const Type& target) {
    builder_.report(
        Code::P4108, operand.at,
        fmt::format("{} takes {}..{}, {} is outside", what_(), target.lower, target.upper, text_of(operand)),
        fmt::format("give a value of {}", types().name_of(to)));
    return std::nullopt;
  }

  /// Constants outside a subrange are errors; other values are held inside at run time, with an event.
  std::optional<ValueId> limit(const Operand& operand, ValueId value, TypeRef to, const Type& target) {
    if (const Constant* known = constant_of(builder_, value)) {
      Constant constant = *known;
      if (!in_limits(target, integer_value(constant.bits, core::rep_of(target.elementary)))) {
        return outside(operand, to, target);
      }
      constant.type = to;
      return builder_.constant(constant);
    }
    return builder_.range(value, to);
  }

  Builder& builder_;
  const What& what_;
};

}  // namespace

std::optional<ValueId> convert_with(Builder& builder, const Operand& operand, TypeRef to, const What& what) {
  return Converter(builder, what).convert(operand, to);
}

std::optional<ValueId> Builder::settle(const Operand& operand, std::optional<TypeRef> expected) {
  const What what = [] { return std::string("this place"); };
  switch (operand.kind) {
    case Operand::Kind::kUnconnected:
      return std::nullopt;
    case Operand::Kind::kValue:
      return operand.value;
    case Operand::Kind::kRealLiteral: {
      const bool wanted = expected && module_.types[*expected].kind == TypeKind::kElementary &&
                          core::in_category(module_.types[*expected].elementary, core::kAnyReal);
      return convert_with(*this, operand, wanted ? *expected : ref_of(TypeId::kLreal), what);
    }
    case Operand::Kind::kIntLiteral:
      break;
  }
  const stdlib::Arg arg = literal_arg(operand);
  if (expected && module_.types[*expected].kind == TypeKind::kElementary &&
      stdlib::literal_fits(arg, module_.types[*expected].elementary)) {
    return convert_with(*this, operand, *expected, what);
  }
  for (const TypeId id : {TypeId::kDint, TypeId::kLint, TypeId::kUlint}) {
    if (stdlib::literal_fits(arg, id)) return convert_with(*this, operand, ref_of(id), what);
  }
  return convert_with(*this, operand, ref_of(TypeId::kDint), what);
}

}  // namespace plc::ir
