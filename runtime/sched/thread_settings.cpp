#include "runtime/sched/thread_settings.h"

#include <sched.h>

#include <cerrno>

#include "runtime/sched/priority.h"

namespace plc::runtime {

void set_stack_of_threads(std::size_t bytes) noexcept {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  // Refused: threads have what they had.
  if (pthread_attr_setstacksize(&attributes, bytes) == 0) static_cast<void>(pthread_setattr_default_np(&attributes));
  pthread_attr_destroy(&attributes);
}

// RT:
int set_fifo(pthread_t thread, int fifo) noexcept {
  sched_param parameter{};
  parameter.sched_priority = fifo;
  return pthread_setschedparam(thread, SCHED_FIFO, &parameter);
}

// RT:
int set_ordinary(pthread_t thread) noexcept {
  const sched_param parameter{};
  return pthread_setschedparam(thread, SCHED_OTHER, &parameter);
}

int bind_to_cpu(pthread_t thread, int cpu) noexcept {
  if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  return pthread_setaffinity_np(thread, sizeof set, &set);
}

// RT: without the lock that the pthread function takes; what it could refuse was refused when the thread started.
void set_own_priority(std::int32_t priority) noexcept {
  sched_param parameter{};
  parameter.sched_priority = fifo_priority(priority);
  static_cast<void>(sched_setparam(0, &parameter));
}

}  // namespace plc::runtime
