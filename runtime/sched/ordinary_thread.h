// OrdinaryThread: a thread beside the tasks. It gets nothing from its maker that is meant for tasks: no signals, no
// real-time priority.
//
// Threads: start() and join() belong to one owner. Does not belong here: what it does.
#pragma once

#include <pthread.h>

#include <csignal>
#include <thread>

#include "runtime/sched/thread_settings.h"

namespace plc::runtime {

class OrdinaryThread {
 public:
  /// `name`: what top shows, at most 15 characters. Throws std::system_error when no thread is to be had.
  template <class Run>
  void start(const char* name, Run run) {
    const NoSignals none;
    thread_ = std::thread([name, run] {
      static_cast<void>(set_ordinary(pthread_self()));
      pthread_setname_np(pthread_self(), name);
      run();
    });
  }
  /// True from start() to join().
  [[nodiscard]] bool joinable() const { return thread_.joinable(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  /// Of the calling thread, and of what it starts meanwhile: no signals.
  struct NoSignals {
    NoSignals() {
      sigset_t all;
      sigfillset(&all);
      pthread_sigmask(SIG_SETMASK, &all, &before);
    }
    ~NoSignals() { pthread_sigmask(SIG_SETMASK, &before, nullptr); }
    NoSignals(const NoSignals&) = delete;
    NoSignals& operator=(const NoSignals&) = delete;
    sigset_t before{};
  };

  std::thread thread_;
};

}  // namespace plc::runtime
