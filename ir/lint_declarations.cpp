// Lints of what declarations ask for: names and addresses.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <tuple>

#include "core/text.h"
#include "ir/lint_findings.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

/// POUs that the tasks reach; all of them where no task runs anything.
std::vector<bool> running_pous(const Module& module) {
  std::vector<bool> running(module.pous.size());
  bool any = false;
  for (const Task& task : module.tasks) {
    for (const std::uint32_t pou : reached_pous(module, task)) {
      running[pou] = true;
      any = true;
    }
  }
  if (!any) running.assign(module.pous.size(), true);
  return running;
}

// Several POUs may share an address under one name: that is how texts without global variables do it. Under two names
// it is hard to see that a write undoes another.
void look_at_names(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kTwoNames)) return;
  const std::vector<bool> running = running_pous(module);
  for (const auto& [global, names] : module.written_names) {
    std::vector<const WrittenName*> different;
    for (const WrittenName& name : names) {
      const bool counts = running[name.pou] && findings.is_linted(module.pous[name.pou]);
      const bool known = std::any_of(different.begin(), different.end(),
                                     [&](const WrittenName* other) { return core::iequals(other->name, name.name); });
      if (counts && !known) different.push_back(&name);
    }
    if (different.size() < 2) continue;
    std::string list;
    for (std::size_t i = 0; i < different.size(); ++i) {
      const WrittenName& name = *different[i];
      list += i == 0 ? "" : i + 1 == different.size() ? " and " : ", ";
      list += fmt::format("{} ({}, line {})", quoted(name.name), module.pous[name.pou].name, name.at.line);
    }
    findings.add(
        Lint::kTwoNames, different.back()->at, module.pous[different.back()->pou].name,
        fmt::format("{} are one variable at {}, and all are written", list, module.globals[global].variable.address),
        "the last write in a scan wins; give each an address of its own, or use one of the names");
  }
}

/// "%IW0.1" has one number more than a word of the process image, "%IX0.0.1" one more than a bit.
bool has_numbers_too_many(std::string_view address) {
  if (address.size() < 3 || address.ends_with('*')) return false;
  const auto dots = std::count(address.begin(), address.end(), '.');
  return dots > (core::upper(address[2]) == 'X' ? 1 : 0);
}

void look_at_address(const Global& global, Findings& findings) {
  const Variable& v = global.variable;
  if (findings.skips_library(global.from_library) || !has_numbers_too_many(v.address)) return;
  const std::string whole = v.address.substr(0, v.address.find('.', v.address[2] == 'X' ? v.address.find('.') + 1 : 0));
  findings.add(Lint::kDottedAddress, v.at, {},
               fmt::format("{} is a place of its own, and no part of {}: HMIs find it at an automatic address",
                           v.address, whole),
               "plc map shows which; where one number is meant, write it like %IW0, %IW1 or %QD2");
}

/// What lies at an address: places of one area and size, of which an array has many.
struct Span {
  std::string_view address;
  const Global* global = nullptr;
  char area = 'M', size = 'W';
  std::int64_t first = 0, count = 1;
  [[nodiscard]] bool is_with(const Span& other) const { return area == other.area && size == other.size; }
};

unsigned bits_at(char size) { return size == 'X' ? 1 : size == 'B' ? 8 : size == 'W' ? 16 : size == 'D' ? 32 : 64; }

/// "%MW10" and "%QX1.3"; nothing for other forms, and where an element is not as large as a place.
std::optional<Span> span_of(const TypeTable& types, const Global& global) {
  const std::string_view address = global.variable.address;
  if (address.size() < 4) return std::nullopt;
  Span out{address, &global, core::upper(address[1]), core::upper(address[2])};
  const char* const end = address.data() + address.size();
  auto [next, problem] = std::from_chars(address.data() + 3, end, out.first);
  if (problem != std::errc{} || out.first > INT32_MAX) return std::nullopt;
  if (out.size == 'X') {
    if (end - next != 2 || *next != '.' || next[1] < '0' || next[1] > '7') return std::nullopt;
    out.first = out.first * 8 + (next[1] - '0');
    next = end;
  }
  if (next != end) return std::nullopt;
  TypeRef type = global.variable.type;
  for (; types[type].kind == TypeKind::kArray; type = types[type].element)
    out.count *= types[type].upper - types[type].lower + 1;
  const auto elementary = types.elementary_of(type);
  if (!elementary || core::in_category(*elementary, core::kAnyString)) return std::nullopt;
  const unsigned bits = *elementary == core::TypeId::kBool ? 1 : core::rep_bytes(core::rep_of(*elementary)) * 8;
  return bits == bits_at(out.size) ? std::optional(out) : std::nullopt;
}

// Each declared address is a variable of its own, also one inside of an array.
void look_at_arrays(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kInsideArray)) return;
  std::vector<Span> spans;
  for (const Global& global : module.globals) {
    if (global.variable.address.empty() || findings.skips_library(global.from_library)) continue;
    if (const auto span = span_of(module.types, global)) spans.push_back(*span);
  }
  // The longest first of those that begin together, then in the order of the declarations.
  std::stable_sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) {
    return std::tie(a.area, a.size, a.first, b.count) < std::tie(b.area, b.size, b.first, a.count);
  });
  const Span* widest = nullptr;
  for (const Span& span : spans) {
    // At one address inputs may have two types, and others are refused.
    const bool inside = widest != nullptr && widest->is_with(span) && span.first > widest->first &&
                        span.first < widest->first + widest->count;
    if (inside) {
      findings.add(Lint::kInsideArray, span.global->variable.at, {},
                   fmt::format("{} lies in the array of {} at {}, and is a variable of its own: neither has what is "
                               "written to the other",
                               span.address, widest->count, widest->address),
                   fmt::format("name element {} of the array, counted from 0, or give one of them another address",
                               span.first - widest->first));
    }
    if (widest == nullptr || !widest->is_with(span) || span.first + span.count > widest->first + widest->count)
      widest = &span;
  }
}

}  // namespace

void lint_declarations(const Module& module, Findings& findings) {
  look_at_names(module, findings);
  look_at_arrays(module, findings);
  for (const Global& global : module.globals) look_at_address(global, findings);
}

}  // namespace plc::ir
