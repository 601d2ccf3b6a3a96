// What one task's body reaches and exports, before anything is resolved.
#include <algorithm>
#include <utility>

#include "runtime/link/decoded.h"
#include "runtime/link/link.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::Opcode;

bool is_export(Opcode opcode) { return opcode == Opcode::kWriteN || opcode == Opcode::kWriteChangedN; }

bool calls_pou(Opcode opcode) {
  return opcode == Opcode::kCallPou || opcode == Opcode::kCallAt || opcode == Opcode::kCallVia ||
         opcode == Opcode::kCallFn;
}

}  // namespace

std::vector<std::uint32_t> reached_pous(const Image& image, std::uint32_t body) {
  // Depth first without recursion; the verifier has refused cycles. Reverse post-order puts callers first.
  std::vector<std::vector<std::uint32_t>> callees(image.pous.size());
  std::vector<std::uint8_t> seen(image.pous.size(), 0);
  std::vector<std::pair<std::uint32_t, std::size_t>> path;
  std::vector<std::uint32_t> order;
  const auto enter = [&](std::uint32_t pou) {
    seen[pou] = 1;
    for_each_instruction(image.pous[pou], [&](const Decoded& d) {
      if (calls_pou(d.opcode)) callees[pou].push_back(d.operands[0]);
    });
    path.emplace_back(pou, 0);
  };
  enter(body);
  while (!path.empty()) {
    const std::uint32_t pou = path.back().first;
    if (path.back().second == callees[pou].size()) {
      order.push_back(pou);
      path.pop_back();
      continue;
    }
    const std::uint32_t callee = callees[pou][path.back().second++];
    if (seen[callee] == 0) enter(callee);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

std::vector<FieldRange> exchanged_ranges(const Image& image, std::uint32_t body) {
  std::vector<FieldRange> ranges;
  for_each_instruction(image.pous[body], [&](const Decoded& d) {
    if (d.opcode != Opcode::kReadN && !is_export(d.opcode)) return;
    ranges.push_back({d.operands[0], d.operands[1], is_export(d.opcode)});
  });
  return ranges;
}

}  // namespace plc::runtime
