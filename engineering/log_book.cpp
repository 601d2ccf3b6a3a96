#include "engineering/log_book.h"

#include <algorithm>

namespace plc::engineering {
void LogBook::add(const log::Record& record) {
  const std::lock_guard lock(mutex_);
  entries_.push_back({++last_, record});
  if (entries_.size() > kMost) entries_.pop_front();
}

void LogBook::take_over(std::uint64_t last, const std::deque<log::Record>& records) {
  const std::lock_guard lock(mutex_);
  if (records.size() > last) return;
  last_ = last - records.size();
  entries_.clear();
  for (const log::Record& record : records) entries_.push_back({++last_, record});
}

std::vector<LogBook::Entry> LogBook::after(std::uint64_t number, core::Severity least, std::size_t most) const {
  std::vector<Entry> found;
  const std::lock_guard lock(mutex_);
  const std::uint64_t first = last_ - entries_.size() + 1;
  const std::size_t from = number < first ? 0 : static_cast<std::size_t>(number - first + 1);
  for (std::size_t i = from; i < entries_.size() && found.size() < most; ++i) {
    if (entries_[i].record.severity >= least) found.push_back(entries_[i]);
  }
  return found;
}

std::vector<LogBook::Entry> LogBook::latest(core::Severity least, std::size_t most) const {
  std::vector<Entry> found;
  const std::lock_guard lock(mutex_);
  for (auto it = entries_.rbegin(); it != entries_.rend() && found.size() < most; ++it) {
    if (it->record.severity >= least) found.push_back(*it);
  }
  std::reverse(found.begin(), found.end());
  return found;
}

std::uint64_t LogBook::last_number() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

std::uint64_t LogBook::first_number() const {
  const std::lock_guard lock(mutex_);
  return last_ - entries_.size() + 1;
}

}  // namespace plc::engineering
