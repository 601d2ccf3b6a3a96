// Constant expressions of declarations: array bounds, enumeration values, initial values.
//
// In: a text, the names it may use. Out: a value, later fitted to the type of its place. Numbers are computed with
// 64-bit integers and doubles and range-checked where they end up. Does not belong here: initial values of aggregates.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "frontend-st/ast.h"
#include "frontend-st/literals.h"
#include "frontend-st/source_text.h"
#include "ir/ir.h"

namespace plc::st {

struct ConstantValue {
  enum class Kind : std::uint8_t {
    kInt,    ///< an integer of any type
    kReal,   ///< a real of any type
    kTyped,  ///< `constant`: BOOL, time, date, text, enumeration value
    kNull,   ///< NULL
  } kind = Kind::kInt;
  std::int64_t int_value = 0;
  bool is_unsigned = false;  ///< int_value is the bits of a value above 2^63-1
  bool based = false;        ///< a literal with its base (16#FF): bits may be meant
  double real_value = 0;
  /// kInt, kReal: the type in which it is computed on; none for literals, which are exact.
  std::optional<core::TypeId> type = std::nullopt;
  ir::Constant constant;
};

/// `value` as a constant of type `id` is computed on: integers become reals, reals are rounded.
ConstantValue constant_of_type(ConstantValue value, core::TypeId id);

inline bool is_number(const ConstantValue& v) {
  return v.kind == ConstantValue::Kind::kInt || v.kind == ConstantValue::Kind::kReal;
}
/// A number as a double.
double as_double(const ConstantValue& value);
/// The value of a literal.
ConstantValue constant_of_literal(const Literal& literal, ir::TypeTable& types);
/// The bits of a number as a value of `rep`.
std::uint64_t number_bits(const ConstantValue& value, core::Rep rep);

/// The standard function `name` of `arguments`, whose pins are named where `pins` names them. Nothing, and why in
/// `problem`, when it does not take them or an event happens.
std::optional<ConstantValue> call_constant(std::string_view name, std::span<const ConstantValue> arguments,
                                           std::span<const std::string_view> pins, ir::TypeTable& types,
                                           std::optional<ir::TypeRef> expected, std::string& problem);

/// One step from a variable to a part of it: a member, or an index as declared.
struct PathStep {
  std::string_view member;  ///< empty: `index`
  std::int64_t index = 0;
};

/// Names that constant expressions may use.
class ConstantScope {
 public:
  virtual ~ConstantScope() = default;
  /// The constant called `name` ("N", "GVL.N"); nothing when there is none or it has no value.
  virtual std::optional<ConstantValue> constant_named(std::string_view name) = 0;
  /// What a variable, or the part of it at the end of `path`, begins with, where that may be used in an expression.
  virtual std::optional<ConstantValue> variable_value(std::string_view /*root*/, std::span<const PathStep> /*path*/) {
    return std::nullopt;
  }
  /// Whether `name` is called as a function that is none of the standard: it has no value before the program runs.
  virtual bool is_own_function(std::string_view /*name*/) { return false; }
  /// Bytes of the variable or type at `id`; nothing, and why in `problem`, when it has no size.
  virtual std::optional<std::uint64_t> size_of(const Ast& /*ast*/, const SourceText& /*source*/, NodeId /*id*/,
                                               std::string& problem) {
    problem = "sizes are not known here";
    return std::nullopt;
  }
  /// Whether the expression is in a library.
  [[nodiscard]] virtual bool in_library() const { return false; }
};

/// The value of the expression `text`, errors reported at `at`. `expected` decides bare enumeration names.
std::optional<ConstantValue> evaluate_constant(std::string_view text, const core::SourceRef& at, ir::TypeTable& types,
                                               ConstantScope& scope, core::Diagnostics& diagnostics,
                                               std::string_view pou,
                                               std::optional<ir::TypeRef> expected = std::nullopt);

/// `value` as a constant of the scalar type `to`. Nothing, and why in `problem`, when it does not fit. Where only other
/// tools would take it, `problem` says what it is, and `note` under which code.
std::optional<ir::Constant> constant_as(const ConstantValue& value, ir::TypeRef to, const ir::TypeTable& types,
                                        std::string& problem, std::optional<core::Code>& note);

}  // namespace plc::st
