#include "frontend-sfc/tree.h"

#include <algorithm>

namespace plc::sfc {

using ir::LabelId;
using ir::ValueId;

Tree::Tree(ir::Builder& builder, std::string_view hint, std::uint32_t count) : builder_(builder), count_(count) {
  if (count <= kGroup) return;
  for (std::uint32_t width = (count + kGroup - 1) / kGroup;; width = (width + 1) / 2) {
    std::vector<std::uint32_t>& level = levels_.emplace_back();
    for (std::uint32_t i = 0; i < width; ++i) level.push_back(builder.hidden(hint, ir::kBoolType));
    if (width == 1) return;
  }
}

void Tree::mark(std::uint32_t i) {
  if (levels_.empty()) return;
  const ValueId on = builder_.constant_bool(true);
  i /= kGroup;
  for (std::size_t level = 0; level < levels_.size(); ++level, i /= 2) builder_.store(node(level, i), on);
}

void Tree::walk(const Visit& visit, const Alive& alive) {
  if (count_ == 0) return;
  if (levels_.empty()) return walk_group(0, visit, nullptr);
  const LabelId end = builder_.new_label();
  const std::size_t top = levels_.size() - 1;
  builder_.jump_if_not(builder_.load(node(top, 0)), end);
  walk_node(top, 0, visit, alive);
  builder_.bind(end);
}

/// Node `i` is marked, so one of its two parts is: if it is not the first, it is the second.
void Tree::walk_node(std::size_t level, std::uint32_t i, const Visit& visit, const Alive& alive) {
  if (level == 0) return walk_group(i, visit, alive);
  const std::uint32_t first = i * 2;
  const std::uint32_t second = first + 1;
  const bool pair = second < levels_[level - 1].size();
  if (pair) {
    const LabelId right = builder_.new_label();
    const LabelId end = builder_.new_label();
    builder_.jump_if_not(builder_.load(node(level - 1, first)), right);
    walk_node(level - 1, first, visit, alive);
    builder_.jump_if_not(builder_.load(node(level - 1, second)), end);
    builder_.bind(right);
    walk_node(level - 1, second, visit, alive);
    builder_.bind(end);
  } else {
    walk_node(level - 1, first, visit, alive);
  }
  if (!alive) return;
  // Marks are taken away, and mostly stay: a mark that is written is one that the level above waits for.
  const LabelId marked = builder_.new_label();
  builder_.jump_if(builder_.load(node(level - 1, first)), marked);
  if (pair) builder_.jump_if(builder_.load(node(level - 1, second)), marked);
  builder_.store(node(level, i), builder_.constant_bool(false));
  builder_.bind(marked);
}

void Tree::walk_group(std::uint32_t group, const Visit& visit, const Alive& alive) {
  const std::uint32_t end = std::min(count_, (group + 1) * kGroup);
  for (std::uint32_t i = group * kGroup; i < end; ++i) visit(i);
  if (!alive) return;
  ValueId any{};
  for (std::uint32_t i = group * kGroup; i < end; ++i) {
    const ValueId one = alive(i);
    any = any.valid() ? builder_.logic(ir::Op::kOr, any, one) : one;
  }
  const LabelId marked = builder_.new_label();
  builder_.jump_if(any, marked);
  builder_.store(node(0, group), builder_.constant_bool(false));
  builder_.bind(marked);
}

}  // namespace plc::sfc
