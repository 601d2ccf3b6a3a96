// Worksheets: the bodies of one POU, and in which language it is when there are several.
//
// In: a POU as it was read. Out: what its bodies are together. Does not belong here: lowering of any language.
#pragma once

#include "plcopen/project.h"

namespace plc::st {

/// Whether a body has nothing to execute: no language, no element, and no text but comments.
bool is_empty_body(const plcopen::Body& body);

/// The language of a POU's bodies; the first that is not empty decides, and the first at all where all are.
plcopen::Language language_of(const plcopen::Pou& pou);

/// Whether worksheets that are not empty are in several languages. LD and FBD are drawn with the same elements, and are
/// one here.
bool is_mixed(const plcopen::Pou& pou);

}  // namespace plc::st
