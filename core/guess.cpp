#include "core/guess.h"

#include <algorithm>

#include "core/text.h"

namespace plc::core {

void Guess::offer(std::string_view candidate) {
  const std::size_t limit = wrong_.size() <= 3 ? 1 : wrong_.size() <= 8 ? 2 : 3;
  if (candidate.empty() || candidate.find('#') != std::string_view::npos) return;
  const std::size_t longer = std::max(candidate.size(), wrong_.size());
  constexpr std::size_t kMaxLength = 64;
  if (longer > kMaxLength || longer - std::min(candidate.size(), wrong_.size()) > limit) return;
  std::size_t row[kMaxLength + 1];
  for (std::size_t j = 0; j <= candidate.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= wrong_.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= candidate.size(); ++j) {
      const std::size_t change = diagonal + (fold(wrong_[i - 1]) == fold(candidate[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  const std::size_t distance = row[candidate.size()];
  if (distance > limit || distance >= longer || (found_ && distance >= distance_)) return;
  best_ = std::string(candidate);
  distance_ = distance;
  found_ = true;
}

std::string Guess::help() const { return found_ ? "did you mean \"" + best_ + "\"?" : std::string{}; }

}  // namespace plc::core
