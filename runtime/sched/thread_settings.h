// Settings of threads: which processor executes them, and how urgent they are to Linux.
//
// In: threads that live. Out: what the system permits, or why it does not (EPERM without the privilege, EINVAL for a
// processor that there is not). Does not belong here: who gets which priority (priority.h, task_plan.h).
#pragma once

#include <pthread.h>

#include <cstddef>
#include <cstdint>

namespace plc::runtime {

/// Enough for tasks and what is beside them. All of a stack is locked into memory with the rest of the process.
inline constexpr std::size_t kThreadStackBytes = std::size_t{1} << 20;
/// The stack of threads that are made from now on without a size of their own, in bytes. Before the first thread.
void set_stack_of_threads(std::size_t bytes) noexcept;

/// Makes `thread` a real-time one of SCHED_FIFO priority `fifo`, 1 to 99. 0, or an errno. RT: one system call.
[[nodiscard]] int set_fifo(pthread_t thread, int fifo) noexcept;
/// Makes `thread` one that shares the processor's time with others (SCHED_OTHER). 0, or an errno. RT: one system call.
[[nodiscard]] int set_ordinary(pthread_t thread) noexcept;
/// Binds `thread` to processor `cpu`, from 0 on. 0, or an errno.
[[nodiscard]] int bind_to_cpu(pthread_t thread, int cpu) noexcept;
/// Gives the calling thread, a real-time one, the priority of IEC priority `priority` (SetPriority of
/// runtime/memory/exchange.h). RT: one system call.
void set_own_priority(std::int32_t priority) noexcept;

}  // namespace plc::runtime
