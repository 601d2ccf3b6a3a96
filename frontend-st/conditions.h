// Conditions: pragmas that choose what is compiled, as CODESYS and TwinCAT have them: {IF defined (X)}, {ELSIF ..},
// {ELSE}, {END_IF}, {define X}, {undefine X}. What is not chosen becomes blanks, so that the places of the rest stay
// true.
//
// In: a text, the defines that hold where it begins, what the project has. Out: the text that counts. P4521 for
// conditions that cannot be read, P4520 for pragmas that do not belong together. Does not belong here: other pragmas,
// where a body begins (read_pous.cpp).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "core/text.h"
#include "frontend-st/lexer.h"
#include "frontend-st/source_text.h"

namespace plc::st {

/// Names that conditions ask for, with the text that they stand for: {define X} or {define X 'text'}.
class Defines {
 public:
  Defines() = default;
  /// Each "NAME" or "NAME=text", as --define and plcopen::Body::defines have them.
  explicit Defines(const std::vector<std::string>& entries);

  void define(std::string_view name, std::string_view text) { texts_.insert_or_assign(std::string(name), text); }
  void undefine(std::string_view name) { texts_.erase(std::string(name)); }
  /// Null when the name is not defined.
  [[nodiscard]] const std::string* find(std::string_view name) const;
  /// As the constructor takes them, in the order of their names.
  [[nodiscard]] std::vector<std::string> entries() const;

 private:
  struct Less {
    bool operator()(const std::string& a, const std::string& b) const { return core::uppered(a) < core::uppered(b); }
  };
  std::map<std::string, std::string, Less> texts_;
};

/// What a project has, for conditions that ask for more than defines.
class Surroundings {
 public:
  virtual ~Surroundings() = default;
  [[nodiscard]] virtual bool has_variable(std::string_view path) const = 0;
  [[nodiscard]] virtual bool has_type(std::string_view name) const = 0;
  [[nodiscard]] virtual bool has_pou(std::string_view name) const = 0;
  [[nodiscard]] virtual bool has_task(std::string_view name) const = 0;
  /// Whether the variable is of this type.
  [[nodiscard]] virtual bool is_of_type(std::string_view path, std::string_view type) const = 0;
  /// {attribute 'name'} before a POU.
  [[nodiscard]] virtual bool pou_has_attribute(std::string_view pou, std::string_view attribute) const = 0;
  /// {attribute 'name'} before a variable of the POU that asks, or of a list.
  [[nodiscard]] virtual bool variable_has_attribute(std::string_view variable, std::string_view attribute) const = 0;
};

/// True for the pragmas that this file knows: those that choose, and {define ..}, {undefine ..}.
bool is_choosing_pragma(std::string_view pragma);

/// The text without what is not chosen.
class ChosenText {
 public:
  /// A body, or any text whose pragmas stand between its tokens. `surroundings` are asked while it is made.
  ChosenText(const SourceText& source, Defines defines, const Surroundings& surroundings,
             core::Diagnostics& diagnostics, std::string_view pou);
  [[nodiscard]] std::string_view text() const { return is_changed_ ? std::string_view(changed_) : text_; }
  /// False after an error.
  [[nodiscard]] bool fine() const { return fine_; }

 private:
  std::string_view text_;
  std::string changed_;
  bool is_changed_ = false;
  bool fine_ = true;
};

/// A text of declarations: chooses among declarations, and leaves pragmas inside of bodies where they are. Conditions
/// ask for defines only: what else there is is not known before all is read.
class DeclaredText {
 public:
  DeclaredText(const SourceText& source, Defines defines, core::Diagnostics& diagnostics);
  [[nodiscard]] std::string_view text() const { return changed_.empty() ? text_ : std::string_view(changed_); }
  [[nodiscard]] bool has_defines() const { return !defines_.empty(); }
  /// The defines that hold at `offset`, as Defines::entries().
  [[nodiscard]] std::vector<std::string> defines_at(std::uint32_t offset) const;

 private:
  std::string_view text_;
  std::string changed_;
  std::vector<std::pair<std::uint32_t, std::vector<std::string>>> defines_;  ///< from this offset on
};

/// `text` with a blank for each character of the ranges but line ends. Ranges are in order and apart from each other.
std::string blanked(std::string_view text, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& ranges);

}  // namespace plc::st
