#include "native/helpers.h"

#include "runtime/interpreter/operations.h"
#include "runtime/taskblocks.h"

namespace plc::native {

// RT:
void raise_event(runtime::Machine& machine, std::uint32_t position, std::uint32_t event) noexcept {
  runtime::raise(machine, machine.code + position, static_cast<stdlib::Event>(event));
}

// RT:
void fail_loop(runtime::Machine& machine, std::uint32_t position) noexcept {
  runtime::fail(machine, machine.code + position, runtime::FaultKind::kLoopBudget);
}

// RT:
bool run_taskblock(runtime::Machine& machine, std::uint32_t position, std::byte* ports) noexcept {
  machine.place.store(position, std::memory_order_relaxed);
  const runtime::Taskblocks::Status status = machine.taskblocks->run(ports);
  return status == runtime::Taskblocks::Status::kFine ||
         runtime::settle_taskblock(machine, machine.code + position, status);
}

// RT:
bool copy_text(std::byte* to, const std::byte* from, std::uint32_t capacities, std::uint32_t width) noexcept {
  return runtime::copy_string(to, from, capacities, width);
}

}  // namespace plc::native
