// lower_project(): the bodies that a project runs become IR.
//
// In: a declared module and the project that it was declared from. Out: bodies of all POUs of the project and of what
// they reach in libraries, stubs in place of what is not compiled; every problem reported. Does not belong here: how
// one body is lowered (frontend-*).
#pragma once

#include <functional>
#include <string>

#include "bytecode/drawings.h"
#include "core/diagnostics.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::compiler {

/// Takes what the file says of a POU, action or transition before its bodies are released; `name` is that of its code.
using BodySink = std::function<void(const plcopen::Pou& pou, const std::string& name, bytecode::DrawnOwner owner)>;

/// `stub_missing`: POUs that cannot be compiled become stubs. `declares_library`: POUs of the project were declarations
/// of what the standard library has. Bodies of the project are released once they are lowered; `sink`, if there is one,
/// sees each of them before.
void lower_project(plcopen::Project& project, ir::Module& module, bool stub_missing, bool declares_library,
                   core::Diagnostics& diagnostics, const BodySink& sink = {});

}  // namespace plc::compiler
