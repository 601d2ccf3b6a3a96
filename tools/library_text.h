// The standard library in words: what belongs together, signatures, types, events, examples. `plc lib`, the pages of
// docs/reference and the library for editors say the same, because they say it from here.
//
// In: rows of stdlib/. Out: words and lists of rows. Does not belong here: columns, Markdown, XML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stdlib/library.h"
#include "stdlib/specials.h"

namespace plc::tools {

/// Rows of one group with one summary: a function with its typed forms (ADD_TIME, ADD_LTIME), a block with its own
/// (TON, TON_TIME). Of one kind only.
struct LibraryTopic {
  std::string_view group;  ///< title of the group
  std::vector<const stdlib::FunctionSpec*> functions;
  std::vector<const stdlib::BundleSpec*> bundles;
  std::vector<const stdlib::BlockSpec*> blocks;
  std::vector<const stdlib::SpecialSpec*> specials;

  [[nodiscard]] std::string_view summary() const;
  /// As people write them, each once; families by their pattern ("*_TO_*").
  [[nodiscard]] std::vector<std::string_view> names() const;
};

/// Everything there is: groups of functions, then what the front ends know by name, then groups of blocks.
std::vector<LibraryTopic> library_topics();

/// Title of the group of the function or block called `name`, in any letter case; empty when there is none.
std::string_view group_of(std::string_view name);

/// True for the name of a family, whose overloads have names of their own: "*_TO_*".
bool is_family(const stdlib::FunctionSpec& spec);

/// A function row as callers meet it under one name: the name of the row, or that of one member of a family.
struct LibraryFunction {
  const stdlib::FunctionSpec* spec = nullptr;
  std::string name;                                ///< "ADD", "*_TO_*", "DINT_TO_REAL"
  std::vector<const stdlib::Overload*> overloads;  ///< of this row under this name, at least one

  /// "LIMIT(MN: T, IN: T, MX: T) : T", "DINT_TO_REAL(IN: DINT) : REAL".
  [[nodiscard]] std::string signature() const;
  /// "T: ANY_INT, BOOL", one line for each type variable of the signature.
  [[nodiscard]] std::vector<std::string> type_lines() const;
  /// What calls can report: strings alone can be truncated.
  [[nodiscard]] stdlib::EventSet events() const;
  /// Those of the row, or those that call the member.
  [[nodiscard]] std::vector<stdlib::Example> examples() const;
};
LibraryFunction library_function(const stdlib::FunctionSpec& spec);
/// "SPLIT_DATE(IN: DATE, YEAR => INT, MONTH => INT, DAY => INT)".
std::string signature(const stdlib::BundleSpec& bundle);
/// The rows that `name` means, in any letter case: of this name, the family with this pattern, or families with such a
/// member.
std::vector<LibraryFunction> functions_named(std::string_view name);

/// "ANY_NUM", "ANY_INT, BOOL": the fewest generic types of the standard, then single ones, that make up `types`.
std::string generic_text(std::vector<core::TypeId> types);
/// "divide_by_zero", "out_of_range", ..
std::vector<std::string_view> event_names(stdlib::EventSet events);
/// "divide_by_zero, out_of_range; ENO is FALSE after one", "none; ENO is as EN".
std::string events_text(stdlib::EventSet events);
/// "T = DINT, U = REAL"; empty where the row has no type variable.
std::string example_types(const stdlib::FunctionSpec& spec, const stdlib::Example& example);
/// "255", or "255 and the event out_of_range".
std::string example_result(const stdlib::Example& example);

/// Lines of cells of a block's example; the first names the columns, "|" parts inputs from outputs.
std::vector<std::vector<std::string>> example_cells(const stdlib::BlockExample& example);

/// "input", "output", "in-out", "state".
std::string_view direction_word(stdlib::Direction direction);

/// Other names that begin alike (ADD for ADD_TIME, TON_LTIME for TON), without those of families.
std::vector<std::string_view> related_names(std::string_view name);

/// "ADD, ADD_TIME, ADD_LTIME".
std::string joined(const std::vector<std::string_view>& names);

}  // namespace plc::tools
