// Objects of TwinCAT's source files to a Project: heads, variables and types are read as text, bodies stay text.
//
// In: ObjectFile, namespaces of libraries. Out: a Project grows; P1201 to P1206 and those of frontend-st. Does not
// belong here: XML (object_file.h), which files belong to a project (folder.h).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"
#include "sources/object_file.h"

namespace plc::sources {

/// The objects of a file as a project of their own. `namespaces` are those of libraries: "Tc2_Standard.TON" is TON.
/// `defines` as those of st::read().
plcopen::Project to_project(ObjectFile file, const std::vector<std::string>& namespaces, core::Diagnostics& diagnostics,
                            const std::vector<std::string>& defines = {});

/// Everything of `part` joins `whole`. Counts of the import report add up.
void merge(plcopen::Project& whole, plcopen::Project&& part);

/// `text` of ST with blanks in place of names of libraries and the dot after them: places stay what they are.
std::string without_namespaces(std::string text, const std::vector<std::string>& namespaces);

/// Says of each attribute that changes what a program does elsewhere that it has no such effect here (P1206).
void report_attributes(const plcopen::Project& project, core::Diagnostics& diagnostics);

}  // namespace plc::sources
