// Reals of the oracle: MPFR with the precision and the exponents of REAL or LREAL.
#include <cstdint>
#define MPFR_USE_INTMAX_T  // declares its functions of 64-bit integers
#include <mpfr.h>

#include <cmath>
#include <map>

#include "tests/library/oracle.h"

namespace plc::test {
namespace {

/// A number of MPFR; as precise as its type, or wide enough for any product of two arguments.
class Number {
 public:
  Number() { mpfr_init2(value_, 400); }
  explicit Number(TypeId type) { mpfr_init2(value_, type == TypeId::kReal ? 24 : 53); }
  explicit Number(const Value& real) : Number() { mpfr_set_d(value_, real_of(real), MPFR_RNDN); }
  explicit Number(Wide whole) : Number() {
    mpfr_set_sj(value_, static_cast<std::int64_t>(whole >> 32), MPFR_RNDN);
    mpfr_mul_2ui(value_, value_, 32, MPFR_RNDN);
    mpfr_add_ui(value_, value_, static_cast<unsigned long>(whole & 0xffff'ffff), MPFR_RNDN);
  }
  ~Number() { mpfr_clear(value_); }
  Number(const Number&) = delete;
  Number& operator=(const Number&) = delete;
  mpfr_ptr operator*() { return value_; }
  mpfr_srcptr operator*() const { return value_; }

 private:
  mpfr_t value_;
};

/// What `f(result, rounding)` computes, as the type has it: its precision, its exponents, its subnormals. Rounded once:
/// MPFR hands on in which direction it has rounded.
template <class F>
Value rounded(TypeId type, mpfr_rnd_t rounding, F f) {
  const bool is_short = type == TypeId::kReal;
  Number result(type);
  int inexact = f(*result, rounding);
  const mpfr_exp_t least = mpfr_get_emin(), greatest = mpfr_get_emax();
  mpfr_set_emin(is_short ? -148 : -1073);
  mpfr_set_emax(is_short ? 128 : 1024);
  inexact = mpfr_check_range(*result, inexact, rounding);
  mpfr_subnormalize(*result, inexact, rounding);
  mpfr_set_emin(least);
  mpfr_set_emax(greatest);
  return real_value(type, mpfr_get_d(*result, MPFR_RNDN));
}
template <class F>
Value nearest(TypeId type, F f) {
  return rounded(type, MPFR_RNDN, f);
}
template <class F>
Expected neighbours(TypeId type, F f) {
  return {Expected::As::kNeighbour, rounded(type, MPFR_RNDD, f), rounded(type, MPFR_RNDU, f)};
}

/// A whole number held within `type`; NaN is 0. Both are an event.
Expected held(TypeId type, const Number& whole) {
  const auto exactly = [&](Wide number, Event event) {
    return Expected{Expected::As::kExactly, wrapped(type, number), {}, event};
  };
  if (mpfr_nan_p(*whole) != 0) return exactly(0, Event::kOutOfRange);
  const Number low(least_of(type)), high(greatest_of(type));
  if (mpfr_cmp(*whole, *low) < 0) return exactly(least_of(type), Event::kOutOfRange);
  if (mpfr_cmp(*whole, *high) > 0) return exactly(greatest_of(type), Event::kOutOfRange);
  if (least_of(type) < 0) return exactly(mpfr_get_sj(*whole, MPFR_RNDN), Event::kNone);
  return exactly(static_cast<Wide>(mpfr_get_uj(*whole, MPFR_RNDN)), Event::kNone);
}

}  // namespace

Value real_arithmetic(char symbol, const Value& a, const Value& b) {
  Number x(a), y(b);
  return nearest(a.type, [&](mpfr_ptr out, mpfr_rnd_t rounding) {
    switch (symbol) {
      case '+':
        return mpfr_add(out, *x, *y, rounding);
      case '-':
        return mpfr_sub(out, *x, *y, rounding);
      case '*':
        return mpfr_mul(out, *x, *y, rounding);
      default:
        return mpfr_div(out, *x, *y, rounding);
    }
  });
}

std::optional<Expected> real_function(std::string_view name, const Value& in) {
  using Function = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
  static const std::map<std::string_view, Function> kFunctions = {
      {"LN", mpfr_log},  {"LOG", mpfr_log10}, {"EXP", mpfr_exp},   {"SIN", mpfr_sin},  {"COS", mpfr_cos},
      {"TAN", mpfr_tan}, {"ASIN", mpfr_asin}, {"ACOS", mpfr_acos}, {"ATAN", mpfr_atan}};
  Number x(in);
  if (name == "SQRT") {
    return Expected{Expected::As::kExactly,
                    nearest(in.type, [&](mpfr_ptr out, mpfr_rnd_t r) { return mpfr_sqrt(out, *x, r); })};
  }
  const auto found = kFunctions.find(name);
  if (found == kFunctions.end()) return std::nullopt;
  return neighbours(in.type, [&](mpfr_ptr out, mpfr_rnd_t r) { return found->second(out, *x, r); });
}

Expected arc_tangent(const Value& y, const Value& x) {
  Number a(y), b(x);
  return neighbours(y.type, [&](mpfr_ptr out, mpfr_rnd_t r) { return mpfr_atan2(out, *a, *b, r); });
}

Expected power(const Value& base, const Value& exponent) {
  Number x(base);
  Number y = core::in_category(exponent.type, core::kAnyReal) ? Number(exponent) : Number(wide_of(exponent));
  return neighbours(base.type, [&](mpfr_ptr out, mpfr_rnd_t r) { return mpfr_pow(out, *x, *y, r); });
}

Value real_quotient(TypeId type, Wide number, std::int64_t divisor) {
  Number x(number), y(static_cast<Wide>(divisor));
  return nearest(type, [&](mpfr_ptr out, mpfr_rnd_t r) { return mpfr_div(out, *x, *y, r); });
}

Value real_as(TypeId type, const Value& in) {
  Number x(in);
  return nearest(type, [&](mpfr_ptr out, mpfr_rnd_t r) { return mpfr_set(out, *x, r); });
}

Expected scaled(TypeId type, char symbol, Wide count, const Value& real) {
  Number x(count), y(real), out;
  if (symbol == '*') {
    mpfr_mul(*out, *x, *y, MPFR_RNDN);
  } else {
    mpfr_div(*out, *x, *y, MPFR_RNDN);
  }
  mpfr_rint(*out, *out, MPFR_RNDN);  // half to even
  return held(type, out);
}

Expected truncated(TypeId type, const Value& real) {
  Number x(real);
  mpfr_trunc(*x, *x);
  return held(type, x);
}

}  // namespace plc::test
