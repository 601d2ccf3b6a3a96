// The only translation unit that expands the rows over their types: at compile time, into constant tables.
#include "stdlib/library.h"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

#include "core/text.h"
#include "stdlib/functions/arithmetic.h"
#include "stdlib/functions/assertion.h"
#include "stdlib/functions/bcd.h"
#include "stdlib/functions/bits.h"
#include "stdlib/functions/comparison.h"
#include "stdlib/functions/conversion.h"
#include "stdlib/functions/dates.h"
#include "stdlib/functions/durations.h"
#include "stdlib/functions/endianness.h"
#include "stdlib/functions/numeric.h"
#include "stdlib/functions/selection.h"
#include "stdlib/functions/strings.h"
#include "stdlib/row.h"

namespace plc::stdlib {
namespace {

template <class... List>
struct Concat;
template <class... A>
struct Concat<Rows<A...>> {
  using Type = Rows<A...>;
};
template <class... A, class... B, class... Rest>
struct Concat<Rows<A...>, Rows<B...>, Rest...> : Concat<Rows<A..., B...>, Rest...> {};

/// The lists of rows in the order in which people read them, and the titles they have for them.
constexpr std::tuple kLists{
    Titled<rows::ArithmeticRows>{"Arithmetic"},    Titled<rows::NumericRows>{"Functions of real numbers"},
    Titled<rows::ComparisonRows>{"Comparison"},    Titled<rows::BitRows>{"Bit strings"},
    Titled<rows::SelectionRows>{"Selection"},      Titled<rows::StringRows>{"Strings"},
    Titled<rows::DurationRows>{"Times and dates"}, Titled<rows::DateRows>{"Dates put together and taken apart"},
    Titled<rows::ConversionRows>{"Conversions"},   Titled<rows::BcdRows>{"BCD"},
    Titled<rows::EndianRows>{"Order of bytes"},    Titled<rows::AssertionRows>{"Assertions"}};

template <class... List>
Concat<List...> concat(const std::tuple<Titled<List>...>&);
using Library = decltype(concat(kLists))::Type;

struct TypePair {
  TypeId t;
  TypeId u;
};

/// Calls `f(t, u)` for every choice of types the row accepts; one call with BOOL for a type variable it does not have.
template <class Row, class F>
constexpr void each_pair(F f) {
  constexpr const FunctionSpec& spec = Row::spec;
  const std::size_t t_end = spec.t_categories == 0 ? 1 : core::kTypeCount;
  const std::size_t u_end = spec.u_categories == 0 ? 1 : core::kTypeCount;
  for (std::size_t ti = 0; ti < t_end; ++ti) {
    const auto t = static_cast<TypeId>(ti);
    if (spec.t_categories != 0 && !core::in_category(t, spec.t_categories)) continue;
    for (std::size_t ui = 0; ui < u_end; ++ui) {
      const auto u = static_cast<TypeId>(ui);
      if (spec.u_categories != 0 && !core::in_category(u, spec.u_categories)) continue;
      if constexpr (requires { Row::accepts(t, u); }) {
        if (!Row::accepts(t, u)) continue;
      }
      f(t, u);
    }
  }
}
template <class Row>
constexpr std::size_t kPairCount = [] {
  std::size_t n = 0;
  each_pair<Row>([&n](TypeId, TypeId) { ++n; });
  return n;
}();
template <class Row>
constexpr std::array<TypePair, kPairCount<Row>> kPairs = [] {
  std::array<TypePair, kPairCount<Row>> out{};
  std::size_t n = 0;
  each_pair<Row>([&](TypeId t, TypeId u) { out[n++] = {t, u}; });
  return out;
}();

/// Rows with a table of kernels give `kernel_of(t, u)`, the others a template `kernel<T, U>`.
template <class Row, std::size_t... I>
constexpr void emit(Overload*& out, std::index_sequence<I...>) {
  const auto name = [](TypeId t, TypeId u) {
    if constexpr (requires { Row::name_of(t, u); }) {
      return Row::name_of(t, u);
    } else {
      static_cast<void>(t), static_cast<void>(u);
      return Row::spec.name;
    }
  };
  if constexpr (requires { Row::kernel_of(TypeId{}, TypeId{}); }) {
    for (const auto [t, u] : kPairs<Row>) *out++ = {&Row::spec, name(t, u), t, u, Row::kernel_of(t, u)};
  } else {
    constexpr Kernel kKernels[] = {Row::template kernel<kPairs<Row>[I].t, kPairs<Row>[I].u>...};
    for (std::size_t i = 0; i < sizeof...(I); ++i) {
      const auto [t, u] = kPairs<Row>[i];
      *out++ = {&Row::spec, name(t, u), t, u, kKernels[i]};
    }
  }
}

template <class... R>
constexpr std::size_t count_of(Rows<R...>) {
  return (kPairCount<R> + ...);
}
constexpr std::size_t kCount = count_of(Library{});

/// A run of overloads with one name.
struct Run {
  std::string_view name;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

constexpr bool folded_less(std::string_view a, std::string_view b) {
  const std::size_t n = std::min(a.size(), b.size());
  for (std::size_t i = 0; i < n; ++i) {
    const char x = core::fold(a[i]), y = core::fold(b[i]);
    if (x != y) return x < y;
  }
  return a.size() < b.size();
}

/// Of a name, whatever its letter case (FNV-1a).
constexpr std::uint32_t hash_of(std::string_view name) {
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(core::fold(c))) * 16777619u;
  return hash ^ hash >> 15;
}

struct Table {
  static constexpr std::size_t kSlots = std::bit_ceil(4 * kCount);

  std::array<Overload, kCount> overloads{};
  std::array<Run, kCount> names{};
  std::size_t name_count = 0;
  /// Names by hash, for look-ups: 1 + index, 0 = none; a taken slot leads to the next.
  std::array<std::uint16_t, kSlots> slots{};
  static_assert(kCount < 0xffff);
};

template <class... R>
constexpr Table expand(Rows<R...>) {
  std::array<Overload, kCount> all{};
  Overload* out = all.data();
  (emit<R>(out, std::make_index_sequence<kPairCount<R>>{}), ...);

  std::array<Run, kCount> runs{};
  std::size_t run_count = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    if (run_count == 0 || runs[run_count - 1].name != all[i].name) runs[run_count++] = {all[i].name, i, 0};
    ++runs[run_count - 1].count;
  }
  std::sort(runs.begin(), runs.begin() + run_count, [](const Run& a, const Run& b) {
    return a.name == b.name ? a.first < b.first : folded_less(a.name, b.name);
  });

  Table table;
  std::uint32_t n = 0;
  for (std::size_t r = 0; r < run_count; ++r) {
    if (table.name_count == 0 || table.names[table.name_count - 1].name != runs[r].name) {
      table.names[table.name_count++] = {runs[r].name, n, 0};
    }
    table.names[table.name_count - 1].count += runs[r].count;
    for (std::uint32_t i = 0; i < runs[r].count; ++i) table.overloads[n++] = all[runs[r].first + i];
  }
  for (std::size_t i = 0; i < table.name_count; ++i) {
    std::size_t slot = hash_of(table.names[i].name) % Table::kSlots;
    while (table.slots[slot] != 0) slot = (slot + 1) % Table::kSlots;
    table.slots[slot] = static_cast<std::uint16_t>(i + 1);
  }
  return table;
}
constexpr Table kTable = expand(Library{});

template <class... R>
constexpr auto specs_of(Rows<R...>) {
  return std::array<const FunctionSpec*, sizeof...(R)>{&R::spec...};
}
constexpr auto kSpecs = specs_of(Library{});

/// Each list as a run of kSpecs.
constexpr auto kGroups = std::apply(
    [](const auto&... list) {
      std::size_t begin = 0;
      const auto run = [&begin](std::string_view title, std::size_t count) {
        const FunctionGroup group{title, std::span(kSpecs).subspan(begin, count)};
        begin += count;
        return group;
      };
      return std::array{run(list.title, list.kCount)...};
    },
    kLists);

std::span<const Overload> rows_named(std::string_view name) {
  for (std::size_t slot = hash_of(name) % Table::kSlots; kTable.slots[slot] != 0; slot = (slot + 1) % Table::kSlots) {
    const Run& run = kTable.names[kTable.slots[slot] - 1u];
    if (core::iequals(run.name, name)) return overloads().subspan(run.first, run.count);
  }
  return {};
}

/// "ADD" and INT of "ADD_INT". Rows whose names say their types already (conversions) have no typed names; D and LD end
/// too many names of users to be read as types here.
std::span<const Overload> rows_of_typed_name(std::string_view name) {
  for (std::size_t at = name.rfind('_'); at != std::string_view::npos && at != 0; at = name.rfind('_', at - 1)) {
    const std::string_view suffix = name.substr(at + 1);
    const auto type = core::type_named(suffix);
    if (!type || core::iequals(suffix, "D") || core::iequals(suffix, "LD")) continue;
    const auto rows = rows_named(name.substr(0, at));
    const auto of_type = [&](const Overload& o) {
      return o.spec->t_categories != 0 && o.t == *type && o.name == o.spec->name;
    };
    const auto first = std::find_if(rows.begin(), rows.end(), of_type);
    if (first != rows.end()) return {first, std::find_if_not(first, rows.end(), of_type)};
  }
  return {};
}

}  // namespace

std::span<const Overload> overloads() { return kTable.overloads; }

std::span<const Overload> overloads_named(std::string_view name) {
  const auto rows = rows_named(name);
  return rows.empty() ? rows_of_typed_name(name) : rows;
}

std::span<const FunctionSpec* const> function_specs() { return kSpecs; }
std::span<const FunctionGroup> function_groups() { return kGroups; }

std::span<const BundleSpec> bundles() {
  static constexpr auto kBundles = [] {
    std::array<BundleSpec, std::size(rows::kSelectionBundles) + std::size(rows::kDateBundles)> all{};
    std::copy(std::begin(rows::kDateBundles), std::end(rows::kDateBundles),
              std::copy(std::begin(rows::kSelectionBundles), std::end(rows::kSelectionBundles), all.begin()));
    return all;
  }();
  return kBundles;
}

const BundleSpec* bundle_named(std::string_view name) {
  for (const BundleSpec& bundle : bundles()) {
    if (core::iequals(bundle.name, name)) return &bundle;
  }
  return nullptr;
}

bool is_function(std::string_view name) { return !overloads_named(name).empty() || bundle_named(name) != nullptr; }

}  // namespace plc::stdlib
