#include "runtime/program.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/floating_point.h"
#include "runtime/compiled_task.h"
#include "runtime/interpreter/events.h"
#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/interpreter/operations.h"
#include "runtime/link/link.h"
#include "runtime/memory/forces.h"
#include "runtime/pointers/objects.h"
#include "runtime/probes.h"
#include "runtime/record/recorder.h"
#include "runtime/record/replay.h"
#include "runtime/sched/task.h"
#include "runtime/taskblocks.h"

namespace plc::runtime {

struct Program::State {
  State(const bytecode::Image& image_in, std::uint32_t index_in, TaskLayout layout, const ProgramOptions& options_in)
      : image(image_in),
        index(index_in),
        options(options_in),
        table(image_in, image_in.tasks[index_in].body, std::move(layout), options_in.huge_pages) {}

  const bytecode::Image& image;
  std::uint32_t index;
  ProgramOptions options;
  TaskTable table;
  std::unique_ptr<Exchange> exchange;
  Forces forces;
  std::optional<ForcingExchange> forcing;
  EventTable events;
  std::vector<QueueEnd> queues;            ///< by queue of the image
  std::unique_ptr<Taskblocks> taskblocks;  ///< null when the task runs none
  std::optional<TableTypes> types;         ///< of replicas
  LinkedCode code;
  std::optional<Objects> objects;  ///< nothing when the task uses no pointers
  Machine machine;
  std::optional<Handover> handover;        ///< nothing when nothing of the task is kept
  bool whole = false;                      ///< the last scan has ended without a fault
  std::unique_ptr<CompiledTask> compiled;  ///< null = the interpreter
  Recorder* recorder = nullptr;            ///< null = nothing is recorded
  std::atomic<bool> cut{false};            ///< loops were cut from outside
  bool replica = false;
  std::unique_ptr<Probes> probes;         ///< null = nobody looks
  LinkedCode plain;                       ///< the code without probes, while somebody looks
  std::unique_ptr<CompiledTask> resting;  ///< what ran it
};

core::Code fault_code(FaultKind kind) {
  switch (kind) {
    case FaultKind::kLoopBudget:
      return core::Code::R1001;
    case FaultKind::kWatchdog:
      return core::Code::R1002;
    case FaultKind::kOverrun:
      return core::Code::R1003;
    case FaultKind::kTaskblock:
      return core::Code::R1004;
    case FaultKind::kBudget:
      return core::Code::R1005;
    case FaultKind::kNone:
      break;
  }
  return core::Code::P9001;
}

core::SourceRef source_of(const bytecode::Image& image, std::uint32_t pou, std::uint32_t word) {
  const std::vector<bytecode::DebugEntry>& debug = image.pous[pou].debug;
  const auto after =
      std::upper_bound(debug.begin(), debug.end(), word,
                       [](std::uint32_t w, const bytecode::DebugEntry& entry) { return w < entry.word; });
  return after == debug.begin() ? core::SourceRef{} : (after - 1)->at;
}

Program::Program(std::unique_ptr<State> state) : state_(std::move(state)) {}
Program::~Program() = default;

core::Result<std::unique_ptr<Program::State>> Program::lay_out(const bytecode::VerifiedImage& verified,
                                                               std::uint32_t task, const ProgramOptions& options) {
  const bytecode::Image& image = verified.image();
  const bytecode::ImageTask& entry = image.tasks[task];
  if (task >= Handle::kMaxTasks || image.types.size() > Handle::kMaxTypes) {
    return core::Problem{core::Code::P9001, "image has more tasks or types than references can name", {}};
  }
  std::vector<std::uint8_t> reached(image.pous.size(), 0);
  for (const std::uint32_t pou : reached_pous(image, entry.body)) reached[pou] = 1;
  TaskLayout layout = runtime::lay_out(image, entry.body, reached);
  if (layout.total + kScratchBytes >= kRelativeBit) {
    return core::Problem{core::Code::P9001,
                         "memory of task \"" + entry.name + "\" would take " + std::to_string(layout.total) + " bytes",
                         "at most 2 GiB can be addressed; make arrays smaller or split the project"};
  }
  return std::make_unique<State>(image, task, std::move(layout), options);
}

// Code and pointers, once there is an exchange.
std::optional<core::Problem> Program::resolve(State& state) {
  const bytecode::Image& image = state.image;
  const std::uint32_t body = image.tasks[state.index].body;
  const std::vector<std::uint32_t> pous = reached_pous(image, body);
  auto code = link_task(image, body, pous, state.table.layout(), *state.exchange, state.options.arrange);
  if (!code) return code.error();
  state.code = std::move(*code);
  state.exchange->prepare();
  if (uses_pointers(image, pous)) {
    auto objects = Objects::make(image, body, state.table.layout(), Handle::task_tag(state.index));
    if (!objects) return objects.error();
    state.objects.emplace(std::move(*objects));
  }
  return {};
}

std::unique_ptr<Program> Program::ready(std::unique_ptr<State> state) {
  Machine& m = state->machine;
  m.table = state->table.data();
  m.code = state->code.data();
  m.marks = state->code.marks;
  m.exchange = state->exchange.get();
  m.events = &state->events;
  m.taskblocks = state->taskblocks.get();
  m.queues = state->queues.data();
  m.objects = state->objects ? &*state->objects : nullptr;
  m.step.host = m.taskblocks;
  m.step.zone = state->options.zone;
  m.task_tag = Handle::task_tag(state->index);
  m.global_bytes = state->table.layout().global_bytes;
  m.constants_begin = state->table.layout().constants;
  m.constants_end = m.constants_begin + static_cast<std::uint32_t>(state->image.const_bytes.size());
  return std::unique_ptr<Program>(new Program(std::move(state)));
}

core::Result<std::unique_ptr<Program>> Program::link(const bytecode::VerifiedImage& verified, std::uint32_t task,
                                                     GlobalTable& globals, const ProgramOptions& options) {
  auto laid_out = lay_out(verified, task, options);
  if (!laid_out) return laid_out.error();
  std::unique_ptr<State> state = std::move(*laid_out);
  const bytecode::Image& image = state->image;
  state->exchange = make_exchange(image.options.coherence, globals, task, state->table.data());
  for (std::uint32_t q = 0; q < image.queues.size(); ++q) state->queues.emplace_back(globals.queue(q), task);
  if (auto problem = resolve(*state)) return *problem;
  const taskblocks::Registry& registry =
      options.taskblocks != nullptr ? *options.taskblocks : taskblocks::Registry::built_in();
  auto blocks = Taskblocks::make(image, task, registry, state->table, state->queues, options);
  if (!blocks) return blocks.error();
  state->taskblocks = std::move(*blocks);
  if (state->taskblocks && options.start_taskblocks) {
    if (auto problem = state->taskblocks->restart()) return *problem;
  }
  return ready(std::move(state));
}

core::Result<std::unique_ptr<Program>> Program::link_replica(const bytecode::VerifiedImage& verified,
                                                             std::uint32_t task, Replay& replay,
                                                             const ProgramOptions& options) {
  auto laid_out = lay_out(verified, task, options);
  if (!laid_out) return laid_out.error();
  std::unique_ptr<State> state = std::move(*laid_out);
  const bytecode::Image& image = state->image;
  state->exchange = std::make_unique<ReplayExchange>(replay);
  for (const bytecode::ImageQueue& queue : image.queues)
    state->queues.emplace_back(replay, image.types[queue.type].size);
  if (auto problem = resolve(*state)) return *problem;
  state->replica = true;
  state->taskblocks = Taskblocks::make_replica(image, task, state->table, options, replay);
  const std::span<std::byte> table(state->table.data(), static_cast<std::size_t>(state->table.layout().total));
  state->types.emplace(image, task, image.tasks[task].body, state->table.layout());
  replay.set_table(table, &*state->types);
  return ready(std::move(state));
}

// RT:
void Program::expect(std::size_t bytes) noexcept { state_->exchange->expect(bytes); }

// RT:
Fault Program::execute(const CycleContext& context) noexcept {
  State& s = *state_;
  const std::uint64_t events = s.machine.event_count;
  s.whole = false;
  s.machine.step.now_ns = context.now_ns;
  s.machine.step.start_ns = context.start_ns;
  s.machine.step.utc_ns = context.utc_ns;
  if (s.taskblocks) s.taskblocks->begin(context.now_ns, context.utc_ns);
  s.machine.loops_left.store(s.options.loop_budget, std::memory_order_relaxed);
  s.machine.place.store(s.code.entry, std::memory_order_relaxed);
  Exchange* exchange = s.exchange.get();
  if (s.forces.take()) [[unlikely]] {
    s.forcing->hold(s.forces.places());
    exchange = &*s.forcing;
  }
  s.machine.exchange = exchange;
  exchange->begin();
  const bool ran = s.compiled != nullptr
                       ? s.compiled->run(s.machine)
                       : run_body(s.machine, Addressing::kFixed, s.code.entry, s.table.layout().instance);
  const bool published = exchange->end();
  // WHY not Machine::fault, reset before the scan: reading it back here waits for all that the scan has written.
  s.whole = ran && published;
  if (!s.whole && !published) {
    // A scan that was cut short knows its place better than the thread that looked from outside.
    if (ran) s.machine.fault = place(FaultKind::kWatchdog);
    s.machine.fault.kind = FaultKind::kWatchdog;
  }
  const Fault fault = s.whole ? Fault{} : s.machine.fault;
  if (s.recorder != nullptr) [[unlikely]]
    record(context, fault, events, published);
  return fault;
}

// RT:
void Program::record(const CycleContext& context, const Fault& fault, std::uint64_t events, bool published) noexcept {
  State& s = *state_;
  RecordHead head;
  if (fault && s.cut.load(std::memory_order_relaxed)) head.flags |= kCut;
  if (!published) head.flags |= kRevoked;
  if (!core::has_floating_point_mode()) head.flags |= kFloatMode;
  head.events = static_cast<std::uint32_t>(s.machine.event_count - events);
  head.now_ns = context.now_ns;
  head.start_ns = context.start_ns;
  head.utc_ns = context.utc_ns;
  s.recorder->close(head, {static_cast<std::uint32_t>(fault.kind), fault.pou, fault.word, fault.taskblock});
}

// RT:
void Program::write_local(std::uint32_t at, std::span<const std::byte> value) noexcept {
  State& s = *state_;
  std::memcpy(s.table.data() + at, value.data(), value.size());
  if (s.recorder != nullptr) s.recorder->written(at, static_cast<std::uint32_t>(value.size()));
}

void Program::set_recorder(Recorder* recorder) {
  State& s = *state_;
  s.recorder = recorder;
  s.exchange->set_recorder(recorder);
  if (s.forcing) s.forcing->set_recorder(recorder);
  for (QueueEnd& queue : s.queues) queue.set_recorder(recorder);
  if (s.taskblocks) s.taskblocks->set_recorder(recorder);
}

Forces& Program::forces() {
  State& s = *state_;
  if (!s.forcing) {
    s.forcing.emplace(*s.exchange, s.table.data());
    s.forcing->set_recorder(s.recorder);
  }
  return s.forces;
}

void Program::set_now(core::TimeNs now_ns, core::TimeNs utc_ns) noexcept {
  state_->machine.step.now_ns = now_ns;
  state_->machine.step.utc_ns = utc_ns;
  if (state_->taskblocks) state_->taskblocks->set_now(now_ns, utc_ns);
}

// RT:
Fault Program::place(FaultKind kind) const noexcept {
  const CodeMark& mark = mark_at(state_->machine.marks, state_->machine.place.load(std::memory_order_relaxed));
  return {kind, mark.pou, mark.word, state_->taskblocks ? state_->taskblocks->running() : Taskblocks::kNone};
}

const LinkedCode& Program::linked() const { return state_->code; }

void Program::install(std::unique_ptr<CompiledTask> compiled) {
  state_->compiled = std::move(compiled);
  state_->machine.code = state_->compiled->code.data();
  state_->machine.marks = state_->compiled->marks;
}

std::optional<core::Problem> Program::look_at(std::span<const ProbedPou> views) {
  State& s = *state_;
  if (!s.replica) return core::Problem{core::Code::P9001, "probes are looked at in replicas only", {}};
  if (!views.empty()) {
    const std::uint32_t body = task().body;
    const std::vector<std::uint32_t> pous = reached_pous(s.image, body);
    auto probes = std::make_unique<Probes>(s.image, body, pous, s.table.layout(), views);
    auto code = link_task(s.image, body, pous, s.table.layout(), *s.exchange, s.options.arrange, probes.get());
    if (!code) return code.error();
    if (!s.probes) {
      s.plain = std::move(s.code);
      s.resting = std::move(s.compiled);
    }
    s.code = std::move(*code);
    s.probes = std::move(probes);
  } else if (s.probes) {
    s.code = std::move(s.plain);
    s.compiled = std::move(s.resting);
    s.probes.reset();
  }
  s.machine.probes = s.probes.get();
  s.machine.code = s.compiled ? s.compiled->code.data() : s.code.data();
  s.machine.marks = s.compiled ? s.compiled->marks : std::span<const CodeMark>(s.code.marks);
  return {};
}

Probes* Program::probes() noexcept { return state_->probes.get(); }

bool Program::is_compiled() const noexcept { return state_->compiled != nullptr; }

// RT:
void Program::cut_loops() noexcept {
  state_->cut.store(true, std::memory_order_relaxed);
  state_->machine.loops_left.store(0, std::memory_order_relaxed);
}
// RT:
bool Program::revoke() noexcept { return state_->exchange->revoke(); }
// RT:
void Program::publish_safe(std::span<const GlobalWrite> values) noexcept { state_->exchange->publish_safe(values); }
void Program::set_priority_change(SetPriority set) { state_->exchange->set_priority_change(set); }

// RT:
bool Program::read_global_bool(std::uint32_t offset) noexcept { return state_->exchange->read_bool(offset); }

const bytecode::Image& Program::image() const { return state_->image; }
const bytecode::ImageTask& Program::task() const { return state_->image.tasks[state_->index]; }
std::uint32_t Program::task_index() const { return state_->index; }
TaskTable& Program::table() { return state_->table; }
const TaskTable& Program::table() const { return state_->table; }
std::vector<EventCount> Program::events() const { return state_->events.counts(); }
std::uint64_t Program::other_events() const { return state_->events.other(); }
std::uint64_t Program::event_total() const { return state_->events.total(); }
const Program::LinkReport& Program::link_report() const { return state_->code.report; }

void Program::restore(std::span<const std::byte> globals, std::span<const std::byte> instance) {
  std::byte* const table = state_->table.data();
  if (!globals.empty()) std::memcpy(table, globals.data(), globals.size());
  if (!instance.empty()) std::memcpy(table + state_->table.layout().instance, instance.data(), instance.size());
  state_->exchange->reset();
  if (state_->recorder != nullptr) state_->recorder->changed();
}

void Program::keep(std::vector<Handover::Run> runs, std::size_t bytes) {
  state_->handover.emplace(std::move(runs), bytes);
}

Handover* Program::handover() noexcept { return state_->handover ? &*state_->handover : nullptr; }

// RT:
bool Program::offer_kept() noexcept {
  State& s = *state_;
  return s.handover && s.whole && s.handover->offer(s.table.data(), s.machine.step.now_ns);
}

std::optional<core::Problem> Program::start_taskblocks() {
  return state_->taskblocks ? state_->taskblocks->restart() : std::nullopt;
}

const char* Program::running_taskblock() const noexcept {
  const Taskblocks* const blocks = state_->taskblocks.get();
  const std::uint32_t running = blocks != nullptr ? blocks->running() : Taskblocks::kNone;
  return running == Taskblocks::kNone ? nullptr : blocks->name(running).c_str();
}

// RT:
void Program::count_allocation() noexcept {
  Taskblocks* const blocks = state_->taskblocks.get();
  const std::uint32_t running = blocks != nullptr ? blocks->running() : Taskblocks::kNone;
  if (running != Taskblocks::kNone) blocks->count_allocation(running);
}

std::vector<Program::Allocations> Program::allocations() const {
  std::vector<Allocations> found;
  const Taskblocks* const blocks = state_->taskblocks.get();
  for (std::uint32_t object = 0; blocks != nullptr && object < blocks->count(); ++object) {
    const std::uint64_t count = blocks->allocations(object);
    if (count != 0) found.push_back({blocks->name(object), count});
  }
  return found;
}

std::vector<TaskblockMessage> Program::messages() {
  return state_->taskblocks ? state_->taskblocks->messages() : std::vector<TaskblockMessage>();
}

std::uint64_t Program::lost_messages() { return state_->taskblocks ? state_->taskblocks->lost_messages() : 0; }

std::string Program::taskblock_text(const Fault& fault) const {
  if (!state_->taskblocks || fault.taskblock == Taskblocks::kNone) return {};
  return state_->taskblocks->text(fault.taskblock);
}

std::optional<core::Problem> Program::reset() {
  state_->table.reset(state_->image, task().body);
  state_->exchange->reset();
  state_->events.clear();
  if (state_->recorder != nullptr) state_->recorder->changed();
  return state_->taskblocks ? state_->taskblocks->restart() : std::nullopt;
}

}  // namespace plc::runtime
