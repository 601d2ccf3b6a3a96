// RecordFolder: recordings in a folder, each file a recording of its own, the oldest removed when there are too many.
//
// In: a folder, blocks. Out: files plant-<UTC>.rec, fault-<UTC>.rec and crash-<UTC>.rec (record_file.h). Threads: one,
// but for file(). Does not belong here: when something is written (shadow.h).
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"
#include "shadow/record_writer.h"

namespace plc::shadow {

struct RecordFolderOptions {
  std::string path;                       ///< made when it is not there
  std::uint64_t file_bytes = 64u << 20;   ///< a new file is begun after so many
  std::uint64_t most_bytes = 1ull << 30;  ///< of all files of the folder that go on one after the other
};

/// What goes on: blocks, file after file.
class RecordFolder {
 public:
  /// Begins a file, and removes the oldest ones where there are too many. P7631 when the folder cannot be written.
  static core::Result<std::unique_ptr<RecordFolder>> open(RecordFolderOptions options, RecordingHead head);

  /// False when the block could not be written; problem() says why, and the next one is tried again.
  bool write(std::span<const std::byte> block);
  [[nodiscard]] std::optional<core::Problem> problem() const { return writer_->problem(); }
  /// The file that is written now. Any thread.
  [[nodiscard]] std::string file() const;

 private:
  RecordFolder(RecordFolderOptions options, RecordingHead head)
      : options_(std::move(options)), head_(std::move(head)) {}
  std::optional<core::Problem> next_file();
  /// Removes the oldest files until there are no more bytes than there may be.
  void prune();

  RecordFolderOptions options_;
  RecordingHead head_;
  std::unique_ptr<RecordWriter> writer_;
  mutable std::mutex mutex_;  ///< for file_
  std::string file_;
};

/// Writes a whole recording as <led_to>-<UTC>.rec and removes the oldest of them above `most_files`. `led_to`: "fault",
/// "crash". The path, or P7631.
core::Result<std::string> save_recording(const std::string& folder, std::string_view led_to,
                                         std::span<const std::byte> recording, std::size_t most_files);

}  // namespace plc::shadow
