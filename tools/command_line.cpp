#include "tools/command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <iterator>
#include <map>

#include "core/guess.h"
#include "core/text.h"

namespace plc::tools {
namespace {

constexpr const char* kCompileGroup = "Compile options (stored in the image)";

template <class Enum>
void add_choice(CLI::App& app, const std::string& name, Enum& target, const std::map<std::string, Enum>& choices,
                const std::string& help) {
  app.add_option(name, target, help)->transform(choice_validator(choices))->group(kCompileGroup);
}

std::pair<const std::string, core::Coherence> named(core::Coherence coherence) {
  return {std::string(coherence_name(coherence)), coherence};
}

struct Unit {
  std::string_view name;
  double ns;
};

}  // namespace

void add_compile_options(CLI::App& app, core::CompileOptions& options, bool with_pou) {
  add_choice<core::Order>(app, "--order", options.order,
                          {{"drawing", core::Order::kDrawing}, {"document", core::Order::kDocument}},
                          "drawing: top to bottom as drawn (default). document: as the file lists the elements");
  add_choice<core::Compat>(
      app, "--compat", options.compat, {{"none", core::Compat::kNone}, {"beremiz", core::Compat::kBeremiz}},
      "none: one value per wire (default). beremiz: contacts are read again for every coil, and edges are "
      "its own");
  add_choice<core::AddressProfile>(
      app, "--profile", options.profile,
      {{"separate", core::AddressProfile::kSeparate}, {"overlay", core::AddressProfile::kOverlay}},
      "separate: %IX, %IB, %IW are independent (default). overlay: %IW0 contains %IX0.0 to %IX1.7");
  add_choice<core::Coherence>(
      app, "--coherence", options.coherence,
      {named(core::Coherence::kWaitFree), named(core::Coherence::kPriorityCeiling),
       named(core::Coherence::kGlobalLock)},
      "how tasks exchange globals. wait-free: nobody waits (default). priority-ceiling: group by group at raised "
      "priority, all tasks on one processor. global-lock: one lock around every exchange");
  app.add_flag("--stub-missing", options.stub_missing,
               "POUs, blocks and types that cannot be compiled become stubs that do nothing; each is named")
      ->group(kCompileGroup);
  app.add_flag(
      "--strict", options.strict,
      "idioms that other tools take and the standard does not know are errors (plc check names them in notes)");
  add_all_option(app, options);
  if (with_pou) {
    app.add_option("--pou", options.pou,
                   "run this program or function block alone in a 20 ms task, its instance named like it")
        ->type_name("NAME")
        ->group(kCompileGroup);
  }
}

void add_all_option(CLI::App& app, core::CompileOptions& options) {
  app.add_flag("--all", options.show_all,
               fmt::format("print all warnings and notes, not {} of one code and the number of the others",
                           core::Diagnostics::kMaxShown));
}

void add_library_option(CLI::App& app, std::vector<std::string>& libraries) {
  app.add_option(
         "--lib", libraries,
         "ST or PLCopen XML file whose data types, POUs and globals join the project; may be repeated. What the "
         "project declares itself counts")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
}

bool has_compile_options(const CLI::App& app) {
  for (const char* name :
       {"--order", "--compat", "--profile", "--coherence", "--stub-missing", "--strict", "--pou", "--lib"}) {
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option != nullptr && option->count() > 0) return true;
  }
  return false;
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
  if (options.order != usual.order)
    words.emplace_back(options.order == core::Order::kDrawing ? "--order=drawing" : "--order=document");
  if (options.compat != usual.compat)
    words.emplace_back(options.compat == core::Compat::kNone ? "--compat=none" : "--compat=beremiz");
  if (options.profile != usual.profile) {
    const bool separate = options.profile == core::AddressProfile::kSeparate;
    words.emplace_back(separate ? "--profile=separate" : "--profile=overlay");
  }
  if (options.coherence != usual.coherence)
    words.push_back(fmt::format("--coherence={}", coherence_name(options.coherence)));
  if (options.stub_missing) words.emplace_back("--stub-missing");
  if (options.strict) words.emplace_back("--strict");
  if (!options.pou.empty()) words.insert(words.end(), {"--pou", options.pou});
  for (const std::string& library : libraries) words.insert(words.end(), {"--lib", library});
  return words;
}

std::string compile_flags(const core::CompileOptions& options, const std::vector<std::string>& libraries) {
  std::string flags;
  for (const std::string& word : compile_arguments(options, libraries)) flags += " " + shell_word(word);
  return flags;
}

const CLI::Validator& count_validator() {
  static const CLI::Validator kCount(
      [](const std::string& text) {
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool good = error == std::errc{} && end == text.data() + text.size() && value > 0;
        return good ? std::string() : "\"" + text + "\" is not a whole number above 0";
      },
      "");
  return kCount;
}

void add_loop_budget(CLI::App& app, runtime::ProgramOptions& options) {
  app.add_option("--loop-budget", options.loop_budget,
                 fmt::format("turns of all loops that one scan of a task may take before it faults; default {}",
                             bytecode::kDefaultLoopBudget))
      ->type_name("N")
      ->check(count_validator());
}

namespace {

/// The first flag that was given and is none.
std::optional<std::string> unknown_flag(const CLI::App& app) {
  for (const std::string& argument : app.remaining(true)) {
    if (argument.size() > 1 && argument.front() == '-') return argument.substr(0, argument.find('='));
  }
  return std::nullopt;
}

}  // namespace

std::optional<int> parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      app.exit(error, std::cout, std::cerr);
      return kExitOk;
    }
    const CLI::App* deepest = &app;
    while (!deepest->get_subcommands().empty()) deepest = deepest->get_subcommands().front();
    const std::string command = command_name(*deepest);
    const auto commands = deepest->get_subcommands([](const CLI::App*) { return true; });
    if (!commands.empty() && argc > 1 && argv[1][0] != '-') {
      core::Guess guess(argv[1]);
      for (const CLI::App* known : commands) guess.offer(known->get_name());
      const std::string help = guess.help();
      complain(command, fmt::format("there is no command \"{}\"", argv[1]),
               help.empty() ? fmt::format("{} --help lists them", command) : help);
      return kExitUsage;
    }
    const std::string help = fmt::format("{} --help shows every flag with examples", command);
    if (const auto flag = unknown_flag(app)) {
      // Said before what may be missing: a misspelt flag is why it is.
      const std::size_t dashes = std::min(flag->find_first_not_of('-'), flag->size());
      core::Guess guess(std::string_view(*flag).substr(dashes));
      for (const CLI::Option* known : deepest->get_options()) {
        for (const std::string& name : known->get_lnames()) guess.offer(name);
      }
      const std::string& similar = guess.best();
      complain(command, fmt::format("there is no flag {}", *flag),
               similar.empty() ? help : fmt::format("did you mean \"--{}\"? {}", similar, help));
      return kExitUsage;
    }
    complain(command, error.what(), help);
    return kExitUsage;
  }
}

std::optional<int> refuse_options_of_image(const CLI::App& app, const std::string& path) {
  if (!is_image_path(path) || !has_compile_options(app)) return std::nullopt;
  complain(command_name(app), fmt::format("{} is an image: its compile options and libraries are stored in it", path),
           "compile the project file again with other options, or omit the options");
  return kExitUsage;
}

std::string command_name(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* parent = app.get_parent(); parent != nullptr; parent = parent->get_parent()) {
    name = parent->get_name() + " " + name;
  }
  return name;
}

void complain(std::string_view command, std::string_view message, std::string_view help) {
  std::cerr << command << ": " << message << '\n';
  if (!help.empty()) std::cerr << "  help: " << help << '\n';
}

void complain(const core::Problem& problem) {
  std::cerr << "error " << core::info(problem.code).name << ": " << problem.message << '\n';
  if (!problem.help.empty()) std::cerr << "  help: " << problem.help << '\n';
}

int exit_code_of(const core::Problem& problem) {
  const bool file = problem.code == core::Code::P7001 || problem.code == core::Code::P7203;
  return file ? kExitUsage : kExitErrors;
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
  std::fclose(file);
  if (good && !in_place && std::rename(target.c_str(), path.c_str()) != 0) {
    why = std::strerror(errno);
    good = false;
  }
  if (!good && !in_place) std::remove(target.c_str());
  return good;
}

}  // namespace plc::tools
