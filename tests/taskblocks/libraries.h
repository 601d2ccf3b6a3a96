// Shared objects of the tests, put where they may be loaded from.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/run_tool.h"

namespace plc::test {

inline void write_text(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

/// Copies the library made of faulty/`name`.cpp into the folder, whatever the permissions of the build are.
inline std::string installed(const ScratchFolder& folder, const std::string& name) {
  const std::string to = folder.file(name + ".so");
  std::filesystem::copy_file(PLC_FAULTY "/" + name + ".so", to, std::filesystem::copy_options::overwrite_existing);
  ::chmod(to.c_str(), 0755);
  return to;
}

/// Fast (10 ms) counts. Bad (50 ms) runs instance faulty.component of `block`, which has GO and OUT and misbehaves from
/// the eleventh scan on.
inline std::string faulty_project(const std::string& block = "FAULTY") {
  return "PROGRAM Counting\n"
         "VAR_EXTERNAL FastCount : DINT; END_VAR\n"
         "  FastCount := FastCount + 1;\n"
         "END_PROGRAM\n"
         "PROGRAM Faulty_\n"
         "VAR component : " +
         block +
         "; Scans : DINT; Result : LREAL; END_VAR\n"
         "  Scans := Scans + 1;\n"
         "  component(GO := Scans > 10);\n"
         "  Result := component.OUT;\n"
         "END_PROGRAM\n"
         "CONFIGURATION C\n"
         "  VAR_GLOBAL FastCount : DINT; END_VAR\n"
         "  RESOURCE R ON PLC\n"
         "    TASK Fast(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "    TASK Bad(INTERVAL := T#50ms, PRIORITY := 1);\n"
         "    PROGRAM counting WITH Fast : Counting;\n"
         "    PROGRAM faulty WITH Bad : Faulty_;\n"
         "  END_RESOURCE\n"
         "END_CONFIGURATION\n";
}

}  // namespace plc::test
