// Declarations as text: .st files -> Project, the same structure that PLCopen XML makes; bodies stay text.
//
// In: a file or its text. Out: Project with places; diagnostics P1001, P1006, P4040 to P4047. Does not belong here:
// what names and types mean (declare.h), statements (text.h).
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::st {

/// Files beyond this are refused.
inline constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;

/// Reads declarations of IEC 61131-3 (third edition, annex A): data types, functions, function blocks, programs,
/// globals, configurations. The text is UTF-8, or UTF-16 with a byte order mark, else Windows-1252. Reports every
/// problem once and continues after it. Null when the file cannot be read at all.
/// `defines`: what pragmas among declarations may ask for ({IF defined (X)}), each "NAME" or "NAME=text".
std::unique_ptr<plcopen::Project> read(const std::string& path, core::Diagnostics& diagnostics,
                                       const std::vector<std::string>& defines = {});

/// The same from memory; `name` appears in messages.
std::unique_ptr<plcopen::Project> read_memory(std::string_view bytes, const std::string& name,
                                              core::Diagnostics& diagnostics,
                                              const std::vector<std::string>& defines = {});

/// Declarations that a tool's XML has as text beside the typed ones: read where the typed interface of the POU or list
/// is empty, else only looked through for pragmas.
void read_plain_declarations(plcopen::Project& project, core::Diagnostics& diagnostics,
                             const std::vector<std::string>& defines = {});

// ---- texts that another reader has taken out of its file; `at` is the place of the first character ----------------

/// Everything that may be in a file of declarations joins the project.
void read_text(std::string_view text, const core::SourceRef& at, plcopen::Project& project,
               core::Diagnostics& diagnostics, const std::vector<std::string>& defines = {});
/// A POU without body and END_: its name, kind, result and variables. What is object-oriented in its head goes to
/// `objects` ("EXTENDS Base") and is no error. False when the text begins no POU, which was reported.
bool read_head(std::string_view text, const core::SourceRef& at, plcopen::Project& project, plcopen::Pou& pou,
               std::vector<std::string>& objects, core::Diagnostics& diagnostics,
               const std::vector<std::string>& defines = {});
/// Globals outside of configurations become a list of this name: with {attribute 'qualified_only'} the name must come
/// before the variables, else it may.
void name_list(plcopen::Project& project, std::string_view name);

/// Variables of lists that need not be named are named with their list where another global goes by their name alone.
void list_shared_names(plcopen::Project& project);

/// True when the first character that is no blank begins no XML.
bool looks_like_text(std::string_view bytes);

}  // namespace plc::st
