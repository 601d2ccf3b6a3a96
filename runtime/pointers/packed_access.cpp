#include "runtime/pointers/packed_access.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/packed.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/arithmetic.h"

namespace plc::runtime {
namespace {

using bytecode::ImageType;
using bytecode::TypeKind;
using core::Rep;
using core::TypeId;

/// The value of a scalar as pointers see it, in the low bytes.
std::uint64_t load_scalar(const ImageType& type, const std::byte* at) {
  const std::int64_t step = core::packed_step_ns(type.elementary);
  if (step != 0) return static_cast<std::uint32_t>(load<std::int64_t>(at) / step);
  std::uint64_t bits = 0;
  std::memcpy(&bits, at, type.size);
  return bits;
}

template <class T>
std::uint64_t limited(std::uint64_t bits, const ImageType& type) {
  const auto value = static_cast<T>(bits);
  // Limits are 64-bit numbers: those of an unsigned type are not negative.
  if constexpr (std::is_signed_v<T>) {
    return static_cast<std::uint64_t>(std::clamp<std::int64_t>(value, type.lower, type.upper));
  } else {
    return std::clamp<std::uint64_t>(value, static_cast<std::uint64_t>(type.lower),
                                     static_cast<std::uint64_t>(type.upper));
  }
}

std::uint64_t in_limits(std::uint64_t bits, const ImageType& type) {
  switch (core::rep_of(type.elementary)) {
    case Rep::kI8:
      return limited<std::int8_t>(bits, type);
    case Rep::kI16:
      return limited<std::int16_t>(bits, type);
    case Rep::kI32:
      return limited<std::int32_t>(bits, type);
    case Rep::kI64:
      return limited<std::int64_t>(bits, type);
    default:
      return limited<std::uint64_t>(bits, type);
  }
}

void store_scalar(const ImageType& type, std::byte* at, std::uint64_t bits, Finer finer) {
  const std::int64_t step = core::packed_step_ns(type.elementary);
  if (step != 0) {
    const auto steps = static_cast<std::uint32_t>(bits);
    const bool stays = finer == Finer::kStays && steps == load_scalar(type, at);
    if (!stays) store<std::int64_t>(at, std::int64_t{steps} * step);
    return;
  }
  const Rep rep = core::rep_of(type.elementary);
  if (rep == Rep::kBool) return store<std::uint8_t>(at, (bits & 0xffu) != 0 ? 1 : 0);
  if (rep == Rep::kF32) return store(at, stdlib::canonical(load<float>(&bits)));
  if (rep == Rep::kF64) return store(at, stdlib::canonical(load<double>(&bits)));
  if (type.limited) bits = in_limits(bits, type);
  std::memcpy(at, &bits, type.size);
}

/// A string in a table: its characters, of one or two bytes.
struct Text {
  std::byte* start;
  std::uint32_t capacity;  ///< characters
  std::uint32_t width;

  Text(const ImageType& type, std::byte* value)
      : start(value + sizeof(core::StringHeader)),
        capacity(type.capacity),
        width(type.elementary == TypeId::kWstring ? 2 : 1),
        value_(value) {}
  [[nodiscard]] std::uint32_t length() const {
    return std::min<std::uint32_t>(load<core::StringHeader>(value_).length, capacity);
  }
  void set_length(std::uint32_t length) const {
    store(value_, core::StringHeader{static_cast<std::uint16_t>(capacity), static_cast<std::uint16_t>(length)});
  }
  [[nodiscard]] bool is_zero(std::uint32_t character) const {
    return width == 1 ? load<std::uint8_t>(start + character) == 0
                      : load<std::uint16_t>(start + std::size_t{character} * 2) == 0;
  }
  [[nodiscard]] std::uint32_t first_zero(std::uint32_t from) const {
    while (from < capacity && !is_zero(from)) ++from;
    return from;
  }

 private:
  std::byte* value_;
};

void read_text(const ImageType& type, const std::byte* value, std::uint32_t offset, std::uint32_t bytes,
               std::byte* to) {
  const Text text(type, const_cast<std::byte*>(value));
  const std::uint32_t end = text.capacity * text.width;
  const std::uint32_t kept = offset < end ? std::min(bytes, end - offset) : 0;
  std::memcpy(to, text.start + offset, kept);
  std::memset(to + kept, 0, bytes - kept);
  // The zero is the length of the header; what lies there is not looked at.
  const std::uint32_t zero = text.length() * text.width;
  for (std::uint32_t i = std::max(zero, offset); i < zero + text.width && i < offset + bytes; ++i) {
    to[i - offset] = std::byte{0};
  }
}

void write_text(const ImageType& type, std::byte* value, std::uint32_t offset, std::uint32_t bytes,
                const std::byte* from) {
  const Text text(type, value);
  const std::uint32_t end = text.capacity * text.width;
  if (offset >= end) return;
  const std::uint32_t length = text.length();
  if (length < text.capacity) std::memset(text.start + std::size_t{length} * text.width, 0, text.width);
  const std::uint32_t kept = std::min(bytes, end - offset);
  std::memcpy(text.start + offset, from, kept);
  const std::uint32_t first = offset / text.width;
  const std::uint32_t last = (offset + kept - 1) / text.width;
  if (first > length) return text.set_length(length);
  // After what was written nothing changed.
  std::uint32_t zero = first;
  while (zero <= last && !text.is_zero(zero)) ++zero;
  if (zero > last) zero = last < length ? length : text.first_zero(zero);
  text.set_length(zero);
}

/// Calls one(part, bytes, done) for the parts of [offset, offset + bytes).
template <class One>
void for_each_part(const PackedTypes& types, std::uint32_t type, std::uint32_t offset, std::uint32_t bytes, One one) {
  for (std::uint32_t done = 0; done < bytes;) {
    const PackedPart part = types.find(type, offset + done);
    const std::uint32_t here = std::min(part.left, bytes - done);
    if (!one(part, here, done)) return;
    done += here;
  }
}

}  // namespace

// RT:
bool is_open(const PackedTypes& types, std::uint32_t type, std::uint32_t offset, std::uint32_t bytes) noexcept {
  if (types[type].plain) return true;
  bool open = true;
  for_each_part(types, type, offset, bytes, [&open](const PackedPart& part, std::uint32_t, std::uint32_t) {
    open = part.kind != PackedPart::Kind::kClosed;
    return open;
  });
  return open;
}

// RT:
void read_packed(const PackedTypes& types, std::uint32_t type, const std::byte* value, std::uint32_t offset,
                 std::uint32_t bytes, std::byte* to) noexcept {
  for_each_part(types, type, offset, bytes, [&](const PackedPart& part, std::uint32_t here, std::uint32_t done) {
    if (part.kind != PackedPart::Kind::kLeaf) {
      std::memset(to + done, 0, here);
      return true;
    }
    const ImageType& leaf = types.image_type(part.type);
    if (leaf.kind == TypeKind::kString) {
      read_text(leaf, value + part.storage, part.inside, here, to + done);
    } else {
      const std::uint64_t bits = load_scalar(leaf, value + part.storage);
      std::memcpy(to + done, reinterpret_cast<const std::byte*>(&bits) + part.inside, here);
    }
    return true;
  });
}

// RT:
void write_packed(const PackedTypes& types, std::uint32_t type, std::byte* value, std::uint32_t offset,
                  std::uint32_t bytes, const std::byte* from, Finer finer) noexcept {
  for_each_part(types, type, offset, bytes, [&](const PackedPart& part, std::uint32_t here, std::uint32_t done) {
    if (part.kind != PackedPart::Kind::kLeaf) return true;
    const ImageType& leaf = types.image_type(part.type);
    if (leaf.kind == TypeKind::kString) {
      write_text(leaf, value + part.storage, part.inside, here, from + done);
    } else {
      std::uint64_t bits = load_scalar(leaf, value + part.storage);
      std::memcpy(reinterpret_cast<std::byte*>(&bits) + part.inside, from + done, here);
      store_scalar(leaf, value + part.storage, bits, finer);
    }
    return true;
  });
}

}  // namespace plc::runtime
