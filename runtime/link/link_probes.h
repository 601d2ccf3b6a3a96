// Where the linker puts the probes of a POU that somebody looks at: PROBE instructions at words of its code.
//
// In: the probe map of the POU. Out: groups of steps by word, where jumps to a word go. Does not belong here: resolved
// code (link.h), executing steps (runtime/probes.h).
#pragma once

#include <cstdint>
#include <vector>

#include "bytecode/probes.h"

namespace plc::runtime {

class LinkProbes {
 public:
  /// `map`: null when nobody looks. `number`: of the POU in Probes.
  LinkProbes(const bytecode::PouProbes* map, std::uint32_t number) : map_(map), number_(number) {}
  [[nodiscard]] bool any() const { return map_ != nullptr; }
  [[nodiscard]] std::uint32_t number() const { return number_; }
  /// True when steps come before what begins at `word`, which is not before those that were asked for.
  [[nodiscard]] bool at(std::uint32_t word) const {
    return map_ != nullptr && next_ < map_->steps.size() && map_->steps[next_].word == word;
  }
  /// Calls put(first, end) for each group of steps at `word`, which appends to `stream`, and notes where it begins.
  template <class Put>
  void place(std::uint32_t word, const std::vector<std::uint32_t>& stream, Put put) {
    const auto position = [&stream] { return static_cast<std::uint32_t>(stream.size()); };
    if (!at(word)) return;
    while (at(word)) {
      const std::uint32_t first = next_;
      const std::uint32_t order = map_->steps[first].order;
      while (at(word) && map_->steps[next_].order == order) ++next_;
      groups_.push_back({word, order, position()});
      put(first, next_);
    }
    groups_.push_back({word, kAfterAll, position()});
  }
  /// The first step that the jump at `word` executes at the word it goes to.
  [[nodiscard]] std::uint32_t order_of_jump(std::uint32_t word) const;
  /// Where in the resolved code a jump to `word` goes; `otherwise` when all steps there are executed, or there is none.
  [[nodiscard]] std::uint32_t target(std::uint32_t word, std::uint32_t order, std::uint32_t otherwise) const;

 private:
  static constexpr std::uint32_t kAfterAll = 0xffffffffu;
  struct Group {
    std::uint32_t word = 0, order = 0, position = 0;
  };
  const bytecode::PouProbes* map_;
  std::uint32_t number_;
  std::uint32_t next_ = 0;
  std::vector<Group> groups_;
};

}  // namespace plc::runtime
