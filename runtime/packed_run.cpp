#include "runtime/packed_run.h"

#include <cstring>

#include "runtime/operations.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace plc::runtime {

#ifdef __x86_64__
namespace {

#define PLC_PACKED [[gnu::target("avx2,bmi2")]]

/// The lowest bit of each byte.
PLC_PACKED inline std::uint64_t bits_of(const std::byte* window) noexcept {
  const auto half = [](const std::byte* at) __attribute__((target("avx2,bmi2"), always_inline)) {
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

/// Shifts the bit `index` of `truth` into `results`.
inline void look_up(std::uint64_t& results, std::uint64_t truth, std::uint64_t index) noexcept {
  asm("bt %2, %1\n\tadc %0, %0" : "+r"(results) : "r"(truth), "r"(index) : "cc");
}

/// Keeps a word in a register of its own: compilers like to bring two of them into one vector.
inline void keep(std::uint64_t& word) noexcept { asm("" : "+r"(word)); }

template <std::size_t kWords>
PLC_PACKED [[gnu::always_inline]] inline std::uint64_t results_of(const std::byte* chunk, std::uint64_t first,
                                                                  std::uint64_t second) noexcept {
  using Chunk = PackedChunk<kWords>;
  using Record = PackedRecord<kWords>;
  std::uint64_t results = 0;
#pragma GCC unroll 4
  for (std::size_t r = 0; r < kChunkRecords; ++r) {
    const std::byte* const record = chunk + offsetof(Chunk, records) + r * sizeof(Record);
    const std::byte* const in = record + offsetof(Record, in);
    std::uint64_t index = _pext_u64(first, load<std::uint64_t>(in));
    if constexpr (kWords == 2) {
      const auto inputs = load<std::uint8_t>(chunk + offsetof(Chunk, inputs) + r);
      index |= _pext_u64(second, load<std::uint64_t>(in + 8)) << (inputs & 63u);
    }
    look_up(results, load<std::uint64_t>(record + offsetof(Record, truth)), index);
  }
  return results;
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

  std::uint64_t first = 0, second = 0;
  if (field(offsetof(PackedHeader, begins)) != 0) {
    if (windows > 0) first = bits_of(window(0));
    if (kWords == 2 && windows > 1) second = bits_of(window(1));
  } else {
    first = load<std::uint64_t>(state);
    if (kWords == 2) second = load<std::uint64_t>(state + 8);
  }
  first &= ~mask(offsetof(PackedHeader, gathered), 0);
  if (kWords == 2) second &= ~mask(offsetof(PackedHeader, gathered), 1);
  const std::byte* single = header + sizeof(PackedHeader);
  for (std::uint32_t i = 0; i < gathers; ++i, single += sizeof(PackedBit)) {
    const auto bit = load<std::uint32_t>(single + offsetof(PackedBit, bit));
    const std::uint64_t value = std::uint64_t{load<std::uint8_t>(place_of(single))} << (bit & 63u);
    (kWords == 2 && bit > 63 ? second : first) |= value;
  }
  const std::byte* const first_scatter = single;
  const std::byte* at = first_scatter + scatters * sizeof(PackedBit);
  std::uint64_t later_first = first, later_second = second;
  for (; count != 0; --count, at += sizeof(Chunk)) {
    const std::uint64_t results = results_of<kWords>(at, first, second);
    first = later_first;
    const auto out = load<std::uint64_t>(at + offsetof(Chunk, out));
    later_first = (later_first & ~out) | _pdep_u64(results, out);
    keep(later_first);
    if constexpr (kWords == 2) {
      second = later_second;
      const auto out_second = load<std::uint64_t>(at + offsetof(Chunk, out) + 8);
      const auto outputs = load<std::uint8_t>(at + offsetof(Chunk, outputs));
      later_second = (later_second & ~out_second) | _pdep_u64(results >> (outputs & 63u), out_second);
      keep(later_second);
    }
  }

  if (field(offsetof(PackedHeader, ends)) != 0) {
    put(window(0), later_first, mask(offsetof(PackedHeader, written), 0));
    if constexpr (kWords == 2) put(window(1), later_second, mask(offsetof(PackedHeader, written), 1));
  } else {
    store(state, later_first);
    if constexpr (kWords == 2) store(state + 8, later_second);
  }
  single = first_scatter;
  for (std::uint32_t i = 0; i < scatters; ++i, single += sizeof(PackedBit)) {
    const auto bit = load<std::uint32_t>(single + offsetof(PackedBit, bit));
    const std::uint64_t word = kWords == 2 && bit > 63 ? later_second : later_first;
    store(place_of(single), static_cast<std::uint8_t>((word >> (bit & 63u)) & 1u));
  }
  return reinterpret_cast<const std::uint32_t*>(at);
}

/// AMD's first two generations with PEXT take as long for it as for twenty loads.
bool is_fast() {
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi2") != 0 &&
         __builtin_cpu_is("znver1") == 0 && __builtin_cpu_is("znver2") == 0;
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
