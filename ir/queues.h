// Queues between tasks (paper, 3.1): several tasks put elements in, one takes them out, nobody waits.
//
// A global array that is named at QUEUE_PUT, QUEUE_GET, QUEUE_COUNT, QUEUE_SPACE or at a queue port of a taskblock is
// no variable but a queue: as many elements as the array has, for each task that puts. In: the place that a call names.
// Out: a function made for this queue, or a port bound to it. Does not belong here: the ring itself
// (runtime/memory/queue.h).
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "ir/builder.h"

namespace plc::ir {

/// Which of the queue functions `name` is, in any letter case.
std::optional<QueueFunction> queue_function_named(std::string_view name);

/// The function POU of `function` for the queue at `place`, which becomes one: an index into Module::pous, at whose end
/// it is added when it is new. `what` names the parameter in messages. Nothing, and reported (P4111), when the place
/// cannot be a queue.
std::optional<std::uint32_t> queue_function(Builder& builder, QueueFunction function, PlaceId place,
                                            const SourceRef& at, std::string_view what);

/// Binds port `variable` of the taskblock instance at `instance` to the queue at `place`. False, and reported (P4111),
/// when the place cannot be a queue of the port's elements, or the instance is not known before the program runs.
bool connect_queue(Builder& builder, PlaceId instance, std::uint32_t variable, PlaceId place, const SourceRef& at,
                   std::string_view what);

/// What a task does with a queue, here or in what it calls.
struct QueueUse {
  bool puts = false;
  bool takes = false;
};
/// By global index.
std::vector<QueueUse> queue_use(const Module& module, const Task& task);

/// Reports queues that are also used as variables (P4112), and queues that several tasks take from (P4205).
void check_queues(const Module& module, core::Diagnostics& diagnostics);

}  // namespace plc::ir
