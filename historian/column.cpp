#include "historian/column.h"

#include <zstd.h>

#include <cstring>

namespace plc::historian {
namespace {

constexpr int kLevel = 1;
/// A column of more would not have been written.
constexpr unsigned long long kMostBytes = 64u << 20;

}  // namespace

struct Columns::State {
  ZSTD_CCtx* compress = ZSTD_createCCtx();
  ZSTD_DCtx* decompress = ZSTD_createDCtx();
  std::vector<std::byte> planes, out;
};

Columns::Columns() : state_(std::make_unique<State>()) {}

Columns::~Columns() {
  ZSTD_freeCCtx(state_->compress);
  ZSTD_freeDCtx(state_->decompress);
}

std::span<const std::byte> Columns::pack(std::span<const std::byte> values, std::uint32_t width) {
  const std::size_t count = values.size() / width;
  State& s = *state_;
  s.planes.resize(values.size());
  for (std::uint32_t plane = 0; plane < width; ++plane) {
    std::byte before{0};
    std::byte* to = s.planes.data() + plane * count;
    const std::byte* from = values.data() + plane;
    for (std::size_t i = 0; i < count; ++i, from += width) {
      to[i] = *from ^ before;
      before = *from;
    }
  }
  s.out.resize(ZSTD_compressBound(values.size()));
  const std::size_t bytes =
      ZSTD_compressCCtx(s.compress, s.out.data(), s.out.size(), s.planes.data(), s.planes.size(), kLevel);
  return {s.out.data(), ZSTD_isError(bytes) != 0 ? 0 : bytes};
}

std::span<const std::byte> Columns::unpack(std::span<const std::byte> packed, std::uint32_t width) {
  State& s = *state_;
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size > kMostBytes || size % width != 0) return {};  // not known and wrong are greater than any
  s.planes.resize(size);
  const std::size_t bytes =
      ZSTD_decompressDCtx(s.decompress, s.planes.data(), s.planes.size(), packed.data(), packed.size());
  if (bytes != size) return {};
  const std::size_t count = size / width;
  s.out.resize(size);
  for (std::uint32_t plane = 0; plane < width; ++plane) {
    std::byte before{0};
    const std::byte* from = s.planes.data() + plane * count;
    std::byte* to = s.out.data() + plane;
    for (std::size_t i = 0; i < count; ++i, to += width) *to = before = before ^ from[i];
  }
  return {s.out.data(), size};
}

}  // namespace plc::historian
