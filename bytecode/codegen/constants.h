// The constants of an image: every distinct value once. In: typed bytes. Out: operand words, Image::const_*.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "bytecode/codegen/layout.h"

namespace plc::bytecode {

class ConstantPool {
 public:
  ConstantPool(Image& image, Layout& layout) : image_(image), layout_(layout) {}

  /// Operand word of a scalar or string constant.
  std::uint32_t word(const ir::Constant& constant);
  /// Operand word of a value of `image_type` given as bytes.
  std::uint32_t word(std::uint32_t image_type, std::span<const std::byte> bytes);
  /// Stores type and bytes in the image; false when they are too large.
  bool finish();

 private:
  Image& image_;
  Layout& layout_;
  StructBuilder fields_;
  std::vector<std::byte> bytes_;
  std::unordered_map<std::string, std::uint32_t> known_;  ///< type index and bytes -> word
  std::uint32_t count_ = 0;
};

}  // namespace plc::bytecode
