// What a process leaves that dies: its newest scans, in any state of its memory.
#include "shadow/crash_memory.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "shadow/recording.h"
#include "tests/support/run_tool.h"
#include "tests/unit/runtime/run_support.h"
#include "tests/unit/shadow/two_tasks.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

/// A plant that records into memory which outlives it.
struct Dying {
  Dying(const std::string& folder, shadow::RecordingOptions options) : image(two_tasks()) {
    resource = std::move(*runtime::Resource::load(bytecode::VerifiedImage(image)));
    const Bytes head =
        shadow::file_head({"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(image.image())});
    shadow::CrashMemory::Sizes sizes{options.ring_bytes, options.most_record_bytes, {}, "/"};
    for (std::size_t t = 0; t < resource->task_count(); ++t)
      sizes.table_bytes.push_back(resource->program(t).table().layout().total);
    auto made = shadow::CrashMemory::make(folder, head, sizes);
    EXPECT_TRUE(made) << made.error().message;
    memory = std::move(*made);
    options.crash_memory = memory.get();
    recording = std::move(*shadow::Recording::start(
        *resource, [this](const shadow::BlockInfo&, const Bytes&) { ++blocks; }, options));
    simulation.emplace(*resource);
  }
  bytecode::VerifiedImage image;
  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<shadow::CrashMemory> memory;
  std::unique_ptr<shadow::Recording> recording;
  std::optional<runtime::Simulation> simulation;
  int blocks = 0;
};

/// What a process leaves that runs `run` and then ends at once, as by a signal.
template <class Run>
Bytes left_by(const std::string& folder, const shadow::RecordingOptions& options, Run&& run) {
  const pid_t child = ::fork();
  if (child == 0) {
    Dying dying(folder, options);
    run(dying);
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  // As the next start does.
  auto next = shadow::CrashMemory::make(folder, {}, {4096, 1024, {}, "/"});
  EXPECT_TRUE(next) << next.error().message;
  return shadow::CrashMemory::take_left(folder);
}

struct Played {
  std::uint64_t scans = 0, first = UINT64_MAX, last = 0;  ///< of task 0
};
Played play(const Bytes& bytes) {
  Played played;
  const auto file = shadow::RecordFile::read(bytes, "left");
  EXPECT_TRUE(file) << file.error().message;
  if (!file) return played;
  EXPECT_EQ(file->damaged_bytes(), 0u);
  core::Diagnostics diagnostics;
  const auto player = shadow::Player::make(*file, diagnostics);
  EXPECT_TRUE(player);
  while (const auto scan = (*player)->step()) {
    EXPECT_TRUE(scan->outcome.equal) << scan->outcome.differs;
    if (scan->task != 0) continue;
    ++played.scans;
    played.first = std::min(played.first, scan->scan);
    played.last = std::max(played.last, scan->scan);
  }
  return played;
}

TEST(CrashMemory, BelongsToOneStateFolderOfOnePlaceAlsoBeforeThatIsThere) {
  const ScratchFolder scratch;
  const fs::path was = fs::current_path();
  fs::create_directory(scratch.file("a"));
  fs::create_directory(scratch.file("b"));
  fs::current_path(scratch.file("a"));
  const std::string before = shadow::CrashMemory::folder_of("new");
  fs::create_directory("new");
  EXPECT_EQ(shadow::CrashMemory::folder_of("new"), before);
  EXPECT_EQ(shadow::CrashMemory::folder_of("new/"), before);
  EXPECT_EQ(shadow::CrashMemory::folder_of("./new"), before);
  EXPECT_EQ(shadow::CrashMemory::folder_of(scratch.file("a/new")), before);
  fs::current_path(scratch.file("b"));
  EXPECT_NE(shadow::CrashMemory::folder_of("new"), before) << "another plant";
  fs::current_path(was);
}

TEST(CrashMemory, HasTheNewestScansAlsoThoseNobodyTook) {
  const ScratchFolder scratch;
  const Played played = play(left_by(scratch.file("memory"), {}, [](Dying& d) {
    d.simulation->run_cycles(500);
    d.recording->drain();
    d.simulation->run_cycles(77);
  }));
  EXPECT_EQ(played.scans, 577u);
  EXPECT_EQ(played.last, 576u);
}

TEST(CrashMemory, HasTheBlockBeforeTheNewestToo) {
  const ScratchFolder scratch;
  shadow::RecordingOptions options;
  options.ring_bytes = 64 * 1024;
  options.most_record_bytes = 4096;
  options.block_bytes = 8 * 1024;
  const Played played = play(left_by(scratch.file("memory"), options, [](Dying& d) {
    for (int round = 0; round < 100; ++round) {
      d.simulation->run_cycles(50);
      d.recording->drain();
    }
    EXPECT_GT(d.blocks, 4);
  }));
  EXPECT_EQ(played.last, 4999u);
  EXPECT_EQ(played.last - played.first + 1, played.scans) << "no gap";
  EXPECT_GT(played.scans, 100u);
  EXPECT_LT(played.scans, 2000u);
}

TEST(CrashMemory, OfAReaderThatFellBehindTheRestIsWhole) {
  const ScratchFolder scratch;
  shadow::RecordingOptions options;
  options.ring_bytes = 16 * 1024;
  options.most_record_bytes = 1024;
  const Played played =
      play(left_by(scratch.file("memory"), options, [](Dying& d) { d.simulation->run_cycles(3000); }));
  EXPECT_EQ(played.first, 0u);
  EXPECT_LT(played.scans, 3000u);
}

TEST(CrashMemory, IsGoneWhenTheProcessEndsWell) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("memory");
  {
    Dying dying(folder, {});
    dying.simulation->run_cycles(10);
    EXPECT_TRUE(fs::exists(folder));
    const auto second = shadow::CrashMemory::make(folder, {}, {4096, 1024, {64}, "/"});
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("another process"), std::string::npos);
  }
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_TRUE(shadow::CrashMemory::take_left(folder).empty());
}

TEST(CrashMemory, OfOthersIsNotTouched) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("memory");
  fs::create_directories(folder);
  fs::permissions(folder, static_cast<fs::perms>(0755));
  EXPECT_FALSE(shadow::CrashMemory::make(folder, {}, {4096, 1024, {64}, "/"}));
  EXPECT_TRUE(fs::exists(folder));
  // A link leads nowhere.
  fs::create_directory_symlink("/", scratch.file("link"));
  EXPECT_FALSE(shadow::CrashMemory::make(scratch.file("link"), {}, {4096, 1024, {64}, "/"}));
}

TEST(CrashMemory, OfPlantsThatAreGoneIsRemoved) {
  const ScratchFolder scratch;
  const auto left_in = [&scratch](const char* name, const std::string& state) {
    const pid_t child = ::fork();
    if (child == 0) {
      static_cast<void>(shadow::CrashMemory::make(scratch.file(name), {}, {4096, 1024, {64}, state})->release());
      ::_exit(0);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(fs::exists(scratch.file(name)));
  };
  left_in("picard-1", scratch.file("gone"));
  left_in("picard-2", scratch.file(""));
  const auto live = shadow::CrashMemory::make(scratch.file("picard-3"), {}, {4096, 1024, {64}, scratch.file("gone")});
  ASSERT_TRUE(live);
  // picard-1 was removed already when picard-2 was made.
  EXPECT_FALSE(fs::exists(scratch.file("picard-1")));
  EXPECT_TRUE(fs::exists(scratch.file("picard-2"))) << "its plant may be started again";
  ASSERT_TRUE(shadow::CrashMemory::make(scratch.file("picard-4"), {}, {4096, 1024, {64}, "/"}));
  EXPECT_TRUE(fs::exists(scratch.file("picard-3"))) << "it is in use";
}

/// Everybody may make files in /dev/shm.
TEST(CrashMemory, OthersDoNotHoldUpAStart) {
  const ScratchFolder scratch;
  const auto make_folder = [&scratch](const char* name, unsigned mode) {
    fs::create_directories(scratch.file(name));
    fs::permissions(scratch.file(name), static_cast<fs::perms>(mode));
    return scratch.file(name);
  };
  // A pipe that nobody writes into, where others may look and where they may not; a file of 1 TB that has no block.
  for (const auto& [name, mode] : {std::pair("picard-a", 0755u), std::pair("picard-b", 0700u)})
    ASSERT_EQ(::mkfifo((make_folder(name, mode) + "/state").c_str(), 0644), 0);
  const std::string huge = make_folder("picard-c", 0700) + "/state";
  std::ofstream(huge).put('/');
  std::error_code error;
  fs::resize_file(huge, std::uintmax_t{1} << 40, error);
  if (error) fs::resize_file(huge, std::uintmax_t{1} << 33);
  // What is said there leads to no removal of what others may have written.
  std::ofstream(make_folder("picard-d", 0777) + "/state") << scratch.file("gone");
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(20);
    ::_exit(shadow::CrashMemory::make(scratch.file("picard-e"), {}, {4096, 1024, {64}, "/"}) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::exists(scratch.file("picard-d")));
}

TEST(CrashMemory, OfOthersIsNotTakenAsLeft) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("memory"), left = folder + ".left";
  const auto take = [&folder] {
    const pid_t child = ::fork();
    if (child == 0) {
      ::alarm(20);
      ::_exit(shadow::CrashMemory::take_left(folder).empty() ? 0 : 1);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return status;
  };
  fs::create_directories(left);
  fs::permissions(left, static_cast<fs::perms>(0755));
  ASSERT_EQ(::mkfifo((left + "/recording").c_str(), 0644), 0);
  EXPECT_EQ(take(), 0);
  EXPECT_TRUE(fs::exists(left));
  fs::permissions(left, static_cast<fs::perms>(0700));
  EXPECT_EQ(take(), 0) << "a pipe is no recording";
  EXPECT_FALSE(fs::exists(left));
}

TEST(CrashMemory, BearsWhateverItsFilesHold) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("memory"), left = folder + ".left";
  const auto save = [&] {
    fs::remove_all(scratch.file("saved"));
    fs::copy(left, scratch.file("saved"), fs::copy_options::recursive);
  };
  shadow::RecordingOptions options;
  options.ring_bytes = options.most_record_bytes = 4096;
  const pid_t child = ::fork();
  if (child == 0) {
    Dying dying(folder, options);
    dying.simulation->run_cycles(20);
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(shadow::CrashMemory::make(folder, {}, {4096, 1024, {}, "/"}));
  save();
  std::mt19937 random(1);
  for (int turn = 0; turn < 300; ++turn) {
    fs::remove_all(left);
    fs::copy(scratch.file("saved"), left, fs::copy_options::recursive);
    const char* const names[] = {"recording", "task-0.ring", "task-0.tables"};
    const std::string path = left + "/" + names[turn % 3];
    const auto size = static_cast<std::size_t>(fs::file_size(path));
    if (turn % 2 == 0) {
      fs::resize_file(path, random() % size);
    } else {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      for (int i = 0; i < 8; ++i) {
        // Mostly where numbers are: at the beginning, and in the last page.
        const std::size_t at = random() % 256;
        file.seekp(static_cast<std::streamoff>(i % 2 == 0 || size < 4096 ? at % size : size - 4096 + at));
        file.put(static_cast<char>(random()));
      }
    }
    const Bytes bytes = shadow::CrashMemory::take_left(folder);
    if (!bytes.empty()) static_cast<void>(shadow::RecordFile::read(bytes, "left"));
    EXPECT_FALSE(fs::exists(left));
  }
}

}  // namespace
}  // namespace plc::test
