// The steps in order: read, declare, lower every body, check, generate, verify. Each step takes one structure and makes
// the next; this is the only place that knows all of them.
//
// In: a PLCopen XML or ST file and libraries, or an image made earlier, and the compile options. Out: a Compilation
// with everything asked for, and every problem found on the way. Does not belong here: printing, command lines,
// running.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "compiler/image_file.h"
#include "compiler/tests.h"
#include "core/diagnostics.h"
#include "core/options.h"
#include "ir/ir.h"
#include "ir/lint.h"
#include "plcopen/project.h"
#include "taskblocks/registry.h"

namespace plc::compiler {

/// How far to go.
enum class Goal : std::uint8_t {
  kRead,    ///< the Project only
  kModule,  ///< everything that can be compiled is lowered and checked, and stays as it is then
  kCheck,   ///< everything that can be compiled is; a file without instances is fine
  kRun,     ///< an image to run, and nothing else: without any instance that is an error
};

struct Request {
  std::string path;
  core::CompileOptions options;
  Goal goal = Goal::kCheck;
  std::vector<std::string> libraries = {};  ///< files whose data types, POUs and globals join the project
  std::optional<ir::LintOptions> lint{};    ///< lint a project that has no errors; lints that are off stay silent
  const taskblocks::Registry* taskblocks = nullptr;  ///< that the project may use; null = those that come with PICARD
  /// For a command that answers a question about the project: lints that compiling finds stay silent.
  bool answers = false;
  bool tests = false;                        ///< compile the tests of the project, too: Compilation::tests
  std::vector<std::string> test_files = {};  ///< ST files whose tests are of this project
  bool drawings = false;                     ///< put what the POUs look like, and where their values are, into the
                                             ///< image: Image::drawings, Image::probes
  bool coverage = false;                     ///< note what happened (ir/coverage.h): Compilation::cover_sites
};

struct Compilation {
  core::Diagnostics diagnostics;
  bool readable = true;                       ///< false: the file could not be opened at all
  std::unique_ptr<plcopen::Project> project;  ///< bodies are released once lowered; null beside an image to run
  std::unique_ptr<ir::Module> module;         ///< null for images and after code generation; kept for Goal::kModule
  std::optional<bytecode::VerifiedImage> image;
  std::optional<TestImage> tests;          ///< with Request::tests, where there are any
  std::vector<ir::CoverSite> cover_sites;  ///< with Request::coverage: of both images

  [[nodiscard]] bool ok() const { return readable && !diagnostics.has_errors(); }
};

/// Reads a project or library: a folder, or a source file of CODESYS or TwinCAT (sources/folder.h); ST by its ".st" or
/// ".iecst" or because its text begins no XML; else PLCopen XML.
/// Null when it cannot be read. `defines` as CompileOptions::defines.
std::unique_ptr<plcopen::Project> read_project(const std::string& path, core::Diagnostics& diagnostics,
                                               const std::vector<std::string>& defines = {});

/// Runs the steps as far as the request says; stops after a step whose result cannot be worked on.
void compile(const Request& request, Compilation& compilation);

/// Compiles a project file or loads an image, by its name.
void open(const Request& request, Compilation& compilation);

}  // namespace plc::compiler
