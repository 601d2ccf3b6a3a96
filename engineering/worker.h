// Worker: a thread for what takes long: passwords, files. What comes first is done first; what is too much is refused.
//
// Threads: post() any; start() and stop() one owner. Does not belong here: what is done.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>

#include "runtime/sched/ordinary_thread.h"

namespace plc::engineering {

class Worker {
 public:
  explicit Worker(std::size_t most) : most_(most) {}
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// `name`: at most 15 characters.
  void start(const char* name);
  /// What has begun is ended, the rest is not done any more.
  void stop();
  /// After stop(): lets go of the rest.
  void drop();
  /// False when as much waits as may. Work that throws is lost.
  bool post(std::function<void()> work);

 private:
  void run();

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> waiting_;
  bool stopping_ = false;
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::engineering
