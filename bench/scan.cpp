// Scan time of interpreter and native code against gcc -O2, results compared variable by variable.
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>

#include "bench/bench.h"
#include "core/clock.h"
#include "native/compile.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

constexpr core::TimeNs kPeriodNs = 20'000'000;

/// One of those that do the same: a scan, and the variables of the ladder as bytes.
class Side {
 public:
  virtual ~Side() = default;
  /// False when the scan ended in a fault.
  virtual bool scan(core::TimeNs now_ns) = 0;
  [[nodiscard]] virtual unsigned char* variable(std::uint32_t index) = 0;
  [[nodiscard]] virtual bool ok() const = 0;
};

/// The ladder as a shared object made by the C compiler.
class CSide final : public Side {
 public:
  CSide(const Ladder& ladder, const Scratch& scratch, bool barriers) {
    const std::string source = scratch.file("ladder.c");
    const std::string object = scratch.file(barriers ? "barriers.so" : "plain.so");
    {
      std::ofstream out(source);
      write_c(ladder, out);
    }
    const std::string command =
        fmt::format("{} -O2 -shared -fPIC {} -o {} {}", PLC_C_COMPILER, barriers ? "" : "-DBARRIER=", object, source);
    if (std::system(command.c_str()) != 0) return;
    library_ = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) return;
    scan_ = reinterpret_cast<void (*)(long long)>(::dlsym(library_, "plc_scan"));
    variables_ = reinterpret_cast<unsigned char* (*)()>(::dlsym(library_, "plc_variables"))();
  }
  ~CSide() override {
    if (library_ != nullptr) ::dlclose(library_);
  }
  CSide(const CSide&) = delete;
  CSide& operator=(const CSide&) = delete;

  [[nodiscard]] bool ok() const override { return scan_ != nullptr; }
  bool scan(core::TimeNs now_ns) override {
    scan_(now_ns);
    return true;
  }
  [[nodiscard]] unsigned char* variable(std::uint32_t index) override { return variables_ + index; }

 private:
  void* library_ = nullptr;
  void (*scan_)(long long) = nullptr;
  unsigned char* variables_ = nullptr;
};

/// The same ladder through the pipeline, with the address of every variable; in the interpreter or as native code.
class PlcSide final : public Side {
 public:
  PlcSide(const Ladder& ladder, const std::string& project, bool compiled) {
    tools::Compilation compilation;
    tools::compile({project, {}, tools::Goal::kRun}, compilation);
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
    if (compiled) {
      auto code = native::compile(resource_->program(0));
      if (!code) {
        std::cerr << code.error().message << '\n';
        resource_.reset();
        return;
      }
      resource_->program(0).install(std::move(*code));
    }
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
  [[nodiscard]] bool ok() const override { return resource_ != nullptr; }
  bool scan(core::TimeNs now_ns) override { return !resource_->program(0).execute({now_ns}); }
  [[nodiscard]] unsigned char* variable(std::uint32_t index) override { return variables_[index]; }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<unsigned char*> variables_;
};

constexpr std::size_t kSides = 4;
constexpr const char* kNames[kSides] = {"C", "C without barriers", "interpreter", "native"};
enum : std::size_t { kBarriers, kPlain, kInterpreter, kNative };

class Comparison {
 public:
  Comparison(const Ladder& ladder, const std::array<std::unique_ptr<Side>, kSides>& sides)
      : ladder_(ladder), sides_(sides) {}

  /// One scan of all after changing one input of all. False when one faulted.
  bool step() {
    const std::uint32_t input = input_of(flips_++);
    now_ns_ += kPeriodNs;
    bool fine = true;
    for (const auto& side : sides_) {
      *side->variable(input) ^= 1;
      fine = side->scan(now_ns_) && fine;
    }
    return fine;
  }
  /// Variables of any side that differ from the first one's now.
  [[nodiscard]] std::uint32_t differences() {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < ladder_.variables; ++i) {
      for (std::size_t s = 1; s < kSides; ++s) {
        const unsigned char expected = *sides_[0]->variable(i);
        const unsigned char found = *sides_[s]->variable(i);
        if (expected == found || count++ >= 5) continue;
        std::cerr << fmt::format("{}: C has {}, {} {}\n", variable_name(i), expected, kNames[s], found);
      }
    }
    return count;
  }

  /// Nanoseconds per scan of a batch of one side; all sides see the same inputs in the same order.
  double time(std::size_t side, std::uint32_t scans) {
    Side& s = *sides_[side];
    const core::TimeNs begin = clock_.now_ns();
    for (std::uint32_t i = 0; i < scans; ++i) {
      *s.variable(input_of(flips_ + i)) ^= 1;
      ok_ = s.scan(now_ns_ + (i + 1) * kPeriodNs) && ok_;
    }
    return static_cast<double>(clock_.now_ns() - begin) / scans;
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

  const Ladder& ladder_;
  const std::array<std::unique_ptr<Side>, kSides>& sides_;
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
  const std::string project = scratch.file("ladder.xml");
  {
    std::ofstream out(project, std::ios::binary);
    write_plcopen(ladder, out);
  }
  std::array<std::unique_ptr<Side>, kSides> sides;
  sides[kBarriers] = std::make_unique<CSide>(ladder, scratch, true);
  sides[kPlain] = std::make_unique<CSide>(ladder, scratch, false);
  sides[kInterpreter] = std::make_unique<PlcSide>(ladder, project, false);
  sides[kNative] = std::make_unique<PlcSide>(ladder, project, true);
  const std::string name = fmt::format("{:>7} rungs {:<6} seed {}", plan.shape.rungs,
                                       plan.shape.nested ? "nested" : "plain", plan.shape.seed);
  if (!std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side->ok(); })) {
    std::cout << name << ": could not be built\n";
    verdict.correct = false;
    return verdict;
  }
  Comparison comparison(ladder, sides);
  std::uint32_t true_coils = 0;
  for (std::uint32_t i = 0; i < plan.scans && verdict.correct; ++i) {
    verdict.correct = comparison.step() && comparison.differences() == 0;
    if (!verdict.correct) std::cerr << fmt::format("after scan {}\n", i + 1);
  }
  for (std::uint32_t i = ladder.inputs; i < ladder.variables; ++i) true_coils += *sides[0]->variable(i);
  std::string line = fmt::format("{}: {} after {} scans, {} of {} coils on", name,
                                 verdict.correct ? "all variables equal" : "VARIABLES DIFFER", plan.scans, true_coils,
                                 ladder.variables - ladder.inputs);
  if (verdict.correct && plan.batches != 0) {
    std::vector<double> times[kSides];
    std::vector<double> ratios[kSides];  // to C with barriers
    std::vector<double> to_plain;
    const std::uint32_t scans = std::max(1u, 200'000u / plan.shape.rungs);
    for (std::uint32_t i = 0; i < plan.batches; ++i) {
      for (std::size_t s = 0; s < kSides; ++s) {
        times[s].push_back(comparison.time(s, scans));
        ratios[s].push_back(times[s].back() / times[kBarriers].back());
      }
      to_plain.push_back(times[kNative].back() / times[kPlain].back());
      comparison.advance(scans);
    }
    if (comparison.differences() != 0 || !comparison.ok()) verdict.correct = false;
    line += "; ns/rung:";
    for (std::size_t s = 0; s < kSides; ++s) {
      line += fmt::format("{} {} {:.2f}", s == 0 ? "" : ",", kNames[s], median(times[s]) / plan.shape.rungs);
    }
    const auto against = [&](const char* what, const std::vector<double>& of, double limit) {
      const double ratio = median(of);
      line += fmt::format("; {} {:.2f}", what, ratio);
      if (limit != 0) line += ", " + limit_text(ratio, limit, verdict);
    };
    against("interpreter/C", ratios[kInterpreter], plan.limit);
    against("native/C", ratios[kNative], plan.native_limit);
    against("native/C without barriers", to_plain, plan.native_limit != 0 ? 1 : 0);
  }
  std::cout << line << std::endl;
  return verdict;
}

}  // namespace plc::bench
