// FILE_LOGGER: signals into a CSV file. The example of a block that needs I/O: the file belongs to a thread of its own,
// fire() puts a line into a ring and goes on.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>

#include "picard/taskblock.h"
#include "taskblocks/signals/csv_log.h"

namespace plc::blocks {

class FileLogger final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "FILE_LOGGER",
      .group = "Signals",
      .summary = "Writes up to eight signals into a CSV file without making the task wait.",
      .details =
          "Each execution with ENABLE is a line: `utc`, the date and time of the first line plus the time since; "
          "`time_s`, "
          "the seconds since the first line by the task's clock; and one value for each name in COLUMNS, from IN1 on, "
          "in "
          "the shortest form that reads back the same (`nan`, `inf` and `-inf` are written so).\n\n"
          "The task never waits: lines go through a ring of BUFFER lines to a thread that opens the file and writes "
          "them every 20 ms. When the disk is slower than that, lines are dropped and DROPPED counts them: after the "
          "end, WRITTEN + DROPPED is the number of lines there should be. A file that cannot be made or written does "
          "not stop the program: ERROR is the number that Linux gives the reason (28: the disk is full, 30: it may "
          "only be read, 13: the rights are missing, 2: no such directory), the operator is told in the log of "
          "plc-run, "
          "whole lines stay, lines wait in the ring, "
          "and it is tried again every second until it can be done. With LIMIT megabytes the file is complete: ERROR "
          "is 27, and nothing more is written. When the program ends, what waits is written down to the disk.\n\n"
          "`utc` follows the clock of the machine: when that is set, as NTP does after the start, so are the lines "
          "from there on. `time_s` never jumps.\n\n"
          "FILE is a name without folders; letters, digits, `.`, `_` and `-`. The file lies in the directory that the "
          "environment variable PICARD_LOG_DIRECTORY names, otherwise in the one the program was started in. No line "
          "is ever overwritten. IF_EXISTS says what happens when there is such a file: `NUMBER` takes the first free "
          "one of log-1.csv, log-2.csv .. log-9999.csv; `APPEND` goes on in it, or in the first of these that has the "
          "same columns or is not there (what a loss of power left of a header, and bytes of 0 at the end, are cut "
          "off); `REFUSE` writes nothing while there is one. ERROR is 17 when no name is free, and 11 while another "
          "logger writes the file."};

  picard::Input<double> in[CsvLog::kColumns]{
      {this, "IN1", "value of the first column"},   {this, "IN2", "value of the second column"},
      {this, "IN3", "value of the third column"},   {this, "IN4", "value of the fourth column"},
      {this, "IN5", "value of the fifth column"},   {this, "IN6", "value of the sixth column"},
      {this, "IN7", "value of the seventh column"}, {this, "IN8", "value of the eighth column"}};
  picard::Input<bool> enable{this, "ENABLE", "TRUE: write a line", {.initial = "TRUE"}};
  picard::Config<picard::Text<80>> file{this, "FILE", "name of the file", {.initial = "'log.csv'"}};
  picard::Config<picard::Text<200>> columns{
      this, "COLUMNS", "names of the columns, separated by commas: as many are written", {.initial = "'IN1'"}};
  picard::Config<picard::Text<16>> if_exists{this, "IF_EXISTS", "NUMBER, APPEND or REFUSE", {.initial = "'NUMBER'"}};
  picard::Config<std::int32_t> buffer{
      this, "BUFFER", "lines that may wait", {.lowest = 16, .highest = 65536, .initial = "4096"}};
  picard::Config<std::int32_t> limit{
      this, "LIMIT", "size of the file at most, 0 = any", {.unit = "MB", .lowest = 0, .initial = "100"}};
  picard::Output<std::uint64_t> written{this, "WRITTEN", "lines in the file"};
  picard::Output<std::uint64_t> dropped{this, "DROPPED", "lines that are lost"};
  picard::Output<std::int32_t> error{this, "ERROR", "why nothing is written at present, 0 = it is"};

  void ready() override {
    CsvLog::Options options;
    const char* const directory = std::getenv("PICARD_LOG_DIRECTORY");
    options.directory = directory != nullptr && *directory != '\0' ? directory : ".";
    options.file = std::string(file->view());
    options.columns = CsvLog::columns_of(columns->view());
    if (if_exists->view() == "NUMBER") {
      options.if_exists = CsvLog::IfExists::Number;
    } else if (if_exists->view() == "APPEND") {
      options.if_exists = CsvLog::IfExists::Append;
    } else if (if_exists->view() == "REFUSE") {
      options.if_exists = CsvLog::IfExists::Refuse;
    } else {
      throw picard::Failure("IF_EXISTS is none of NUMBER, APPEND, REFUSE");
    }
    options.lines = static_cast<std::size_t>(buffer.get());
    options.limit = static_cast<std::uint64_t>(limit.get()) * 1'000'000;
    log_.emplace(options);
  }

  void fire() override {
    if (enable) {
      CsvLog::Line line{now().count(), {}};
      for (std::size_t i = 0; i < CsvLog::kColumns; ++i) line.values[i] = in[i];
      if (!log_->push(line)) ++rejected_;
    }
    written = log_->written();
    dropped = rejected_ + log_->lost();
    error = log_->error();
    if (error != told_) tell_error();
  }

 private:
  void tell_error() {
    told_ = error;
    const auto name = file->view();
    const int length = static_cast<int>(name.size());
    if (told_ == 0) return tell(picard::Severity::Note, "%.*s is written again", length, name.data());
    const char* const why = ::strerrordesc_np(told_);
    tell(picard::Severity::Warning, "%.*s is not written: %s%s", length, name.data(), why != nullptr ? why : "an error",
         told_ == EFBIG ? "; it has reached its LIMIT" : "; it is tried again");
  }

  std::optional<CsvLog> log_;  ///< made in ready()
  std::uint64_t rejected_ = 0;
  std::int32_t told_ = 0;  ///< the ERROR that the operator knows of
};

}  // namespace plc::blocks
