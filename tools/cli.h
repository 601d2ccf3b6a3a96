// Command lines: what programs and their commands take, and what reads it.
//
// In: names, helps, places for values; argv. Out: values filled in and the chosen command run; or help, manual page,
// what was wrong. A narrow front of CLI11, which takes ten seconds wherever it is included: cli.cpp and manual.cpp do.
// Does not belong here: what a flag means, flags that several commands share (command_line.h).
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace plc::tools {

/// Exit codes, the same for every command.
inline constexpr int kExitOk = 0;
inline constexpr int kExitErrors = 1;  ///< the input has errors, or a program faulted
inline constexpr int kExitUsage = 2;   ///< wrong flags, or a file that cannot be opened or written

/// Prints "command: message" and "help: ..." on stderr.
void complain(std::string_view command, std::string_view message, std::string_view help = {});

/// A flag, or a file or name without dashes, of a command: copies are the same one. Calls can be chained.
class Flag {
 public:
  /// It must be given.
  Flag required() const;
  /// May be given several times, each time with one value; `dots`: help says so.
  Flag repeated(bool dots = true) const;
  /// Given several times, the last counts.
  Flag last() const;
  /// Only together with this one.
  Flag needs(Flag other) const;
  /// With none of these.
  Flag excludes(std::initializer_list<Flag> others) const;
  /// Says what is wrong with a value, nothing of a good one.
  Flag check(const std::function<std::string(const std::string&)>& wrong) const;
  /// Values from `least` to `most`; help says so.
  Flag range(int least, int most) const;
  Flag range(unsigned least, unsigned most) const;
  /// One of these words; help lists them.
  Flag one_of(const std::vector<std::string>& words) const;
  /// Help shows the value that its place has now.
  Flag shows_default() const;
  /// True when it was given.
  [[nodiscard]] bool given() const;

 private:
  friend class Command;
  explicit Flag(CLI::Option* option) : option_(option) {}
  CLI::Option* option_;
};

/// A command of a program, or the program itself: copies are the same one. It lives as long as its program does. Places
/// for values must outlive the parsing.
class Command {
 public:
  /// "plc config check": with those it belongs to.
  [[nodiscard]] std::string name() const;
  /// A command of this one, of which one must be chosen.
  Command sub(const std::string& name, const std::string& description) const;
  /// None of its commands, which it has by now, need be chosen.
  void runs_alone() const;
  /// Takes the flags of the program, too.
  void falls_through() const;
  /// True when it was chosen.
  [[nodiscard]] bool chosen() const;
  /// True when it has a flag of that name, with dashes, which was given.
  [[nodiscard]] bool gives(const std::string& name) const;
  /// What help says after the flags.
  void footer(const std::string& text) const;
  /// What to do when it is chosen and all flags are good; its result is that of Program::parse().
  void on_run(std::function<int()> run) const;

  /// The same command; flags that it gets by this one stand under a heading, a literal, of their own.
  [[nodiscard]] Command under(const char* heading) const { return Command(app_, heading); }
  /// "--cycles=N" or "-o,--output=FILE", where help calls the value N and FILE; "FILE" without dashes. T: a text, a
  /// number, or a list of such; cli.cpp says which.
  template <class T>
  Flag option(const std::string& name, T& to, const std::string& help) const;
  /// "--json": true when it is given.
  Flag flag(const std::string& name, bool& to, const std::string& help) const;

  /// One of a few words, in any letter case. The value of "--stats{text}=[=json]" may be omitted and is "text" then.
  template <class T>
  using Words = std::vector<std::pair<std::string_view, T>>;
  template <class T>
  Flag choice(const std::string& name, T& to, const std::type_identity_t<Words<T>>& words,
              const std::string& help) const {
    std::vector<std::string> names;
    for (const auto& [word, value] : words) names.emplace_back(word);
    return add_choice(
        name, names, [&to, words](std::size_t i) { to = words[i].second; }, help);
  }

 protected:
  explicit Command(CLI::App* app, const char* heading = nullptr) : app_(app), heading_(heading) {}
  CLI::App* app_;

 private:
  /// Takes `type` after "=" out of the name, and puts the flag under the heading.
  template <class Add>
  Flag add(const std::string& name, Add add) const;
  Flag add_choice(const std::string& name, const std::vector<std::string>& words,
                  const std::function<void(std::size_t)>& choose, const std::string& help) const;
  const char* heading_;
};

/// A program. With a version it has --version, and --manual: its page for man(1).
class Program : public Command {
 public:
  Program(const std::string& name, const std::string& description, const char* version = nullptr);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Reads argv and runs what was chosen; prints help or what was wrong. The exit code when the program should end now.
  std::optional<int> parse(int argc, char** argv) const;

 private:
  std::shared_ptr<CLI::App> owned_;
};

}  // namespace plc::tools
