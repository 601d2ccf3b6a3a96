// make(): what the POUs of a project look like.
//
// In: bodies as plcopen, sources and frontend-st read them. Out: bytecode::Drawings, for images and pictures: places as
// the file has them where they can be used, else laid out by rule; the same bodies give the same drawings. Does not
// belong here: what runs, pictures, values.
#pragma once

#include <string>
#include <vector>

#include "bytecode/drawings.h"
#include "bytecode/image.h"
#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::drawings {

/// The bodies of a POU, an action or a transition that messages and images call `name`. `places` knows the file they
/// are in; nothing is reported. `has_plane`: positions count in one plane for a whole body (not in IEC 61131-10, which
/// counts them for each network).
std::vector<bytecode::DrawnBody> make_bodies(const plcopen::Pou& pou, const std::string& name,
                                             bytecode::DrawnOwner owner, bool has_plane,
                                             const core::Diagnostics& places);

/// Everything in a project whose bodies have not been released: the POUs in its order, each with its actions and
/// transitions behind it.
bytecode::Drawings make(const plcopen::Project& project, const core::Diagnostics& places);

/// "Main.Start"
std::string part_name(const plcopen::Pou& pou, const plcopen::Pou& part);
bytecode::DrawnOwner owner_of(plcopen::PouKind kind);

}  // namespace plc::drawings
