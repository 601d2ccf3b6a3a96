// What the commands share: compile options as flags, durations, reading and writing of whole files.
//
// In: commands (cli.h). Out: options filled in. Does not belong here: what a command does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/image_file.h"
#include "core/duration.h"
#include "core/options.h"
#include "core/result.h"
#include "runtime/program.h"
#include "tools/cli.h"

namespace plc::tools {

using compiler::can_open;
using compiler::describe;
using compiler::is_image_path;
using compiler::kMaxImageBytes;
using compiler::load_image;

/// Adds --order, --compat, --profile, --coherence, --stub-missing and, where one POU can run alone, --pou. The options
/// must outlive the parsing.
void add_compile_options(Command command, core::CompileOptions& options, bool with_pou = true);

/// Adds --all; part of add_compile_options().
void add_all_option(Command command, core::CompileOptions& options);

/// Adds --lib, which may be repeated. The list must outlive the parsing.
void add_library_option(Command command, std::vector<std::string>& libraries);

/// The compile options that are not by default and the libraries, as arguments: "--lib", "drives.st".
std::vector<std::string> compile_arguments(const core::CompileOptions& options,
                                           const std::vector<std::string>& libraries);
/// The same, to be put after a command in a shell: " --lib drives.st".
std::string compile_flags(const core::CompileOptions& options, const std::vector<std::string>& libraries);
/// A word as a shell takes it: in quotes when it must be.
std::string shell_word(const std::string& word);

/// True when any compile option or library was given: an image carries its own.
bool has_compile_options(Command command);

/// What is wrong with a text that should be 1, 2, 3, .. up to 64 bits, for Flag::check().
std::string wrong_count(const std::string& text);
/// The same, of a text that names a file.
std::string wrong_file_name(const std::string& text);

/// Adds --loop-budget. The options must outlive the parsing.
void add_loop_budget(Command command, runtime::ProgramOptions& options);

/// Refuses compile options for an image. The exit code then.
std::optional<int> refuse_options_of_image(Command command, const std::string& path);

/// A problem of set-up code, as diagnostics look: "error P7101: message".
void complain(const core::Problem& problem);

/// kExitUsage for a file that cannot be opened or written, kExitErrors for one with wrong contents.
int exit_code_of(const core::Problem& problem);
/// A whole program: exceptions are complaints, with kExitErrors.
int guarded(const char* command, int (*run)(int, char**), int argc, char** argv);
/// Flushes stdout; complains and returns kExitUsage when something written there was lost, else `code`.
int close_output(std::string_view command, int code);

using core::parse_duration_ns;
/// "1 error", "3 errors".
std::string counted(std::size_t count, const char* word);
/// "20ms", "1.5us", "2s": at most four significant digits.
std::string duration_text(double ns);

/// Lines of cells as columns, left aligned and two blanks apart, after `indent` blanks.
std::string columns_text(const std::vector<std::vector<std::string>>& lines, std::size_t indent = 0);

/// Replaces the file by `bytes` in one step; false, with errno's words in `why`, when that fails.
bool write_file(const std::string& path, std::string_view bytes, std::string& why);

}  // namespace plc::tools
