// System: how the doctor sees a machine: files below a root folder, and the few facts that no file has.
//
// In: a root folder, "/" for this machine; functions for what the kernel tells by calls alone. Out: texts, names,
// facts. Nothing is written, locked or taken, and nothing blocks: files are opened without waiting and read up to a
// limit. Tests plant a machine as a folder. Does not belong here: what a finding is (check.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/configuration.h"

namespace plc::doctor {

/// What stat() says of a file.
struct FileFacts {
  std::uint32_t mode = 0;  ///< type and permissions, as st_mode
  std::uint32_t owner = 0;
  std::uint32_t group = 0;
  std::uint64_t inode = 0;
  std::uint32_t device_major = 0;  ///< of the file system it is on
  std::uint32_t device_minor = 0;
};

struct Space {
  std::uint64_t free_bytes = 0;  ///< for ordinary users
  std::uint64_t free_files = 0;  ///< UINT64_MAX where the file system has no limit
  bool read_only = false;
};

struct Clocks {
  bool synchronised = false;       ///< the kernel's clock is disciplined
  std::int64_t time_of_day_s = 0;  ///< since 1970
  std::int64_t resolution_ns = 0;  ///< of timers, CLOCK_MONOTONIC
};

/// What no file tells. Those that are null are not known: for a machine that is a folder of files.
struct Calls {
  std::function<Clocks()> clocks;
  std::function<std::optional<Space>(const std::string& real_path)> space;
  bool devices = false;  ///< kinds of drivers may ask the kernel of this machine for theirs (DriverType::check_device)
};

/// All paths are those of the machine: absolute ones begin at the root, and so do the symbolic links on their way;
/// nothing leads out of it. Relative ones are files given to the doctor, as seen from where it runs. Not RT. Any
/// thread.
class System {
 public:
  /// This machine.
  static System here();
  /// What `root` holds, looked at with `calls`.
  explicit System(std::string root, Calls calls = {});

  /// The first MiB of a file; nothing when it cannot be read.
  [[nodiscard]] std::optional<std::string> read(const std::string& path) const;
  /// The same without blanks at both ends.
  [[nodiscard]] std::optional<std::string> line(const std::string& path) const;
  [[nodiscard]] std::optional<std::int64_t> number(const std::string& path) const;
  /// Names in a folder, sorted; none when it is not there.
  [[nodiscard]] std::vector<std::string> list(const std::string& folder) const;
  /// Follows symbolic links.
  [[nodiscard]] std::optional<FileFacts> facts(const std::string& path) const;
  /// Where a symbolic link leads; empty when it is none.
  [[nodiscard]] std::string link(const std::string& path) const;
  [[nodiscard]] std::optional<Space> space(const std::string& path) const;

  [[nodiscard]] const Calls& calls() const { return calls_; }
  /// Where the file is for this process, and in a folder of files without symbolic links; empty when those go in a
  /// circle.
  [[nodiscard]] std::string real(const std::string& path) const { return resolved(path, true); }
  /// The path here of a file that plc.toml names; empty stays empty.
  [[nodiscard]] std::string named(const io::Configuration& configuration, const std::string& name) const;

 private:
  /// As real(). `last`: a link at its end is followed, too.
  [[nodiscard]] std::string resolved(const std::string& path, bool last) const;

  std::string root_;  ///< without a slash at its end: empty for this machine
  Calls calls_;
};

}  // namespace plc::doctor
