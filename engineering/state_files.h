// Files of the state folder, for this user alone, and of the project: written whole or not at all.
//
// Threads: any; blocks on the disk. Does not belong here: what is in them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace plc::engineering {

/// Makes the folder, mode 0700, where it is not there. Empty; or why not.
std::string make_private_folder(const std::string& folder);
/// Replaces the file by `bytes` in one step, mode 0600: a loss of power leaves the old or the new one. Empty; or why
/// not.
std::string write_private_file(const std::string& path, std::string_view bytes);
/// The same with other rights.
std::string write_file(const std::string& path, std::string_view bytes, unsigned mode);
/// The whole file; nothing when there is none. `why` is set when there is one that cannot be read, or that is larger
/// than 64 MB.
std::optional<std::string> read_whole_file(const std::string& path, std::string& why);

/// A folder that no other process uses meanwhile. Threads: one.
class FolderLock {
 public:
  FolderLock() = default;
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Empty, or that another process has it. A folder that cannot be locked for another reason is used without a lock.
  std::string take(const std::string& folder);

 private:
  int directory_ = -1;
};

}  // namespace plc::engineering
