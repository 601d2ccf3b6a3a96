// Scans that were recorded are executed again alone, in another engine; and what a record leaves out is found.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "tests/support/failing_taskblock.h"
#include "tests/support/random_image.h"
#include "tests/support/random_inputs.h"
#include "tests/support/replayed.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using Bytes = std::vector<std::byte>;
using Change = std::function<Bytes(std::span<const std::byte>)>;

constexpr core::TimeNs kPeriod = 20'000'000;

/// A random program for some scans, recorded in the interpreter and executed again in native code; `change` is done to
/// each record. What differs first, or nothing.
std::string run(std::uint64_t seed, const Change& change) {
  core::Diagnostics diagnostics;
  const auto image = bytecode::verify(RandomImage(seed, &registry_with_failures()).make(30), diagnostics);
  if (!image) return diagnostics.all().front().message;
  runtime::ProgramOptions options;
  options.taskblocks = &registry_with_failures();
  options.loop_budget = 40;
  std::string problem;
  const auto engines = Engines::link(*image, problem, options, {interpreter()});
  if (engines == nullptr) return problem;
  runtime::Resource& resource = (*engines)[0];
  const auto replayed = Replayed::make(*image, resource, options, native_code(), problem);
  if (replayed == nullptr) return problem;
  replayed->change_records(change);
  Random random(seed);
  RandomInputs inputs(image->image());
  for (std::uint64_t scan = 0; scan < 12; ++scan) {
    inputs.choose(random, 3);
    inputs.write(resource);
    for (std::uint32_t task = 0; task < resource.task_count(); ++task) {
      static_cast<void>(engines->scan(task, static_cast<core::TimeNs>(scan) * kPeriod));
      if (std::string different = replayed->check(task); !different.empty()) return different;
    }
  }
  return {};
}

/// Without the entries of one kind.
Change without(runtime::EntryKind kind) {
  return [kind](std::span<const std::byte> record) {
    Bytes out(record.begin(), record.begin() + sizeof(runtime::RecordHead));
    for (std::size_t at = sizeof(runtime::RecordHead); at < record.size();) {
      runtime::EntryHead entry;
      std::memcpy(&entry, &record[at], sizeof entry);
      const std::size_t size = sizeof entry + runtime::padded(entry.bytes);
      if (entry.kind != kind) out.insert(out.end(), &record[at], &record[at] + size);
      at += size;
    }
    return out;
  };
}

TEST(Replay, RecordsAreAllThatAScanNeeds) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) EXPECT_EQ(run(seed, {}), "") << seed;
}

TEST(Replay, WhatAHookDidNotTellIsFound) {
  using runtime::EntryKind;
  for (const EntryKind kind :
       {EntryKind::kBytes, EntryKind::kQueue, EntryKind::kNumber, EntryKind::kTaskblock, EntryKind::kFault}) {
    std::size_t found = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) found += run(seed, without(kind)).empty() ? 0 : 1;
    EXPECT_GT(found, 0u) << "entries of kind " << static_cast<int>(kind);
  }
}

/// A task that counts by three, recorded in the interpreter and executed again in native code.
struct Counting {
  void load() {
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    const Word count = main.variable("count", b.type(core::TypeId::kDint));
    main.op(Opcode::kAdd32, {count, count, b.constant<std::int32_t>(core::TypeId::kDint, 3)});
    b.task("Cyclic", kPeriod, {main.finish()});
    core::Diagnostics diagnostics;
    image = bytecode::verify(b.build(), diagnostics);
    ASSERT_TRUE(image) << diagnostics.all().front().message;
    std::string problem;
    engines = Engines::link(*image, problem, {}, {interpreter()});
    ASSERT_NE(engines, nullptr) << problem;
    replayed = Replayed::make(*image, (*engines)[0], {}, native_code(), problem);
    ASSERT_NE(replayed, nullptr) << problem;
  }
  std::string scan(core::TimeNs now_ns) {
    static_cast<void>(engines->scan(0, now_ns));
    return replayed->check(0);
  }
  ImageBuilder b;
  std::optional<bytecode::VerifiedImage> image;
  std::unique_ptr<Engines> engines;
  std::unique_ptr<Replayed> replayed;
};

TEST(Replay, AColdStartIsAGapThatACheckpointEnds) {
  Counting t;
  t.load();
  EXPECT_EQ(t.scan(0), "");
  runtime::Program& program = (*t.engines)[0].program(0);
  ASSERT_FALSE(program.reset());
  static_cast<void>(t.engines->scan(0, kPeriod));
  runtime::RecordHead head;
  std::memcpy(&head, t.replayed->ring(0).next().data(), sizeof head);
  EXPECT_EQ(head.kind, runtime::RecordKind::kLost);
  EXPECT_NE(t.replayed->check(0), "") << "the replica knows nothing of it";
  EXPECT_TRUE(t.replayed->recorder(0).ask());
  static_cast<void>(t.engines->scan(0, 2 * kPeriod));
  for (auto record = t.replayed->ring(0).next(); head.kind != runtime::RecordKind::kCheckpointed;
       record = t.replayed->ring(0).next()) {
    ASSERT_FALSE(record.empty());
    std::memcpy(&head, record.data(), sizeof head);
  }
  const auto checkpoint = t.replayed->recorder(0).checkpoint();
  std::memcpy(t.replayed->replica(0).table().data(), checkpoint.data(), checkpoint.size());
  EXPECT_EQ(t.scan(3 * kPeriod), "");
}

TEST(Replay, AVariableWrittenFromOutsideIsInTheRecord) {
  Counting t;
  t.load();
  runtime::Program& program = (*t.engines)[0].program(0);
  const std::int32_t value = 1000;
  EXPECT_EQ(t.scan(0), "");
  program.write_local(program.table().layout().instance, std::as_bytes(std::span(&value, 1)));
  EXPECT_EQ(t.scan(kPeriod), "");
  std::int32_t found = 0;
  std::memcpy(&found, t.replayed->replica(0).table().data() + program.table().layout().instance, sizeof found);
  EXPECT_EQ(found, 1003);
}

}  // namespace
}  // namespace plc::test
