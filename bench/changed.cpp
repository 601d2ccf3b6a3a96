// Scans that leave out what did not change against scans that execute everything, both native code, on a plain ladder.
// What the latter compute is compared with C and the interpreter elsewhere (scan.cpp).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iostream>
#include <memory>
#include <vector>

#include "bench/bench.h"
#include "bench/limits.h"
#include "bench/process.h"
#include "bench/side.h"

namespace plc::bench {
namespace {

constexpr core::TimeNs kPeriodNs = 20'000'000;
/// About what a batch of full evaluation takes: so long that caches which the other side filled do not count.
constexpr double kBatchNs = 4e7;

enum : std::size_t { kFull, kChanged, kSides };
using Times = std::array<double, kSides>;  ///< nanoseconds per scan

struct Row {
  const char* name;
  std::size_t inputs;  ///< that are inverted before each scan, at most
  const Limit* limit;  ///< of changed / full; null = none
};
constexpr Row kRows[] = {
    {"nothing", 0, nullptr},
    {"one input", 1, &limit::kOneInput},
    {"all inputs", ~std::size_t{0}, &limit::kAllInputs},
};

class Comparison {
 public:
  Comparison(const bytecode::VerifiedImage& image, const Source& source, const Row& row) : source_(source) {
    for (std::uint32_t i = 0; i < source.variables.size(); ++i) {
      if (source.variables[i].stimulus == Stimulus::kBool) inputs_.push_back(i);
    }
    changes_ = std::min(row.inputs, inputs_.size());
    sides_[kFull] = make_plc_side(image, source, Engine::kNative);
    sides_[kChanged] = make_plc_side(image, source, Engine::kNativeChanged);
    for (const auto& side : sides_) good_ = good_ && side != nullptr;
  }
  /// `scans` scans of each side, one after the other; all see the same.
  Times round(std::uint32_t scans) {
    Times times{};
    for (std::size_t s = 0; s < kSides && good_; ++s) {
      const core::TimeNs begin = own_time_ns();
      for (std::uint32_t i = 1; i <= scans; ++i) {
        // Somewhere else in each scan, found in a few steps: they count on both sides.
        const auto hash = static_cast<std::uint32_t>((scans_ + i) * 2654435761u);
        std::size_t input = std::uint64_t{hash} * inputs_.size() >> 32;
        for (std::size_t n = 0; n < changes_; ++n) {
          *sides_[s]->variables()[inputs_[input]] ^= 1;
          if (++input == inputs_.size()) input = 0;
        }
        good_ = sides_[s]->scan(static_cast<core::TimeNs>(scans_ + i) * kPeriodNs) && good_;
      }
      times[s] = static_cast<double>(own_time_ns() - begin) / scans;
    }
    scans_ += scans;
    return times;
  }
  /// False when variables of the sides differ, or a scan ended in a fault.
  [[nodiscard]] bool same() const {
    for (std::size_t i = 0; i < source_.variables.size() && good_; ++i) {
      const unsigned char* const full = sides_[kFull]->variables()[i];
      if (std::memcmp(full, sides_[kChanged]->variables()[i], source_.variables[i].bytes) != 0) return false;
    }
    return good_;
  }

 private:
  const Source& source_;
  std::array<std::unique_ptr<Side>, kSides> sides_;
  std::vector<std::uint32_t> inputs_;
  std::size_t changes_ = 0;
  std::uint64_t scans_ = 0;
  bool good_ = true;
};

void measure(const bytecode::VerifiedImage& image, const Source& source, const Row& row, const ChangedPlan& plan,
             Verdict& verdict) {
  Comparison comparison(image, source, row);
  bool same = comparison.same();
  for (std::uint32_t i = 0; i < plan.scans && same; ++i) {
    comparison.round(1);
    same = comparison.same();
  }
  std::string line = fmt::format("{:<12} {:>6}", row.name, plan.scans);
  if (same && plan.batches != 0) {
    std::uint32_t scans = 1;
    while (comparison.round(scans)[kFull] * scans < kBatchNs) scans *= 2;
    std::vector<double> full, changed, ratios;
    for (std::uint32_t i = 0; i < plan.batches && same; ++i) {
      const Times times = comparison.round(scans);
      full.push_back(times[kFull]);
      changed.push_back(times[kChanged]);
      ratios.push_back(times[kChanged] / times[kFull]);
      same = comparison.same();
    }
    const double ratio = median(ratios);
    const std::string limit = row.limit == nullptr ? "" : ", " + limit_text(ratio, *row.limit, verdict);
    line += fmt::format(" | {:>8.0f} {:>8.0f} | {:.3f}{}", median(full), median(changed), ratio, limit);
  }
  if (!same) line += " VARIABLES DIFFER";
  verdict.correct = verdict.correct && same;
  std::cout << line << std::endl;
}

}  // namespace

Verdict measure_changed(const ChangedPlan& plan) {
  Verdict verdict;
  const Source source = find_workload("plain")->make(plan.rungs, plan.seed);
  const auto image = compile_project(source);
  if (!image) return {false, true};
  std::cout << fmt::format("evaluate = \"changed\" against full evaluation, native code, {} plain rungs, ns per scan\n",
                           plan.rungs)
            << fmt::format("{:<12} {:>6} | {:>8} {:>8} | changed/full\n", "changing", "scans", "full", "changed");
  for (const Row& row : kRows) measure(*image, source, row, plan, verdict);
  return verdict;
}

}  // namespace plc::bench
