// What exchanging globals costs the fast task under each protocol, while a slower task exchanges the same variables as
// often as it can: on the other processor, and on the fast task's own.
#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bench/chart.h"
#include "bench/measurements.h"
#include "bench/scratch.h"
#include "core/clock.h"
#include "runtime/link.h"
#include "runtime/memory/common_table_exchange.h"
#include "runtime/memory/exchange.h"
#include "runtime/sched/priority.h"
#include "runtime/sched/task_plan.h"
#include "runtime/sched/thread_settings.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

using core::Coherence;
using core::TimeNs;

constexpr std::array kProtocols = {Coherence::kWaitFree, Coherence::kPriorityCeiling, Coherence::kGlobalLock};
constexpr std::uint32_t kFast = 0;
constexpr TimeNs kPeriodNs = 100'000;    ///< of the fast task
constexpr TimeNs kLeadNs = 10'000;       ///< a tenth of the period
constexpr TimeNs kSlowPauseNs = 20'000;  ///< between two exchanges of a slow task: more would starve the system

TimeNs now() { return core::MonotonicClock().now_ns(); }
void sleep_until(TimeNs at) { core::MonotonicClock().sleep_until_ns(at); }

/// Binds the calling thread and makes it a real-time one; throws where the system grants none.
void become_task(int cpu, std::int32_t priority) {
  if (runtime::bind_to_cpu(pthread_self(), cpu) != 0 ||
      runtime::set_fifo(pthread_self(), runtime::fifo_priority(priority)) != 0) {
    throw std::runtime_error("the coherence benchmark needs two processors and SCHED_FIFO: run it as root");
  }
}

/// Fast and Slow exchange `common` DINTs in both directions; Slow and Slowest exchange `others` that Fast does not use.
std::string source(std::uint32_t common, std::uint32_t others) {
  std::string text = "VAR_GLOBAL\n";
  const auto list = [&text](char letter, std::uint32_t count, std::string_view format) {
    for (std::uint32_t i = 0; i < count; ++i) text += fmt::format(fmt::runtime(format), letter, i);
  };
  for (const char letter : {'a', 'b'}) list(letter, common, "  {}{} : DINT;\n");
  for (const char letter : {'c', 'd'}) list(letter, others, "  {}{} : DINT;\n");
  text += "END_VAR\n";
  const auto program = [&](std::string_view name, std::string_view pairs, std::uint32_t first_count,
                           std::uint32_t second_count) {
    text += fmt::format("PROGRAM {}\nVAR_EXTERNAL\n", name);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      list(pairs[i], i < 2 ? first_count : second_count, "  {}{} : DINT;\n");
    text += "END_VAR\n";
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
      const std::uint32_t count = i < 2 ? first_count : second_count;
      for (std::uint32_t v = 0; v < count; ++v) text += fmt::format("  {0}{2} := {1}{2};\n", pairs[i], pairs[i + 1], v);
    }
    text += "END_PROGRAM\n";
  };
  program("Fast", "ba", common, 0);
  program("Slow", "abcd", common, others);
  program("Slowest", "dc", others, 0);
  text += "CONFIGURATION C\n  RESOURCE R ON PLC\n";
  text += "    TASK TFast(INTERVAL := T#1ms, PRIORITY := 0);\n    TASK TSlow(INTERVAL := T#10ms, PRIORITY := 1);\n";
  text += "    TASK TSlowest(INTERVAL := T#20ms, PRIORITY := 2);\n    PROGRAM fast WITH TFast : Fast;\n";
  text += "    PROGRAM slow WITH TSlow : Slow;\n    PROGRAM slowest WITH TSlowest : Slowest;\n";
  return text + "  END_RESOURCE\nEND_CONFIGURATION\n";
}

/// The copies of a common table without anything that keeps others off: what the protocols add is what they cost.
class UnprotectedExchange final : public runtime::CommonTableExchange {
 public:
  using CommonTableExchange::CommonTableExchange;
  void import(std::uint32_t range) noexcept override { copy_in(range); }
  void export_range(std::uint32_t range) noexcept override {
    if (may_publish()) copy_out(range);
  }
};

/// Part of an exchange in which the fast task is held off.
struct Section {
  TimeNs begin = 0;
  TimeNs end = 0;
};

/// One task without code: its exchange as its body has it, and its local copy.
class alignas(runtime::kTableAlign) Side {
 public:
  Side(runtime::GlobalTable& globals, std::uint32_t task, bool protected_copies)
      : protocol_(globals.image().options.coherence), local_(globals.size()) {
    if (protected_copies) {
      exchange_ = runtime::make_exchange(protocol_, globals, task, local_.data());
    } else {
      exchange_ = std::make_unique<UnprotectedExchange>(globals, task, local_.data());
    }
    const bytecode::Image& image = globals.image();
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[task].body)) {
      using Use = runtime::Exchange::Use;
      bool urgent = false;
      for (std::uint32_t f = range.first; f < range.first + range.count; ++f)
        urgent = urgent || globals.ceiling(f) == 0;
      (range.exported ? exports_ : imports_)
          .push_back({exchange_->add_range(range.first, range.count, Use::kRaise),
                      exchange_->add_range(range.first, range.count, range.exported ? Use::kExport : Use::kImport),
                      urgent});
    }
    exchange_->prepare();
    exchange_->set_priority_change(runtime::set_own_priority);
  }
  /// What a task does ahead of its release: as many bytes as the lead has nanoseconds (runtime/sched/realtime.cpp).
  void expect() { exchange_->expect(std::size_t{kLeadNs}); }
  void take() {
    exchange_->begin();
    critical(imports_, [this](std::uint32_t range) { exchange_->import(range); });
  }
  void give() {
    critical(exports_, [this](std::uint32_t range) { exchange_->export_range(range); });
    if (protocol_ == Coherence::kWaitFree) exchange_->end();
  }
  /// Under the protocols with a common table the snapshot for devices and servers is made here, which is not theirs.
  void finish() {
    if (protocol_ != Coherence::kWaitFree) exchange_->end();
  }
  /// Notes from now on when it holds the fast task off.
  void note_sections(std::vector<Section>& sections) { sections_ = &sections; }
  [[nodiscard]] std::int32_t* values(std::uint32_t offset) {
    return reinterpret_cast<std::int32_t*>(local_.data() + offset);
  }

 private:
  struct Part {
    std::uint32_t raise;
    std::uint32_t copy;
    bool urgent;  ///< the fast task uses it
  };
  template <class Copy>
  void critical(const std::vector<Part>& parts, Copy copy) {
    TimeNs begin = 0;
    if (protocol_ == Coherence::kGlobalLock) {
      exchange_->lock();
      if (sections_ != nullptr) begin = now();
    }
    for (const Part& part : parts) {
      if (sections_ != nullptr && part.urgent && begin == 0) begin = now();
      if (protocol_ == Coherence::kPriorityCeiling) exchange_->raise(part.raise);
      copy(part.copy);
    }
    // Before the fast task can run again.
    if (begin != 0) sections_->push_back({begin, now()});
    if (protocol_ == Coherence::kGlobalLock) exchange_->unlock();
    if (protocol_ == Coherence::kPriorityCeiling) exchange_->reschedule();
  }

  Coherence protocol_;
  runtime::TableMemory local_;
  std::unique_ptr<runtime::Exchange> exchange_;
  std::vector<Part> imports_, exports_;
  std::vector<Section>* sections_ = nullptr;
};

/// One protocol with its tasks.
class alignas(runtime::kTableAlign) Rig {
 public:
  Rig(Coherence protocol, std::uint32_t common, std::uint32_t others, bool protected_copies = true)
      : protocol_(protocol), common_(common), others_(others) {
    const Scratch scratch;
    std::ofstream(scratch.file("exchange.st")) << source(common, others);
    tools::Compilation compilation;
    core::CompileOptions options;
    options.coherence = protocol;
    tools::compile({scratch.file("exchange.st"), options, tools::Goal::kRun}, compilation);
    if (!compilation.image) throw std::runtime_error("the project of the coherence benchmark does not compile");
    image_ = std::move(*compilation.image);
    const bytecode::Image& image = image_->image();
    globals_ = std::make_unique<runtime::GlobalTable>(image);
    for (std::uint32_t task = 0; task < 3; ++task)
      sides_[task] = std::make_unique<Side>(*globals_, task, protected_copies);
    for (const bytecode::ImageField& field : image.types[image.global_type].fields) {
      if (field.name.size() == 2 && field.name[1] == '0')
        at_[static_cast<std::size_t>(field.name[0] - 'a')] = field.offset;
    }
  }
  Side& side(std::uint32_t task) { return *sides_[task]; }
  /// Variables of a letter lie side by side: one task writes them, and the same ones read them.
  std::int32_t* values(std::uint32_t task, char letter) {
    return sides_[task]->values(at_[static_cast<std::size_t>(letter - 'a')]);
  }
  [[nodiscard]] std::uint32_t count(char letter) const { return letter < 'c' ? common_ : others_; }

  [[nodiscard]] Coherence protocol() const { return protocol_; }

 private:
  Coherence protocol_;
  std::uint32_t common_, others_;
  std::optional<bytecode::VerifiedImage> image_;
  std::unique_ptr<runtime::GlobalTable> globals_;
  std::array<std::unique_ptr<Side>, 3> sides_;
  std::array<std::uint32_t, 4> at_{};
};

/// One exchange of a slow task: takes, checks, fills what it exports with the number of its round, gives. What it took
/// is mixed when not all values of a letter are of one round of the other side.
class alignas(runtime::kTableAlign) SlowSide {
 public:
  SlowSide(Rig& rig, std::uint32_t task, std::string_view in, std::string_view out)
      : rig_(rig), task_(task), in_(in), out_(out) {}
  void exchange() {
    ++rounds_;
    Side& side = rig_.side(task_);
    side.take();
    for (const char letter : in_) mixed_ += is_mixed(rig_, task_, letter) ? 1 : 0;
    for (const char letter : out_)
      std::fill_n(rig_.values(task_, letter), rig_.count(letter), static_cast<std::int32_t>(rounds_));
    side.give();
    side.finish();
  }
  static bool is_mixed(Rig& rig, std::uint32_t task, char letter) {
    const std::int32_t* const v = rig.values(task, letter);
    return std::any_of(v, v + rig.count(letter), [&](std::int32_t one) { return one != v[0]; });
  }
  [[nodiscard]] std::uint64_t rounds() const { return rounds_; }
  [[nodiscard]] std::uint64_t mixed() const { return mixed_; }

 private:
  Rig& rig_;
  std::uint32_t task_;
  std::string_view in_, out_;
  std::uint64_t rounds_ = 0, mixed_ = 0;
};

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

/// Bytes that another processor has just written, and bytes that it reads, for memcpy.
class alignas(runtime::kTableAlign) Mailbox {
 public:
  explicit Mailbox(std::uint32_t count)
      : in_(kBuffers, std::vector<std::int32_t>(count)), out_(in_), local_(count), slow_(count) {}
  /// The copy of what comes in, once more and ahead.
  void expect() { copy_in(); }
  /// Nanoseconds that two memcpy take, with the words that say where the bytes are.
  TimeNs copy() {
    const TimeNs t0 = now();
    copy_in();
    const TimeNs t1 = now();
    std::fill(local_.begin(), local_.end(), static_cast<std::int32_t>(++round_));
    const TimeNs t2 = now();
    std::memcpy(out_[round_ % kBuffers].data(), local_.data(), local_.size() * sizeof(std::int32_t));
    taken_.store(round_, std::memory_order_release);
    const TimeNs t3 = now();
    return t1 - t0 + t3 - t2;
  }
  /// The other side.
  void exchange() {
    const std::vector<std::int32_t>& from = out_[taken_.load(std::memory_order_acquire) % kBuffers];
    std::memcpy(slow_.data(), from.data(), from.size() * sizeof(std::int32_t));
    std::fill(slow_.begin(), slow_.end(), static_cast<std::int32_t>(++slow_round_));
    std::memcpy(in_[slow_round_ % kBuffers].data(), slow_.data(), slow_.size() * sizeof(std::int32_t));
    written_.store(slow_round_, std::memory_order_release);
  }

 private:
  [[gnu::noinline]] void copy_in() {
    const std::vector<std::int32_t>& from = in_[written_.load(std::memory_order_acquire) % kBuffers];
    std::memcpy(local_.data(), from.data(), from.size() * sizeof(std::int32_t));
  }

  /// As many as a snapshot of one reader has: as long as nobody is held up, none is written while it is read.
  static constexpr std::uint64_t kBuffers = 3;
  std::vector<std::vector<std::int32_t>> in_, out_;
  std::vector<std::int32_t> local_, slow_;
  std::uint64_t round_ = 0, slow_round_ = 0;
  alignas(runtime::kTableAlign) std::atomic<std::uint64_t> written_{0};
  alignas(runtime::kTableAlign) std::atomic<std::uint64_t> taken_{0};
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
TimeNs fast_exchange(Rig& rig, std::uint32_t cycle, Times& times, std::vector<TimeNs>* wanted = nullptr) {
  const TimeNs t0 = now();
  rig.side(kFast).take();
  const TimeNs t1 = now();
  times.mixed += SlowSide::is_mixed(rig, kFast, 'a') ? 1 : 0;
  ++times.rounds;
  std::fill_n(rig.values(kFast, 'b'), rig.count('b'), static_cast<std::int32_t>(cycle));
  const TimeNs t2 = now();
  rig.side(kFast).give();
  const TimeNs t3 = now();
  rig.side(kFast).finish();
  if (wanted != nullptr) wanted->insert(wanted->end(), {t0, t2});
  return t1 - t0 + t3 - t2;
}

constexpr int kFastCpu = 1;

/// The slow task, or two of them, on the fast one's processor.
void measure(Rig& rig, bool third, std::uint32_t cycles, Times& times) {
  std::vector<Section> sections;
  sections.reserve(std::size_t{cycles} * 8);
  rig.side(1).note_sections(sections);
  // Under the lock the fast task runs, and waits where it takes it; under ceilings it does not run.
  std::vector<TimeNs> wanted;
  wanted.reserve(std::size_t{cycles} * 2);
  const bool by_lock = rig.protocol() == Coherence::kGlobalLock;
  SlowSide slow(rig, 1, third ? "bd" : "b", third ? "ac" : "a");
  SlowSide slowest(rig, 2, "c", "d");
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
  Rig unprotected(Coherence::kPriorityCeiling, n, 0, false);
  Rig wait_free(Coherence::kWaitFree, n, 0);
  Rig wait_free_lead(Coherence::kWaitFree, n, 0);
  Rig lock(Coherence::kGlobalLock, n, 0);
  const std::array<Rig*, kComparedCount> rigs = {nullptr, nullptr, &unprotected, &wait_free, &wait_free_lead, &lock};
  std::vector<Section> sections;
  sections.reserve(std::size_t{cycles} * kComparedCount * 20);
  lock.side(1).note_sections(sections);
  std::vector<TimeNs> wanted;
  wanted.reserve(std::size_t{cycles} * 2);
  std::array<SlowSide, kComparedCount - kUnprotected> slow = {
      {{unprotected, 1, "b", "a"}, {wait_free, 1, "b", "a"}, {wait_free_lead, 1, "b", "a"}, {lock, 1, "b", "a"}}};
  const auto ahead = [&](std::uint32_t cycle) {
    if (cycle % kComparedCount == kMemcpyLead) warm.expect();
    if (cycle % kComparedCount == kWaitFreeLead) wait_free_lead.side(kFast).expect();
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
      for (SlowSide& side : slow) side.exchange();
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
    std::array<std::unique_ptr<Rig>, 3> rigs;
    for (std::size_t p = 0; p < 3; ++p) rigs[p] = std::make_unique<Rig>(kProtocols[p], common, others);
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
