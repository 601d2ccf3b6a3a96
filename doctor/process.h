// Process: limits and rights of the process that is looked at, as /proc tells them: the doctor's own, or a service's.
//
// In: a System. Out: numbers. What is not known is nothing, which is no finding. Does not belong here: what is enough.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "doctor/system.h"

namespace plc::doctor {

/// Bits of capabilities(7).
enum class Capability : unsigned { kDacOverride = 1, kNetBindService = 10, kIpcLock = 14, kSysNice = 23 };

inline constexpr std::uint64_t kUnlimited = UINT64_MAX;

class Process {
 public:
  /// `id`: its number, or "self". The system must live longer.
  Process(const System& system, std::string_view id);

  /// Whether /proc knows it.
  [[nodiscard]] bool known() const { return !status_.empty(); }
  /// Soft limit of a line of /proc/PID/limits, "Max open files".
  [[nodiscard]] std::optional<std::uint64_t> limit(std::string_view name) const;
  /// A line of /proc/PID/status, without its name: "Uid".
  [[nodiscard]] std::optional<std::string> status(std::string_view name) const;
  /// A variable of its environment; empty when it has none, or may not be asked.
  [[nodiscard]] std::string environment(std::string_view name) const;
  [[nodiscard]] bool has(Capability capability) const;
  [[nodiscard]] std::uint32_t user() const;
  /// Whether it may open a file: 4 to read, 2 to write, 6 both.
  [[nodiscard]] bool may(std::uint32_t access, const FileFacts& file) const;
  /// Processors it may run on; empty: not known.
  [[nodiscard]] std::vector<int> processors() const;
  /// A file of its control group or of the nearest group around it that has the file, "cpu.max", for which `limits` is
  /// true; `controller`: of version 1. Nothing: no group limits it.
  [[nodiscard]] std::optional<std::string> control(std::string_view controller, const std::string& file,
                                                   bool (*limits)(const std::string& value)) const;
  /// Type of the file system at an absolute path ("ext4"), and whether it is mounted to be read only.
  struct Mount {
    std::string type, options;
  };
  [[nodiscard]] std::optional<Mount> mount_of(const std::string& path) const;

 private:
  const System& system_;
  std::string folder_;  ///< "/proc/self"
  std::string status_, limits_;
};

/// "0-2,5" as 0, 1, 2, 5; at most 4096 numbers.
std::vector<int> parse_list(std::string_view text);
/// The lines of a text.
std::vector<std::string_view> lines_of(std::string_view text);
/// The words of a line.
std::vector<std::string_view> words_of(std::string_view line);
/// A number in the whole text, of base 10 or 16.
std::optional<std::uint64_t> to_number(std::string_view text, int base = 10);

}  // namespace plc::doctor
