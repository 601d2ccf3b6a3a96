// Inside runtime/access: walks through all variables of a resource and collects the paths that match a pattern.
//
// In: an image, a pattern. Out: paths with their places. Does not belong here: looking one path up (access.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/text.h"
#include "runtime/access.h"

namespace plc::runtime {

/// False for a global that was made for located variables of POUs: it is called "Pou.Variable" or by its address.
bool is_declared_global(const bytecode::ImageField& global);
/// True when a program instance of this name is in more than one task.
bool in_several_tasks(const bytecode::Image& image, std::string_view name);
/// The place of a field of the global table.
Place place_of_global(const bytecode::Image& image, std::size_t index);

/// What is listed of variables that have several paths.
enum class Paths : std::uint8_t {
  kOnce,   ///< each variable once
  kNames,  ///< each once under every name that a declaration gives it
  kAll,    ///< every path that matches
};

class PathLister {
 public:
  PathLister(const Resource& resource, std::string_view pattern, std::size_t limit, Paths paths);
  /// Memory of blocks of the library is left out: a misspelt name does not mean it.
  void leave_out_states() { states_ = false; }
  /// Walks through everything: instances before globals, in declaration order.
  void run();
  /// What was found.
  std::vector<Listed> take() { return std::move(found_); }
  /// Adds what `other` found under names that this one did not find its variable under.
  void add_missing(PathLister&& other);

 private:
  [[nodiscard]] bool shows(const std::string& name) const { return hidden_ || name.find('#') == std::string::npos; }
  void add_global(std::size_t index);
  /// Adds the leaves of `place`, which is called `path`. Aliases that only aliases lead to stay out: they may go round
  /// in circles.
  void walk(std::string& path, const Place& place, bool inside_alias);
  void walk_aliases(std::string& path, const bytecode::ImageType& type);
  void walk_named(std::string& path, const std::string& name, const Place& place, bool inside_alias);
  /// Whether an alias is listed, or its global under its own name.
  bool lists_alias(const bytecode::ImageAlias& alias);
  /// A part of a global under one of its names; empty for variables of tasks.
  [[nodiscard]] std::string key_of(const Place& place) const;

  const Resource& resource_;
  const bytecode::Image& image_;
  const std::vector<bytecode::ImageField>& globals_;
  std::string_view pattern_;
  std::size_t limit_;
  bool hidden_;
  bool states_ = true;
  Paths paths_;
  std::string_view root_name_;  ///< by which the walk came to the global that it is in
  std::vector<bool> listed_;    ///< by global
  std::vector<Listed> found_;
  std::vector<std::string> keys_;  ///< of found_, but for Paths::kOnce
  using Names = std::unordered_set<std::string, core::NameHash, core::NameEqual>;
  Names known_;
  Names named_;  ///< "index name" of globals, for Paths::kNames
};

}  // namespace plc::runtime
