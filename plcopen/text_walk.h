// TextWalk: which characters of the file a text is made of. It goes through the file beside the XML parser, which says
// what a text is but not where.
//
// In: the pieces of a text, in order, and where tags end; values of attributes. Out: the place of the first character
// that is no blank, and the jumps of the file. Does not belong here: XML events.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/text_jumps.h"
#include "plcopen/input_text.h"

namespace plc::plcopen {

class TextWalk {
 public:
  TextWalk(std::string_view file, PlaceFinder& places) : file_(file), places_(places), own_places_(file) {}

  /// What comes next belongs to a new text.
  void begin();
  /// A tag ends before `offset`; the text may continue after it.
  void tag(std::size_t offset);
  void piece(std::string_view piece);
  /// The text has a line end where the last tag is, of which nothing was given yet.
  void line_end();
  /// All of the text was given.
  void end();
  /// A whole text: the value of an attribute, after the quote at `offset`, as the parser gives it.
  void attribute(std::size_t offset, std::string_view value);

  /// Of the first character that is no blank; none while there were only blanks.
  [[nodiscard]] const std::optional<Place>& first() const { return first_; }
  core::TextJumps& jumps() { return jumps_; }

 private:
  /// A character of the text, or the only part of it that the file has: an entity.
  struct Step {
    std::size_t raw = 0;   ///< bytes in the file; 0: it says something else than the parser
    std::size_t text = 0;  ///< bytes in the text
    bool plain = false;    ///< what follows is next to it, or on the next line
  };
  [[nodiscard]] Step step(std::string_view text) const;
  void skip_markup();
  Place place_at(std::size_t offset);
  void jump_to(std::size_t offset);

  static constexpr std::size_t kNone = std::string_view::npos;

  std::string_view file_;
  PlaceFinder& places_;     ///< for values of attributes
  PlaceFinder own_places_;  ///< for texts
  core::TextJumps jumps_;
  std::optional<Place> first_;
  std::size_t at_ = 0;        ///< offset in the file of what comes next
  std::size_t last_ = kNone;  ///< offset of the last character; none while there were only blanks
  std::size_t after_ = 0;     ///< offset after it
  std::size_t next_ = kNone;  ///< where the following character is expected; none: it needs a jump
  bool section_ = false;      ///< inside of <![CDATA[
  bool value_ = false;        ///< inside of an attribute
  bool lost_ = false;         ///< no more jumps in this text
};

}  // namespace plc::plcopen
