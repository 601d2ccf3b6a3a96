// Any text is lowered as an instruction list and as a condition, or refused: no crash, no hang, and a refusal is
// reported.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "declare/declare.h"
#include "frontend-il/text.h"
#include "frontend-st/read.h"

namespace {

constexpr std::string_view kProject = R"(
FUNCTION f : INT
VAR_INPUT x : INT; END_VAR VAR_IN_OUT io : INT; END_VAR VAR_OUTPUT y : INT; END_VAR
END_FUNCTION
FUNCTION none
VAR_INPUT x : INT; END_VAR
END_FUNCTION
TYPE Pair : STRUCT n : INT; s : STRING; END_STRUCT END_TYPE
PROGRAM p
VAR a, b : BOOL; i, j : INT; r : REAL; t : TIME; w : WORD; s : STRING; k : TON; c : CTU; l : SR; g : ARRAY[0..3] OF INT;
  q : Pair; v : REF_TO INT; END_VAR
END_PROGRAM)";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static plc::core::Diagnostics read;
  static const auto project = plc::st::read_memory(kProject, "project.st", read);
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  plc::core::SourceRef at;
  at.line = 1;
  at.column = 1;
  plc::core::Diagnostics declared;
  const auto module = plc::st::declare(*project, {}, declared);
  plc::core::Diagnostics diagnostics;
  plc::ir::Builder builder(*module, module->pou_by_name.find("p")->second, diagnostics);
  if (!plc::il::lower_instructions(text, at, builder) && !diagnostics.has_errors()) std::abort();
  const std::size_t before = diagnostics.error_count();
  if (!plc::il::lower_value(text, at, builder) && diagnostics.error_count() == before) std::abort();
  return 0;
}
