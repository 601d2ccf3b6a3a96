// Guess: what a misspelt name was meant to be.
//
// In: the name as written, the names there are. Out: a help line. Letter case is ignored; far candidates are not
// offered. Does not belong here: looking names up.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace plc::core {

/// Collects candidates and keeps the one nearest to a misspelt name.
class Guess {
 public:
  explicit Guess(std::string_view wrong) : wrong_(wrong) {}
  void offer(std::string_view candidate);
  /// The nearest, or empty.
  [[nodiscard]] const std::string& best() const { return best_; }
  /// "did you mean \"Start\"?", or empty when nothing is near.
  [[nodiscard]] std::string help() const;

 private:
  std::string_view wrong_;
  std::string best_;
  std::size_t distance_ = 0;
  bool found_ = false;
};

}  // namespace plc::core
