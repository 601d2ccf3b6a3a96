#include "runtime/sched/simulation.h"

#include <algorithm>

namespace plc::runtime {

Simulation::Simulation(Resource& resource, SimulationOptions options)
    : resource_(resource), options_(options), order_(priority_order(resource.image())) {
  const bytecode::Image& image = resource.image();
  for (const bytecode::ImageTask& task : image.tasks) {
    tasks_.push_back({ReleaseGrid(0, grid_period(task)), trigger_of(image, task), false, false, false, 0});
  }
  ran_.reserve(tasks_.size());
}

std::optional<core::TimeNs> Simulation::next_instant_ns() const {
  if (stopped_) return std::nullopt;
  // When all cyclic tasks have halted, time goes on as they would.
  std::optional<core::TimeNs> next, halted;
  for (const SimulatedTask& task : tasks_) {
    if (task.trigger) continue;
    std::optional<core::TimeNs>& earliest = task.halted ? halted : next;
    if (!earliest || task.grid.next_ns() < *earliest) earliest = task.grid.next_ns();
  }
  if (next || halted) return next ? next : halted;
  // Only event tasks: time still goes on, so that stimuli and triggers are looked at.
  return cycle_ == 0 ? 0 : clock_.now_ns() + kFreewheelNs;
}

void Simulation::look_at_triggers() {
  for (SimulatedTask& task : tasks_) {
    if (!task.trigger) continue;
    std::byte value{};
    resource_.globals().read(*task.trigger, 1, &value);
    const bool now = value != std::byte{0};
    if (now && !task.trigger_was && !task.halted) task.due = true;
    task.trigger_was = now;
  }
}

void Simulation::run_task(std::uint32_t index) {
  SimulatedTask& task = tasks_[index];
  const core::TimeNs now_ns = clock_.now_ns();
  const ReleaseContext context{index, task.scans, now_ns, now_ns, options_.date_ns + now_ns};
  task.due = false;
  for (CycleListener* const listener : listeners_) listener->before_scan(context);
  resource_.process_image().sync();
  const Fault fault =
      resource_.program(index).execute({options_.program_time_ns + now_ns, options_.program_time_ns, context.utc_ns});
  resource_.process_image().sync();
  ++task.scans;
  for (CycleListener* const listener : listeners_) listener->after_scan(context);
  ran_.push_back(index);
  if (!fault) return;
  ++fault_count_;
  if (faults_.size() < kMaxFaultsKept) faults_.push_back({index, context.cycle, context.now_ns, fault});
  if (options_.on_fault == FaultPolicy::kContinue) return;
  task.halted = true;
  stopped_ = stopped_ || options_.on_fault == FaultPolicy::kStop;
  resource_.globals().task_stopped(index);
  for (CycleListener* const listener : listeners_) listener->task_stopped(index);
}

bool Simulation::step() {
  const auto next = next_instant_ns();
  if (!next) return false;
  clock_.sleep_until_ns(*next);
  ran_.clear();
  for (const Hook& hook : before_) hook({cycle_, clock_.now_ns(), {}});
  for (SimulatedTask& task : tasks_) {
    if (task.trigger || task.grid.next_ns() > clock_.now_ns()) continue;
    task.due = !task.halted;
    task.grid.advance(clock_.now_ns());
  }
  look_at_triggers();
  // A task may release another by its exports: the most urgent one due is looked for anew after each scan. An event
  // task runs once per instant at most, since its trigger has to fall in between.
  for (;;) {
    const auto due = std::find_if(order_.begin(), order_.end(), [this](std::uint32_t t) {
      return tasks_[t].due && std::find(ran_.begin(), ran_.end(), t) == ran_.end();
    });
    if (due == order_.end() || stopped_) break;
    run_task(*due);
    look_at_triggers();
  }
  for (const Hook& hook : after_) hook({cycle_, clock_.now_ns(), ran_});
  ++cycle_;
  return true;
}

std::uint64_t Simulation::run_cycles(std::uint64_t count) {
  std::uint64_t done = 0;
  while (done < count && step()) ++done;
  return done;
}

std::uint64_t Simulation::run_until(core::TimeNs end_ns) {
  std::uint64_t done = 0;
  for (;;) {
    const auto next = next_instant_ns();
    if (!next || *next >= end_ns || !step()) return done;
    ++done;
  }
}

}  // namespace plc::runtime
