#include "engineering/audit.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "engineering/secrets.h"
#include "engineering/state_files.h"
#include "log/format.h"

namespace plc::engineering {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kHashDigits = 64;
constexpr const char* kName = "audit";
constexpr const char* kHeadName = "audit.head";

std::string first_hash() { return std::string(kHashDigits, '0'); }

std::string head_text(std::uint64_t number, const std::string& hash) { return fmt::format("{} {}\n", number, hash); }

std::string dump(const ordered_json& object) {
  return object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace

AuditCheck check_audit(std::string_view bytes, std::string_view head, std::string_view before) {
  AuditCheck check;
  check.hash = before;
  // A loss of power between a new file and its head leaves that of the record before.
  bool has_head = head.empty() || (!before.empty() && head.ends_with(std::string(before) + "\n"));
  for (std::uint64_t line_number = 1; check.sound_bytes < bytes.size(); ++line_number) {
    const std::size_t end = bytes.find('\n', check.sound_bytes);
    if (end == std::string_view::npos) break;
    const auto broken = [&](const char* why) {
      check.broken_line = line_number;
      check.why = why;
    };
    const std::string_view line = bytes.substr(check.sound_bytes, end - check.sound_bytes);
    const std::string_view json = line.size() > kHashDigits ? line.substr(kHashDigits + 1) : std::string_view();
    const ordered_json record = ordered_json::parse(json, nullptr, false);
    const auto number = record.is_object() ? record.find("n") : record.end();
    const auto after = record.is_object() ? record.find("after") : record.end();
    if (!record.is_object() || number == record.end() || !number->is_number_unsigned() || after == record.end() ||
        !after->is_string() || line[kHashDigits] != ' ') {
      broken("it is no record");
      return check;
    }
    if (sha256(json) != line.substr(0, kHashDigits)) return broken("it was changed"), check;
    const auto n = number->get<std::uint64_t>();
    const bool first = check.texts.empty();
    const bool follows = first ? check.hash.empty() || after->get<std::string>() == check.hash
                               : after->get<std::string>() == check.hash && n == check.last + 1;
    if (!follows) return broken("the record before it is another one, or was taken out"), check;
    if (first) check.first = n;
    check.last = n;
    check.hash = line.substr(0, kHashDigits);
    check.sound_bytes = end + 1;
    check.texts.emplace_back(json);
    has_head = has_head || head == head_text(check.last, check.hash);
  }
  if (!has_head) {
    check.broken_line = check.texts.size() + 1;
    check.why = "record " + std::string(head.substr(0, head.find(' '))) + " was written, and is not here";
  }
  return check;
}

core::Result<AuditCheck> check_audit_file(const std::string& path) {
  std::error_code error;
  namespace fs = std::filesystem;
  const std::string file = fs::is_directory(path, error) ? (fs::path(path) / kName).string() : path;
  std::string why;
  const auto bytes = read_whole_file(file, why);
  if (!bytes) {
    return core::Problem{core::Code::P7001, why.empty() ? "cannot open " + file + ": there is no such file" : why,
                         "the audit of a plant lies in its state folder, as engineering/audit"};
  }
  // "audit" goes on from "audit.1", and that from "audit.2".
  const std::string name = fs::path(file).filename().string();
  std::uint32_t n = 0;
  const bool older = name.size() > 6 && name.starts_with("audit.") &&
                     std::from_chars(name.data() + 6, name.data() + name.size(), n).ec == std::errc{};
  std::string before;
  if (name == kName || older) {
    const auto previous =
        read_whole_file((fs::path(file).parent_path() / fmt::format("{}.{}", kName, n + 1)).string(), why);
    if (previous) before = check_audit(*previous, {}, {}).hash;
    // Of the oldest file that is kept nobody knows what was before.
    if (before.empty() && n < Audit::kKept) before = first_hash();
  }
  std::string head;
  if (name == kName) {
    head = read_whole_file((fs::path(file).parent_path() / kHeadName).string(), why).value_or("");
    if (head.empty() && !bytes->empty()) head = "? ";
  }
  return check_audit(*bytes, head, before);
}

Audit::Audit(std::string folder, const core::Calendar& calendar, std::string& said, std::uint64_t most_bytes)
    : folder_(std::move(folder)), calendar_(calendar), most_bytes_(most_bytes), hash_(first_hash()) {
  if (folder_.empty()) return;
  std::string why;
  const auto bytes = read_whole_file(path(kName), why);
  if (!bytes && why.empty()) {
    // All records may lie in the file before.
    const auto older = read_whole_file(path(kName) + ".1", why);
    if (!older) return;
    const AuditCheck check = check_audit(*older, {}, {});
    number_ = check.last;
    if (!check.hash.empty()) hash_ = check.hash;
    return;
  }
  const auto check = bytes ? check_audit_file(path(kName)) : core::Result<AuditCheck>(AuditCheck{});
  if (why.empty() && check && !check->why.empty()) why = fmt::format("line {}: {}", check->broken_line, check->why);
  if (!why.empty()) {
    const std::string broken = path("audit.broken");
    static_cast<void>(std::rename(path(kName).c_str(), broken.c_str()));
    ::unlink(path(kHeadName).c_str());
    said = fmt::format("{}: the audit is broken, {}; it is {} now, and a new one begins",
                       core::info(core::Code::P7702).name, why, broken);
    add("", "", "audit.broken", {{"why", why}, {"file", broken}});
    return;
  }
  // What a loss of power left of a record.
  if (check->sound_bytes < bytes->size() &&
      ::truncate(path(kName).c_str(), static_cast<off_t>(check->sound_bytes)) != 0) {
    said = fmt::format("cannot write {}: {}", path(kName), std::strerror(errno));
  }
  number_ = check->last;
  if (!check->hash.empty()) hash_ = check->hash;
  const std::size_t from = check->texts.size() > kRecent ? check->texts.size() - kRecent : 0;
  recent_.assign(check->texts.begin() + static_cast<std::ptrdiff_t>(from), check->texts.end());
}

Audit::~Audit() {
  write_waiting();
  if (file_ >= 0) ::close(file_);
}

void Audit::add(const std::string& user, const std::string& address, const std::string& what,
                const ordered_json& details) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() >= kMostWaiting) {
    ++lost_;
    return;
  }
  ordered_json record;
  record["n"] = ++number_;
  record["time"] = log::time_text(calendar_.utc_ns());
  record["user"] = user;
  record["address"] = address;
  record["what"] = what;
  if (!details.empty()) record["details"] = details;
  if (lost_ != 0) record["lost"] = lost_;
  record["after"] = hash_;
  Record made{dump(record), {}, number_};
  made.hash = hash_ = sha256(made.json);
  recent_.push_back(made.json);
  if (recent_.size() > kRecent) recent_.pop_front();
  if (!folder_.empty()) waiting_.push_back(std::move(made));
}

void Audit::rotate() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  const auto older = [this](std::uint32_t n) { return path(kName) + (n == 0 ? "" : fmt::format(".{}", n)); };
  for (std::uint32_t n = kKept; n-- > 0;) static_cast<void>(std::rename(older(n).c_str(), older(n + 1).c_str()));
}

std::string Audit::write_waiting() {
  std::deque<Record> batch;
  {
    const std::lock_guard lock(mutex_);
    batch.swap(waiting_);
  }
  if (batch.empty()) return write_head();
  const auto refused = [&](const std::string& what) {
    std::string why = "cannot write " + what + ": " + std::strerror(errno);
    const std::lock_guard lock(mutex_);
    waiting_.insert(waiting_.begin(), std::make_move_iterator(batch.begin()), std::make_move_iterator(batch.end()));
    return why;
  };
  if (file_ >= 0 && size_ >= most_bytes_) rotate();
  if (file_ < 0) {
    const std::string why = make_private_folder(folder_);
    file_ =
        why.empty() ? ::open(path(kName).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600) : -1;
    struct stat status {};
    if (file_ < 0 || ::fstat(file_, &status) != 0) return refused(path(kName));
    size_ = static_cast<std::uint64_t>(status.st_size);
    if (size_ == 0 && batch.front().number == 1) {
      const std::string refusal = write_private_file(path(kHeadName), head_text(0, first_hash()));
      if (!refusal.empty()) return refused(path(kHeadName));
    }
  }
  std::string lines;
  for (const Record& record : batch) lines += record.hash + ' ' + record.json + '\n';
  const ssize_t written = ::write(file_, lines.data(), lines.size());
  if (written != static_cast<ssize_t>(lines.size()) || ::fdatasync(file_) != 0) {
    const int error = errno;
    // Half a line would break the chain.
    if (::ftruncate(file_, static_cast<off_t>(size_)) != 0) ::close(std::exchange(file_, -1));
    errno = written >= 0 && error == 0 ? ENOSPC : error;
    return refused(path(kName));
  }
  size_ += lines.size();
  head_ = head_text(batch.back().number, batch.back().hash);
  return write_head();
}

std::string Audit::write_head() {
  if (head_.empty()) return {};
  std::string why = write_private_file(path(kHeadName), head_);
  if (why.empty()) head_.clear();
  return why;
}

std::vector<std::string> Audit::recent(std::size_t most) const {
  const std::lock_guard lock(mutex_);
  const std::size_t from = recent_.size() > most ? recent_.size() - most : 0;
  return {recent_.begin() + static_cast<std::ptrdiff_t>(from), recent_.end()};
}

std::uint64_t Audit::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

}  // namespace plc::engineering
