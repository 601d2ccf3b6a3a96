// Binary coded decimals against the digits that the C library prints, and what is no value at all: IS_VALID,
// IS_VALID_BCD.
#include <bit>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <random>

#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;

struct Outcome {
  std::uint64_t bits;
  Event event;
};
Outcome run(const Overload& o, std::uint64_t in) {
  Value arg(o.param_type(0));
  arg.set_bits(in);
  Value result(o.result_type());
  const Event event = call(o, result, {arg});
  return {result.bits(), event};
}
unsigned digits_of(TypeId bits) { return static_cast<unsigned>(2 * core::rep_bytes(core::rep_of(bits))); }
std::uint64_t most_of(TypeId number) {
  const std::size_t bytes = core::rep_bytes(core::rep_of(number));
  return bytes == 8 ? ~0ull : (1ull << 8 * bytes) - 1;
}

/// What a bit string says, read as the text of its hexadecimal digits.
Outcome decoded(std::uint64_t bits, TypeId number) {
  char text[24];
  std::snprintf(text, sizeof text, "%" PRIX64, bits);
  if (std::string_view(text).find_first_of("ABCDEF") != std::string_view::npos) return {0, Event::kInvalid};
  const std::uint64_t value = std::strtoull(text, nullptr, 10);
  if (value > most_of(number)) return {most_of(number), Event::kOutOfRange};
  return {value, Event::kNone};
}
Outcome encoded(std::uint64_t value, TypeId bits) {
  char text[24];
  const int length = std::snprintf(text, sizeof text, "%" PRIu64, value);
  if (length > static_cast<int>(digits_of(bits))) {
    return {std::strtoull(std::string(digits_of(bits), '9').c_str(), nullptr, 16), Event::kOutOfRange};
  }
  return {std::strtoull(text, nullptr, 16), Event::kNone};
}

constexpr TypeId kBits[] = {TypeId::kByte, TypeId::kWord, TypeId::kDword, TypeId::kLword};
constexpr TypeId kNumbers[] = {TypeId::kUsint, TypeId::kUint, TypeId::kUdint, TypeId::kUlint};

/// All values of 16 bits and less; of wider types the edges and values of every length.
std::vector<std::uint64_t> values_of(TypeId type) {
  std::vector<std::uint64_t> out;
  const std::size_t bytes = core::rep_bytes(core::rep_of(type));
  for (std::uint64_t v = 0; v <= std::min<std::uint64_t>(most_of(type), 0xffff); ++v) out.push_back(v);
  if (bytes <= 2) return out;
  std::mt19937_64 random(22);
  for (unsigned i = 0; i < 4000; ++i) {
    const std::uint64_t v = random() >> random() % 64;
    char text[24];
    std::snprintf(text, sizeof text, "%" PRIu64, v);
    for (const std::uint64_t candidate : {v, std::uint64_t{std::strtoull(text, nullptr, 16)}}) {
      if (candidate <= most_of(type)) out.push_back(candidate);
    }
  }
  for (std::uint64_t power = 10; power < 1'000'000'000'000'000'000ull; power *= 10) {
    for (const std::uint64_t v : {power - 1, power}) {
      if (v <= most_of(type)) out.push_back(v);
    }
  }
  out.push_back(most_of(type));
  return out;
}

TEST(Bcd, DigitsAreNumbers) {
  for (const TypeId t : kBits) {
    for (const TypeId u : kNumbers) {
      const std::string pair = ":" + std::string(core::name_of(t)) + "," + std::string(core::name_of(u));
      const std::string bits(core::name_of(t)), number(core::name_of(u));
      const Overload& typed = overload(bits + "_BCD_TO_" + number + pair);
      const Overload& open = overload("BCD_TO_" + number + pair);
      for (const std::uint64_t in : values_of(t)) {
        const Outcome want = decoded(in, u);
        for (const Overload* o : {&typed, &open}) {
          const Outcome got = run(*o, in);
          ASSERT_EQ(got.bits, want.bits) << o->name << " " << in;
          ASSERT_EQ(got.event, want.event) << o->name << " " << in;
        }
      }
    }
  }
}

TEST(Bcd, NumbersAreDigits) {
  for (const TypeId t : kNumbers) {
    for (const TypeId u : kBits) {
      const std::string pair = ":" + std::string(core::name_of(t)) + "," + std::string(core::name_of(u));
      const std::string number(core::name_of(t)), bits(core::name_of(u));
      const Overload& typed = overload(number + "_TO_BCD_" + bits + pair);
      const Overload& open = overload("TO_BCD_" + bits + pair);
      for (const std::uint64_t in : values_of(t)) {
        const Outcome want = encoded(in, u);
        for (const Overload* o : {&typed, &open}) {
          const Outcome got = run(*o, in);
          ASSERT_EQ(got.bits, want.bits) << o->name << " " << in;
          ASSERT_EQ(got.event, want.event) << o->name << " " << in;
        }
      }
    }
  }
}

TEST(Bcd, IsValidWhereThereIsANumber) {
  for (const TypeId t : kBits) {
    const Overload& o = overload("IS_VALID_BCD:" + std::string(core::name_of(t)));
    for (const std::uint64_t in : values_of(t)) {
      const Outcome got = run(o, in);
      ASSERT_EQ(got.bits != 0, decoded(in, TypeId::kUlint).event == Event::kNone) << o.name << " " << in;
      ASSERT_EQ(got.event, Event::kNone);
    }
  }
}

TEST(Validation, RealsAreValidWhenTheyAreFinite) {
  std::mt19937_64 random(39);
  const Overload& real = overload("IS_VALID:REAL");
  const Overload& lreal = overload("IS_VALID:LREAL");
  for (std::uint64_t exponent = 0; exponent < 2048; ++exponent) {
    for (const std::uint64_t fraction :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << 51, ~std::uint64_t{0} >> 12, random() >> 12}) {
      for (const std::uint64_t sign : {std::uint64_t{0}, std::uint64_t{1} << 63}) {
        const std::uint64_t bits = sign | exponent << 52 | fraction;
        EXPECT_EQ(run(lreal, bits).bits != 0, std::isfinite(std::bit_cast<double>(bits))) << bits;
        const auto low = static_cast<std::uint32_t>(sign >> 32 | (exponent & 0xff) << 23 | fraction >> 29);
        EXPECT_EQ(run(real, low).bits != 0, std::isfinite(std::bit_cast<float>(low))) << low;
      }
    }
  }
}

}  // namespace
}  // namespace plc::test
