// Values for the sweep over the library: for each elementary type those at which functions change what they do, and
// calls of kernels on them.
//
// In: types, overloads. Out: samples, each as a value and as ST text that gives it; lists of arguments; results of
// kernels. Does not belong here: what a result should be (oracle.h), programs (program.h).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"
#include "stdlib/library.h"

namespace plc::test {

using core::TypeId;
using stdlib::Event;
using stdlib::Overload;

/// A value of an elementary type: the low bits of a scalar, or the characters of a string (STRING: one per byte).
struct Value {
  TypeId type = TypeId::kBool;
  std::uint64_t bits = 0;
  std::u16string text;
  friend bool operator==(const Value&, const Value&) = default;
};
bool is_string(TypeId type);
/// Bits that count in a scalar: 1 of a BOOL.
unsigned width_of(TypeId type);
Value real_value(TypeId type, double value);
double real_of(const Value& value);
/// The value as a reader of a failed test wants to see it.
std::string shown(const Value& value);
std::string shown(std::span<const Value> values);

struct Sample {
  Value value;
  std::string st;  ///< a constant expression of exactly this type and value; empty where no literal reaches
};
/// Ends, zero, one, -1, what rounds, overflows or saturates elsewhere; strings empty, full, and with literals in them.
std::span<const Sample> samples_of(TypeId type);

/// Numbers that look random and are the same on every machine (splitmix64).
class Sequence {
 public:
  explicit Sequence(std::string_view seed);
  std::uint64_t next();
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

using Arguments = std::vector<const Sample*>;
/// Lists of `count` arguments of the overload: every combination of its samples if there are at most `limit`, else
/// `limit` of them, each sample at each place among them.
std::vector<Arguments> argument_lists(const Overload& overload, std::size_t count, std::size_t limit);
std::vector<Value> values_of(const Arguments& arguments);

/// Memory of one value as tables have it; strings have room for `capacity` characters.
class Cell {
 public:
  explicit Cell(TypeId type, std::uint16_t capacity = core::kDefaultStringCapacity);
  [[nodiscard]] std::byte* place() { return bytes_.data(); }
  void set(const Value& value) { write(bytes_.data(), value); }
  [[nodiscard]] Value get() const { return read(bytes_.data(), type_); }
  /// The same on memory of others; a string must fit.
  static void write(std::byte* place, const Value& value);
  static Value read(const std::byte* place, TypeId type);

 private:
  TypeId type_;
  std::vector<std::byte> bytes_;
};

struct Outcome {
  Value result;
  Event event = Event::kNone;
};
/// What the kernel of the overload gives; a string result has room for `room` characters.
Outcome call_kernel(const Overload& overload, std::span<const Value> arguments,
                    std::uint16_t room = core::kDefaultStringCapacity);

}  // namespace plc::test
