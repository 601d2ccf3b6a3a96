#include "bench/taskblock_types.h"

#include <stdexcept>

#include "picard/taskblock.h"

namespace plc::bench {
namespace {

/// Blocks of the shape of a filter, and with eight wires. `kWorks`: they pass their inputs on, plus 1; else they are
/// empty, and all that is measured is what is around them.
template <bool kWorks>
class One final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = kWorks ? "ONE_WORKING" : "ONE_EMPTY", .group = "Bench", .summary = "One input."};
  picard::Input<double> in{this, "IN1", "any number"};
  picard::Output<double> out{this, "OUT1", "IN1 + 1"};
  One() { made_taskblocks().push_back(this); }
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

}  // namespace

std::vector<void*>& made_taskblocks() {
  static std::vector<void*> made;
  return made;
}

const taskblocks::Registry& bench_taskblocks() {
  static const taskblocks::Registry all = [] {
    taskblocks::Registry r;
    if (const auto problem = r.add(bench_library())) throw std::logic_error(problem->message);
    return r;
  }();
  return all;
}

}  // namespace plc::bench
