// Standard functions of constants, for initial values and bounds: the kernels that the program would run.
#include <algorithm>
#include <cstring>
#include <vector>

#include "core/text.h"
#include "declare/constants.h"
#include "frontend-st/literals.h"
#include "stdlib/library.h"

namespace plc::st {
namespace {

using core::TypeId;
using Kind = ConstantValue::Kind;

/// Characters that a result may have beyond those of the arguments: numbers become texts.
constexpr std::size_t kSpareCharacters = 254;

bool is_text(TypeId id) { return core::in_category(id, core::kAnyString); }
std::size_t width_of(TypeId id) { return id == TypeId::kWstring ? 2 : 1; }

std::optional<ConstantValue> fail(std::string& problem, std::string why) {
  problem = std::move(why);
  return std::nullopt;
}

/// Positions of the arguments among the parameters; empty when a name is none of theirs or one is given twice.
std::vector<std::size_t> positions_of(const stdlib::FunctionSpec& spec, std::span<const std::string_view> pins) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < pins.size(); ++i) {
    std::size_t position = i;
    if (!pins[i].empty()) {
      position = 0;
      while (
          position < pins.size() && !core::iequals(stdlib::pin_name(spec, position), pins[i]) &&
          !(!stdlib::pin_alias(spec, position).empty() && core::iequals(stdlib::pin_alias(spec, position), pins[i]))) {
        ++position;
      }
    }
    if (position == pins.size() || std::find(out.begin(), out.end(), position) != out.end()) return {};
    out.push_back(position);
  }
  return out;
}

std::optional<stdlib::Arg> argument_of(const ConstantValue& value, const ir::TypeTable& types) {
  stdlib::Arg arg;
  if (value.kind == Kind::kNull) return std::nullopt;
  if (value.kind == Kind::kTyped) {
    const auto type = types.elementary_of(value.constant.type);
    if (!type) return std::nullopt;
    arg.type = *type;
  } else if (value.type) {
    arg.type = *value.type;
  } else if (value.kind == Kind::kReal) {
    arg.kind = stdlib::Arg::Kind::kRealLiteral;
  } else {
    arg.kind = stdlib::Arg::Kind::kIntLiteral;
    arg.int_value = value.int_value;
    arg.int_is_unsigned = value.is_unsigned;
  }
  return arg;
}

/// A value as it lies in a table.
std::vector<std::byte> stored(const ConstantValue& value, TypeId type) {
  if (!is_text(type)) {
    const std::uint64_t bits =
        value.kind == Kind::kTyped ? value.constant.bits : number_bits(value, core::rep_of(type));
    std::vector<std::byte> out(sizeof bits);
    std::memcpy(out.data(), &bits, sizeof bits);
    return out;
  }
  const std::string& text = value.constant.text;
  core::StringHeader header;
  header.capacity = header.length = static_cast<std::uint16_t>(text.size() / width_of(type));
  std::vector<std::byte> out(sizeof header + text.size());
  std::memcpy(out.data(), &header, sizeof header);
  std::memcpy(out.data() + sizeof header, text.data(), text.size());
  return out;
}

}  // namespace

std::optional<ConstantValue> call_constant(std::string_view name, std::span<const ConstantValue> arguments,
                                           std::span<const std::string_view> pins, ir::TypeTable& types,
                                           std::optional<ir::TypeRef> expected, std::string& problem) {
  const auto candidates = stdlib::overloads_named(name);
  if (candidates.empty()) return fail(problem, "there is no standard function \"" + std::string(name) + '"');
  const auto positions = positions_of(*candidates.front().spec, pins);
  std::vector<ConstantValue> values(arguments.size());
  std::vector<stdlib::Arg> args(arguments.size());
  std::size_t characters = kSpareCharacters;
  const std::string unfit = core::uppered(name) + " does not take these values";
  if (positions.size() != arguments.size()) return fail(problem, unfit);
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const auto arg = argument_of(arguments[i], types);
    if (!arg) return fail(problem, unfit);
    args[positions[i]] = *arg;
    values[positions[i]] = arguments[i];
    characters += arguments[i].constant.text.size();
  }
  const auto wanted = expected ? types.elementary_of(*expected) : std::nullopt;
  const stdlib::Resolution found = stdlib::resolve(name, args, wanted);
  if (found.status != stdlib::Resolution::Status::kFound || found.overload->kernel == nullptr)
    return fail(problem, unfit);
  std::vector<std::vector<std::byte>> places;
  std::vector<const void*> pointers;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const TypeId type = found.overload->param_type(i);
    const auto own = types.elementary_of(values[i].constant.type.valid() ? values[i].constant.type : ir::kBoolType);
    // A character where a text is needed, or the other way round, is left to the program.
    const bool text = values[i].kind == Kind::kTyped && own && is_text(*own);
    if (text != is_text(type) || (text && *own != type)) return fail(problem, unfit);
    places.push_back(stored(values[i], type));
  }
  for (const auto& place : places) pointers.push_back(place.data());
  Literal result;
  result.type = found.overload->result_type();
  const std::size_t width = width_of(result.type);
  const auto capacity = static_cast<std::uint16_t>(std::min<std::size_t>(characters, core::kMaxStringCapacity));
  core::StringHeader header;
  header.capacity = capacity;
  std::vector<std::byte> out(sizeof header + std::size_t{capacity} * width);
  if (is_text(result.type)) std::memcpy(out.data(), &header, sizeof header);
  const stdlib::Event event =
      found.overload->kernel(out.data(), pointers.data(), static_cast<std::uint32_t>(pointers.size()));
  if (event == stdlib::Event::kDivideByZero) return fail(problem, "division by zero");
  if (event != stdlib::Event::kNone)
    return fail(problem, core::uppered(name) + ": " + std::string(stdlib::event_name(event)));
  if (is_text(result.type)) {
    std::memcpy(&header, out.data(), sizeof header);
    result.kind = Literal::Kind::kText;
    result.text.assign(reinterpret_cast<const char*>(out.data()) + sizeof header, header.length * width);
    return constant_of_literal(result, types);
  }
  std::memcpy(&result.bits, out.data(), sizeof result.bits);
  result.bits = truncate_bits(result.bits, core::rep_of(result.type));
  if (core::in_category(result.type, core::kAnyChar)) {
    const std::size_t bytes = result.type == TypeId::kWchar ? 2 : 1;
    result.kind = Literal::Kind::kText;
    for (std::size_t i = 0; i < bytes; ++i) result.text += static_cast<char>(result.bits >> (8 * i));
    return constant_of_literal(result, types);
  }
  result.kind = Literal::Kind::kScalar;
  return constant_of_literal(result, types);
}

}  // namespace plc::st
