// BodyPlan: what is known of a body before it is written: where labels are, how often and where values are used, and
// which of them may be computed where they are used.
//
// In: a body. Out: answers. Does not belong here: text (expressions.h).
#pragma once

#include <cstdint>
#include <vector>

#include "ir/ir.h"

namespace plc::convert {

class BodyPlan {
 public:
  BodyPlan(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner);

  /// The first instruction that was written: those before it come with declarations (R_EDGE).
  [[nodiscard]] std::uint32_t first() const { return first_; }
  [[nodiscard]] std::uint32_t position_of(std::uint32_t label) const { return labels_[label]; }
  /// True when all jumps to the label are before it.
  [[nodiscard]] bool label_is_known(std::uint32_t label) const { return forward_[label]; }
  [[nodiscard]] std::uint32_t uses(std::uint32_t value) const { return uses_[value]; }
  /// The value is used by nothing, and computing it does nothing.
  [[nodiscard]] bool is_unwanted(std::uint32_t value) const { return uses_[value] == 0 && is_pure(value); }
  /// The value may be written where its use is: it has one, and nothing in between changes what it reads.
  [[nodiscard]] bool is_inline(std::uint32_t value) const { return inline_[value]; }
  /// The store at `inst` sets an input for the run at the result; 0 when it does not.
  [[nodiscard]] std::uint32_t run_of(std::uint32_t inst) const { return run_of_[inst]; }
  /// How many stores, `inst` the first, have this value one after the other; 0 when it is not stored so alone.
  [[nodiscard]] std::uint32_t chain(std::uint32_t inst) const { return chain_[inst]; }
  /// The store is a later one of a chain.
  [[nodiscard]] bool in_chain(std::uint32_t inst) const { return in_chain_[inst]; }
  /// The call that the kEno at `inst` asks about, of those between it and its kClearEvent; kNone: none that can have an
  /// event, kSeveral: more than one.
  static constexpr std::uint32_t kNone = 0xffffffffu;
  static constexpr std::uint32_t kSeveral = 0xfffffffeu;
  [[nodiscard]] std::uint32_t watched(std::uint32_t eno) const { return watched_[eno]; }

 private:
  template <class Visit>
  void each_value(const ir::Inst& inst, const Visit& visit) const;
  template <class Visit>
  void each_value_of(ir::PlaceId place, const Visit& visit) const;
  [[nodiscard]] bool is_input(ir::TypeRef instance, std::uint32_t field) const;
  [[nodiscard]] bool is_pure(std::uint32_t inst) const;
  [[nodiscard]] bool is_counted(std::uint32_t value, int depth) const;
  [[nodiscard]] bool can_move(std::uint32_t i, std::uint32_t use) const;
  [[nodiscard]] bool reads(std::uint32_t value, ir::PlaceId root, int depth) const;
  [[nodiscard]] ir::PlaceId root_of(ir::PlaceId place) const;
  [[nodiscard]] bool place_reads(ir::PlaceId place, ir::PlaceId root, int depth) const;
  void find_labels();
  void find_runs();
  void count_uses();
  void find_chains();
  void find_inline();
  void find_watched();

  const ir::Module& module_;
  const ir::Body& body_;
  std::uint32_t first_ = 0;
  std::vector<std::uint32_t> labels_;
  std::vector<bool> forward_;
  std::vector<std::uint32_t> uses_, last_use_, run_of_, chain_, watched_;
  std::vector<bool> inline_, in_chain_;
  bool has_loops_ = false;  ///< a jump goes back
};

}  // namespace plc::convert
