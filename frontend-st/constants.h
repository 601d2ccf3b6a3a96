// Constant expressions of declarations: array bounds, enumeration values, initial values.
//
// In: a text, the names it may use. Out: a value, later fitted to the type of its place. Numbers are computed with
// 64-bit integers and doubles and range-checked where they end up. Does not belong here: initial values of aggregates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
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
  double real_value = 0;
  /// kInt, kReal: the type in which it is computed on; none for literals, which are exact.
  std::optional<core::TypeId> type = std::nullopt;
  ir::Constant constant;
};

/// `value` as a constant of type `id` is computed on: integers become reals, reals are rounded.
ConstantValue constant_of_type(ConstantValue value, core::TypeId id);

/// Names that constant expressions may use.
class ConstantScope {
 public:
  virtual ~ConstantScope() = default;
  /// The constant called `name` ("N", "GVL.N"); nothing when there is none or it has no value.
  virtual std::optional<ConstantValue> constant_named(std::string_view name) = 0;
};

/// The value of the expression `text`, errors reported at `at`. `expected` decides bare enumeration names.
std::optional<ConstantValue> evaluate_constant(std::string_view text, const core::SourceRef& at, ir::TypeTable& types,
                                               ConstantScope& scope, core::Diagnostics& diagnostics,
                                               std::string_view pou,
                                               std::optional<ir::TypeRef> expected = std::nullopt);

/// `value` as a constant of the scalar type `to`. Nothing, and why in `problem`, when it does not fit.
std::optional<ir::Constant> constant_as(const ConstantValue& value, ir::TypeRef to, const ir::TypeTable& types,
                                        std::string& problem);

}  // namespace plc::st
