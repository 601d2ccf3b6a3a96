// Tree: which of many things have something to do. BOOLs in the instance, one for each few things, and above them a
// binary tree, so that looking at them costs what there is to do and not how many there are.
//
// In: a number of things, code for each. Out: IR that marks one, and IR that visits those that are marked. Does not
// belong here: what the things are.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "ir/builder.h"

namespace plc::sfc {

class Tree {
 public:
  /// A tree over things 0 to `count`; up to kGroup of them need no marks.
  Tree(ir::Builder& builder, std::string_view hint, std::uint32_t count);

  /// Code: thing `i` has something to do.
  void mark(std::uint32_t i);
  /// Code: `visit` writes the code for each thing that may have something to do, ascending; that code tests the thing
  /// itself. With `alive`, which gives a BOOL that is TRUE while a thing has something to do, marks without one are
  /// taken away.
  void walk(const std::function<void(std::uint32_t)>& visit,
            const std::function<ir::ValueId(std::uint32_t)>& alive = nullptr);

  /// Things that are visited together.
  static constexpr std::uint32_t kGroup = 4;

 private:
  using Visit = std::function<void(std::uint32_t)>;
  using Alive = std::function<ir::ValueId(std::uint32_t)>;
  void walk_node(std::size_t level, std::uint32_t i, const Visit& visit, const Alive& alive);
  void walk_group(std::uint32_t group, const Visit& visit, const Alive& alive);
  [[nodiscard]] ir::PlaceId node(std::size_t level, std::uint32_t i) { return builder_.variable(levels_[level][i]); }

  ir::Builder& builder_;
  std::uint32_t count_;
  std::vector<std::vector<std::uint32_t>> levels_;  ///< hidden variables: of groups, of pairs of them, .. one
};

}  // namespace plc::sfc
