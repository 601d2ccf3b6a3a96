// Declarations of a Project as text: data types, variables, heads of POUs, configurations, as the standard writes them
// (IEC 61131-3:2013, annex A).
//
// In: a Project with its comments. Out: text. Does not belong here: bodies (body_writer.h), what belongs together
// (write.h).
#pragma once

#include <string>
#include <vector>

#include "convert/body_writer.h"
#include "convert/comments.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::convert {

/// "TYPE Motor : STRUCT .. END_STRUCT; END_TYPE", an empty line after each.
std::string write_types(const std::vector<plcopen::DataType>& types, const Comments& comments);

/// "INT", "ARRAY [1..3] OF REAL", "STRUCT .. END_STRUCT", "REF_TO Motor".
std::string write_type(const plcopen::TypeSpec& type, const Comments& comments);

/// Sections of variables in the order of declaration, each line indented by `indent` blanks.
std::string write_variables(const std::vector<plcopen::Variable>& variables, const Comments& comments,
                            std::size_t indent = 0);

/// Sections for variables that bodies need beside those declared. `in_function`: nothing is kept there.
std::string write_added(const std::vector<AddedVariable>& added, bool in_function);

/// "FUNCTION Share : REAL", with the documentation of the POU as a comment before it.
std::string write_head(const plcopen::Pou& pou, const Comments& comments);

/// Globals, tasks, program instances. Intervals and priorities are those of the module, which understands all
/// spellings.
std::string write_configuration(const plcopen::Configuration& configuration, const ir::Module& module,
                                const Comments& comments);

}  // namespace plc::convert
