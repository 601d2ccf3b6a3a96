// The library as a PLCopen XML project that editors import, so that blocks they do not know can be drawn in them.
//
// In: rows of stdlib/. Out: XML (TC6 2.01): one POU per row, with its pins, their meaning and a body without
// statements. plc takes such a POU for a declaration of its own row (st::drop_declarations_of_library). Does not belong
// here: files.
#pragma once

#include <span>
#include <string>

#include "stdlib/library.h"
#include "stdlib/specials.h"

namespace plc::tools {

/// The rows that no table of the standard has (is_standard in library_text.h).
std::string library_xml();
/// These rows; families of functions, whose pattern is no name, are left out, and specials that drawings do not need.
std::string library_xml(std::span<const stdlib::FunctionSpec* const> functions,
                        std::span<const stdlib::BundleSpec* const> bundles,
                        std::span<const stdlib::SpecialSpec* const> specials,
                        std::span<const stdlib::BlockSpec* const> blocks);

}  // namespace plc::tools
