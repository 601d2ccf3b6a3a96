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

#include "bench/bench.h"
#include "core/clock.h"
#include "picard/taskblock.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "taskblocks/registry.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kBlocks = 1'000;
constexpr std::uint32_t kWires = 8;  ///< from a block of the chain to the next
constexpr std::uint32_t kScansPerBatch = 20;
constexpr double kCallLimitNs = 3;
constexpr double kWireLimit = 1.1;

/// All objects of the last program that was loaded, in the order in which it executes them.
std::vector<void*> made;

/// Blocks of the shape of a filter, and with eight wires. `kWorks`: they pass their inputs on, plus 1; else they are
/// empty, and all that is measured is what is around them.
template <bool kWorks>
class One final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = kWorks ? "ONE_WORKING" : "ONE_EMPTY", .group = "Bench", .summary = "One input."};
  picard::Input<double> in{this, "IN1", "any number"};
  picard::Output<double> out{this, "OUT1", "IN1 + 1"};
  One() { made.push_back(this); }
  void fire() override {
    if (kWorks) out = in + 1;
  }
};

template <bool kWorks>
class Eight final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = kWorks ? "EIGHT_WORKING" : "EIGHT_EMPTY", .group = "Bench", .summary = "Eight inputs."};
  picard::Input<double> in1{this, "IN1", ""}, in2{this, "IN2", ""}, in3{this, "IN3", ""}, in4{this, "IN4", ""},
      in5{this, "IN5", ""}, in6{this, "IN6", ""}, in7{this, "IN7", ""}, in8{this, "IN8", ""};
  picard::Output<double> out1{this, "OUT1", "IN1 + 1"}, out2{this, "OUT2", ""}, out3{this, "OUT3", ""},
      out4{this, "OUT4", ""}, out5{this, "OUT5", ""}, out6{this, "OUT6", ""}, out7{this, "OUT7", ""},
      out8{this, "OUT8", ""};
  void fire() override {
    if (!kWorks) return;
    out1 = in1 + 1, out2 = in2 + 1, out3 = in3 + 1, out4 = in4 + 1;
    out5 = in5 + 1, out6 = in6 + 1, out7 = in7 + 1, out8 = in8 + 1;
  }
};

PICARD_LINKED_LIBRARY(bench_library, "bench", "1.0.0", One<false>, One<true>, Eight<false>, Eight<true>)

const taskblocks::Registry& registry() {
  static const taskblocks::Registry all = [] {
    taskblocks::Registry r;
    if (const auto problem = r.add(bench_library())) throw std::logic_error(problem->message);
    return r;
  }();
  return all;
}

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
    tools::Compilation compilation;
    tools::Request request{path, {}, tools::Goal::kRun};
    request.taskblocks = &registry();
    tools::compile(request, compilation);
    if (!compilation.ok()) {
      compilation.diagnostics.render(std::cerr);
      throw std::runtime_error("the project of the taskblock benchmark does not compile");
    }
    runtime::ProgramOptions options;
    options.taskblocks = &registry();
    made.clear();
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
  for (void* const object : made) calls.push_back({registry().find("ONE_EMPTY")->block->fire, object});
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
                           limit_text(median(more), kCallLimitNs, verdict));
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
      limit_text(median(wired_ratios), kWireLimit, verdict), median(copied_ratios));
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
