// Frame: variables of the frame first, then intermediate values, whose slots are reused by type after their last use.
#pragma once

#include <cstdint>
#include <queue>
#include <unordered_map>
#include <vector>

#include "bytecode/codegen/layout.h"

namespace plc::bytecode {

class Frame {
 public:
  explicit Frame(Image& image) : image_(image) {}

  StructBuilder& fields() { return fields_; }
  /// A slot of `type` that stays taken up to and including instruction `last`.
  std::uint32_t intermediate(std::uint32_t type, std::uint32_t last);
  /// Frees what was taken up to instructions before `now`.
  void advance(std::uint32_t now) {
    while (!taken_.empty() && taken_.top().last < now) {
      free_[taken_.top().type].push_back(taken_.top().word);
      taken_.pop();
    }
  }

 private:
  struct Slot {
    std::uint32_t last, type, word;
    friend bool operator<(const Slot& a, const Slot& b) { return a.last > b.last; }
  };
  Image& image_;
  StructBuilder fields_;
  std::priority_queue<Slot> taken_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> free_;
  std::uint32_t count_ = 0;
};

}  // namespace plc::bytecode
