#include "runtime/packed_columns.h"

namespace plc::runtime {
namespace {

/// Matching bytes with bits, lane by lane (H. W. Kuhn, "The Hungarian method for the assignment problem", 1955): each
/// byte takes a bit that is free, or the bit of a byte that can take another one.
class Lane {
 public:
  Lane(const std::array<std::uint64_t, kPackedWindowBytes>& blocked, std::uint32_t first)
      : blocked_(blocked), first_(first) {
    byte_of_.fill(kNobody);
  }
  /// At most kLaneBytes calls deep.
  bool place(std::uint32_t byte) {
    for (std::uint32_t i = 0; i < kLaneBytes; ++i) {
      const std::uint32_t bit = first_ + (byte + i) % kLaneBytes;  // its own first
      if ((blocked_[byte] >> bit & 1u) != 0 || (tried_ >> bit & 1u) != 0) continue;
      tried_ |= std::uint64_t{1} << bit;
      std::uint32_t& other = byte_of_[bit - first_];
      if (other == kNobody || place(other)) {
        other = byte;
        return true;
      }
    }
    return false;
  }
  void forget_tried() { tried_ = 0; }
  [[nodiscard]] std::uint32_t byte_of(std::uint32_t bit) const { return byte_of_[bit - first_]; }

 private:
  static constexpr std::uint32_t kNobody = 0xffffffffu;
  const std::array<std::uint64_t, kPackedWindowBytes>& blocked_;
  std::uint32_t first_;
  std::array<std::uint32_t, kLaneBytes> byte_of_;
  std::uint64_t tried_ = 0;
};

}  // namespace

std::optional<WindowBits> order_window(const std::array<std::uint64_t, kPackedWindowBytes>& blocked) {
  WindowBits bits{};
  for (std::uint32_t first = 0; first < kPackedWindowBytes; first += kLaneBytes) {
    Lane lane(blocked, first);
    for (std::uint32_t byte = first; byte < first + kLaneBytes; ++byte) {
      lane.forget_tried();
      if (!lane.place(byte)) return std::nullopt;
    }
    for (std::uint32_t bit = first; bit < first + kLaneBytes; ++bit) {
      bits[lane.byte_of(bit)] = static_cast<std::uint8_t>(bit);
    }
  }
  return bits;
}

}  // namespace plc::runtime
