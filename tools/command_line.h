// What the commands share: exit codes, compile options as flags, durations, reading and writing of whole files.
//
// In: CLI11 applications. Out: options filled in. Does not belong here: what a command does.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/image_file.h"
#include "core/duration.h"
#include "core/options.h"
#include "core/result.h"
#include "core/text.h"
#include "runtime/program.h"

namespace plc::tools {

using compiler::can_open;
using compiler::describe;
using compiler::is_image_path;
using compiler::kMaxImageBytes;
using compiler::load_image;

/// Exit codes, the same for every command.
inline constexpr int kExitOk = 0;
inline constexpr int kExitErrors = 1;  ///< the input has errors, or a program faulted
inline constexpr int kExitUsage = 2;   ///< wrong flags, or a file that cannot be opened or written

/// Adds --order, --compat, --profile, --coherence, --stub-missing and, where one POU can run alone, --pou. The options
/// must outlive the parsing.
void add_compile_options(CLI::App& app, core::CompileOptions& options, bool with_pou = true);

/// Adds --all; part of add_compile_options().
void add_all_option(CLI::App& app, core::CompileOptions& options);

/// Adds --lib, which may be repeated. The list must outlive the parsing.
void add_library_option(CLI::App& app, std::vector<std::string>& libraries);

/// The compile options that are not by default and the libraries, as arguments: "--lib", "drives.st".
std::vector<std::string> compile_arguments(const core::CompileOptions& options,
                                           const std::vector<std::string>& libraries);
/// The same, to be put after a command in a shell: " --lib drives.st".
std::string compile_flags(const core::CompileOptions& options, const std::vector<std::string>& libraries);
/// A word as a shell takes it: in quotes when it must be.
std::string shell_word(const std::string& word);

/// True when any compile option or library was given: an image carries its own.
bool has_compile_options(const CLI::App& app);

/// Words for the values of an enumeration, in any letter case; says which there are otherwise.
template <class Enum>
CLI::Validator choice_validator(std::map<std::string, Enum> choices) {
  return CLI::Validator(
      [choices = std::move(choices)](std::string& text) {
        std::string all;
        for (const auto& [word, value] : choices) {
          if (core::iequals(word, text)) {
            text = std::to_string(static_cast<int>(value));
            return std::string();
          }
          all += (all.empty() ? "" : ", ") + word;
        }
        return text + " is not one of " + all;
      },
      "");
}

/// Accepts 1, 2, 3, .. up to 64 bits, and says so otherwise.
const CLI::Validator& count_validator();

/// Adds --loop-budget. The options must outlive the parsing.
void add_loop_budget(CLI::App& app, runtime::ProgramOptions& options);

/// Parses argv; prints help or what was wrong. The exit code when the program should end now.
std::optional<int> parse(CLI::App& app, int argc, char** argv);

/// Refuses compile options for an image. The exit code then.
std::optional<int> refuse_options_of_image(const CLI::App& app, const std::string& path);

/// "plc config check": the command with those it belongs to.
std::string command_name(const CLI::App& app);
/// Prints "command: message" and "help: ..." on stderr.
void complain(std::string_view command, std::string_view message, std::string_view help = {});
/// A problem of set-up code, as diagnostics look: "error P7101: message".
void complain(const core::Problem& problem);

/// kExitUsage for a file that cannot be opened or written, kExitErrors for one with wrong contents.
int exit_code_of(const core::Problem& problem);
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
