#include "log/limiter.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace plc::log {
namespace {

std::string key_of(const Record& record) {
  std::string key(1, static_cast<char>('0' + static_cast<int>(record.severity)));
  for (const std::string* part :
       {&record.source, &record.code, &record.task, &record.block, &record.text, &record.details})
    key.append(1, '\0').append(*part);
  return key;
}

std::string seconds_text(core::TimeNs ns) { return fmt::format("{} s", (ns + 500'000'000) / 1'000'000'000); }

}  // namespace

bool Limiter::admit(const Record& record, core::TimeNs now_ns) {
  if (window_ns_ == 0) return true;
  const auto same = messages_.find(key_of(record));
  if (same != messages_.end()) {
    Message& message = same->second;
    // sums() ends windows: one that is over has held nothing, or its sum is about to be written.
    ++message.held;
    message.record.scan = record.scan;
    message.record.utc_ns = record.utc_ns;
    return false;
  }
  // Components of one kind are one source each.
  Source& source =
      sources_.try_emplace(record.block.empty() ? record.source : record.block, Source{now_ns}).first->second;
  if (source.written >= most_) {
    ++source.held;
    source.worst = std::max(source.worst, record.severity);
    return false;
  }
  ++source.written;
  messages_.emplace(key_of(record), Message{record, now_ns, 0});
  return true;
}

std::vector<Record> Limiter::sums(core::TimeNs now_ns, core::TimeNs utc_ns, bool all) {
  std::vector<Record> said;
  for (auto at = messages_.begin(); at != messages_.end();) {
    Message& message = at->second;
    if (!all && !has_ended(message.begin_ns, now_ns)) {
      ++at;
    } else if (message.held == 0) {
      at = messages_.erase(at);
    } else {
      Record sum = message.record;
      sum.text += fmt::format(" ({} {} more in {})", message.held, message.held == 1 ? "time" : "times",
                              seconds_text(now_ns - message.begin_ns));
      sum.details.clear();
      sum.shown = false;
      said.push_back(std::move(sum));
      message.held = 0;
      message.begin_ns = now_ns;  // what goes on repeating is summed up again
      ++at;
    }
  }
  for (auto at = sources_.begin(); at != sources_.end();) {
    const auto& [name, source] = *at;
    if (!all && !has_ended(source.begin_ns, now_ns)) {
      ++at;
      continue;
    }
    if (source.held != 0) {
      Record sum;
      sum.severity = source.worst;
      sum.source = name;
      sum.text = fmt::format("{}: {} further messages in {} are left out", name.empty() ? "plc-run" : name, source.held,
                             seconds_text(now_ns - source.begin_ns));
      said.push_back(std::move(sum));
    }
    at = sources_.erase(at);
  }
  for (Record& record : said) record.utc_ns = utc_ns;
  std::sort(said.begin(), said.end(), [](const Record& a, const Record& b) { return a.text < b.text; });
  return said;
}

}  // namespace plc::log
