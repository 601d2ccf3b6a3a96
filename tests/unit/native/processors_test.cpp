// Random programs leave the same bytes in their tables on every processor. The golden digests are made on one and
// compared on all that the tests run on (scripts/check-aarch64); that native code does what the interpreter does is
// engine_test.cpp's business.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>

#include "bytecode/image.h"
#include "runtime/resource.h"
#include "stdlib/library.h"
#include "tests/support/golden.h"
#include "tests/support/random_image.h"

namespace plc::test {
namespace {

/// FNV-1a of bytes in a row.
class Digest {
 public:
  void add(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) value_ = (value_ ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3ull;
  }
  void add(std::uint64_t number) {
    for (int bit = 0; bit < 64; bit += 8) value_ = (value_ ^ (number >> bit & 0xff)) * 0x100000001b3ull;
  }
  [[nodiscard]] std::string text() const {
    std::array<char, 17> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value_));
    return digits.data();
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

/// Whether the image calls exact functions alone: the last bit of SIN and its like is the C library's.
bool is_exact(const Image& image) {
  return std::all_of(image.functions.begin(), image.functions.end(), [](const std::string& key) {
    const stdlib::Overload* const overload = stdlib::overload_with_key(key);
    return overload != nullptr && overload->spec->foldable;
  });
}

void add_scans(Digest& digest, const Image& image, int scans) {
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(Image(image), diagnostics);
  ASSERT_TRUE(verified.has_value());
  const auto loaded = runtime::Resource::load(std::move(*verified), {.loop_budget = 1000});
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message;
  runtime::Program& program = (*loaded)->program(0);
  for (int scan = 0; scan < scans; ++scan) {
    const runtime::Fault fault = program.execute({core::TimeNs{scan} * 10'000'000});
    digest.add(static_cast<std::uint64_t>(fault.kind));
    digest.add(fault.word);
    digest.add({program.table().data(), program.table().layout().total});
    digest.add(program.event_total());
  }
}

TEST(Processors, RandomProgramsLeaveTheSameTables) {
  std::string text =
      "# What random programs leave in their tables, the same on every processor: seeds, programs among them that "
      "call\n"
      "# exact functions alone, digest of these programs, digest of their tables, faults and events after every "
      "scan.\n";
  constexpr std::uint32_t kAtOnce = 25;
  for (std::uint32_t first = 0; first < 600; first += kAtOnce) {
    Digest images;
    Digest tables;
    int programs = 0;
    for (std::uint32_t seed = first; seed < first + kAtOnce; ++seed) {
      const Image image = RandomImage(seed).make(4 + seed % 60);
      if (!is_exact(image)) continue;
      ++programs;
      images.add(bytecode::save(image));
      add_scans(tables, image, 12);
    }
    text += std::to_string(first) + ".." + std::to_string(first + kAtOnce - 1) + " " + std::to_string(programs) + " " +
            images.text() + " " + tables.text() + "\n";
  }
  expect_golden("tests/golden/processors.txt", text);
}

}  // namespace
}  // namespace plc::test
