#include "gcode.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cnc {

namespace {

constexpr double kInch = 25.4;
/// How much start and end of an arc may differ in their distance from its centre, in mm: programs are written with
/// three decimals.
constexpr double kRadiusTolerance = 0.005;
/// Ends that are nearer to each other than this are one point: sums of increments are not exact.
constexpr double kSamePoint = 1e-6;
constexpr std::array<char, 3> kAxes{'X', 'Y', 'Z'};

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r'; }
char upper(char c) noexcept { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

bool is(double value, int number) noexcept { return value == static_cast<double>(number); }

bool stops(const double code) noexcept { return is(code, 0) || is(code, 1) || is(code, 2) || is(code, 30); }
bool ends(const double code) noexcept { return is(code, 2) || is(code, 30); }

}  // namespace

const Interpreter::Word* Interpreter::Block::find(char letter) const noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    if (words[i].letter == letter) return &words[i];
  }
  return nullptr;
}

void Interpreter::start(std::string_view program, const std::array<double, 3>& position) noexcept {
  *this = {};
  rest_ = program;
  position_ = position;
  finished_ = false;
}

bool Interpreter::fail(std::int32_t column, const char* text) noexcept {
  mistake_ = {text, line_, column};
  finished_ = true;
  return false;
}

void Interpreter::next(Segments& out) noexcept {
  out.count = 0;
  if (finished_) return;
  ++line_;
  if (rest_.empty()) {
    // A program without M2 ends with its text.
    add(out, {.kind = Segment::kEnd});
    finished_ = true;
    return;
  }
  const std::size_t length = rest_.find('\n');
  const std::string_view line = rest_.substr(0, length);
  rest_.remove_prefix(length == std::string_view::npos ? rest_.size() : length + 1);
  Block block;
  if (!scan(line, block) || !interpret(block, out)) out.count = 0;
}

// ---- words --------------------------------------------------------------------------------------------------------

bool Interpreter::scan(std::string_view line, Block& block) noexcept {
  std::size_t at = 0;
  while (at < line.size()) {
    const auto column = static_cast<std::int32_t>(at + 1);
    const char c = upper(line[at]);
    if (is_blank(c)) {
      ++at;
    } else if (c == ';' || ((c == '%' || c == '/') && block.count == 0)) {
      return true;  // a comment, the mark of a tape's ends, or a block that is switched off
    } else if (c == '(') {
      const std::size_t end = line.find(')', at);
      if (end == std::string_view::npos) return fail(column, "this comment has no end");
      at = end + 1;
    } else if (c >= 'A' && c <= 'Z') {
      if (std::string_view("FGIJKMNPRSTXYZ").find(c) == std::string_view::npos) {
        return fail(column, "no word of this reader begins with this letter");
      }
      if (c != 'G' && c != 'M' && block.find(c) != nullptr) return fail(column, "this letter is there twice");
      if (block.count == block.words.size()) return fail(column, "too many words in one block");
      Word word{c, 0, column};
      ++at;
      if (!scan_number(line, at, word.value)) return false;
      block.words[block.count++] = word;
    } else {
      return fail(column, "a letter must be here");
    }
  }
  return true;
}

// WHY by hand: std::from_chars takes 1e5 and inf, which are none here, and strtod() depends on the locale.
bool Interpreter::scan_number(std::string_view line, std::size_t& at, double& value) noexcept {
  while (at < line.size() && is_blank(line[at])) ++at;
  const auto column = static_cast<std::int32_t>(at + 1);
  const bool negative = at < line.size() && line[at] == '-';
  if (at < line.size() && (line[at] == '-' || line[at] == '+')) ++at;
  double digits = 0;
  double scale = 1;
  int seen = 0;
  bool fraction = false;
  for (; at < line.size() && (is_digit(line[at]) || (line[at] == '.' && !fraction)); ++at) {
    if (line[at] == '.') {
      fraction = true;
      continue;
    }
    digits = digits * 10 + (line[at] - '0');
    if (fraction) scale *= 10;
    ++seen;
  }
  if (seen == 0) return fail(column, "a number must be here");
  if (seen > 15) return fail(column, "a number has 15 digits at most");
  value = (negative ? -digits : digits) / scale;
  return true;
}

// ---- meaning ------------------------------------------------------------------------------------------------------

bool Interpreter::set_g(const Word& word, Request& request) noexcept {
  if (is(word.value, 4)) {
    request.dwell = &word;
  } else if (is(word.value, 0) || is(word.value, 1) || is(word.value, 2) || is(word.value, 3)) {
    if (request.motion != nullptr) return fail(word.column, "a second motion (G0 to G3) in one block");
    request.motion = &word;
    motion_ = static_cast<int>(word.value);
  } else if (is(word.value, 20) || is(word.value, 21)) {
    inches_ = is(word.value, 20);
  } else if (is(word.value, 90) || is(word.value, 91)) {
    incremental_ = is(word.value, 91);
  } else if (!is(word.value, 17)) {
    return fail(word.column, "this G-code is not one of 0 1 2 3 4 17 20 21 90 91");
  }
  return true;
}

bool Interpreter::set_modes(const Block& block, Request& request) noexcept {
  // Units first: they are those of F in the same block.
  for (std::size_t i = 0; i < block.count; ++i) {
    const Word& word = block.words[i];
    if (word.letter == 'G' && !set_g(word, request)) return false;
    if (word.letter == 'M') {
      if (request.code_count == request.codes.size()) return fail(word.column, "more than four M-codes in one block");
      if (word.value < 0 || word.value > 999 || word.value != std::floor(word.value)) {
        return fail(word.column, "an M-code is a whole number from 0 to 999");
      }
      request.codes[request.code_count++] = &word;
    }
  }
  if (const Word* const feed = block.find('F')) {
    if (!(feed->value > 0)) return fail(feed->column, "a feed is above zero");
    feed_ = feed->value * (inches_ ? kInch : 1) / 60;
  }
  if (const Word* const spindle = block.find('S')) {
    if (spindle->value < 0) return fail(spindle->column, "a spindle speed is not negative");
    spindle_ = spindle->value;
  }
  return true;
}

void Interpreter::add_codes(const Request& request, bool after_motion, Segments& out) noexcept {
  for (std::size_t i = 0; i < request.code_count; ++i) {
    const double code = request.codes[i]->value;
    if (stops(code) != after_motion) continue;
    add(out, {.kind = Segment::kCode, .code = static_cast<std::int32_t>(code)});
    if (ends(code)) {
      add(out, {.kind = Segment::kEnd});
      finished_ = true;
      return;
    }
  }
}

bool Interpreter::interpret(const Block& block, Segments& out) noexcept {
  Request request;
  if (!set_modes(block, request)) return false;
  add_codes(request, false, out);

  const Word* axis = nullptr;
  for (const char letter : kAxes) {
    if (axis == nullptr) axis = block.find(letter);
  }
  if (request.dwell != nullptr) {
    const Word* const seconds = block.find('P');
    if (seconds == nullptr || seconds->value < 0) {
      return fail(request.dwell->column, "G4 needs P with the seconds to wait");
    }
    if (axis != nullptr) return fail(axis->column, "G4 does not move");
    add(out, {.kind = Segment::kDwell, .seconds = seconds->value});
  } else if (block.find('P') != nullptr) {
    return fail(block.find('P')->column, "P belongs to G4");
  }
  // A full circle is asked for by G2 or G3 with a centre and no axis word.
  const bool circle =
      request.motion != nullptr && motion_ >= 2 && (block.find('I') != nullptr || block.find('J') != nullptr);
  if (axis != nullptr || circle) {
    if (!move(block, request, out)) return false;
  } else {
    for (const char letter : {'I', 'J', 'K', 'R'}) {
      if (const Word* const word = block.find(letter)) return fail(word->column, "this word belongs to an arc");
    }
  }
  add_codes(request, true, out);
  return true;
}

bool Interpreter::move(const Block& block, const Request& request, Segments& out) noexcept {
  const Word& where = request.motion != nullptr ? *request.motion : block.words[0];
  if (motion_ < 0) return fail(where.column, "an axis moves, but no G0 to G3 said how");
  const double unit = inches_ ? kInch : 1;
  Segment segment{.kind = motion_ == 0 ? Segment::kRapid : Segment::kLine, .end = position_, .feed = feed_};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    const Word* const word = block.find(kAxes[i]);
    if (word != nullptr) segment.end[i] = word->value * unit + (incremental_ ? position_[i] : 0);
  }
  if (motion_ != 0 && !(feed_ > 0)) return fail(where.column, "there was no feed (F) yet");
  if (motion_ >= 2) {
    if (!set_arc(block, where, segment)) return false;
  } else {
    for (const char letter : {'I', 'J', 'K', 'R'}) {
      if (const Word* const word = block.find(letter)) return fail(word->column, "this word belongs to an arc");
    }
  }
  position_ = segment.end;
  add(out, segment);
  return true;
}

bool Interpreter::set_arc(const Block& block, const Word& where, Segment& segment) noexcept {
  segment.kind = Segment::kArc;
  const double unit = inches_ ? kInch : 1;
  const double turn = motion_ == 3 ? 1.0 : -1.0;
  const double dx = segment.end[0] - position_[0];
  const double dy = segment.end[1] - position_[1];
  const double chord = std::hypot(dx, dy);
  const bool closed = chord < kSamePoint;
  const Word* const i = block.find('I');
  const Word* const j = block.find('J');
  const Word* const r = block.find('R');
  if (const Word* const k = block.find('K'))
    return fail(k->column, "arcs lie in the plane of X and Y: K has no meaning");
  if (r != nullptr) {
    if (i != nullptr || j != nullptr) return fail(r->column, "an arc has R, or I and J, but not both");
    if (closed) return fail(r->column, "a full circle needs I and J: R leaves its centre open");
    const double radius = std::fabs(r->value) * unit;
    const double below = radius * radius - chord * chord / 4;
    if (radius < chord / 2 - kRadiusTolerance) return fail(r->column, "R is less than half the way from start to end");
    // The centre lies beside the middle of the chord; on its left for the short way counter-clockwise.
    const double side = turn * (r->value < 0 ? -1 : 1) * std::sqrt(std::max(0.0, below)) / chord;
    segment.centre = {position_[0] + dx / 2 - side * dy, position_[1] + dy / 2 + side * dx};
  } else {
    if (i == nullptr && j == nullptr) return fail(where.column, "an arc needs R, or I and J");
    segment.centre = {position_[0] + (i != nullptr ? i->value * unit : 0),
                      position_[1] + (j != nullptr ? j->value * unit : 0)};
    const double at_start = std::hypot(position_[0] - segment.centre[0], position_[1] - segment.centre[1]);
    const double at_end = std::hypot(segment.end[0] - segment.centre[0], segment.end[1] - segment.centre[1]);
    if (at_start == 0) return fail(where.column, "the arc begins in its centre");
    if (std::fabs(at_start - at_end) > kRadiusTolerance) {
      return fail(where.column, "start and end of the arc are not equally far from its centre");
    }
    if (!closed) {
      // Rounded I and J: the nearest centre that is equally far from both.
      const double off =
          ((segment.centre[0] - position_[0]) * dx + (segment.centre[1] - position_[1]) * dy) / (chord * chord) - 0.5;
      segment.centre = {segment.centre[0] - off * dx, segment.centre[1] - off * dy};
    }
  }
  double sweep = std::atan2(segment.end[1] - segment.centre[1], segment.end[0] - segment.centre[0]) -
                 std::atan2(position_[1] - segment.centre[1], position_[0] - segment.centre[0]);
  constexpr double kCircle = 2 * std::numbers::pi;
  if (closed) {
    sweep = turn * kCircle;
  } else {
    while (turn * sweep <= 0) sweep += turn * kCircle;
    while (turn * sweep > kCircle) sweep -= turn * kCircle;
  }
  segment.sweep = sweep;
  return true;
}

void Interpreter::add(Segments& out, Segment segment) const noexcept {
  segment.line = line_;
  segment.spindle = spindle_;
  if (segment.kind != Segment::kRapid && segment.kind != Segment::kLine && segment.kind != Segment::kArc) {
    segment.end = position_;
  }
  out.all[out.count++] = segment;
}

}  // namespace cnc
