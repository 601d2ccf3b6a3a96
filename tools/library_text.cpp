#include "tools/library_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/text.h"

namespace plc::tools {
namespace {

using core::TypeId;
using stdlib::Event;

void add_once(std::vector<std::string_view>& names, std::string_view name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// The generic types of the standard (figure 5), larger ones first.
struct Generic {
  std::string_view name;
  std::uint16_t categories;
};
constexpr Generic kGenerics[] = {{"ANY_ELEMENTARY", core::kAnyElementary},
                                 {"ANY_MAGNITUDE", core::kAnyMagnitude},
                                 {"ANY_NUM", core::kAnyNum},
                                 {"ANY_INT", core::kAnyInt},
                                 {"ANY_SIGNED", core::kAnySigned},
                                 {"ANY_UNSIGNED", core::kAnyUnsigned},
                                 {"ANY_REAL", core::kAnyReal},
                                 {"ANY_BIT", core::kAnyBit},
                                 {"ANY_DURATION", core::kAnyDuration},
                                 {"ANY_DATE", core::kAnyDate},
                                 {"ANY_CHARS", core::kAnyChars},
                                 {"ANY_CHAR", core::kAnyChar},
                                 {"ANY_STRING", core::kAnyString}};

std::vector<TypeId> types_in(std::uint16_t categories) {
  std::vector<TypeId> types;
  for (std::size_t i = 0; i < core::kTypeCount; ++i) {
    const auto type = static_cast<TypeId>(i);
    if (core::in_category(type, categories)) types.push_back(type);
  }
  return types;
}

using Variable = TypeId stdlib::Overload::*;

/// Types of a type variable in the overloads, each once, in the order of core/types.def.
std::vector<TypeId> types_of(const LibraryFunction& function, Variable variable) {
  std::vector<TypeId> types;
  for (const stdlib::Overload* overload : function.overloads) types.push_back(overload->*variable);
  std::sort(types.begin(), types.end());
  types.erase(std::unique(types.begin(), types.end()), types.end());
  return types;
}

/// A variable with one type is no variable.
std::string_view type_text(const LibraryFunction& function, stdlib::ParamType type) {
  const stdlib::Overload& first = *function.overloads.front();
  if (type.kind == stdlib::ParamType::Kind::kFixed) return core::name_of(type.fixed);
  const bool is_t = type.kind == stdlib::ParamType::Kind::kT;
  if (types_of(function, is_t ? &stdlib::Overload::t : &stdlib::Overload::u).size() > 1) return is_t ? "T" : "U";
  return core::name_of(first.type_of(type));
}

}  // namespace

std::string_view LibraryTopic::summary() const {
  if (!functions.empty()) return functions.front()->summary;
  if (!bundles.empty()) return bundles.front()->summary;
  return blocks.empty() ? specials.front()->summary : blocks.front()->summary;
}

std::vector<std::string_view> LibraryTopic::names() const {
  std::vector<std::string_view> names;
  for (const stdlib::FunctionSpec* spec : functions) add_once(names, spec->name);
  for (const stdlib::BundleSpec* bundle : bundles) add_once(names, bundle->name);
  for (const stdlib::BlockSpec* block : blocks) add_once(names, block->name);
  for (const stdlib::SpecialSpec* special : specials) add_once(names, special->name);
  return names;
}

std::vector<LibraryTopic> library_topics() {
  std::vector<LibraryTopic> topics;
  std::size_t first = 0;  // topic of the present group
  const auto topic = [&](std::string_view group, std::string_view summary) -> LibraryTopic& {
    const auto found = std::find_if(topics.begin() + static_cast<std::ptrdiff_t>(first), topics.end(),
                                    [summary](const LibraryTopic& t) { return t.summary() == summary; });
    return found != topics.end() ? *found : topics.emplace_back(LibraryTopic{group, {}, {}, {}, {}});
  };
  for (const stdlib::FunctionGroup& group : stdlib::function_groups()) {
    first = topics.size();
    for (const stdlib::FunctionSpec* spec : group.specs) {
      if (!stdlib::is_bundle_output(*spec)) topic(group.title, spec->summary).functions.push_back(spec);
    }
    for (const stdlib::BundleSpec& bundle : stdlib::bundles()) {
      if (group.contains(*bundle.outputs.front())) topic(group.title, bundle.summary).bundles.push_back(&bundle);
    }
  }
  first = topics.size();
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    topic(stdlib::kSpecialsTitle, special.summary).specials.push_back(&special);
  }
  for (const stdlib::BlockGroup& group : stdlib::block_groups()) {
    first = topics.size();
    for (const stdlib::BlockSpec& block : group.blocks) topic(group.title, block.summary).blocks.push_back(&block);
  }
  return topics;
}

std::string_view group_of(std::string_view name) {
  const std::vector<LibraryFunction> functions = functions_named(name);
  const stdlib::BundleSpec* const bundle = stdlib::bundle_named(name);
  const stdlib::FunctionSpec* const row = !functions.empty()  ? functions.front().spec
                                          : bundle != nullptr ? bundle->outputs.front()
                                                              : nullptr;
  for (const stdlib::FunctionGroup& group : stdlib::function_groups()) {
    if (row != nullptr && group.contains(*row)) return group.title;
  }
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    if (core::iequals(special.name, name)) return stdlib::kSpecialsTitle;
  }
  for (const stdlib::BlockGroup& group : stdlib::block_groups()) {
    for (const stdlib::BlockSpec& block : group.blocks) {
      if (core::iequals(block.name, name)) return group.title;
    }
  }
  return {};
}

bool is_family(const stdlib::FunctionSpec& spec) { return spec.name.find('*') != std::string_view::npos; }

LibraryFunction library_function(const stdlib::FunctionSpec& spec) {
  LibraryFunction function{&spec, std::string(spec.name), {}};
  for (const stdlib::Overload& overload : stdlib::overloads()) {
    if (overload.spec == &spec) function.overloads.push_back(&overload);
  }
  return function;
}

namespace {

/// Each output of a bundle has a type of its own: "ANY_INT" says so, where T would be one for all.
std::string output_type_text(const stdlib::FunctionSpec& output) {
  const bool fixed = output.result.kind == stdlib::ParamType::Kind::kFixed;
  return fixed ? std::string(core::name_of(output.result.fixed)) : generic_text(types_in(output.t_categories));
}

}  // namespace

std::string signature(const stdlib::BundleSpec& bundle) {
  std::string text = fmt::format("{}({}: {}", bundle.name, bundle.input.name, core::name_of(bundle.input.type.fixed));
  for (const stdlib::FunctionSpec* output : bundle.outputs) {
    text += fmt::format(", {} => {}", stdlib::output_name(*output), output_type_text(*output));
  }
  return text + ")";
}

std::vector<LibraryFunction> functions_named(std::string_view name) {
  std::vector<LibraryFunction> functions;
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (core::iequals(spec->name, name)) functions.push_back(library_function(*spec));
  }
  if (!functions.empty()) return functions;
  for (const stdlib::Overload& overload : stdlib::overloads_named(name)) {
    if (functions.empty() || functions.back().spec != overload.spec) {
      // A row that is no family has its own name under any other: it is called as it was asked for.
      functions.push_back(
          {overload.spec, is_family(*overload.spec) ? std::string(overload.name) : core::uppered(name), {}});
    }
    functions.back().overloads.push_back(&overload);
  }
  return functions;
}

std::string LibraryFunction::signature() const {
  std::string text = name + '(';
  for (std::size_t i = 0; i < spec->param_count; ++i) {
    text += fmt::format("{}{}: {}", i == 0 ? "" : ", ", spec->params[i].name, type_text(*this, spec->params[i].type));
  }
  return text + fmt::format("{}) : {}", spec->extensible ? ", .." : "", type_text(*this, spec->result));
}

std::vector<std::string> LibraryFunction::type_lines() const {
  std::vector<std::string> lines;
  const auto add = [&](char letter, std::uint16_t categories, Variable variable) {
    std::vector<TypeId> types = categories != 0 ? types_of(*this, variable) : std::vector<TypeId>{};
    if (types.size() > 1) lines.push_back(fmt::format("{}: {}", letter, generic_text(std::move(types))));
  };
  add('T', spec->t_categories, &stdlib::Overload::t);
  add('U', spec->u_categories, &stdlib::Overload::u);
  return lines;
}

stdlib::EventSet LibraryFunction::events() const {
  stdlib::EventSet events = spec->events;
  const bool strings = std::any_of(overloads.begin(), overloads.end(), [](const stdlib::Overload* overload) {
    return core::in_category(overload->result_type(), core::kAnyString);
  });
  if (!strings) events.bits &= static_cast<std::uint16_t>(~stdlib::events(Event::kTruncated).bits);
  return events;
}

std::vector<stdlib::Example> LibraryFunction::examples() const {
  std::vector<stdlib::Example> examples;
  for (const stdlib::Example& example : spec->examples) {
    const std::string_view called = example.call.substr(0, example.call.find('('));
    if (name == spec->name || core::iequals(called, name)) examples.push_back(example);
  }
  return examples;
}

std::string generic_text(std::vector<TypeId> types) {
  std::vector<std::string_view> words;
  const auto holds = [&types](TypeId type) { return std::find(types.begin(), types.end(), type) != types.end(); };
  for (const Generic& generic : kGenerics) {
    const std::vector<TypeId> members = types_in(generic.categories);
    // A generic type of one member says less than its name.
    if (members.size() < 2 || !std::all_of(members.begin(), members.end(), holds)) continue;
    words.push_back(generic.name);
    std::erase_if(types, [&generic](TypeId type) { return core::in_category(type, generic.categories); });
  }
  for (const TypeId type : types) words.push_back(core::name_of(type));
  return joined(words);
}

std::vector<std::string_view> event_names(stdlib::EventSet events) {
  std::vector<std::string_view> names;
  for (const Event event : {Event::kDivideByZero, Event::kOutOfRange, Event::kTruncated, Event::kBadIndex,
                            Event::kNullReference, Event::kInvalid, Event::kBadPointer, Event::kAssertion}) {
    if (events.contains(event)) names.push_back(stdlib::event_name(event));
  }
  return names;
}

std::string events_text(stdlib::EventSet events) {
  return events.empty() ? "none; ENO is as EN" : joined(event_names(events)) + "; ENO is FALSE after one";
}

std::string example_types(const stdlib::FunctionSpec& spec, const stdlib::Example& example) {
  const std::size_t comma = example.types.find(',');
  if (spec.t_categories != 0 && spec.u_categories != 0 && comma != std::string_view::npos) {
    return fmt::format("T = {}, U = {}", example.types.substr(0, comma), example.types.substr(comma + 1));
  }
  if (example.types.empty()) return {};
  return fmt::format("{} = {}", spec.t_categories != 0 ? 'T' : 'U', example.types);
}

std::string example_result(const stdlib::Example& example) {
  constexpr std::string_view kEvent = "event:";
  if (!example.result.starts_with(kEvent)) return std::string(example.result);
  const std::size_t blank = example.result.find(' ');
  return fmt::format("{} and the event {}", example.result.substr(blank + 1),
                     example.result.substr(kEvent.size(), blank - kEvent.size()));
}

std::vector<std::vector<std::string>> example_cells(const stdlib::BlockExample& example) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream in{std::string(example.table)};
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::vector<std::string> cells;
    for (std::string word; words >> word;) cells.push_back(std::move(word));
    if (!cells.empty()) lines.push_back(std::move(cells));
  }
  return lines;
}

std::string_view direction_word(stdlib::Direction direction) {
  switch (direction) {
    case stdlib::Direction::kInput:
      return "input";
    case stdlib::Direction::kOutput:
      return "output";
    case stdlib::Direction::kInOut:
      return "in-out";
    case stdlib::Direction::kState:
      return "state";
  }
  return "";
}

std::vector<std::string_view> related_names(std::string_view name) {
  const auto stem = [](std::string_view text) { return text.substr(0, text.find('_')); };
  std::vector<std::string_view> names;
  const auto offer = [&](std::string_view other) {
    if (core::iequals(stem(other), stem(name)) && !core::iequals(other, name)) add_once(names, other);
  };
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (!is_family(*spec) && !stdlib::is_bundle_output(*spec)) offer(spec->name);
  }
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) offer(bundle.name);
  for (const stdlib::SpecialSpec& special : stdlib::specials()) offer(special.name);
  for (const stdlib::BlockSpec& block : stdlib::blocks()) offer(block.name);
  return names;
}

std::string joined(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) {
    if (!text.empty()) text += ", ";
    text += name;
  }
  return text;
}

}  // namespace plc::tools
