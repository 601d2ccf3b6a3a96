#include "tools/date.h"

#include <charconv>
#include <chrono>
#include <cstdint>

#include "core/text.h"

namespace plc::tools {
namespace {

/// Takes a number of at most `digits` digits, and the character after it when it is one of `ends`.
class DateText {
 public:
  explicit DateText(std::string_view text) : rest_(text) {}
  bool number(std::size_t digits, std::int64_t& value) {
    const std::string_view part = rest_.substr(0, digits);
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    const auto length = static_cast<std::size_t>(end - part.data());
    if (error != std::errc{} || length != digits || value < 0) return false;
    rest_.remove_prefix(length);
    return true;
  }
  bool one_of(std::string_view ends) {
    if (rest_.empty() || ends.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
    return true;
  }
  /// Digits after the point of seconds, in ns; those beyond the ninth count for nothing.
  bool fraction(std::int64_t& ns) {
    std::int64_t weight = 100'000'000;
    const std::size_t before = rest_.size();
    for (; !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9'; rest_.remove_prefix(1)) {
      ns += (rest_.front() - '0') * weight;
      weight /= 10;
    }
    return rest_.size() != before;
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

}  // namespace

std::optional<core::TimeNs> parse_date_ns(std::string_view text) {
  for (const std::string_view prefix : {"DT#", "LDT#", "DATE_AND_TIME#"}) {
    if (text.size() > prefix.size() && core::iequals(text.substr(0, prefix.size()), prefix)) {
      text.remove_prefix(prefix.size());
      break;
    }
  }
  using namespace std::chrono;
  std::int64_t year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, ns = 0;
  DateText in(text);
  if (!in.number(4, year) || !in.one_of("-") || !in.number(2, month) || !in.one_of("-") || !in.number(2, day))
    return std::nullopt;
  if (!in.at_end()) {
    if (!in.one_of("Tt -") || !in.number(2, hour) || !in.one_of(":") || !in.number(2, minute)) return std::nullopt;
    if (in.one_of(":") && !in.number(2, second)) return std::nullopt;
    if (in.one_of(".") && !in.fraction(ns)) return std::nullopt;
    in.one_of("Zz");
  }
  const year_month_day date{std::chrono::year(static_cast<int>(year)), std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!in.at_end() || !date.ok() || year < 1970 || year > 2261 || hour > 23 || minute > 59 || second > 59)
    return std::nullopt;
  const auto at = sys_days(date).time_since_epoch() + hours(hour) + minutes(minute) + seconds(second);
  return duration_cast<nanoseconds>(at).count() + ns;
}

void add_date_options(Command command, DateOptions& options) {
  command.option("--date=DATE", options.date,
                 "date and time of the machine at the start, in UTC, as 2026-03-29T00:59:58; it goes on with virtual "
                 "time. Default: 1970-01-01");
  command.option("--zone=ZONE", options.zone, "time zone of LOCAL_DT() and SYS_TIME, as Europe/Berlin; default: UTC");
}

std::optional<int> parse_date_options(std::string_view command, DateOptions& options) {
  if (!options.date.empty()) {
    const auto date = parse_date_ns(options.date);
    if (!date) {
      complain(command, "--date \"" + options.date + "\" is not a date and time", "write 2026-03-29T00:59:58");
      return kExitUsage;
    }
    options.date_ns = *date;
  }
  auto zone = core::TimeZone::load(options.zone);
  if (!zone) {
    complain(command, "there is no time zone \"" + options.zone + "\" on this machine",
             "timedatectl list-timezones lists them; the package tzdata has them");
    return kExitUsage;
  }
  options.time_zone = std::move(*zone);
  return std::nullopt;
}

}  // namespace plc::tools
