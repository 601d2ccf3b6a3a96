// retain::parse_file on arbitrary bytes: it must end, and what it accepts must go into a program whatever it says. The
// sums are made to fit, so that what is behind them is reached.
#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "retain/carry.h"
#include "retain/store.h"

namespace {

using namespace plc;

/// A few variables of several kinds, as a program may keep.
retain::Layout present() {
  using bytecode::TypeKind;
  retain::Layout layout;
  bytecode::ImageType integer, text, array, structure;
  integer.elementary = core::TypeId::kInt;
  integer.size = 2;
  text.kind = TypeKind::kString;
  text.elementary = core::TypeId::kString;
  text.capacity = 4;
  text.size = 8;
  array.kind = TypeKind::kArray;
  array.count = 3;
  array.size = 6;
  structure.kind = TypeKind::kStruct;
  structure.size = 16;
  bytecode::ImageField a, s;
  a.name = "a";
  a.type = 2;
  s.name = "s";
  s.type = 1;
  s.offset = 8;
  structure.fields = {a, s};
  layout.types = {integer, text, array, structure};
  layout.roots = {{"main.x", 3, 0, false, false}, {"main.y", 0, 16, true, false}};
  layout.bytes = 18;
  return layout;
}

template <class T>
T load(const std::vector<std::byte>& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}
void store(std::vector<std::byte>& bytes, std::size_t at, std::uint64_t value) {
  if (at + sizeof value <= bytes.size()) std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// The sums of the header and of both slots.
void seal(std::vector<std::byte>& bytes) {
  const std::uint64_t layout_bytes = load<std::uint32_t>(bytes, 12), value_bytes = load<std::uint64_t>(bytes, 16);
  if (bytes.size() < 32 || layout_bytes > bytes.size() - 32 || value_bytes > bytes.size()) return;
  const std::uint64_t hash = XXH3_64bits(bytes.data() + 32, layout_bytes);
  store(bytes, 24, hash);
  const auto rounded = [](std::uint64_t n) { return (n + 4095) / 4096 * 4096; };
  for (int slot = 0; slot < 2; ++slot) {
    const std::uint64_t at = rounded(32 + layout_bytes) + static_cast<std::uint64_t>(slot) * rounded(32 + value_bytes);
    if (at > bytes.size() || 32 + value_bytes > bytes.size() - at) return;
    const std::byte* const begin = bytes.data() + at;
    store(bytes, at + 24, XXH3_64bits_withSeed(begin + 32, value_bytes, XXH3_64bits_withSeed(begin, 24, hash)));
  }
}

void read(const std::vector<std::byte>& bytes) {
  const auto stored = retain::parse_file(bytes);
  if (!stored) return;
  if (stored->values.size() != stored->layout.bytes || stored->sequence == 0) std::abort();
  const auto again = retain::decode(retain::encode(stored->layout));
  if (!again || again->roots.size() != stored->layout.roots.size()) std::abort();
  const retain::Layout now = present();
  for (const retain::Start start : {retain::Start::kWarm, retain::Start::kCold}) {
    std::vector<std::byte> values(now.bytes);
    const core::StringHeader header{4, 0};
    std::memcpy(values.data() + 8, &header, sizeof header);
    static_cast<void>(retain::carry_over(stored->layout, stored->values, now, values, start));
    core::StringHeader after{};
    std::memcpy(&after, values.data() + 8, sizeof after);
    if (after.capacity != 4 || after.length > 4) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* const first = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> bytes(first, first + size);
  read(bytes);
  seal(bytes);
  read(bytes);
  // Seeds are short: blocks of zeros are left out of them.
  if (const std::uint64_t rest = load<std::uint32_t>(bytes, 12); bytes.size() >= 32 && rest <= bytes.size() - 32) {
    const auto layout = retain::decode(std::span(bytes).subspan(32, rest));
    if (layout && layout->bytes < (1 << 20)) {
      store(bytes, 16, layout->bytes);
      bytes.resize((32 + rest + 4095) / 4096 * 4096 + 2 * ((32 + layout->bytes + 4095) / 4096 * 4096), std::byte{1});
      seal(bytes);
      read(bytes);
    }
  }
  return 0;
}
