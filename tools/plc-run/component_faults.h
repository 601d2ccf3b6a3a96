// What plc-run notices of components that misbehave beyond what the runtime contains: the process crashes, fire()
// allocates memory.
//
// In: the resource that runs. Out: one line on stderr before a crash takes its course, counts in the programs
// (Program::allocations()). Does not belong here: what the runtime contains itself (runtime/taskblocks.h), what becomes
// of the outputs of a dead process (io-drivers/guardian).
#pragma once

#include <cstdint>

#include "runtime/resource.h"

namespace plc::tools {

/// From here on a crash of this process says in which taskblock it is. Nothing else changes: it ends by the same
/// signal, with the same core file. Once, before taskblocks are made; `resource` must outlive its threads.
void name_crashes(runtime::Resource& resource);

/// On the thread of a task before its first cycle, for RealtimeOptions::on_thread_start: its crashes are named, even
/// when it has no stack left, and its allocations counted.
void watch_task_thread(std::uint32_t task);

/// The program of the task whose thread this is, or null. RT, also for signal handlers and malloc().
runtime::Program* program_of_thread() noexcept;

}  // namespace plc::tools
