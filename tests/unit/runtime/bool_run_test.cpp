// BOOL_RUN in every form the linker makes, against a plain model.
#include <array>
#include <random>

#include "runtime/interpreter/interpreter.h"
#include "runtime/link/link_bool.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::BoolSegment;
using runtime::GeneralRecord;

struct Net {
  std::vector<std::array<std::uint32_t, 7>> records;  ///< truth, out, inputs: indices of BOOLs
};

Net random_net(std::mt19937& random, std::uint32_t bools, std::size_t count, bool four_inputs) {
  Net net;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint32_t, 7> record{};
    record[0] = static_cast<std::uint32_t>(random());
    if (four_inputs) record[0] = (record[0] & 0xffffu) * 0x10001u;
    for (std::size_t k = 1; k < 7; ++k) record[k] = static_cast<std::uint32_t>(random() % bools);
    net.records.push_back(record);
  }
  return net;
}

void evaluate(const Net& net, std::vector<std::uint8_t>& values) {
  for (const auto& r : net.records) {
    std::uint32_t index = 0;
    for (std::uint32_t k = 0; k < 5; ++k) index |= static_cast<std::uint32_t>(values[r[2 + k]]) << k;
    values[r[1]] = static_cast<std::uint8_t>((r[0] >> index) & 1u);
  }
}

void emit(PouBuilder& pou, const Net& net, const std::vector<Word>& places) {
  std::vector<Word> words;
  for (const auto& r : net.records) {
    words.push_back(r[0]);
    for (std::size_t k = 1; k < 7; ++k) words.push_back(places[r[k]]);
  }
  pou.list(Opcode::kBoolRun, static_cast<std::uint32_t>(net.records.size()), words);
}

/// Runs the net on the BOOLs of array `path` (of `bools`) and on the model; they must agree after each of some scans.
void expect_as_model(runtime::Resource& r, const Net& net, std::uint32_t bools, const std::vector<std::string>& paths) {
  std::mt19937 random(7);
  runtime::Access access(r);
  std::vector<std::uint8_t> model(bools);
  std::vector<runtime::Place> places;
  for (std::uint32_t i = 0; i < bools; ++i) {
    const auto place = access.find_leaf(paths[i]);
    ASSERT_TRUE(place.has_value()) << place.error().message;
    places.push_back(*place);
    model[i] = static_cast<std::uint8_t>(random() & 1u);
    ASSERT_FALSE(access.write(*place, model[i] != 0 ? "1" : "0"));
  }
  for (int scan = 0; scan < 5; ++scan) {
    ASSERT_FALSE(r.program(0).execute({}));
    evaluate(net, model);
    for (std::uint32_t i = 0; i < bools; ++i)
      ASSERT_EQ(access.read_integer(places[i]), model[i]) << "scan " << scan << ", " << paths[i];
  }
}

TEST(BoolRun, WindowedForms) {
  for (const bool four : {true, false}) {
    std::mt19937 random(four ? 1 : 2);
    constexpr std::uint32_t kBools = 300;
    OneProgram p;
    const Word base = p.main.variable("v", p.b.array(p.b.boolean(), kBools));
    const Net net = random_net(random, kBools, 1000, four);
    std::vector<Word> places;
    std::vector<std::string> paths;
    for (std::uint32_t i = 0; i < kBools; ++i) {
      places.push_back(base + i);
      paths.push_back("Main0.v[" + std::to_string(i) + "]");
    }
    emit(p.main, net, places);
    auto r = p.load();
    ASSERT_NE(r, nullptr);
    const auto& report = r->program(0).link_report();
    EXPECT_EQ(four ? report.short4_records : report.short5_records, 1000u);
    EXPECT_EQ(report.wide_records, 0u);
    expect_as_model(*r, net, kBools, paths);
  }
}

TEST(BoolRun, SpreadOverMoreThanAWindow) {
  std::mt19937 random(3);
  constexpr std::uint32_t kBools = 200;
  constexpr std::uint32_t kStride = 1000;
  OneProgram p;
  const Word base = p.main.variable("v", p.b.array(p.b.boolean(), kBools * kStride));
  const Net net = random_net(random, kBools, 500, false);
  std::vector<Word> places;
  std::vector<std::string> paths;
  for (std::uint32_t i = 0; i < kBools; ++i) {
    places.push_back(base + i * kStride);
    paths.push_back("Main0.v[" + std::to_string(i * kStride) + "]");
  }
  emit(p.main, net, places);
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(r->program(0).link_report().wide_records, 500u);
  expect_as_model(*r, net, kBools, paths);
}

TEST(BoolRun, BodiesWithSeveralInstances) {
  // Records of the instance alone, then some that mix it with globals.
  std::mt19937 random(4);
  constexpr std::uint32_t kOwn = 40;
  constexpr std::uint32_t kGlobals = 10;
  OneProgram p;
  const Word globals = p.b.global("g", p.b.array(p.b.boolean(), kGlobals));
  PouBuilder fb = p.b.pou("Logic", PouKind::kFunctionBlock);
  const Word own = fb.variable("v", p.b.array(p.b.boolean(), kOwn));
  std::vector<Word> places;
  std::vector<std::string> paths;
  for (std::uint32_t i = 0; i < kOwn; ++i) {
    places.push_back(own + i);
    paths.push_back("Main0.second.v[" + std::to_string(i) + "]");
  }
  Net net = random_net(random, kOwn, 100, false);
  for (std::uint32_t i = 0; i < kGlobals; ++i) {
    places.push_back(globals + i);
    paths.push_back("g[" + std::to_string(i) + "]");
  }
  const Net mixed = random_net(random, kOwn + kGlobals, 100, true);
  net.records.insert(net.records.end(), mixed.records.begin(), mixed.records.end());
  emit(fb, net, places);
  const std::uint32_t logic = fb.finish();
  p.main.instance_of("first", logic);
  const Word second = p.main.instance_of("second", logic);
  const Word third = p.main.instance_of("third", logic);
  const std::uint32_t never = p.main.jump(Opcode::kJump);
  p.main.op(Opcode::kCallPou, {logic, third});
  p.main.land(never);
  p.main.op(Opcode::kCallPou, {logic, second});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_GT(r->program(0).link_report().mixed_records, 0u);
  EXPECT_GE(r->program(0).link_report().short5_records, 100u);
  expect_as_model(*r, net, kOwn + kGlobals, paths);
  EXPECT_EQ(value_of(*r, "Main0.first.v[0]"), "0");
}

TEST(BoolRun, AJumpMayLandBetweenRuns) {
  OneProgram p;
  const Word c = p.main.variable("c", p.b.boolean());
  const Word a = p.main.variable("a", p.b.boolean());
  const Word d = p.main.variable("d", p.b.boolean());
  const std::uint32_t skip = p.main.jump(Opcode::kCondJump, {c});
  p.main.record(0xffffffffu, a, {a});
  p.main.land(skip);
  p.main.record(0xffffffffu, d, {d});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a"), "0");
  EXPECT_EQ(value_of(*r, "Main0.d"), "1");
  set(*r, "Main0.c", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a"), "1");
}

std::size_t total(const std::vector<BoolSegment>& segments) {
  std::size_t sum = 0;
  for (const BoolSegment& s : segments) {
    EXPECT_EQ(s.first, sum);
    sum += s.count;
  }
  return sum;
}

TEST(BoolRun, SegmentsCoverTheRunInOrder) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<GeneralRecord> records(1 + random() % 400);
    const std::uint32_t spread = 1u << (random() % 24);
    std::uint32_t drift = 0;
    for (GeneralRecord& r : records) {
      r.truth = (random() & 3u) != 0 ? (static_cast<std::uint32_t>(random()) & 0xffffu) * 0x10001u : 0x12345678u;
      const std::uint32_t relative = (round % 3 == 0 && (random() & 63u) == 0) ? runtime::kRelativeBit : 0;
      drift += static_cast<std::uint32_t>(random() % 200);
      r.out = (drift + static_cast<std::uint32_t>(random()) % spread) | relative;
      for (auto& in : r.in) in = drift + static_cast<std::uint32_t>(random()) % spread;
    }
    const auto segments = cut_into_segments(records);
    ASSERT_EQ(total(segments), records.size());
    for (const BoolSegment& s : segments) {
      if (s.form == BoolSegment::Form::kGeneral) continue;
      for (std::uint32_t i = s.first; i < s.first + s.count; ++i) {
        const auto shorter = runtime::shorten(records[i], s.window);
        ASSERT_EQ(s.window + shorter.out, records[i].out);
        for (std::size_t k = 0; k < 5; ++k) ASSERT_EQ(s.window + shorter.in[k], records[i].in[k]);
        if (s.form == BoolSegment::Form::kShort4) {
          ASSERT_TRUE(runtime::ignores_last_input(records[i].truth));
        }
      }
    }
  }
}

}  // namespace
}  // namespace plc::test
