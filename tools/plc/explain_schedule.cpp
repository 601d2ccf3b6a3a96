#include "tools/plc/explain_schedule.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "io-drivers/config/check_schedule.h"
#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/machine/driver_types.h"
#include "runtime/program.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;
using runtime::ProcessorSchedule;
using runtime::Schedule;
using runtime::TaskDemand;
using runtime::TaskTiming;
using runtime::Verdict;

/// Everything that is printed.
struct Explained {
  const bytecode::Image& image;
  const core::Diagnostics& diagnostics;  ///< names files
  const Schedule& schedule;
  const io::MachineCosts& machine;
  std::span<const runtime::TaskPlan> plan;
};

std::string_view verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::kFits:
      return "fits";
    case Verdict::kDoesNotFit:
      return "does not fit";
    case Verdict::kUnknown:
      return "unknown";
    case Verdict::kNoDeadline:
      return "no deadline";
  }
  return "unknown";
}

std::string time(core::TimeNs ns) {
  return ns < 0 ? "-" + duration_text(-static_cast<double>(ns)) : duration_text(static_cast<double>(ns));
}
std::string time_or_none(const std::optional<core::TimeNs>& ns) { return ns ? time(*ns) : "-"; }
std::string percent(double share) { return fmt::format("{:.1f} %", share * 100); }

std::string released(const bytecode::ImageTask& task) {
  if (!task.single.empty()) return "on " + task.single;
  return task.period_ns == 0 ? std::string("freewheeling") : time(task.period_ns);
}

void print_processor(const Explained& e, const ProcessorSchedule& processor) {
  std::cout << (processor.cpu < 0 ? std::string("any processor") : fmt::format("processor {}", processor.cpu)) << '\n';
  std::vector<std::vector<std::string>> rows = {{"task", "period", "priority", "scan", "by", "lead", "load", "blocking",
                                                 "response", "deadline", "margin", "verdict"}};
  for (std::size_t i = 0; i < processor.tasks.size(); ++i) {
    const std::uint32_t t = processor.tasks[i];
    const TaskDemand& demand = e.schedule.tasks[t];
    const TaskTiming& timing = processor.timings[i];
    rows.push_back({e.image.tasks[t].name, released(e.image.tasks[t]), std::to_string(e.plan[t].priority),
                    time(demand.execution_ns), demand.measured ? "measured" : "estimate", time(demand.lead_ns),
                    percent(timing.utilization), time(demand.blocking_ns + demand.waiting_ns),
                    time_or_none(timing.response_ns), timing.deadline_ns == 0 ? "-" : time(timing.deadline_ns),
                    time_or_none(timing.margin_ns), std::string(verdict_text(timing.verdict))});
  }
  print_table(rows, std::cout);

  const runtime::CpuTiming& cpu = processor.timing;
  std::cout << fmt::format("utilisation {}; Liu and Layland's bound {}, hyperbolic product {:.3f} of 2{}\n",
                           percent(cpu.utilization), percent(cpu.liu_layland_bound), cpu.hyperbolic_product,
                           cpu.bounds_apply ? "" : " (neither says anything here)");
  if (cpu.breakdown_factor) {
    std::cout << fmt::format("everything fits up to {:.2f} times these scans\n", *cpu.breakdown_factor);
  }
  if (cpu.not_rate_monotonic) {
    const auto& [first, second] = *cpu.not_rate_monotonic;
    std::cout << fmt::format(
        "not rate-monotonic: {} does not come after {} and has the longer period; priorities = \"rate-monotonic\" of "
        "[scheduler] would\n",
        e.image.tasks[processor.tasks[first]].name, e.image.tasks[processor.tasks[second]].name);
  }
  std::cout << '\n';
}

std::string place(const Explained& e, const core::SourceRef& at) {
  const std::string file = at.file < e.image.files.size() ? e.image.files[at.file] : std::string();
  return at.line == 0 ? file : fmt::format("{}:{}:{}", file, at.line, at.column);
}

void print_notes(const Explained& e) {
  bool unbound = false, events = false, estimates = false;
  for (std::uint32_t t = 0; t < e.plan.size(); ++t) {
    unbound = unbound || e.plan[t].cpu < 0;
    events = events || !e.image.tasks[t].single.empty();
    estimates = estimates || !e.schedule.tasks[t].measured;
  }
  if (estimates) {
    std::cout << fmt::format(
        "estimate: the longest way through the instructions and {:.0f} % more, by what they take on {}\n",
        e.machine.margin * 100,
        e.machine.calibrated ? e.machine.costs.machine : "a typical machine (plc calibrate measures yours)");
  }
  std::cout << fmt::format("each release takes {} more, of the system\n", time(e.schedule.release_ns));
  for (std::uint32_t t = 0; t < e.plan.size(); ++t) {
    const TaskDemand& demand = e.schedule.tasks[t];
    if (demand.measured) continue;
    for (const runtime::AssumedLoop& loop : demand.assumed) {
      std::cout << fmt::format("{}: {}: a loop whose number of rounds is not known counts as {} rounds [POU {}]\n",
                               e.image.tasks[t].name, place(e, loop.at), runtime::kAssumedRounds,
                               e.image.pous[loop.pou].name);
    }
  }
  if (unbound && e.plan.size() > 1) {
    std::cout << "tasks that are bound to no processor count as if they all ran on one, which is the worst case\n";
  }
  if (events) std::cout << fmt::format("event tasks count as released every {}\n", time(runtime::kFreewheelNs));
}

// ---- JSON -------------------------------------------------------------------------------------------------------

ordered_json maybe(const std::optional<core::TimeNs>& ns) { return ns ? ordered_json(*ns) : ordered_json(nullptr); }

ordered_json task_json(const Explained& e, const ProcessorSchedule& processor, std::size_t i) {
  const std::uint32_t t = processor.tasks[i];
  const bytecode::ImageTask& task = e.image.tasks[t];
  const TaskDemand& demand = e.schedule.tasks[t];
  const TaskTiming& timing = processor.timings[i];
  ordered_json out;
  out["name"] = task.name;
  out["period_ns"] = task.period_ns;
  out["single"] = task.single;
  out["priority"] = e.plan[t].priority;
  out["measured"] = demand.measured;
  out["execution_ns"] = demand.execution_ns;
  out["lead_ns"] = demand.lead_ns;
  out["waiting_ns"] = demand.waiting_ns;
  out["blocking_ns"] = demand.blocking_ns;
  out["utilization"] = timing.utilization;
  out["level_load"] = timing.level_load;
  out["level_bound"] = timing.level_bound;
  out["response_ns"] = maybe(timing.response_ns);
  out["deadline_ns"] = timing.deadline_ns;
  out["margin_ns"] = maybe(timing.margin_ns);
  out["verdict"] = verdict_text(timing.verdict);
  ordered_json loops = ordered_json::array();
  for (const runtime::AssumedLoop& loop : demand.assumed) {
    loops.push_back({{"pou", e.image.pous[loop.pou].name},
                     {"file", loop.at.file < e.image.files.size() ? e.image.files[loop.at.file] : std::string()},
                     {"line", loop.at.line},
                     {"column", loop.at.column},
                     {"rounds", runtime::kAssumedRounds}});
  }
  out["assumed_loops"] = std::move(loops);
  return out;
}

void print_json(const Explained& e, const std::string& file) {
  ordered_json out;
  out["file"] = file;
  out["coherence"] = coherence_name(e.image.options.coherence);
  out["calibrated"] = e.machine.calibrated;
  out["machine"] = e.machine.costs.machine;
  out["margin"] = e.machine.margin;
  out["release_ns"] = e.schedule.release_ns;
  out["processors"] = ordered_json::array();
  for (const ProcessorSchedule& processor : e.schedule.processors) {
    const runtime::CpuTiming& cpu = processor.timing;
    ordered_json one;
    one["cpu"] = processor.cpu < 0 ? ordered_json(nullptr) : ordered_json(processor.cpu);
    one["verdict"] = verdict_text(cpu.verdict);
    one["utilization"] = cpu.utilization;
    one["liu_layland_bound"] = cpu.liu_layland_bound;
    one["hyperbolic_product"] = cpu.hyperbolic_product;
    one["bounds_apply"] = cpu.bounds_apply;
    one["rate_monotonic"] = !cpu.not_rate_monotonic.has_value();
    one["breakdown_factor"] = cpu.breakdown_factor ? ordered_json(*cpu.breakdown_factor) : ordered_json(nullptr);
    one["tasks"] = ordered_json::array();
    for (std::size_t i = 0; i < processor.tasks.size(); ++i) one["tasks"].push_back(task_json(e, processor, i));
    out["processors"].push_back(std::move(one));
  }
  std::cout << out.dump(2) << '\n';
}

}  // namespace

int explain_schedule(Command command, const ExplainSchedule& explain) {
  Compilation compilation;
  if (const auto code = open_or_explain(
          command, {explain.file, explain.options, Goal::kRun, explain.libraries, {}, explain.taskblocks, true},
          compilation)) {
    return *code;
  }
  const bytecode::Image& image = compilation.image->image();
  core::Diagnostics diagnostics;
  if (explain.options.show_all) diagnostics.show_all();
  std::optional<io::Configuration> configuration = io::Configuration{};
  if (!explain.configuration.empty()) configuration = io::load_configuration(explain.configuration, diagnostics);
  std::optional<std::vector<runtime::TaskPlan>> plan;
  std::optional<io::MachineCosts> machine;
  if (configuration) {
    // The plant's machine may have others than this one: which there are, plc-run finds out.
    plan = io::plan_tasks(*configuration, image, io::every_cpu(), runtime::FaultPolicy::kSafeState, diagnostics);
    machine = io::machine_costs(*configuration, diagnostics);
  }
  diagnostics.render_with_lines(std::cerr);
  if (!plan || !machine) {
    const bool unreadable = !configuration && diagnostics.all().front().code == core::Code::P7001;
    return unreadable ? kExitUsage : kExitErrors;
  }
  const Schedule schedule = runtime::make_schedule(image, *plan, machine->costs, machine->margin);
  const Explained explained{image, diagnostics, schedule, *machine, *plan};
  if (explain.json) {
    print_json(explained, explain.file);
    return kExitOk;
  }
  std::cout << fmt::format("coherence={}\n\n", coherence_name(image.options.coherence));
  for (const ProcessorSchedule& processor : schedule.processors) print_processor(explained, processor);
  print_notes(explained);
  return kExitOk;
}

}  // namespace plc::tools
