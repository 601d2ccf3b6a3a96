// RecordThread: keeps the recording of a plant that runs, in a folder.
//
// In: a resource that is about to run, a folder. Out: files plant-<UTC>.rec (record_file.h), a new one after a certain
// size, the oldest removed when all of them together are too large. A thread of its own takes records from the tasks'
// rings ten times a second and writes them: a slow or full disk costs records, never a scan. Threads: start(), stop()
// and messages() on one thread. Does not belong here: command lines.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"
#include "runtime/resource.h"
#include "shadow/record_writer.h"
#include "shadow/recording.h"

namespace plc::shadow {

struct RecordFolder {
  std::string path;
  std::uint64_t file_bytes = 64u << 20;   ///< a new file is begun after so many
  std::uint64_t most_bytes = 1ull << 30;  ///< of all files of the folder
};

class RecordThread {
 public:
  /// Records all tasks from their next scan on. P7631 when the folder cannot be written, P9001 without memory. Before
  /// the tasks start, after their taskblocks did.
  static core::Result<std::unique_ptr<RecordThread>> start(runtime::Resource& resource, RecordFolder folder,
                                                           RecordingHead head);
  ~RecordThread();
  RecordThread(const RecordThread&) = delete;
  RecordThread& operator=(const RecordThread&) = delete;

  /// What has gone wrong since the last call, and that it goes on again.
  std::vector<std::string> messages();
  /// The last blocks. `whole`: no task runs any more; else what tasks still write is left out.
  void stop(bool whole);
  /// Of all tasks together. After stop().
  [[nodiscard]] RecordingCounts counts() const;
  /// The file that is written now.
  [[nodiscard]] std::string file() const;

 private:
  RecordThread(RecordFolder folder, RecordingHead head) : folder_(std::move(folder)), head_(std::move(head)) {}
  std::optional<core::Problem> next_file();
  void remove_oldest();
  bool write(std::span<const std::byte> block);
  void say(std::string text);
  void run();

  RecordFolder folder_;
  RecordingHead head_;
  std::unique_ptr<RecordWriter> writer_;
  std::unique_ptr<Recording> recording_;
  std::uint32_t tasks_ = 0;
  bool in_trouble_ = false;
  mutable std::mutex mutex_;  ///< for messages_ and file_
  std::vector<std::string> messages_;
  std::string file_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace plc::shadow
