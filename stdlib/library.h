// The standard library as data: which functions and function blocks exist, for which types, and what they do.
//
// Each row is a struct (stdlib/functions/*.h, stdlib/blocks/*.h); library.cpp alone expands the rows over their types.
// Everyone else (overload resolution, constant folding, interpreter, docs, tests) reads these spans.
// Does not belong here: IR, opcodes, XML.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "core/types.h"

namespace plc::core {
class TimeZone;
}

namespace plc::stdlib {

using core::Rep;
using core::TypeId;

/// What can happen inside a function besides its result. An event sets ENO FALSE, is counted with its drawn element and
/// stops nothing (docs/guides/events.md).
enum class Event : std::uint8_t {
  kNone,
  kDivideByZero,
  kOutOfRange,
  kTruncated,
  kBadIndex,
  kNullReference,
  kInvalid,
  kBadPointer,
  kAssertion
};
std::string_view event_name(Event event);

/// The events that a function can report.
struct EventSet {
  std::uint16_t bits = 0;
  [[nodiscard]] constexpr bool empty() const { return bits == 0; }
  [[nodiscard]] constexpr bool contains(Event event) const {
    return event == Event::kNone || (bits >> static_cast<unsigned>(event) & 1u) != 0;
  }
};
template <class... E>
constexpr EventSet events(E... event) {
  return {static_cast<std::uint16_t>(((1u << static_cast<unsigned>(event)) | ...))};
}

/// One call of a function: `args` are pointers to `count` typed values, `result` to the typed result. Result and
/// arguments may be the same variable: kernels read all inputs before they write. Strings point at core::StringHeader.
/// RT: noexcept, bounded, no allocation.
using Kernel = Event (*)(void* result, const void* const* args, std::uint32_t count) noexcept;

/// Type of a parameter or result: a fixed elementary type, or a type variable of the row.
struct ParamType {
  enum class Kind : std::uint8_t { kFixed, kT, kU } kind = Kind::kT;
  TypeId fixed = TypeId::kBool;
};

struct Param {
  std::string_view name;  ///< pin name; the standard's ("IN1", "MN", "G")
  ParamType type{};
  std::string_view alias{};  ///< its name in the Standard libraries of CODESYS and TwinCAT ("STR1"), or empty
};

struct Example {
  std::string_view types;   ///< "DINT" or "DINT,REAL": T and U
  std::string_view call;    ///< "LIMIT(-5, 99, 10)", literals as in ST
  std::string_view result;  ///< literal, or "event:divide_by_zero 0"
};

inline constexpr std::size_t kMaxParams = 8;  // PACK
/// Arguments of one call of an extensible function.
inline constexpr std::size_t kMaxArguments = 255;

/// One function row.
struct FunctionSpec {
  std::string_view name;           ///< upper case; conversions are rows per pair family, see below
  std::uint16_t t_categories = 0;  ///< types that T ranges over, 0 = no T
  std::uint16_t u_categories = 0;  ///< types that U ranges over, 0 = no U
  Param params[kMaxParams];
  std::uint8_t param_count = 0;  ///< declared parameters
  bool extensible = false;       ///< the last declared parameter may be repeated (IN1, IN2, IN3 ..)
  ParamType result{};
  bool foldable = true;     ///< constants may be folded at compile time: exact functions only
  EventSet events{};        ///< that calls can report; strings in T: kTruncated only where a result is a string
  std::string_view clause;  ///< "IEC 61131-3:2013, table 28"
  std::string_view summary;
  std::span<const Example> examples;
};

/// One row for one choice of types.
struct Overload {
  const FunctionSpec* spec;
  std::string_view name;  ///< name callers write; equals spec->name except for conversions ("DINT_TO_REAL")
  TypeId t;               ///< meaningful when spec->t_categories != 0
  TypeId u;               ///< meaningful when spec->u_categories != 0
  Kernel kernel;

  [[nodiscard]] TypeId type_of(ParamType p) const {
    return p.kind == ParamType::Kind::kFixed ? p.fixed : p.kind == ParamType::Kind::kT ? t : u;
  }
  /// Type of argument `i` (beyond the declared ones: that of the last declared).
  [[nodiscard]] TypeId param_type(std::size_t i) const {
    return type_of(spec->params[i < spec->param_count ? i : spec->param_count - 1u].type);
  }
  [[nodiscard]] TypeId result_type() const { return type_of(spec->result); }
};

/// True for the clause of a row from a table of the standard, which every editor knows; false for those of annex F, of
/// other systems and PICARD's own.
constexpr bool is_standard(std::string_view clause) {
  return clause.starts_with("IEC 61131-3:") && clause.find("table") != std::string_view::npos;
}

/// Every overload, sorted by folded name; overloads of one name are adjacent.
std::span<const Overload> overloads();
/// The overloads called `name` (any letter case); empty when there is none. A typed name, "ADD_INT" or "SHL_WORD",
/// means the overloads of that function whose T is the type (IEC 61131-3:2013, table 21); a row of that very name goes
/// first.
std::span<const Overload> overloads_named(std::string_view name);
/// Every function row, in the order of the groups.
std::span<const FunctionSpec* const> function_specs();

/// Functions that people look for in one place.
struct FunctionGroup {
  std::string_view title;  ///< "Comparison"
  std::span<const FunctionSpec* const> specs;
  [[nodiscard]] bool contains(const FunctionSpec& row) const {
    for (const FunctionSpec* spec : specs) {
      if (spec == &row) return true;
    }
    return false;
  }
};
std::span<const FunctionGroup> function_groups();

/// Name of pin `i` of the function as drawn: declared names, then the last one counted on ("IN3", "IN4", ..).
std::string pin_name(const FunctionSpec& spec, std::size_t i);
/// The other name that pin `i` goes by, or empty.
constexpr std::string_view pin_alias(const FunctionSpec& spec, std::size_t i) {
  return i < spec.param_count ? spec.params[i].alias : std::string_view{};
}

/// Stable name of an overload in images: "ADD:DINT", "SEL:REAL", "SHL:WORD,INT". Found again by overload_with_key.
std::string key_of(const Overload& overload);
const Overload* overload_with_key(std::string_view key);
/// The overload of a kernel; overloads whose kernels are one function differ in the names of their types alone. Null
/// when the library has none.
const Overload* overload_with_kernel(Kernel kernel);

// ---- functions of several outputs
// ------------------------------------------------------------------------------------

/// A function of one input and several outputs, without a result: SPLIT_DATE, SWITCH. Each output is a function of its
/// own on the same input, whose name, "SPLIT_DATE.YEAR", no text and no drawing can spell.
struct BundleSpec {
  std::string_view name;
  Param input;  ///< of fixed type
  std::span<const FunctionSpec* const> outputs;
  std::string_view clause;
  std::string_view summary;
  std::string_view example;  ///< a call as an ST statement
};
std::span<const BundleSpec> bundles();
/// The bundle called `name` (any letter case) or null.
const BundleSpec* bundle_named(std::string_view name);
/// True for the rows that are outputs of bundles.
constexpr bool is_bundle_output(const FunctionSpec& spec) { return spec.name.find('.') != std::string_view::npos; }
/// Pin name of such a row: "YEAR".
constexpr std::string_view output_name(const FunctionSpec& spec) { return spec.name.substr(spec.name.find('.') + 1); }
/// The type of such an output where nothing asks for another: parts of dates are of any integer type.
constexpr TypeId usual_output_type(const FunctionSpec& spec) {
  return spec.result.kind == ParamType::Kind::kFixed ? spec.result.fixed : TypeId::kInt;
}
/// Whether such an output can be of this type.
constexpr bool output_takes(const FunctionSpec& spec, TypeId type) {
  return spec.result.kind == ParamType::Kind::kFixed ? spec.result.fixed == type
                                                     : core::in_category(type, spec.t_categories);
}
/// True when overloads or a bundle have this name.
bool is_function(std::string_view name);

// ---- overload resolution ---------------------------------------------------------------------------------------

/// True when no input tells the type of the result (TRUNC): what is expected does.
bool result_is_open(const FunctionSpec& spec);

/// Type of one argument as the caller knows it.
struct Arg {
  enum class Kind : std::uint8_t {
    kTyped,        ///< `type`
    kIntLiteral,   ///< an integer literal without prefix: takes any numeric or bit type its value fits
    kRealLiteral,  ///< a real literal without prefix: takes REAL or LREAL
    kUnconnected,  ///< a drawn pin without a wire: takes what the others need
  } kind = Kind::kTyped;
  TypeId type = TypeId::kBool;
  std::int64_t int_value = 0;  ///< kIntLiteral (wraps for values above 2^63-1, then `int_is_unsigned`)
  bool int_is_unsigned = false;
  bool based = false;  ///< kIntLiteral: written with its base (16#FF), so that bits may be meant
};

/// True when the third edition widens `from` to `to` implicitly (IEC 61131-3:2013, figure 12), or they are equal.
bool widens(TypeId from, TypeId to);
/// True when an untyped integer literal may become a value of `to`.
bool literal_fits(const Arg& literal, TypeId to);

struct Resolution {
  enum class Status : std::uint8_t {
    kFound,
    kUnknownName,
    kNoMatch,
    kAmbiguous,
    kWrongCount
  } status = Status::kUnknownName;
  const Overload* overload = nullptr;
  const Overload* rival = nullptr;  ///< kAmbiguous: the other winner
};
/// Picks the overload of `name` for these arguments: an exact match first, then the cheapest set of implicit widenings,
/// literals last. `expected` is the type the result should have, if the caller knows one; it breaks ties only.
Resolution resolve(std::string_view name, std::span<const Arg> args, std::optional<TypeId> expected = std::nullopt);

// ---- function blocks -------------------------------------------------------------------------------------------

enum class Direction : std::uint8_t { kInput, kOutput, kInOut, kState };

/// One port or state variable of a block, laid out in the table (docs/adr/0007: ports are memory, objects are not).
struct Field {
  std::string_view name;  ///< state fields are named too: the debugger shows them, drawings cannot wire them
  Direction direction = Direction::kInput;
  TypeId type = TypeId::kBool;
  std::uint32_t offset = 0;  ///< bytes from the start of the port struct
  std::string_view summary;
  std::string_view alias{};  ///< another name drawings use for the pin ("LOAD" for LD), or empty
};

struct StepContext {
  core::TimeNs now_ns;                   ///< taken once per cycle
  void* host = nullptr;                  ///< of the code that runs the block; standard blocks do not look at it
  core::TimeNs start_ns = 0;             ///< when the PLC started, by the same clock
  core::TimeNs utc_ns = 0;               ///< date and time, taken with now_ns; may jump from cycle to cycle
  const core::TimeZone* zone = nullptr;  ///< of local time; null: UTC
};
/// One execution of a block on its port struct. RT: noexcept, bounded.
using Step = void (*)(void* ports, const StepContext& context) noexcept;
/// One execution of each of `count` instances, whose port structs lie at `base` + places[i]: the same, without as many
/// calls. RT.
using StepEach = void (*)(std::byte* base, const std::uint32_t* places, std::uint32_t count,
                          const StepContext& context) noexcept;

/// What a block does, scan by scan, in a form that tests run and pages show. The first line names the columns: "at",
/// inputs, "|", outputs. Each further line is one scan: the time of it as a TIME, input values as ST literals, "|", the
/// outputs after it. "." leaves an input as it is, and says nothing of an output. Reals count within 1e-6 of what
/// is there, relative to values beyond 1.
struct BlockExample {
  std::string_view title;  ///< "PT changed while the time runs"
  std::string_view table;
};

struct BlockSpec {
  std::string_view name;  ///< "TON", "CTU_DINT"
  std::span<const Field> fields;
  std::uint32_t size = 0;  ///< bytes of the port struct
  std::uint32_t align = 1;
  const void* initial = nullptr;  ///< `size` bytes: a fresh instance
  Step step = nullptr;
  StepEach step_each = nullptr;
  std::string_view clause;
  std::string_view summary;
  std::span<const BlockExample> examples;
  bool any_duration = false;  ///< its inputs of type TIME take LTIME, too (IEC 61131-3:2013, table 46, 1a, 2a, 3a)
};

/// Every block, in the order of the groups.
std::span<const BlockSpec> blocks();

/// Blocks that people look for in one place.
struct BlockGroup {
  std::string_view title;  ///< "Counters"
  std::span<const BlockSpec> blocks;
};
std::span<const BlockGroup> block_groups();
/// The block called `name` (any letter case) or null.
const BlockSpec* block_named(std::string_view name);
/// The field called `name`, or else the one with that alias, or null (any letter case).
const Field* field_named(const BlockSpec& block, std::string_view name);
/// Hash of name, field names, types and offsets: an image made for another layout is refused.
std::uint64_t layout_hash(const BlockSpec& block);

}  // namespace plc::stdlib
