// Scans that leave out what did not change against scans that do not, both native code, on a plain ladder.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>

#include "bench/bench.h"
#include "core/clock.h"
#include "native/compile.h"
#include "runtime/access.h"
#include "runtime/compiled_task.h"
#include "runtime/resource.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

constexpr core::TimeNs kPeriodNs = 20'000'000;

/// The ladder in one engine, with the addresses of its inputs.
class Side {
 public:
  enum class Engine { kInterpreter, kNative, kChanged };

  Side(const Ladder& ladder, const std::string& project, Engine engine) {
    tools::Compilation compilation;
    tools::compile({project, {}, tools::Goal::kRun}, compilation);
    if (!compilation.ok()) return;
    auto loaded = runtime::Resource::load(std::move(*compilation.image));
    if (!loaded) return;
    resource_ = std::move(*loaded);
    if (engine != Engine::kInterpreter) {
      auto code = native::compile(program(), {.changed = engine == Engine::kChanged});
      if (!code) {
        std::cerr << code.error().message << '\n';
        resource_.reset();
        return;
      }
      program().install(std::move(*code));
    }
    const runtime::Access access(*resource_);
    for (std::uint32_t i = 0; i < ladder.inputs; ++i) {
      const auto place = access.find_leaf(fmt::format("{}.{}", kInstanceName, variable_name(i)));
      inputs_.push_back(program().table().data() + place->offset);
    }
  }
  [[nodiscard]] bool ok() const { return resource_ != nullptr; }
  [[nodiscard]] runtime::Program& program() { return resource_->program(0); }
  [[nodiscard]] const runtime::Program& program() const { return resource_->program(0); }
  void flip(std::size_t input) { *inputs_[input] ^= std::byte{1}; }
  [[nodiscard]] std::size_t inputs() const { return inputs_.size(); }
  bool scan(core::TimeNs now_ns) { return !program().execute({now_ns}); }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<std::byte*> inputs_;
};

enum : std::size_t { kInterpreter, kNative, kChanged, kSides };

/// What happens to the inputs in front of scan number `scan`.
using Change = std::function<void(Side& side, std::uint64_t scan)>;

class Comparison {
 public:
  Comparison(std::array<std::unique_ptr<Side>, kSides>& sides, const Change& change)
      : sides_(sides), change_(change) {}

  /// One scan of all sides; false when tables differ behind it.
  bool step() {
    bool fine = true;
    for (const auto& side : sides_) fine = one(*side, scan_) && fine;
    ++scan_;
    const auto& table = sides_[0]->program().table();
    for (std::size_t s = 1; s < kSides; ++s) {
      fine = fine && std::memcmp(table.data(), sides_[s]->program().table().data(), table.layout().total) == 0;
    }
    return fine;
  }
  /// Nanoseconds per scan of a batch.
  double time(std::size_t side, std::uint32_t scans) {
    const core::TimeNs begin = clock_.now_ns();
    for (std::uint32_t i = 0; i < scans; ++i) one(*sides_[side], scan_ + i);
    return static_cast<double>(clock_.now_ns() - begin) / scans;
  }
  void advance(std::uint32_t scans) { scan_ += scans; }

 private:
  bool one(Side& side, std::uint64_t scan) {
    change_(side, scan);
    return side.scan(static_cast<core::TimeNs>(scan + 1) * kPeriodNs);
  }

  std::array<std::unique_ptr<Side>, kSides>& sides_;
  const Change& change_;
  core::MonotonicClock clock_;
  std::uint64_t scan_ = 0;
};

}  // namespace

Verdict measure_changed(const ChangedPlan& plan) {
  std::cout << "Changed: evaluate = \"changed\" against full evaluation, both native code\n";
  Verdict verdict;
  const Scratch scratch;
  const Ladder ladder = make_ladder({plan.rungs, false, plan.seed});
  const std::string project = scratch.file("ladder.xml");
  {
    std::ofstream out(project, std::ios::binary);
    write_plcopen(ladder, out);
  }
  struct Row {
    const char* name;
    Change change;
    double limit;  ///< most that it may be of full evaluation
  };
  const Row rows[] = {
      {"nothing", [](Side&, std::uint64_t) {}, 0},
      {"one input",
       [](Side& side, std::uint64_t scan) { side.flip(scan * 2654435761u % side.inputs()); },
       1 / kChangedGain},
      {"all inputs",
       [](Side& side, std::uint64_t) {
         for (std::size_t i = 0; i < side.inputs(); ++i) side.flip(i);
       },
       kChangedLoss},
  };
  for (const Row& row : rows) { if (row.name[0] != (getenv("ROW") ? *getenv("ROW") : row.name[0])) continue;
    std::array<std::unique_ptr<Side>, kSides> sides;
    sides[kInterpreter] = std::make_unique<Side>(ladder, project, Side::Engine::kInterpreter);
    sides[kNative] = std::make_unique<Side>(ladder, project, Side::Engine::kNative);
    sides[kChanged] = std::make_unique<Side>(ladder, project, Side::Engine::kChanged);
    const std::string name = fmt::format("{:>7} rungs plain seed {}, {} changing", plan.rungs, plan.seed, row.name);
    bool fine = true;
    for (const auto& side : sides) fine = fine && side->ok();
    Comparison comparison(sides, row.change);
    for (std::uint32_t i = 0; i < plan.scans && fine; ++i) fine = comparison.step();
    std::string line = fmt::format("{}: {}", name, fine ? "tables equal" : "TABLES DIFFER");
    verdict.correct = verdict.correct && fine;
    if (fine && plan.batches != 0) {
      std::vector<double> times[kSides];
      std::vector<double> ratios;
      const std::uint32_t scans = std::max(200u, 100'000'000u / plan.rungs);
      for (std::uint32_t i = 0; i < plan.batches; ++i) {
        for (const std::size_t side : {kNative, kChanged}) times[side].push_back(comparison.time(side, getenv("ROW") && side == kNative ? 1 : scans));
        ratios.push_back(times[kChanged].back() / times[kNative].back());
        comparison.advance(scans);
      }
      const double ratio = median(ratios);
      line += fmt::format("; min {:.0f} {:.0f}", *std::min_element(times[kNative].begin(), times[kNative].end()), *std::min_element(times[kChanged].begin(), times[kChanged].end()));
      line += fmt::format("; ns/scan: full {:.0f}, changed {:.0f}; changed/full {:.3f}", median(times[kNative]),
                          median(times[kChanged]), ratio);
      if (row.limit != 0) line += ", " + limit_text(ratio, row.limit, verdict);
      const runtime::SkipCounts& counts = *sides[kChanged]->program().skipped();
      line += fmt::format("; {} groups, {:.1f} run per scan", counts.groups,
                          static_cast<double>(counts.runs) / static_cast<double>(counts.scans - counts.whole_scans + 1));
      line += fmt::format(", {} of {} scans whole", counts.whole_scans.load(), counts.scans.load());
    }
    std::cout << line << std::endl;
  }
  return verdict;
}

}  // namespace plc::bench
