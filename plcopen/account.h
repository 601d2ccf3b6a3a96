// The account of a file's elements: every element belongs to exactly one row of the import report.
//
// In: (open element, name of the child). Out: the rule for the child and its row. Lookups are cached per pair, so that
// an element costs one hash probe. Does not belong here: what handlers do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "plcopen/project.h"
#include "plcopen/rules.h"

namespace plc::plcopen {

class Account {
 public:
  /// One kind of element at one place of the tree.
  struct Node {
    const Rule* rule = nullptr;  ///< null: unknown element
    State state = State::kSkip;
    Fate fate = Fate::kIgnored;
    std::uint32_t row = 0;
    std::string variant;
    std::vector<std::uint32_t> variants;  ///< nodes that differ by data's name or xsi:type
  };
  using NodeId = std::uint32_t;

  Account();
  static constexpr NodeId kRoot = 0;

  /// Node of the child `name` (an address that stands for the name) of `parent`; `variant` is data's name or the local
  /// part of xsi:type, or empty. Counts the element.
  NodeId enter(NodeId parent, const char* name, std::string_view variant, std::uint32_t line);
  [[nodiscard]] const Node& node(NodeId id) const { return nodes_[id]; }
  /// Moves the rows out, in the order of first appearance.
  std::vector<ReportRow> take_rows();

 private:
  /// Kinds beyond these are counted together: a file of made-up names must not fill the memory.
  static constexpr std::size_t kMaxNodes = 4096;
  static constexpr std::size_t kMaxVariants = 64;
  static constexpr std::size_t kMaxPath = 200;

  struct Slot {
    const char* name = nullptr;
    NodeId parent = 0;
    NodeId child = 0;
  };

  NodeId make(NodeId parent, std::string_view name, std::string_view variant);
  NodeId variant_of(NodeId base, NodeId parent, const char* name, std::string_view variant);
  std::uint32_t row_for(std::string path, Fate fate, std::string_view reason);

  std::vector<Node> nodes_;
  std::vector<ReportRow> rows_;
  std::vector<Slot> slots_;
  std::size_t used_slots_ = 0;
  std::unordered_map<std::string, std::uint32_t> rows_by_path_;
};

}  // namespace plc::plcopen
