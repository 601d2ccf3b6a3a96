#include "log/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "log/format.h"

namespace plc::log {
namespace {

constexpr core::TimeNs kSumsNs = 1'000'000'000;

/// Lines after the first belong to the message, and begin with a blank: none of them looks like another one.
void split_lines(Record& record) {
  const std::size_t end = record.text.find('\n');
  if (end == std::string::npos) return;
  std::string lines;
  for (std::size_t at = end; at < record.text.size();) {
    const std::size_t next = std::min(record.text.find('\n', at + 1), record.text.size());
    const std::string_view line = std::string_view(record.text).substr(at + 1, next - at - 1);
    if (!line.empty()) lines += fmt::format("{}{}{}", lines.empty() ? "" : "\n", line.front() == ' ' ? "" : "  ", line);
    at = next;
  }
  record.text.resize(end);
  if (record.details.empty() || lines.empty()) {
    record.details += lines;
  } else {
    record.details = lines + "\n" + record.details;
  }
}

}  // namespace

Log::Log(const Options& options, std::unique_ptr<Sink> sink, std::string name, std::ostream& aside)
    : options_(options),
      sink_(std::move(sink)),
      name_(std::move(name)),
      aside_(aside),
      limiter_(options.repeat_ns, options.most) {}

void Log::write(Record record) {
  if (record.severity < options_.level) return;
  if (record.utc_ns == 0) record.utc_ns = calendar_.utc_ns();
  split_lines(record);
  if (limiter_.admit(record, clock_.now_ns())) emit(record);
}

void Log::emit(const Record& record) {
  if (!problem_.empty() && !record.shown && record.severity >= core::Severity::kWarning) {
    Record shown = record;
    shown.shown = true;
    aside_ << text_line(record);
    sink_->write(shown);
  } else {
    sink_->write(record);
  }
  if (tell_) tell_(record);
}

void Log::show_waiting(core::Severity least) {
  for (const Record& record : sink_->take_unshown(least)) aside_ << text_line(record);
}

void Log::service() {
  const core::TimeNs now_ns = clock_.now_ns();
  if (now_ns >= next_sums_ns_) {
    next_sums_ns_ = now_ns + kSumsNs;
    for (const Record& sum : limiter_.sums(now_ns, calendar_.utc_ns())) emit(sum);
  }
  sink_->flush();
  look_at_sink();
}

void Log::stop(core::TimeNs patience_ns) {
  for (const Record& sum : limiter_.sums(clock_.now_ns(), calendar_.utc_ns(), true)) emit(sum);
  sink_->stop(patience_ns);
  look_at_sink();
  show_waiting(options_.level);
  if (const std::uint64_t lost = sink_->lost(); lost != 0) {
    Record record;
    record.utc_ns = calendar_.utc_ns();
    record.severity = core::Severity::kWarning;
    record.text = fmt::format("{} messages are lost: {} could not be written in time", lost, name_);
    aside_ << text_line(record);
  }
}

void Log::look_at_sink() {
  std::string problem = sink_->problem();
  if (problem == problem_) {
    if (!problem_.empty()) show_waiting(core::Severity::kWarning);
    return;
  }
  Record record;
  record.utc_ns = calendar_.utc_ns();
  record.severity = problem.empty() ? core::Severity::kNote : core::Severity::kWarning;
  record.text = problem.empty() ? fmt::format("the log is written again to {}", name_)
                                : fmt::format("{}: the log cannot be written to {}: {}; it is tried again",
                                              core::info(core::Code::P7620).name, name_, problem);
  aside_ << text_line(record);
  problem_ = std::move(problem);
  // Also what was written to the sink before that was known.
  if (!problem_.empty()) show_waiting(core::Severity::kWarning);
}

}  // namespace plc::log
