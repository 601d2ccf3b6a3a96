// Image files: what is saved is loaded again, and no bytes whatever do more harm than a message.
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "bytecode/format.h"
#include "bytecode/image.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using bytecode::load;
using bytecode::save;
using core::Code;

TEST(ImageFile, RoundTripKeepsEveryByte) {
  Sample s = sample_image();
  s.image.options = {core::Order::kDocument,
                     core::Compat::kBeremiz,
                     core::AddressProfile::kOverlay,
                     core::Coherence::kGlobalLock,
                     true,
                     false,
                     false,
                     core::FinalScan::kOn,
                     "Main",
                     {"FIRST", "SECOND=a b"}};
  s.image.tasks[0].single = "go";
  const std::vector<std::byte> bytes = save(s.image);
  const auto loaded = load(bytes);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(save(*loaded), bytes);
  EXPECT_EQ(loaded->options, s.image.options);
  EXPECT_EQ(loaded->project, "test");
  EXPECT_EQ(loaded->globals[3].address, "%IX0.0");
  EXPECT_EQ(loaded->types[s.colour].members, s.image.types[s.colour].members);
  EXPECT_EQ(loaded->types[s.colour].member_values, s.image.types[s.colour].member_values);
  EXPECT_TRUE(loaded->types[loaded->global_type].fields[2].constant);
  const auto& aliases = loaded->types[loaded->pous[s.motor].instance_type].aliases;
  ASSERT_EQ(aliases.size(), 1u);
  EXPECT_EQ(aliases[0].name, "sensor");
  EXPECT_EQ(aliases[0].global, 3u);
  EXPECT_EQ(loaded->global_initial, s.image.global_initial);
  EXPECT_EQ(loaded->pous[s.main].code, s.image.pous[s.main].code);
  EXPECT_EQ(loaded->pous[s.main].debug[0].at, s.image.pous[s.main].debug[0].at);
  EXPECT_EQ(loaded->blocks[0].layout_hash, s.image.blocks[0].layout_hash);
  EXPECT_EQ(loaded->functions, s.image.functions);
  EXPECT_EQ(loaded->tasks[0].single, "go");
  core::Diagnostics diagnostics;
  EXPECT_TRUE(bytecode::verify(*loaded, diagnostics));
}

TEST(ImageFile, FrozenAddressesAreASectionOfTheirOwn) {
  Sample s = sample_image();
  const std::vector<std::byte> without = save(s.image);
  s.image.frozen_addresses = "path,table,address,type\n\"a,b\",coils,16384,BOOL\n";
  const std::vector<std::byte> with = save(s.image);
  EXPECT_EQ(with.size(), without.size() + bytecode::format::kSectionHeaderBytes + s.image.frozen_addresses.size());
  const auto loaded = load(with);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->frozen_addresses, s.image.frozen_addresses);
  EXPECT_EQ(save(*loaded), with);
  const auto listed = bytecode::assemble(bytecode::disassemble(s.image));
  ASSERT_TRUE(listed) << listed.error().message;
  EXPECT_EQ(listed->frozen_addresses, s.image.frozen_addresses);
  // An empty one is no section, and a second one neither.
  std::vector<std::byte> wrong = without;
  wrong[bytecode::format::kSectionCountAt] = std::byte{9};
  wrong.insert(wrong.end(), {std::byte{9}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}});
  bytecode::reseal(wrong);
  EXPECT_FALSE(load(wrong));
  wrong = with;
  wrong[bytecode::format::kSectionCountAt] = std::byte{10};
  bytecode::reseal(wrong);
  EXPECT_FALSE(load(wrong));
}

TEST(ImageFile, AnEmptyImageIsAnImage) {
  const auto loaded = load(save(bytecode::Image{}));
  ASSERT_TRUE(loaded);
  core::Diagnostics diagnostics;
  EXPECT_FALSE(bytecode::verify(*loaded, diagnostics));
}

TEST(ImageFile, TruncationAnywhereIsRefused) {
  const std::vector<std::byte> bytes = save(whole_sample_image());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(load(cut)) << size;
    bytecode::reseal(cut);  // also when the checksum was made for the rest
    EXPECT_FALSE(load(cut)) << size;
  }
}

TEST(ImageFile, AFlippedBitAnywhereIsRefused) {
  std::vector<std::byte> bytes = save(whole_sample_image());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const auto bit = static_cast<std::byte>(1u << (at % 8));
    bytes[at] ^= bit;
    EXPECT_FALSE(load(bytes)) << at;
    bytes[at] ^= bit;
  }
}

TEST(ImageFile, AResealedByteAnywhereIsLoadedVerifiedOrRefused) {
  const std::vector<std::byte> bytes = save(whole_sample_image());
  std::size_t refused_by_load = 0, refused_by_verify = 0, accepted = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const unsigned change : {0x01u, 0x80u, 0xffu}) {
      std::vector<std::byte> mutant = bytes;
      mutant[at] ^= static_cast<std::byte>(change);
      bytecode::reseal(mutant);
      auto loaded = load(mutant);
      if (!loaded) {
        ++refused_by_load;
        continue;
      }
      core::Diagnostics diagnostics;
      const bool good = bytecode::verify(std::move(*loaded), diagnostics).has_value();
      EXPECT_EQ(good, diagnostics.all().empty());
      ++(good ? accepted : refused_by_verify);
    }
  }
  EXPECT_GT(refused_by_load, 0u);
  EXPECT_GT(refused_by_verify, 0u);
  EXPECT_GT(accepted, 0u);
}

TEST(ImageFile, ProblemsAreToldApart) {
  std::vector<std::byte> bytes = save(sample_image().image);
  const auto code = [](const std::vector<std::byte>& b) { return load(b).error().code; };
  std::vector<std::byte> other = bytes;
  other[0] = std::byte{'X'};
  EXPECT_EQ(code(other), Code::P6001);
  other = bytes;
  other[bytecode::format::kVersionAt] = std::byte{99};
  EXPECT_EQ(code(other), Code::P6002);
  other = bytes;
  other.back() ^= std::byte{1};
  EXPECT_EQ(code(other), Code::P6003);
  other = bytes;
  other.push_back(std::byte{0});
  bytecode::reseal(other);
  EXPECT_EQ(code(other), Code::P6004);
}

TEST(ImageFile, CountsThatTheBytesCannotHoldAreRefusedAtOnce) {
  const std::vector<std::byte> bytes = save(sample_image().image);
  // Every place that could be a count says "four thousand million".
  for (std::size_t at = bytecode::format::kHeaderBytes; at + 4 <= bytes.size(); ++at) {
    std::vector<std::byte> mutant = bytes;
    std::memset(mutant.data() + at, 0xff, 4);
    bytecode::reseal(mutant);
    const auto loaded = load(mutant);
    if (!loaded) {
      EXPECT_EQ(loaded.error().code, Code::P6004);
    }
  }
}

TEST(ImageFile, ATextCannotBeMultipliedWithoutBound) {
  bytecode::Image image;
  image.project.assign(60000, 'x');
  image.files.assign(5000, image.project);  // 300 MB from 80 kB
  EXPECT_FALSE(load(save(image)));
}

}  // namespace
}  // namespace plc::test
