// Lowering of texts: bodies in ST; expressions in contacts, coils, pins and variables; statements of EXECUTE boxes.
//
// In: a text with its place in the file, the Builder of the POU it is in. Out: IR through the Builder. Errors P4xxx
// name the line and column inside the XML file. Does not belong here: drawings, declarations (declare.h).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ir/builder.h"
#include "plcopen/project.h"

namespace plc::st {

/// Lowers an expression. `expected` is the type the reader wants, if known (decides untyped literals and enum names).
/// Reports and returns nothing when the text is not a well-typed expression.
std::optional<ir::Operand> lower_expression(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                                            std::optional<ir::TypeRef> expected = std::nullopt);

/// Lowers the text of something that can be written or wired in-out: a variable, member, element or direct address.
/// Array indices may be expressions. Reports constants and inputs only when `for_writing`.
std::optional<ir::PlaceId> lower_place(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                                       bool for_writing);

/// Lowers a statement list (IEC 61131-3:2013, 7.3.3). Recovers at statement ends: every independent error is reported
/// once. False when any was. Pragmas that choose what is compiled (conditions.h) are asked first; `defines` are those
/// that hold where the text begins, null for those of the compile options.
bool lower_statements(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                      const std::vector<std::string>* defines = nullptr);

/// Reads a statement list without looking up a name: reports errors of syntax alone. False when there was any. `pou` is
/// for the messages.
bool check_syntax(std::string_view text, const core::SourceRef& at, std::string_view pou,
                  core::Diagnostics& diagnostics);

/// Lowers the ST bodies of a POU. False when any statement had an error.
bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics);

/// What a body begins with before anything of it is lowered. A POU that declares EN and ENO itself ends at once with
/// ENO FALSE when EN is FALSE, else sets ENO (IEC 61131-3:2013, table 18). References that begin with REF(x) are made
/// in the first execution of an instance, in every execution of a function. Actions begin with the references alone.
void lower_prologue(ir::Builder& builder);

/// Makes the REFERENCE TO at `where` stand for the variable that `text` names. False after an error.
bool lower_binding(ir::PlaceId where, std::string_view text, const core::SourceRef& at, ir::Builder& builder);

/// True when the text is one plain variable name or path (no operators, no literal): what may be written.
bool is_variable_text(std::string_view text);

}  // namespace plc::st
