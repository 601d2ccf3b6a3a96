// Conversions of the oracle, after the table of docs/guides/conversions.md.
#include "tests/library/oracle.h"

namespace plc::test {
namespace {

constexpr std::int64_t kMillisecondNs = 1'000'000;

bool is(TypeId type, std::uint16_t categories) { return core::in_category(type, categories); }
Expected exactly(Value value, Event event = Event::kNone) {
  return {Expected::As::kExactly, std::move(value), {}, event};
}

/// Nanoseconds of what DATE, DT and TOD count as numbers; the long forms count them themselves.
std::int64_t date_unit(TypeId type) {
  if (type == TypeId::kTod) return kMillisecondNs;
  return type == TypeId::kDate || type == TypeId::kDt ? 1'000'000'000 : 1;
}

/// Its day of a date and time; the time of day that is left.
Expected part_of_stamp(TypeId type, const Value& in) {
  constexpr Wide kDayNs = Wide{86'400} * 1'000'000'000;
  constexpr Wide kFirstDay = -106'751 * kDayNs;
  const Wide rest = (wide_of(in) % kDayNs + kDayNs) % kDayNs;
  const Wide day = wide_of(in) - rest;
  if (type == TypeId::kTod || type == TypeId::kLtod) return exactly(wrapped(type, rest));
  // The first day of 64 bits begins before they do.
  if (day < kFirstDay) return exactly(wrapped(type, kFirstDay), Event::kOutOfRange);
  return exactly(wrapped(type, day));
}

Expected from_real(TypeId type, const Value& in) {
  const double number = real_of(in);
  if (is(type, core::kAnyReal)) return exactly(real_as(type, in));
  if (type == TypeId::kBool) {
    const bool is_nan = number != number;
    return exactly(wrapped(type, !is_nan && number != 0), is_nan ? Event::kOutOfRange : Event::kNone);
  }
  return scaled(type, '*', type == TypeId::kTime ? kMillisecondNs : 1, in);
}

}  // namespace

Expected converted(TypeId type, const Value& in) {
  using enum TypeId;
  const bool from_text = is(in.type, core::kAnyString);
  if (is(type, core::kAnyString)) return written(type, in);
  if (from_text) return read(type, in);
  if (is(in.type, core::kAnyReal)) return from_real(type, in);
  if (in.type == kWchar && type == kChar) {
    const auto byte = byte_of_character(static_cast<char16_t>(wide_of(in)));
    return exactly(wrapped(type, byte.value_or(u'?')), byte ? Event::kNone : Event::kInvalid);
  }
  if (in.type == kChar && type == kWchar) {
    return exactly(wrapped(type, character_of_byte(static_cast<char16_t>(wide_of(in)))));
  }
  const bool from_date = is(in.type, core::kAnyDate), to_date = is(type, core::kAnyDate);
  if (from_date && is(type, core::kAnyDuration)) return exactly(wrapped(type, wide_of(in)));
  if (to_date && is(in.type, core::kAnyDuration)) return part_of_stamp(type, in);
  if (from_date && !to_date) return exactly(wrapped(type, wide_of(in) / date_unit(in.type)));
  if (to_date && !from_date) {
    const Value stamp = wrapped(kLdt, wide_of(wrapped(kLint, wide_of(in))) * date_unit(type));
    return type == kDt || type == kLdt ? exactly(wrapped(type, wide_of(stamp))) : part_of_stamp(type, stamp);
  }
  if (from_date) {
    const bool whole_stamp = in.type == kDt || in.type == kLdt;
    const bool to_stamp = type == kDt || type == kLdt;
    return whole_stamp && !to_stamp ? part_of_stamp(type, in) : exactly(wrapped(type, wide_of(in)));
  }
  if (is(in.type, core::kAnyDuration) && is(type, core::kAnyDuration)) return exactly(wrapped(type, wide_of(in)));
  const std::int64_t unit = in.type == kTime ? kMillisecondNs : 1;
  if (type == kBool) return exactly(wrapped(type, wide_of(in) != 0));
  if (is(type, core::kAnyReal)) return exactly(real_quotient(type, wide_of(in), unit));
  return exactly(wrapped(type, type == kTime ? wide_of(in) * kMillisecondNs : wide_of(in) / unit));
}

}  // namespace plc::test
