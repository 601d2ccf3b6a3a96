#include "runtime/packed_run.h"

#include <cstring>

#include "runtime/operations.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace plc::runtime {

#ifdef __x86_64__
namespace {

#define PLC_PACKED [[gnu::target("avx2,bmi,bmi2")]]

/// The lowest bit of each byte.
PLC_PACKED inline std::uint64_t bits_of(const std::byte* window) noexcept {
  const auto half = [](const std::byte* at) __attribute__((target("avx2,bmi,bmi2"), always_inline)) {
    const __m256i bytes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
    return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_slli_epi16(bytes, 7)));
  };
  return half(window) | std::uint64_t{half(window + 32)} << 32;
}

/// 0xff for each bit that is set.
PLC_PACKED inline __m256i bytes_of(std::uint32_t bits) noexcept {
  const __m256i from = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
  const __m256i bit = _mm256_set1_epi64x(static_cast<long long>(0x8040201008040201));
  const __m256i all = _mm256_shuffle_epi8(_mm256_set1_epi32(static_cast<int>(bits)), from);
  return _mm256_cmpeq_epi8(_mm256_and_si256(all, bit), bit);
}
PLC_PACKED inline void put_half(std::byte* at, std::uint32_t bits, std::uint32_t written) noexcept {
  auto* const to = reinterpret_cast<__m256i*>(at);
  const __m256i values = _mm256_and_si256(bytes_of(bits), _mm256_set1_epi8(1));
  _mm256_storeu_si256(to, _mm256_blendv_epi8(_mm256_loadu_si256(to), values, bytes_of(written)));
}

PLC_PACKED inline void put(std::byte* window, std::uint64_t bits, std::uint64_t written) noexcept {
  if (written == 0) return;
  put_half(window, static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(written));
  put_half(window + 32, static_cast<std::uint32_t>(bits >> 32), static_cast<std::uint32_t>(written >> 32));
}

/// One of a run, which are aligned as its words are.
using WordInRun = std::uint64_t __attribute__((may_alias, aligned(4)));

/// Shifts the bit `index` of `truth` into `results`. WHY not BT: on some processors it runs where PEXT does, and only
/// there.
PLC_PACKED inline void look_up(std::uint64_t& results, const std::byte* truth, std::uint64_t index) noexcept {
  std::uint64_t bit;
  asm("shrx %2, %3, %1\n\tshr $1, %1\n\tadc %0, %0"
      : "+r"(results), "=&r"(bit)
      : "r"(index), "m"(*reinterpret_cast<const WordInRun*>(truth))
      : "cc");
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

/// Results of a chunk that reads `bits`.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline std::uint64_t results_of(const std::byte* chunk, Bits bits) noexcept {
  using Chunk = PackedChunk<kWords>;
  using Record = PackedRecord<kWords>;
  std::uint64_t results = 0;
#pragma GCC unroll 4
  for (std::size_t r = 0; r < kChunkRecords; ++r) {
    const std::byte* const record = chunk + offsetof(Chunk, records) + r * sizeof(Record);
    const std::byte* const in = record + offsetof(Record, in);
    std::uint64_t index = extract(bits.first, in);
    if constexpr (kWords == 2) {
      const auto inputs = load<std::uint8_t>(chunk + offsetof(Chunk, inputs) + r);
      index |= extract(bits.second, in + 8) << (inputs & 63u);
    }
    look_up(results, record + offsetof(Record, truth), index);
  }
  return results;
}

/// `bits` with the results of a chunk that reads `before`.
template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline Bits behind(const std::byte* chunk, Bits before, Bits bits) noexcept {
  using Chunk = PackedChunk<kWords>;
  const std::uint64_t results = results_of<kWords>(chunk, before);
  const auto out = [chunk](std::size_t w) { return load<std::uint64_t>(chunk + offsetof(Chunk, out) + 8 * w); };
  bits.first = (bits.first & ~out(0)) | _pdep_u64(results, out(0));
  if constexpr (kWords == 2) {
    const auto outputs = load<std::uint8_t>(chunk + offsetof(Chunk, outputs));
    bits.second = (bits.second & ~out(1)) | _pdep_u64(results >> (outputs & 63u), out(1));
  }
  bits.keep();
  return bits;
}

template <std::size_t kWords>
PLC_PACKED const std::uint32_t* run(std::byte* table, std::uint32_t instance, const std::uint32_t* words,
                                    std::uint32_t count) noexcept {
  using Chunk = PackedChunk<kWords>;
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

  Bits bits;
  if (field(offsetof(PackedHeader, begins)) != 0) {
    if (windows > 0) bits.first = bits_of(window(0));
    if (kWords == 2 && windows > 1) bits.second = bits_of(window(1));
  } else {
    bits.first = load<std::uint64_t>(state);
    if (kWords == 2) bits.second = load<std::uint64_t>(state + 8);
  }
  bits.first &= ~mask(offsetof(PackedHeader, gathered), 0);
  if (kWords == 2) bits.second &= ~mask(offsetof(PackedHeader, gathered), 1);
  const std::byte* single = header + sizeof(PackedHeader);
  for (std::uint32_t i = 0; i < gathers; ++i, single += sizeof(PackedBit)) {
    const auto bit = load<std::uint32_t>(single + offsetof(PackedBit, bit));
    const std::uint64_t value = std::uint64_t{load<std::uint8_t>(place_of(single))} << (bit & 63u);
    (kWords == 2 && bit > 63 ? bits.second : bits.first) |= value;
  }
  const std::byte* const first_scatter = single;
  const std::byte* at = first_scatter + scatters * sizeof(PackedBit);
  // As they were before the chunk in front, too: two chunks are under way at a time.
  Bits before = bits;
  for (; count > 1; count -= 2, at += 2 * sizeof(Chunk)) {
    before = behind<kWords>(at, before, bits);
    bits = behind<kWords>(at + sizeof(Chunk), bits, before);
  }
  if (count != 0) {
    bits = behind<kWords>(at, before, bits);
    at += sizeof(Chunk);
  }

  if (field(offsetof(PackedHeader, ends)) != 0) {
    put(window(0), bits.first, mask(offsetof(PackedHeader, written), 0));
    if constexpr (kWords == 2) put(window(1), bits.second, mask(offsetof(PackedHeader, written), 1));
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

ValueRun packed_run(std::size_t words) {
  static const bool kFast = is_fast();
  if (!kFast) return nullptr;
  return words == 1 ? &run<1> : &run<2>;
}
#else
ValueRun packed_run(std::size_t /*words*/) { return nullptr; }
#endif

}  // namespace plc::runtime
