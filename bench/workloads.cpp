#include <algorithm>

#include "bench/program.h"
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
  // Of native code against C without barriers: 1, and what medians of equal code differ by on a machine that does
  // other things, too.
  constexpr double kNotSlower = 1.02;
  static const std::vector<Workload> all = {
      {"plain", "rung", &drawn<Kind::kPlain>, {100, 1'000, 10'000, 100'000}, 200, true, {2, 1.15, kNotSlower}},
      {"nested", "rung", &drawn<Kind::kNested>, {1'000, 10'000}, 100, true, {3, 1.25, 0}},
      {"blocks", "rung", &drawn<Kind::kBlocks>, {100, 1'000, 10'000}, 100, true, {6, 1.25, 0}},
      {"arithmetic", "chain", &drawn<Kind::kArithmetic>, {100, 1'000, 10'000}, 100, true, {6, 1.25, 0}},
      {"mixed", "rung", &drawn<Kind::kMixed>, {100, 1'000, 10'000}, 100, true, {6, 1.25, 0}},
      {"bubble", "element", &make_bubble, {1'000}, 100, false, {6, 2, 0}},
      {"products", "product", &make_products, {1'000, 100'000}, 100, false, {6, 2, 0}},
      {"fir", "sample", &make_fir, {1'000}, 100, false, {6, 2, 0}},
      {"matrix", "row", &make_matrix, {50}, 10, false, {6, 2, 0}},
      {"checksum", "byte", &make_checksum, {4'096}, 100, false, {6, 2, 0}},
      {"taskblocks", "call", &make_calls, {100, 1'000}, 100, false, {6, 0, 0}},
      {"exchange", "DINT", &make_exchange, {100, 1'000, 10'000}, 100, false, {6, 0, 0}},
  };
  return all;
}

const Workload* find_workload(const std::string& name) {
  const auto all = workloads();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Workload& w) { return w.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace plc::bench
