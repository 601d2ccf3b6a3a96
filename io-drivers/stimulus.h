// Stimulus: inputs scripted in a CSV file, for simulation and tests.
//
// In: "time_ms,path,path,..." and rows of values in ascending time; time_ms may be fractional, an empty cell keeps the
// value, '' or "" in quotes is the empty string. Out: variables written at the first release instant at or after each
// row's time, through Access, so normalised. All values are checked when the script is loaded: later a value is lost
// only when its task does not take writes any more (lost()). Problems are "file:line:column: ..." with P72xx codes.
// Does not belong here: devices, real or simulated.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "runtime/access.h"
#include "runtime/sched/simulation.h"

namespace plc::io {

class Stimulus {
 public:
  /// Parses `text`; `file` names it in problems.
  static core::Result<Stimulus> parse(std::string_view text, std::string_view file, runtime::Resource& resource);
  /// Reads and parses a file.
  static core::Result<Stimulus> load(const std::string& path, runtime::Resource& resource);

  /// Takes a value of a row: text that stands for a value of the place's type.
  using Sink = std::function<void(const runtime::Place&, std::string_view)>;
  /// Hands on every row that is due at `now_ns` and was not handed on yet.
  void apply(core::TimeNs now_ns, const Sink& sink);
  /// The same, into the variables; what cannot be written is counted.
  void apply(core::TimeNs now_ns);
  /// Writes one value, or counts it as lost; `now_ns` is for the message.
  void write(const runtime::Place& place, std::string_view text, core::TimeNs now_ns);
  /// The first row is the next one again.
  void restart() { next_ = 0; }
  /// Values that could not be written, and why the first could not (P7107).
  struct Lost {
    std::uint64_t values = 0;
    std::optional<core::Problem> first;
  };
  [[nodiscard]] const Lost& lost() const { return lost_; }
  /// Applies rows at each instant of `simulation`; the driver must outlive it.
  void attach(runtime::Simulation& simulation);
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  /// The variables of its columns.
  [[nodiscard]] const std::vector<runtime::Place>& places() const { return places_; }
  /// In real time a stimulus is applied by `task`, and names globals and variables of that task only: P7205 otherwise.
  /// `name` is the stimulus, for the message.
  [[nodiscard]] std::optional<core::Problem> check_real_time(std::string_view name, std::uint32_t task) const;
  /// Time of the last row, 0 without rows.
  [[nodiscard]] core::TimeNs end_ns() const { return rows_.empty() ? 0 : rows_.back().time_ns; }

 private:
  struct Value {
    std::uint32_t column = 0;
    std::string text;
  };
  struct Row {
    core::TimeNs time_ns = 0;
    std::vector<Value> values;
  };
  explicit Stimulus(runtime::Resource& resource) : resource_(&resource), access_(resource) {}
  const runtime::Resource* resource_;
  runtime::Access access_;
  std::vector<runtime::Place> places_;
  std::vector<Row> rows_;
  std::size_t next_ = 0;
  Lost lost_;
};

/// Milliseconds as decimal text, with up to six digits after the point ("12.5"), as ns; nothing when it is not such a
/// number.
std::optional<core::TimeNs> parse_time_ms(std::string_view text);
/// ns as milliseconds in the shortest decimal form ("12.5").
void append_time_ms(std::string& out, core::TimeNs time_ns);

}  // namespace plc::io
