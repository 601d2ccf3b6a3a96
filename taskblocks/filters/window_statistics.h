// Mean, spread and extremes of the last samples. Sums that are corrected by adding the new and subtracting the old
// sample drift: rounding errors stay forever, and after a large value little is left of the small ones. Here nothing is
// ever subtracted: a binary tree holds the statistics of halves, quarters .. of the window, and a new sample renews
// those that it is in, 10 for 1024 samples. That is the same work in every cycle. Two stacks, which need O(1) on
// average, were measured against it: 33 ns for any window, where the tree takes 16 ns for 10 samples, 39 for 100 and 80
// for 1000; but they go through all samples in some cycles (12 us for 1000), and spreading that over the others takes a
// third stack and as many operations as the tree has up to some hundred samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace plc::blocks {

class WindowStatistics {
 public:
  /// Of some samples. The spread is the sum of squared distances from the mean.
  struct Summary {
    double count = 0;
    double mean = 0;
    double spread = 0;
    double lowest = 0;
    double highest = 0;

    [[nodiscard]] double deviation() const noexcept { return count > 1 ? std::sqrt(spread / (count - 1)) : 0; }
    [[nodiscard]] double rms() const noexcept { return count > 0 ? std::sqrt(mean * mean + spread / count) : 0; }
  };

  /// Not real-time. `window` samples, at least 1.
  explicit WindowStatistics(std::size_t window) : window_(window), nodes_(2 * window) {}

  /// RT: forgets all samples.
  void clear() noexcept {
    std::fill(nodes_.begin(), nodes_.end(), Summary{});
    next_ = 0;
  }

  /// RT: takes a finite sample; the oldest goes when the window is full.
  void add(double sample) noexcept {
    // The children of node i are 2i and 2i + 1; the samples are the leaves, from node `window_` on. Any size will do:
    // the order in which samples are combined is of no meaning.
    std::size_t node = window_ + next_;
    nodes_[node] = {1, sample, 0, sample, sample};
    for (node /= 2; node >= 1; node /= 2) nodes_[node] = combine(nodes_[2 * node], nodes_[2 * node + 1]);
    next_ = next_ + 1 < window_ ? next_ + 1 : 0;
  }

  /// RT: of the samples in the window.
  [[nodiscard]] const Summary& summary() const noexcept { return nodes_[1]; }

 private:
  /// T. F. Chan, G. H. Golub, R. J. LeVeque: Updating formulae and a pairwise algorithm for computing sample variances,
  /// 1979, equation 2.1.
  static Summary combine(const Summary& a, const Summary& b) noexcept {
    if (a.count == 0) return b;
    if (b.count == 0) return a;
    const double count = a.count + b.count;
    const double distance = b.mean - a.mean;
    return {count, a.mean + distance * (b.count / count),
            a.spread + b.spread + distance * distance * (a.count * b.count / count), std::min(a.lowest, b.lowest),
            std::max(a.highest, b.highest)};
  }

  std::size_t window_;
  std::size_t next_ = 0;  ///< leaf of the next sample
  std::vector<Summary> nodes_;
};

}  // namespace plc::blocks
