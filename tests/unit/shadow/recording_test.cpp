// Recordings of resources that run, and the player: blocks, gaps, checkpoints, several tasks.
#include "shadow/recording.h"

#include <gtest/gtest.h>

#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "shadow/tracer.h"
#include "tests/unit/runtime/run_support.h"
#include "tests/unit/shadow/two_tasks.h"

namespace plc::test {
namespace {

using Bytes = std::vector<std::byte>;

struct Recorded {
  explicit Recorded(const shadow::RecordingOptions& options = {}) : image(two_tasks()) {
    auto loaded = runtime::Resource::load(bytecode::VerifiedImage(image));
    resource = std::move(*loaded);
    bytes =
        shadow::file_head({"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(image.image())});
    auto started = shadow::Recording::start(
        *resource,
        [this](const shadow::BlockInfo&, const std::vector<std::byte>& block) {
          bytes.insert(bytes.end(), block.begin(), block.end());
        },
        options);
    EXPECT_TRUE(started);
    recording = std::move(*started);
  }
  bytecode::VerifiedImage image;
  std::unique_ptr<runtime::Resource> resource;
  Bytes bytes;
  std::unique_ptr<shadow::Recording> recording;
};

/// All scans of a recording, as "task:scan" with '!' after gaps and '?' where something differs.
std::string played(const Bytes& bytes, std::string* last_values = nullptr) {
  const auto file = shadow::RecordFile::read(bytes, "recording");
  if (!file) return file.error().message;
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  if (!player) return player.error().message;
  std::string text;
  while (const auto scan = (*player)->step()) {
    text += std::to_string(scan->task) + ":" + std::to_string(scan->scan) + (scan->after_gap ? "!" : "") +
            (scan->outcome.equal ? " " : "? ");
  }
  (*player)->show_globals();
  if (last_values != nullptr) {
    runtime::Resource& resource = (*player)->resource();
    *last_values = value_of(resource, "FastCount") + " " + value_of(resource, "SlowSum");
  }
  return text;
}

TEST(Recording, EveryScanIsExecutedAgainInTheOrderOfTime) {
  Recorded r;
  runtime::Simulation simulation(*r.resource);
  simulation.run_cycles(7);
  r.recording->finish();
  std::string values;
  EXPECT_EQ(played(r.bytes, &values), "0:0 1:0 0:1 0:2 0:3 1:1 0:4 0:5 0:6 1:2 ");
  EXPECT_EQ(values, value_of(*r.resource, "FastCount") + " " + value_of(*r.resource, "SlowSum"));
  EXPECT_EQ(r.recording->counts(0).scans, 7u);
  EXPECT_EQ(r.recording->counts(0).lost, 0u);
  EXPECT_EQ(r.recording->counts(1).scans, 3u);
  EXPECT_GT(r.recording->counts(1).stored_bytes, 0u);
}

TEST(Recording, BlocksEndByTimeAndSizeAndBeginWithACheckpoint) {
  for (const bool by_time : {true, false}) {
    shadow::RecordingOptions options;
    if (by_time) {
      options.block_ns = 100'000'000;
    } else {
      options.block_bytes = 600;
    }
    Recorded r(options);
    runtime::Simulation simulation(*r.resource);
    for (int i = 0; i < 300; ++i) {
      simulation.step();
      r.recording->drain();
    }
    r.recording->finish();
    const auto file = shadow::RecordFile::read(r.bytes, "f");
    EXPECT_GT(file->blocks().size(), 20u);
    std::string expected;
    const std::string all = played(r.bytes);
    EXPECT_EQ(all.find_first_of("!?"), std::string::npos) << all;
    EXPECT_NE(all.find("0:299 "), std::string::npos);
    // Each block alone, with the head: it begins with what was there.
    Bytes one = shadow::file_head(file->head());
    const shadow::BlockInfo& info = file->blocks()[file->blocks().size() / 2];
    const auto begin = r.bytes.begin() + static_cast<std::ptrdiff_t>(info.at);
    one.insert(one.end(), begin, begin + 56 + static_cast<std::ptrdiff_t>(info.stored_bytes));
    const std::string part = played(one);
    EXPECT_NE(part.find('!'), std::string::npos) << "scans before it are not there";
    EXPECT_EQ(part.find('?'), std::string::npos) << part;
  }
}

TEST(Recording, AReaderThatSleepsLosesScansAndGoesOnAtTheNextCheckpoint) {
  shadow::RecordingOptions options;
  options.ring_bytes = 4096;
  options.most_record_bytes = 1024;
  Recorded r(options);
  runtime::Simulation simulation(*r.resource);
  simulation.run_cycles(500);
  for (int i = 0; i < 20; ++i) {
    r.recording->drain();
    simulation.step();
  }
  r.recording->finish();
  EXPECT_GT(r.recording->counts(0).lost, 300u);
  EXPECT_EQ(r.recording->counts(0).gaps, 1u);
  const std::string text = played(r.bytes);
  EXPECT_EQ(text.find('?'), std::string::npos) << text;
  EXPECT_NE(text.find("0:519 "), std::string::npos) << text;
  // What is seen after each scan is of that scan, also of the last one before the gap.
  const auto file = shadow::RecordFile::read(r.bytes, "f");
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  ASSERT_TRUE(player);
  while (const auto scan = (*player)->step()) {
    if (scan->task == 0) {
      EXPECT_EQ(value_of((*player)->resource(), "Fast0.count"), std::to_string(scan->scan + 1));
    }
  }
  const std::size_t gap = text.find('!');
  ASSERT_NE(gap, std::string::npos) << text;
  EXPECT_EQ(text.find('!', gap + 1) == std::string::npos, r.recording->counts(1).gaps == 0);
}

TEST(Player, WhatWasChangedInARecordIsFound) {
  Recorded r;
  runtime::Simulation simulation(*r.resource);
  simulation.run_cycles(5);
  r.recording->finish();
  const auto file = shadow::RecordFile::read(r.bytes, "f");
  ASSERT_TRUE(file);
  // Another table to begin with, in a block that is whole.
  Bytes changed = shadow::file_head(file->head());
  for (const shadow::BlockInfo& info : file->blocks()) {
    auto block = *file->load(info);
    if (info.task == 0) block.table[r.resource->program(0).table().layout().instance] ^= std::byte{1};
    shadow::BlockBuilder builder;
    builder.begin(info.task, info.first_scan, block.table);
    shadow::for_each_record(block.records, [&](std::span<const std::byte> one) { return builder.add(one); });
    const Bytes bytes = builder.pack();
    changed.insert(changed.end(), bytes.begin(), bytes.end());
  }
  EXPECT_NE(played(changed).find('?'), std::string::npos);
}

TEST(Player, ATableOfAnotherSizeIsADamagedBlock) {
  Recorded r;
  r.recording->finish();
  shadow::BlockBuilder builder;
  builder.begin(0, 0, Bytes(3));
  runtime::RecordHead head;
  head.bytes = sizeof head;
  ASSERT_TRUE(builder.add(std::as_bytes(std::span(&head, 1))));
  const Bytes block = builder.pack();
  r.bytes.insert(r.bytes.end(), block.begin(), block.end());
  const auto file = shadow::RecordFile::read(r.bytes, "f");
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  ASSERT_TRUE(player);
  EXPECT_FALSE((*player)->step());
  EXPECT_EQ((*player)->damaged_blocks(), 1u);
}

/// Values of FastCount and SlowSum where the player is.
std::string shown(shadow::Player& player) {
  player.show_globals();
  return value_of(player.resource(), "FastCount") + " " + value_of(player.resource(), "SlowSum");
}

TEST(Player, GoesToAnyTimeAndAnyScan) {
  shadow::RecordingOptions options;
  options.block_bytes = 2048;
  Recorded r(options);
  runtime::Simulation simulation(*r.resource);
  std::vector<std::pair<core::TimeNs, std::string>> states;
  simulation.after_instant([&](const runtime::Instant& instant) {
    r.recording->drain();
    states.emplace_back(instant.now_ns, value_of(*r.resource, "FastCount") + " " + value_of(*r.resource, "SlowSum"));
  });
  simulation.run_cycles(400);
  r.recording->finish();
  const auto file = shadow::RecordFile::read(r.bytes, "recording");
  ASSERT_TRUE(file);
  ASSERT_GT(file->blocks().size(), 10u);
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  ASSERT_TRUE(player);
  EXPECT_EQ((*player)->begin_ns(), states.front().first);
  EXPECT_EQ((*player)->end_ns(), states.back().first);
  // Forwards, backwards, to the ends.
  for (const std::size_t at : {7u, 399u, 0u, 200u, 201u, 199u, 1u, 398u}) {
    if (at >= states.size()) continue;
    (*player)->seek(states[at].first);
    EXPECT_EQ(shown(**player), states[at].second) << at;
    const auto next = (*player)->step();
    EXPECT_EQ(next.has_value(), at + 1 < states.size());
    if (next) {
      EXPECT_TRUE(next->outcome.equal && !next->after_gap) << at;
    }
  }
  for (const std::uint64_t scan : {0u, 90u, 33u}) {
    ASSERT_TRUE((*player)->seek(0, scan)) << scan;
    EXPECT_EQ(value_of((*player)->resource(), "Fast0.count"), std::to_string(scan + 1));
  }
  EXPECT_FALSE((*player)->seek(0, 1'000'000));
  EXPECT_FALSE((*player)->seek(7, 0));
}

TEST(Player, ComparesTheTableAtEachBlockAndNamesTheVariable) {
  shadow::RecordingOptions options;
  options.block_bytes = 4096;
  Recorded r(options);
  runtime::Simulation simulation(*r.resource);
  simulation.after_instant([&](const runtime::Instant&) { r.recording->drain(); });
  simulation.run_cycles(100);
  const runtime::Access access(*r.resource);
  const auto place = access.find("Fast0.count");
  r.resource->program(0).table().data()[place->offset + 1] ^= std::byte{1};
  simulation.run_cycles(200);
  r.recording->finish();
  const auto file = shadow::RecordFile::read(r.bytes, "recording");
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  std::string first;
  while (const auto played = (*player)->step()) {
    if (!played->outcome.equal && first.empty()) first = played->outcome.differs;
  }
  EXPECT_NE(first.find("Fast0.count"), std::string::npos) << first;
}

TEST(Tracer, RowsOfEachScanAndAroundATrigger) {
  shadow::RecordingOptions options;
  options.block_bytes = 2048;
  Recorded r(options);
  runtime::Simulation simulation(*r.resource);
  simulation.after_instant([&](const runtime::Instant&) { r.recording->drain(); });
  simulation.run_cycles(300);
  r.recording->finish();
  const auto file = shadow::RecordFile::read(r.bytes, "recording");
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  shadow::TraceRequest request;
  request.paths = {"Fast0.count", "SlowSum"};
  request.from_ns = 1'000'000'000;
  request.until_ns = 1'030'000'000;
  auto made = shadow::trace(**player, request);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->rows, 4u);
  EXPECT_EQ(made->csv.substr(0, made->csv.find('\n', 40)), "scan,time_ms,Fast0.count,SlowSum\n100,0,101,1717");
  EXPECT_NE(made->csv.find("\n103,30,104,"), std::string::npos) << made->csv;
  // Around the scan in which the count reaches 200: two before, one after.
  request.from_ns = 0;
  request.until_ns = 10'000'000'000;
  request.trigger = shadow::Trigger{"Fast0.count", shadow::Trigger::Edge::kRising, 200};
  request.before_ns = 20'000'000;
  request.after_ns = 10'000'000;
  made = shadow::trace(**player, request);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->triggered, 199u);
  EXPECT_EQ(made->rows, 4u);
  EXPECT_NE(made->csv.find("\n197,-20,198,"), std::string::npos) << made->csv;
  EXPECT_NE(made->csv.find("\n200,10,201,"), std::string::npos) << made->csv;
  request.trigger->edge = shadow::Trigger::Edge::kFalling;
  made = shadow::trace(**player, request);
  EXPECT_FALSE(made->triggered);
  EXPECT_EQ(made->rows, 0u);
  request.trigger = shadow::Trigger{"SlowSum", shadow::Trigger::Edge::kChange, 0};
  made = shadow::trace(**player, request);
  EXPECT_TRUE(made->triggered);
  request.trigger.reset();
  request.most_rows = 5;
  made = shadow::trace(**player, request);
  EXPECT_TRUE(made->cut);
  EXPECT_EQ(made->rows, 5u);
  const std::size_t whole = made->csv.size();
  request.most_rows = 1'000'000;
  request.most_bytes = whole;
  made = shadow::trace(**player, request);
  EXPECT_TRUE(made->cut);
  EXPECT_EQ(made->csv.size(), whole);
  const std::atomic<bool> ending{true};
  request.ending = &ending;
  made = shadow::trace(**player, request);
  EXPECT_TRUE(made->cut);
  EXPECT_EQ(made->rows, 0u);
  request.paths = {"nothing"};
  EXPECT_EQ(shadow::trace(**player, request).error().code, core::Code::P7101);
}

}  // namespace
}  // namespace plc::test
