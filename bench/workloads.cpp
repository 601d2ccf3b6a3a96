#include <algorithm>

#include "bench/drawn_source.h"
#include "bench/st_programs.h"
#include "bench/workload.h"

namespace plc::bench {
namespace {

template <Kind K>
Source drawn(std::uint32_t size, std::uint64_t seed) {
  return make_source({K, size, seed});
}

}  // namespace

std::span<const Workload> workloads() {
  using namespace limit;
  constexpr ScanLimits kDrawn{&kInterpreter, &kDrawnNative, nullptr};
  constexpr ScanLimits kLoop{nullptr, &kLoopNative, nullptr};
  constexpr ScanLimits kOther{&kInterpreter, nullptr, nullptr};
  static const std::vector<Workload> all = {
      {"plain",
       "rung",
       &drawn<Kind::kPlain>,
       {100, 1'000, 10'000, 100'000},
       200,
       true,
       {&kInterpreter, &kLadderNative, &kLadderNotSlower}},
      {"nested", "rung", &drawn<Kind::kNested>, {1'000, 10'000}, 100, true, {&kInterpreter, &kDrawnNative, nullptr}},
      {"blocks", "rung", &drawn<Kind::kBlocks>, {100, 1'000, 10'000}, 100, true, kDrawn},
      {"arithmetic", "chain", &drawn<Kind::kArithmetic>, {100, 1'000, 10'000}, 100, true, kDrawn},
      {"mixed", "rung", &drawn<Kind::kMixed>, {100, 1'000, 10'000}, 100, true, kDrawn},
      {"bubble", "element", &make_bubble, {1'000, 10'000}, 150, true, kLoop},
      {"products", "product", &make_products, {1'000, 100'000}, 100, true, kLoop},
      {"fir", "sample", &make_fir, {1'000, 10'000}, 100, true, kLoop},
      {"matrix", "row", &make_matrix, {1'000, 10'000}, 10, true, kLoop},
      {"checksum", "byte", &make_checksum, {1'000, 10'000}, 100, true, kLoop},
      {"taskblocks", "call", &make_calls, {100, 1'000}, 100, false, kOther},
      {"exchange", "DINT", &make_exchange, {100, 1'000, 10'000}, 100, false, kOther},
  };
  return all;
}

const Workload* find_workload(const std::string& name) {
  const auto all = workloads();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Workload& w) { return w.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace plc::bench
