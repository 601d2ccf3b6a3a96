// ObjectFile: what a source file of TwinCAT 3 (.TcPOU, .TcGVL, .TcDUT, .TcIO, .TcTTO) holds, as texts with places:
// declarations, bodies, actions, settings of a task. Read in one pass, without a tree.
//
// In: a file. Out: its objects, an account of its elements; P1001 to P1006, P1014, P1207. Does not belong here: what
// the texts declare (object_project.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"
#include "plcopen/reader.h"

namespace plc::sources {

/// A text of a file without the blanks at its ends.
struct Text {
  std::string text;
  core::SourceRef at;  ///< its first character; of the element where it is empty
};

/// A body: its language by the name of the element that holds it ("ST", "NWL"); empty when there is none.
struct Implementation {
  std::string format;
  Text text;  ///< ST
};

/// A part of an object beside its own body. Bodies of methods and properties are not kept.
struct Member {
  enum class Kind : std::uint8_t { kAction, kMethod, kProperty, kTransition };
  Kind kind = Kind::kAction;
  std::string name;
  core::SourceRef at;
  Implementation implementation;  ///< kAction
};

struct Object {
  enum class Kind : std::uint8_t { kPou, kGlobals, kType, kInterface, kTask };
  Kind kind = Kind::kPou;
  std::string name;
  core::SourceRef at;
  std::string special;  ///< SpecialFunc: "CheckBounds"; "None" and absent are empty
  Text declaration;
  Implementation implementation;
  std::vector<Member> members;
  Text cycle_time;          ///< kTask: microseconds
  Text priority;            ///< kTask: 1 is the highest
  std::vector<Text> calls;  ///< kTask: programs, in calling order
};

struct ObjectFile {
  std::string path;
  std::uint16_t file = 0;  ///< index into Diagnostics' files
  std::vector<Object> objects;
  std::vector<plcopen::ReportRow> report;
};

/// Reads a file. Nothing when it cannot be read or is no such file, which was reported.
std::optional<ObjectFile> read_object_file(const std::string& path, core::Diagnostics& diagnostics,
                                           const plcopen::ReadLimits& limits = {});
/// The same from memory; `name` appears in messages.
std::optional<ObjectFile> read_object_memory(std::string_view bytes, const std::string& name,
                                             core::Diagnostics& diagnostics, const plcopen::ReadLimits& limits = {});

/// True for the names of such files, in any letter case.
bool is_object_path(std::string_view path);

}  // namespace plc::sources
