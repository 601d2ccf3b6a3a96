// Database: a file of SQLite that survives being killed, a full disk and a file that is no database any more.
//
// In: SQL. Out: rows, or in words why not. A file that cannot be read is renamed to NAME.broken, and a new one begins.
// Threads: one at a time for each object; several objects may have one file, of which one writes: a second one that
// would, in this or another process, cannot open it. Does not belong here: what is stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace plc::storage {

class Statement;

class Database {
 public:
  Database() = default;
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Opens or makes the file; ":memory:" is one without a file. `schema`: statements that may be repeated. `said`: what
  /// became of a file that was broken, else empty. `page_bytes`: of a new file; larger ones waste less beside rows of
  /// some kilobytes. False: why() says why not.
  bool open(const std::string& path, std::string_view schema, std::string& said, unsigned page_bytes = 4096);
  /// To read what another object writes.
  bool open_to_read(const std::string& path);
  void close();
  [[nodiscard]] bool is_open() const { return handle_ != nullptr; }
  /// Statements without values; false: why().
  bool run(std::string_view sql);
  /// Runs `work` as one transaction: all of it or, when it returns false, nothing.
  bool transact(const std::function<bool()>& work);
  /// Of the last thing that failed, without a full stop.
  [[nodiscard]] const std::string& why() const { return why_; }
  /// The first number of the first row; 0 without one.
  std::int64_t number(std::string_view sql);
  /// Bytes of the file that are in use.
  std::uint64_t used_bytes();

 private:
  friend class Statement;
  bool prepare_file(std::string_view schema, unsigned page_bytes);
  bool lock(const std::string& path);
  bool fails();

  sqlite3* handle_ = nullptr;
  int lock_ = -1;  ///< of a file beside it, from the first open() on
  std::string why_;
};

/// A statement with values, `?1` to `?n`. Made once, run often.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int place, std::int64_t value);
  Statement& bind(int place, double value);
  Statement& bind(int place, std::string_view text);
  Statement& bind_bytes(int place, std::span<const std::byte> bytes);
  Statement& bind_null(int place);
  /// Runs it to its end; false: Database::why(). It may be bound anew then.
  bool run();
  /// Goes to the next row; false at the end, or when it fails.
  bool next();
  /// Ends what next() began.
  void reset();

  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] bool is_null(int column) const;
  /// Until the next call of next() or reset().
  [[nodiscard]] std::span<const std::byte> bytes(int column) const;

 private:
  Database& database_;
  sqlite3_stmt* handle_ = nullptr;
};

}  // namespace plc::storage
