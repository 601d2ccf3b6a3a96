// LogBook: the latest messages of the log, for clients that ask later or follow.
//
// In: records (log/record.h), from whoever writes the log. Out: those after a number, each as JSON of log::json_line().
// Memory: kMost records. Threads: any. Does not belong here: levels, limits (log/).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "log/record.h"

namespace plc::engineering {

class LogBook {
 public:
  static constexpr std::size_t kMost = 10'000;

  struct Entry {
    std::uint64_t number = 0;  ///< from 1 on
    log::Record record;
  };

  void add(const log::Record& record);
  /// Goes on after the book of the process before, of which these are the latest records. Before the first add().
  void take_over(std::uint64_t last, const std::deque<log::Record>& records);
  /// At most `most` records after the one of this number that are at least as severe, oldest first.
  [[nodiscard]] std::vector<Entry> after(std::uint64_t number, core::Severity least, std::size_t most) const;
  /// The last `most` of them.
  [[nodiscard]] std::vector<Entry> latest(core::Severity least, std::size_t most) const;
  [[nodiscard]] std::uint64_t last_number() const;
  /// Number of the oldest record that is still here; last_number() + 1 when there is none.
  [[nodiscard]] std::uint64_t first_number() const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t last_ = 0;
  std::deque<Entry> entries_;
};

}  // namespace plc::engineering
