// TextJumps: where the characters of a text do not simply follow one another in the file that it was read from.
//
// In: the reader of a file with markup: entities, sections, comments and tags inside of a text, carriage returns that
// the markup makes line ends. Out: the place of the next character. Does not belong here: what a text says.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plc::core {

/// A line and a column, as in SourceRef. One rule for every kind of file: a line ends with LF, whatever comes before
/// it (CR LF, CR CR LF); a CR alone is a character of its line. Columns count characters.
struct Spot {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 means the 0 of the generated comparison.
  friend auto operator<=>(const Spot&, const Spot&) = default;
};

/// All jumps of one file.
class TextJumps {
 public:
  struct Jump {
    Spot at;    ///< of a character
    Spot next;  ///< of the one that follows it in the text
  };
  /// Beyond this many, columns are only near: a file of nothing but entities must not take more memory than its text.
  static constexpr std::size_t kMost = std::size_t{1} << 20;

  /// Mostly in ascending order of `at`. For a place that is known, `next` is replaced.
  void add(const Spot& at, const Spot& next) {
    if (jumps_.empty() || jumps_.back().at < at) {
      if (jumps_.size() < kMost) jumps_.push_back({at, next});
      return;
    }
    const std::size_t index = first_from(at);
    if (jumps_[index].at == at) {
      jumps_[index].next = next;
    } else if (jumps_.size() < kMost) {
      jumps_.insert(jumps_.begin() + static_cast<std::ptrdiff_t>(index), {at, next});
    }
  }
  /// Index of the first jump at or after `at`.
  [[nodiscard]] std::size_t first_from(const Spot& at) const {
    const auto found = std::lower_bound(jumps_.begin(), jumps_.end(), at,
                                        [](const Jump& jump, const Spot& spot) { return jump.at < spot; });
    return static_cast<std::size_t>(found - jumps_.begin());
  }
  [[nodiscard]] const std::vector<Jump>& all() const { return jumps_; }

 private:
  std::vector<Jump> jumps_;
};

}  // namespace plc::core
