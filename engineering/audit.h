// Audit: who did what, in a file whose records are chained by hashes: what is changed, taken out or put in afterwards
// is seen (docs/adr/0058).
//
// A record is a line: 64 hexadecimal digits, a blank, a JSON object. The digits are the SHA-256 of the object's bytes,
// and the object holds those of the record before it as "after" (64 zeros before the first), so any tool can check it.
// The file "audit.head" beside it names a record that must be there: a file that ends early is seen, too. At kMostBytes
// the file becomes audit.1, and a new one goes on with the chain. Threads: add() and recent() any; the rest blocks on
// the disk and belongs to one. Does not belong here: what is worth a record (the calls).
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/result.h"

namespace plc::engineering {

/// What a file of records is like.
struct AuditCheck {
  std::uint64_t first = 0;         ///< number of the first record
  std::uint64_t last = 0;          ///< ..and of the last sound one
  std::string hash;                ///< of the last sound record
  std::uint64_t broken_line = 0;   ///< 0 = none
  std::string why;                 ///< empty = the chain is whole
  std::uint64_t sound_bytes = 0;   ///< up to the end of the last sound record
  std::vector<std::string> texts;  ///< the sound records, as JSON, oldest first
};
/// `before`: the hash of the record before the first, or empty where it is not known. `head`: contents of audit.head,
/// or empty where there is none. A piece of a record at the end, as a loss of power leaves it, breaks nothing.
AuditCheck check_audit(std::string_view bytes, std::string_view head, std::string_view before);
/// A file, or a folder with "audit" in it; with what lies beside it. P7001 when it cannot be read.
core::Result<AuditCheck> check_audit_file(const std::string& path);

class Audit {
 public:
  static constexpr std::uint64_t kMostBytes = 10'000'000;
  static constexpr std::uint32_t kKept = 9;     ///< files before the present one
  static constexpr std::size_t kRecent = 1000;  ///< records that can be asked for
  static constexpr std::size_t kMostWaiting = 10'000;

  /// `folder` empty: in memory. A chain that is broken, or a file that cannot be read, is renamed to audit.broken, and
  /// a new chain begins with a record that says so; `said` gets the sentence.
  Audit(std::string folder, const core::Calendar& calendar, std::string& said, std::uint64_t most_bytes = kMostBytes);
  ~Audit();
  Audit(const Audit&) = delete;
  Audit& operator=(const Audit&) = delete;

  /// A record of now. `details`: an object. Any thread, at once; write_waiting() stores it.
  void add(const std::string& user, const std::string& address, const std::string& what,
           const nlohmann::ordered_json& details);
  /// Puts what waits on the disk. Empty; or why it cannot be written: it is tried again with the next call.
  std::string write_waiting();
  /// The last records as JSON texts, oldest first.
  [[nodiscard]] std::vector<std::string> recent(std::size_t most) const;
  /// Records that were lost, because the disk refused for long.
  [[nodiscard]] std::uint64_t lost() const;

 private:
  struct Record {
    std::string json, hash;
    std::uint64_t number = 0;
  };
  void rotate();
  std::string write_head();
  [[nodiscard]] std::string path(const char* name) const { return folder_ + "/" + name; }

  std::string folder_;
  const core::Calendar& calendar_;
  std::uint64_t most_bytes_;
  mutable std::mutex mutex_;
  std::uint64_t number_ = 0;  ///< of the last record
  std::string hash_;          ///< of the last record
  std::uint64_t lost_ = 0;
  std::deque<Record> waiting_;
  std::deque<std::string> recent_;
  // Of the thread that writes:
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::string head_;  ///< to be written; empty: it is
};

}  // namespace plc::engineering
