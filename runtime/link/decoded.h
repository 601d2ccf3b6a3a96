// Decoded: the instructions of an image's code, one after the other.
//
// In: code of a verified image, so nothing is checked. Out: opcode, operands, list. For the linker (runtime/link*.cpp)
// and for tools that look at code. Does not belong here: what instructions mean.
#pragma once

#include <cstdint>
#include <vector>

#include "bytecode/image.h"

namespace plc::runtime {

/// One instruction of an image.
struct Decoded {
  bytecode::Opcode opcode = bytecode::Opcode::kReturn;
  std::uint32_t word = 0;   ///< where it starts
  std::uint32_t items = 0;  ///< of its list
  const std::uint32_t* operands = nullptr;
  const std::uint32_t* list = nullptr;
  std::uint32_t next = 0;
};

inline Decoded decode(const std::vector<std::uint32_t>& code, std::uint32_t word) {
  Decoded d;
  d.opcode = static_cast<bytecode::Opcode>(code[word] & 0xffffu);
  d.word = word;
  d.items = code[word] >> 16;
  const bytecode::Operands& operands = bytecode::info(d.opcode).operands;
  d.operands = code.data() + word + 1;
  d.list = code.data() + word + bytecode::words_of(operands, 0);
  d.next = word + static_cast<std::uint32_t>(bytecode::words_of(operands, d.items));
  return d;
}

/// Calls `visit` with every instruction of a body.
template <class Visit>
void for_each_instruction(const bytecode::ImagePou& pou, Visit visit) {
  for (std::uint32_t word = 0; word < pou.code.size();) {
    const Decoded d = decode(pou.code, word);
    visit(d);
    word = d.next;
  }
}

}  // namespace plc::runtime
