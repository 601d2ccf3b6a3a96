// ir::lint: what compiles, but is hardly meant. Each lint has a row in ir/lints.def: name, code, default.
//
// In: the Module of a whole project that ir::check had no error for, and the lints that are on. Out: warnings, in the
// order of the files. Linear in the size of the program. Does not belong here: errors, and anything that needs syntax.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "core/result.h"
#include "ir/ir.h"

namespace plc::ir {

enum class Lint : std::uint8_t {
#define PLC_LINT(name, word, code, on, summary) k##name,
#include "ir/lints.def"
};

struct LintInfo {
  std::string_view name;  ///< on the command line: "unused-variable"
  core::Code code;
  bool on;  ///< by default
  std::string_view summary;
};
/// All lints, indexed by Lint.
std::span<const LintInfo> lints();
inline const LintInfo& info(Lint lint) { return lints()[static_cast<std::size_t>(lint)]; }

inline constexpr std::size_t kLintCount = 0
#define PLC_LINT(name, word, code, on, summary) +1
#include "ir/lints.def"
    ;

/// Which lints are on; at first those that are by default.
class LintOptions {
 public:
  LintOptions();
  [[nodiscard]] bool on(Lint lint) const { return on_[static_cast<std::size_t>(lint)]; }
  void set(Lint lint, bool on) { on_[static_cast<std::size_t>(lint)] = on; }
  /// Whether what comes from libraries is looked at, too; at first not.
  [[nodiscard]] bool libraries() const { return libraries_; }
  void set_libraries(bool on) { libraries_ = on; }
  /// What others than the program read and write, as plc.toml names variables: globals or paths. Of globals that are
  /// named there it is not looked at whether the program uses them.
  void set_used_outside(std::vector<std::string> paths) { used_outside_ = std::move(paths); }
  [[nodiscard]] bool is_used_outside(std::string_view global) const;
  /// Applies a list like "all,-shadowed-name" from left to right: "all", "none", a name, or a name after '-'. A
  /// problem names the first item that is none of these, and what it may have meant.
  core::Result<LintOptions> with(std::string_view list) const;

 private:
  std::array<bool, kLintCount> on_{};
  bool libraries_ = false;
  std::vector<std::string> used_outside_;
};

/// Reports what the lints that are on find. Stubs are left out, and libraries but on request.
void lint(const Module& module, const LintOptions& options, core::Diagnostics& diagnostics);

/// The codes that are not wanted of a library: warnings and notes about how it is written. What is left is about what
/// the project does with it.
std::vector<core::Code> codes_about_writing();

/// Mutes the codes of lints that are off, also those that earlier steps report.
void mute_others(const LintOptions& options, core::Diagnostics& diagnostics);

}  // namespace plc::ir
