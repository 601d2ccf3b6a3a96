// Charts as text (IEC 61131-3:2013, 6.7, tables 54 to 57): a chart that is drawn becomes steps, transitions and actions
// in words, from the model that both forms of a chart have.
//
// In: a body in SFC, the POU it belongs to, lowered. Out: text that reads back as the same chart, or the reason why
// there is none. Does not belong here: what a chart does (frontend-sfc).
#pragma once

#include <string>
#include <vector>

#include "convert/body_writer.h"
#include "core/source_ref.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::convert {

struct WrittenChart {
  std::string text;                  ///< steps and transitions, each line indented by two blanks or more
  std::string actions;               ///< ACTION .. END_ACTION of what is written at steps
  std::vector<std::string> remarks;  ///< what is not as it was drawn, as parts of sentences
  std::string problem;               ///< why there is no text, as part of a sentence; or empty
  core::SourceRef at;                ///< of the problem
};

/// Writes the drawn chart `body` of `owner`, or of an action of it, which was lowered as `made`. `name` is that of the
/// body. Variables that the text needs join `added`.
WrittenChart write_chart(const plcopen::Body& body, const plcopen::Pou& owner, const std::string& name,
                         const ir::Module& module, const ir::Pou& made, AddedVariables& added);

}  // namespace plc::convert
