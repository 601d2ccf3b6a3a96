#include "core/time_zone.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <system_error>

namespace plc::core {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;
constexpr std::time_t kLastSecond = 4'102'444'800;  ///< 2100-01-01
/// No zone has had two changes closer than that and been where it was before the first.
constexpr std::time_t kStep = 604'800;  ///< a week

/// The environment variable TZ has another value for as long as this lives.
class OtherZone {
 public:
  explicit OtherZone(const std::string& zone) {
    if (const char* const before = std::getenv("TZ")) before_ = before;
    if (!zone.empty()) ::setenv("TZ", zone.c_str(), 1);
    ::tzset();
  }
  ~OtherZone() {
    before_ ? ::setenv("TZ", before_->c_str(), 1) : ::unsetenv("TZ");
    ::tzset();
  }
  OtherZone(const OtherZone&) = delete;
  OtherZone& operator=(const OtherZone&) = delete;

 private:
  std::optional<std::string> before_;
};

long offset_at(std::time_t second) {
  std::tm local{};
  ::localtime_r(&second, &local);
  return local.tm_gmtoff;
}

/// The first second of another offset than that of `low`, which `high` has.
std::time_t change_between(std::time_t low, std::time_t high) {
  const long before = offset_at(low);
  while (high - low > 1) {
    const std::time_t middle = low + (high - low) / 2;
    (offset_at(middle) == before ? low : high) = middle;
  }
  return high;
}

/// "Europe/Berlin" of ".../zoneinfo/Europe/Berlin".
std::string zone_of_path(const std::string& path) {
  constexpr std::string_view kFolder = "zoneinfo/";
  const std::size_t at = path.rfind(kFolder);
  return at == std::string::npos ? path : path.substr(at + kFolder.size());
}

std::string name_of_machine() {
  if (const char* const zone = std::getenv("TZ")) return *zone == ':' ? zone + 1 : zone;
  std::error_code none;
  const std::filesystem::path link = std::filesystem::read_symlink("/etc/localtime", none);
  return none ? "UTC" : zone_of_path(link.string());
}

bool is_in_database(const std::string& name) {
  if (name.starts_with('/') || name.find("..") != std::string::npos) return false;
  const char* const folder = std::getenv("TZDIR");
  std::error_code none;
  return std::filesystem::is_regular_file(
      std::filesystem::path(folder != nullptr && *folder != '\0' ? folder : "/usr/share/zoneinfo") / name, none);
}

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

/// Three letters or more and an offset, as "CET-1": what follows is the C library's to read.
bool is_rule(const std::string& name) {
  const auto letters = std::find_if_not(name.begin(), name.end(), is_letter);
  if (letters - name.begin() < 3 || letters == name.end()) return false;
  const auto digits = *letters == '+' || *letters == '-' ? letters + 1 : letters;
  return digits != name.end() && *digits >= '0' && *digits <= '9';
}

}  // namespace

std::optional<TimeZone> TimeZone::load(const std::string& name) {
  TimeZone zone;
  if (name == zone.name_) return zone;
  const bool database = is_in_database(name);
  if (!name.empty() && !database && !is_rule(name)) return std::nullopt;
  zone.name_ = name.empty() ? name_of_machine() : name;
  const OtherZone here(name.empty() ? name : (database ? ":" : "") + name);
  long offset = offset_at(0);
  zone.first_offset_ns_ = offset * kSecond;
  for (std::time_t second = 0; second < kLastSecond;) {
    std::time_t next = second + kStep;
    if (offset_at(next) != offset) {
      next = change_between(second, next);
      offset = offset_at(next);
      zone.changes_.push_back({next * kSecond, offset * kSecond});
    }
    second = next;
  }
  return zone;
}

// RT:
TimeNs TimeZone::offset_ns(TimeNs utc_ns) const noexcept {
  const auto after = std::upper_bound(changes_.begin(), changes_.end(), utc_ns,
                                      [](TimeNs at, const Change& change) { return at < change.from_ns; });
  return after == changes_.begin() ? first_offset_ns_ : std::prev(after)->offset_ns;
}

}  // namespace plc::core
