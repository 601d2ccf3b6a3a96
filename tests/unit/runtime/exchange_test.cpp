// The exchange between tasks, the outside and drivers: who sees what when, and that nobody ever sees half of it.
#include "runtime/memory/exchange.h"

#include <gtest/gtest.h>

#include <array>

#include "runtime/memory/process_image.h"
#include "tests/unit/runtime/exchange_support.h"

namespace plc::test {
namespace {

TEST(Exchange, AnExportIsSeenAtTheReadersNextStart) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask writer(globals, 0);
  HandTask reader(globals, 1);
  reader.begin();
  writer.begin();
  writer.put<std::int32_t>(x, 7);
  EXPECT_EQ(t.read<std::int32_t>(x), 0) << "published before the end of the cycle";
  writer.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 7);
  EXPECT_EQ(reader.get<std::int32_t>(x), 0) << "a running cycle saw a change";
  reader.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 7) << "a reader exported what it does not own";
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(x), 7);
  reader.end();
}

TEST(Exchange, AReaderKeepsItsSnapshotWhileTheWriterGoesOn) {
  Tables t;
  const std::uint32_t x = t.global("x", t.b.type(TypeId::kDint), {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask writer(globals, 0);
  GlobalReader reader(globals);
  reader.take();
  for (std::int32_t i = 1; i <= 20; ++i) {
    writer.begin();
    writer.put(x, i);
    writer.end();
    std::int32_t seen = -1;
    reader.read(x, sizeof seen, reinterpret_cast<std::byte*>(&seen));
    EXPECT_EQ(seen, 0);
  }
  reader.take();
  std::int32_t seen = -1;
  reader.read(x, sizeof seen, reinterpret_cast<std::byte*>(&seen));
  EXPECT_EQ(seen, 20);
}

TEST(Exchange, OutsideWritesWaitForTheExportersNextStart) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask owner(globals, 0);
  owner.begin();
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 5), WriteResult::kDone);
  owner.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 0) << "the running cycle published a write it had not seen";
  owner.begin();
  EXPECT_EQ(owner.get<std::int32_t>(x), 5);
  owner.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 5);
}

TEST(Exchange, MasksApplyAtTheOwnerOneAfterTheOther) {
  Tables t;
  const std::uint32_t dword = t.b.type(TypeId::kDword);
  const std::uint32_t owned = t.global("owned", dword, {.owner = 0});
  const std::uint32_t outside = t.global("outside", dword, {.input = true});
  const std::uint32_t shared = t.global("shared", dword);
  GlobalTable& globals = t.build();
  HandTask owner(globals, 0);
  for (const std::uint32_t x : {owned, outside, shared}) {
    EXPECT_EQ(t.write<std::uint32_t>(x, dword, 0x12345678u, 0xffff0000u), WriteResult::kDone);
    EXPECT_EQ(t.write<std::uint32_t>(x, dword, 0x12345678u, 0x0000ff00u), WriteResult::kDone);
    const std::uint32_t bits = 0x000000f1u;
    const std::uint32_t mask = 0x00000001u;
    const GlobalWrite twice[] = {
        {x, dword, reinterpret_cast<const std::byte*>(&bits), reinterpret_cast<const std::byte*>(&mask)},
        {x, dword, reinterpret_cast<const std::byte*>(&bits), reinterpret_cast<const std::byte*>(&bits)},
    };
    EXPECT_EQ(globals.write(twice), WriteResult::kDone);
  }
  owner.begin();
  for (const std::uint32_t x : {owned, outside, shared}) EXPECT_EQ(owner.get<std::uint32_t>(x), 0x123456f1u);
  owner.end();
  for (const std::uint32_t x : {owned, outside, shared}) EXPECT_EQ(t.read<std::uint32_t>(x), 0x123456f1u);
}

TEST(Exchange, WritesAreNormalised) {
  Tables t;
  const std::uint32_t boolean = t.b.boolean();
  const std::uint32_t percent = t.b.limited(TypeId::kInt, 0, 100);
  const std::uint32_t real = t.b.type(TypeId::kReal);
  const std::uint32_t text = t.b.string(3);
  const std::uint32_t a = t.global("a", boolean, {.input = true});
  const std::uint32_t p = t.global("p", percent, {.input = true});
  const std::uint32_t r = t.global("r", real, {.input = true});
  const std::uint32_t s = t.global("s", text, {.input = true});
  GlobalTable& globals = t.build(1);
  EXPECT_EQ(t.write<std::uint8_t>(a, boolean, 0x40), WriteResult::kDone);
  EXPECT_EQ(t.read<std::uint8_t>(a), 1);
  t.write<std::int16_t>(p, percent, 100);
  t.write<std::int16_t>(p, percent, 101);
  EXPECT_EQ(t.read<std::int16_t>(p), 100) << "outside the subrange";
  t.write<std::int16_t>(p, percent, 0x100, std::int16_t{0x100});
  EXPECT_EQ(t.read<std::int16_t>(p), 100) << "a masked write led outside the subrange";
  t.write<std::uint32_t>(r, real, 0xffc12345u);
  EXPECT_EQ(t.read<std::uint32_t>(r), 0x7fc00000u) << "not the one NaN";
  struct Text {
    std::uint16_t capacity = 9;
    std::uint16_t length = 9;
    char bytes[4] = {'a', 'b', 'c', 'd'};
  } forged;
  const GlobalWrite write{s, text, reinterpret_cast<const std::byte*>(&forged), nullptr};
  EXPECT_EQ(globals.write({&write, 1}), WriteResult::kDone);
  EXPECT_EQ(t.read<core::StringHeader>(s).capacity, 3);
  EXPECT_EQ(t.read<core::StringHeader>(s).length, 3);
}

TEST(Exchange, ConstantsAndDriverInputsAreRefused) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t fixed = t.global("fixed", dint, {.constant = true});
  const std::uint32_t in = t.global("in", dint, {.input = true});
  const std::uint32_t out = t.global("out", dint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  EXPECT_FALSE(globals.claimable(0));
  EXPECT_TRUE(globals.claimable(1));
  EXPECT_FALSE(globals.claimable(2)) << "a task exports it";
  HandTask task(globals, 0);
  const std::uint32_t fields[] = {1};
  GlobalInputs inputs(globals, fields);
  EXPECT_FALSE(globals.claimable(1)) << "claimed twice";
  EXPECT_EQ(t.write<std::int32_t>(fixed, dint, 1), WriteResult::kRefused);
  EXPECT_EQ(t.write<std::int32_t>(in, dint, 1), WriteResult::kRefused);
  const std::int32_t one = 1;
  const auto* const bytes = reinterpret_cast<const std::byte*>(&one);
  const GlobalWrite mixed[] = {{out, dint, bytes, nullptr}, {in, dint, bytes, nullptr}};
  EXPECT_EQ(globals.write(mixed), WriteResult::kRefused);
  task.begin();
  EXPECT_EQ(task.get<std::int32_t>(out), 0) << "half of a refused batch was written";
  task.end();
  inputs.set(in, dint, bytes);
  EXPECT_EQ(t.read<std::int32_t>(in), 0);
  inputs.publish();
  task.begin();
  EXPECT_EQ(task.get<std::int32_t>(in), 1);
  task.end();
}

TEST(Exchange, AnInputOutsideOfItsSubrangeIsTheNearestValue) {
  Tables t;
  const std::uint32_t percent = t.b.limited(TypeId::kInt, 0, 100);
  const std::uint32_t large = t.b.limited(TypeId::kUlint, 0, 10);
  const std::uint32_t p = t.global("p", percent, {.input = true});
  const std::uint32_t l = t.global("l", large, {.input = true});
  GlobalTable& globals = t.build(1);
  const std::uint32_t fields[] = {0, 1};
  GlobalInputs inputs(globals, fields);
  const auto set = [&](std::int16_t number, std::uint64_t ulint) {
    inputs.set(p, percent, reinterpret_cast<const std::byte*>(&number));
    inputs.set(l, large, reinterpret_cast<const std::byte*>(&ulint));
    inputs.publish();
  };
  set(500, ~std::uint64_t{0});
  EXPECT_EQ(t.read<std::int16_t>(p), 100);
  EXPECT_EQ(t.read<std::uint64_t>(l), 10u);
  set(-7, 0);
  EXPECT_EQ(t.read<std::int16_t>(p), 0);
  EXPECT_EQ(t.read<std::uint64_t>(l), 0u);
  set(42, 7);
  EXPECT_EQ(t.read<std::int16_t>(p), 42);
  EXPECT_EQ(t.read<std::uint64_t>(l), 7u);
}

TEST(Exchange, AFullJournalIsBusyAndRecovers) {
  Tables t;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  const std::uint32_t x = t.global("x", lint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  HandTask task(globals, 0);
  for (int round = 0; round < 3; ++round) {
    std::int64_t written = 0;
    while (t.write<std::int64_t>(x, lint, written + 1) == WriteResult::kDone) ++written;
    EXPECT_GT(written, 500);
    EXPECT_LT(written, 100'000);
    task.begin();
    EXPECT_EQ(task.get<std::int64_t>(x), written);
    task.end();
  }
}

TEST(Exchange, OfSeveralWritersTheLastChangeCounts) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t text = t.b.string(20);
  const std::uint32_t x = t.global("x", dint);
  const std::uint32_t y = t.global("y", dint);
  const std::uint32_t s = t.global("s", text);
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  a.begin();
  b.begin();
  a.put<std::int32_t>(x, 1);
  b.put<std::int32_t>(y, 2);
  b.put(s, core::StringHeader{20, 7});
  a.end();
  b.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 1) << "a task that did not change a value published it";
  EXPECT_EQ(t.read<std::int32_t>(y), 2);
  struct Text {
    core::StringHeader header;
    std::byte bytes[20];
  };
  EXPECT_EQ(t.read<Text>(s).header.length, 7);
  b.begin();
  EXPECT_EQ(b.get<std::int32_t>(x), 1);
  b.put<std::int32_t>(x, 3);
  b.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 3);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 4), WriteResult::kDone);
  EXPECT_EQ(t.read<std::int32_t>(x), 4) << "the outside publishes shared values at once";
  a.begin();
  EXPECT_EQ(a.get<std::int32_t>(x), 4);
  a.put<std::int32_t>(x, 5);
  a.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 5);
}

TEST(Exchange, OverlappingAddressesAreSingleValues) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t word = t.b.type(TypeId::kWord);
  const std::uint32_t bit = t.global("bit", t.b.boolean(), {.address = "%QX0.3", .owner = 0});
  const std::uint32_t whole = t.global("whole", word, {.address = "%QW0", .owner = 1});
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  runtime::ProcessImage image(globals.image(), globals);
  a.begin();
  a.put<std::uint8_t>(bit, 1);
  a.end();
  image.sync();
  b.begin();
  EXPECT_EQ(b.get<std::uint16_t>(whole), 8);
  b.put<std::uint16_t>(whole, 0x8000);
  b.end();
  image.sync();
  EXPECT_EQ(t.read<std::uint8_t>(bit), 0);
  EXPECT_EQ(t.write<std::uint16_t>(whole, word, 0x0008, std::uint16_t{0x0008}), WriteResult::kDone);
  image.sync();
  EXPECT_EQ(t.read<std::uint8_t>(bit), 1);
  EXPECT_EQ(t.read<std::uint16_t>(whole), 0x8008);
}

TEST(Exchange, AClaimCoversWhatSharesItsBits) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t word = t.b.type(TypeId::kWord);
  t.global("bit", t.b.boolean(), {.input = true, .address = "%MX0.3"});
  const std::uint32_t whole = t.global("whole", word, {.input = true, .address = "%MW0"});
  t.global("out", t.b.boolean(), {.address = "%QX0.0", .owner = 0});
  t.global("outs", word, {.input = true, .address = "%QW0"});
  GlobalTable& globals = t.build(1);
  EXPECT_FALSE(globals.claimable(3)) << "a task exports a bit of it";
  const std::uint32_t bit_field[] = {0};
  GlobalInputs inputs(globals, bit_field);
  EXPECT_FALSE(globals.writable(1));
  EXPECT_EQ(t.write<std::uint16_t>(whole, word, 8), WriteResult::kRefused);
}

TEST(Exchange, AnExportBetweenTwoSyncsIsNotUndone) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t bit = t.global("bit", t.b.boolean(), {.address = "%QX0.0", .owner = 0});
  t.global("whole", t.b.type(TypeId::kWord), {.input = true, .address = "%QW0"});
  GlobalTable& globals = t.build(1);
  HandTask task(globals, 0);
  runtime::ProcessImage image(globals.image(), globals);
  std::atomic<bool> stop{false};
  std::thread other([&] {
    while (!stop) image.sync();
  });
  std::uint64_t undone = 0;
  for (int round = 0; round < 20'000; ++round) {
    const auto wanted = static_cast<std::uint8_t>(round % 2);
    task.begin();
    task.put(bit, wanted);
    task.end();
    image.sync();
    if (t.read<std::uint8_t>(bit) != wanted) ++undone;
  }
  stop = true;
  other.join();
  EXPECT_EQ(undone, 0u);
}

TEST(Exchange, AStoppedTaskTakesNoWrites) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 1), WriteResult::kDone);
  globals.task_stopped(0);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 2), WriteResult::kBusy);
  globals.reset();
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 3), WriteResult::kDone);
}

TEST(Exchange, ALateStampIsSeen) {
  // The change with the lower stamp is published after the one with the higher: both must arrive.
  Tables t;
  const std::uint32_t pair = t.global("pair", t.b.array(t.b.type(TypeId::kDint), 2));
  GlobalTable& globals = t.build(3);
  HandTask early(globals, 0);
  HandTask late(globals, 1);
  HandTask reader(globals, 2);
  early.begin();
  early.put<std::int32_t>(pair, 1);
  early.export_only();
  late.begin();
  late.put<std::int32_t>(pair + 4, 2);
  late.end();
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(pair + 4), 2);
  reader.end();
  early.finish();
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(pair), 1);
  EXPECT_EQ(reader.get<std::int32_t>(pair + 4), 2);
  reader.end();
}

/// The watchdog's part: a task that computes loses the right to publish, one that exports does not.
class Revocation : public testing::TestWithParam<core::Coherence> {};

TEST_P(Revocation, ARevokedCycleHasNoEffectAndSafeValuesStand) {
  Tables t;
  t.b.image.options.coherence = GetParam();
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t output = t.global("output", dint, {.owner = 0});
  const std::uint32_t other = t.global("other", dint, {.owner = 0});
  const std::uint32_t shared = t.global("shared", dint);
  GlobalTable& globals = t.build();
  HandTask task(globals, 0);
  HandTask reader(globals, 1);
  EXPECT_FALSE(task.exchange().revoke()) << "between cycles";
  task.begin();
  task.put<std::int32_t>(output, 1);
  task.put<std::int32_t>(other, 2);
  task.put<std::int32_t>(shared, 3);
  task.export_only();
  EXPECT_FALSE(task.exchange().revoke()) << "it exports already";
  EXPECT_TRUE(task.finish());
  task.begin();
  task.put<std::int32_t>(output, 10);
  task.put<std::int32_t>(other, 20);
  task.put<std::int32_t>(shared, 30);
  ASSERT_TRUE(task.exchange().revoke());
  const std::int32_t safe = 77;
  const auto* const bytes = reinterpret_cast<const std::byte*>(&safe);
  const std::array<GlobalWrite, 2> values = {{{output, dint, bytes, nullptr}, {shared, dint, bytes, nullptr}}};
  task.exchange().publish_safe(values);
  task.export_only();
  EXPECT_FALSE(task.finish());
  EXPECT_EQ(t.read<std::int32_t>(output), 77);
  EXPECT_EQ(t.read<std::int32_t>(other), 2) << "as published last";
  EXPECT_EQ(t.read<std::int32_t>(shared), 77);
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(output), 77);
  EXPECT_EQ(reader.get<std::int32_t>(other), 2);
  EXPECT_EQ(reader.get<std::int32_t>(shared), 77);
  reader.end();
}

INSTANTIATE_TEST_SUITE_P(Protocols, Revocation,
                         testing::Values(core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling,
                                         core::Coherence::kGlobalLock));

}  // namespace
}  // namespace plc::test
