// BodyGenerator: code of one POU while it is made. body.cpp has the order and memory, body_logic.cpp values and boolean
// logic, body_instructions.cpp the other instructions.
//
// In: a POU, the tables shared by all bodies. Out: an ImagePou. Does not belong here: analyses of the body
// (analysis.h), frames (frame.h), look-up tables (boolean_map.h).
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "bytecode/codegen/body.h"
#include "bytecode/codegen/boolean_map.h"
#include "bytecode/codegen/frame.h"
#include "bytecode/codegen/if_conversion.h"
#include "bytecode/codegen/probe_notes.h"
#include "bytecode/codegen/writer.h"

namespace plc::bytecode {

using ir::Inst;
using ir::Op;
using ir::Place;

/// How far a result may be written ahead of the store that takes it.
inline constexpr std::uint32_t kFuseWindow = 8;

inline Logic logic_of(Op op) { return op == Op::kAnd ? Logic::kAnd : op == Op::kOr ? Logic::kOr : Logic::kXor; }

class BodyGenerator final : private RecordSink {
 public:
  BodyGenerator(Shared& shared, std::uint32_t pou, ImagePou& out)
      : shared_(shared),
        pou_index_(pou),
        pou_(shared.module.pous[pou]),
        converted_(convert_ifs(pou_.body)),
        body_(converted_ ? *converted_ : pou_.body),
        types_(shared.module.types),
        analysis_(shared.analysis),
        out_(out),
        frame_(shared.image),
        writer_(out.code, out.debug) {}

  bool run();
  /// After run(): the probe map, when the module notes probes.
  PouProbes take_probes() { return notes_ ? notes_->take() : PouProbes{}; }

 private:
  struct Patch {
    std::uint32_t word;
    std::uint32_t label;
  };

  std::vector<ValueInfo>& values() { return analysis_.values; }

  /// Inputs of taskblocks that are read where they come from: their stores are left out.
  void wire_taskblocks();

  void connect_queues();

  /// The body of a function that was made for a queue: its result and parameter are all its variables.
  void call_queue(const ir::QueueCall& call);

  // ---- memory -----------------------------------------------------------------------------------------------------

  /// Operand words of all places whose address is known.
  void place_words();

  bool is_static(std::uint32_t place) const { return analysis_.places[place].is_static(); }
  std::uint32_t image_type(ir::TypeRef type) { return shared_.layout.type(type); }
  std::uint32_t size_of(std::uint32_t type) const { return shared_.image.types[type].size; }
  ir::TypeRef type_of_place(std::uint32_t place) const { return body_.places[place].type; }

  std::uint32_t intermediate_of(std::uint32_t type, std::uint32_t last) { return frame_.intermediate(type, last); }
  /// Until when the own place of value `v` is needed.
  std::uint32_t lifetime(std::uint32_t v) {
    const ValueInfo& info = values()[v];
    return info.pinned ? kUnset : std::max(info.evaluated, now_);
  }

  /// Copies the bytes of a scalar, string, reference or aggregate of `type`.
  void move(ir::TypeRef type, std::uint32_t to, std::uint32_t from);

  /// VAR_TEMP of programs and function blocks starts anew in every execution. Where actions share it, it lies in the
  /// instance.
  void initialise_temps();

  bool finish();

  // ---- values -----------------------------------------------------------------------------------------------------

  /// Operand word of a value that an instruction reads at this point.
  std::uint32_t operand(std::uint32_t value);

  /// The operand's word, and its bytes in a place of exactly `type` (values of a subrange are kept as their base).
  std::uint32_t operand_as(std::uint32_t value, ir::TypeRef type);

  /// Where value `now_` is written: into the variable of a store that follows at once, or into an intermediate.
  std::uint32_t destination(bool exact_type);

  /// The store that may be done by writing value `now_` into its variable already here, or kUnset.
  std::uint32_t takeover(bool exact_type);

  // ---- BOOL logic -------------------------------------------------------------------------------------------------

  std::uint32_t intermediate(const Piece& piece) override;

  /// Last instruction at whose place the literal may be read.
  std::uint32_t hazard_of(Literal literal) {
    return is_constant(literal) ? kUnset : values()[value_of(literal)].hazard;
  }

  /// The literal as part of a larger cone or record. `last` when no later instruction uses it.
  ConeArena::Operand take(Literal literal);

  /// The literal as the contents of one record; intermediate values on the way live until `last`.
  Piece piece_of(Literal literal, std::uint32_t last);

  /// Word of a BOOL that an instruction other than a record reads.
  std::uint32_t bool_operand(Literal literal);

  void logic(const Inst& inst);

  /// True when the first use of the value is a store whose variable holds it for all later uses.
  bool stored_first(const ValueInfo& v);

  /// Evaluates the logic value `v` here, into a place of its own.
  void locate(std::uint32_t v);

  void store_bool(const Inst& inst);

  // ---- parts of values that only the running program can find ------------------------------------------------------

  /// How an instruction reaches a place: its path from a place of known address, or from what a reference or a pointer
  /// leads to.
  struct Access {
    enum class From : std::uint8_t { kPlace, kReference, kPointer } from = From::kPlace;
    std::uint32_t base = 0;  ///< operand: the place, the reference or the pointer
    std::uint32_t type = 0;  ///< image type where the path starts
    std::vector<std::uint32_t> path;
    [[nodiscard]] std::uint32_t items() const { return static_cast<std::uint32_t>(path.size()) / kPathWords; }
    /// The member of a family of instructions.
    [[nodiscard]] Opcode pick(Opcode at_place, Opcode via_reference, Opcode through_pointer) const {
      return from == From::kPlace ? at_place : from == From::kReference ? via_reference : through_pointer;
    }
  };

  Access access(std::uint32_t place);

  /// Number of the element, from 0, when it is known and inside the bounds.
  std::optional<std::uint32_t> known_element(const Place& place);

  void access_op(Opcode opcode, std::initializer_list<std::uint32_t> words, const Access& access) {
    writer_.op(opcode, words, access.path, access.items());
  }
  void load_part(std::uint32_t to, const Access& from) {
    access_op(from.pick(Opcode::kLoadAt, Opcode::kLoadVia, Opcode::kLoadPtr), {to, from.base, from.type}, from);
  }
  void store_part(const Access& to, std::uint32_t from) {
    access_op(to.pick(Opcode::kStoreAt, Opcode::kStoreVia, Opcode::kStorePtr), {to.base, from, to.type}, to);
  }

  void make_ref(const Inst& inst);

  void take_address(const Inst& inst);

  // ---- instructions -----------------------------------------------------------------------------------------------

  void instruction(const Inst& inst);

  void load(const Inst& inst);

  void store(const Inst& inst);

  void copy(const Inst& inst);

  void range(const Inst& inst);

  void call(const Inst& inst);

  void call_pou(const Inst& inst);

  void run_block(const Inst& inst);

  // ---- jumps ------------------------------------------------------------------------------------------------------

  void jump(std::uint32_t label);
  [[nodiscard]] std::uint32_t here() const { return static_cast<std::uint32_t>(out_.code.size()); }
  /// The instruction written last, which began at `word`, jumps to the label.
  void note_jump(std::uint32_t word, std::uint32_t label) {
    if (notes_) notes_->jump(word, label);
  }

  /// Goes to `label` when the literal is FALSE.
  void jump_unless(Literal condition, std::uint32_t label);
  /// A jump forward when the literal is FALSE; returns the word that takes its target. A value that has a place is
  /// tested as it is, rather than negated into another place.
  std::uint32_t forward_jump(Literal condition);

  Shared& shared_;
  std::uint32_t pou_index_;
  const ir::Pou& pou_;
  const std::optional<ir::Body> converted_;  ///< if_conversion.h
  const ir::Body& body_;
  const ir::TypeTable& types_;
  Analysis& analysis_;
  ImagePou& out_;
  Frame frame_;
  CodeWriter writer_;
  ConeArena arena_;
  std::uint32_t now_ = 0;
  std::uint32_t cone_lifetime_ = 0;
  std::vector<std::uint32_t> place_words_;  ///< by place, kUnset for those reached through references
  std::vector<std::uint32_t> label_words_;
  std::vector<Patch> patches_;
  std::optional<ProbeNotes> notes_;  ///< nothing when nobody may look
};

}  // namespace plc::bytecode
