// Comments between the declarations of a text, by the declaration that they belong to: what is in its line after it,
// and what is in the lines before it.
//
// In: a Project. Out: lines of text. Does not belong here: comments inside of bodies, which are part of their text;
// documentation of XML (declaration_writer.h).
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/source_ref.h"
#include "plcopen/project.h"

namespace plc::convert {

class Comments {
 public:
  explicit Comments(const plcopen::Project& project);

  /// Whole lines before the declaration at `at`, each indented by `indent` blanks.
  [[nodiscard]] std::string before(const core::SourceRef& at, std::size_t indent) const;
  /// What follows the declaration at `at` in its line, with two blanks before it; or empty.
  [[nodiscard]] std::string after(const core::SourceRef& at) const;
  /// Lines after the last declaration.
  [[nodiscard]] const std::string& rest() const { return rest_; }
  [[nodiscard]] bool has(const core::SourceRef& at) const { return entries_.contains(key(at)); }

 private:
  using Key = std::tuple<std::uint16_t, std::uint32_t, std::uint32_t>;
  struct Entry {
    std::vector<std::string> before;
    std::string after;
  };
  static Key key(const core::SourceRef& at) { return {at.file, at.line, at.column}; }

  std::map<Key, Entry> entries_;
  std::string rest_;
};

}  // namespace plc::convert
