// Which tests there are: files and folders of a command line -> units, each with one project.
//
// In: a path. Out: cases (folders with project and table), and projects with the files whose tests are of them. The
// file pump_test.st holds tests of pump.xml, pump.st, pump.plcproj or pump.EXP beside it; tests in any other text are
// of that text itself. Does not belong here: compiling, running.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace plc::tests {

struct Unit {
  bool is_case = false;
  std::string path;                ///< of the project, or of the folder of the case
  std::vector<std::string> files;  ///< of tests, beside what the project itself has
};

/// What stands before ".st" in the name of a file of tests.
inline constexpr std::string_view kTestSuffix = "_test";

/// True when the text has a TEST block.
bool has_tests(std::string_view text);

/// Units of the paths, each once, by path. Folders are looked through, those whose name begins with a dot apart. P7001
/// for a path that is not there, and for a file that cannot be read.
core::Result<std::vector<Unit>> find_units(const std::vector<std::string>& paths);

}  // namespace plc::tests
