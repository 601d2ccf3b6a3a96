#include "interpolator.h"

#include <algorithm>
#include <cmath>

namespace cnc {

namespace {

/// Shorter than anything that matters, in mm: what rounding leaves of an element.
constexpr double kNothing = 1e-10;
/// An element has three phases at most (faster, level, slower), and a cycle five elements.
constexpr int kMostPhases = 24;

}  // namespace

void Interpolator::start(const PathLimits& limits, const Vector& position) noexcept {
  *this = {};
  limits_ = limits;
  position_ = added_to_ = position;
}

void Interpolator::place(const Vector& position) noexcept {
  position_ = position;
  speed_ = 0;
  forget();
}

// ---- what is to come ----------------------------------------------------------------------------------------------

void Interpolator::push(const Element& element) noexcept {
  at(count_) = element;
  exits_[(head_ + count_) % kCapacity] = 0;
  ++count_;
}

void Interpolator::close_pending() noexcept {
  if (!has_pending_) return;
  push(pending_);
  has_pending_ = false;
}

void Interpolator::add(const Segment& segment) noexcept {
  done_ = false;
  Element element = element_of(segment, added_to_, limits_);
  if (!element.moves()) {
    close_pending();
    push(element);
    return;
  }
  if (!(element.length >= kNothing && std::isfinite(element.length))) return;  // no way at all, or no numbers
  added_to_ = element.end;
  const double length = element.length;
  if (has_pending_) {
    Element rounding;
    const bool rounded = join(pending_, pending_length_, element, limits_, rounding);
    push(pending_);
    if (rounded) push(rounding);
  }
  pending_ = element;
  pending_length_ = length;
  has_pending_ = true;
  dry_seconds_ = 0;
}

double Interpolator::cap(const Element& element) const noexcept {
  const double rapid = element.cap * std::min(1.0, factor_);
  return element.kind == Segment::kRapid ? rapid : std::min(element.cap, element.feed * factor_);
}

void Interpolator::look_ahead() noexcept {
  if (count_ == 0) return;
  double entry = 0;  // of the next element: after the last one that is known, rest
  for (std::size_t i = count_; i-- > 0;) {
    const Element& element = at(i);
    double& exit = exits_[(head_ + i) % kCapacity];
    if (!element.moves()) {
      exit = entry = 0;
      continue;
    }
    const double own = cap(element);
    exit = std::min({own, element.exit_cap, entry});
    entry = std::min(own, std::sqrt(exit * exit + 2 * element.acceleration * element.length));
  }
}

// ---- motion -------------------------------------------------------------------------------------------------------

// Constant acceleration until something else has to be done, the end of the element, or the end of the cycle.
Interpolator::Phase Interpolator::phase(const Element& element, double most_seconds) const noexcept {
  const double a = element.acceleration;
  const double v = speed_;
  const double rest = element.length - way_;
  const double exit = exits_[head_];
  const double level = braking_ ? 0 : cap(element);
  const double brakable = std::sqrt(exit * exit + 2 * a * rest);
  constexpr double kSame = 1e-9;  // relative
  if (v > level * (1 + kSame)) {
    const double to_level = (v - level) / a;
    const double square = v * v - 2 * a * rest;
    const double to_end = square > 0 ? (v - std::sqrt(square)) / a : to_level;
    return {-a, std::min({to_level, to_end, most_seconds})};
  }
  if (v > exit && v >= brakable * (1 - kSame)) {
    // What is really needed, so that roundings do not add up; a lowered override can ask for more than there is.
    const double needed = (v * v - exit * exit) / (2 * rest);
    if (needed > a * (1 + 1e-3)) {
      const double square = v * v - 2 * a * rest;
      return {-a, std::min((v - std::sqrt(std::max(0.0, square))) / a, most_seconds)};
    }
    return {-needed, std::min(2 * rest / (v + exit), most_seconds)};
  }
  if (v < level * (1 - kSame)) {
    // Up to where braking has to begin, or the end.
    const double at_end = std::sqrt(v * v + 2 * a * rest);
    const double turning = at_end <= exit ? at_end : std::sqrt((exit * exit + v * v) / 2 + a * rest);
    return {a, std::min((std::min(level, turning) - v) / a, most_seconds)};
  }
  if (v <= 0) return {0, most_seconds};
  const double braking_way = v > exit ? (v * v - exit * exit) / (2 * a) : 0;
  return {0, std::min((rest - braking_way) / v, most_seconds)};
}

void Interpolator::travel(double seconds) noexcept {
  for (int i = 0; i < kMostPhases && seconds > 0 && count_ > 0 && at(0).moves(); ++i) {
    const Element& element = at(0);
    const Phase now = phase(element, seconds);
    way_ += now.seconds * (speed_ + now.acceleration * now.seconds / 2);
    speed_ = std::max(0.0, speed_ + now.acceleration * now.seconds);
    seconds -= now.seconds;
    line_ = element.line;
    spindle_ = element.spindle;
    if (way_ >= element.length - kNothing) {
      position_ = element.end;
      drop_head();
      if (count_ == 0 || !at(0).moves()) speed_ = 0;  // but for roundings it is
    } else {
      position_ = element.point(way_);
    }
  }
}

void Interpolator::drop_head() noexcept {
  head_ = (head_ + 1) % kCapacity;
  --count_;
  way_ = 0;
}

// True when the element is over.
bool Interpolator::pass_special(const Command& command) noexcept {
  const Element& element = at(0);
  line_ = element.line;
  spindle_ = element.spindle;
  if (element.kind == Segment::kDwell) {
    waited_ += limits_.period;
    if (waited_ < element.seconds) return false;
    waited_ = 0;
  } else if (element.kind == Segment::kCode) {
    // Four edges: strobe, answer, strobe away, answer away. So one answer never confirms two codes.
    if (!strobe_ && !answered_) {
      if (command.code_done) return false;
      code_ = element.code;
      strobe_ = true;
    } else if (strobe_ && command.code_done) {
      strobe_ = false;
      answered_ = true;
    }
    if (!answered_ || command.code_done) return false;
    answered_ = false;
  } else {
    done_ = true;
  }
  return true;
}

void Interpolator::step(const Command& command, bool dry) noexcept {
  if (command.limit) limited_ = true;
  if (command.reset) resetting_ = true;
  braking_ = command.hold || limited_ || resetting_;
  // FALSE for NaN as well: an override that is no number is a hold.
  factor_ = command.override_factor > 0 ? std::min(command.override_factor, 2.0) : 0;

  dry_seconds_ = dry ? dry_seconds_ + limits_.period : 0;
  if (dry_seconds_ > kPatience) close_pending();
  look_ahead();
  if (count_ > 0 && !at(0).moves()) {
    if (!limited_ && !resetting_ && pass_special(command)) drop_head();
  } else {
    travel(limits_.period);
  }
  held_ = braking_ && speed_ <= 0;

  if (resetting_ && speed_ <= 0) {
    forget();
    if (!command.reset && dry) {
      resetting_ = false;
      limited_ = command.limit;
    }
  }
}

void Interpolator::forget() noexcept {
  head_ = count_ = 0;
  has_pending_ = false;
  added_to_ = position_;
  way_ = 0;
  waited_ = 0;
  strobe_ = answered_ = false;
}

}  // namespace cnc
