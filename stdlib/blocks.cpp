// The table of function blocks, expanded from the rows at compile time.
#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>

#include "core/text.h"
#include "stdlib/blocks/alarms.h"
#include "stdlib/blocks/analog.h"
#include "stdlib/blocks/bistable.h"
#include "stdlib/blocks/control.h"
#include "stdlib/blocks/counters.h"
#include "stdlib/blocks/signals.h"
#include "stdlib/blocks/timers.h"
#include "stdlib/library.h"
#include "stdlib/row.h"

namespace plc::stdlib {
namespace {

template <class Row>
void step(void* ports, const StepContext& context) noexcept {
  Row::step(*static_cast<typename Row::Ports*>(ports), context);
}
template <class Row>
void step_each(std::byte* base, const std::uint32_t* places, std::uint32_t count, const StepContext& context) noexcept {
  for (; count != 0; --count, ++places) Row::step(*reinterpret_cast<typename Row::Ports*>(base + *places), context);
}
template <class Ports>
constexpr Ports kFresh{};

/// A block whose TIME ports take LTIME as well.
template <class Row>
concept AnyDuration = requires {
  Row::any_duration;
};

template <class Row>
constexpr BlockSpec block() {
  using Ports = typename Row::Ports;
  static_assert(std::is_standard_layout_v<Ports> && std::is_trivially_copyable_v<Ports>, "ports are memory");
  return {Row::name,
          Row::fields,
          static_cast<std::uint32_t>(sizeof(Ports)),
          static_cast<std::uint32_t>(alignof(Ports)),
          &kFresh<Ports>,
          &step<Row>,
          &step_each<Row>,
          Row::clause,
          Row::summary,
          Row::examples,
          AnyDuration<Row>};
}

constexpr bool folded_less(std::string_view a, std::string_view b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                      [](char x, char y) { return core::fold(x) < core::fold(y); });
}

/// The lists of rows in the order in which people read them, and the titles they have for them.
constexpr std::tuple kLists{Titled<fb::BistableRows>{"Bistables and edges"},
                            Titled<fb::CounterRows>{"Counters"},
                            Titled<fb::TimerRows>{"Timers"},
                            Titled<fb::ControlRows>{"Control"},
                            Titled<fb::AnalogRows>{"Analog values"},
                            Titled<fb::SignalRows>{"Signals and clocks"},
                            Titled<fb::AlarmRows>{"Alarms"}};

template <class... R>
constexpr auto specs_of(Titled<Rows<R...>>) {
  return std::tuple{block<R>()...};
}
constexpr auto kBlocks = std::apply(
    [](auto... list) {
      return std::apply([](auto... spec) { return std::array{spec...}; }, std::tuple_cat(specs_of(list)...));
    },
    kLists);

/// Each list as a run of kBlocks.
constexpr auto kGroups = std::apply(
    [](const auto&... list) {
      std::size_t begin = 0;
      const auto run = [&begin](std::string_view title, std::size_t count) {
        const BlockGroup group{title, std::span(kBlocks).subspan(begin, count)};
        begin += count;
        return group;
      };
      return std::array{run(list.title, list.kCount)...};
    },
    kLists);

constexpr auto kByName = [] {
  std::array<const BlockSpec*, kBlocks.size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = &kBlocks[i];
  std::sort(all.begin(), all.end(),
            [](const BlockSpec* x, const BlockSpec* y) { return folded_less(x->name, y->name); });
  return all;
}();

}  // namespace

std::span<const BlockSpec> blocks() { return kBlocks; }
std::span<const BlockGroup> block_groups() { return kGroups; }

const BlockSpec* block_named(std::string_view name) {
  const auto it =
      std::lower_bound(kByName.begin(), kByName.end(), name,
                       [](const BlockSpec* block, std::string_view key) { return folded_less(block->name, key); });
  return it != kByName.end() && core::iequals((*it)->name, name) ? *it : nullptr;
}

const Field* field_named(const BlockSpec& block, std::string_view name) {
  for (const Field& field : block.fields) {
    if (core::iequals(field.name, name)) return &field;
  }
  for (const Field& field : block.fields) {
    if (!field.alias.empty() && core::iequals(field.alias, name)) return &field;
  }
  return nullptr;
}

std::uint64_t layout_hash(const BlockSpec& block) {
  std::uint64_t hash = 14695981039346656037ull;
  const auto byte = [&hash](std::uint64_t b) { hash = (hash ^ (b & 0xff)) * 1099511628211ull; };
  const auto number = [&byte](std::uint64_t n) {
    for (unsigned shift = 0; shift < 64; shift += 8) byte(n >> shift);
  };
  const auto text = [&](std::string_view s) {
    number(s.size());
    for (const char c : s) byte(static_cast<unsigned char>(c));
  };
  text(block.name);
  number(block.size);
  number(block.fields.size());
  for (const Field& field : block.fields) {
    text(field.name);
    number(static_cast<std::uint64_t>(field.direction));
    number(static_cast<std::uint64_t>(field.type));
    number(field.offset);
  }
  return hash;
}

}  // namespace plc::stdlib
