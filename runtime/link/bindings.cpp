#include "runtime/link/bindings.h"

#include "runtime/link/decoded.h"

namespace plc::runtime {

using bytecode::Opcode;
using bytecode::Space;

Bindings::Bindings(const bytecode::Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous,
                   const TaskLayout& layout)
    : layout_(layout), instances_(image.pous.size()) {
  join(body, layout.instance);
  // Callers come before callees, so each POU's instances are known when its calls are looked at.
  for (const std::uint32_t pou : pous) {
    for_each_instruction(image.pous[pou], [&](const Decoded& d) {
      if (d.opcode == Opcode::kCallPou) join(d.operands[0], absolute(pou, d.operands[1]));
      if (d.opcode == Opcode::kCallAt || d.opcode == Opcode::kCallVia) join(d.operands[0], std::nullopt);
      if (d.opcode == Opcode::kCallFn) join(d.operands[0], 0);
    });
  }
}

void Bindings::join(std::uint32_t callee, std::optional<std::uint32_t> instance) {
  Instances& known = instances_[callee];
  if (!instance || (known.number == Instances::Number::kOne && known.at != *instance)) {
    known.number = Instances::Number::kMany;
  } else if (known.number == Instances::Number::kNone) {
    known = {Instances::Number::kOne, *instance};
  }
}

Addressing Bindings::addressing(std::uint32_t pou) const {
  return instances_[pou].number == Instances::Number::kMany ? Addressing::kRelative : Addressing::kFixed;
}

std::optional<std::uint32_t> Bindings::absolute(std::uint32_t pou, std::uint32_t operand) const {
  const std::uint32_t offset = bytecode::offset_of(operand);
  switch (bytecode::space_of(operand)) {
    case Space::kGlobal:
      return offset;
    case Space::kConst:
      return layout_.constants + offset;
    case Space::kFrame:
      return layout_.frames[pou] + offset;
    case Space::kInstance:
      break;
  }
  if (addressing(pou) == Addressing::kRelative) return std::nullopt;
  return instances_[pou].at + offset;
}

std::uint32_t Bindings::resolve(std::uint32_t pou, std::uint32_t operand) const {
  const auto offset = absolute(pou, operand);
  return offset ? *offset : (kRelativeBit | bytecode::offset_of(operand));
}

}  // namespace plc::runtime
