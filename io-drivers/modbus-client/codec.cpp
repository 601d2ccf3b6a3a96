#include "io-drivers/modbus-client/codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <variant>

namespace plc::modbus_client {
namespace {

using core::Rep;
using core::TypeId;
/// A number on its way: whole numbers keep all 64 bits.
using Number = std::variant<std::int64_t, std::uint64_t, double>;

template <class T>
Number load_as(const std::byte* from) {
  T value{};
  std::memcpy(&value, from, sizeof value);
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<double>(value);
  } else if constexpr (std::is_signed_v<T>) {
    return std::int64_t{value};
  } else {
    return std::uint64_t{value};
  }
}

/// The nearest value of the type.
template <class T>
T clamp_to(const Number& number) {
  using Limits = std::numeric_limits<T>;
  if constexpr (std::is_floating_point_v<T>) {
    return std::visit([](auto v) { return static_cast<T>(v); }, number);
  } else {
    if (const double* real = std::get_if<double>(&number)) {
      if (std::isnan(*real)) return 0;
      const double whole = std::round(*real);
      // The limits of 64 bits are not doubles: the next above is.
      if (whole <= static_cast<double>(Limits::min())) return Limits::min();
      if (whole >= std::ldexp(1.0, Limits::digits)) return Limits::max();
      return static_cast<T>(whole);
    }
    return std::visit(
        [](auto v) -> T {
          if constexpr (std::is_integral_v<decltype(v)>) {
            if (std::cmp_less(v, Limits::min())) return Limits::min();
            if (std::cmp_greater(v, Limits::max())) return Limits::max();
          }
          return static_cast<T>(v);
        },
        number);
  }
}
template <class T>
void store_as(const Number& number, std::byte* to) {
  const T value = clamp_to<T>(number);
  std::memcpy(to, &value, sizeof value);
}

Number load(Rep rep, const std::byte* from) {
  switch (rep) {
    case Rep::kI8:
      return load_as<std::int8_t>(from);
    case Rep::kU8:
      return load_as<std::uint8_t>(from);
    case Rep::kI16:
      return load_as<std::int16_t>(from);
    case Rep::kU16:
      return load_as<std::uint16_t>(from);
    case Rep::kI32:
      return load_as<std::int32_t>(from);
    case Rep::kU32:
      return load_as<std::uint32_t>(from);
    case Rep::kI64:
      return load_as<std::int64_t>(from);
    case Rep::kU64:
      return load_as<std::uint64_t>(from);
    case Rep::kF32:
      return load_as<float>(from);
    case Rep::kF64:
      return load_as<double>(from);
    default:
      return std::int64_t{0};
  }
}

void store(Rep rep, const Number& number, std::byte* to) {
  switch (rep) {
    case Rep::kI8:
      return store_as<std::int8_t>(number, to);
    case Rep::kU8:
      return store_as<std::uint8_t>(number, to);
    case Rep::kI16:
      return store_as<std::int16_t>(number, to);
    case Rep::kU16:
      return store_as<std::uint16_t>(number, to);
    case Rep::kI32:
      return store_as<std::int32_t>(number, to);
    case Rep::kU32:
      return store_as<std::uint32_t>(number, to);
    case Rep::kI64:
      return store_as<std::int64_t>(number, to);
    case Rep::kU64:
      return store_as<std::uint64_t>(number, to);
    case Rep::kF32:
      return store_as<float>(number, to);
    case Rep::kF64:
      return store_as<double>(number, to);
    default:
      return;
  }
}

Rep rep_of(Raw raw) {
  constexpr Rep kReps[] = {Rep::kI16, Rep::kI16, Rep::kU16, Rep::kI32, Rep::kU32,
                           Rep::kI64, Rep::kU64, Rep::kF32, Rep::kF64};
  return kReps[static_cast<std::size_t>(raw)];
}

double real_of(const Number& number) {
  return std::visit([](auto v) { return static_cast<double>(v); }, number);
}

/// The register that has word `i` of the value, counted from its lowest.
std::size_t place_of(std::size_t i, std::size_t registers, io::WordOrder order) {
  const bool low_first = order == io::WordOrder::kCdab || order == io::WordOrder::kDcba;
  return low_first ? i : registers - 1 - i;
}
std::uint16_t in_order(std::uint16_t word, std::size_t registers, io::WordOrder order) {
  // As in the server's map, the order is one of values of several registers.
  const bool swap = registers > 1 && (order == io::WordOrder::kBadc || order == io::WordOrder::kDcba);
  return swap ? static_cast<std::uint16_t>(word << 8 | word >> 8) : word;
}

/// Bytes of a register of a text, exchanged where the order says so.
std::uint16_t text_register(std::uint16_t word, io::WordOrder order) { return in_order(word, 2, order); }

void decode_text(const Coding& coding, std::span<const std::uint16_t> cells, std::byte* value) {
  const std::size_t width = coding.variable == TypeId::kWstring ? 2 : 1;
  std::byte* const characters = value + sizeof(core::StringHeader);
  const auto room = std::min<std::size_t>(coding.characters, cells.size() * 2 / width);
  std::uint16_t length = 0;
  for (; length < room; ++length) {
    const std::uint16_t word = text_register(cells[length * width / 2], coding.order);
    const auto one = static_cast<std::uint16_t>(width == 2 ? word : length % 2 == 0 ? word >> 8 : word & 0xff);
    if (one == 0) break;
    std::memcpy(characters + length * width, &one, width);
  }
  const core::StringHeader header{coding.characters, length};
  std::memcpy(value, &header, sizeof header);
}

void encode_text(const Coding& coding, const std::byte* value, std::span<std::uint16_t> cells) {
  const bool wide = coding.variable == TypeId::kWstring;
  core::StringHeader header;
  std::memcpy(&header, value, sizeof header);
  const std::byte* const characters = value + sizeof header;
  const std::size_t length = std::min(header.length, coding.characters);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::uint16_t word = 0;
    if (wide) {
      if (i < length) std::memcpy(&word, characters + 2 * i, 2);
    } else {
      const auto at = [&](std::size_t k) { return k < length ? std::to_integer<unsigned>(characters[k]) : 0u; };
      word = static_cast<std::uint16_t>(at(2 * i) << 8 | at(2 * i + 1));
    }
    cells[i] = text_register(word, coding.order);
  }
}

}  // namespace

Raw raw_of(TypeId variable) {
  switch (rep_of(variable)) {
    case Rep::kU8:
    case Rep::kU16:
      return Raw::kUint;
    case Rep::kI32:
      return Raw::kDint;
    case Rep::kU32:
      return Raw::kUdint;
    case Rep::kI64:
      return Raw::kLint;
    case Rep::kU64:
      return Raw::kUlint;
    case Rep::kF32:
      return Raw::kReal;
    case Rep::kF64:
      return Raw::kLreal;
    default:
      return Raw::kInt;
  }
}

std::uint16_t registers_of(Raw raw) { return static_cast<std::uint16_t>(core::rep_bytes(rep_of(raw)) / 2); }

std::string_view refuses(const bytecode::ImageType& type) {
  const bool number =
      type.kind == bytecode::TypeKind::kScalar && core::in_category(type.elementary, core::kAnyNum | core::kAnyBit);
  const bool text = type.kind == bytecode::TypeKind::kString && type.capacity != 0;
  return number || text ? "" : "a Modbus value is a BOOL, a bit string, a number or a text";
}

void decode(const Coding& coding, std::span<const std::uint16_t> cells, std::byte* value) {
  if (coding.characters != 0) return decode_text(coding, cells, value);
  if (coding.variable == TypeId::kBool) {
    const bool on = coding.bit >= 0 ? (cells[0] >> coding.bit & 1) != 0 : cells[0] != 0;
    *value = std::byte{on != coding.invert ? std::uint8_t{1} : std::uint8_t{0}};
    return;
  }
  const std::size_t registers = registers_of(coding.raw);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < registers; ++i) {
    const std::uint16_t word = in_order(cells[place_of(i, registers, coding.order)], registers, coding.order);
    bits |= std::uint64_t{word} << 16 * i;
  }
  std::byte raw[8];
  std::memcpy(raw, &bits, sizeof raw);  // little-endian, as the table is
  Number number = load(rep_of(coding.raw), raw);
  if (coding.scale != 1 || coding.offset != 0) number = real_of(number) * coding.scale + coding.offset;
  store(rep_of(coding.variable), number, value);
}

void encode(const Coding& coding, const std::byte* value, std::span<std::uint16_t> cells) {
  if (coding.characters != 0) return encode_text(coding, value, cells);
  if (coding.variable == TypeId::kBool) {
    const bool on = (*value != std::byte{0}) != coding.invert;
    if (coding.bit < 0) {
      cells[0] = on ? 1 : 0;
    } else {
      const unsigned mask = 1u << coding.bit;
      cells[0] = static_cast<std::uint16_t>(on ? cells[0] | mask : cells[0] & ~mask);
    }
    return;
  }
  Number number = load(rep_of(coding.variable), value);
  if (coding.scale != 1 || coding.offset != 0) number = (real_of(number) - coding.offset) / coding.scale;
  std::byte raw[8] = {};
  store(rep_of(coding.raw), number, raw);
  std::uint64_t bits = 0;
  std::memcpy(&bits, raw, sizeof raw);
  const std::size_t registers = registers_of(coding.raw);
  for (std::size_t i = 0; i < registers; ++i) {
    cells[place_of(i, registers, coding.order)] =
        in_order(static_cast<std::uint16_t>(bits >> 16 * i), registers, coding.order);
  }
}

}  // namespace plc::modbus_client
