// convert::write: a project, however it is drawn or kept, as one text of IEC 61131-3 that compiles to the same.
//
// In: the Project, and the Module that was made from it. Out: text, and what in it is not as it was drawn; P1211. Does
// not belong here: reading (plcopen, sources, frontend-st), comparing images (tools/plc/convert.cpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::convert {

/// Why the image of the text is another one than that of the drawing, though both do the same.
struct Remark {
  std::string pou;   ///< "Main", or "Pump.Start" for an action
  std::string text;  ///< part of a sentence: "keeps 2 values of the drawing in variables"
};

struct WrittenProject {
  std::string text;  ///< UTF-8, lines end with LF
  std::vector<Remark> remarks;
};

/// Writes the project. Bodies in ST and IL are written as they are, drawings as statements. Nothing when a drawing has
/// no form as text, which is reported.
std::optional<WrittenProject> write(const plcopen::Project& project, const ir::Module& module,
                                    core::Diagnostics& diagnostics);

}  // namespace plc::convert
