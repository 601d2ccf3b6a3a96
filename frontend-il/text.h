// Lowering of instruction lists: bodies in IL, and conditions of transitions.
//
// In: a text with its place in the file, the Builder of the POU it is in. Out: IR through the Builder. Errors P4502 to
// P4506 and those of ST (P4xxx) name the line and column inside the file. Does not belong here: drawings, declarations.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "ir/builder.h"
#include "plcopen/project.h"

namespace plc::il {

/// Lowers an instruction list (IEC 61131-3:2013, 7.2). Every independent error is reported once. False when any was.
/// What is lowered after it goes on where the list ends. `defines` as for st::lower_statements().
bool lower_instructions(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                        const std::vector<std::string>* defines = nullptr);

/// Lowers an instruction list whose meaning is the value in the accumulator at its end, as in the condition of a
/// transition: of whatever way leads there, RET included. Reports and returns nothing when there is an error or no
/// value. The value has the type that was computed; converting it to BOOL is for the caller.
std::optional<ir::Operand> lower_value(std::string_view text, const core::SourceRef& at, ir::Builder& builder);

/// Lowers one body in IL into the one that `builder` makes, after what it has already. False when there was an error.
bool lower_list(const plcopen::Body& body, ir::Builder& builder);

/// Lowers the IL bodies of a POU or an action. False when there was an error.
bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics);

}  // namespace plc::il
