// Lints about tasks: priorities against intervals.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "ir/lint_findings.h"

namespace plc::ir {
namespace {

/// More tasks than this are counted, not named.
constexpr std::size_t kNamed = 4;

/// "10ms", "2500us": in the largest unit of which it is a whole number.
std::string interval_text(std::int64_t ns) {
  constexpr std::array<std::pair<std::int64_t, const char*>, 3> kUnits = {
      {{1'000'000'000, "s"}, {1'000'000, "ms"}, {1'000, "us"}}};
  for (const auto& [unit, name] : kUnits) {
    if (ns % unit == 0) return fmt::format("{}{}", ns / unit, name);
  }
  return fmt::format("{}ns", ns);
}

std::string described(const Task& task) {
  return fmt::format("{} (every {}, priority {})", task.name, interval_text(task.period_ns), task.priority);
}

/// "A (every 1ms, priority 1), B (every 2ms, priority 1) and 3 more"
std::string listed(const std::vector<const Task*>& tasks) {
  std::string text;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const bool last = i + 1 == tasks.size();
    text += i == 0 ? "" : last ? " and " : ", ";
    if (i + 1 == kNamed && !last)
      return text + fmt::format("{} and {} more", described(*tasks[i]), tasks.size() - kNamed);
    text += described(*tasks[i]);
  }
  return text;
}

/// Tasks that wait for whole scans of a slower one.
struct Waiting {
  const Task* slow = nullptr;
  std::vector<const Task*> fast;
};

/// "Fast 0, Middle 1, Slow 2": the shorter the interval, the more urgent.
std::string rate_monotonic(const std::vector<const Task*>& by_interval) {
  std::string text;
  std::size_t priority = 0;
  for (std::size_t i = 0; i < by_interval.size(); ++i) {
    if (i == kNamed && by_interval.size() > kNamed + 1) return text + ", ..";
    if (i > 0 && by_interval[i]->period_ns != by_interval[i - 1]->period_ns) ++priority;
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", by_interval[i]->name, priority);
  }
  return text;
}

/// A program that its task runs and that another POU calls by its name.
void look_at_programs(const Module& module, Findings& findings) {
  for (const Task& task : module.tasks) {
    for (const ProgramInstance& program : task.programs) {
      if (program.global == Pou::kDeclared) continue;
      for (const Pou& pou : module.pous) {
        if (!findings.is_linted(pou)) continue;
        const auto call = std::find_if(pou.body.insts.begin(), pou.body.insts.end(), [&](const Inst& inst) {
          if (inst.op != Op::kRun || inst.b != 0) return false;
          const Place& place = pou.body.places[inst.a];
          return place.kind == Place::Kind::kGlobal && place.index == program.global;
        });
        if (call == pou.body.insts.end()) continue;
        findings.add(Lint::kProgramTwice, pou.body.sources[call->source], pou.name,
                     fmt::format("task {} runs program {}, and this calls it once more", task.name,
                                 module.pous[program.pou].name),
                     "its timers and counters see both calls: take it out of the task, or do not call it");
      }
    }
  }
}

}  // namespace

void lint_tasks(const Module& module, Findings& findings) {
  look_at_programs(module, findings);
  std::vector<const Task*> tasks;  // by interval
  for (const Task& task : module.tasks) {
    if (task.single.empty() && task.period_ns > 0) tasks.push_back(&task);
  }
  std::stable_sort(tasks.begin(), tasks.end(),
                   [](const Task* a, const Task* b) { return a->period_ns < b->period_ns; });

  // Each task that waits, with the slowest one that it waits for; tasks that wait for the same one are together.
  std::vector<Waiting> all;
  for (const Task* fast : tasks) {
    const auto slow = std::find_if(tasks.rbegin(), tasks.rend(), [&](const Task* task) {
      return task->period_ns > fast->period_ns && task->priority <= fast->priority;
    });
    if (slow == tasks.rend()) continue;
    auto known = std::find_if(all.begin(), all.end(), [&](const Waiting& w) { return w.slow == *slow; });
    if (known == all.end()) known = all.insert(all.end(), {*slow, {}});
    known->fast.push_back(fast);
  }
  if (all.empty()) return;

  std::string message;
  for (const Waiting& one : all) {
    message += fmt::format("{}{} can wait for whole scans of {}", message.empty() ? "task " : "; ", listed(one.fast),
                           described(*one.slow));
  }
  findings.add(Lint::kRateMonotonic, all.front().slow->at, "", std::move(message),
               fmt::format("rate-monotonic priorities are {}; or set priorities = \"rate-monotonic\" in [scheduler] of "
                           "plc.toml",
                           rate_monotonic(tasks)));
}

}  // namespace plc::ir
