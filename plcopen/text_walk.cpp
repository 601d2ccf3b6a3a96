#include "plcopen/text_walk.h"

namespace plc::plcopen {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/// Bytes of the character that begins `text`.
std::size_t character_length(std::string_view text) {
  std::size_t length = 1;
  while (length < text.size() && (static_cast<unsigned char>(text[length]) & 0xC0u) == 0x80u) ++length;
  return length;
}

}  // namespace

void TextWalk::begin() {
  first_.reset();
  last_ = next_ = kNone;
  value_ = lost_ = false;
}

void TextWalk::tag(std::size_t offset) {
  at_ = offset;
  section_ = false;
}

// Comments, processing instructions and the borders of sections hold no characters of the text.
void TextWalk::skip_markup() {
  constexpr std::string_view kSection = "<![CDATA[";
  while (at_ < file_.size()) {
    const std::string_view rest = file_.substr(at_);
    std::string_view closing;
    if (section_ && rest.starts_with("]]>")) {
      section_ = false;
      at_ += 3;
      continue;
    }
    if (section_ || rest.front() != '<') return;
    if (rest.starts_with(kSection)) {
      section_ = true;
      at_ += kSection.size();
      continue;
    }
    if (rest.starts_with("<!--")) {
      closing = "-->";
    } else if (rest.starts_with("<?")) {
      closing = "?>";
    } else {
      return;
    }
    const std::size_t end = file_.find(closing, at_ + 2);
    if (end == std::string_view::npos) return;
    at_ = end + closing.size();
  }
}

TextWalk::Step TextWalk::step(std::string_view text) const {
  if (at_ >= file_.size()) return {};
  const char c = file_[at_];
  if (c == '&' && !section_) {
    const std::size_t end = file_.find(';', at_);
    if (end == std::string_view::npos) return {};
    // The parser leaves an ampersand in values escaped; the reader does not.
    return {end + 1 - at_, character_length(text), false};
  }
  const bool line_end = c == '\r' || c == '\n';
  const std::size_t raw = c == '\r' && at_ + 1 < file_.size() && file_[at_ + 1] == '\n' ? 2 : 1;
  if (value_) {
    if (!line_end && c != '\t') return {text[0] == c ? raw : 0, 1, true};
    return {text[0] == ' ' ? raw : 0, 1, false};
  }
  if (!line_end) return {text[0] == c ? raw : 0, 1, true};
  return {text[0] == '\n' ? raw : 0, 1, file_[at_ + raw - 1] == '\n'};
}

// Tags inside of a text have other places already: from there back to the text would be all of the file anew.
Place TextWalk::place_at(std::size_t offset) { return (value_ ? places_ : own_places_).at(offset); }

void TextWalk::jump_to(std::size_t offset) {
  if (last_ == kNone || offset == next_) return;
  const Place from = place_at(last_);
  const Place to = place_at(offset);
  jumps_.add({from.line, from.column}, {to.line, to.column});
}

void TextWalk::piece(std::string_view piece) {
  std::size_t done = 0;
  while (done < piece.size() && !lost_) {
    if (!value_) skip_markup();
    const Step one = step(piece.substr(done));
    if (one.raw == 0) {
      lost_ = true;
      return;
    }
    if (last_ != kNone || !is_blank(piece[done])) {
      if (last_ == kNone) first_ = place_at(at_);
      // The bytes of one character beyond its first take no column.
      if ((static_cast<unsigned char>(piece[done]) & 0xC0u) != 0x80u || !one.plain) {
        jump_to(at_);
        last_ = at_;
      }
      next_ = one.plain ? at_ + one.raw : kNone;
    }
    at_ += one.raw;
    after_ = at_;
    done += one.text;
  }
}

// The end of the tag stands for the line end.
void TextWalk::line_end() {
  if (last_ == kNone || at_ == 0 || lost_) return;
  jump_to(at_ - 1);
  last_ = at_ - 1;
  next_ = kNone;
}

void TextWalk::end() {
  if (!lost_) jump_to(after_);
  last_ = kNone;
}

void TextWalk::attribute(std::size_t offset, std::string_view value) {
  begin();
  value_ = true;
  section_ = false;
  at_ = offset;
  piece(value);
  end();
  value_ = false;
}

}  // namespace plc::plcopen
