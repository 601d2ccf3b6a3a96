// Interpreter scan time against gcc -O2, results compared variable by variable.
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>

#include "bench/bench.h"
#include "core/clock.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

constexpr core::TimeNs kPeriodNs = 20'000'000;

/// The ladder as a shared object made by the C compiler.
class Native {
 public:
  Native(const Ladder& ladder, const Scratch& scratch) {
    const std::string source = scratch.file("ladder.c");
    const std::string object = scratch.file("ladder.so");
    {
      std::ofstream out(source);
      write_c(ladder, out);
    }
    const std::string command = fmt::format("{} -O2 -shared -fPIC -o {} {}", PLC_C_COMPILER, object, source);
    if (std::system(command.c_str()) != 0) return;
    library_ = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) return;
    scan_ = reinterpret_cast<void (*)(long long)>(::dlsym(library_, "plc_scan"));
    variables_ = reinterpret_cast<unsigned char* (*)()>(::dlsym(library_, "plc_variables"))();
  }
  ~Native() {
    if (library_ != nullptr) ::dlclose(library_);
  }
  Native(const Native&) = delete;
  Native& operator=(const Native&) = delete;

  [[nodiscard]] bool ok() const { return scan_ != nullptr; }
  void scan(core::TimeNs now_ns) { scan_(now_ns); }
  [[nodiscard]] unsigned char* variables() { return variables_; }

 private:
  void* library_ = nullptr;
  void (*scan_)(long long) = nullptr;
  unsigned char* variables_ = nullptr;
};

/// The same ladder through the pipeline, with the address of every variable.
class Interpreted {
 public:
  Interpreted(const Ladder& ladder, const Scratch& scratch) {
    const std::string path = scratch.file("ladder.xml");
    {
      std::ofstream out(path, std::ios::binary);
      write_plcopen(ladder, out);
    }
    tools::Compilation compilation;
    tools::compile({path, {}, tools::Goal::kRun}, compilation);
    if (!compilation.ok()) {
      compilation.diagnostics.render(std::cerr);
      return;
    }
    auto loaded = runtime::Resource::load(std::move(*compilation.image));
    if (!loaded) {
      std::cerr << loaded.error().message << '\n';
      return;
    }
    resource_ = std::move(*loaded);
    const runtime::Access access(*resource_);
    for (std::uint32_t i = 0; i < ladder.variables; ++i) {
      const auto place = access.find_leaf(fmt::format("{}.{}", kInstanceName, variable_name(i)));
      if (!place) {
        std::cerr << place.error().message << '\n';
        resource_.reset();
        return;
      }
      if (place->task == runtime::Place::kGlobal) {
        std::cerr << variable_name(i) << " is global, where the benchmark cannot set it\n";
        resource_.reset();
        return;
      }
      std::byte* table = resource_->program(place->task).table().data();
      variables_.push_back(reinterpret_cast<unsigned char*>(table + place->offset));
    }
  }
  [[nodiscard]] bool ok() const { return resource_ != nullptr; }
  [[nodiscard]] bool scan(core::TimeNs now_ns) { return !resource_->program(0).execute({now_ns}); }
  [[nodiscard]] unsigned char* variable(std::uint32_t index) { return variables_[index]; }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<unsigned char*> variables_;
};

class Comparison {
 public:
  Comparison(const Ladder& ladder, Native& native, Interpreted& interpreted)
      : ladder_(ladder), native_(native), interpreted_(interpreted) {}

  /// One scan of both after changing one input of both.
  bool step() {
    flip();
    now_ns_ += kPeriodNs;
    native_.scan(now_ns_);
    return interpreted_.scan(now_ns_);
  }
  /// Variables that differ now.
  [[nodiscard]] std::uint32_t differences() {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < ladder_.variables; ++i) {
      if (native_.variables()[i] != *interpreted_.variable(i)) {
        if (count++ < 5) {
          std::cerr << fmt::format("{}: C has {}, the interpreter {}\n", variable_name(i), native_.variables()[i],
                                   *interpreted_.variable(i));
        }
      }
    }
    return count;
  }

  /// Nanoseconds per scan of a batch of one side; both sides see the same inputs in the same order.
  double time_native(std::uint32_t scans) {
    return timed(scans, [&](std::uint32_t input, core::TimeNs now) {
      native_.variables()[input] ^= 1;
      native_.scan(now);
    });
  }
  double time_interpreted(std::uint32_t scans) {
    return timed(scans, [&](std::uint32_t input, core::TimeNs now) {
      *interpreted_.variable(input) ^= 1;
      ok_ = interpreted_.scan(now) && ok_;
    });
  }
  void advance(std::uint32_t scans) {
    now_ns_ += scans * kPeriodNs;
    flips_ += scans;
  }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  [[nodiscard]] std::uint32_t input_of(std::uint64_t flip) const {
    return static_cast<std::uint32_t>(flip * 2654435761u % ladder_.inputs);
  }
  void flip() {
    const std::uint32_t input = input_of(flips_++);
    native_.variables()[input] ^= 1;
    *interpreted_.variable(input) ^= 1;
  }
  template <class Scan>
  double timed(std::uint32_t scans, Scan scan) {
    const core::TimeNs begin = clock_.now_ns();
    for (std::uint32_t i = 0; i < scans; ++i) scan(input_of(flips_ + i), now_ns_ + (i + 1) * kPeriodNs);
    return static_cast<double>(clock_.now_ns() - begin) / scans;
  }

  const Ladder& ladder_;
  Native& native_;
  Interpreted& interpreted_;
  core::MonotonicClock clock_;
  core::TimeNs now_ns_ = 0;
  std::uint64_t flips_ = 0;
  bool ok_ = true;
};

}  // namespace

Verdict measure_scan(const ScanPlan& plan) {
  Verdict verdict;
  const Scratch scratch;
  const Ladder ladder = make_ladder(plan.shape);
  Native native(ladder, scratch);
  Interpreted interpreted(ladder, scratch);
  const std::string name =
      fmt::format("{:>7} rungs {:<6} seed {}", plan.shape.rungs, plan.shape.nested ? "nested" : "plain", plan.shape.seed);
  if (!native.ok() || !interpreted.ok()) {
    std::cout << name << ": could not be built\n";
    verdict.correct = false;
    return verdict;
  }
  Comparison comparison(ladder, native, interpreted);
  std::uint32_t true_coils = 0;
  for (std::uint32_t i = 0; i < plan.scans && verdict.correct; ++i) {
    verdict.correct = comparison.step() && comparison.differences() == 0;
    if (!verdict.correct) std::cerr << fmt::format("after scan {}\n", i + 1);
  }
  for (std::uint32_t i = ladder.inputs; i < ladder.variables; ++i) true_coils += *interpreted.variable(i);
  std::string line = fmt::format("{}: {} after {} scans, {} of {} coils on", name,
                                 verdict.correct ? "all variables equal" : "VARIABLES DIFFER", plan.scans, true_coils,
                                 ladder.variables - ladder.inputs);
  if (verdict.correct && plan.batches != 0) {
    std::vector<double> c, vm, ratios;
    const std::uint32_t scans = std::max(1u, 200'000u / plan.shape.rungs);
    for (std::uint32_t i = 0; i < plan.batches; ++i) {
      c.push_back(comparison.time_native(scans));
      vm.push_back(comparison.time_interpreted(scans));
      comparison.advance(scans);
      ratios.push_back(vm.back() / c.back());
    }
    if (comparison.differences() != 0 || !comparison.ok()) verdict.correct = false;
    const double ratio = median(ratios);
    const double rungs = plan.shape.rungs;
    line += fmt::format("; C {:.2f}, interpreter {:.2f} ns/rung, ratio {:.2f}", median(c) / rungs, median(vm) / rungs, ratio);
    if (plan.limit != 0) line += ", " + limit_text(ratio, plan.limit, verdict);
  }
  std::cout << line << std::endl;
  return verdict;
}

}  // namespace plc::bench
