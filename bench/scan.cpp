#include "bench/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>

#include "bench/inputs.h"
#include "bench/process.h"
#include "core/clock.h"

namespace plc::bench {
namespace {

constexpr core::TimeNs kPeriodNs = 20'000'000;
constexpr double kBatchNs = 1e6;                       ///< about what a batch of the C takes
constexpr std::uint64_t kComparedBytes = 100'000'000;  ///< at most, in the scans that are checked

constexpr const char* kNames[kSides] = {"C", "C without barriers", "interpreter", "native"};
using Times = std::array<double, kSides>;  ///< nanoseconds per scan

class Comparison {
 public:
  explicit Comparison(const Source& source) : source_(source) {}
  /// False when one of them could not be made.
  bool make(const Workload& workload, const ScanPlan& plan) {
    const auto image = compile_project(source_);
    if (!image) return false;
    wanted_ = {plan.c, plan.plain_c && workload.barriers, true, true};
    if (wanted_[kC]) sides_[kC] = make_c_side(*image, source_, true);
    if (wanted_[kPlainC]) sides_[kPlainC] = make_c_side(*image, source_, false);
    sides_[kInterpreter] = make_plc_side(*image, source_, Engine::kInterpreter);
    sides_[kNative] = make_plc_side(*image, source_, Engine::kNative);
    for (std::size_t s = 0; s < kSides; ++s) {
      if (!wanted_[s]) continue;
      if (sides_[s] == nullptr) return false;
      inputs_[s].emplace(source_, *sides_[s], workload.inputs);
    }
    first_side_ = wanted_[kC] ? kC : kInterpreter;
    for (std::size_t i = 0; i < source_.variables.size(); ++i) {
      const unsigned char* at = sides_[first_side_]->variables()[i];
      first_.insert(first_.end(), at, at + source_.variables[i].bytes);
    }
    changed_.resize(source_.variables.size());
    return true;
  }

  /// `scans` scans of each side, one after the other, with inputs changing before each; all see the same.
  Times round(std::uint32_t scans) {
    Times times{};
    for (std::size_t s = 0; s < kSides; ++s) {
      if (!wanted_[s]) continue;
      const core::TimeNs begin = own_time_ns();
      for (std::uint32_t i = 1; i <= scans; ++i) {
        inputs_[s]->write(scans_ + i);
        good_ = sides_[s]->scan(now_ns(scans_ + i)) && good_;
      }
      times[s] = static_cast<double>(own_time_ns() - begin) / scans;
    }
    scans_ += scans;
    return times;
  }
  /// Variables of all sides now. False, and the first ones on stderr, when some differ or a scan ended in a fault.
  bool same() {
    std::uint32_t differences = 0;
    std::size_t first = 0;
    for (std::size_t i = 0; i < source_.variables.size(); ++i) {
      const std::uint32_t bytes = source_.variables[i].bytes;
      const unsigned char* expected = sides_[first_side_]->variables()[i];
      for (std::size_t s = first_side_ + 1; s < kSides; ++s) {
        if (!wanted_[s]) continue;
        const unsigned char* found = sides_[s]->variables()[i];
        if (std::memcmp(expected, found, bytes) == 0 || differences++ >= 5) continue;
        const std::size_t at =
            static_cast<std::size_t>(std::mismatch(expected, expected + bytes, found).first - expected);
        std::cerr << fmt::format("scan {}: {}, byte {} of {}: {} has {:#x}, {} {:#x}\n", scans_,
                                 source_.variables[i].path, at, bytes, kNames[first_side_], expected[at], kNames[s],
                                 found[at]);
      }
      if (!changed_[i]) changed_[i] = std::memcmp(expected, &first_[first], bytes) != 0;
      first += bytes;
    }
    return differences == 0 && good_;
  }
  /// Of the variables, those that same() has seen change; percent. What stands still compares nothing.
  [[nodiscard]] double alive() const {
    return 100.0 * static_cast<double>(std::count(changed_.begin(), changed_.end(), true)) /
           static_cast<double>(changed_.size());
  }
  [[nodiscard]] std::uint64_t scans() const { return scans_; }
  /// What same() compares of each side.
  [[nodiscard]] std::size_t bytes() const { return first_.size(); }
  [[nodiscard]] bool has(std::size_t side) const { return wanted_[side]; }
  /// The one that all others are compared with.
  [[nodiscard]] std::size_t first_side() const { return first_side_; }
  [[nodiscard]] const Side& operator[](std::size_t side) const { return *sides_[side]; }

 private:
  static core::TimeNs now_ns(std::uint64_t scan) { return static_cast<core::TimeNs>(scan) * kPeriodNs; }

  const Source& source_;
  std::array<std::unique_ptr<Side>, kSides> sides_;
  std::array<bool, kSides> wanted_{};
  std::size_t first_side_ = kC;
  std::array<std::optional<InputWriter>, kSides> inputs_;
  std::vector<unsigned char> first_;  ///< variables before the first scan
  std::vector<bool> changed_;         ///< ... and which of them had another value since
  std::uint64_t scans_ = 0;
  bool good_ = true;
};

}  // namespace

std::string scan_head() {
  return fmt::format("{:<20} {:>7} {:>6} {:>5} | {:>8} {:>8} {:>8} {:>8} | {:>17} {:>17} {:>17} {:>17}\n", "workload",
                     "size", "scans", "alive", "C", "plain C", "interp", "native", "native/interp", "interp/C",
                     "native/C", "native/plain C");
}

ScanResult measure_scan(const Workload& workload, const ScanPlan& plan) {
  ScanResult result;
  const Source source = workload.make(plan.size, plan.seed);
  Comparison comparison(source);
  std::string line = fmt::format("{:<20} {:>7}", workload.name, plan.size);
  if (!comparison.make(workload, plan)) {
    std::cout << line << " could not be built" << std::endl;
    result.verdict.correct = false;
    return result;
  }
  for (std::size_t s = 0; s < kSides; ++s) {
    if (comparison.has(s)) result.footprints[s] = comparison[s].footprint();
  }
  const std::uint64_t most = std::max<std::uint64_t>(20, kComparedBytes / comparison.bytes());
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(plan.scans, most) && result.verdict.correct; ++i) {
    comparison.round(1);
    result.verdict.correct = comparison.same();
  }
  line += fmt::format(" {:>6} {:>4.0f}%", comparison.scans(), comparison.alive());
  if (!result.verdict.correct) line += " VARIABLES DIFFER";
  if (result.verdict.correct && plan.batches != 0) {
    std::uint32_t scans = 1;
    while (comparison.round(scans)[comparison.first_side()] * scans < kBatchNs) scans *= 2;
    std::array<std::vector<double>, kSides> times, to_c;
    std::vector<double> to_plain, to_interpreter;
    for (std::uint32_t i = 0; i < plan.batches; ++i) {
      const Times batch = comparison.round(scans);
      for (std::size_t s = 0; s < kSides; ++s) {
        times[s].push_back(batch[s] / plan.size);
        to_c[s].push_back(batch[s] / batch[kC]);
      }
      to_interpreter.push_back(batch[kNative] / batch[kInterpreter]);
      to_plain.push_back(batch[kNative] / batch[kPlainC]);
    }
    result.verdict.correct = comparison.same();
    line += " |";
    for (std::size_t s = 0; s < kSides; ++s) {
      result.ns[s] = median(times[s]);
      line += result.ns[s] == 0 ? fmt::format(" {:>8}", "") : fmt::format(" {:>8.3g}", result.ns[s]);
    }
    line += " |";
    const auto against = [&](const std::vector<double>& ratios, const Limit* limit) {
      const double ratio = median(ratios);
      const std::string text = limit == nullptr ? "" : ", " + limit_text(ratio, *limit, result.verdict);
      line += fmt::format(" {:>17}", fmt::format("{:.2f}{}", ratio, text));
    };
    against(to_interpreter, workload.limits.native_interpreter);
    if (comparison.has(kC)) {
      against(to_c[kInterpreter], workload.limits.interpreter);
      against(to_c[kNative], workload.limits.native);
    }
    if (comparison.has(kPlainC)) against(to_plain, workload.limits.native_plain);
    if (!result.verdict.correct) line += " VARIABLES DIFFER";
  }
  std::cout << line << std::endl;
  return result;
}

}  // namespace plc::bench
