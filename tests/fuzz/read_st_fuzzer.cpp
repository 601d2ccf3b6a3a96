// Any text as an .st file: it is read, declared, lowered, checked, generated and verified, or refused with a message.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "frontend-st/read.h"
#include "tests/fuzz/compile_project.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static_cast<void>(st::looks_like_text(text));
  core::Diagnostics diagnostics;
  const auto project = st::read_memory(text, "input.st", diagnostics);
  if (project == nullptr) {
    if (!diagnostics.has_errors()) std::abort();
    return 0;
  }
  for (const plcopen::Pou& pou : project->pous) {
    if (pou.name.empty() || pou.at.line == 0 || pou.bodies.size() != 1) std::abort();
    for (const plcopen::Variable& variable : pou.variables) {
      if (variable.name.empty() || variable.at.line == 0 || variable.at.column == 0) std::abort();
    }
  }
  test::compile_project(*project, diagnostics);
  return 0;
}
