// Choosing in bodies: the text of a body without what its pragmas leave out, with the names that its POU sees.
//
// In: a text, the Builder of the POU it is in. Out: the text that is lowered. Does not belong here: what pragmas mean
// (conditions.h), declarations.
#pragma once

#include <string>
#include <vector>

#include "frontend-st/conditions.h"
#include "frontend-st/source_text.h"
#include "ir/builder.h"

namespace plc::st {

/// What counts of `source`. `defines`: those that hold where it begins, as Defines::entries(); null for those of the
/// compile options.
ChosenText choose(const SourceText& source, ir::Builder& builder, const std::vector<std::string>* defines = nullptr);

}  // namespace plc::st
