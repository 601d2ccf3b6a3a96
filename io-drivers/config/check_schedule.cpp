#include "io-drivers/config/check_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/text.h"
#include "io-drivers/config/calibration.h"

namespace plc::io {
namespace {

using core::Code;
using runtime::ProcessorSchedule;
using runtime::TaskTiming;
using runtime::Verdict;

std::string time_text(core::TimeNs ns) {
  if (ns >= 10'000'000) return fmt::format("{:.1f} ms", static_cast<double>(ns) / 1e6);
  return ns >= 10'000 ? fmt::format("{:.1f} us", static_cast<double>(ns) / 1e3) : fmt::format("{} ns", ns);
}

/// Where plc.toml speaks of the task, or of all.
const core::SourceRef& place_of(const Configuration& configuration, const std::string& task) {
  for (const TaskConfig& config : configuration.tasks) {
    if (core::iequals(config.name, task)) return config.at;
  }
  return configuration.scheduler.at.line != 0 ? configuration.scheduler.at : configuration.at;
}

std::string processor_text(int cpu) { return cpu < 0 ? "one processor" : fmt::format("processor {}", cpu); }

/// Why the deadline may be missed.
std::string sentence(const std::string& task, const ProcessorSchedule& processor, const TaskTiming& timing) {
  if (timing.verdict == Verdict::kUnknown) {
    return fmt::format("nobody can say when task \"{}\" ends: of one as urgent it is not known how often it runs",
                       task);
  }
  if (timing.response_ns) {
    return fmt::format("task \"{}\" may end {} after its release; its deadline is {}", task,
                       time_text(*timing.response_ns), time_text(timing.deadline_ns));
  }
  return fmt::format("task \"{}\" may fall behind without end: with the tasks before it, it needs {:.0f} % of {}", task,
                     timing.level_load * 100, processor_text(processor.cpu));
}

}  // namespace

std::optional<MachineCosts> machine_costs(const Configuration& configuration, core::Diagnostics& diagnostics) {
  const Placed& file = configuration.scheduler.calibration;
  if (file.text.empty()) return MachineCosts{typical_costs(), kTypicalMargin, false};
  const auto path = std::filesystem::path(configuration.file).parent_path() / file.text;
  auto costs = load_calibration(path.string(), file.at, diagnostics);
  if (!costs) return std::nullopt;
  return MachineCosts{std::move(*costs), kCalibratedMargin, true};
}

void report_schedule(const Configuration& configuration, const bytecode::Image& image,
                     std::span<const runtime::TaskPlan> plan, const runtime::Schedule& schedule,
                     const MachineCosts& machine, std::span<const int> cpus, core::Diagnostics& diagnostics) {
  const std::vector<std::uint32_t> misses = runtime::certain_misses(image, plan, cpus);
  const bool refuse = configuration.scheduler.unfit == Unfit::kRefuse;
  std::set<std::uint32_t> told;
  for (const std::uint32_t t : misses) {
    const std::string& name = image.tasks[t].name;
    diagnostics.report(refuse ? Code::P7606 : Code::P7605, place_of(configuration, name), {},
                       fmt::format("task \"{}\" cannot meet its deadline by the measured times of the tasks", name),
                       refuse
                           ? "plc explain FILE --schedule --config PLC.TOML shows how they meet; bind some to another "
                             "processor, give them longer intervals, or run them all the same: [scheduler] unfit = "
                             "\"run\""
                           : "plc explain FILE --schedule --config PLC.TOML shows how they meet");
    told.insert(t);
  }
  for (const ProcessorSchedule& processor : schedule.processors) {
    for (std::size_t i = 0; i < processor.tasks.size(); ++i) {
      const std::uint32_t t = processor.tasks[i];
      const TaskTiming& timing = processor.timings[i];
      const bool fine = timing.verdict == Verdict::kFits || timing.verdict == Verdict::kNoDeadline;
      if (fine || !told.insert(t).second) continue;
      std::string message = sentence(image.tasks[t].name, processor, timing);
      const bool all_measured = std::all_of(processor.tasks.begin(), processor.tasks.end(),
                                            [&](std::uint32_t one) { return schedule.tasks[one].measured; });
      if (!all_measured) message += fmt::format(" (estimated, with a margin of {:.0f} %)", machine.margin * 100);
      diagnostics.report(
          Code::P7605, place_of(configuration, image.tasks[t].name), {}, std::move(message),
          "plc explain FILE --schedule shows how the tasks meet; what plc-run measured counts instead of "
          "an estimate: [tasks.NAME] execution");
    }
  }
}

void check_schedule(const Configuration& configuration, const bytecode::Image& image,
                    std::span<const runtime::TaskPlan> plan, std::span<const int> cpus, core::Diagnostics& diagnostics,
                    std::uint32_t loop_budget) {
  const auto machine = machine_costs(configuration, diagnostics);
  if (!machine) return;
  const runtime::Schedule schedule = runtime::make_schedule(image, plan, machine->costs, machine->margin, loop_budget);
  report_schedule(configuration, image, plan, schedule, *machine, cpus, diagnostics);
}

}  // namespace plc::io
