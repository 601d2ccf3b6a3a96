// What executing a taskblock costs beyond its own work, against a plain indirect call of the same fire() on the same
// objects; and that a wire between two of them costs nothing.
#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/measurements.h"
#include "bench/scratch.h"
#include "bench/taskblock_types.h"
#include "compiler/compile.h"
#include "core/clock.h"
#include "runtime/access.h"
#include "runtime/resource.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kBlocks = 1'000;
constexpr std::uint32_t kWires = 8;  ///< from a block of the chain to the next
constexpr std::uint32_t kScansPerBatch = 20;

enum class Inputs : std::uint8_t {
  kOpen,    ///< nothing is wired
  kWired,   ///< each block to the one before it
  kCopied,  ///< the same, and assigned a second time in a branch that is never taken: a wire is a copy then
};

/// `blocks` blocks of `type` with `wires` inputs, executed one after the other.
std::string source(std::string_view type, std::uint32_t blocks, std::uint32_t wires, Inputs inputs) {
  std::string variables = "  never : BOOL;\n";
  std::string body;
  std::string again;
  for (std::uint32_t i = 0; i < blocks; ++i) {
    variables += fmt::format("  b{} : {};\n", i, type);
    std::string wired;
    std::string assigned;
    for (std::uint32_t w = 1; w <= wires && i > 0; ++w) {
      wired += fmt::format("{}IN{} := b{}.OUT{}", w == 1 ? "" : ", ", w, i - 1, w);
      assigned += fmt::format("{}IN{} := 0.0", w == 1 ? "" : ", ", w);
    }
    body += fmt::format("b{}({});\n", i, inputs == Inputs::kOpen ? "" : wired);
    again += fmt::format("  b{}({});\n", i, assigned);
  }
  if (inputs == Inputs::kCopied) body += "IF never THEN\n" + again + "END_IF;\n";
  return fmt::format(
      "PROGRAM Main\nVAR\n{}END_VAR\n{};\nEND_PROGRAM\nCONFIGURATION C\nRESOURCE R ON Plc\n"
      "  TASK T(INTERVAL := T#1s, PRIORITY := 0);\n  PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n",
      variables, body);
}

class Compiled {
 public:
  Compiled(std::string_view type, std::uint32_t blocks, std::uint32_t wires, Inputs inputs) {
    const Scratch scratch;
    const std::string path = scratch.file("taskblocks.st");
    std::ofstream(path) << source(type, blocks, wires, inputs);
    compiler::Compilation compilation;
    compiler::Request request{path, {}, compiler::Goal::kRun};
    request.taskblocks = &bench_taskblocks();
    compiler::compile(request, compilation);
    if (!compilation.ok()) {
      compilation.diagnostics.render(std::cerr);
      throw std::runtime_error("the project of the taskblock benchmark does not compile");
    }
    runtime::ProgramOptions options;
    options.taskblocks = &bench_taskblocks();
    made_taskblocks().clear();
    auto loaded = runtime::Resource::load(std::move(*compilation.image), options);
    if (!loaded) throw std::runtime_error(loaded.error().message);
    resource_ = std::move(*loaded);
  }
  void scan() { good_ = !resource_->program(0).execute({0}) && good_; }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::size_t wires() const { return resource_->image().pous[0].wires.size(); }
  [[nodiscard]] std::string value(const std::string& path) const {
    const runtime::Access access(*resource_);
    const auto place = access.find(path);
    return place ? access.read(*place) : place.error().message;
  }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  bool good_ = true;
};

/// Nanoseconds of one of `kScansPerBatch` repetitions.
template <class Work>
double timed(Work work) {
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  for (std::uint32_t i = 0; i < kScansPerBatch; ++i) work();
  return static_cast<double>(clock.now_ns() - begin) / kScansPerBatch;
}

/// Chains of blocks that work carry values to their ends, and as many wires are seen as are drawn.
bool chains_carry() {
  bool good = true;
  using Shape = std::pair<const char*, std::uint32_t>;
  for (const auto& [type, wires] : {Shape{"ONE_WORKING", 1}, Shape{"EIGHT_WORKING", kWires}}) {
    for (const Inputs inputs : {Inputs::kWired, Inputs::kCopied}) {
      Compiled chain(type, kBlocks, wires, inputs);
      chain.scan();
      for (std::uint32_t w = 1; w <= wires; ++w)
        good = good && chain.value(fmt::format("main.b{}.OUT{}", kBlocks - 1, w)) == std::to_string(kBlocks);
      good = good && chain.good() && chain.wires() == (inputs == Inputs::kWired ? wires * (kBlocks - 1) : 0);
    }
  }
  return good;
}

Verdict measure_calls(std::uint32_t batches) {
  Verdict verdict;
  Compiled nothing("ONE_EMPTY", 0, 1, Inputs::kOpen);
  Compiled blocks("ONE_EMPTY", kBlocks, 1, Inputs::kWired);
  struct Call {
    int (*fire)(void* object, picard_failure* failure);
    void* object;
  };
  std::vector<Call> calls;
  for (void* const object : made_taskblocks())
    calls.push_back({bench_taskblocks().find("ONE_EMPTY")->block->fire, object});
  bool fired = calls.size() == kBlocks;
  const auto call_all = [&] {
    picard_failure failure;
    for (const Call& call : calls) fired = call.fire(call.object, &failure) != 0 && fired;
  };
  std::vector<double> plain, executed, more;
  for (std::uint32_t i = 0; i < batches; ++i) {
    const double call = timed(call_all);
    const double scan = timed([&] { blocks.scan(); }) - timed([&] { nothing.scan(); });
    plain.push_back(call / kBlocks);
    executed.push_back(scan / kBlocks);
    more.push_back((scan - call) / kBlocks);
  }
  verdict.correct = fired && blocks.good() && nothing.good();
  std::cout << fmt::format("  {} empty blocks: indirect call {:.1f} ns, RUNTB {:.1f} ns, {:.1f} ns more, {}\n", kBlocks,
                           median(plain), median(executed), median(more),
                           limit_text(median(more), limit::kTaskblockCall, verdict));
  return verdict;
}

Verdict measure_wires(std::uint32_t batches) {
  Verdict verdict;
  Compiled open("EIGHT_EMPTY", kBlocks, kWires, Inputs::kOpen);
  Compiled wired("EIGHT_EMPTY", kBlocks, kWires, Inputs::kWired);
  Compiled copied("EIGHT_EMPTY", kBlocks, kWires, Inputs::kCopied);
  std::vector<double> without, wired_ratios, copied_ratios;
  for (std::uint32_t i = 0; i < batches; ++i) {
    without.push_back(timed([&] { open.scan(); }));
    wired_ratios.push_back(timed([&] { wired.scan(); }) / without.back());
    copied_ratios.push_back(timed([&] { copied.scan(); }) / without.back());
  }
  verdict.correct = open.good() && wired.good() && copied.good();
  std::cout << fmt::format(
      "  {} empty blocks with {} LREAL inputs: unconnected {:.1f} ns each; in a chain {:.2f} times that, {}; with "
      "copies "
      "{:.2f} times\n",
      kBlocks, kWires, median(without) / kBlocks, median(wired_ratios),
      limit_text(median(wired_ratios), limit::kTaskblockWires, verdict), median(copied_ratios));
  return verdict;
}

}  // namespace

Verdict measure_taskblocks(const TaskblockPlan& plan) {
  Verdict verdict;
  verdict.correct = chains_carry();
  std::cout << fmt::format("  chains of {} taskblocks: {}\n", kBlocks,
                           verdict.correct ? "results right" : "RESULTS WRONG");
  if (verdict.correct && plan.batches != 0) {
    verdict.merge(measure_calls(plan.batches));
    verdict.merge(measure_wires(plan.batches));
  }
  return verdict;
}

}  // namespace plc::bench
