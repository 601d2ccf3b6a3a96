// The thread that keeps recordings in a folder: files, their number, what cannot be written.
#include "shadow/record_thread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "tests/support/run_tool.h"
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

/// Rounds of scans with time for the thread in between. The files that are left.
std::vector<std::string> record(const shadow::RecordFolder& folder, int rounds, shadow::RecordingCounts& counts) {
  const bytecode::VerifiedImage image = two_tasks();
  auto resource = runtime::Resource::load(bytecode::VerifiedImage(image));
  auto thread = shadow::RecordThread::start(
      **resource, folder, {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(image.image())});
  EXPECT_TRUE(thread) << thread.error().message;
  runtime::Simulation simulation(**resource);
  for (int round = 0; round < rounds; ++round) {
    simulation.run_cycles(5000);
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
  }
  (*thread)->stop(true);
  counts = (*thread)->counts();
  EXPECT_TRUE((*thread)->messages().empty());
  return files_of(folder.path);
}

TEST(RecordThread, EveryFileIsARecordingOfItsOwn) {
  const ScratchFolder scratch;
  shadow::RecordingCounts counts;
  const auto files = record({scratch.file("records"), 1, 1u << 30}, 6, counts);
  EXPECT_GE(files.size(), 4u);
  EXPECT_EQ(counts.lost, 0u);
  std::uint64_t scans = 0;
  for (const std::string& path : files) {
    const auto file = shadow::RecordFile::open(path);
    ASSERT_TRUE(file) << file.error().message;
    core::Diagnostics diagnostics;
    const auto player = shadow::Player::make(*file, diagnostics);
    ASSERT_TRUE(player);
    while (const auto played = (*player)->step()) {
      EXPECT_TRUE(played->outcome.equal) << path << ": " << played->outcome.differs;
      ++scans;
    }
  }
  EXPECT_EQ(scans, counts.scans);
}

TEST(RecordThread, TheOldestFilesGo) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.file("records"));
  std::ofstream(scratch.file("records/plant-19700101T000000Z.rec")) << std::string(1000, 'x');
  std::ofstream(scratch.file("records/of-others.rec")) << std::string(1000, 'x');
  shadow::RecordingCounts counts;
  const auto files = record({scratch.file("records"), 1, 1}, 6, counts);
  // That of others, and at most the last one that was full and the one that is written.
  EXPECT_LE(files.size(), 3u);
  EXPECT_TRUE(fs::exists(scratch.file("records/of-others.rec")));
  EXPECT_FALSE(fs::exists(scratch.file("records/plant-19700101T000000Z.rec")));
}

TEST(RecordThread, AFolderThatCannotBeIsAProblem) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("file")) << "x";
  const bytecode::VerifiedImage image = two_tasks();
  auto resource = runtime::Resource::load(bytecode::VerifiedImage(image));
  const auto thread = shadow::RecordThread::start(**resource, {scratch.file("file")}, {});
  ASSERT_FALSE(thread);
  EXPECT_EQ(thread.error().code, core::Code::P7631);
}

}  // namespace
}  // namespace plc::test
