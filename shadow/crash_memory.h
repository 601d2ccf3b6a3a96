// CrashMemory: the newest records of a plant in memory that outlives its process, for who starts it again.
//
// In: rings of records (runtime/record/ring.h) and the tables before their blocks. Out: after a process that did not
// end well, a recording as a file has it. The memory is files of a folder in a file system that is memory (/dev/shm):
// no disk, nothing for a cycle to wait for, and gone when the machine is. Threads: make() and the end on one,
// begin_block() on that of the recording, take_left() on any. Does not belong here: files on disks (record_folder.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"

namespace plc::shadow {

class CrashMemory {
 public:
  struct Sizes {
    std::size_t ring_bytes = 0, most_record_bytes = 0;  ///< as RecordRing::make() takes them
    std::vector<std::size_t> table_bytes;               ///< of each task
    std::string state;                                  ///< the state folder of the plant
  };
  /// Puts aside what a process that died has left in `folder`, for take_left(), and makes it anew, for the calling user
  /// alone. What other plants of the user have left whose state folder is gone is removed. `file_head`: of the
  /// recording (file_head()). P7631 when it cannot be, or another process uses it.
  static core::Result<std::unique_ptr<CrashMemory>> make(const std::string& folder,
                                                         std::span<const std::byte> file_head, const Sizes& sizes);
  /// The process ends well: nothing is left.
  ~CrashMemory();
  CrashMemory(const CrashMemory&) = delete;
  CrashMemory& operator=(const CrashMemory&) = delete;

  /// For RecordRing::make().
  [[nodiscard]] int ring_file(std::size_t task) const { return tasks_[task].ring_file; }
  /// A block begins with the record at `position` of the task's ring, that of scan `first_scan`, and with this table.
  void begin_block(std::size_t task, std::uint64_t first_scan, std::uint64_t position,
                   std::span<const std::byte> table) noexcept;

  /// The folder of a plant that has this state folder, of the calling user.
  static std::string folder_of(const std::string& state);
  /// What the process before has left, as RecordFile::read() takes it: of each task the newest block and, where its
  /// records are still there, the one before. Empty when there is none, or it is not the calling user's alone. It is
  /// gone afterwards.
  static std::vector<std::byte> take_left(const std::string& folder);

 private:
  struct Task {
    int ring_file = -1;
    std::byte* tables = nullptr;  ///< mapped
    std::size_t table_bytes = 0;
  };

  explicit CrashMemory(std::string folder) : folder_(std::move(folder)) {}

  std::string folder_;
  int directory_ = -1;  ///< locked as long as this lives
  std::vector<Task> tasks_;
};

}  // namespace plc::shadow
