// BodyReader: one body of an image as the linker sees it, for the linker and for estimates of what it makes.
//
// In: a verified image, bindings of a task. Out: which words are jumped to, boolean runs that become one, comparisons
// that are joined with the jump after them, paths and types of operands. Does not belong here: resolved code
// (link.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"
#include "runtime/link/bindings.h"
#include "runtime/link/decoded.h"
#include "runtime/link/link_bool.h"
#include "runtime/link/link_path.h"

namespace plc::runtime {

class BodyReader {
 public:
  /// `bindings` must outlive this.
  BodyReader(const bytecode::Image& image, const Bindings& bindings) : image_(image), bindings_(bindings) {}
  /// The body of `pou` is read from now on.
  void open(std::uint32_t pou);

  [[nodiscard]] std::uint32_t pou() const { return pou_; }
  [[nodiscard]] const std::vector<std::uint32_t>& code() const { return image_.pous[pou_].code; }
  [[nodiscard]] bool is_target(std::uint32_t word) const { return is_target_[word] != 0; }
  [[nodiscard]] static std::optional<std::uint32_t> target_of(const Decoded& d);

  /// The records of a boolean run and of those that follow it without a jump between them; `next` becomes the word
  /// after the last one.
  [[nodiscard]] std::vector<GeneralRecord> records(const Decoded& first, std::uint32_t& next) const;
  /// One of them, from its words.
  [[nodiscard]] GeneralRecord record(const std::uint32_t* words) const;
  struct FusedJump {
    ResolvedOp op = ResolvedOp::kReturn;
    std::uint32_t target = 0, next = 0;
  };
  /// The conditional jump after comparison `d` on its result, if one instruction does both.
  [[nodiscard]] std::optional<FusedJump> fused_jump(const Decoded& d) const;
  /// Where LOAD_AT and the like lead.
  [[nodiscard]] ResolvedPath path_of(const Decoded& d, const PackedTypes* packed = nullptr) const;
  /// Type of the leaf that an operand names.
  [[nodiscard]] const bytecode::ImageType& leaf_type(std::uint32_t operand) const;

 private:
  const bytecode::Image& image_;
  const Bindings& bindings_;
  std::uint32_t pou_ = 0;
  std::vector<std::uint8_t> is_target_;
};

}  // namespace plc::runtime
