// Typed helpers of the builder: literals take types, values are widened, standard functions are found by name.
// Rules: IEC 61131-3:2013, 6.3.2 (literals), figure 12 (implicit widening); what a mismatch is called: P41xx.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "ir/builder.h"
#include "stdlib/arithmetic.h"

namespace plc::ir {
namespace {

using core::Code;
using stdlib::Overload;

std::uint64_t mask_of_width(std::uint32_t bytes) { return bytes >= 8 ? ~0ull : (1ull << (bytes * 8)) - 1; }

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

/// For a text where the other kind of text is wanted: the quotes tell them apart, other than in most languages.
std::string quotes_help(const Operand& operand) {
  const std::string inner = operand.text.substr(1, operand.text.size() - 2);
  return operand.text.front() == '"'
             ? fmt::format("{} is a WSTRING; a STRING stands in single quotes: '{}'", operand.text, inner)
             : fmt::format("{} is a STRING; a WSTRING stands in double quotes: \"{}\"", operand.text, inner);
}

stdlib::Arg literal_arg(const Operand& operand) {
  stdlib::Arg arg;
  arg.kind = stdlib::Arg::Kind::kIntLiteral;
  arg.int_value = operand.int_value;
  arg.int_is_unsigned = operand.int_is_unsigned;
  return arg;
}

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

bool in_limits(const Type& subrange, std::int64_t value) {
  if (is_unsigned(core::rep_of(subrange.elementary))) {
    return static_cast<std::uint64_t>(value) >= static_cast<std::uint64_t>(subrange.lower) &&
           static_cast<std::uint64_t>(value) <= static_cast<std::uint64_t>(subrange.upper);
  }
  return value >= subrange.lower && value <= subrange.upper;
}

/// Conversion with the receiver's name made only when a message needs it: every pin of every block passes here.
template <class What>
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
    const auto id = types().elementary_of(to);
    if (operand.kind != Operand::Kind::kValue)
      return id ? literal(operand, to, target, *id) : literal_misfit(operand, to);
    const TypeRef from = builder_.type_of(operand.value);
    if (from == to) return operand.value;
    const auto from_id = types().elementary_of(from);
    if (!id || !from_id || target.kind == TypeKind::kEnum) return misfit(operand, from, to);
    ValueId value = operand.value;
    if (*from_id != *id) {
      const auto widened = widen(operand, *from_id, *id, target.kind == TypeKind::kSubrange ? ref_of(*id) : to);
      if (!widened) return misfit(operand, from, to);
      value = *widened;
    }
    return target.kind == TypeKind::kSubrange ? limit(operand, value, to, target) : value;
  }

 private:
  TypeTable& types() { return builder_.module().types; }

  std::optional<ValueId> misfit(const Operand& operand, TypeRef from, TypeRef to) {
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
      return literal_misfit(operand, to);
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

template <class What>
std::optional<ValueId> convert_with(Builder& builder, const Operand& operand, TypeRef to, const What& what) {
  return Converter<What>(builder, what).convert(operand, to);
}

/// One call by name: arguments classified, overload resolved, problems named by pin.
class NamedCall {
 public:
  NamedCall(Builder& builder, std::string_view name, std::span<const Operand> args, const SourceRef& at,
            std::optional<TypeRef> expected, std::span<const std::string> pins)
      : builder_(builder), name_(core::uppered(name)), args_(args), at_(at), expected_(expected), pins_(pins) {}

  std::optional<ValueId> make() {
    if (const auto type = whole_type()) return choose(*type);
    if (!classify()) return std::nullopt;
    std::optional<TypeId> expected_id;
    if (expected_) expected_id = types().elementary_of(*expected_);
    const stdlib::Resolution found = stdlib::resolve(name_, known_, expected_id);
    if (found.status != stdlib::Resolution::Status::kFound) {
      explain(found);
      return std::nullopt;
    }
    const Overload& overload = *found.overload;
    std::vector<ValueId> values;
    values.reserve(args_.size());
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const auto value = argument(i, overload.param_type(i));
      if (!value) return std::nullopt;
      values.push_back(*value);
    }
    if (const auto logic = boolean(overload, values)) return logic;
    return call_or_fold(builder_, overload, values, result_type(overload, values));
  }

 private:
  TypeTable& types() { return builder_.module().types; }
  std::string quoted_pin(std::size_t i) const {
    if (i < pins_.size() && !pins_[i].empty()) return '"' + pins_[i] + '"';
    const auto named = stdlib::overloads_named(name_);
    return '"' + (named.empty() ? fmt::format("IN{}", i + 1) : stdlib::pin_name(*named.front().spec, i)) + '"';
  }
  std::string input(std::size_t i) const { return fmt::format("input {} of {}", quoted_pin(i), name_); }
  /// The first of the inputs that the result is one of.
  std::size_t first_choice() const { return name_ == "MOVE" ? 0 : 1; }
  /// The type of structures, arrays or references among what stands to choose: no row has them, and moving them is the
  /// same for all. Nothing when there are none.
  std::optional<TypeRef> whole_type() {
    if (name_ != "MOVE" && name_ != "SEL" && name_ != "MUX") return std::nullopt;
    for (std::size_t i = first_choice(); i < args_.size(); ++i) {
      if (args_[i].kind != Operand::Kind::kValue) continue;
      const TypeRef type = builder_.type_of(args_[i].value);
      if (!types().elementary_of(type)) return type;
    }
    return std::nullopt;
  }
  /// MOVE, SEL and MUX are of ANY (IEC 61131-3:2013, table 32).
  std::optional<ValueId> choose(TypeRef type) {
    const std::size_t first = first_choice();
    const stdlib::FunctionSpec& spec = *stdlib::overloads_named(name_).front().spec;
    if (spec.extensible ? args_.size() < spec.param_count : args_.size() != spec.param_count) {
      explain({stdlib::Resolution::Status::kWrongCount});
      return std::nullopt;
    }
    for (std::size_t i = first; i < args_.size(); ++i) {
      if (!builder_.convert(args_[i], type, input(i))) return std::nullopt;
    }
    if (types().holds_instance(type)) {
      builder_.report(
          Code::P4109, at_,
          fmt::format("{} has type {}, which holds a function block instance", input(first), types().name_of(type)),
          "assign its members, or pass the instance to a VAR_IN_OUT");
      return std::nullopt;
    }
    if (name_ == "MOVE") return args_[0].value;
    const PlaceId chosen = builder_.variable(builder_.hidden("chosen", type));
    builder_.store(chosen, args_[first].value);
    return name_ == "SEL" ? choose_by_condition(chosen) : choose_by_number(chosen);
  }
  std::optional<ValueId> choose_by_condition(PlaceId chosen) {
    const auto condition = builder_.convert(args_[0], kBoolType, input(0));
    if (!condition) return std::nullopt;
    const LabelId end = builder_.new_label();
    builder_.jump_if_not(*condition, end);
    builder_.store(chosen, args_[2].value);
    builder_.bind(end);
    return builder_.load(chosen);
  }
  /// The MUX of the numbers 0, 1, .. knows what a number outside does.
  std::optional<ValueId> choose_by_number(PlaceId chosen) {
    std::vector<Operand> numbers{args_[0]};
    for (std::size_t i = 1; i < args_.size(); ++i) numbers.push_back(number(i - 1));
    const auto index = builder_.call("MUX", numbers, at_, ref_of(TypeId::kDint));
    if (!index) return std::nullopt;
    for (std::size_t i = 2; i < args_.size(); ++i) {
      const std::array<Operand, 2> pair{Operand::of(*index, at_), number(i - 1)};
      const LabelId next = builder_.new_label();
      builder_.jump_if_not(*builder_.call("EQ", pair, at_), next);
      builder_.store(chosen, args_[i].value);
      builder_.bind(next);
    }
    return builder_.load(chosen);
  }
  Operand number(std::size_t value) const {
    Operand operand;
    operand.kind = Operand::Kind::kIntLiteral;
    operand.int_value = static_cast<std::int64_t>(value);
    operand.at = at_;
    return operand;
  }
  SourceRef place_of(std::size_t i) const { return args_[i].at.line != 0 ? args_[i].at : at_; }

  bool classify() {
    bool fine = true;
    if (stdlib::overloads_named(name_).empty()) {
      builder_.report(Code::P9001, at_, fmt::format("no front end looked for the function {}", name_));
      return false;
    }
    known_.reserve(args_.size());
    for (std::size_t i = 0; i < args_.size(); ++i) {
      stdlib::Arg arg;
      switch (args_[i].kind) {
        case Operand::Kind::kUnconnected:
          builder_.report(Code::P4106, place_of(i), fmt::format("{} is not connected", input(i)),
                          "wire it or give it a value");
          fine = false;
          break;
        case Operand::Kind::kIntLiteral:
          arg = literal_arg(args_[i]);
          break;
        case Operand::Kind::kRealLiteral:
          arg.kind = stdlib::Arg::Kind::kRealLiteral;
          break;
        case Operand::Kind::kValue: {
          const TypeRef type = builder_.type_of(args_[i].value);
          const auto id = types().elementary_of(type);
          if (id) {
            arg.type = *id;
            break;
          }
          builder_.report(Code::P4103, place_of(i), fmt::format("{} has type {}", input(i), types().name_of(type)),
                          types()[type].kind == TypeKind::kReference
                              ? "references are not computed with: use an array and an index, or read what it refers to: ^"
                              : "give it one element or member");
          fine = false;
          break;
        }
      }
      known_.push_back(arg);
    }
    return fine;
  }

  std::optional<ValueId> argument(std::size_t i, TypeId type) {
    const Operand& operand = args_[i];
    // Strings of any capacity are passed as they are.
    if (operand.kind == Operand::Kind::kValue && known_[i].type == type) return operand.value;
    return convert_with(builder_, operand, ref_of(type), [&] { return input(i); });
  }

  /// BOOL functions that look-up tables can hold.
  std::optional<ValueId> boolean(const Overload& overload, std::span<const ValueId> v) {
    if (v.empty()) return std::nullopt;
    const std::string_view function = overload.name;  // "AND" where AND_BOOL is called
    if (function == "MOVE" && v.size() == 1) return v[0];
    if (overload.spec->t_categories == 0 || overload.t != TypeId::kBool) return std::nullopt;
    if (function == "NOT") return builder_.not_(v[0]);
    const bool pair = v.size() == 2;
    if (function == "EQ" && pair) return builder_.not_(builder_.logic(Op::kXor, v[0], v[1]));
    if (function == "NE" && pair) return builder_.logic(Op::kXor, v[0], v[1]);
    if (function == "SEL" && v.size() == 3) {
      const ValueId low = builder_.logic(Op::kAnd, builder_.not_(v[0]), v[1]);
      return builder_.logic(Op::kOr, low, builder_.logic(Op::kAnd, v[0], v[2]));
    }
    Op op = Op::kAnd;
    if (function == "OR") {
      op = Op::kOr;
    } else if (function == "XOR") {
      op = Op::kXor;
    } else if (function != "AND") {
      return std::nullopt;
    }
    ValueId value = v[0];
    for (std::size_t i = 1; i < v.size(); ++i) value = builder_.logic(op, value, v[i]);
    return value;
  }

  TypeRef result_type(const Overload& overload, std::span<const ValueId> values) {
    const TypeId id = overload.result_type();
    if (id == TypeId::kString || id == TypeId::kWstring) {
      return types().string(id, result_capacity(overload, values));
    }
    // Choosing among values of one enumeration or subrange gives one of them.
    static constexpr std::array<std::string_view, 5> kChoices{"SEL", "MUX", "MIN", "MAX", "LIMIT"};
    if (overload.spec->result.kind == stdlib::ParamType::Kind::kT &&
        std::find(kChoices.begin(), kChoices.end(), overload.name) != kChoices.end()) {
      const TypeRef last = builder_.type_of(values.back());
      bool same = true;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t declared = std::min<std::size_t>(i, overload.spec->param_count - 1u);
        const bool chosen = overload.spec->params[declared].type.kind == stdlib::ParamType::Kind::kT;
        same = same && (!chosen || builder_.type_of(values[i]) == last);
      }
      if (same) return last;
    }
    return ref_of(id);
  }

  /// Large enough for what the arguments can hold: cutting belongs to the assignment that asks for less.
  std::uint16_t result_capacity(const Overload& overload, std::span<const ValueId> values) {
    const TypeId id = overload.result_type();
    const bool joins = overload.name == "CONCAT" || overload.name == "INSERT" || overload.name == "REPLACE";
    std::uint32_t sum = 0;
    std::uint32_t most = core::kDefaultStringCapacity;
    for (const ValueId value : values) {
      const Type& type = types()[builder_.type_of(value)];
      if (type.kind != TypeKind::kString || type.elementary != id) continue;
      sum += type.capacity;
      most = std::max<std::uint32_t>(most, type.capacity);
    }
    if (joins) most = std::max(most, sum);
    return static_cast<std::uint16_t>(std::min<std::uint32_t>(most, core::kMaxStringCapacity));
  }

  std::string type_text(std::size_t i) {
    const stdlib::Arg& arg = known_[i];
    if (arg.kind == stdlib::Arg::Kind::kIntLiteral) return "literal " + text_of(args_[i]);
    if (arg.kind == stdlib::Arg::Kind::kRealLiteral) return "literal " + text_of(args_[i]);
    return types().name_of(builder_.type_of(args_[i].value));
  }

  void explain(const stdlib::Resolution& found) {
    const stdlib::FunctionSpec& spec = *stdlib::overloads_named(name_).front().spec;
    switch (found.status) {
      case stdlib::Resolution::Status::kWrongCount: {
        std::string inputs;
        for (std::size_t i = 0; i < spec.param_count; ++i) inputs += (i ? ", " : "") + stdlib::pin_name(spec, i);
        builder_.report(
            Code::P4105, at_,
            fmt::format("{} takes {} input{} ({}{}), {} given", name_, spec.param_count,
                        spec.param_count == 1 ? "" : "s", inputs, spec.extensible ? ", .." : "", args_.size()));
        return;
      }
      case stdlib::Resolution::Status::kAmbiguous:
        builder_.report(Code::P9001, at_,
                        fmt::format("call of {} fits {} and {}", name_, stdlib::key_of(*found.overload),
                                    stdlib::key_of(*found.rival)),
                        "give each literal its type, for example INT#1");
        return;
      default:
        explain_mismatch();
    }
  }

  /// Names the first input that no overload takes, or else the one that differs from what the others agree on.
  void explain_mismatch() {
    const auto candidates = stdlib::overloads_named(name_);
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const bool taken = std::any_of(candidates.begin(), candidates.end(), [&](const Overload& o) {
        const TypeId want = o.param_type(i);
        if (known_[i].kind == stdlib::Arg::Kind::kTyped) return stdlib::widens(known_[i].type, want);
        if (known_[i].kind == stdlib::Arg::Kind::kRealLiteral) return core::in_category(want, core::kAnyReal);
        return stdlib::literal_fits(known_[i], want);
      });
      if (taken) continue;
      builder_.report(Code::P4103, place_of(i),
                      fmt::format("{} has type {}, which {} does not take", input(i), type_text(i), name_),
                      is_literal_text(args_[i]) ? quotes_help(args_[i]) : "candidates: " + candidate_list());
      return;
    }
    const std::optional<std::size_t> reference = commonest();
    std::size_t odd = args_.size();
    for (std::size_t i = 0; reference && i < args_.size() && odd == args_.size(); ++i) {
      if (!agrees(known_[i], known_[*reference].type)) odd = i;
    }
    if (odd == args_.size()) {
      builder_.report(Code::P4103, at_, fmt::format("{} does not take these inputs", name_),
                      "candidates: " + candidate_list());
      return;
    }
    std::string help = "candidates: " + candidate_list();
    if (is_literal_text(args_[odd])) {
      help = quotes_help(args_[odd]);
    } else if (known_[odd].kind == stdlib::Arg::Kind::kTyped &&
        conversion(known_[odd].type, known_[*reference].type) != nullptr) {
      help = fmt::format("convert it with {}_TO_{}", core::name_of(known_[odd].type),
                         core::name_of(known_[*reference].type));
    }
    const bool several = args_.size() > 2;
    builder_.report(
        Code::P4103, place_of(odd),
        fmt::format("{} has type {}, {} {}", input(odd), type_text(odd),
                    several ? std::string("other inputs are") : fmt::format("input {} is", quoted_pin(*reference)),
                    type_text(*reference)),
        std::move(help));
  }

  /// The first input whose type most inputs share.
  std::optional<std::size_t> commonest() const {
    std::optional<std::size_t> best;
    std::size_t most = 0;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (known_[i].kind != stdlib::Arg::Kind::kTyped) continue;
      const auto alike =
          static_cast<std::size_t>(std::count_if(known_.begin(), known_.end(), [&](const stdlib::Arg& o) {
            return o.kind == stdlib::Arg::Kind::kTyped && o.type == known_[i].type;
          }));
      if (alike > most) {
        most = alike;
        best = i;
      }
    }
    return best;
  }

  static bool agrees(const stdlib::Arg& arg, TypeId type) {
    if (arg.kind == stdlib::Arg::Kind::kTyped) return arg.type == type;
    if (arg.kind == stdlib::Arg::Kind::kRealLiteral) return core::in_category(type, core::kAnyReal);
    return stdlib::literal_fits(arg, type);
  }

  std::string candidate_list() const {
    constexpr std::size_t kShown = 6;
    std::string list;
    std::size_t shown = 0;
    const auto candidates = stdlib::overloads_named(name_);
    for (const Overload& o : candidates) {
      if (shown++ == kShown) return list + ", ..";
      list += (list.empty() ? "" : ", ") + name_ + "(";
      for (std::size_t i = 0; i < o.spec->param_count; ++i) {
        list += (i ? ", " : "") + std::string(core::name_of(o.param_type(i)));
      }
      list += ")";
    }
    return list;
  }

  Builder& builder_;
  std::string name_;
  std::span<const Operand> args_;
  const SourceRef& at_;
  std::optional<TypeRef> expected_;
  std::span<const std::string> pins_;
  std::vector<stdlib::Arg> known_;
};

}  // namespace

std::optional<ValueId> Builder::convert(const Operand& operand, TypeRef to, std::string_view what) {
  return convert_with(*this, operand, to, [&] { return what; });
}

bool Builder::assign(PlaceId place, const Operand& operand, std::string_view what) {
  const TypeRef type = type_of(place);
  if (!module_.types.rep_of(type)) {
    if (operand.kind != Operand::Kind::kValue || type_of(operand.value) != type) {
      const std::string given =
          operand.kind == Operand::Kind::kValue ? module_.types.name_of(type_of(operand.value)) : text_of(operand);
      report(Code::P4101, operand.at, fmt::format("{} needs {}, not {}", what, module_.types.name_of(type), given));
      return false;
    }
    // Instances hold time and edges of their own: a copy of one would be a second device.
    if (module_.types.holds_instance(type)) {
      report(Code::P4109, operand.at, fmt::format("{} holds a function block instance and cannot be assigned", what),
             "assign its members, or pass the instance to a VAR_IN_OUT");
      return false;
    }
    store(place, operand.value);
    return true;
  }
  const auto value = convert(takes_ltime(place) ? as_time(operand) : operand, type, what);
  if (!value) return false;
  store(place, *value);
  return true;
}

// TP, TON and TOF are overloaded for both durations (IEC 61131-3:2013, table 46). Both count nanoseconds.
bool Builder::takes_ltime(PlaceId place) {
  const Place& at = body().places[place.index];
  if (at.kind != Place::Kind::kField || at.type != ref_of(TypeId::kTime)) return false;
  const Type& parent = module_.types[type_of(at.parent)];
  return parent.kind == TypeKind::kBlock && parent.block->any_duration;
}

Operand Builder::as_time(const Operand& operand) {
  if (operand.kind != Operand::Kind::kValue || type_of(operand.value) != ref_of(TypeId::kLtime)) return operand;
  Operand out = operand;
  const Overload* const same = conversion(TypeId::kLtime, TypeId::kTime);
  out.value = call_or_fold(*this, *same, std::span(&operand.value, 1), ref_of(TypeId::kTime));
  return out;
}

bool Builder::assign_input(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what) {
  const Type& type = module_.types[type_of(instance)];
  const bool configures = type.kind == TypeKind::kPou && module_.pous[type.pou].taskblock != 0 &&
                          module_.pous[type.pou].variables[index].constant;
  return configures ? configure(instance, index, operand, what) : assign(field(instance, index), operand, what);
}

// The constant becomes part of the initial value of the variable that holds the instance.
bool Builder::configure(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what) {
  const TypeRef type = module_.pous[module_.types[type_of(instance)].pou].variables[index].type;
  const auto refuse = [&](std::string_view why, std::string_view help) {
    report(Code::P4110, operand.at, fmt::format("{} {}", what, why), std::string(help));
    return false;
  };
  std::vector<std::uint32_t> path = {index};
  PlaceId root = instance;
  for (; body().places[root.index].parent.valid(); root = body().places[root.index].parent) {
    const Place& step = body().places[root.index];
    if (step.kind != Place::Kind::kField && step.kind != Place::Kind::kElement) {
      return refuse("is a configuration port, and which instance is meant is not known before the program runs",
                    "call it by an index that is a constant");
    }
    path.insert(path.begin(), step.index);
  }
  const Place& place = body().places[root.index];
  Variable* variable = nullptr;
  if (place.kind == Place::Kind::kInstance) variable = &pou().variables[place.index];
  if (place.kind == Place::Kind::kGlobal) variable = &module_.globals[place.index].variable;
  if (variable == nullptr) {
    return refuse("is a configuration port, and the instance is the caller's",
                  "configure it where the instance is declared: initial values in brackets");
  }
  std::vector<InitItem> items;
  if (module_.types.rep_of(type)) {
    const auto value = convert(operand, type, what);
    if (!value) return false;
    const Inst& inst = body().insts[value->index];
    const Place* const from = inst.op == Op::kLoad ? &body().places[inst.a] : nullptr;
    if (inst.op == Op::kConst) {
      items.push_back({path, body().constants[inst.a]});
    } else if (from == nullptr) {
      return refuse("is a configuration port and takes a constant", "wire a constant, or a variable that is CONSTANT");
    }
  }
  if (items.empty()) {
    // A variable that is constant: its initial value.
    const Variable* source = nullptr;
    const std::uint32_t made = operand.kind == Operand::Kind::kValue ? operand.value.index : 0xffffffffu;
    if (made < body().insts.size() && body().insts[made].op == Op::kLoad) {
      const Place& from = body().places[body().insts[made].a];
      if (from.kind == Place::Kind::kInstance) source = &pou().variables[from.index];
      if (from.kind == Place::Kind::kGlobal) source = &module_.globals[from.index].variable;
    }
    if (source == nullptr || !source->constant || source->type != type) {
      return refuse("is a configuration port and takes a constant", "wire a constant, or a variable that is CONSTANT");
    }
    for (const InitItem& item : source->initial) {
      std::vector<std::uint32_t> to = path;
      to.insert(to.end(), item.path.begin(), item.path.end());
      items.push_back({std::move(to), item.value});
    }
  }
  for (InitItem& item : items) {
    const auto same = std::find_if(variable->initial.begin(), variable->initial.end(),
                                   [&](const InitItem& other) { return other.path == item.path; });
    if (same == variable->initial.end()) {
      variable->initial.push_back(std::move(item));
    } else {
      same->value = std::move(item.value);
    }
  }
  return true;
}

// s[p] is the one character that MID takes and REPLACE puts: what happens outside of the string is theirs.
ValueId Builder::character_of(ValueId string, ValueId position) {
  const TypeId text = module_.types[type_of(string)].elementary;
  const TypeId index = *module_.types.elementary_of(type_of(position));
  const TypeId character = text == TypeId::kWstring ? TypeId::kWchar : TypeId::kChar;
  const ValueId one = constant({ref_of(index), 1, {}});
  const Overload* const mid =
      stdlib::overload_with_key(fmt::format("MID:{},{}", core::name_of(text), core::name_of(index)));
  const ValueId taken = call_overload(*mid, std::array{string, one, position}, module_.types.string(text, 1));
  return call_overload(*conversion(text, character), std::array{taken}, ref_of(character));
}

ValueId Builder::with_character(ValueId string, ValueId character, ValueId position) {
  const TypeId text = module_.types[type_of(string)].elementary;
  const TypeId index = *module_.types.elementary_of(type_of(position));
  const ValueId one = constant({ref_of(index), 1, {}});
  const Overload* const put = conversion(*module_.types.elementary_of(type_of(character)), text);
  const ValueId piece = call_overload(*put, std::array{character}, module_.types.string(text, 1));
  const Overload* const replace =
      stdlib::overload_with_key(fmt::format("REPLACE:{},{}", core::name_of(text), core::name_of(index)));
  return call_overload(*replace, std::array{string, piece, one, position}, type_of(string));
}

std::optional<ValueId> Builder::call(std::string_view name, std::span<const Operand> args, const SourceRef& at,
                                     std::optional<TypeRef> expected, std::span<const std::string> pins) {
  return NamedCall(*this, name, args, at, expected, pins).make();
}

std::optional<ValueId> Builder::settle(const Operand& operand, std::optional<TypeRef> expected) {
  const auto what = [] { return std::string_view("this place"); };
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
