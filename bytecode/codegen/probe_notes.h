// ProbeNotes: writes the probe map of a body while its code is made.
//
// In: the probes that front ends noted, and for each instruction of the IR, also those without code, where the code
// was before and after it. Out: PouProbes. It rests on this: at the code word where instruction i begins, each variable
// has the value that a load at i gives, since no store comes later in the code than in the IR, and none that comes
// earlier is seen in between. So a load is a capture of its variable at that word, whatever its value became; logic is
// computed from captures; anything else is where its instruction wrote it, straight after that. Does not belong here:
// what is noted (ir/probes.h), code.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bytecode/codegen/analysis.h"
#include "bytecode/codegen/layout.h"
#include "bytecode/probes.h"
#include "ir/ir.h"

namespace plc::bytecode {

class ProbeNotes {
 public:
  /// `place_words`: operand words by place, kUnset where only the running program finds it. All outlive this.
  ProbeNotes(const ir::TypeTable& types, const ir::Body& body, const Analysis& analysis,
             const std::vector<std::uint32_t>& place_words, const Layout& layout);

  /// Code of instruction `i` begins at `word`; i = their number: the end of the body.
  void begin(std::uint32_t i, std::uint32_t word);
  /// It has ended before `word`.
  void end(std::uint32_t i, std::uint32_t word);
  /// The label is bound at `word`.
  void label(std::uint32_t label, std::uint32_t word);
  /// The jump at `word` goes to the label, perhaps one that comes later.
  void jump(std::uint32_t word, std::uint32_t label) { jumps_.emplace_back(word, label); }
  PouProbes take();

 private:
  [[nodiscard]] std::optional<Literal> same_as(std::uint32_t value) const;
  [[nodiscard]] bool is_shown(ir::TypeRef type) const;
  void want(ir::ValueId value);
  void move_to(std::uint32_t word);
  std::uint32_t add(ProbeOp op, std::uint32_t a, std::uint32_t b, std::uint32_t type, std::uint32_t when);
  std::uint32_t capture(std::uint32_t operand, ir::TypeRef type, std::uint32_t when);
  std::uint32_t constant(const ir::Inst& inst, std::uint32_t value, std::uint32_t when);
  [[nodiscard]] std::uint32_t when_of(std::uint32_t value) const;

  const ir::TypeTable& types_;
  const ir::Body& body_;
  const Analysis& analysis_;
  const std::vector<std::uint32_t>& place_words_;
  const Layout& layout_;
  PouProbes map_;
  std::vector<std::uint8_t> wanted_;        ///< by value
  std::vector<std::uint32_t> when_;         ///< by value: the BOOL that says whether it is computed, or kUnset
  std::vector<std::uint32_t> step_;         ///< by value, and by probe that has none
  std::vector<std::uint32_t> by_position_;  ///< probes without a value, in the order of their positions
  std::vector<std::uint32_t> probe_step_;   ///< by probe
  std::size_t next_ = 0;                    ///< into by_position_
  std::uint32_t word_ = 0, order_ = 0;
  bool since_label_ = false;                                    ///< a step was added since the last label at this word
  std::vector<std::uint32_t> label_order_;                      ///< by label
  std::vector<std::pair<std::uint32_t, std::uint32_t>> jumps_;  ///< word, label
  std::vector<std::pair<std::uint32_t, std::uint32_t>> texts_;  ///< step of a constant text, its value
};

}  // namespace plc::bytecode
