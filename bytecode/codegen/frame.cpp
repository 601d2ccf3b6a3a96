#include "bytecode/codegen/frame.h"

#include <fmt/format.h>

namespace plc::bytecode {

std::uint32_t Frame::intermediate(std::uint32_t type, std::uint32_t last) {
  std::vector<std::uint32_t>& spare = free_[type];
  std::uint32_t word = 0;
  if (spare.empty()) {
    ImageField field;
    field.name = fmt::format("#t{}", count_++);
    field.type = type;
    field.role = FieldRole::kHidden;
    word = operand_word(Space::kFrame, fields_.offset(fields_.add(image_, std::move(field))));
  } else {
    word = spare.back();
    spare.pop_back();
  }
  taken_.push({last, type, word});
  return word;
}

}  // namespace plc::bytecode
