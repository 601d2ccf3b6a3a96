// How a plant is, in a word.
//
// Threads: any. Does not belong here: tasks one by one (statistics).
#pragma once

#include <string_view>

#include "bytecode/image.h"
#include "runtime/sched/realtime.h"

namespace plc::engineering {

/// "starts", "runs", "faulted", "stopped", "stops".
std::string_view plant_state(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler);
/// The same of a task: "starts", "runs", "faulted", "stopped".
std::string_view task_state(std::uint32_t task, const runtime::RealtimeScheduler& scheduler);

}  // namespace plc::engineering
