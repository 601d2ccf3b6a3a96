#include <algorithm>
#include <string>
#include <vector>

#include "bench/drawn_source.h"
#include "bench/st_programs.h"
#include "bench/workload.h"

namespace plc::bench {
namespace {

template <Kind K, Text T = Text::kXml>
Source drawn(std::uint32_t size, std::uint64_t seed) {
  return make_source({K, size, seed}, T);
}

/// Drawn and as ST (".st"), and each of them with all inputs changing (".random") too.
template <Kind K>
void add_forms(std::vector<Workload>& all, const std::string& name, const ScanLimits& limits) {
  const Workload form{name, "rung", &drawn<K>, {1'000, 10'000}, 100, true, limits};
  for (const bool st : {false, true}) {
    for (const Inputs inputs : {Inputs::kOneOfEachType, Inputs::kAll}) {
      Workload& added = all.emplace_back(form);
      added.name += std::string(st ? ".st" : "") + (inputs == Inputs::kAll ? ".random" : "");
      if (st) added.make = &drawn<K, Text::kSt>;
      added.inputs = inputs;
    }
  }
}

std::vector<Workload> make_workloads() {
  using namespace limit;
  constexpr const Limit* kNotSlower = &kNotSlowerThanInterpreter;
  constexpr ScanLimits kPlain{&kInterpreter, &kLadderNative, &kLadderNotSlower, kNotSlower};
  constexpr ScanLimits kRewritten{&kInterpreter, &kLadderNative, nullptr, kNotSlower};
  constexpr ScanLimits kDrawn{&kInterpreter, &kDrawnNative, nullptr, kNotSlower};
  constexpr ScanLimits kLoop{nullptr, &kLoopNative, nullptr, kNotSlower};
  constexpr ScanLimits kOther{&kInterpreter, nullptr, nullptr, kNotSlower};
  std::vector<Workload> all = {
      {"plain", "rung", &drawn<Kind::kPlain>, {100, 1'000, 10'000, 100'000}, 200, true, kPlain},
      {"nested", "rung", &drawn<Kind::kNested>, {1'000, 10'000}, 100, true, kDrawn},
      {"blocks", "rung", &drawn<Kind::kBlocks>, {100, 1'000, 10'000}, 100, true, kDrawn},
      {"arithmetic", "chain", &drawn<Kind::kArithmetic>, {100, 1'000, 10'000}, 100, true, kDrawn},
      {"mixed", "rung", &drawn<Kind::kMixed>, {100, 1'000, 10'000}, 100, true, kDrawn},
  };
  add_forms<Kind::kRewritten>(all, "rewritten", kRewritten);
  add_forms<Kind::kTimers>(all, "timers", kDrawn);
  add_forms<Kind::kMixed2>(all, "mixed2", kDrawn);
  const std::vector<Workload> written = {
      {"bubble", "element", &make_bubble, {1'000, 10'000}, 150, true, kLoop},
      {"products", "product", &make_products, {1'000, 100'000}, 100, true, kLoop},
      {"fir", "sample", &make_fir, {1'000, 10'000}, 100, true, kLoop},
      {"matrix", "row", &make_matrix, {1'000, 10'000}, 10, true, kLoop},
      {"checksum", "byte", &make_checksum, {1'000, 10'000}, 100, true, kLoop},
      {"taskblocks", "call", &make_calls, {100, 1'000}, 100, false, kOther},
      {"exchange", "DINT", &make_exchange, {100, 1'000, 10'000}, 100, false, kOther},
  };
  all.insert(all.end(), written.begin(), written.end());
  return all;
}

}  // namespace

std::span<const Workload> workloads() {
  static const std::vector<Workload> all = make_workloads();
  return all;
}

const Workload* find_workload(const std::string& name) {
  const auto all = workloads();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Workload& w) { return w.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace plc::bench
