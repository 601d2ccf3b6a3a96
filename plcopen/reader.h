// plcopen::read: XML file -> Project, in one pass over the bytes; no DOM, no network, no entities.
//
// In: a file or its bytes, limits. Out: Project with places and an account of every element; diagnostics P1xxx.
// Does not belong here: what names, types and drawings mean (frontend-*).
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::plcopen {

/// What a file may cost. Beyond a limit reading stops with a diagnostic; nothing is half-loaded.
struct ReadLimits {
  std::size_t max_bytes = std::size_t{512} << 20;
  std::size_t max_depth = 256;                   ///< nesting of XML elements
  std::size_t max_elements = 20'000'000;         ///< XML elements in the file
  std::size_t max_attributes = 1000;             ///< attributes of one XML element, and namespaces in scope
  std::size_t max_name = 1024;                   ///< bytes (UTF-8) of one identifier
  std::size_t max_text = std::size_t{16} << 20;  ///< bytes (UTF-8) of one text: an ST body, an expression, a note
};

/// Reads a PLCopen XML file: TC6 1.01, 2.00, 2.01 or the IEC 61131-10 spelling, with the dialects of
/// plcopen/SUPPORT.md. Reports every problem found (P1xxx), not only the first. Null when the file is not a readable
/// project; a Project with errors reported beside it is still complete as far as it could be read.
std::unique_ptr<Project> read(const std::string& path, core::Diagnostics& diagnostics, const ReadLimits& limits = {});

/// The same from memory; `name` appears in messages.
std::unique_ptr<Project> read_memory(std::string_view xml, const std::string& name, core::Diagnostics& diagnostics,
                                     const ReadLimits& limits = {});

}  // namespace plc::plcopen
