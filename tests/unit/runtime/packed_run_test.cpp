// Packed runs against a plain model: windows, bytes outside of them, scratch memory, instances.
#include "runtime/packed_run.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "runtime/link_packed.h"

namespace plc::test {
namespace {

using runtime::GeneralRecord;
using runtime::LogicRecord;

constexpr std::uint32_t kTableBytes = 4096, kScratch = 3000, kInstance = 2000;

std::uint32_t place_of(std::uint32_t operand) {
  return (operand & ~runtime::kRelativeBit) + ((operand & runtime::kRelativeBit) != 0 ? kInstance : 0);
}

/// Logic as the linker's arranging leaves it.
struct Logic {
  std::vector<LogicRecord> records;
  std::set<std::uint32_t> unneeded;  ///< places that may hold anything behind it

  /// `operands`: what the records use; some results go to scratch memory, and are used from there by later ones.
  static Logic random(std::mt19937& random, const std::vector<std::uint32_t>& operands, std::size_t count) {
    const auto one_of = [&](const auto& all) { return all[random() % all.size()]; };
    Logic logic;
    std::vector<std::uint32_t> scratch;
    for (std::uint32_t s = 0; s < 4; ++s) scratch.push_back(kScratch + 8 * s);
    std::vector<std::size_t> writer(kTableBytes, count);
    for (std::size_t i = 0; i < count; ++i) {
      LogicRecord r;
      constexpr std::uint8_t kInputs[] = {2, 4, 5};
      r.inputs = kInputs[random() % 3];
      r.record.truth = static_cast<std::uint32_t>(random());
      if (r.inputs < 5) r.record.truth = (r.record.truth & 0xffffu) * 0x10001u;
      if (r.inputs < 4) r.record.truth = (r.record.truth & 0xfu) * 0x11111111u;
      for (std::uint32_t& in : r.record.in) in = random() % 4 == 0 ? one_of(scratch) : one_of(operands);
      r.scratch = random() % 3 == 0;
      r.record.out = r.scratch ? one_of(scratch) : one_of(operands);
      if (r.scratch) {
        // What another value replaces is of no use behind the run.
        std::size_t& before = writer[r.record.out];
        if (before != count) logic.records[before].needed = false;
        before = i;
      }
      logic.records.push_back(r);
    }
    for (const std::uint32_t s : scratch) {
      if (writer[s] == count || random() % 2 == 0) continue;
      logic.records[writer[s]].needed = false;
      logic.unneeded.insert(s);
    }
    return logic;
  }

  void evaluate(std::vector<std::uint8_t>& bytes) const {
    for (const LogicRecord& r : records) {
      std::uint32_t index = 0;
      for (std::uint32_t k = 0; k < r.inputs; ++k) {
        index |= static_cast<std::uint32_t>(bytes[place_of(r.record.in[k])]) << k;
      }
      bytes[place_of(r.record.out)] = static_cast<std::uint8_t>((r.record.truth >> index) & 1u);
    }
  }

  /// Runs both on random bytes. Operands hold BOOLs, everything else any bytes, which nobody may change.
  void expect_as_model(std::mt19937& random, const runtime::PackedWords& packed) const {
    std::vector<std::uint8_t> bytes(kTableBytes);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    for (const LogicRecord& r : records) {
      bytes[place_of(r.record.out)] &= 1u;
      for (const std::uint32_t in : r.record.in) bytes[place_of(in)] &= 1u;
    }
    std::vector<std::uint8_t> model = bytes;
    evaluate(model);
    const runtime::ValueRun run = runtime::packed_run(packed.bits);
    const std::uint32_t* const end =
        run(reinterpret_cast<std::byte*>(bytes.data()), kInstance, packed.words.data(), packed.chunks);
    EXPECT_EQ(end, packed.words.data() + packed.words.size());
    for (std::uint32_t i = 0; i < kTableBytes; ++i) {
      if (unneeded.contains(i)) continue;
      ASSERT_EQ(bytes[i], model[i]) << i;
    }
  }
};

std::vector<std::uint32_t> row(std::uint32_t first, std::uint32_t count, std::uint32_t step = 1) {
  std::vector<std::uint32_t> operands;
  for (std::uint32_t i = 0; i < count; ++i) operands.push_back(first + step * i);
  return operands;
}
std::vector<std::uint32_t> joined(std::vector<std::uint32_t> a, const std::vector<std::uint32_t>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class PackedRun : public testing::Test {
 protected:
  void SetUp() override {
    if (runtime::packed_run(1) == nullptr) GTEST_SKIP() << "this processor has no fast PEXT";
  }
};

TEST_F(PackedRun, RunsAsTheModel) {
  const std::vector<std::uint32_t> kPlaces[] = {
      row(100, 8),
      row(101, 60),
      row(77, 110),
      row(10, 40, 3),                                        // outside of windows, mostly
      joined(row(100, 30), row(1000, 30)),                   // two windows
      joined(row(100, 20), row(runtime::kRelativeBit, 30)),  // of an instance
      joined(row(100, 62), row(500, 20, 70)),
  };
  std::mt19937 random(3);
  std::size_t packed_in[3] = {};
  for (const auto& places : kPlaces) {
    for (int n = 0; n < 300; ++n) {
      const Logic logic = Logic::random(random, places, 1 + random() % 120);
      const auto packed = runtime::pack(logic.records);
      if (!packed) continue;
      ++packed_in[packed->bits];
      for (int scan = 0; scan < 3; ++scan) logic.expect_as_model(random, *packed);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(packed_in[1], 300u);
  EXPECT_GT(packed_in[2], 300u);
}

TEST_F(PackedRun, TooManyVariablesAreNotPacked) {
  Logic logic;
  for (std::uint32_t i = 0; i < 65; ++i) {
    GeneralRecord r;
    r.out = 2 * i;
    for (std::uint32_t& in : r.in) in = 2 * i + 1;
    logic.records.push_back({r, 2, false, true});
  }
  EXPECT_FALSE(runtime::pack(logic.records));
  logic.records.pop_back();
  EXPECT_TRUE(runtime::pack(logic.records));
}

TEST_F(PackedRun, PaysForManyIndependentRecordsOnFewVariables) {
  Logic many, chain, far;
  for (std::uint32_t i = 0; i < 48; ++i) {
    GeneralRecord r;
    r.truth = 0x80008000u;
    r.out = i;
    for (std::uint32_t k = 0; k < 5; ++k) r.in[k] = 48 + (i + k) % 16;
    many.records.push_back({r, 4, false, true});
    far.records.push_back({r, 4, false, true});
    far.records.back().record.out = 200 + 100 * i;
    for (std::uint32_t& in : r.in) in = i == 0 ? 48 : i - 1;
    chain.records.push_back({r, 4, false, true});
  }
  EXPECT_TRUE(runtime::pack(many.records)->pays);
  EXPECT_FALSE(runtime::pack(chain.records)->pays) << "each record waits for the one before";
  EXPECT_FALSE(runtime::pack(far.records)->pays) << "no window holds the results";
}

}  // namespace
}  // namespace plc::test
