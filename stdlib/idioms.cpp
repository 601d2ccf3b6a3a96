#include "stdlib/idioms.h"

#include <algorithm>

namespace plc::stdlib {
namespace {

using enum TypeId;

unsigned bytes_of(TypeId id) { return core::rep_bytes(core::rep_of(id)); }
bool is_int(TypeId id) { return core::in_category(id, core::kAnyInt); }
bool is_signed(TypeId id) { return core::in_category(id, core::kAnySigned); }
bool is_bits(TypeId id) { return core::in_category(id, core::kAnyBit) && id != kBool; }
bool is_whole(TypeId id) { return is_int(id) || is_bits(id); }
bool is_real(TypeId id) { return core::in_category(id, core::kAnyReal); }

TypeId of_size(unsigned bytes, TypeId one, TypeId two, TypeId four, TypeId eight) {
  return bytes <= 1 ? one : bytes == 2 ? two : bytes == 4 ? four : eight;
}
TypeId bits_of_size(unsigned bytes) { return of_size(bytes, kByte, kWord, kDword, kLword); }
TypeId unsigned_of_size(unsigned bytes) { return of_size(bytes, kUsint, kUint, kUdint, kUlint); }
TypeId signed_of_size(unsigned bytes) { return of_size(bytes, kSint, kInt, kDint, kLint); }

/// Bytes that hold an integer literal: its value, or as bits.
unsigned literal_size(const Arg& literal) {
  for (const unsigned bytes : {1u, 2u, 4u}) {
    if (literal_fits(literal, unsigned_of_size(bytes)) || literal_fits(literal, signed_of_size(bytes))) return bytes;
  }
  return 8;
}
bool is_negative(const Arg& literal) { return !literal.int_is_unsigned && literal.int_value < 0; }

/// What the arguments of one type variable have in common.
struct Group {
  unsigned typed_size = 0;    ///< bytes of the largest integer or bit string
  unsigned made_size = 0;     ///< the same of the types in which they were computed
  unsigned literal_size = 0;  ///< bytes of the largest integer literal
  bool has_typed = false;     ///< an integer, bit string or BOOL
  bool has_signed = false;    ///< by type, or by a literal below 0
  bool made_signed = false;   ///< computed in a signed type
  bool all_bits = true;
  bool has_bool = false;
  bool has_real = false;
  bool has_long_real = false;
  bool real_literal = false;
  bool has_other = false;  ///< of no number

  void add(const LooseArg& one) {
    switch (one.arg.kind) {
      case Arg::Kind::kUnconnected:
        return;
      case Arg::Kind::kRealLiteral:
        real_literal = true;
        return;
      case Arg::Kind::kIntLiteral:
        literal_size = std::max(literal_size, stdlib::literal_size(one.arg));
        has_signed = has_signed || is_negative(one.arg);
        return;
      case Arg::Kind::kTyped:
        break;
    }
    const TypeId id = one.narrow;
    if (is_real(id)) {
      has_real = true;
      has_long_real = has_long_real || id == kLreal;
    } else if (is_whole(id) || id == kBool) {
      has_typed = true;
      has_bool = has_bool || id == kBool;
      typed_size = std::max(typed_size, bytes_of(id));
      all_bits = all_bits && is_bits(id);
      has_signed = has_signed || is_signed(id);
      made_size = std::max(made_size, bytes_of(one.arg.type));
      made_signed = made_signed || is_signed(one.arg.type);
    } else {
      has_other = true;
    }
  }
  [[nodiscard]] unsigned size() const { return std::max(typed_size, literal_size); }
  [[nodiscard]] bool real() const { return has_real || real_literal; }

  /// What the result of computing with them stands for.
  [[nodiscard]] TypeId narrow() const {
    if (real()) return has_long_real ? kLreal : kReal;
    if (all_bits && has_typed) return bits_of_size(size());
    return has_signed ? signed_of_size(size()) : unsigned_of_size(size());
  }
  /// The type in which integers are computed: LINT, which holds every result of 8 and 16 bits and its sign; where all
  /// are without sign and one has 32 or 64 bits, these wrap.
  [[nodiscard]] TypeId whole_type() const {
    if (has_signed || made_signed || typed_size < 4) return kLint;
    if (typed_size == 4) return literal_size <= 4 ? kUdint : kLint;
    return kUlint;
  }
  [[nodiscard]] TypeId real_type() const { return has_long_real || size() >= 4 ? kLreal : kReal; }
};

bool may_become(TypeId from, TypeId to) {
  return from == to || widens(from, to) || implicit_conversion(from, to) != Idiom::kNone;
}

/// One row of a name and what is given to it.
class Attempt {
 public:
  Attempt(std::string_view name, std::span<const Overload> rows, std::span<const LooseArg> args,
          std::optional<TypeId> expected)
      : name_(name), rows_(rows), spec_(*rows.front().spec), args_(args), expected_(expected) {}

  std::optional<LooseCall> make() {
    const bool count_fits = spec_.extensible ? args_.size() >= spec_.param_count && args_.size() <= kMaxArguments
                                             : args_.size() == spec_.param_count;
    if (!count_fits || spec_.param_count == 0) return std::nullopt;
    for (std::size_t i = 0; i < args_.size(); ++i) {
      changed_.push_back(args_[i].arg);
      if (kind_of(i) == ParamType::Kind::kT) group_.add(args_[i]);
    }
    if (!choose_t() || !choose_others()) return std::nullopt;
    const Resolution found = resolve(name_, changed_, expected_);
    if (found.status != Resolution::Status::kFound || found.overload->spec != &spec_) return std::nullopt;
    LooseCall call;
    call.overload = found.overload;
    call.narrow = call.result = found.overload->result_type();
    if (spec_.result.kind == ParamType::Kind::kT && t_) {
      call.narrow = narrow_;
      if (only_bits()) call.result = wide_ ? kLint : narrow_;
      call.keeps_sign = spec_.name == "SHR" && is_signed(call.result);
    }
    find_idiom(call);
    return call;
  }

 private:
  [[nodiscard]] ParamType::Kind kind_of(std::size_t i) const {
    return spec_.params[std::min<std::size_t>(i, spec_.param_count - 1u)].type.kind;
  }
  [[nodiscard]] bool has_t(TypeId id) const {
    return std::any_of(rows_.begin(), rows_.end(), [id](const Overload& o) { return o.t == id; });
  }
  [[nodiscard]] bool has_u(TypeId id) const {
    return std::any_of(rows_.begin(), rows_.end(), [id](const Overload& o) { return o.u == id; });
  }
  template <class Is>
  [[nodiscard]] bool any_t(Is is) const {
    return std::any_of(rows_.begin(), rows_.end(), [is](const Overload& o) { return is(o.t); });
  }
  [[nodiscard]] bool only_bits() const { return any_t(is_bits) && !any_t(is_int); }
  [[nodiscard]] bool only_reals() const { return any_t(is_real) && !any_t(is_int); }

  /// The type variable T, of which most rows have one. False when nothing fits.
  bool choose_t() {
    if (spec_.t_categories == 0 || group_.has_other || !(group_.has_typed || group_.has_real)) return true;
    if (agreed()) return true;
    TypeId t = group_.whole_type();
    narrow_ = group_.narrow();
    if (group_.real() || only_reals()) {
      t = group_.real_type();
      if (!group_.real()) narrow_ = group_.size() <= 4 ? kReal : kLreal;
    } else if (only_bits()) {
      if (group_.has_bool) return false;  // a condition beside a number: a mistake
      // What was computed in more bits keeps them until it is stored; a rotation is one of as many bits as meant.
      wide_ = group_.made_signed && group_.made_size > group_.size() && spec_.name != "ROL" && spec_.name != "ROR";
      t = bits_of_size(wide_ ? 8 : group_.size());
    }
    // A typed name (ADD_INT), or a conversion from one type.
    if (!has_t(t)) {
      t = narrow_ = rows_.front().t;
      wide_ = false;
      if (any_t([t](TypeId id) { return id != t; })) return false;
    }
    for (std::size_t i = 0; i < args_.size(); ++i) {
      if (kind_of(i) != ParamType::Kind::kT) continue;
      const Arg& arg = args_[i].arg;
      bool fits = true;
      if (arg.kind == Arg::Kind::kTyped) {
        fits = arg.type == t || may_become(args_[i].narrow, t);
      } else if (arg.kind == Arg::Kind::kIntLiteral) {
        fits = literal_fits(arg, t) || literal_fits_by_bits(arg, t);
      } else if (arg.kind == Arg::Kind::kRealLiteral) {
        fits = is_real(t);
      }
      if (!fits) return false;
      changed_[i] = {Arg::Kind::kTyped, t};
    }
    t_ = t;
    return true;
  }

  /// All arguments of T have one type of the row already: something else does not fit.
  bool agreed() {
    std::optional<TypeId> one;
    for (std::size_t i = 0; i < args_.size(); ++i) {
      if (kind_of(i) != ParamType::Kind::kT || args_[i].arg.kind != Arg::Kind::kTyped) continue;
      if (args_[i].narrow != args_[i].arg.type || (one && *one != args_[i].narrow)) return false;
      one = args_[i].narrow;
    }
    if (!one || !has_t(*one)) return false;
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const Arg& arg = args_[i].arg;
      if (kind_of(i) != ParamType::Kind::kT) continue;
      if (arg.kind == Arg::Kind::kIntLiteral && !literal_fits(arg, *one)) return false;
      if (arg.kind == Arg::Kind::kRealLiteral && !is_real(*one)) return false;
    }
    t_ = narrow_ = *one;
    return true;
  }

  /// Arguments of the type variable U, and those of one type.
  bool choose_others() {
    for (std::size_t i = 0; i < args_.size(); ++i) {
      Arg& arg = changed_[i];
      if (kind_of(i) == ParamType::Kind::kT || arg.kind != Arg::Kind::kTyped) continue;
      if (kind_of(i) == ParamType::Kind::kU) {
        if (!has_u(arg.type) && is_bits(arg.type)) arg.type = unsigned_of(arg.type);
        continue;
      }
      const TypeId wanted = spec_.params[std::min<std::size_t>(i, spec_.param_count - 1u)].type.fixed;
      if (arg.type != wanted && !widens(arg.type, wanted)) {
        if (!may_become(args_[i].narrow, wanted)) return false;
        arg.type = wanted;
      }
    }
    return true;
  }

  [[nodiscard]] Idiom idiom_of(std::size_t i) const {
    const TypeId id = args_[i].narrow;
    if (kind_of(i) == ParamType::Kind::kFixed) {
      const TypeId wanted = spec_.params[std::min<std::size_t>(i, spec_.param_count - 1u)].type.fixed;
      return id == wanted || widens(id, wanted) ? Idiom::kNone : implicit_conversion(id, wanted);
    }
    if (kind_of(i) == ParamType::Kind::kU) {
      if (!is_bits(id) || has_u(id)) return Idiom::kNone;
      return only_bits() ? Idiom::kShiftCount : Idiom::kMixedBits;
    }
    if (!t_ || id == *t_ || widens(id, *t_)) return Idiom::kNone;
    if (id == kBool) return Idiom::kBoolNumber;
    if (only_bits()) return is_int(id) ? Idiom::kIntegerBits : Idiom::kNone;
    if (is_bits(id) && !has_t(id) && !only_reals()) return Idiom::kBitArithmetic;
    if (is_bits(id) && (!group_.all_bits || group_.real() || only_reals())) return Idiom::kMixedBits;
    if (is_bits(id)) return group_.has_signed ? Idiom::kMixedSigns : Idiom::kNone;  // beside a literal below 0
    return is_int(id) ? (is_real(*t_) ? Idiom::kIntoReal : Idiom::kMixedSigns) : Idiom::kNone;
  }

  void find_idiom(LooseCall& call) const {
    // Signs mix wherever anything does: what else there is says more.
    for (const bool signs : {false, true}) {
      for (std::size_t i = 0; i < args_.size() && call.idiom == Idiom::kNone; ++i) {
        if (args_[i].noted || args_[i].arg.kind != Arg::Kind::kTyped) continue;
        const Idiom idiom = idiom_of(i);
        const bool is_sign = idiom == Idiom::kMixedSigns || idiom == Idiom::kIntoReal;
        if (idiom == Idiom::kNone || is_sign != signs) continue;
        call.idiom = idiom;
        call.because = i;
      }
    }
  }

  std::string_view name_;
  std::span<const Overload> rows_;
  const FunctionSpec& spec_;
  std::span<const LooseArg> args_;
  std::optional<TypeId> expected_;
  std::vector<Arg> changed_;
  Group group_;
  std::optional<TypeId> t_;
  TypeId narrow_ = kBool;
  bool wide_ = false;
};

}  // namespace

TypeId unsigned_of(TypeId id) { return unsigned_of_size(bytes_of(id)); }

Idiom implicit_conversion(TypeId from, TypeId to) {
  if (from == to) return Idiom::kNone;
  if (from == kBool) return is_int(to) || is_real(to) ? Idiom::kBoolNumber : Idiom::kNone;
  if (!is_whole(from)) return Idiom::kNone;
  if (is_real(to)) return is_bits(from) ? Idiom::kMixedBits : Idiom::kIntoReal;
  if (!is_whole(to) || bytes_of(from) > bytes_of(to)) return Idiom::kNone;
  return is_bits(from) != is_bits(to) ? Idiom::kMixedBits : Idiom::kMixedSigns;
}

bool literal_fits_by_bits(const Arg& literal, TypeId to) {
  if (literal.kind != Arg::Kind::kIntLiteral || !is_whole(to) || literal_fits(literal, to)) return false;
  if (!literal.based && !is_negative(literal)) return false;
  const unsigned bytes = bytes_of(to);
  return literal_fits(literal, unsigned_of_size(bytes)) || literal_fits(literal, signed_of_size(bytes));
}

std::optional<LooseCall> resolve_loosely(std::string_view name, std::span<const LooseArg> args,
                                         std::optional<TypeId> expected) {
  const auto rows = overloads_named(name);
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first;
    while (end < rows.size() && rows[end].spec == rows[first].spec) ++end;
    if (auto call = Attempt(name, rows.subspan(first, end - first), args, expected).make()) return call;
    first = end;
  }
  return std::nullopt;
}

TypeId narrow_result(const Overload& overload, std::span<const LooseArg> args) {
  const FunctionSpec& spec = *overload.spec;
  const TypeId result = overload.result_type();
  if (spec.result.kind != ParamType::Kind::kT || !(is_int(result) || is_real(result))) return result;
  Group group;
  for (std::size_t i = 0; i < args.size(); ++i) {
    if (spec.params[std::min<std::size_t>(i, spec.param_count - 1u)].type.kind == ParamType::Kind::kT)
      group.add(args[i]);
  }
  if (group.has_other || group.has_bool || !(group.has_typed || group.has_real)) return result;
  if (is_real(result)) {
    const bool is_long = group.real() ? group.has_long_real : group.size() > 4;
    return is_long ? result : kReal;
  }
  return bytes_of(group.narrow()) < bytes_of(result) ? group.narrow() : result;
}

}  // namespace plc::stdlib
