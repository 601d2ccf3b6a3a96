// Tests in a compilation: TEST blocks join the project, are lowered with it, and become an image of their own.
//
// In: a Project with tests. Out: the project's own image as it would be without tests, and a TestImage: one task whose
// program runs the test that it is told to. Tests and project share nothing while they run: in the tests' image stand
// copies of the project's globals, and for each program instance that a test may name a global of its type; who runs
// tests keeps them equal to the project's (testing/mirror.h). Does not belong here: running.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/diagnostics.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::compiler {

/// Names in the image of the tests: its task and program, the number of the test to run, and the instances of tests.
inline constexpr const char* kTestsName = "#tests";
inline constexpr const char* kWhichTest = "which";

struct TestInfo {
  std::string name;       ///< what stands in quotes after TEST
  std::string instance;   ///< name of its instance in the program
  std::uint32_t pou = 0;  ///< as in ir::Assertion
  core::SourceRef at;
};

struct TestImage {
  bytecode::VerifiedImage image;
  std::vector<TestInfo> tests;
  std::vector<ir::Assertion> assertions;
  std::vector<std::string> programs;  ///< program instances that have a copy in the image, a global of their name
  std::vector<plcopen::Pragma> pragmas = {};  ///< of the project and of the files of tests
};

/// Puts the tests of `project` and of `more`, files read by themselves, among its POUs. What else `more` declares joins
/// as of a library.
void add_tests(plcopen::Project& project, std::vector<plcopen::Project> more, core::Diagnostics& diagnostics);

/// Declares what tests see beyond the names of the module, before any body is lowered.
void prepare_tests(const plcopen::Project& project, ir::Module& module, core::Diagnostics& diagnostics);

/// The image of the tests, whose bodies are lowered. The module is fit for nothing else afterwards.
std::optional<TestImage> generate_tests(ir::Module& module, core::Diagnostics& diagnostics);

}  // namespace plc::compiler
