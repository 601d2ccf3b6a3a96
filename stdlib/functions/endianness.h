// Rows: the order of bytes (IEC 61131-3:2013, table 37), for data that is exchanged byte by byte with other machines.
//
// Our values lie in memory with their lowest byte first, so little endian changes nothing and big endian reverses the
// bytes: of a number, bit string, duration or date as a whole, of a WSTRING character by character. Types of one byte
// stay as they are. A REAL whose bytes are reversed is bits to be sent, not a number to compute with.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "stdlib/row.h"

namespace plc::stdlib::rows {

static_assert(std::endian::native == std::endian::little, "these rows and images take low bytes first for granted");

/// Bytes are moved as bytes: a reversed REAL may be a NaN, whose bits a floating point register need not keep.
template <TypeId T>
Event reversed_bytes(void* result, const void* const* args, std::uint32_t) noexcept {
  if constexpr (core::rep_of(T) == Rep::kStr) {
    return store(result, load<ValueOf<T>>(args[0]));
  } else if constexpr (core::rep_of(T) == Rep::kWstr) {
    const Event event = store(result, load<ValueOf<T>>(args[0]));
    const std::size_t length = load<ValueOf<T>>(result).size();
    char16_t* const chars = detail::chars_of<char16_t>(result);
    for (std::size_t i = 0; i < length; ++i) chars[i] = static_cast<char16_t>(chars[i] << 8 | chars[i] >> 8);
    return event;
  } else {
    std::byte bytes[sizeof(ValueOf<T>)];
    std::memcpy(bytes, args[0], sizeof bytes);
    std::reverse(std::begin(bytes), std::end(bytes));
    std::memcpy(result, bytes, sizeof bytes);
    return Event::kNone;
  }
}
template <TypeId T>
Event same_bytes(void* result, const void* const* args, std::uint32_t) noexcept {
  if constexpr (core::in_category(T, core::kAnyString)) {
    return store(result, load<ValueOf<T>>(args[0]));
  } else {
    std::memmove(result, args[0], sizeof(ValueOf<T>));
    return Event::kNone;
  }
}

#define PLC_ENDIAN(Row, iec, function, text, ...)                              \
  struct Row {                                                                 \
    static constexpr Example examples[] = {__VA_ARGS__};                       \
    static constexpr FunctionSpec spec{.name = iec,                            \
                                       .t_categories = core::kAnyElementary,   \
                                       .params = {{"IN", kT}},                 \
                                       .param_count = 1,                       \
                                       .result = kT,                           \
                                       .events = events(Event::kTruncated),    \
                                       .clause = "IEC 61131-3:2013, table 37", \
                                       .summary = text,                        \
                                       .examples = examples};                  \
    template <TypeId T, TypeId>                                                \
    static constexpr Kernel kernel = &function<T>;                             \
  }
PLC_ENDIAN(ToBigEndian, "TO_BIG_ENDIAN", reversed_bytes, "IN with its highest byte first.",
           {"WORD", "TO_BIG_ENDIAN(16#1234)", "16#3412"}, {"DWORD", "TO_BIG_ENDIAN(16#12345678)", "16#78563412"},
           {"BYTE", "TO_BIG_ENDIAN(16#12)", "16#12"});
PLC_ENDIAN(ToLittleEndian, "TO_LITTLE_ENDIAN", same_bytes, "IN with its lowest byte first: IN itself.",
           {"WORD", "TO_LITTLE_ENDIAN(16#1234)", "16#1234"});
PLC_ENDIAN(FromBigEndian, "FROM_BIG_ENDIAN", reversed_bytes, "The value of which IN has the highest byte first.",
           {"DWORD", "FROM_BIG_ENDIAN(16#78563412)", "16#12345678"});
PLC_ENDIAN(FromLittleEndian, "FROM_LITTLE_ENDIAN", same_bytes,
           "The value of which IN has the lowest byte first: IN itself.",
           {"WORD", "FROM_LITTLE_ENDIAN(16#1234)", "16#1234"});
#undef PLC_ENDIAN

using EndianRows = Rows<ToBigEndian, ToLittleEndian, FromBigEndian, FromLittleEndian>;

}  // namespace plc::stdlib::rows
