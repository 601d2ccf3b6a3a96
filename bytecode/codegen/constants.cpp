#include "bytecode/codegen/constants.h"

#include <fmt/format.h>

#include <cstring>

namespace plc::bytecode {

std::uint32_t ConstantPool::word(const ir::Constant& constant) {
  const std::uint32_t type = layout_.type(constant.type);
  std::vector<std::byte> bytes(image_.types[type].size);
  layout_.write_constant(constant, constant.type, bytes.data());
  return word(type, bytes);
}

std::uint32_t ConstantPool::word(std::uint32_t image_type, std::span<const std::byte> bytes) {
  std::string key(sizeof image_type + bytes.size(), '\0');
  std::memcpy(key.data(), &image_type, sizeof image_type);
  if (!bytes.empty()) std::memcpy(key.data() + sizeof image_type, bytes.data(), bytes.size());
  const auto [it, fresh] = known_.try_emplace(std::move(key), 0);
  if (fresh) {
    ImageField field;
    field.name = fmt::format("#c{}", count_++);
    field.type = image_type;
    field.constant = true;
    const std::uint32_t offset = fields_.offset(fields_.add(image_, std::move(field)));
    if (!fields_.too_large()) {
      bytes_.resize(offset + bytes.size());
      if (!bytes.empty()) std::memcpy(bytes_.data() + offset, bytes.data(), bytes.size());
    }
    it->second = operand_word(Space::kConst, offset);
  }
  return it->second;
}

bool ConstantPool::finish() {
  const bool fits = !fields_.too_large();
  ImageType type = fields_.finish("#constants");
  bytes_.resize(type.size);
  image_.const_bytes = std::move(bytes_);
  image_.types.push_back(std::move(type));
  image_.const_type = static_cast<std::uint32_t>(image_.types.size() - 1);
  return fits;
}

}  // namespace plc::bytecode
