#include "tools/cli.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <iostream>

#include "core/guess.h"
#include "core/text.h"
#include "tools/manual.h"

namespace plc::tools {
namespace {

/// A program's CLI::App.
struct Root final : CLI::App {
  using App::App;
  std::optional<int> exit_code;  ///< of the command that ran
};

Root& root_of(CLI::App& app) {
  return app.get_parent() == nullptr ? static_cast<Root&>(app) : root_of(*app.get_parent());
}

/// The first flag that was given and is none.
std::optional<std::string> unknown_flag(const CLI::App& app) {
  for (const std::string& argument : app.remaining(true)) {
    if (argument.size() > 1 && argument.front() == '-') return argument.substr(0, argument.find('='));
  }
  return std::nullopt;
}

}  // namespace

void complain(std::string_view command, std::string_view message, std::string_view help) {
  std::cerr << command << ": " << message << '\n';
  if (!help.empty()) std::cerr << "  help: " << help << '\n';
}

Flag Flag::required() const { return Flag(option_->required()); }
Flag Flag::repeated(bool dots) const {
  if (!dots) option_->expected(1);
  return Flag(option_->take_all()->allow_extra_args(false));
}
Flag Flag::last() const { return Flag(option_->take_last()); }
Flag Flag::needs(Flag other) const { return Flag(option_->needs(other.option_)); }
Flag Flag::excludes(std::initializer_list<Flag> others) const {
  for (const Flag other : others) option_->excludes(other.option_);
  return *this;
}
Flag Flag::check(const std::function<std::string(const std::string&)>& wrong) const {
  return Flag(option_->check(wrong));
}
Flag Flag::range(int least, int most) const { return Flag(option_->check(CLI::Range(least, most))); }
Flag Flag::range(unsigned least, unsigned most) const { return Flag(option_->check(CLI::Range(least, most))); }
Flag Flag::one_of(const std::vector<std::string>& words) const { return Flag(option_->check(CLI::IsMember(words))); }
Flag Flag::shows_default() const { return Flag(option_->capture_default_str()); }
bool Flag::given() const { return option_->count() != 0; }

std::string Command::name() const { return full_name(*app_); }

Command Command::sub(const std::string& name, const std::string& description) const {
  app_->require_subcommand(1);
  return Command(app_->add_subcommand(name, description));
}

void Command::runs_alone() const { app_->require_subcommand(0, 1); }
void Command::falls_through() const { app_->fallthrough(); }
bool Command::chosen() const { return app_->parsed(); }
void Command::footer(const std::string& text) const { app_->footer(text); }

bool Command::gives(const std::string& name) const {
  const CLI::Option* const option = std::as_const(*app_).get_option_no_throw(name);
  return option != nullptr && option->count() != 0;
}

void Command::on_run(std::function<int()> run) const {
  app_->callback([root = &root_of(*app_), run = std::move(run)] { root->exit_code = run(); });
}

template <class Add>
Flag Command::add(const std::string& name, Add add) const {
  const std::size_t equals = name.find('=');
  CLI::Option* const option = add(name.substr(0, equals));
  if (equals != std::string::npos) option->type_name(name.substr(equals + 1));
  if (heading_ != nullptr) option->group(heading_);
  return Flag(option);
}

template <class T>
Flag Command::option(const std::string& name, T& to, const std::string& help) const {
  return add(name, [&](const std::string& names) { return app_->add_option(names, to, help); });
}
template Flag Command::option(const std::string&, std::string&, const std::string&) const;
template Flag Command::option(const std::string&, double&, const std::string&) const;
template Flag Command::option(const std::string&, std::uint16_t&, const std::string&) const;
template Flag Command::option(const std::string&, std::uint32_t&, const std::string&) const;
template Flag Command::option(const std::string&, std::uint64_t&, const std::string&) const;
template Flag Command::option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Flag Command::option(const std::string&, std::vector<std::uint32_t>&, const std::string&) const;

Flag Command::flag(const std::string& name, bool& to, const std::string& help) const {
  return add(name, [&](const std::string& names) { return app_->add_flag(names, to, help); });
}

Flag Command::add_choice(const std::string& name, const std::vector<std::string>& words,
                         const std::function<void(std::size_t)>& choose, const std::string& help) const {
  const bool is_flag = name.find('{') != std::string::npos;
  const auto add_option = [&](const std::string& names) {
    return is_flag ? app_->add_flag(names, help) : app_->add_option(names, CLI::callback_t{}, help)->type_name("ENUM");
  };
  // WHY no callback: CLI11 gives a flag with a value none that takes the last one.
  return add(name, add_option).check([words, choose](const std::string& text) {
    const auto found =
        std::find_if(words.begin(), words.end(), [&text](const auto& word) { return core::iequals(word, text); });
    if (found != words.end()) return choose(static_cast<std::size_t>(found - words.begin())), std::string();
    std::vector<std::string> sorted = words;
    std::sort(sorted.begin(), sorted.end());
    return fmt::format("{} is not one of {}", text, fmt::join(sorted, ", "));
  });
}

Program::Program(const std::string& name, const std::string& description, const char* version)
    : Command(nullptr), owned_(std::make_shared<Root>(description, name)) {
  app_ = owned_.get();
  if (version == nullptr) return;
  app_->set_version_flag("--version", version);
  app_->add_flag_callback(
          "--manual", [app = app_] { throw CLI::CallForVersion(manual_page(*app), 0); },
          "this page in the language of man(1)")
      ->group("");
}

std::optional<int> Program::parse(int argc, char** argv) const {
  try {
    app_->parse(argc, argv);
    return root_of(*app_).exit_code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      app_->exit(error, std::cout, std::cerr);
      return kExitOk;
    }
    const CLI::App* deepest = app_;
    int depth = 1;  // of the argument that should be one of its commands
    for (; !deepest->get_subcommands().empty(); ++depth) deepest = deepest->get_subcommands().front();
    const std::string command = full_name(*deepest);
    const auto commands = deepest->get_subcommands([](const CLI::App*) { return true; });
    if (!commands.empty() && argc > depth && argv[depth][0] != '-') {
      core::Guess guess(argv[depth]);
      for (const CLI::App* known : commands) guess.offer(known->get_name());
      const std::string help = guess.help();
      complain(command, fmt::format("there is no command \"{}\"", argv[depth]),
               help.empty() ? fmt::format("{} --help lists them", command) : help);
      return kExitUsage;
    }
    const std::string help = fmt::format("{} --help shows every flag with examples", command);
    if (const auto flag = unknown_flag(*app_)) {
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

}  // namespace plc::tools
