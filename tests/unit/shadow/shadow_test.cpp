// The thread beside a plant: files, memory, what led to a fault, replicas that follow, checks.
#include "shadow/shadow.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>

#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "tests/support/run_tool.h"
#include "tests/unit/runtime/run_support.h"
#include "tests/unit/shadow/two_tasks.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

struct Shadowed {
  explicit Shadowed(shadow::ShadowOptions options, bytecode::VerifiedImage image = two_tasks()) {
    const std::vector<std::byte> bytes = bytecode::save(image.image());
    resource = std::move(*runtime::Resource::load(std::move(image)));
    auto started = shadow::Shadow::start(*resource, std::move(options),
                                         {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytes});
    EXPECT_TRUE(started) << started.error().message;
    shadow = std::move(*started);
    simulation.emplace(*resource);
  }
  /// True when `condition` becomes true within some seconds.
  template <class Condition>
  static bool soon(Condition&& condition) {
    for (int turn = 0; turn < 2000 && !condition(); ++turn) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
  }
  bool taken(std::uint64_t scans) {
    return soon([&] { return shadow->counts().scans == scans; });
  }
  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<shadow::Shadow> shadow;
  std::optional<runtime::Simulation> simulation;
};

/// Scans of a recording that give what they gave; fails where one does not.
std::uint64_t equal_scans(const shadow::RecordFile& file, const std::string& name) {
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(file, diagnostics);
  EXPECT_TRUE(player);
  std::uint64_t scans = 0;
  while (const auto played = (*player)->step()) {
    EXPECT_TRUE(played->outcome.equal) << name << ": " << played->outcome.differs;
    ++scans;
  }
  return scans;
}

/// Rounds of scans with time for the thread in between. The files that are left.
std::vector<std::string> record(const shadow::RecordFolderOptions& folder, int rounds,
                                shadow::RecordingCounts& counts) {
  shadow::ShadowOptions options;
  options.folder = folder;
  Shadowed s(options);
  for (int round = 1; round <= rounds; ++round) {
    s.simulation->run_cycles(5000);
    EXPECT_TRUE(s.soon([&] { return s.shadow->counts().scans >= static_cast<std::uint64_t>(round) * 5000; }));
  }
  s.shadow->stop(true);
  counts = s.shadow->counts();
  EXPECT_TRUE(s.shadow->messages().empty());
  return files_of(folder.path);
}

TEST(Shadow, EveryFileIsARecordingOfItsOwn) {
  const ScratchFolder scratch;
  shadow::RecordingCounts counts;
  const auto files = record({scratch.file("records"), 1, 1u << 30}, 6, counts);
  EXPECT_GE(files.size(), 4u);
  EXPECT_EQ(counts.lost, 0u);
  std::uint64_t scans = 0;
  for (const std::string& path : files) {
    const auto file = shadow::RecordFile::open(path);
    ASSERT_TRUE(file) << file.error().message;
    scans += equal_scans(*file, path);
  }
  EXPECT_EQ(scans, counts.scans);
}

TEST(Shadow, TheOldestFilesGo) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.file("records"));
  std::ofstream(scratch.file("records/plant-19700101T000000.000Z.rec")) << std::string(1000, 'x');
  std::ofstream(scratch.file("records/of-others.rec")) << std::string(1000, 'x');
  shadow::RecordingCounts counts;
  const auto files = record({scratch.file("records"), 1, 1}, 6, counts);
  // That of others, and at most the last one that was full and the one that is written.
  EXPECT_LE(files.size(), 3u);
  EXPECT_TRUE(fs::exists(scratch.file("records/of-others.rec")));
  EXPECT_FALSE(fs::exists(scratch.file("records/plant-19700101T000000.000Z.rec")));
}

TEST(Shadow, AFolderThatCannotBeWrittenAtTheStartIsTriedAgain) {
  const ScratchFolder scratch;
  const std::string path = scratch.file("records");
  std::ofstream(path) << "x";
  shadow::ShadowOptions options;
  options.folder.emplace();
  options.folder->path = path;
  Shadowed s(options);
  const auto said = s.shadow->messages();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said.front().text.find("P7631: " + path), std::string::npos) << said.front().text;
  EXPECT_EQ(s.shadow->file(), "");
  s.simulation->run_cycles(10);
  fs::remove(path);
  s.simulation->run_cycles(10);
  s.shadow->stop(true);
  const auto files = files_of(path);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files.front(), s.shadow->file());
  const auto file = shadow::RecordFile::open(files.front());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_GT(equal_scans(*file, files.front()), 0u);
  const auto again = s.shadow->messages();
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again.front().text, "the recording is written again");
}

TEST(Shadow, MemoryHasTheNewestScans) {
  shadow::ShadowOptions options;
  options.recording.block_bytes = 8 * 1024;
  options.history_bytes = 20'000;
  Shadowed s(options);
  core::TimeNs last_ns = 0;
  s.simulation->after_instant([&](const runtime::Instant& instant) { last_ns = instant.now_ns; });
  std::uint64_t scans = 0;
  for (int round = 0; round < 20; ++round) {
    s.simulation->run_cycles(1000);
    ASSERT_TRUE(s.soon([&] { return s.shadow->counts().scans > scans; }));
    scans = s.shadow->counts().scans;
  }
  s.shadow->stop(false);
  EXPECT_LE(s.shadow->history_bytes(), 20'000u);
  const auto file = shadow::RecordFile::read(s.shadow->recording(), "memory");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->damaged_bytes(), 0u);
  const std::uint64_t kept = equal_scans(*file, "memory");
  EXPECT_GT(kept, 0u);
  EXPECT_LT(kept, s.shadow->counts().scans);
  core::TimeNs newest = 0;
  for (const shadow::BlockInfo& block : file->blocks()) newest = std::max(newest, block.last_ns);
  EXPECT_EQ(newest, last_ns);
  EXPECT_GT(s.shadow->history_ns(), 0);
}

TEST(Shadow, AViewerSeesVariablesOfTasksAsTheyAreInThePlant) {
  Shadowed s({});
  s.simulation->run_cycles(500);
  std::string seen;
  {
    shadow::Shadow::Viewer viewer(*s.shadow);
    ASSERT_TRUE(s.soon([&] {
      seen.clear();
      viewer.read([&](shadow::Follower& follower) {
        runtime::Resource& replicas = follower.replicas().resource();
        seen = value_of(replicas, "Fast0.count") + " " + value_of(replicas, "FastCount") + " " +
               value_of(replicas, "SlowSum");
      });
      return seen == value_of(*s.resource, "Fast0.count") + " " + value_of(*s.resource, "FastCount") + " " +
                         value_of(*s.resource, "SlowSum");
    })) << seen;
    s.simulation->run_cycles(77);
    EXPECT_TRUE(s.soon([&] {
      viewer.read([&](shadow::Follower& f) { seen = value_of(f.replicas().resource(), "Fast0.count"); });
      return seen == value_of(*s.resource, "Fast0.count");
    })) << seen;
  }
  // Nobody looks for a while; then somebody does again.
  s.simulation->run_cycles(300);
  shadow::Shadow::Viewer later(*s.shadow);
  EXPECT_TRUE(s.soon([&] {
    later.read([&](shadow::Follower& f) { seen = value_of(f.replicas().resource(), "Fast0.count"); });
    return seen == value_of(*s.resource, "Fast0.count");
  })) << seen;
  EXPECT_TRUE(s.shadow->messages().empty());
}

/// An observer that takes long, and how often nothing came for some time.
struct Slow : shadow::ScanObserver {
  void after_scan(const shadow::ReplicaSet&, const shadow::ObservedScan&) override {
    if (scans != 0 && std::chrono::steady_clock::now() - last > pause) ++pauses;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    last = std::chrono::steady_clock::now();
    ++scans;
  }
  std::chrono::milliseconds pause{90};
  std::chrono::steady_clock::time_point last;
  std::atomic<std::uint64_t> scans{0};
  std::atomic<int> pauses{0};
};

TEST(Shadow, DoesNotRestWhileItIsBehind) {
  Slow observer;
  Shadowed s({});
  s.shadow->observe(observer);
  // It has to execute them ten times or more, 60 ms each.
  s.simulation->run_cycles(800);
  const std::uint64_t scans = s.simulation->scans(0) + s.simulation->scans(1);
  EXPECT_TRUE(s.soon([&] { return observer.scans == scans; })) << observer.scans;
  EXPECT_LT(observer.pauses, 4);
}

TEST(Shadow, NobodyWaitsWhileReplicasAreMade) {
  std::atomic<bool> is_making{false}, goes_on{false};
  shadow::ShadowOptions options;
  options.prepare = [&](runtime::Resource&) {
    is_making = true;
    while (!goes_on) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  Shadowed s(options);
  s.simulation->run_cycles(10);
  shadow::Shadow::Viewer viewer(*s.shadow);
  const bool made_now = s.soon([&] { return is_making.load(); });
  const auto asked = std::async(std::launch::async, [&] {
    static_cast<void>(s.shadow->counts());
    return viewer.read([](shadow::Follower&) {});
  });
  const bool answered = asked.wait_for(std::chrono::seconds(5)) == std::future_status::ready;
  goes_on = true;
  EXPECT_TRUE(made_now && answered);
  EXPECT_TRUE(s.soon([&] { return viewer.read([](shadow::Follower&) {}); }));
}

TEST(Shadow, ThatIsAlwaysBehindRestsAndSaysSo) {
  Slow observer;
  observer.pause = std::chrono::milliseconds(40);
  shadow::ShadowOptions options;
  options.recording.block_bytes = 16 * 1024;
  Shadowed s(options);
  s.shadow->observe(observer);
  std::vector<shadow::ShadowMessage> said;
  // Each round has more scans than it executes meanwhile.
  EXPECT_TRUE(s.soon([&] {
    s.simulation->run_cycles(20);
    for (shadow::ShadowMessage& one : s.shadow->messages()) said.push_back(std::move(one));
    return observer.pauses > 2 && !said.empty();
  })) << observer.pauses;
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].text.find("scans come faster"), std::string::npos) << said[0].text;
}

TEST(Shadow, ACheckNamesTheVariableThatAReplicaDoesNotHave) {
  shadow::ShadowOptions options;
  options.check = true;
  options.recording.block_bytes = 1024;
  Shadowed s(options);
  s.simulation->run_cycles(1000);
  ASSERT_TRUE(s.soon([&] { return s.shadow->counts().scans >= 1000; }));
  EXPECT_TRUE(s.shadow->messages().empty());
  // Somebody writes into the table without anybody's knowledge.
  const runtime::Access access(*s.resource);
  const auto place = access.find("Fast0.count");
  ASSERT_TRUE(place);
  s.resource->program(0).table().data()[place->offset] ^= std::byte{64};
  s.simulation->run_cycles(1000);
  s.shadow->stop(true);
  const auto messages = s.shadow->messages();
  ASSERT_FALSE(messages.empty());
  EXPECT_EQ(messages.front().severity, core::Severity::kError);
  EXPECT_NE(messages.front().text.find("Fast0.count"), std::string::npos) << messages.front().text;
  EXPECT_NE(messages.front().text.find("task \"Quick\""), std::string::npos) << messages.front().text;
}

/// One task that hangs while the global Hang is TRUE.
bytecode::VerifiedImage may_hang() {
  ImageBuilder b;
  const std::uint32_t dint = b.type(core::TypeId::kDint);
  const Word one = b.constant<std::int32_t>(core::TypeId::kDint, 1);
  const Word hang = b.global("Hang", b.type(core::TypeId::kBool));
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word count = main.variable("count", dint);
  main.op(Opcode::kAdd32, {count, count, one});
  const std::uint32_t end = main.jump(Opcode::kCondJump, {hang});
  const std::uint32_t top = main.here();
  main.op(Opcode::kAdd32, {count, count, one});
  main.op(Opcode::kLoopJump, {top});
  main.land(end);
  b.task("Cyclic", 10'000'000, {main.finish()}, 0);
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  EXPECT_TRUE(image);
  return std::move(*image);
}

TEST(Shadow, WhatLedToAFaultIsWritten) {
  const ScratchFolder scratch;
  shadow::ShadowOptions options;
  options.fault_folder = scratch.file("records");
  Shadowed s(options, may_hang());
  s.simulation->run_cycles(100);
  ASSERT_TRUE(s.taken(100));
  EXPECT_FALSE(fs::exists(options.fault_folder));
  set(*s.resource, "Hang", "1");
  s.simulation->run_cycles(1);
  s.shadow->stop(true);
  const auto messages = s.shadow->messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages.front().severity, core::Severity::kNote);
  const auto files = files_of(options.fault_folder);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_NE(messages.front().text.find(files.front()), std::string::npos) << messages.front().text;
  EXPECT_EQ(fs::status(files.front()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const auto file = shadow::RecordFile::open(files.front());
  ASSERT_TRUE(file);
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  std::uint64_t scans = 0, faults = 0;
  while (const auto played = (*player)->step()) {
    EXPECT_TRUE(played->outcome.equal) << played->outcome.differs;
    ++scans;
    faults += played->outcome.fault ? 1 : 0;
  }
  EXPECT_EQ(scans, 101u);
  EXPECT_EQ(faults, 1u);
}

TEST(Shadow, AFaultThatCannotBeWrittenIsSaid) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("records")) << "x";
  shadow::ShadowOptions options;
  options.fault_folder = scratch.file("records");
  Shadowed s(options, may_hang());
  set(*s.resource, "Hang", "1");
  s.simulation->run_cycles(1);
  s.shadow->stop(true);
  const auto messages = s.shadow->messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages.front().severity, core::Severity::kWarning);
  EXPECT_NE(messages.front().text.find("could not be written"), std::string::npos) << messages.front().text;
}

TEST(RecordFolder, OldRecordingsOfFaultsGo) {
  const ScratchFolder scratch;
  const std::vector<std::byte> bytes(10, std::byte{1});
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(shadow::save_recording(scratch.file("records"), "fault", bytes, 3));
  EXPECT_EQ(files_of(scratch.file("records")).size(), 3u);
}

TEST(RecordFolder, AFaultAfterAClockThatWasAheadStays) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.file("records"));
  for (int i = 0; i < 3; ++i)
    std::ofstream(scratch.file("records/fault-29990101T00000" + std::to_string(i) + ".000Z.rec")) << "x";
  const std::vector<std::byte> bytes(10, std::byte{1});
  const auto saved = shadow::save_recording(scratch.file("records"), "fault", bytes, 3);
  ASSERT_TRUE(saved);
  EXPECT_TRUE(fs::exists(*saved));
  EXPECT_EQ(files_of(scratch.file("records")).size(), 3u);
}

TEST(RecordFolder, OldFilesGoAtTheStartAlso) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.file("records"));
  for (const char* const time : {"19700101T000000", "20240101T000000", "29990101T000000"})
    std::ofstream(scratch.file("records/plant-" + std::string(time) + ".000Z.rec")) << std::string(1000, 'x');
  const auto folder = shadow::RecordFolder::open({scratch.file("records"), 64u << 20, 1500}, {});
  ASSERT_TRUE(folder) << folder.error().message;
  // The last one that fits beside the new one, whose name is not the last.
  EXPECT_EQ(files_of(scratch.file("records")),
            (std::vector<std::string>{(*folder)->file(), scratch.file("records/plant-29990101T000000.000Z.rec")}));
  const auto small = shadow::RecordFolder::open({scratch.file("records"), 64u << 20, 1}, {});
  ASSERT_TRUE(small);
  EXPECT_EQ(files_of(scratch.file("records")), (std::vector<std::string>{(*small)->file()}));
}

TEST(RecordFolder, AFullDiskIsNotFilledWithEmptyFiles) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.file("records"));
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit full{1, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &full);
  const auto folder = shadow::RecordFolder::open({scratch.file("records")}, {});
  const std::vector<std::byte> bytes(10, std::byte{1});
  const auto saved = shadow::save_recording(scratch.file("records"), "fault", bytes, 3);
  ::setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, core::Code::P7631);
  EXPECT_FALSE(saved);
  EXPECT_TRUE(files_of(scratch.file("records")).empty());
}

}  // namespace
}  // namespace plc::test
