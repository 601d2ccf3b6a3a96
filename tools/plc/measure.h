// Measuring what scans, functions and blocks take on this machine.
//
// In: texts of probes, the tables of the library. Out: times and a CostTable. Times are the kPercentile of many
// repetitions. Scans are measured as they come after a task has slept, with caches full of other things, and again at
// once, as loops repeat themselves. Does not belong here: printing, what programs to measure (probes.h).
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "runtime/resource.h"
#include "runtime/sched/cost_table.h"

namespace plc::tools {

/// Share of the repetitions that took at most the time that counts: one in ten meets an interrupt or worse, which is
/// not the program's.
inline constexpr double kPercentile = 0.9;

class Meter {
 public:
  /// Repetitions of each measurement.
  explicit Meter(std::uint32_t repetitions);
  ~Meter();

  /// A project of probes.h, ready to run. P9001 when it does not compile: a defect of plc itself.
  core::Result<std::unique_ptr<runtime::Resource>> load(std::string_view text);
  /// Scans of the first task of each: the first time and again. They take turns, so that what disturbs the machine for
  /// a while disturbs all of them.
  struct Subject {
    runtime::Resource* resource = nullptr;
    bool partner = false;  ///< the second task runs before it
  };
  std::vector<runtime::Cost> scans(const std::vector<Subject>& subjects);

  /// What the system takes around each release of a task.
  runtime::Cost release();
  /// Taking the lock of the global table and giving it back, by halves.
  runtime::Cost lock();
  /// A change of the own priority.
  runtime::Cost priority();

  /// The quickest and the slowest call of a function or step of a block that values of its types bring about, in ns.
  struct Range {
    double least = std::numeric_limits<double>::max();
    double most = 0;
    void join(double ns);
  };
  Range function(const stdlib::Overload& overload);
  Range block(const stdlib::BlockSpec& block);

 private:
  void forget();
  [[nodiscard]] double percentile(std::vector<double>& times) const;
  double timed(const std::function<void()>& work) const;

  std::uint32_t repetitions_;
  std::string folder_;  ///< of the texts while they are read
  std::vector<std::uint8_t> others_;
  double clock_ns_ = 0;  ///< of reading the clock itself
  core::TimeNs now_ns_ = 0;
};

/// Everything, in the order of costs.def. `tell`: each kind when it is known.
core::Result<runtime::CostTable> calibrate(Meter& meter, const std::function<void(std::string_view)>& tell);

/// The processor's name and how many there are: "AMD EPYC, 2 processors".
std::string machine_text();

}  // namespace plc::tools
