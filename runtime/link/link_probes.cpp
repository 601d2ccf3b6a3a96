#include "runtime/link/link_probes.h"

#include <algorithm>
#include <utility>

namespace plc::runtime {

std::uint32_t LinkProbes::order_of_jump(std::uint32_t word) const {
  if (map_ == nullptr) return 0;
  const auto found = std::lower_bound(map_->jumps.begin(), map_->jumps.end(), word,
                                      [](const bytecode::ProbeJump& jump, std::uint32_t w) { return jump.word < w; });
  return found == map_->jumps.end() || found->word != word ? 0 : found->order;
}

std::uint32_t LinkProbes::target(std::uint32_t word, std::uint32_t order, std::uint32_t otherwise) const {
  if (order == 0) return otherwise;
  const auto found = std::lower_bound(groups_.begin(), groups_.end(), std::pair{word, order},
                                      [](const Group& group, const auto& wanted) {
                                        return std::pair{group.word, group.order} < wanted;
                                      });
  return found == groups_.end() || found->word != word ? otherwise : found->position;
}

}  // namespace plc::runtime
