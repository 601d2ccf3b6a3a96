// The sweep: every overload of every function, on every combination of the samples of its types, gives what the oracle
// says, and reports the events its row names and no others.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "tests/library/oracle.h"

namespace plc::test {
namespace {

using stdlib::FunctionSpec;

/// Combinations tried of one overload and number of arguments; beyond, a sample of them.
constexpr std::size_t kLists = 1000;
/// Room of a string result: a variable as declared without length, and one that cuts nearly everything.
constexpr std::uint16_t kRooms[] = {core::kDefaultStringCapacity, 3};

std::string differing(const Overload& overload, std::span<const Value> arguments, const Expected& expected,
                      const Outcome& got) {
  std::string out = stdlib::key_of(overload) + shown(arguments) + " = " + shown(got.result) + ", " +
                    std::string(stdlib::event_name(got.event)) + "; expected " + shown(expected.value);
  if (expected.as == Expected::As::kNeighbour) out += " or " + shown(expected.other);
  return out + ", " + std::string(stdlib::event_name(expected.event));
}

/// Compares the kernel with the oracle; false, and reported, where they differ.
bool same(const Overload& overload, std::span<const Value> arguments, std::uint16_t room, Outcome& got) {
  auto expected = expect(overload, arguments, room);
  if (!expected) {
    ADD_FAILURE() << overload.spec->name << " has no oracle: add one to tests/library/oracle.cpp";
    return false;
  }
  got = call_kernel(overload, arguments, room);
  if (expected->as == Expected::As::kShortestText && room != kRooms[0]) {
    // Which text it is says the result that is not cut.
    const Outcome whole = call_kernel(overload, arguments, kRooms[0]);
    expected->as = Expected::As::kExactly;
    expected->value = whole.result;
    if (whole.result.text.size() > room) expected->event = Event::kTruncated;
    expected->value.text.resize(std::min<std::size_t>(room, whole.result.text.size()));
  }
  if (agrees(*expected, got.result) && expected->event == got.event) return true;
  ADD_FAILURE() << differing(overload, arguments, *expected, got);
  return false;
}

TEST(Sweep, EveryOverloadGivesWhatTheOracleSays) {
  std::map<const FunctionSpec*, std::set<Event>> seen;
  for (const Overload& overload : stdlib::overloads()) {
    const FunctionSpec& spec = *overload.spec;
    std::size_t wrong = 0;
    for (std::size_t count = spec.param_count; count <= spec.param_count + (spec.extensible ? 1u : 0u); ++count) {
      for (const Arguments& list : argument_lists(overload, count, kLists)) {
        const std::vector<Value> arguments = values_of(list);
        for (const std::uint16_t room : kRooms) {
          if (room != kRooms[0] && !is_string(overload.result_type())) continue;
          Outcome got;
          if (!same(overload, arguments, room, got) && ++wrong == 5) break;
          seen[&spec].insert(got.event);
        }
        if (wrong == 5) break;  // of one overload five examples are enough
      }
    }
  }
  for (const FunctionSpec* spec : stdlib::function_specs()) {
    for (int i = 1; i <= static_cast<int>(Event::kInvalid); ++i) {
      const auto event = static_cast<Event>(i);
      EXPECT_EQ(seen[spec].count(event) != 0, spec->events.contains(event))
          << spec->name << " (" << spec->summary << "): " << stdlib::event_name(event)
          << (spec->events.contains(event) ? " is declared and never happens" : " happens and is not declared");
    }
  }
}

/// A random value of a scalar type. Half of the numbers are small, as most functions care about size; dates are whole
/// days and times of day stay in theirs.
Value random_value(TypeId type, Sequence& sequence) {
  constexpr std::int64_t kDayNs = 86'400'000'000'000;
  const std::uint64_t bits = sequence.next() >> (64 - width_of(type));
  const bool any = sequence.below(2) == 0;
  switch (type) {
    case TypeId::kReal:
    case TypeId::kLreal: {
      if (any) return real_value(type, real_of({type, bits, {}}));  // one NaN
      const double size = std::ldexp(1.0, static_cast<int>(sequence.below(16)) - 8);
      return real_value(type, (static_cast<double>(sequence.next() >> 11) * 0x1p-53 - 0.5) * size);
    }
    case TypeId::kDate:
    case TypeId::kLdate:
      return wrapped(type, static_cast<std::int64_t>(bits) / kDayNs * kDayNs);
    case TypeId::kTod:
    case TypeId::kLtod:
      return wrapped(type, static_cast<Wide>(bits % kDayNs));
    default:
      return wrapped(type, static_cast<Wide>(any ? bits : bits >> sequence.below(width_of(type))));
  }
}

// Few samples say little about a function whose every value is rounded; of the exact ones some random values are
// enough.
TEST(Sweep, RandomNumbersGiveWhatTheOracleSays) {
  for (const Overload& overload : stdlib::overloads()) {
    const std::size_t count = overload.spec->param_count;
    bool scalar = !is_string(overload.result_type());
    for (std::size_t i = 0; i < count; ++i) scalar = scalar && !is_string(overload.param_type(i));
    if (!scalar) continue;
    Sequence sequence(stdlib::key_of(overload));
    const int tries = overload.spec->foldable ? 200 : 4000;
    int wrong = 0;
    for (int i = 0; i < tries && wrong < 5; ++i) {
      std::vector<Value> arguments;
      for (std::size_t p = 0; p < count; ++p) arguments.push_back(random_value(overload.param_type(p), sequence));
      Outcome got;
      if (!same(overload, arguments, core::kDefaultStringCapacity, got)) ++wrong;
    }
  }
}

}  // namespace
}  // namespace plc::test
