// Handlers for types, values and variables that both spellings (TC6 and IEC 61131-10) share.
//
// In: tags, while a variable, data type or POU is open in the Reader. Out: TypeSpec, InitialValue, Variable as written.
// Does not belong here: resolving names, sizes.
#pragma once

#include <string_view>

#include "plcopen/reader_state.h"

namespace plc::plcopen {

/// Type the next type element describes: of the open variable, data type or POU result, or the base of another type.
void push_variable_type(Reader& r, const Tag& tag);
void push_data_type_type(Reader& r, const Tag& tag);
void push_return_type(Reader& r, const Tag& tag);
void push_base_type(Reader& r, const Tag& tag);
void pop_type(Reader& r);

/// Fills `result` from a type as text: "INT", "STRING[20]", "ARRAY [0..9, 1..2] OF Lib\Point", "REF_TO T".
void parse_type_text(std::string_view text, const SourceRef& at, TypeSpec& result);
/// Makes a list of a value that is one simple text with brackets, "[1, 3(0)]" or "(x := 1, y := [2])", as editors keep
/// what was typed. Values of strings, what is no list, and lists of more than a million values stay as they are. The
/// text stays beside the list: the type may have a name that stands for a string, which is not known yet.
void parse_value_text(const TypeSpec& type, InitialValue& value);

void push_variable_value(Reader& r, const Tag& tag);
void push_data_type_value(Reader& r, const Tag& tag);
void push_element_value(Reader& r, const Tag& tag);
void pop_value(Reader& r);
void simple_value(Reader& r, const Tag& tag);
void array_value(Reader& r, const Tag& tag);
void struct_value(Reader& r, const Tag& tag);

void start_data_type(Reader& r, const Tag& tag);
void end_data_type(Reader& r);
void enum_value(Reader& r, const Tag& tag);
void dimension(Reader& r, const Tag& tag);
/// Says what kind the open type is.
template <TypeSpec::Kind kKind>
void type_kind(Reader& r, const Tag&) {
  r.types.back()->kind = kKind;
}
void start_struct(Reader& r, const Tag& tag);
void start_union(Reader& r, const Tag& tag);
void end_var_list(Reader& r);

void start_variable(Reader& r, const Tag& tag);
void end_variable(Reader& r);
void access_variable(Reader& r, const Tag& tag);
void config_variable(Reader& r, const Tag& tag);
void start_text(Reader& r, const Tag& tag);
void drop_text(Reader& r);
void variable_note(Reader& r);

/// Opens a list of variables of `section` that go to `out`.
void push_var_list(Reader& r, const Tag& tag, std::vector<Variable>& out, Section section);
/// globalVars of the open resource or configuration, or of none.
void start_globals(Reader& r, const Tag& tag);
/// The open POU's list for `section`.
template <Section kSection>
void start_pou_list(Reader& r, const Tag& tag) {
  push_var_list(r, tag, r.pous.back()->pou.variables, kSection);
}

}  // namespace plc::plcopen
