// Overload resolution, and the names of overloads and pins.
#include <algorithm>
#include <array>
#include <charconv>
#include <tuple>
#include <unordered_map>

#include "core/text.h"
#include "stdlib/library.h"

namespace plc::stdlib {
namespace {

constexpr std::uint8_t kNever = 0xff;
using CostTable = std::array<std::array<std::uint8_t, core::kTypeCount>, core::kTypeCount>;

constexpr std::size_t index_of(TypeId id) { return static_cast<std::size_t>(id); }

/// Cost of each implicit widening: the steps of figure 12 and everything they lead to. A wider type of the same kind is
/// cheaper than a signed one for an unsigned, and that cheaper than a real.
constexpr CostTable kWidening = [] {
  using enum TypeId;
  struct Step {
    TypeId from, to;
    std::uint8_t cost;
  };
  constexpr Step kSteps[] = {{kSint, kInt, 1},     {kInt, kDint, 1},    {kDint, kLint, 1},    {kUsint, kUint, 1},
                             {kUint, kUdint, 1},   {kUdint, kUlint, 1}, {kUsint, kInt, 3},    {kUint, kDint, 3},
                             {kUdint, kLint, 3},   {kInt, kReal, 10},   {kUint, kReal, 10},   {kDint, kLreal, 10},
                             {kUdint, kLreal, 10}, {kReal, kLreal, 1},  {kBool, kByte, 1},    {kByte, kWord, 1},
                             {kWord, kDword, 1},   {kDword, kLword, 1}, {kTime, kLtime, 1},   {kDate, kLdate, 1},
                             {kTod, kLtod, 1},     {kDt, kLdt, 1},      {kChar, kString, 10}, {kWchar, kWstring, 10}};
  CostTable cost{};
  for (std::size_t i = 0; i < core::kTypeCount; ++i) {
    for (std::size_t k = 0; k < core::kTypeCount; ++k) cost[i][k] = i == k ? 0 : kNever;
  }
  for (const Step& s : kSteps) cost[index_of(s.from)][index_of(s.to)] = s.cost;
  for (std::size_t via = 0; via < core::kTypeCount; ++via) {
    for (std::size_t i = 0; i < core::kTypeCount; ++i) {
      for (std::size_t k = 0; k < core::kTypeCount; ++k) {
        if (cost[i][via] == kNever || cost[via][k] == kNever) continue;
        const auto sum = static_cast<std::uint8_t>(cost[i][via] + cost[via][k]);
        if (sum < cost[i][k]) cost[i][k] = sum;
      }
    }
  }
  return cost;
}();

/// Which type an untyped literal takes when nothing else decides: DINT, LINT, ULINT; LREAL; then the rest.
constexpr std::uint32_t literal_cost(TypeId to) {
  using enum TypeId;
  constexpr TypeId kOrder[] = {kDint, kLint, kUlint, kLreal, kDword, kLword, kReal, kUdint,
                               kInt,  kUint, kWord,  kSint,  kUsint, kByte,  kBool};
  std::uint32_t cost = 0;
  for (const TypeId id : kOrder) {
    if (id == to) return cost;
    ++cost;
  }
  return cost;
}
constexpr auto kLiteralCost = [] {
  std::array<std::uint8_t, core::kTypeCount> out{};
  for (std::size_t i = 0; i < core::kTypeCount; ++i) {
    out[i] = static_cast<std::uint8_t>(literal_cost(static_cast<TypeId>(i)));
  }
  return out;
}();

struct Range {
  std::int64_t least;
  std::uint64_t greatest;
};
/// Values of an integer or bit type.
constexpr Range range_of(TypeId id) {
  switch (core::rep_of(id)) {
    case Rep::kBool:
      return {0, 1};
    case Rep::kI8:
      return {-0x80, 0x7f};
    case Rep::kI16:
      return {-0x8000, 0x7fff};
    case Rep::kI32:
      return {-0x80000000ll, 0x7fffffff};
    case Rep::kI64:
      return {INT64_MIN, 0x7fffffffffffffffull};
    case Rep::kU8:
      return {0, 0xff};
    case Rep::kU16:
      return {0, 0xffff};
    case Rep::kU32:
      return {0, 0xffffffff};
    default:
      return {0, UINT64_MAX};
  }
}

/// Compared in this order: implicit widenings, distance of the result from what is expected, literals, and for results
/// that no argument decides (TRUNC) the usual type.
struct Cost {
  std::uint32_t widening = 0;
  std::uint32_t expected = 0;
  std::uint32_t literals = 0;
  std::uint32_t result = 0;
  friend bool operator==(const Cost&, const Cost&) = default;
  friend auto operator<=>(const Cost&, const Cost&) = default;
};

bool count_fits(const FunctionSpec& spec, std::size_t count) {
  return spec.extensible ? count >= spec.param_count && count <= kMaxArguments : count == spec.param_count;
}

/// False when an argument does not fit.
bool cost_of(const Overload& overload, std::span<const Arg> args, std::optional<TypeId> expected, Cost& cost) {
  for (std::size_t i = 0; i < args.size(); ++i) {
    const TypeId to = overload.param_type(i);
    const Arg& arg = args[i];
    switch (arg.kind) {
      case Arg::Kind::kTyped: {
        const std::uint8_t step = kWidening[index_of(arg.type)][index_of(to)];
        if (step == kNever) return false;
        cost.widening += step;
        break;
      }
      case Arg::Kind::kIntLiteral:
        if (!literal_fits(arg, to)) return false;
        cost.literals += kLiteralCost[index_of(to)];
        break;
      case Arg::Kind::kRealLiteral:
        if (!core::in_category(to, core::kAnyReal)) return false;
        cost.literals += kLiteralCost[index_of(to)];
        break;
      case Arg::Kind::kUnconnected:
        break;
    }
  }
  constexpr std::uint32_t kUnrelated = 0x1000;
  if (expected) {
    const std::uint8_t step = kWidening[index_of(overload.result_type())][index_of(*expected)];
    cost.expected = step == kNever ? kUnrelated : step;
    // Where nothing but the context tells the result, a narrower one that would be widened loses values for nothing.
    if (result_is_open(*overload.spec) && step != 0) cost.expected = kUnrelated;
  }
  if (result_is_open(*overload.spec)) cost.result = kLiteralCost[index_of(overload.result_type())];
  return true;
}

/// The types that tell overloads of one name apart: T and U, or the parameters of a row without type variables.
template <class F>
void each_key_type(const Overload& overload, F f) {
  const FunctionSpec& spec = *overload.spec;
  if (spec.t_categories != 0) f(overload.t);
  if (spec.u_categories != 0) f(overload.u);
  if (spec.t_categories != 0 || spec.u_categories != 0) return;
  for (std::size_t i = 0; i < spec.param_count; ++i) f(spec.params[i].type.fixed);
}

}  // namespace

std::string_view event_name(Event event) {
  constexpr std::string_view kNames[] = {"none",           "divide_by_zero", "out_of_range", "truncated", "bad_index",
                                         "null_reference", "invalid",        "bad_pointer",  "assertion"};
  return kNames[static_cast<std::size_t>(event)];
}

bool result_is_open(const FunctionSpec& spec) {
  const ParamType::Kind kind = spec.result.kind;
  return kind != ParamType::Kind::kFixed &&
         std::none_of(spec.params, spec.params + spec.param_count, [&](const Param& p) { return p.type.kind == kind; });
}

bool widens(TypeId from, TypeId to) { return kWidening[index_of(from)][index_of(to)] != kNever; }

bool literal_fits(const Arg& literal, TypeId to) {
  if (core::in_category(to, core::kAnyReal)) return true;
  if (literal.kind != Arg::Kind::kIntLiteral || !core::in_category(to, core::kAnyInt | core::kAnyBit)) return false;
  const Range range = range_of(to);
  if (literal.int_is_unsigned || literal.int_value >= 0) {
    return static_cast<std::uint64_t>(literal.int_value) <= range.greatest;
  }
  return literal.int_value >= range.least;
}

Resolution resolve(std::string_view name, std::span<const Arg> args, std::optional<TypeId> expected) {
  using Status = Resolution::Status;
  const auto candidates = overloads_named(name);
  if (candidates.empty()) return {Status::kUnknownName};
  const bool exact =
      std::any_of(args.begin(), args.end(), [](const Arg& arg) { return arg.kind == Arg::Kind::kTyped; });
  // Most calls fit exactly: types are compared before costs are counted.
  const auto is_exact = [args](const Overload& candidate) {
    for (std::size_t i = 0; i < args.size(); ++i) {
      if (args[i].kind == Arg::Kind::kTyped && args[i].type != candidate.param_type(i)) return false;
    }
    return true;
  };
  if (exact) {
    for (const Overload& candidate : candidates) {
      if (!count_fits(*candidate.spec, args.size()) || !is_exact(candidate)) continue;
      Cost cost;
      if (cost_of(candidate, args, expected, cost) && cost == Cost{}) return {Status::kFound, &candidate, nullptr};
    }
  }
  Resolution best{Status::kWrongCount};
  Cost best_cost;
  for (const Overload& candidate : candidates) {
    if (!count_fits(*candidate.spec, args.size())) continue;
    if (best.status == Status::kWrongCount) best.status = Status::kNoMatch;
    Cost cost;
    if (!cost_of(candidate, args, expected, cost)) continue;
    if (best.overload == nullptr || cost < best_cost) {
      best = {Status::kFound, &candidate, nullptr};
      best_cost = cost;
    } else if (cost == best_cost) {
      best.rival = &candidate;
    }
  }
  if (best.rival != nullptr) best.status = Status::kAmbiguous;
  return best;
}

std::string pin_name(const FunctionSpec& spec, std::size_t i) {
  if (spec.param_count == 0) return {};
  if (i < spec.param_count) return std::string(spec.params[i].name);
  const std::string_view last = spec.params[spec.param_count - 1u].name;
  std::size_t digits = last.size();
  while (digits > 0 && last[digits - 1] >= '0' && last[digits - 1] <= '9') --digits;
  std::size_t number = 0;
  std::from_chars(last.data() + digits, last.data() + last.size(), number);
  return std::string(last.substr(0, digits)) + std::to_string(number + i - (spec.param_count - 1u));
}

std::string key_of(const Overload& overload) {
  std::string key(overload.name);
  char separator = ':';
  each_key_type(overload, [&](TypeId id) {
    key += separator;
    key += core::name_of(id);
    separator = ',';
  });
  return key;
}

const Overload* overload_with_kernel(Kernel kernel) {
  static const auto known = [] {
    std::unordered_map<Kernel, const Overload*> map;
    for (const Overload& overload : overloads()) map.try_emplace(overload.kernel, &overload);
    return map;
  }();
  const auto found = known.find(kernel);
  return found == known.end() ? nullptr : found->second;
}

const Overload* overload_with_key(std::string_view key) {
  const std::size_t colon = std::min(key.find(':'), key.size());
  std::array<TypeId, kMaxParams> types{};
  std::size_t count = 0;
  for (std::string_view rest = key.substr(colon); !rest.empty();) {
    rest.remove_prefix(1);
    const std::size_t end = std::min(rest.find(','), rest.size());
    const auto type = core::type_named(rest.substr(0, end));
    if (!type || count == kMaxParams) return nullptr;
    types[count++] = *type;
    rest.remove_prefix(end);
  }
  for (const Overload& overload : overloads_named(key.substr(0, colon))) {
    if (!core::iequals(overload.name, key.substr(0, colon))) return nullptr;  // a typed name: keys have their types
    std::size_t n = 0;
    bool same = true;
    each_key_type(overload, [&](TypeId id) {
      same = same && n < count && types[n] == id;
      ++n;
    });
    if (same && n == count) return &overload;
  }
  return nullptr;
}

}  // namespace plc::stdlib
