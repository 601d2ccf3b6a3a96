// Lowering of one instruction list: blocks in order, the accumulator between them, each instruction through the
// lowering of ST. lower_blocks.cpp has the blocks, lower_instructions.cpp what one instruction does.
//
// In: a Listing and its Flow. Out: IR through the Builder. Does not belong here: syntax, labels' names.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "frontend-il/flow.h"
#include "frontend-il/listing.h"
#include "frontend-st/lowering.h"
#include "ir/builder.h"

namespace plc::il {

class Lowering {
 public:
  Lowering(ir::Builder& builder, const st::SourceText& source, Listing& listing, const Flow& flow, bool gives_value)
      : builder_(builder),
        source_(source),
        listing_(listing),
        flow_(flow),
        gives_value_(gives_value),
        st_(builder, source, listing.ast) {}

  /// False when there was an error.
  bool lower_all();
  /// After lower_all(): what is in the accumulator at the end.
  [[nodiscard]] const std::optional<ir::Operand>& result() const { return result_; }

 private:
  using Expected = std::optional<ir::TypeRef>;

  /// What is in the accumulator.
  struct Accumulator {
    enum class State : std::uint8_t {
      kEmpty,   ///< nothing was loaded
      kFailed,  ///< what was to be loaded had an error, or no control comes here
      kValue,
    } state = State::kEmpty;
    ir::Operand value;                    ///< kValue: typed, or a literal that still takes its type
    std::optional<std::uint32_t> called;  ///< where CAL left it as it was, if nothing was loaded since
  };
  /// A block where several ways meet keeps the accumulator in a variable.
  struct Meeting {
    ir::TypeRef type{};         ///< invalid while nobody has come here
    std::uint32_t decided = 0;  ///< where the way ends that decided it
    bool failed = false;
    std::optional<std::uint32_t> called;
  };
  struct Bracket {
    std::uint32_t instruction = 0;
    Accumulator before;
  };

  // lower_blocks.cpp
  void lower_block(BlockId id, bool reached);
  [[nodiscard]] bool meets(BlockId id) const;
  void enter(BlockId id, bool reached);
  void leave(BlockId id, bool reached);
  void deliver(BlockId to, std::uint32_t from);
  ir::TypeRef type_at(BlockId to);
  Expected wanted_type(BlockId block, std::uint32_t instruction);
  Expected type_wanted_by(const Instruction& instruction);
  ir::PlaceId kept(ir::TypeRef type);
  ir::LabelId label(BlockId id);

  // lower_instructions.cpp
  void lower(std::uint32_t index);
  void execute(const Instruction& one, std::uint32_t index);
  void load(const Instruction& one, std::uint32_t index);
  void store(const Instruction& one);
  void set_or_reset(const Instruction& one);
  void negate(std::uint32_t index);
  Expected expected_after(std::uint32_t index, const ir::Operand& accumulator);
  void combine(std::uint32_t index);
  void open_bracket(std::uint32_t index);
  void close_bracket(std::uint32_t index);
  void call(std::uint32_t index);
  void call_function(const Instruction& one, std::uint32_t index);
  void give_input(const Instruction& one, st::NodeId instance);
  void end(const Instruction& one);
  /// The value of the accumulator, which instruction `begin` needs. Nothing, and reported where it is an error of its
  /// own, when there is none.
  std::optional<ir::Operand> needed(std::uint32_t begin);
  std::optional<ir::ValueId> condition(const Instruction& one);
  void set(const std::optional<ir::Operand>& value);
  void fail(core::Code code, std::uint32_t at, std::string message, std::string help = {});
  /// The node of the value `operand`, number `number` of what is given to the lowering of ST.
  st::NodeId given(const Instruction& one, std::uint32_t number, const ir::Operand& operand);
  st::NodeId negated(st::NodeId operand);
  /// The operand of a binary instruction, negated where it says so: what is negated of a literal has the type of the
  /// accumulator. Nothing after an error.
  std::optional<st::NodeId> right_of(const Instruction& one, st::NodeId operand, const ir::Operand& accumulator,
                                     bool literal);
  st::NodeId binary(const Instruction& one, st::NodeId left, st::NodeId right);
  [[nodiscard]] std::string_view word(const Instruction& one) const { return source_.slice(one.begin, one.end); }
  [[nodiscard]] core::SourceRef at(const Instruction& one) const { return source_.locate(one.begin); }
  [[nodiscard]] Expected type_of(const ir::Operand& operand);
  /// The type that a value goes on with where ways meet: without the limits of a subrange, and of strings the usual
  /// one.
  ir::TypeRef plain_type(const ir::Operand& operand);
  ir::TypeTable& types() { return builder_.module().types; }

  ir::Builder& builder_;
  const st::SourceText& source_;
  Listing& listing_;
  const Flow& flow_;
  bool gives_value_;
  st::Lowering st_;
  BlockId block_ = 0;  ///< that is lowered
  Accumulator accumulator_;
  std::vector<Bracket> brackets_;
  std::vector<Accumulator> after_;             ///< by block: the accumulator at its end
  std::vector<Meeting> meetings_;              ///< by block
  std::vector<ir::LabelId> labels_;            ///< by block
  std::map<std::uint32_t, ir::PlaceId> kept_;  ///< by type: the accumulator between blocks
  std::optional<ir::ValueId> jump_condition_;  ///< of the last instruction of the block
  std::optional<ir::Operand> result_;
  bool fine_ = true;
};

}  // namespace plc::il
