#include "bytecode/codegen/body.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "bytecode/codegen/frame.h"
#include "bytecode/codegen/if_conversion.h"
#include "bytecode/codegen/select.h"
#include "bytecode/codegen/wires.h"
#include "bytecode/codegen/writer.h"
#include "core/text.h"

namespace plc::bytecode {

using ir::Inst;
using ir::Op;
using ir::Place;

std::uint32_t Shared::function(const stdlib::Overload& overload) {
  const auto [it, fresh] = functions.try_emplace(&overload, static_cast<std::uint32_t>(image.functions.size()));
  if (fresh) image.functions.push_back(stdlib::key_of(overload));
  return it->second;
}

std::uint32_t Shared::block(ir::TypeRef block_type) {
  const ir::Type& type = module.types[block_type];
  const auto [it, fresh] = blocks.try_emplace(block_type.index, static_cast<std::uint32_t>(image.blocks.size()));
  if (fresh) {
    ImageBlock block;
    block.name = type.block != nullptr ? std::string(type.block->name) : module.pous[type.pou].name;
    block.layout_hash = type.block != nullptr ? stdlib::layout_hash(*type.block) : module.pous[type.pou].taskblock;
    block.type = layout.type(block_type);
    image.blocks.push_back(std::move(block));
  }
  return it->second;
}

namespace {

/// How far a result may be written ahead of the store that takes it.
constexpr std::uint32_t kFuseWindow = 8;

Logic logic_of(Op op) { return op == Op::kAnd ? Logic::kAnd : op == Op::kOr ? Logic::kOr : Logic::kXor; }

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

  bool run() {
    analyse(shared_.module, pou_, body_, analysis_);
    shared_.layout.lay_out_frame(pou_index_, frame_.fields());
    place_words();
    wire_taskblocks();
    connect_queues();
    label_words_.assign(body_.label_count, kUnset);
    initialise_temps();
    for (now_ = 0; now_ < body_.insts.size(); ++now_) {
      const Inst& inst = body_.insts[now_];
      if (!values()[now_].live) continue;
      frame_.advance(now_);
      writer_.source(body_.sources[inst.source]);
      instruction(inst);
    }
    if (pou_.queue_call) call_queue(*pou_.queue_call);
    const std::uint32_t end = writer_.here();
    for (const Patch& patch : patches_) {
      const std::uint32_t target = label_words_[patch.label];
      writer_.patch(patch.word, target == kUnset ? end : target);
    }
    writer_.op(Opcode::kReturn, {});
    return finish();
  }

 private:
  struct Patch {
    std::uint32_t word;
    std::uint32_t label;
  };

  std::vector<ValueInfo>& values() { return analysis_.values; }

  /// Inputs of taskblocks that are read where they come from: their stores are left out.
  void wire_taskblocks() {
    for (const Wire& wire : find_wires(shared_.module, pou_, body_, analysis_)) {
      const ir::TypeRef type = body_.places[wire.block].type;
      const std::uint32_t input = shared_.layout.field_index(type, wire.input);
      out_.wires.push_back({offset_of(place_words_[wire.block]), input, offset_of(place_words_[wire.source])});
      values()[wire.store].live = false;
    }
  }

  void connect_queues() {
    for (const ir::QueuePort& port : pou_.queue_ports) {
      const ir::Type& block = types_[type_of_place(port.instance.index)];
      const ir::Variable& end = shared_.module.pous[block.pou].variables[port.variable];
      out_.queue_ports.push_back(
          {offset_of(place_words_[port.instance.index]), end.name, shared_.queue_of[port.global], end.constant});
    }
  }

  /// The body of a function that was made for a queue: its result and parameter are all its variables.
  void call_queue(const ir::QueueCall& call) {
    const std::uint32_t queue = shared_.queue_of[call.global];
    const auto variable = [&](ir::Role role) {
      const auto found =
          std::find_if(pou_.variables.begin(), pou_.variables.end(), [&](const auto& v) { return v.role == role; });
      const auto index = static_cast<std::size_t>(found - pou_.variables.begin());
      return operand_word(Space::kFrame, shared_.layout.pou(pou_index_).offset[index]);
    };
    const std::uint32_t result = variable(ir::Role::kReturnValue);
    const std::uint32_t type = shared_.image.queues[queue].type;
    switch (call.function) {
      case ir::QueueFunction::kPut:
        writer_.op(Opcode::kQueuePut, {result, queue, variable(ir::Role::kInput), type});
        break;
      case ir::QueueFunction::kGet:
        writer_.op(Opcode::kQueueGet, {result, queue, variable(ir::Role::kOutput), type});
        break;
      case ir::QueueFunction::kCount:
        writer_.op(Opcode::kQueueCount, {result, queue});
        break;
      case ir::QueueFunction::kSpace:
        writer_.op(Opcode::kQueueSpace, {result, queue});
        break;
    }
  }

  // ---- memory -----------------------------------------------------------------------------------------------------

  /// Operand words of all places whose address is known.
  void place_words() {
    place_words_.assign(body_.places.size(), kUnset);
    const PouLayout& layout = shared_.layout.pou(pou_index_);
    for (std::uint32_t p = 0; p < body_.places.size(); ++p) {
      const Place& place = body_.places[p];
      switch (place.kind) {
        case Place::Kind::kGlobal:
          place_words_[p] = operand_word(Space::kGlobal, shared_.global_offset[place.index]);
          break;
        case Place::Kind::kInstance:
          place_words_[p] = operand_word(Space::kInstance, layout.offset[place.index]);
          break;
        case Place::Kind::kFrame:
          place_words_[p] = operand_word(Space::kFrame, layout.offset[place.index]);
          break;
        case Place::Kind::kSelf:
          place_words_[p] = operand_word(Space::kInstance, 0);
          break;
        case Place::Kind::kDeref:
          break;
        case Place::Kind::kField:
          if (is_static(place.parent.index)) {
            const ir::TypeRef parent = body_.places[place.parent.index].type;
            place_words_[p] = place_words_[place.parent.index] + shared_.layout.field_offset(parent, place.index);
          }
          break;
        case Place::Kind::kElement:
          if (is_static(place.parent.index)) {
            place_words_[p] = place_words_[place.parent.index] + place.index * size_of(image_type(place.type));
          }
          break;
        case Place::Kind::kPart:
        case Place::Kind::kCharacter:
        case Place::Kind::kElementAt:
          break;
      }
    }
  }

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
  void move(ir::TypeRef type, std::uint32_t to, std::uint32_t from) {
    if (to == from) return;
    const auto rep = types_.rep_of(type);
    if (rep) {
      writer_.op(move_for(*rep), {to, from});
    } else if (size_of(image_type(type)) != 0) {
      writer_.op(Opcode::kCopy, {to, from, image_type(type)});
    }
  }

  /// VAR_TEMP of programs and function blocks starts anew in every execution. Where actions share it, it lies in the
  /// instance.
  void initialise_temps() {
    if (pou_.kind == ir::PouKind::kFunction) return;
    for (std::uint32_t i = 0; i < pou_.variables.size(); ++i) {
      const ir::Variable& v = pou_.variables[i];
      if (v.role != ir::Role::kTemp) continue;
      const std::uint32_t type = image_type(v.type);
      std::vector<std::byte> bytes(size_of(type));
      shared_.layout.initialise(v, bytes.data());
      writer_.source(v.at);
      move(v.type,
           operand_word(v.in_frame ? Space::kFrame : Space::kInstance, shared_.layout.pou(pou_index_).offset[i]),
           shared_.constants.word(type, bytes));
    }
  }

  bool finish() {
    const bool fits = !frame_.fields().too_large();
    ImageType frame = frame_.fields().finish("");
    out_.frame_initial.assign(frame.size, std::byte{0});
    for (const ImageField& field : frame.fields) {
      shared_.layout.initialise_raw(field.type, out_.frame_initial.data() + field.offset);
    }
    const PouLayout& layout = shared_.layout.pou(pou_index_);
    for (std::uint32_t i = 0; i < pou_.variables.size(); ++i) {
      const ir::Variable& v = pou_.variables[i];
      if (fits && v.in_frame && layout.offset[i] != kNoIndex) {
        std::byte* const to = out_.frame_initial.data() + layout.offset[i];
        std::memset(to, 0, size_of(image_type(v.type)));
        shared_.layout.initialise(v, to);
      }
    }
    shared_.image.types.push_back(std::move(frame));
    out_.frame_type = static_cast<std::uint32_t>(shared_.image.types.size() - 1);
    return fits;
  }

  // ---- values -----------------------------------------------------------------------------------------------------

  /// Operand word of a value that an instruction reads at this point.
  std::uint32_t operand(std::uint32_t value) {
    const Inst& inst = body_.insts[value];
    if (inst.type == ir::kBoolType) return bool_operand(values()[value].literal);
    if (values()[value].word != kUnset) return values()[value].word;
    if (inst.op == Op::kConst) return values()[value].word = shared_.constants.word(body_.constants[inst.a]);
    assert(inst.op == Op::kLoad);
    return place_words_[inst.a];
  }

  /// The operand's word, and its bytes in a place of exactly `type` (values of a subrange are kept as their base).
  std::uint32_t operand_as(std::uint32_t value, ir::TypeRef type) {
    const std::uint32_t word = operand(value);
    const ValueInfo& info = values()[value];
    const bool taken_over = info.word != kUnset && !is_logic(body_.insts[value].op) && info.link != kUnset;
    const ir::TypeRef own = taken_over ? type_of_place(body_.insts[info.link].a) : body_.insts[value].type;
    if (own == type) return word;
    const std::uint32_t copy = intermediate_of(image_type(type), now_);
    move(type, copy, word);
    return copy;
  }

  /// Where value `now_` is written: into the variable of a store that follows at once, or into an intermediate.
  std::uint32_t destination(bool exact_type) {
    ValueInfo& v = values()[now_];
    const ir::TypeRef type = body_.insts[now_].type;
    const std::uint32_t store = v.uses == 0 ? kUnset : takeover(exact_type);
    if (store == kUnset) {
      v.word = intermediate_of(image_type(type), lifetime(now_));
    } else {
      v.word = place_words_[body_.insts[store].a];
      v.link = store;
      v.hazard = values()[store].hazard;
    }
    return v.word;
  }

  /// The store that may be done by writing value `now_` into its variable already here, or kUnset.
  std::uint32_t takeover(bool exact_type) {
    const ValueInfo& v = values()[now_];
    const std::uint32_t s = v.first_use;
    if (s - now_ > kFuseWindow || body_.insts[s].op != Op::kStore) return kUnset;
    const Inst& store = body_.insts[s];
    if (store.b != now_ || !is_static(store.a)) return kUnset;
    const ir::TypeRef from = body_.insts[now_].type;
    const ir::TypeRef to = type_of_place(store.a);
    if (from != to && (exact_type || types_.rep_of(from) != types_.rep_of(to))) return kUnset;
    if (v.uses > 1 && (from != to || v.pinned || v.last_use > values()[s].hazard)) return kUnset;
    const std::uint32_t root = analysis_.places[store.a].root;
    for (std::uint32_t i = now_ + 1; i < s; ++i) {
      const Inst& between = body_.insts[i];
      const bool harmless = between.op == Op::kConst || (between.op == Op::kLoad && is_static(between.a) &&
                                                         analysis_.places[between.a].root != root);
      if (!harmless) return kUnset;
    }
    return s;
  }

  // ---- BOOL logic -------------------------------------------------------------------------------------------------

  std::uint32_t intermediate(const Piece& piece) override {
    const std::uint32_t word = intermediate_of(image_type(ir::kBoolType), cone_lifetime_);
    writer_.record(word, piece);
    return word;
  }

  /// Last instruction at whose place the literal may be read.
  std::uint32_t hazard_of(Literal literal) {
    return is_constant(literal) ? kUnset : values()[value_of(literal)].hazard;
  }

  /// The literal as part of a larger cone or record. `last` when no later instruction uses it.
  ConeArena::Operand take(Literal literal) {
    ConeArena::Operand operand;
    const std::uint32_t v = value_of(literal);
    ValueInfo& info = values()[v];
    if (info.word == kUnset && info.link != kUnset && is_logic(body_.insts[v].op)) {
      operand.inverted = is_inverted(literal);
      if (info.uses > 1) {
        --info.uses;
        operand.cone = arena_.copy(info.link);
      } else {
        operand.cone = std::exchange(info.link, kUnset);
      }
      return operand;
    }
    const std::uint32_t word = info.word != kUnset ? info.word : place_words_[body_.insts[v].a];
    operand.piece = leaf_piece(word, is_inverted(literal));
    return operand;
  }

  /// The literal as the contents of one record; intermediate values on the way live until `last`.
  Piece piece_of(Literal literal, std::uint32_t last) {
    if (is_constant(literal)) return constant_piece(literal == kTrueLiteral);
    cone_lifetime_ = last;
    const ConeArena::Operand operand = take(literal);
    if (operand.cone == ConeArena::kNone) return operand.piece;
    const Piece piece = arena_.close(operand.cone, *this);
    return operand.inverted ? inverted_piece(piece) : piece;
  }

  /// Word of a BOOL that an instruction other than a record reads.
  std::uint32_t bool_operand(Literal literal) {
    if (is_constant(literal)) {
      ir::Constant constant;
      constant.type = ir::kBoolType;
      constant.bits = literal == kTrueLiteral ? 1 : 0;
      return shared_.constants.word(constant);
    }
    const std::uint32_t v = value_of(literal);
    const ValueInfo& info = values()[v];
    if (!is_inverted(literal)) {
      if (info.word != kUnset) return info.word;
      if (!is_logic(body_.insts[v].op)) return place_words_[body_.insts[v].a];
    }
    const Piece piece = piece_of(literal, now_);
    cone_lifetime_ = now_;
    return intermediate(piece);
  }

  void logic(const Inst& inst) {
    ValueInfo& v = values()[now_];
    if (v.literal != now_ * 2) return;  // another name of an operand
    const Literal a = values()[inst.a].literal;
    const Literal b = values()[inst.b].literal;
    v.hazard = std::min(hazard_of(a), hazard_of(b));
    cone_lifetime_ = lifetime(now_);
    const ConeArena::Operand left = take(a);
    const ConeArena::Operand right = take(b);
    v.link = arena_.combine(logic_of(inst.op), left, right, *this);
    const bool shared = v.uses > 1 && v.root_leaves > kRecordInputs;
    if (!shared && v.last_use <= v.hazard) return;
    if (stored_first(v)) {
      v.store_first = true;
      return;
    }
    locate(now_);
  }

  /// True when the first use of the value is a store whose variable holds it for all later uses.
  bool stored_first(const ValueInfo& v) {
    const Inst& store = body_.insts[v.first_use];
    if (v.uses < 2 || store.op != Op::kStore || !is_static(store.a) || v.first_use > v.hazard) return false;
    return values()[store.b].literal == now_ * 2 && !v.crosses_label && v.last_use <= values()[v.first_use].hazard;
  }

  /// Evaluates the logic value `v` here, into a place of its own.
  void locate(std::uint32_t v) {
    ValueInfo& info = values()[v];
    cone_lifetime_ = now_;
    const Piece piece = arena_.close(std::exchange(info.link, kUnset), *this);
    info.word = intermediate_of(image_type(ir::kBoolType), lifetime(v));
    info.hazard = kUnset;
    writer_.record(info.word, piece);
  }

  void store_bool(const Inst& inst) {
    const std::uint32_t to = place_words_[inst.a];
    const Literal literal = values()[inst.b].literal;
    if (!is_constant(literal)) {
      ValueInfo& v = values()[value_of(literal)];
      if (v.store_first && v.first_use == now_) {
        v.uses = 1;  // the later uses read the variable
        writer_.record(to, piece_of(literal, now_));
        v.word = to;
        v.hazard = values()[now_].hazard;
        return;
      }
    }
    const Piece piece = piece_of(literal, now_);
    if (piece.count == 1 && piece.leaf[0] == to && piece.table == leaf_piece(to, false).table) return;
    writer_.record(to, piece);
  }

  // ---- parts of values that only the running program can find ------------------------------------------------------

  /// How an instruction reaches a place: its path from a place of known address, or from what a reference refers to.
  struct Access {
    bool via = false;
    std::uint32_t base = 0;  ///< operand: the place, or the reference
    std::uint32_t type = 0;  ///< image type where the path starts
    std::vector<std::uint32_t> path;
    [[nodiscard]] std::uint32_t items() const { return static_cast<std::uint32_t>(path.size()) / kPathWords; }
    /// The member of a family of instructions.
    [[nodiscard]] Opcode pick(Opcode at_place, Opcode via_reference) const { return via ? via_reference : at_place; }
  };

  Access access(std::uint32_t place) {
    Access found;
    std::vector<std::uint32_t> steps;
    ir::PlaceId at{place};
    for (; !is_static(at.index) && body_.places[at.index].parent.valid(); at = body_.places[at.index].parent) {
      steps.push_back(at.index);
    }
    found.via = !is_static(at.index);
    found.base = found.via ? operand(body_.places[at.index].index) : place_words_[at.index];
    found.type = image_type(type_of_place(at.index));
    const auto step = [&](PathStep kind, std::uint32_t number) {
      found.path.push_back(static_cast<std::uint32_t>(kind));
      found.path.push_back(number);
    };
    for (; !steps.empty(); steps.pop_back()) {
      const Place& to = body_.places[steps.back()];
      const ir::TypeRef from = type_of_place(to.parent.index);
      if (to.kind == Place::Kind::kField) {
        step(PathStep::kField, shared_.layout.field_index(from, to.index));
      } else if (const auto element = known_element(to)) {
        step(PathStep::kElement, *element);
      } else {
        step(PathStep::kIndex, operand(to.index));
      }
    }
    return found;
  }

  /// Number of the element, from 0, when it is known and inside the bounds.
  std::optional<std::uint32_t> known_element(const Place& place) {
    if (place.kind == Place::Kind::kElement) return place.index;
    const Inst& index = body_.insts[place.index];
    if (index.op != Op::kConst) return std::nullopt;
    const ir::Type& array = types_[type_of_place(place.parent.index)];
    const core::Rep rep = types_.rep_of(index.type).value_or(core::Rep::kI64);
    const std::uint64_t bits = body_.constants[index.a].bits;
    const unsigned shift = 64 - core::rep_bytes(rep) * 8;
    const bool is_signed = rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32;
    const auto value = is_signed ? static_cast<std::int64_t>(bits << shift) >> shift : static_cast<std::int64_t>(bits);
    if (value < array.lower || value > array.upper || (rep == core::Rep::kU64 && value < 0)) return std::nullopt;
    return static_cast<std::uint32_t>(value - array.lower);
  }

  void access_op(Opcode opcode, std::initializer_list<std::uint32_t> words, const Access& access) {
    writer_.op(opcode, words, access.path, access.items());
  }
  void load_part(std::uint32_t to, const Access& from) {
    access_op(from.pick(Opcode::kLoadAt, Opcode::kLoadVia), {to, from.base, from.type}, from);
  }
  void store_part(const Access& to, std::uint32_t from) {
    access_op(to.pick(Opcode::kStoreAt, Opcode::kStoreVia), {to.base, from, to.type}, to);
  }

  void make_ref(const Inst& inst) {
    const Access place = access(inst.a);
    if (place.via && place.path.empty()) {
      move(inst.type, destination(true), place.base);
    } else {
      access_op(place.pick(Opcode::kRefAt, Opcode::kRefVia), {destination(true), place.base, place.type}, place);
    }
  }

  // ---- instructions -----------------------------------------------------------------------------------------------

  void instruction(const Inst& inst) {
    switch (inst.op) {
      case Op::kConst:
      case Op::kNot:
        break;
      case Op::kLoad:
        load(inst);
        break;
      case Op::kStore:
        store(inst);
        break;
      case Op::kCopy:
        copy(inst);
        break;
      case Op::kAnd:
      case Op::kOr:
      case Op::kXor:
        logic(inst);
        break;
      case Op::kCall:
        call(inst);
        break;
      case Op::kCallPou:
        call_pou(inst);
        break;
      case Op::kRun:
        run_block(inst);
        break;
      case Op::kLabel:
        label_words_[inst.a] = writer_.here();
        break;
      case Op::kJump:
        jump(inst.a);
        break;
      case Op::kJumpIf:
        jump_unless(values()[inst.b].literal ^ 1u, inst.a);
        break;
      case Op::kJumpIfNot:
        jump_unless(values()[inst.b].literal, inst.a);
        break;
      case Op::kReturn:
        writer_.op(Opcode::kReturn, {});
        break;
      case Op::kClearEvent:
        writer_.op(Opcode::kClearEvent, {});
        break;
      case Op::kEno:
        writer_.op(Opcode::kEno, {destination(false)});
        break;
      case Op::kMakeRef:
        make_ref(inst);
        break;
      case Op::kExtract: {
        const std::uint32_t word = operand(inst.a);
        writer_.op(Opcode::kExtract, {destination(false), word, inst.b});
        break;
      }
      case Op::kInsert: {
        const std::uint32_t word = operand(inst.a);
        const std::uint32_t part = operand(inst.b);
        writer_.op(Opcode::kInsert, {destination(false), word, part, inst.count});
        break;
      }
      case Op::kSameRef: {
        const std::uint32_t a = operand(inst.a);
        const std::uint32_t b = operand(inst.b);
        writer_.op(Opcode::kSameRef, {destination(false), a, b});
        break;
      }
      case Op::kRange:
        range(inst);
        break;
    }
  }

  void load(const Inst& inst) {
    ValueInfo& v = values()[now_];
    if (!is_static(inst.a)) {
      const Access from = access(inst.a);
      load_part(destination(!types_.rep_of(inst.type)), from);
      return;
    }
    if (v.last_use <= v.hazard) return;  // read where it is used
    v.word = intermediate_of(image_type(inst.type), lifetime(now_));
    v.hazard = kUnset;
    if (inst.type == ir::kBoolType) {
      writer_.record(v.word, leaf_piece(place_words_[inst.a], false));
    } else {
      move(inst.type, v.word, place_words_[inst.a]);
    }
  }

  void store(const Inst& inst) {
    const ValueInfo& v = values()[inst.b];
    const bool logic_value = is_logic(body_.insts[inst.b].op) || body_.insts[inst.b].op == Op::kNot;
    if (!logic_value && v.link == now_) return;  // written by the instruction that made the value
    const ir::TypeRef type = type_of_place(inst.a);
    if (!is_static(inst.a)) {
      const Access to = access(inst.a);
      store_part(to, types_.rep_of(type) ? operand(inst.b) : operand_as(inst.b, type));
      return;
    }
    if (type == ir::kBoolType) {
      store_bool(inst);
    } else {
      move(type, place_words_[inst.a], operand(inst.b));
    }
  }

  void copy(const Inst& inst) {
    const ir::TypeRef type = type_of_place(inst.a);
    std::uint32_t from = 0;
    if (is_static(inst.b)) {
      from = place_words_[inst.b];
    } else {
      from = is_static(inst.a) ? place_words_[inst.a] : intermediate_of(image_type(type), now_);
      load_part(from, access(inst.b));
    }
    if (is_static(inst.a)) {
      move(type, place_words_[inst.a], from);
    } else {
      store_part(access(inst.a), from);
    }
  }

  void range(const Inst& inst) {
    const ir::Type& limits = types_[inst.type];
    const auto bound = [&](std::int64_t value) {
      ir::Constant constant;
      constant.type = ir::ref_of(limits.elementary);
      constant.bits = static_cast<std::uint64_t>(value);
      return shared_.constants.word(constant);
    };
    const std::uint32_t value = operand(inst.a);
    const std::uint32_t lower = bound(limits.lower);
    const std::uint32_t upper = bound(limits.upper);
    writer_.op(range_for(core::rep_of(limits.elementary)), {destination(false), value, lower, upper});
  }

  void call(const Inst& inst) {
    const stdlib::Overload& overload = *body_.functions[inst.a];
    std::vector<std::uint32_t> list(1);
    for (std::uint32_t k = 0; k < inst.count; ++k) list.push_back(operand(body_.args[inst.b + k].index));
    const std::optional<Opcode> opcode = inst.count >= 2 ? opcode_for(overload) : std::nullopt;
    const bool chained = opcode && inst.count > 2 && overload.result_type() == overload.param_type(0);
    if (opcode && inst.count == 2) {
      writer_.op(*opcode, {destination(false), list[1], list[2]});
    } else if (chained) {
      // The running result stays out of the destination: a later argument may be that variable.
      std::uint32_t sum = list[1];
      for (std::uint32_t k = 2; k < inst.count; ++k) {
        const std::uint32_t next = intermediate_of(image_type(inst.type), now_);
        writer_.op(*opcode, {next, sum, list[k]});
        sum = next;
      }
      writer_.op(*opcode, {destination(false), sum, list[inst.count]});
    } else {
      list[0] = destination(false);
      writer_.op(Opcode::kCallStd, {shared_.function(overload)}, list, static_cast<std::uint32_t>(list.size()));
    }
  }

  void call_pou(const Inst& inst) {
    const PouLayout& callee = shared_.layout.pou(inst.a);
    const std::vector<ir::Variable>& variables = shared_.module.pous[inst.a].variables;
    std::vector<std::uint32_t> list;
    struct Late {
      std::uint32_t place, word;
    };
    std::vector<Late> late;
    for (std::uint32_t k = 0; k < inst.count; ++k) {
      const ir::CallArg& arg = body_.call_args[inst.b + k];
      const ir::TypeRef type = variables[arg.variable].type;
      std::uint32_t word = 0;
      if (arg.kind != ir::CallArg::Kind::kOutput) {
        word = types_.rep_of(type) ? operand(arg.value.index) : operand_as(arg.value.index, type);
      } else if (is_static(arg.place.index)) {
        word = place_words_[arg.place.index];
      } else {
        word = intermediate_of(image_type(type_of_place(arg.place.index)), now_);
        late.push_back({arg.place.index, word});
      }
      list.push_back(callee.field[arg.variable]);
      list.push_back(word);
    }
    if (values()[now_].uses != 0) {
      const auto result = std::find_if(variables.begin(), variables.end(),
                                       [](const ir::Variable& v) { return v.role == ir::Role::kReturnValue; });
      assert(result != variables.end());
      list.push_back(callee.field[static_cast<std::size_t>(result - variables.begin())]);
      list.push_back(destination(false));
    }
    writer_.op(Opcode::kCallFn, {shared_.image_pou[inst.a]}, list, static_cast<std::uint32_t>(list.size() / 2));
    for (const Late& l : late) {
      store_part(access(l.place), l.word);
    }
  }

  void run_block(const Inst& inst) {
    const auto executed = shared_.module.pou_run_by(body_, inst);
    const bool pou = executed && shared_.module.pous[*executed].taskblock == 0;
    const std::uint32_t what = pou ? shared_.image_pou[*executed] : shared_.block(type_of_place(inst.a));
    if (is_static(inst.a)) {
      writer_.op(pou ? Opcode::kCallPou : Opcode::kRunTb, {what, place_words_[inst.a]});
    } else {
      const Access instance = access(inst.a);
      const Opcode opcode =
          pou ? instance.pick(Opcode::kCallAt, Opcode::kCallVia) : instance.pick(Opcode::kRunAt, Opcode::kRunVia);
      access_op(opcode, {what, instance.base, instance.type}, instance);
    }
  }

  // ---- jumps ------------------------------------------------------------------------------------------------------

  void jump(std::uint32_t label) {
    if (label_words_[label] != kUnset) {
      writer_.op(Opcode::kLoopJump, {label_words_[label]});
      return;
    }
    writer_.op(Opcode::kJump, {0});
    patches_.push_back({writer_.last_word(), label});
  }

  /// Goes to `label` when the literal is FALSE.
  void jump_unless(Literal condition, std::uint32_t label) {
    if (condition == kTrueLiteral) return;
    if (condition == kFalseLiteral) {
      jump(label);
      return;
    }
    if (label_words_[label] == kUnset) {
      patches_.push_back({forward_jump(condition), label});
      return;
    }
    // Conditional jumps go forward: step over the jump back.
    const std::uint32_t over = forward_jump(condition ^ 1u);
    writer_.op(Opcode::kLoopJump, {label_words_[label]});
    writer_.patch(over, writer_.here());
  }
  /// A jump forward when the literal is FALSE; returns the word that takes its target. A value that has a place is
  /// tested as it is, rather than negated into another place.
  std::uint32_t forward_jump(Literal condition) {
    const std::uint32_t v = value_of(condition);
    const bool as_it_is = is_inverted(condition) && (values()[v].word != kUnset || !is_logic(body_.insts[v].op));
    const std::uint32_t word = bool_operand(as_it_is ? condition ^ 1u : condition);
    writer_.op(as_it_is ? Opcode::kJumpIf : Opcode::kCondJump, {word, 0});
    return writer_.last_word();
  }

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
  std::vector<std::uint32_t> place_words_;  ///< by place, kUnset for those behind references
  std::vector<std::uint32_t> label_words_;
  std::vector<Patch> patches_;
};

}  // namespace

bool generate_body(Shared& shared, std::uint32_t pou, ImagePou& out) { return BodyGenerator(shared, pou, out).run(); }

}  // namespace plc::bytecode
