#include "tools/plc/measure.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>
#include <vector>

#include "runtime/sched/estimate.h"
#include "runtime/sched/thread_settings.h"
#include "stdlib/library.h"
#include "tools/open.h"
#include "tools/plc/probes.h"

namespace plc::tools {
namespace {

using core::TypeId;
using runtime::Cost;
using runtime::CostKind;
using runtime::CostTable;

double now_ns(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) * 1e9 + static_cast<double>(t.tv_nsec);
}

// ---- values of every type ---------------------------------------------------------------------------------------

constexpr std::uint16_t kCapacity = core::kDefaultStringCapacity;
/// Room for a value of any elementary type.
struct alignas(8) Place {
  std::byte bytes[sizeof(core::StringHeader) + 2 * kCapacity];
};

/// Texts that functions of texts have most to do with: full, nearly equal, numbers, times, dates.
constexpr std::string_view kTexts[] = {
    "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
    "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab",
    "-123.456789012345e-37",
    "-9223372036854775808",
    "T#-1234d23h59m59s999ms999us999ns",
    "DT#2024-02-29-23:59:59.999999999",
    "D#2024-02-29",
    "TOD#23:59:59.999999999",
    "16#FFFF_FFFF_FFFF_FFFF",
    ""};
constexpr double kReals[] = {0.0, 1.0, -1.5, 0.123456789, 3.0e4, -2.5e9, 1.0e300, 1.0e-300, 0.99999, 57.2957795};
constexpr std::int64_t kIntegers[] = {0,
                                      1,
                                      -1,
                                      5,
                                      59,
                                      2024,
                                      12'345'678,
                                      86'399'999'999'999,
                                      std::numeric_limits<std::int64_t>::max(),
                                      std::numeric_limits<std::int64_t>::min()};
constexpr std::size_t kValues = std::size(kTexts);
static_assert(std::size(kReals) == kValues && std::size(kIntegers) == kValues);

void clear(TypeId type, std::byte* place) {
  const core::Rep rep = core::rep_of(type);
  std::memset(place, 0, sizeof(Place));
  if (rep != core::Rep::kStr && rep != core::Rep::kWstr) return;
  const core::StringHeader header{kCapacity, 0};
  std::memcpy(place, &header, sizeof header);
}

/// Value `number` of the type, 0 .. kValues - 1.
void put(TypeId type, std::size_t number, std::byte* place) {
  const auto store = [place](auto value) { std::memcpy(place, &value, sizeof value); };
  clear(type, place);
  switch (core::rep_of(type)) {
    case core::Rep::kBool:
      return store(static_cast<std::uint8_t>(number % 2));
    case core::Rep::kF32:
      return store(static_cast<float>(std::fmod(kReals[number], 1e38)));
    case core::Rep::kF64:
      return store(kReals[number]);
    case core::Rep::kStr:
    case core::Rep::kWstr: {
      const bool wide = core::rep_of(type) == core::Rep::kWstr;
      const std::string_view text = kTexts[number].substr(0, kCapacity);
      const core::StringHeader header{kCapacity, static_cast<std::uint16_t>(text.size())};
      std::memcpy(place, &header, sizeof header);
      for (std::size_t i = 0; i < text.size(); ++i) {
        place[sizeof header + (wide ? 2 * i : i)] = static_cast<std::byte>(text[i]);
      }
      return;
    }
    default:
      std::memcpy(place, &kIntegers[number], core::rep_bytes(core::rep_of(type)));
      return;
  }
}

/// Sleep between two measured scans.
constexpr long kPauseNs = 100'000;

/// Copies of a block that step together, and steps of each.
constexpr std::size_t kTwins = 16;
constexpr std::size_t kSteps = 120;
/// Calls that are timed as one.
constexpr std::size_t kCalls = 32;
/// Times each is measured; the shortest counts, for what is longer is not the function's.
constexpr int kTries = 3;

}  // namespace

Meter::Meter(std::uint32_t repetitions) : repetitions_(std::max(repetitions, 1u)) {
  std::string pattern = (std::filesystem::temp_directory_path() / "plc-calibrate-XXXXXX").string();
  if (::mkdtemp(pattern.data()) != nullptr) folder_ = pattern;
  const long cache = ::sysconf(_SC_LEVEL2_CACHE_SIZE);
  others_.resize(2 * static_cast<std::size_t>(cache > 0 ? cache : 2L << 20));
  // Moving to another processor would be measured too.
  static_cast<void>(runtime::bind_to_cpu(::pthread_self(), std::max(::sched_getcpu(), 0)));
  std::vector<double> times;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const double begin = now_ns(CLOCK_MONOTONIC);
    times.push_back(now_ns(CLOCK_MONOTONIC) - begin);
  }
  clock_ns_ = *std::min_element(times.begin(), times.end());
}

Meter::~Meter() {
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

core::Result<std::unique_ptr<runtime::Resource>> Meter::load(std::string_view text) {
  if (folder_.empty()) return core::Problem{core::Code::P7001, "no temporary folder can be made", "set TMPDIR"};
  const std::string path = folder_ + "/probe.st";
  std::ofstream(path, std::ios::binary) << text;
  Compilation compilation;
  compile({path, {}, Goal::kRun}, compilation);
  if (!compilation.ok() || !compilation.image) {
    const auto& all = compilation.diagnostics.all();
    return core::Problem{
        core::Code::P9001,
        "a probe does not compile: " + (all.empty() ? std::string() : compilation.diagnostics.render_one(all.front())),
        "please report this"};
  }
  runtime::ProgramOptions options;
  options.arrange = false;  // what one instruction takes after any other
  return runtime::Resource::load(std::move(*compilation.image), options);
}

/// What happens to a task between two scans: others fill the caches, it sleeps, the kernel wakes it.
void Meter::forget() {
  for (std::size_t i = 0; i < others_.size(); i += 64) ++others_[i];
  const timespec pause{0, kPauseNs};
  ::clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
}

double Meter::percentile(std::vector<double>& times) const {
  const auto place = static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(times.size() - 1));
  std::nth_element(times.begin(), times.begin() + place, times.end());
  return std::max(times[static_cast<std::size_t>(place)] - clock_ns_, 0.0);
}

double Meter::timed(const std::function<void()>& work) const {
  const double begin = now_ns(CLOCK_MONOTONIC);
  work();
  return now_ns(CLOCK_MONOTONIC) - begin;
}

std::vector<Cost> Meter::scans(const std::vector<Subject>& subjects) {
  struct Times {
    std::vector<double> first, again;
  };
  std::vector<Times> times(subjects.size());
  const auto scan = [this](const Subject& subject, bool cold) {
    now_ns_ += 10'000'000;
    if (subject.partner) static_cast<void>(subject.resource->program(1).execute({now_ns_}));
    if (cold) forget();
    return timed([&] { static_cast<void>(subject.resource->program(0).execute({now_ns_})); });
  };
  for (std::uint32_t i = 0; i < repetitions_; ++i) {
    for (std::size_t s = 0; s < subjects.size(); ++s) {
      times[s].first.push_back(scan(subjects[s], true));
      times[s].again.push_back(scan(subjects[s], false));
    }
  }
  std::vector<Cost> costs;
  for (Times& one : times) costs.push_back({percentile(one.first), percentile(one.again)});
  return costs;
}

Cost Meter::release() {
  // On a thread of its own, whose time on the processor is that of its releases alone.
  double ns = 0;
  std::thread sleeper([&] {
    constexpr long kPeriodNs = 500'000;
    const std::uint32_t releases = 2 * repetitions_;
    timespec next{};
    ::clock_gettime(CLOCK_MONOTONIC, &next);
    const double begin = now_ns(CLOCK_THREAD_CPUTIME_ID);
    for (std::uint32_t i = 0; i < releases; ++i) {
      next.tv_nsec += kPeriodNs;
      if (next.tv_nsec >= 1'000'000'000) {
        next.tv_nsec -= 1'000'000'000;
        ++next.tv_sec;
      }
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
    }
    ns = (now_ns(CLOCK_THREAD_CPUTIME_ID) - begin) / releases;
  });
  sleeper.join();
  return {ns, ns};
}

Cost Meter::lock() {
  pthread_mutexattr_t attributes;
  pthread_mutex_t mutex;
  ::pthread_mutexattr_init(&attributes);
  ::pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  ::pthread_mutex_init(&mutex, &attributes);
  const auto measure = [&](bool cold) {
    std::vector<double> times;
    for (std::uint32_t i = 0; i < repetitions_; ++i) {
      if (cold) forget();
      times.push_back(timed([&] {
        ::pthread_mutex_lock(&mutex);
        ::pthread_mutex_unlock(&mutex);
      }));
    }
    return percentile(times) / 2;
  };
  const Cost cost{measure(true), measure(false)};
  ::pthread_mutex_destroy(&mutex);
  ::pthread_mutexattr_destroy(&attributes);
  return cost;
}

Cost Meter::priority() {
  // As a task does it where that is allowed; else the same call to the same effect as now.
  std::array<std::vector<double>, 2> times;
  std::thread changing([&] {
    const pthread_t self = ::pthread_self();
    const bool allowed = runtime::set_fifo(self, 1) == 0;
    for (const bool cold : {true, false}) {
      for (std::uint32_t i = 0; i < repetitions_; ++i) {
        if (cold) forget();
        times[cold ? 0 : 1].push_back(timed([&] {
          static_cast<void>(allowed ? runtime::set_fifo(self, 1 + static_cast<int>(i % 2))
                                    : runtime::set_ordinary(self));
        }));
      }
    }
  });
  changing.join();
  return {percentile(times[0]), percentile(times[1])};
}

void Meter::Range::join(double ns) {
  least = std::min(least, ns);
  most = std::max(most, ns);
}

Meter::Range Meter::function(const stdlib::Overload& overload) {
  const std::size_t count = std::max<std::size_t>(overload.spec->param_count, 1);
  std::vector<Place> places(count);
  Place result;
  std::vector<const void*> arguments;
  for (const Place& place : places) arguments.push_back(place.bytes);
  Range range;
  for (std::size_t shift = 0; shift < 2; ++shift) {
    for (std::size_t number = 0; number < kValues; ++number) {
      for (std::size_t i = 0; i < overload.spec->param_count; ++i) {
        put(overload.param_type(i), (number + shift * i) % kValues, places[i].bytes);
      }
      clear(overload.result_type(), result.bytes);
      double shortest = std::numeric_limits<double>::max();
      for (int attempt = 0; attempt < kTries; ++attempt) {
        shortest =
            std::min(shortest, timed([&] {
                       for (std::size_t call = 0; call < kCalls; ++call) {
                         static_cast<void>(overload.kernel(result.bytes, arguments.data(), overload.spec->param_count));
                       }
                     }));
      }
      range.join(std::max(shortest - clock_ns_, 0.0) / kCalls);
    }
  }
  return range;
}

Meter::Range Meter::block(const stdlib::BlockSpec& block) {
  // Twins in the same state, so that one step takes long enough to be timed.
  const std::size_t stride = (block.size + 63) / 64 * 64;
  std::vector<std::byte> memory((kTwins + 1) * stride + 64);
  std::byte* const first = memory.data() + (64 - reinterpret_cast<std::uintptr_t>(memory.data()) % 64);
  std::vector<std::byte> before(block.size);
  std::memcpy(before.data(), block.initial, block.size);
  core::TimeNs now = 0;
  Range range;
  for (std::size_t step = 0; step < kSteps; ++step) {
    // Inputs change at different times, so that states of every combination come up.
    std::size_t every = 1;
    for (const stdlib::Field& field : block.fields) {
      if (field.direction == stdlib::Direction::kState || field.direction == stdlib::Direction::kOutput) continue;
      const core::Rep rep = core::rep_of(field.type);
      if (rep == core::Rep::kStr || rep == core::Rep::kWstr) continue;  // as they are declared
      Place value;
      put(field.type, step / every % kValues, value.bytes);
      std::memcpy(before.data() + field.offset, value.bytes, core::rep_bytes(rep));
      every = every % 7 + 1;
    }
    now += step % 5 == 4 ? 60'000'000'000 : 10'000'000;
    double shortest = std::numeric_limits<double>::max();
    for (int attempt = 0; attempt < kTries; ++attempt) {
      for (std::size_t twin = 0; twin < kTwins; ++twin) std::memcpy(first + twin * stride, before.data(), block.size);
      shortest = std::min(shortest, timed([&] {
                            for (std::size_t twin = 0; twin < kTwins; ++twin) block.step(first + twin * stride, {now});
                          }));
    }
    std::memcpy(before.data(), first, block.size);
    range.join(std::max(shortest - clock_ns_, 0.0) / kTwins);
  }
  return range;
}

namespace {

/// The slowest of each function and block; `quickest`: the same for the values that probes declare.
void measure_library(Meter& meter, CostTable& costs, CostTable& quickest) {
  const auto keep = [](auto& table, const std::string& name, double ns) {
    const auto [known, fresh] = table.emplace(name, ns);
    if (!fresh) known->second = std::min(known->second, ns);
  };
  for (int pass = 0; pass < kTries; ++pass) {
    for (const stdlib::Overload& overload : stdlib::overloads()) {
      const Meter::Range range = meter.function(overload);
      keep(costs.functions, stdlib::key_of(overload), range.most);
      keep(quickest.functions, stdlib::key_of(overload), range.least);
    }
    for (const stdlib::BlockSpec& block : stdlib::blocks()) {
      const Meter::Range range = meter.block(block);
      keep(costs.blocks, std::string(block.name), range.most);
      keep(quickest.blocks, std::string(block.name), range.least);
    }
  }
}

}  // namespace

core::Result<CostTable> calibrate(Meter& meter, const std::function<void(std::string_view)>& tell) {
  CostTable costs, quickest;
  costs.machine = machine_text();
  tell("functions and function blocks of the library");
  measure_library(meter, costs, quickest);
  tell("what the system takes");
  const Cost release = meter.release();
  const Cost lock = meter.lock();
  const Cost priority = meter.priority();
  tell("instructions");
  const std::vector<Probe> all = probes();
  std::vector<std::unique_ptr<runtime::Resource>> resources;
  std::vector<Meter::Subject> subjects;
  for (const Probe& probe : all) {
    auto resource = meter.load(probe.text);
    if (!resource) return resource.error();
    subjects.push_back({resource->get(), probe.partner});
    resources.push_back(std::move(*resource));
  }
  const std::vector<Cost> measured = meter.scans(subjects);
  for (std::size_t p = 0; p < all.size(); ++p) {
    // What is known of the program, and how often it has the one thing that is not.
    quickest.kinds = costs.kinds;
    const Cost known = runtime::estimate_task(resources[p]->image(), 0, quickest).scan;
    CostTable unit;
    unit[all[p].kind] = {1, 1};
    const double count = runtime::estimate_task(resources[p]->image(), 0, unit).scan.first;
    if (count <= 0) {
      return core::Problem{core::Code::P9001,
                           fmt::format("the probe of \"{}\" has none in it", runtime::info(all[p].kind).key),
                           "please report this"};
    }
    const double again = std::max(measured[p].again - known.again, 0.0) / count;
    costs[all[p].kind] = {std::max(std::max(measured[p].first - known.first, 0.0) / count, again), again};
  }
  costs[CostKind::kRelease] = release;
  costs[CostKind::kLock] = lock;
  costs[CostKind::kPriority] = priority;
  return costs;
}

std::string machine_text() {
  std::ifstream in("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      name = line.substr(colon + 2);
      break;
    }
  }
  std::erase_if(name,
                [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\' || c == 0x7f; });
  const unsigned processors = std::thread::hardware_concurrency();
  return fmt::format("{}, {} {}", name, processors, processors == 1 ? "processor" : "processors");
}

}  // namespace plc::tools
