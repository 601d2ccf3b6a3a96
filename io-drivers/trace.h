// TraceWriter: values of variables at every release instant, as CSV.
//
// In: paths, release instants of a simulation. Out: "cycle,time_ms,path,..." and one row per instant, values as Access
// writes them, LF line ends. Buffered; a failing file is reported by close(). Does not belong here: comparing traces
// (tools).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "runtime/access.h"
#include "runtime/sched/simulation.h"

namespace plc::io {

class TraceWriter {
 public:
  /// Resolves the paths (P7101, P7102) and opens `file`; "-" is standard output, an empty name keeps everything in
  /// memory.
  static core::Result<std::unique_ptr<TraceWriter>> open(const std::string& file, const std::vector<std::string>& paths,
                                                         runtime::Resource& resource,
                                                         runtime::ValueStyle style = runtime::ValueStyle::kNumbers);
  ~TraceWriter();
  TraceWriter(const TraceWriter&) = delete;
  TraceWriter& operator=(const TraceWriter&) = delete;

  void record(const runtime::Instant& instant);
  /// Records after each instant of `simulation`; the writer must outlive it.
  void attach(runtime::Simulation& simulation);
  /// Writes what is buffered. Returns the problem (P7203) when any write failed.
  std::optional<core::Problem> close();
  /// What was written so far when the trace is kept in memory.
  [[nodiscard]] const std::string& text() const { return buffer_; }

 private:
  TraceWriter(int descriptor, runtime::Resource& resource) : descriptor_(descriptor), access_(resource) {}
  void flush();
  runtime::ValueStyle style_ = runtime::ValueStyle::kNumbers;
  int descriptor_;  ///< -1 = in memory
  int error_ = 0;   ///< errno of the first write that failed
  std::string name_;
  runtime::Access access_;
  std::vector<runtime::Place> places_;
  std::vector<std::uint8_t> may_need_quotes_;  ///< per place: text
  std::string buffer_;
};

}  // namespace plc::io
