#include "bytecode/codegen/body.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "bytecode/codegen/body_generator.h"
#include "bytecode/codegen/select.h"
#include "bytecode/codegen/wires.h"

namespace plc::bytecode {

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

bool BodyGenerator::run() {
  analyse(shared_.module, pou_, body_, analysis_);
  shared_.layout.lay_out_frame(pou_index_, frame_.fields());
  place_words();
  wire_taskblocks();
  connect_queues();
  label_words_.assign(body_.label_count, kUnset);
  initialise_temps();
  if (!body_.probes.empty()) notes_.emplace(types_, body_, analysis_, place_words_, shared_.layout);
  for (now_ = 0; now_ < body_.insts.size(); ++now_) {
    const Inst& inst = body_.insts[now_];
    if (notes_) notes_->begin(now_, here());
    if (values()[now_].live) {
      frame_.advance(now_);
      writer_.source(body_.sources[inst.source]);
      instruction(inst);
    }
    if (notes_) notes_->end(now_, here());
  }
  if (notes_) notes_->begin(now_, here());
  if (pou_.queue_call) call_queue(*pou_.queue_call);
  const std::uint32_t end = writer_.here();
  for (const Patch& patch : patches_) {
    const std::uint32_t target = label_words_[patch.label];
    writer_.patch(patch.word, target == kUnset ? end : target);
  }
  writer_.op(Opcode::kReturn, {});
  return finish();
}

void BodyGenerator::wire_taskblocks() {
  for (const Wire& wire : find_wires(shared_.module, pou_, body_, analysis_)) {
    const ir::TypeRef type = body_.places[wire.block].type;
    const std::uint32_t input = shared_.layout.field_index(type, wire.input);
    out_.wires.push_back({offset_of(place_words_[wire.block]), input, offset_of(place_words_[wire.source])});
    values()[wire.store].live = false;
  }
}

void BodyGenerator::connect_queues() {
  for (const ir::QueuePort& port : pou_.queue_ports) {
    const ir::Type& block = types_[type_of_place(port.instance.index)];
    const ir::Variable& end = shared_.module.pous[block.pou].variables[port.variable];
    out_.queue_ports.push_back(
        {offset_of(place_words_[port.instance.index]), end.name, shared_.queue_of[port.global], end.constant});
  }
}

void BodyGenerator::call_queue(const ir::QueueCall& call) {
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

void BodyGenerator::place_words() {
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

void BodyGenerator::move(ir::TypeRef type, std::uint32_t to, std::uint32_t from) {
  if (to == from) return;
  const auto rep = types_.rep_of(type);
  if (rep) {
    writer_.op(move_for(*rep), {to, from});
  } else if (size_of(image_type(type)) != 0) {
    writer_.op(Opcode::kCopy, {to, from, image_type(type)});
  }
}

void BodyGenerator::initialise_temps() {
  if (pou_.kind == ir::PouKind::kFunction) return;
  for (std::uint32_t i = 0; i < pou_.variables.size(); ++i) {
    const ir::Variable& v = pou_.variables[i];
    if (v.role != ir::Role::kTemp) continue;
    const std::uint32_t type = image_type(v.type);
    std::vector<std::byte> bytes(size_of(type));
    shared_.layout.initialise(v, bytes.data());
    writer_.source(v.at);
    move(v.type, operand_word(v.in_frame ? Space::kFrame : Space::kInstance, shared_.layout.pou(pou_index_).offset[i]),
         shared_.constants.word(type, bytes));
  }
}

bool BodyGenerator::finish() {
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

void BodyGenerator::jump(std::uint32_t label) {
  note_jump(here(), label);
  if (label_words_[label] != kUnset) {
    writer_.op(Opcode::kLoopJump, {label_words_[label]});
    return;
  }
  writer_.op(Opcode::kJump, {0});
  patches_.push_back({writer_.last_word(), label});
}

void BodyGenerator::jump_unless(Literal condition, std::uint32_t label) {
  if (condition == kTrueLiteral) return;
  if (condition == kFalseLiteral) {
    jump(label);
    return;
  }
  if (label_words_[label] == kUnset) {
    const std::uint32_t target = forward_jump(condition);
    note_jump(target - 2, label);
    patches_.push_back({target, label});
    return;
  }
  // Conditional jumps go forward: step over the jump back.
  const std::uint32_t over = forward_jump(condition ^ 1u);
  note_jump(here(), label);
  writer_.op(Opcode::kLoopJump, {label_words_[label]});
  writer_.patch(over, writer_.here());
}

std::uint32_t BodyGenerator::forward_jump(Literal condition) {
  const std::uint32_t v = value_of(condition);
  const bool as_it_is = is_inverted(condition) && (values()[v].word != kUnset || !is_logic(body_.insts[v].op));
  const std::uint32_t word = bool_operand(as_it_is ? condition ^ 1u : condition);
  writer_.op(as_it_is ? Opcode::kJumpIf : Opcode::kCondJump, {word, 0});
  return writer_.last_word();
}

bool generate_body(Shared& shared, std::uint32_t pou, ImagePou& out, PouProbes& probes) {
  BodyGenerator generator(shared, pou, out);
  const bool fits = generator.run();
  probes = generator.take_probes();
  return fits;
}

}  // namespace plc::bytecode
