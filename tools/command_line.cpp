#include "tools/command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <iterator>
#include <new>

#include "core/text.h"

namespace plc::tools {
namespace {

/// "--order": the flag of a row of core/options.h.
template <class Row>
std::string flag_of(const Row& row) {
  return fmt::format("--{}", row.name);
}

struct Unit {
  std::string_view name;
  double ns;
};

}  // namespace

void add_compile_options(Command command, core::CompileOptions& options, bool with_pou) {
  const Command stored = command.under("Compile options (stored in the image)");
  core::for_each_choice([&]<class E>(const core::Choice<E>& choice) {
    Command::Words<E> words;
    for (std::size_t i = 0; i < choice.words.size(); ++i) words.emplace_back(choice.words[i], static_cast<E>(i));
    stored.choice(flag_of(choice), options.*choice.value, words, std::string(choice.help));
  });
  for (const core::Switch& row : core::kSwitches)
    (row.stored ? stored : command).flag(flag_of(row), options.*row.value, std::string(row.help));
  for (const core::Texts& row : core::kTexts) {
    stored.option(fmt::format("{}={}", flag_of(row), row.value_name), options.*row.value, std::string(row.help))
        .repeated(false)
        .check([wrong = row.wrong](const std::string& text) { return wrong(text); });
  }
  add_all_option(command, options);
  if (with_pou) {
    stored.option("--pou=NAME", options.pou,
                  "run this program or function block alone in a 20 ms task, its instance named like it");
  }
}

void add_all_option(Command command, core::CompileOptions& options) {
  command.flag("--all", options.show_all,
               fmt::format("print all warnings and notes, not {} of one code and the number of the others",
                           core::Diagnostics::kMaxShown));
}

void add_library_option(Command command, std::vector<std::string>& libraries) {
  command
      .option("--lib=FILE", libraries,
              "ST or PLCopen XML file whose data types, POUs and globals join the project; may be repeated. What the "
              "project declares itself counts")
      .repeated(false);
}

bool has_compile_options(Command command) {
  std::vector<std::string> flags = {"--pou", "--lib"};
  core::for_each_choice([&](const auto& choice) { flags.push_back(flag_of(choice)); });
  for (const core::Switch& row : core::kSwitches) flags.push_back(flag_of(row));
  for (const core::Texts& row : core::kTexts) flags.push_back(flag_of(row));
  return std::any_of(flags.begin(), flags.end(), [command](const std::string& flag) { return command.gives(flag); });
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=@%+,";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::vector<std::string> compile_arguments(const core::CompileOptions& options,
                                           const std::vector<std::string>& libraries) {
  const core::CompileOptions usual;
  std::vector<std::string> words;
  core::for_each_choice([&](const auto& choice) {
    if (options.*choice.value != usual.*choice.value)
      words.push_back(fmt::format("{}={}", flag_of(choice), word_of(choice, options)));
  });
  for (const core::Switch& row : core::kSwitches) {
    if (options.*row.value) words.push_back(flag_of(row));
  }
  for (const core::Texts& row : core::kTexts) {
    for (const std::string& text : options.*row.value) words.insert(words.end(), {flag_of(row), text});
  }
  if (!options.pou.empty()) words.insert(words.end(), {"--pou", options.pou});
  for (const std::string& library : libraries) words.insert(words.end(), {"--lib", library});
  return words;
}

std::string compile_flags(const core::CompileOptions& options, const std::vector<std::string>& libraries) {
  std::string flags;
  for (const std::string& word : compile_arguments(options, libraries)) flags += " " + shell_word(word);
  return flags;
}

std::string wrong_count(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc{} && end == text.data() + text.size() && value > 0;
  return good ? std::string() : "\"" + text + "\" is not a whole number above 0";
}

std::string wrong_file_name(const std::string& text) { return text.empty() ? "a file without a name" : ""; }

void add_loop_budget(Command command, runtime::ProgramOptions& options) {
  command
      .option("--loop-budget=N", options.loop_budget,
              fmt::format("turns of all loops that one scan of a task may take before it faults; default {}",
                          bytecode::kDefaultLoopBudget))
      .check(wrong_count);
}

std::optional<int> refuse_options_of_image(Command command, const std::string& path) {
  if (!is_image_path(path) || !has_compile_options(command)) return std::nullopt;
  complain(command.name(), fmt::format("{} is an image: its compile options and libraries are stored in it", path),
           "compile the project file again with other options, or omit the options");
  return kExitUsage;
}

void complain(const core::Problem& problem) {
  std::cerr << "error " << core::info(problem.code).name << ": " << problem.message << '\n';
  if (!problem.help.empty()) std::cerr << "  help: " << problem.help << '\n';
}

int exit_code_of(const core::Problem& problem) {
  const bool file = problem.code == core::Code::P7001 || problem.code == core::Code::P7203;
  return file ? kExitUsage : kExitErrors;
}

int guarded(const char* command, int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    complain(command, "error P5001: the project needs more memory than this machine gives",
             "look for arrays and instances of great size: plc explain P5001");
  } catch (const std::exception& error) {
    complain(command, std::string("internal error P9001: ") + error.what(),
             "please report this with the file that caused it");
  }
  return kExitErrors;
}

int close_output(std::string_view command, int code) {
  std::cout.flush();
  const bool lost = !std::cout || std::fflush(stdout) != 0;
  if (!lost) return code;
  complain(command, "standard output cannot be written");
  return kExitUsage;
}

std::string counted(std::size_t count, const char* word) {
  return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

std::string duration_text(double ns) {
  constexpr Unit kShown[] = {{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}};
  for (const Unit& unit : kShown) {
    if (ns >= unit.ns) return fmt::format("{:.4g}{}", ns / unit.ns, unit.name);
  }
  return fmt::format("{:.4g}ns", ns);
}

std::string columns_text(const std::vector<std::vector<std::string>>& lines, std::size_t indent) {
  std::vector<std::size_t> widths;
  for (const auto& cells : lines) {
    widths.resize(std::max(widths.size(), cells.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], cells[i].size());
  }
  std::string text;
  for (const auto& cells : lines) {
    std::string line(indent, ' ');
    for (std::size_t i = 0; i < cells.size(); ++i) line += fmt::format("{:<{}}  ", cells[i], widths[i]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return text;
}

bool write_file(const std::string& path, std::string_view bytes, std::string& why) {
  // WHY not rename for what is no plain file: /dev/stdout and pipes are written in place.
  const bool in_place = path.rfind("/dev/", 0) == 0;
  const std::string target = in_place ? path : fmt::format("{}.{}.tmp", path, ::getpid());
  std::FILE* file = std::fopen(target.c_str(), "wb");
  if (file == nullptr) {
    why = std::strerror(errno);
    return false;
  }
  bool good = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  good = std::fflush(file) == 0 && good;
  if (!good) why = std::strerror(errno);
  static_cast<void>(std::fclose(file));
  if (good && !in_place && std::rename(target.c_str(), path.c_str()) != 0) {
    why = std::strerror(errno);
    good = false;
  }
  if (!good && !in_place) static_cast<void>(std::remove(target.c_str()));
  return good;
}

}  // namespace plc::tools
