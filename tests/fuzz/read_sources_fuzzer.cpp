// Any bytes as a source file of TwinCAT, as a .plcproj and as an .EXP file: read, declared, lowered, checked, or
// refused with a message.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "sources/export_file.h"
#include "sources/object_file.h"
#include "sources/object_project.h"
#include "sources/plcproj.h"
#include "tests/fuzz/compile_project.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  {
    core::Diagnostics diagnostics;
    auto file = sources::read_object_memory(bytes, "input.TcPOU", diagnostics);
    if (!file && !diagnostics.has_errors()) std::abort();
    if (file) {
      plcopen::Project project = sources::to_project(std::move(*file), {"Tc2_Standard"}, diagnostics);
      sources::report_attributes(project, diagnostics);
      test::compile_project(project, diagnostics);
    }
  }
  {
    core::Diagnostics diagnostics;
    if (!sources::read_plcproj_memory(bytes, "input.plcproj", diagnostics) && !diagnostics.has_errors()) std::abort();
  }
  core::Diagnostics diagnostics;
  const auto project = sources::read_export_memory(bytes, "input.exp", diagnostics);
  if (project == nullptr && !diagnostics.has_errors()) std::abort();
  if (project != nullptr) test::compile_project(*project, diagnostics);
  return 0;
}
