#include "runtime/packed_run.h"

#include "runtime/operations.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace plc::runtime {

#ifdef __x86_64__
namespace {

#define PLC_PACKED [[gnu::target("avx2,bmi,bmi2")]]

PLC_PACKED inline __m256i load_half(const std::byte* at) noexcept {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
}
/// The bytes in the order of `numbers`, where there is one.
PLC_PACKED inline __m256i in_order(__m256i bytes, const std::byte* numbers) noexcept {
  return numbers == nullptr ? bytes : _mm256_shuffle_epi8(bytes, load_half(numbers));
}

/// The lowest bit of each byte. `byte_of_bit`: null for a window in its own order.
PLC_PACKED inline std::uint32_t half_of(const std::byte* window, const std::byte* byte_of_bit) noexcept {
  const __m256i bytes = in_order(load_half(window), byte_of_bit);
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_slli_epi16(bytes, 7)));
}
PLC_PACKED inline std::uint64_t bits_of(const std::byte* window, const std::byte* byte_of_bit) noexcept {
  const std::byte* const high = byte_of_bit == nullptr ? nullptr : byte_of_bit + 32;
  return half_of(window, byte_of_bit) | std::uint64_t{half_of(window + 32, high)} << 32;
}

/// 0xff for each bit that is set.
PLC_PACKED inline __m256i bytes_of(std::uint32_t bits) noexcept {
  const __m256i from = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
  const __m256i bit = _mm256_set1_epi64x(static_cast<long long>(0x8040201008040201));
  const __m256i all = _mm256_shuffle_epi8(_mm256_set1_epi32(static_cast<int>(bits)), from);
  return _mm256_cmpeq_epi8(_mm256_and_si256(all, bit), bit);
}
PLC_PACKED inline void put_half(std::byte* at, std::uint32_t bits, std::uint32_t written,
                                const std::byte* bit_of_byte) noexcept {
  const __m256i values = in_order(_mm256_and_si256(bytes_of(bits), _mm256_set1_epi8(1)), bit_of_byte);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(at), _mm256_blendv_epi8(load_half(at), values, bytes_of(written)));
}
PLC_PACKED inline void put(std::byte* window, std::uint64_t bits, std::uint64_t written,
                           const std::byte* bit_of_byte) noexcept {
  if (written == 0) return;
  const std::byte* const high = bit_of_byte == nullptr ? nullptr : bit_of_byte + 32;
  put_half(window, static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(written), bit_of_byte);
  put_half(window + 32, static_cast<std::uint32_t>(bits >> 32), static_cast<std::uint32_t>(written >> 32), high);
}

/// One of a run, which are aligned as its words are.
using WordInRun = std::uint64_t __attribute__((may_alias, aligned(4)));

/// The bit `index` of `truth`, and any bits above it. WHY not BT: on some processors it runs where PEXT does, and only
/// there.
PLC_PACKED inline std::uint64_t look_up(const std::byte* truth, std::uint64_t index) noexcept {
  std::uint64_t bit;
  asm("shrx %1, %2, %0" : "=r"(bit) : "r"(index), "m"(*reinterpret_cast<const WordInRun*>(truth)));
  return bit;
}
/// Shifts the lowest bit of `bit` into `results`.
PLC_PACKED inline void append(std::uint64_t& results, std::uint64_t bit) noexcept {
  asm("shr $1, %1\n\tadc %0, %0" : "+r"(results), "+r"(bit) : : "cc");
}

/// PEXT with a mask in memory, right where it is needed: there are more masks than registers.
PLC_PACKED inline std::uint64_t extract(std::uint64_t word, const std::byte* mask) noexcept {
  std::uint64_t bits;
  asm("pext %2, %1, %0" : "=r"(bits) : "r"(word), "m"(*reinterpret_cast<const WordInRun*>(mask)));
  return bits;
}

/// Up to two words of bits. WHY kept: compilers like to bring two of them into one vector.
struct Bits {
  std::uint64_t first = 0, second = 0;
  void keep() noexcept { asm("" : "+r"(first), "+r"(second)); }
};

/// Where a chunk's inputs are: each in its column.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline std::uint64_t inputs_of(const std::byte* chunk, Bits bits) noexcept {
  if constexpr (kWords == 1) return bits.first;
  auto from_first = load<std::uint64_t>(chunk + offsetof(PackedChunk<2>, from_first));
  asm("" : "+r"(from_first));  // loaded once
  return (bits.first & from_first) | (bits.second & ~from_first);
}

/// `bits` with the results of a chunk that reads `before`.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline Bits behind(const std::byte* chunk, Bits before, Bits bits) noexcept {
  using Chunk = PackedChunk<kWords>;
  const std::uint64_t inputs = inputs_of<kWords>(chunk, before);
  const auto result = [ chunk, inputs ](std::size_t r) __attribute__((target("avx2,bmi,bmi2"), always_inline)) {
    const std::byte* const record = chunk + offsetof(Chunk, records) + r * sizeof(PackedRecord);
    return look_up(record + offsetof(PackedRecord, truth), extract(inputs, record + offsetof(PackedRecord, in)));
  };
  // What the first one brings above its bit ends up above those of all: nobody takes it.
  std::uint64_t results = result(0);
#pragma GCC unroll 4
  for (std::size_t r = 1; r < kChunkRecords; ++r) append(results, result(r));
  const auto field = [chunk](std::size_t at) { return load<std::uint64_t>(chunk + at); };
  const std::uint64_t out = field(offsetof(Chunk, out));
  bits.first = (bits.first & ~out) | _pdep_u64(results, out);
  if constexpr (kWords == 2) {
    const std::uint64_t second = field(offsetof(Chunk, second_out));
    const std::uint64_t others = results >> (field(offsetof(Chunk, first_outputs)) & 63u);
    bits.second = (bits.second & ~second) | _pdep_u64(others, second);
  }
  bits.keep();
  return bits;
}

/// Runs chunks, two under way at a time. Returns their end.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline const std::byte* run_two(const std::byte* at, std::uint32_t count,
                                                                  Bits& bits) noexcept {
  using Chunk = PackedChunk<kWords>;
  Bits before = bits;
  for (; count > 1; count -= 2, at += 2 * sizeof(Chunk)) {
    before = behind<kWords>(at, before, bits);
    bits = behind<kWords>(at + sizeof(Chunk), bits, before);
  }
  if (count == 0) return at;
  bits = behind<kWords>(at, before, bits);
  return at + sizeof(Chunk);
}
/// Three under way at a time.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline const std::byte* run_three(const std::byte* at, std::uint32_t count,
                                                                    Bits& bits) noexcept {
  using Chunk = PackedChunk<kWords>;
  Bits first = bits, second = bits;
  for (; count > 2; count -= 3, at += 3 * sizeof(Chunk)) {
    first = behind<kWords>(at, first, bits);
    second = behind<kWords>(at + sizeof(Chunk), second, first);
    bits = behind<kWords>(at + 2 * sizeof(Chunk), bits, second);
  }
  if (count == 0) return at;
  bits = behind<kWords>(at, first, bits);
  if (count == 1) return at + sizeof(Chunk);
  bits = behind<kWords>(at + sizeof(Chunk), second, bits);
  return at + 2 * sizeof(Chunk);
}

template <std::size_t kWords, int kDelay>
PLC_PACKED const std::uint32_t* run(std::byte* table, std::uint32_t instance, const std::uint32_t* words,
                                    std::uint32_t count) noexcept {
  const auto* const header = reinterpret_cast<const std::byte*>(words);
  const auto place_of = [table, instance](const std::byte* operand) {
    return place<Addressing::kRelative>(table, instance, load<std::uint32_t>(operand));
  };
  const auto window = [=](std::size_t w) { return place_of(header + offsetof(PackedHeader, window) + 4 * w); };
  const auto mask = [=](std::size_t at, std::size_t w) { return load<std::uint64_t>(header + at + 8 * w); };
  const auto field = [=](std::size_t at) { return load<std::uint32_t>(header + at); };
  const std::uint32_t windows = field(offsetof(PackedHeader, windows));
  const std::uint32_t gathers = field(offsetof(PackedHeader, gathers));
  const std::uint32_t scatters = field(offsetof(PackedHeader, scatters));
  std::byte* const state = place_of(header + offsetof(PackedHeader, state));
  const std::byte* const order = kWords == 2 ? header + sizeof(PackedHeader) : nullptr;

  Bits bits;
  if (field(offsetof(PackedHeader, begins)) != 0) {
    if (windows > 0) bits.first = bits_of(window(0), nullptr);
    if (kWords == 2 && windows > 1) bits.second = bits_of(window(1), order + offsetof(PackedOrder, byte_of_bit));
  } else {
    bits.first = load<std::uint64_t>(state);
    if (kWords == 2) bits.second = load<std::uint64_t>(state + 8);
  }
  bits.first &= ~mask(offsetof(PackedHeader, gathered), 0);
  if (kWords == 2) bits.second &= ~mask(offsetof(PackedHeader, gathered), 1);
  const std::byte* single = header + sizeof(PackedHeader) + (kWords == 2 ? sizeof(PackedOrder) : 0);
  for (std::uint32_t i = 0; i < gathers; ++i, single += sizeof(PackedBit)) {
    const auto bit = load<std::uint32_t>(single + offsetof(PackedBit, bit));
    const std::uint64_t value = std::uint64_t{load<std::uint8_t>(place_of(single))} << (bit & 63u);
    (kWords == 2 && bit > 63 ? bits.second : bits.first) |= value;
  }
  const std::byte* const first_scatter = single;
  const std::byte* at = first_scatter + scatters * sizeof(PackedBit);
  at = kDelay == 2 ? run_two<kWords>(at, count, bits) : run_three<kWords>(at, count, bits);

  if (field(offsetof(PackedHeader, ends)) != 0) {
    put(window(0), bits.first, mask(offsetof(PackedHeader, written), 0), nullptr);
    if constexpr (kWords == 2) {
      put(window(1), bits.second, mask(offsetof(PackedHeader, written), 1), order + offsetof(PackedOrder, bit_of_byte));
    }
  } else {
    store(state, bits.first);
    if constexpr (kWords == 2) store(state + 8, bits.second);
  }
  single = first_scatter;
  for (std::uint32_t i = 0; i < scatters; ++i, single += sizeof(PackedBit)) {
    const auto bit = load<std::uint32_t>(single + offsetof(PackedBit, bit));
    const std::uint64_t word = kWords == 2 && bit > 63 ? bits.second : bits.first;
    store(place_of(single), static_cast<std::uint8_t>((word >> (bit & 63u)) & 1u));
  }
  return reinterpret_cast<const std::uint32_t*>(at);
}

/// AMD's first two generations with PEXT take as long for it as for twenty loads.
bool is_fast() {
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_is("znver1") == 0 && __builtin_cpu_is("znver2") == 0;
}

}  // namespace

ValueRun packed_run(PackedForm form) {
  static const bool kFast = is_fast();
  if (!kFast) return nullptr;
  if (form.delay == 2) return form.words == 1 ? &run<1, 2> : &run<2, 2>;
  return form.words == 1 ? &run<1, 3> : &run<2, 3>;
}
#else
ValueRun packed_run(PackedForm /*form*/) { return nullptr; }
#endif

}  // namespace plc::runtime
