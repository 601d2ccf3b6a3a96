#include "tools/plc-run/run_log.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <utility>

#include "core/clock.h"
#include "log/file_sink.h"
#include "log/format.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

constexpr core::TimeNs kPatienceNs = 2'000'000'000;
constexpr std::string_view kProgram = "plc-run: ";

/// Whether stderr is the stream that systemd named to its service.
bool is_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The first code of a problem in a text: "P7510"; empty when it has none.
std::string code_in(std::string_view text) {
  constexpr std::size_t kLength = 5;
  for (std::size_t at = 0; at + kLength <= text.size(); ++at) {
    const bool begins = (text[at] == 'P' || text[at] == 'R') && (at == 0 || text[at - 1] == ' ');
    const std::string_view digits = text.substr(at + 1, kLength - 1);
    const bool ends = at + kLength == text.size() || text[at + kLength] == ':' || text[at + kLength] == ' ';
    if (begins && ends && std::all_of(digits.begin(), digits.end(), is_digit))
      return std::string(text.substr(at, kLength));
  }
  return {};
}

/// Whether the word stands as a severity does: "error P4001: ..", "file:1:2: warning: ..".
bool says(std::string_view line, std::string_view word) {
  const std::size_t at = line.find(word);
  if (at == std::string_view::npos || (at != 0 && line[at - 1] != ' ')) return false;
  const std::string_view rest = line.substr(at + word.size());
  return rest.starts_with(": ") || (rest.starts_with(" ") && rest.substr(1, 5) == code_in(rest));
}

core::Severity severity_of_line(std::string_view line) {
  if (says(line, "error")) return core::Severity::kError;
  if (says(line, "warning")) return core::Severity::kWarning;
  return line.starts_with(kProgram) ? core::Severity::kError : core::Severity::kNote;
}

io::LogFormat format_of(const io::Configuration& configuration, const std::optional<LogPlace>& place) {
  const io::LogFormat format = place ? place->format : configuration.log.format;
  const bool file = place ? !place->file.empty() : !configuration.log.file.text.empty();
  if (format != io::LogFormat::kAuto) return format;
  return !file && is_journal() ? io::LogFormat::kJournal : io::LogFormat::kText;
}

std::string stderr_line(const log::Record& record) { return log::text_line(record); }

}  // namespace

std::optional<LogPlace> parse_log_place(const std::string& text) {
  static constexpr std::pair<std::string_view, io::LogFormat> kFormats[] = {
      {"text", io::LogFormat::kText}, {"json", io::LogFormat::kJson}, {"journal", io::LogFormat::kJournal}};
  const std::size_t colon = text.find(':');
  for (const auto& [word, format] : kFormats) {
    if (text.substr(0, colon) != word) continue;
    if (colon == std::string::npos) return LogPlace{format, {}};
    if (colon + 1 < text.size()) return LogPlace{format, text.substr(colon + 1)};
  }
  return std::nullopt;
}

log::Record record_of_line(std::string line) {
  log::Record record;
  record.severity = severity_of_line(line);
  record.code = code_in(line);
  for (const std::string_view prefix : {std::string_view("error "), std::string_view("warning "), kProgram}) {
    if (line.starts_with(prefix)) {
      line.erase(0, prefix.size());
      break;
    }
  }
  record.text = std::move(line);
  return record;
}

// WHY no end of the record: std::cerr does this after every piece of a line.
int LineBuffer::sync() { return also_ != nullptr ? also_->pubsync() : 0; }

LineBuffer::int_type LineBuffer::overflow(int_type character) {
  if (!traits_type::eq_int_type(character, traits_type::eof())) {
    const char one = traits_type::to_char_type(character);
    xsputn(&one, 1);
  }
  return traits_type::not_eof(character);
}

std::streamsize LineBuffer::xsputn(const char* text, std::streamsize count) {
  if (also_ != nullptr) also_->sputn(text, count);
  for (const char c : std::string_view(text, static_cast<std::size_t>(count))) {
    if (c == '\n') {
      take_line(std::exchange(line_, {}));
    } else {
      line_ += c;
    }
  }
  return count;
}

void LineBuffer::take_line(std::string line) {
  if (line.empty()) return end_record();
  if (line.front() == ' ' && record_) {
    record_->details += (record_->details.empty() ? "" : "\n") + line;
    return;
  }
  end_record();
  record_ = record_of_line(std::move(line));
}

void LineBuffer::end_record() {
  if (!record_) return;
  record_->shown = also_ != nullptr;
  log_.write(*std::exchange(record_, std::nullopt));
}

RunLog::RunLog(const io::Configuration& configuration, const std::optional<LogPlace>& place,
               std::optional<core::Severity> level, Output& output, std::ostream& talk)
    : err_(&output.err()), talk_(talk.rdbuf()) {
  const io::LogConfig& config = configuration.log;
  const io::LogFormat format = format_of(configuration, place);
  const std::string file = place ? place->file : configuration.beside(config.file.text);
  const log::Options options{level.value_or(config.level), config.repeat_ns, config.most};
  const auto line = format == io::LogFormat::kJson ? &log::json_line : &stderr_line;
  std::unique_ptr<log::Sink> sink;
  if (format == io::LogFormat::kJournal) {
    sink = log::journal_sink(file.empty() ? log::kJournalSocket : file);
  } else if (file.empty()) {
    sink = log::stream_sink(err_, line);
  } else {
    sink = std::make_unique<log::FileSink>(
        log::FileOptions{file, std::uint64_t{config.size_mb} * 1'000'000, config.keep, line});
  }
  log_ = std::make_unique<log::Log>(options, std::move(sink), file.empty() ? "the journal" : file, err_);
  if (format == io::LogFormat::kText && file.empty()) return;
  // In the journal, and among lines of JSON, everything is a record; beside a file people read what they always do.
  const bool beside = format != io::LogFormat::kJournal && !file.empty();
  cerr_ = std::make_unique<LineBuffer>(*log_, beside ? std::cerr.rdbuf() : nullptr);
  talked_ = std::make_unique<LineBuffer>(*log_, format == io::LogFormat::kJournal ? nullptr : talk.rdbuf());
  if (&talk == &std::cerr) {
    talk_.rdbuf(cerr_.get());
  } else {
    talk_.rdbuf(talked_.get());
  }
  cerr_before_ = std::cerr.rdbuf(cerr_.get());
}

RunLog::~RunLog() {
  stop();
  if (cerr_before_ != nullptr) std::cerr.rdbuf(cerr_before_);
}

void RunLog::say(core::Severity severity, std::string text, std::string source) {
  log::Record record;
  record.severity = severity;
  record.code = code_in(text);
  record.text = std::move(text);
  record.source = std::move(source);
  log_->write(std::move(record));
}

void RunLog::say_fault(const runtime::Resource& resource, const runtime::TaskFault& fault) {
  log::Record record;
  record.severity = core::Severity::kError;
  record.text = fault_text(resource, fault);
  record.code = code_in(record.text);
  record.task = resource.image().tasks[fault.task].name;
  record.scan = fault.cycle;
  const std::string block = resource.program(fault.task).taskblock_text(fault.fault);
  record.block = block.substr(0, block.find(": "));
  log_->write(std::move(record));
}

void RunLog::say_messages(runtime::Resource& resource) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    runtime::Program& program = resource.program(task);
    for (runtime::TaskblockMessage& message : program.messages()) {
      log::Record record;
      record.severity = message.severity;
      record.text = fmt::format("{}: {}", message.taskblock, message.text);
      record.source = "taskblock";
      record.task = program.task().name;
      record.block = std::move(message.taskblock);
      record.scan = message.scan;
      record.utc_ns = message.utc_ns;
      log_->write(std::move(record));
    }
    if (const std::uint64_t lost = program.lost_messages(); lost != 0) {
      say(core::Severity::kWarning,
          fmt::format("{} messages of the taskblocks of task {} are lost: more came at once than there is room for",
                      lost, program.task().name));
    }
  }
}

void RunLog::end_records() {
  std::cerr.flush();
  talk_.flush();
  if (cerr_) cerr_->end_record();
  if (talked_) talked_->end_record();
}

void RunLog::service() {
  end_records();
  log_->service();
}

void RunLog::stop() {
  if (std::exchange(stopped_, true)) return;
  end_records();
  log_->stop(kPatienceNs);
}

}  // namespace plc::tools
