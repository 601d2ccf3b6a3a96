// ByteWriter and ByteReader: little-endian numbers in a byte buffer, whatever the machine's own order.
//
// The reader never reads past its end: after a short read it is failed(), returns zeros and stays so. Callers check
// once, at the end of a section. Does not belong here: what the numbers mean.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace plc::bytecode {

template <class T>
void store_le(std::byte* to, T value) {
  using U = std::make_unsigned_t<T>;
  const auto bits = static_cast<U>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) to[i] = static_cast<std::byte>((bits >> (8 * i)) & 0xff);
}
template <class T>
T load_le(const std::byte* from) {
  using U = std::make_unsigned_t<T>;
  U bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bits = static_cast<U>(bits | static_cast<U>(static_cast<U>(from[i]) << (8 * i)));
  return static_cast<T>(bits);
}

class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    store_le(bytes_.data() + at, value);
  }
  void put_bytes(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void put_words(std::span<const std::uint32_t> words) {
    if constexpr (std::endian::native == std::endian::little) {
      put_bytes(std::as_bytes(words));
    } else {
      for (const std::uint32_t word : words) put(word);
    }
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    if (failed_ || rest_.size() < sizeof(T)) {
      failed_ = true;
      return T{};
    }
    const T value = load_le<T>(rest_.data());
    rest_ = rest_.subspan(sizeof(T));
    return value;
  }
  /// The next `size` bytes, or none when there are fewer.
  std::span<const std::byte> take(std::uint64_t size) {
    if (failed_ || size > rest_.size()) {
      failed_ = true;
      return {};
    }
    const auto taken = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
    return taken;
  }
  /// A number of records of at least `record_bytes` each; fails when the rest cannot hold them, so that a caller may
  /// reserve memory for them.
  std::uint32_t count(std::size_t record_bytes) {
    const auto n = get<std::uint32_t>();
    if (failed_ || n > rest_.size() / record_bytes) {
      failed_ = true;
      return 0;
    }
    return n;
  }
  void fail() { failed_ = true; }
  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::byte> rest_;
  bool failed_ = false;
};

}  // namespace plc::bytecode
