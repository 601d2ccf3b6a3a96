#include "runtime/link/body_reader.h"

#include "bytecode/type_map.h"

namespace plc::runtime {

using bytecode::Opcode;
using bytecode::Space;

void BodyReader::open(std::uint32_t pou) {
  pou_ = pou;
  is_target_.assign(code().size(), 0);
  for_each_instruction(image_.pous[pou], [this](const Decoded& d) {
    if (const auto target = target_of(d)) is_target_[*target] = 1;
  });
}

std::optional<std::uint32_t> BodyReader::target_of(const Decoded& d) {
  const bytecode::Operands& operands = bytecode::info(d.opcode).operands;
  for (std::uint32_t i = 0; i < operands.count; ++i) {
    if (operands.specs[i].kind == bytecode::OperandKind::kTarget) return d.operands[i];
  }
  return std::nullopt;
}

GeneralRecord BodyReader::record(const std::uint32_t* words) const {
  GeneralRecord record;
  record.truth = words[0];
  record.out = bindings_.resolve(pou_, words[1]);
  for (std::size_t input = 0; input < 5; ++input) record.in[input] = bindings_.resolve(pou_, words[2 + input]);
  return record;
}

std::vector<GeneralRecord> BodyReader::records(const Decoded& first, std::uint32_t& next) const {
  std::vector<GeneralRecord> records;
  Decoded run = first;
  for (;;) {
    for (std::uint32_t i = 0; i < run.items; ++i) {
      records.push_back(record(run.list + std::size_t{i} * bytecode::kRecordWords));
    }
    next = run.next;
    if (next >= code().size() || is_target(next)) return records;
    run = decode(code(), next);
    if (run.opcode != Opcode::kBoolRun) return records;
  }
}

std::optional<BodyReader::FusedJump> BodyReader::fused_jump(const Decoded& d) const {
  if (d.next >= code().size() || is_target(d.next)) return std::nullopt;
  const Decoded jump = decode(code(), d.next);
  const bool unless = jump.opcode == Opcode::kCondJump;
  if ((!unless && jump.opcode != Opcode::kJumpIf) || jump.operands[0] != d.operands[0]) return std::nullopt;
  const auto fused = [&](ResolvedOp when_false, ResolvedOp when_true) {
    return FusedJump{unless ? when_false : when_true, jump.operands[1], jump.next};
  };
  switch (d.opcode) {
#define PLC_FUSED_JUMP(Name, T, expression) \
  case Opcode::k##Name:                     \
    return fused(ResolvedOp::k##Name##Unless, ResolvedOp::k##Name##If);
#include "runtime/interpreter/fused_jumps.def"
    default:
      return std::nullopt;
  }
}

ResolvedPath BodyReader::path_of(const Decoded& d, const PackedTypes* packed) const {
  const std::uint32_t spaces[] = {image_.global_type, image_.pous[pou_].instance_type, image_.pous[pou_].frame_type,
                                  image_.const_type};
  return resolve_path(image_, spaces, d.operands[2], {d.list, std::size_t{d.items} * bytecode::kPathWords}, packed);
}

const bytecode::ImageType& BodyReader::leaf_type(std::uint32_t operand) const {
  const Space space = bytecode::space_of(operand);
  const std::uint32_t root = space == Space::kGlobal     ? image_.global_type
                             : space == Space::kConst    ? image_.const_type
                             : space == Space::kInstance ? image_.pous[pou_].instance_type
                                                         : image_.pous[pou_].frame_type;
  return image_.types[*bytecode::leaf_at(image_, root, bytecode::offset_of(operand))];
}

}  // namespace plc::runtime
