#include "frontend-sfc/tree.h"

#include <algorithm>

namespace plc::sfc {

Tree::Tree(ir::Builder& builder, std::string_view hint, std::uint32_t count) : builder_(builder), count_(count) {
  for (std::uint32_t width = count; width > kFan;) {
    width = (width + kFan - 1) / kFan;
    std::vector<std::uint32_t>& level = levels_.emplace_back();
    for (std::uint32_t i = 0; i < width; ++i) level.push_back(builder.hidden(hint, ir::kBoolType));
  }
}

void Tree::mark(std::uint32_t i) {
  if (levels_.empty()) return;
  const ir::ValueId on = builder_.constant_bool(true);
  for (std::size_t level = 0; level < levels_.size(); ++level) builder_.store(node(level, i /= kFan), on);
}

void Tree::walk(const std::function<void(std::uint32_t)>& visit,
                const std::function<ir::ValueId(std::uint32_t)>& alive) {
  const std::size_t top = levels_.size();
  walk_range(top, 0, top == 0 ? count_ : static_cast<std::uint32_t>(levels_[top - 1].size()), visit, alive);
}

/// Things or marks `begin` to `end` of what is below `level`: 0 are the things.
void Tree::walk_range(std::size_t level, std::uint32_t begin, std::uint32_t end,
                      const std::function<void(std::uint32_t)>& visit,
                      const std::function<ir::ValueId(std::uint32_t)>& alive) {
  for (std::uint32_t i = begin; i < end; ++i) {
    if (level == 0) {
      visit(i);
      continue;
    }
    const ir::LabelId skip = builder_.new_label();
    builder_.jump_if_not(builder_.load(node(level - 1, i)), skip);
    const std::uint32_t first = i * kFan;
    const std::uint32_t width = level == 1 ? count_ : static_cast<std::uint32_t>(levels_[level - 2].size());
    const std::uint32_t last = std::min(width, first + kFan);
    walk_range(level - 1, first, last, visit, alive);
    if (alive) {
      ir::ValueId any{};
      for (std::uint32_t k = first; k < last; ++k) {
        const ir::ValueId one = level == 1 ? alive(k) : builder_.load(node(level - 2, k));
        any = any.valid() ? builder_.logic(ir::Op::kOr, any, one) : one;
      }
      builder_.store(node(level - 1, i), any);
    }
    builder_.bind(skip);
  }
}

}  // namespace plc::sfc
