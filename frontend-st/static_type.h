// The type of what a place names, found without making any instruction: for SIZEOF, and where a value takes the type of
// the variable that it goes to.
//
// In: a syntax tree, the names of a POU. Out: a type. Errors are left to the lowering of the place. Does not belong
// here: types of expressions.
#pragma once

#include <optional>

#include "frontend-st/ast.h"
#include "frontend-st/source_text.h"
#include "ir/ir.h"

namespace plc::st {

/// The type of the place at `id`, as the text of `pou` (or of no POU) sees it. Nothing when it names none.
std::optional<ir::TypeRef> static_type(const Ast& ast, const SourceText& source, NodeId id, const ir::Module& module,
                                       const ir::Pou* pou);

/// Bytes of what `id` names, a place or a type, as CODESYS lays it out. Nothing, and why in `problem`, when it has no
/// such size.
std::optional<std::uint64_t> size_of_named(const Ast& ast, const SourceText& source, NodeId id, ir::Module& module,
                                           const ir::Pou* pou, std::string& problem);

}  // namespace plc::st
