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
  /// `name`: what top shows, at most 15 characters.
  template <class Run>
  void start(const char* name, Run run) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([name, run] {
      static_cast<void>(set_ordinary(pthread_self()));
      pthread_setname_np(pthread_self(), name);
      run();
    });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  /// True from start() to join().
  [[nodiscard]] bool joinable() const { return thread_.joinable(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::thread thread_;
};

}  // namespace plc::runtime
