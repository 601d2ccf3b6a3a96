// What the declarations of libraries need of each other, and which of them the project uses.
//
// In: where each is, which names which. Out: problems of those that are used, and of no others. What is wrong with
// a declaration was set aside by Diagnostics, by its place. Does not belong here: reading, declaring.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "core/text.h"

namespace plc::ir {

class Library {
 public:
  using Index = std::uint32_t;

  /// A declaration of `names` from `begin` to `end`. All of them are added before anything is asked.
  void add(const std::vector<std::string>& names, const core::SourceRef& begin, const core::SourceRef& end);
  void finish();
  [[nodiscard]] bool empty() const { return parts_.empty(); }

  /// The declaration that `at` lies in.
  [[nodiscard]] std::optional<Index> at(const core::SourceRef& at) const;
  /// The first declaration of this name that has an error.
  [[nodiscard]] std::optional<Index> broken(std::string_view name, core::Diagnostics& diagnostics) const;

  /// The declaration `user` names `used`.
  void need(Index user, Index used);

  /// `part` is used at `at`, in POU `pou`: what was set aside of it and of all it needs is reported, and P4060 at the
  /// first such place of the project if there is an error among it. False when there is. `name` is the one it is used
  /// by, where a declaration has several.
  bool use(Index part, const core::SourceRef& at, std::string_view pou, core::Diagnostics& diagnostics,
           std::string_view name = {});
  /// An error was found in `part` while it was compiled.
  void fail(Index part, const core::SourceRef& at, std::string message);

 private:
  struct Part {
    std::string name;  ///< the first of its names
    core::SourceRef begin;
    core::SourceRef end;
    std::vector<Index> needs;
    bool reached = false;
    bool reported = false;  ///< P4060
    bool broken = false;
    core::SourceRef error_at;  ///< broken: its first error, or that of what it needs
    std::string error;
  };

  void reach(Index part, core::Diagnostics& diagnostics);

  std::vector<Part> parts_;  ///< by place
  bool any_broken_ = false;
  std::vector<std::pair<std::string, Index>> names_;
  std::unordered_map<std::string, std::vector<Index>, core::NameHash, core::NameEqual> by_name_;
};

}  // namespace plc::ir
