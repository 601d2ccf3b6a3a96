// Shadow: the thread beside a plant that keeps what its scans took in, and shows their state to whoever looks.
//
// In: a resource that is about to run. Out: the newest scans in memory, files of recordings where a folder is named, a
// recording of what led to a fault or to the death of the process before, and replicas that follow the plant while
// somebody looks. Everything that a person sees comes from here, never from a real-time thread. A slow or full disk,
// and a viewer that reads slowly, cost records, never a scan. Threads: start(), stop() on one; messages(), look() and
// viewers on any but real-time ones. Does not belong here: command lines, networks.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "core/result.h"
#include "runtime/resource.h"
#include "runtime/sched/ordinary_thread.h"
#include "shadow/crash_memory.h"
#include "shadow/follower.h"
#include "shadow/history.h"
#include "shadow/record_folder.h"
#include "shadow/recording.h"

namespace plc::shadow {

struct ShadowOptions {
  RecordingOptions recording;
  std::uint64_t history_bytes = 32u << 20;    ///< of the newest scans, compressed, in memory
  std::optional<RecordFolderOptions> folder;  ///< where everything is written
  std::string fault_folder;                   ///< where what memory has is written after a fault; empty = nowhere
  std::size_t fault_files = 10;               ///< that are kept there, as many of crashes
  std::string crash_folder;                   ///< in memory that outlives the process (crash_memory.h); empty = none
  bool check = false;                         ///< replicas follow all the time, and what differs is said
  Follower::Prepare prepare;                  ///< what replicas run in
};

/// What the operator is told.
struct ShadowMessage {
  core::Severity severity = core::Severity::kWarning;
  std::string text;
};

class Shadow {
 public:
  /// Records all tasks from their next scan on. P7631 when the folder cannot be written, P9001 without memory. Before
  /// the tasks start, after their taskblocks did.
  static core::Result<std::unique_ptr<Shadow>> start(runtime::Resource& resource, ShadowOptions options,
                                                     RecordingHead head);
  ~Shadow();
  Shadow(const Shadow&) = delete;
  Shadow& operator=(const Shadow&) = delete;

  /// What has gone wrong since the last call, that it goes on again, and what was written after a fault.
  std::vector<ShadowMessage> messages();
  /// The last blocks. `whole`: no task runs any more; else what tasks still write is left out.
  void stop(bool whole);
  /// Of all tasks together, as of the last time that the thread took records.
  [[nodiscard]] RecordingCounts counts() const;
  /// How far back scans are in memory: from the oldest one to the newest one.
  [[nodiscard]] core::TimeNs history_ns() const;
  [[nodiscard]] std::uint64_t history_bytes() const { return history_.bytes(); }
  /// The file that is written now; empty without a folder, and until that can be written.
  [[nodiscard]] std::string file() const {
    const std::lock_guard lock(mutex_);
    return folder_ ? folder_->file() : std::string();
  }
  /// The newest scans, as a file has them (RecordFile::read()): a past to look into, or to store.
  [[nodiscard]] std::vector<std::byte> recording() const;
  /// What replicas run in, as it was given.
  [[nodiscard]] const Follower::Prepare& prepare() const { return options_.prepare; }

  /// Replicas follow the plant from now on, and the observer is told of every scan that they execute: all of them, as
  /// long as one processor is fast enough beside the tasks; else some are left out, which is said. Before the tasks
  /// start; it must outlive the thread.
  void observe(ScanObserver& observer);

  /// While one lives, replicas follow the plant. Must not outlive the shadow.
  class Viewer {
   public:
    explicit Viewer(Shadow& shadow);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;
    /// Calls `read` with the tasks as their newest scans have left them, globals included; no scan is executed
    /// meanwhile. False, and nothing is called, before the first scans were followed, and when there are no replicas.
    bool read(const std::function<void(Follower&)>& read);

   private:
    Shadow& shadow_;
  };

 private:
  Shadow(ShadowOptions options, RecordingHead head)
      : options_(std::move(options)), head_(std::move(head)), history_(options_.history_bytes) {}
  void run();
  /// Takes records; executes them where somebody looks; writes blocks and faults.
  void turn();
  void follow(Follower::Deadline deadline);
  void make_follower();
  /// A block ends, and replicas have not executed all of it.
  void leaves_out_scans();
  void sum_counts();
  /// Where there is one to be written, and it is not open yet. Why it cannot be.
  std::optional<core::Problem> open_folder();
  void store();
  void store_fault();
  void make_crash_memory(runtime::Resource& resource);
  /// What a process that died before this one has left.
  void store_left();
  void say(core::Severity severity, std::string text);

  const ShadowOptions options_;
  const RecordingHead head_;
  std::vector<std::byte> file_head_;
  History history_;
  std::unique_ptr<RecordFolder> folder_;
  std::unique_ptr<CrashMemory> crash_memory_;
  std::unique_ptr<Recording> recording_;
  std::uint32_t tasks_ = 0;

  // Of the thread alone.
  std::vector<std::vector<std::byte>> unwritten_;  ///< blocks that were completed in this turn
  bool in_trouble_ = false, slow_said_ = false;
  std::chrono::steady_clock::time_point slow_until_{};  ///< at most half of a processor until then
  std::chrono::steady_clock::time_point slow_since_{};
  std::uint64_t faults_seen_ = 0;
  std::optional<std::chrono::steady_clock::time_point> fault_due_, fault_saved_;

  mutable std::mutex mutex_;  ///< of the open blocks and the replicas; no task takes it
  std::unique_ptr<Follower> follower_;
  bool follower_failed_ = false;
  bool followed_ = false;  ///< the replicas have executed all that was recorded; written by the thread alone
  RecordingCounts counts_;

  mutable std::mutex said_mutex_;
  std::vector<ShadowMessage> messages_;

  std::mutex wake_mutex_;
  std::condition_variable wake_;
  std::atomic<int> viewers_{0};
  std::atomic<ScanObserver*> observer_{nullptr};
  std::atomic<bool> ends_{false};
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::shadow
