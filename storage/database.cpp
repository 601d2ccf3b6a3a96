#include "storage/database.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace plc::storage {
namespace {

/// One that reads waits so long for one that writes.
constexpr int kPatienceMs = 2000;
/// So much of the write-ahead log is taken over into the file at once.
constexpr unsigned kCheckpointBytes = 8'000'000;

/// A new file is for this user alone: it shows how a plant works.
void make_private(const std::string& path) {
  if (path == ":memory:" || ::access(path.c_str(), F_OK) == 0) return;
  const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) ::close(file);
}

bool is_broken(int code) { return (code & 0xff) == SQLITE_NOTADB || (code & 0xff) == SQLITE_CORRUPT; }

}  // namespace

Database::~Database() {
  close();
  if (lock_ >= 0) ::close(lock_);
}

/// Whoever writes has counted what is there: two of them would replace the rows of each other.
bool Database::lock(const std::string& path) {
  if (lock_ >= 0 || path == ":memory:") return true;
  // WHY not the file itself: whoever closes any descriptor of it gives up the locks that SQLite has there.
  const int file = ::open((path + "-lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return true;  // a full disk, a folder that cannot be written: the database says that itself
  if (::flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {
    lock_ = file;
    return true;
  }
  ::close(file);
  why_ = "another plc-run writes it";
  return false;
}

bool Database::fails() {
  why_ = handle_ == nullptr ? "no memory" : sqlite3_errmsg(handle_);
  return false;
}

bool Database::prepare_file(std::string_view schema, unsigned page_bytes) {
  sqlite3_busy_timeout(handle_, kPatienceMs);
  sqlite3_extended_result_codes(handle_, 1);
  // WHY normal: after a loss of power the last moments may be missing; the file is whole all the same.
  return run(fmt::format("PRAGMA page_size={}", page_bytes)) &&
         run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA temp_store=MEMORY;") &&
         run(fmt::format("PRAGMA wal_autocheckpoint={}", kCheckpointBytes / page_bytes)) && run(schema);
}

bool Database::open(const std::string& path, std::string_view schema, std::string& said, unsigned page_bytes) {
  said.clear();
  if (!lock(path)) return close(), false;
  for (int attempt = 0;; ++attempt) {
    close();
    make_private(path);
    const int opened = sqlite3_open_v2(path.c_str(), &handle_,
                                       SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX, nullptr);
    if (opened == SQLITE_OK && prepare_file(schema, page_bytes)) return true;
    static_cast<void>(fails());
    const bool broken = handle_ != nullptr && is_broken(sqlite3_errcode(handle_));
    close();
    if (!broken || attempt != 0) return false;
    const std::string aside = path + ".broken";
    if (std::rename(path.c_str(), aside.c_str()) != 0) return false;
    static_cast<void>(std::remove((path + "-wal").c_str()));
    static_cast<void>(std::remove((path + "-shm").c_str()));
    said = fmt::format("{} is no database any more ({}): it is {} now, and a new one begins", path, why_, aside);
  }
}

bool Database::open_to_read(const std::string& path) {
  close();
  const int opened = sqlite3_open_v2(path.c_str(), &handle_, SQLITE_OPEN_READONLY | SQLITE_OPEN_FULLMUTEX, nullptr);
  if (opened != SQLITE_OK) {
    static_cast<void>(fails());
    close();
    return false;
  }
  sqlite3_busy_timeout(handle_, kPatienceMs);
  return true;
}

void Database::close() {
  if (handle_ != nullptr) sqlite3_close_v2(handle_);
  handle_ = nullptr;
}

bool Database::run(std::string_view sql) {
  if (handle_ == nullptr) return why_ = "it is not open", false;
  return sqlite3_exec(handle_, std::string(sql).c_str(), nullptr, nullptr, nullptr) == SQLITE_OK || fails();
}

bool Database::transact(const std::function<bool()>& work) {
  if (!run("BEGIN IMMEDIATE")) return false;
  if (work() && run("COMMIT")) return true;
  const std::string first = why_;
  static_cast<void>(run("ROLLBACK"));
  why_ = first;
  return false;
}

std::int64_t Database::number(std::string_view sql) {
  Statement statement(*this, sql);
  return statement.next() ? statement.integer(0) : 0;
}

std::uint64_t Database::used_bytes() {
  return static_cast<std::uint64_t>((number("PRAGMA page_count") - number("PRAGMA freelist_count")) *
                                    number("PRAGMA page_size"));
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  if (database.handle_ == nullptr) {
    database.why_ = "it is not open";
  } else if (sqlite3_prepare_v2(database.handle_, sql.data(), static_cast<int>(sql.size()), &handle_, nullptr) !=
             SQLITE_OK) {
    static_cast<void>(database.fails());
  }
}

Statement::~Statement() { sqlite3_finalize(handle_); }

Statement& Statement::bind(int place, std::int64_t value) {
  sqlite3_bind_int64(handle_, place, value);
  return *this;
}
Statement& Statement::bind(int place, double value) {
  sqlite3_bind_double(handle_, place, value);
  return *this;
}
Statement& Statement::bind(int place, std::string_view text) {
  sqlite3_bind_text64(handle_, place, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}
Statement& Statement::bind_bytes(int place, std::span<const std::byte> bytes) {
  sqlite3_bind_blob64(handle_, place, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
  return *this;
}
Statement& Statement::bind_null(int place) {
  sqlite3_bind_null(handle_, place);
  return *this;
}

bool Statement::run() {
  if (handle_ == nullptr) return false;
  const int code = sqlite3_step(handle_);
  if (code != SQLITE_DONE && code != SQLITE_ROW) static_cast<void>(database_.fails());
  reset();
  return code == SQLITE_DONE || code == SQLITE_ROW;
}

bool Statement::next() {
  if (handle_ == nullptr) return false;
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) static_cast<void>(database_.fails());
  return false;
}

void Statement::reset() { sqlite3_reset(handle_); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_, column); }
double Statement::real(int column) const { return sqlite3_column_double(handle_, column); }
bool Statement::is_null(int column) const { return sqlite3_column_type(handle_, column) == SQLITE_NULL; }
std::span<const std::byte> Statement::bytes(int column) const {
  const auto* const begin = static_cast<const std::byte*>(sqlite3_column_blob(handle_, column));
  return {begin, begin == nullptr ? 0 : static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}
std::string Statement::text(int column) const {
  const std::span<const std::byte> all = bytes(column);
  return {reinterpret_cast<const char*>(all.data()), all.size()};
}

}  // namespace plc::storage
