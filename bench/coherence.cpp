// What exchanging globals costs the fast task under each protocol, while a slower task exchanges the same variables as
// often as it can: on the other processor, and on the fast task's own.
#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bench/chart.h"
#include "bench/exchange_rig.h"
#include "bench/measurements.h"
#include "core/clock.h"
#include "runtime/sched/priority.h"
#include "runtime/sched/task_plan.h"
#include "runtime/sched/thread_settings.h"

namespace plc::bench {
namespace {

using core::Coherence;
using core::TimeNs;

constexpr std::array kProtocols = {Coherence::kWaitFree, Coherence::kPriorityCeiling, Coherence::kGlobalLock};
constexpr std::uint32_t kFast = 0;
constexpr TimeNs kPeriodNs = 100'000;    ///< of the fast task
constexpr TimeNs kSlowPauseNs = 20'000;  ///< between two exchanges of a slow task: more would starve the system

void sleep_until(TimeNs at) { core::MonotonicClock().sleep_until_ns(at); }

/// Binds the calling thread and makes it a real-time one; throws where the system grants none.
void become_task(int cpu, std::int32_t priority) {
  if (runtime::bind_to_cpu(pthread_self(), cpu) != 0 ||
      runtime::set_fifo(pthread_self(), runtime::fifo_priority(priority)) != 0) {
    throw std::runtime_error("the coherence benchmark needs two processors and SCHED_FIFO: run it as root");
  }
}

/// A thread that does one thing again and again until it is destroyed, with pauses, as a task of `priority`.
class SlowThread {
 public:
  template <class Step>
  SlowThread(int cpu, std::int32_t priority, Step step)
      : thread_([this, cpu, priority, step] {
          become_task(cpu, priority);
          while (!stop_) {
            step();
            sleep_until(now() + kSlowPauseNs);
          }
        }) {}
  ~SlowThread() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct Times {
  std::vector<TimeNs> exchange;  ///< both halves of one cycle
  std::vector<TimeNs> delay;     ///< from the release to the start of the cycle
  std::vector<TimeNs> sections;  ///< lengths of the slow task's critical sections
  std::vector<TimeNs> held_off;  ///< times for which one kept the fast task from going on
  std::uint64_t mixed = 0;
  std::uint64_t rounds = 0;  ///< of everybody

  void add(const Times& other) {
    exchange.insert(exchange.end(), other.exchange.begin(), other.exchange.end());
    delay.insert(delay.end(), other.delay.begin(), other.delay.end());
    sections.insert(sections.end(), other.sections.begin(), other.sections.end());
    held_off.insert(held_off.end(), other.held_off.begin(), other.held_off.end());
    mixed += other.mixed;
    rounds += other.rounds;
  }
};

TimeNs at_share(std::vector<TimeNs>& values, double share) {
  if (values.empty()) return 0;
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index), values.end());
  return values[index];
}

/// Does nothing ahead.
struct NothingAhead {
  void operator()(std::uint32_t) const {}
};

/// Runs `cycle(release)` on a thread of its own as the fast task would run. With `spin` it waits for its releases
/// awake: what a processor forgets while it sleeps, and the machine below it gives to others, is no matter of the
/// exchange. `ahead(cycle)` comes kLeadNs before each release.
template <class Cycle, class Ahead = NothingAhead>
void run_fast(int cpu, bool spin, std::uint32_t cycles, Cycle cycle, Ahead ahead = {}) {
  std::string problem;
  std::thread([&] {
    try {
      become_task(cpu, kFast);
    } catch (const std::exception& error) {
      problem = error.what();
      return;
    }
    TimeNs release = now() + 1'000'000;
    for (std::uint32_t i = 0; i < cycles; ++i) {
      if (!spin) sleep_until(release);
      while (now() < release - kLeadNs) {
      }
      ahead(i);
      while (now() < release) {
      }
      cycle(release, i);
      release = std::max(release + kPeriodNs, now() + kPeriodNs / 10);
    }
  }).join();
  if (!problem.empty()) throw std::runtime_error(problem);
  // The kernel takes real-time threads off a processor that they keep busy for 95 % of a second.
  if (spin) sleep_until(now() + kPeriodNs * cycles / 4);
}

/// Cycles before the first one that counts: caches, pages, branch predictors.
constexpr std::uint32_t kWarmUp = 50;

/// How long each instant at which the fast task wanted to go on lay before the end of a section that had begun.
void match(const std::vector<Section>& sections, const std::vector<TimeNs>& wanted, std::vector<TimeNs>& held_off) {
  auto section = sections.begin();
  for (const TimeNs at : wanted) {
    while (section != sections.end() && section->end <= at) ++section;
    if (section == sections.end()) return;
    if (section->begin < at) held_off.push_back(section->end - at);
  }
}

/// One cycle of the fast task; nanoseconds that both halves of its exchange took. `delays` gets when each began.
TimeNs fast_exchange(ExchangeRig& rig, std::uint32_t cycle, Times& times, std::vector<TimeNs>* wanted = nullptr) {
  const TimeNs t0 = now();
  rig.task(kFast).take();
  const TimeNs t1 = now();
  times.mixed += SlowTask::is_mixed(rig, kFast, 'a') ? 1 : 0;
  ++times.rounds;
  std::fill_n(rig.values(kFast, 'b'), rig.count('b'), static_cast<std::int32_t>(cycle));
  const TimeNs t2 = now();
  rig.task(kFast).give();
  const TimeNs t3 = now();
  rig.task(kFast).finish();
  if (wanted != nullptr) wanted->insert(wanted->end(), {t0, t2});
  return t1 - t0 + t3 - t2;
}

constexpr int kFastCpu = 1;

/// The slow task, or two of them, on the fast one's processor.
void measure(ExchangeRig& rig, bool third, std::uint32_t cycles, Times& times) {
  std::vector<Section> sections;
  sections.reserve(std::size_t{cycles} * 8);
  rig.task(1).note_sections(sections);
  // Under the lock the fast task runs, and waits where it takes it; under ceilings it does not run.
  std::vector<TimeNs> wanted;
  wanted.reserve(std::size_t{cycles} * 2);
  const bool by_lock = rig.protocol() == Coherence::kGlobalLock;
  SlowTask slow(rig, 1, third ? "bd" : "b", third ? "ac" : "a");
  SlowTask slowest(rig, 2, "c", "d");
  {
    const SlowThread thread(kFastCpu, 1, [&slow] { slow.exchange(); });
    std::optional<SlowThread> other;
    if (third) other.emplace(kFastCpu, 2, [&slowest] { slowest.exchange(); });
    run_fast(kFastCpu, false, cycles + kWarmUp, [&](TimeNs release, std::uint32_t cycle) {
      const TimeNs begin = now();
      const TimeNs took = fast_exchange(rig, cycle, times, by_lock ? &wanted : nullptr);
      if (cycle < kWarmUp) return;
      times.exchange.push_back(took);
      times.delay.push_back(begin - release);
      if (!by_lock) wanted.push_back(release);
    });
  }
  times.mixed += slow.mixed() + slowest.mixed();
  times.rounds += slow.rounds() + slowest.rounds();
  if (rig.protocol() == Coherence::kWaitFree) return;
  match(sections, wanted, times.held_off);
  for (const Section& section : sections) times.sections.push_back(section.end - section.begin);
}

/// What is compared when the slow task runs on the other processor.
enum Compared : std::size_t {
  kMemcpy,
  kMemcpyLead,
  kUnprotected,
  kWaitFree,
  kWaitFreeLead,
  kGlobalLock,
  kComparedCount
};
constexpr std::array<std::string_view, kComparedCount> kComparedNames = {"memcpy",    "memcpy, lead",    "unprotected",
                                                                         "wait-free", "wait-free, lead", "global-lock"};

/// The slow task on the other processor. All that is compared takes turns, cycle by cycle: what the machine does to one
/// of them it does to all.
void measure_apart(std::uint32_t n, std::uint32_t cycles, std::array<Times, kComparedCount>& times) {
  Mailbox cold(n), warm(n);
  // Under priority ceilings without priorities: LOCK and UNLOCK would be no calls either.
  ExchangeRig unprotected(Coherence::kPriorityCeiling, n, 0, false);
  ExchangeRig wait_free(Coherence::kWaitFree, n, 0);
  ExchangeRig wait_free_lead(Coherence::kWaitFree, n, 0);
  ExchangeRig lock(Coherence::kGlobalLock, n, 0);
  const std::array<ExchangeRig*, kComparedCount> rigs = {nullptr,    nullptr,         &unprotected,
                                                         &wait_free, &wait_free_lead, &lock};
  std::vector<Section> sections;
  sections.reserve(std::size_t{cycles} * kComparedCount * 20);
  lock.task(1).note_sections(sections);
  std::vector<TimeNs> wanted;
  wanted.reserve(std::size_t{cycles} * 2);
  std::array<SlowTask, kComparedCount - kUnprotected> slow = {
      {{unprotected, 1, "b", "a"}, {wait_free, 1, "b", "a"}, {wait_free_lead, 1, "b", "a"}, {lock, 1, "b", "a"}}};
  const auto ahead = [&](std::uint32_t cycle) {
    if (cycle % kComparedCount == kMemcpyLead) warm.expect();
    if (cycle % kComparedCount == kWaitFreeLead) wait_free_lead.task(kFast).expect();
  };
  const auto run = [&](TimeNs, std::uint32_t cycle) {
    const std::size_t which = cycle % kComparedCount;
    const TimeNs took = which == kMemcpy       ? cold.copy()
                        : which == kMemcpyLead ? warm.copy()
                                               : fast_exchange(*rigs[which], cycle, times[which],
                                                               which == kGlobalLock ? &wanted : nullptr);
    if (cycle >= kWarmUp * kComparedCount) times[which].exchange.push_back(took);
  };
  {
    const SlowThread thread(1 - kFastCpu, 1, [&] {
      cold.exchange();
      warm.exchange();
      for (SlowTask& side : slow) side.exchange();
    });
    run_fast(kFastCpu, true, (cycles + kWarmUp) * kComparedCount, run, ahead);
  }
  for (std::size_t i = kUnprotected; i < kComparedCount; ++i) {
    times[i].mixed += slow[i - kUnprotected].mixed();
    times[i].rounds += slow[i - kUnprotected].rounds();
  }
  times[kUnprotected].mixed = 0;  // nothing keeps it from being
  match(sections, wanted, times[kGlobalLock].held_off);
  for (const Section& section : sections) times[kGlobalLock].sections.push_back(section.end - section.begin);
}

/// Median cost of raising the own priority and taking it back.
TimeNs priority_change() {
  std::vector<TimeNs> times;
  run_fast(1, false, 1, [&](TimeNs, std::uint32_t) {
    for (int i = 0; i < 2000; ++i) {
      const TimeNs begin = now();
      runtime::set_own_priority(-1 + i % 2);
      runtime::set_own_priority(1);
      times.push_back((now() - begin) / 2);
    }
  });
  return at_share(times, 0.5);
}

std::string text(TimeNs ns) {
  return ns < 10'000 ? fmt::format("{} ns", ns) : fmt::format("{:.1f} us", static_cast<double>(ns) / 1000);
}

void header(std::string_view title) {
  std::cout << fmt::format(
      "\n{}\n{:>9}  {:<17} {:>10} {:>10} {:>10}   {:>10} {:>10} {:>10}   {:>10} {:>10} {:>9} {:>10}\n", title,
      "variables", "protocol", "p50", "p99.9", "worst", "delay p50", "p99.9", "worst", "section p50", "p99.9",
      "held off", "p99.9");
}

void row(std::uint32_t variables, std::string_view name, Times& t) {
  std::cout << fmt::format("{:>9}  {:<17} {:>10} {:>10} {:>10}", variables, name, text(at_share(t.exchange, 0.5)),
                           text(at_share(t.exchange, 0.999)), text(at_share(t.exchange, 1)));
  if (!t.delay.empty()) {
    std::cout << fmt::format("   {:>10} {:>10} {:>10}", text(at_share(t.delay, 0.5)), text(at_share(t.delay, 0.999)),
                             text(at_share(t.delay, 1)));
  }
  if (!t.sections.empty()) {
    std::cout << fmt::format("   {:>10} {:>10} {:>9} {:>10}", text(at_share(t.sections, 0.5)),
                             text(at_share(t.sections, 0.999)), t.held_off.size(),
                             t.held_off.empty() ? "" : text(at_share(t.held_off, 0.999)));
  }
  std::cout << std::endl;
}

}  // namespace

Verdict measure_coherence(const CoherencePlan& plan) {
  Verdict verdict;
  std::uint64_t rounds = 0, mixed = 0;
  const auto count = [&](const Times& t) {
    rounds += t.rounds;
    mixed += t.mixed;
  };
  std::cout << fmt::format(
      "Coherence: exchange of N DINTs in, N out, by a task of {} us and priority 80, {} cycles each, in {} interleaved "
      "parts. The slow task exchanges the same ones again and again. Lead: {} us before its release, as a task of 1 ms "
      "does it, the fast task has done ahead what can be done twice; memcpy has copied what comes in. Delay: from the "
      "release to the start of the "
      "cycle. Section: the slow task's critical sections; held off: how often one had begun when the fast task wanted "
      "to go on, and the time to its end.\n",
      kPeriodNs / 1000, plan.cycles, plan.parts, kLeadNs / 1000);
  const TimeNs change = priority_change();
  std::cout << fmt::format("one change of priority: {} (median)\n", text(change));

  std::vector<Chart> charts = {
      {"Slow task on the other processor", "variables in each direction", "exchange, p99.9, ns", {}},
      {"Slow task on the same processor", "variables in each direction", "exchange, p99.9, ns", {}},
      {"Slow tasks exchange N among each other, the fast one 10 with them", "variables", "exchange, p99.9, ns", {}}};
  const auto add_point = [&charts](std::size_t chart, std::string_view name, std::uint32_t n, Times& t) {
    // Colours that everybody can tell apart (Okabe, Ito 2002); dashed is what is no protocol.
    struct Look {
      std::string_view name;
      const char* colour;
      bool dashed;
    };
    constexpr std::array<Look, 7> kLooks = {{{"memcpy", "#000000", true},
                                             {"memcpy, lead", "#cc79a7", true},
                                             {"unprotected", "#9ca3af", true},
                                             {"wait-free", "#56b4e9", false},
                                             {"wait-free, lead", "#0072b2", false},
                                             {"priority-ceiling", "#009e73", false},
                                             {"global-lock", "#d55e00", false}}};
    auto& lines = charts[chart].lines;
    auto line = std::find_if(lines.begin(), lines.end(), [&](const ChartLine& l) { return l.name == name; });
    if (line == lines.end()) {
      const auto* look = std::find_if(kLooks.begin(), kLooks.end(), [&](const Look& l) { return l.name == name; });
      line = lines.insert(line, {std::string(name), look->colour, look->dashed, {}});
    }
    line->points.emplace_back(n, static_cast<double>(std::max<TimeNs>(at_share(t.exchange, 0.999), 1)));
  };
  header("slow task on the other processor");
  for (const std::uint32_t n : plan.sizes) {
    std::array<Times, kComparedCount> times;
    // A hiccup of the machine decides one part's p99.9: the median of the parts' ratios counts.
    struct Ratio {
      std::string_view text;
      std::size_t of, over;
      std::vector<double> parts = {};
    };
    std::array<Ratio, 4> ratios = {{{"wait-free, lead, over memcpy", kWaitFreeLead, kMemcpy},
                                    {"wait-free, lead, over memcpy, lead", kWaitFreeLead, kMemcpyLead},
                                    {"wait-free over memcpy", kWaitFree, kMemcpy},
                                    {"wait-free over unprotected", kWaitFree, kUnprotected}}};
    for (std::uint32_t part = 0; part < plan.parts; ++part) {
      std::array<Times, kComparedCount> own;
      measure_apart(n, plan.cycles / plan.parts, own);
      const auto tail = [&own](std::size_t i) {
        return static_cast<double>(std::max<TimeNs>(at_share(own[i].exchange, 0.999), 1));
      };
      for (Ratio& ratio : ratios) ratio.parts.push_back(tail(ratio.of) / tail(ratio.over));
      for (std::size_t i = 0; i < kComparedCount; ++i) times[i].add(own[i]);
    }
    for (std::size_t i = 0; i < kComparedCount; ++i) {
      row(n, kComparedNames[i], times[i]);
      add_point(0, kComparedNames[i], n, times[i]);
      count(times[i]);
    }
    for (Ratio& ratio : ratios) {
      const double whole = static_cast<double>(at_share(times[ratio.of].exchange, 0.999)) /
                           static_cast<double>(std::max<TimeNs>(at_share(times[ratio.over].exchange, 0.999), 1));
      std::cout << fmt::format("{:>9}  {} at p99.9: {:.2f} times (median of the parts {:.2f})", "", ratio.text, whole,
                               median(ratio.parts));
      // What a task has when nobody says otherwise, against a copy of bytes that the other processor has just written.
      if (plan.limits && &ratio == ratios.data()) std::cout << ", " << limit_text(whole, limit::kExchange, verdict);
      std::cout << std::endl;
    }
  }

  const auto same_cpu = [&](std::size_t chart, std::uint32_t common, std::uint32_t others, std::uint32_t shown) {
    std::array<Times, 3> times;
    std::array<std::unique_ptr<ExchangeRig>, 3> rigs;
    for (std::size_t p = 0; p < 3; ++p) rigs[p] = std::make_unique<ExchangeRig>(kProtocols[p], common, others);
    for (std::uint32_t part = 0; part < plan.parts; ++part) {
      for (std::size_t p = 0; p < 3; ++p) measure(*rigs[p], others != 0, plan.cycles / plan.parts, times[p]);
    }
    for (std::size_t p = 0; p < 3; ++p) {
      row(shown, core::coherence_name(kProtocols[p]), times[p]);
      add_point(chart, core::coherence_name(kProtocols[p]), shown, times[p]);
      count(times[p]);
    }
  };
  header("slow task on the same processor");
  for (const std::uint32_t n : plan.sizes) same_cpu(1, n, 0, n);
  header("slow tasks on the same processor exchange N among each other, and 10 with the fast task (paper, 3.2.3)");
  for (const std::uint32_t n : plan.sizes) same_cpu(2, 10, n, n);

  std::cout << fmt::format("\n{} exchanges, {} mixed snapshots; no protocol has a retry\n", rounds, mixed);
  if (!plan.plot.empty()) {
    std::ofstream(plan.plot) << draw(charts);
    std::cout << fmt::format("plot: {}\n", plan.plot);
  }
  verdict.correct = mixed == 0;
  return verdict;
}

}  // namespace plc::bench
