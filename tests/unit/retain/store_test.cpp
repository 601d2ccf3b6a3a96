// The file: what is read is what was written last, whatever became of a write.
#include "retain/store.h"

#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/unit/retain/plant.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using retain::Store;

/// Array of so many bytes, under this name.
retain::Layout layout_of(std::uint32_t bytes, const std::string& path = "main.a") {
  retain::Layout layout;
  layout.project = "test";
  bytecode::ImageType element, array;
  element.elementary = core::TypeId::kByte;
  element.size = 1;
  array.kind = bytecode::TypeKind::kArray;
  array.count = array.size = bytes;
  layout.types = {element, array};
  layout.roots = {{path, 1, 0, false, false}};
  layout.bytes = bytes;
  return layout;
}

std::vector<std::byte> filled(std::size_t bytes, unsigned value) {
  return std::vector<std::byte>(bytes, static_cast<std::byte>(value));
}

std::vector<std::byte> read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(Store, GivesWhatWasStoredLast) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(10'000));
  for (unsigned n = 1; n <= 5; ++n) {
    ASSERT_EQ(store.write(filled(10'000, n), 1'000 * n, 7), "");
    const auto stored = retain::read_file(store.path());
    ASSERT_TRUE(stored) << stored.error().message;
    EXPECT_EQ(stored->sequence, n);
    EXPECT_EQ(stored->program_time_ns, 1'000 * n);
    EXPECT_EQ(stored->values, filled(10'000, n));
    EXPECT_EQ(stored->layout.project, "test");
  }
}

TEST(Store, GoesOnWithTheFileOfTheSameLayout) {
  const ScratchFolder scratch;
  for (unsigned n = 1; n <= 4; ++n) {
    Store store(scratch.file("state"), layout_of(100));
    ASSERT_EQ(store.write(filled(100, n), n, 0), "");
    EXPECT_EQ(retain::read_file(store.path())->sequence, n);
  }
  EXPECT_FALSE(fs::exists(scratch.file("state/retain.previous")));
}

TEST(Store, KeepsTheFileOfAnotherLayout) {
  const ScratchFolder scratch;
  ASSERT_EQ(Store(scratch.file("state"), layout_of(100)).write(filled(100, 1), 0, 0), "");
  Store store(scratch.file("state"), layout_of(50, "main.b"));
  ASSERT_EQ(store.write(filled(50, 2), 0, 0), "");
  EXPECT_EQ(retain::read_file(store.path())->values, filled(50, 2));
  EXPECT_EQ(retain::read_file(scratch.file("state/retain.previous"))->values, filled(100, 1));
}

TEST(Store, KeepsAFileThatItCannotRead) {
  const ScratchFolder scratch;
  fs::create_directory(scratch.file("state"));
  std::ofstream(scratch.file("state/retain")) << "not mine";
  Store store(scratch.file("state"), layout_of(10));
  ASSERT_EQ(store.write(filled(10, 1), 0, 0), "");
  EXPECT_EQ(fs::file_size(scratch.file("state/retain.previous")), 8u);
}

TEST(Store, MakesAFileAgainThatSomebodyRemoved) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(10));
  ASSERT_EQ(store.write(filled(10, 1), 0, 0), "");
  fs::remove_all(scratch.file("state"));
  ASSERT_EQ(store.write(filled(10, 2), 0, 0), "");
  EXPECT_EQ(retain::read_file(store.path())->values, filled(10, 2));
}

TEST(Store, SaysWhyItCannotWriteAndTriesAgain) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("state")) << "a file";
  Store store(scratch.file("state"), layout_of(10));
  EXPECT_NE(store.write(filled(10, 1), 0, 0).find("cannot open folder"), std::string::npos);
  fs::remove(scratch.file("state"));
  EXPECT_EQ(store.write(filled(10, 1), 0, 0), "");
}

TEST(Store, TwoAtATimeAreRefused) {
  const ScratchFolder scratch;
  Store one(scratch.file("state"), layout_of(10)), two(scratch.file("state"), layout_of(10));
  ASSERT_EQ(one.write(filled(10, 1), 0, 0), "");
  EXPECT_NE(two.write(filled(10, 2), 0, 0).find("in use by another plc-run"), std::string::npos);
}

TEST(Store, AFullDiskLosesNothing) {
  const ScratchFolder scratch;
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  Store store(scratch.file("state"), layout_of(20'000));
  ASSERT_EQ(store.write(filled(20'000, 1), 0, 0), "");
  ASSERT_EQ(store.write(filled(20'000, 2), 0, 0), "");
  // The second slot lies beyond the limit.
  rlimit limit = before;
  limit.rlim_cur = 4096;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const std::string first = store.write(filled(20'000, 3), 0, 0);
  const std::string second = store.write(filled(20'000, 4), 0, 0);
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(first, "");
  EXPECT_NE(second, "");
  EXPECT_EQ(retain::read_file(store.path())->values, filled(20'000, 2));
  ASSERT_EQ(store.write(filled(20'000, 5), 0, 0), "");
  EXPECT_EQ(retain::read_file(store.path())->values, filled(20'000, 5));
}

TEST(Store, OnlyBlocksThatDifferAreWritten) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(1'000'000));
  std::vector<std::byte> values = filled(1'000'000, 1);
  for (int n = 0; n < 6; ++n) {
    values[500'000] = static_cast<std::byte>(n);
    ASSERT_EQ(store.write(values, n, 0), "");
  }
  EXPECT_EQ(retain::read_file(store.path())->values, values);
}

TEST(Store, AFileCutAnywhereGivesTheSetThatIsWholeOrNone) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(5'000));
  for (unsigned n = 1; n <= 3; ++n) ASSERT_EQ(store.write(filled(5'000, n), 0, 0), "");
  const std::vector<std::byte> bytes = read_bytes(store.path());
  std::size_t none = 0, older = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto stored = retain::parse_file(std::span(bytes).first(size));
    if (!stored) {
      ++none;
      EXPECT_EQ(stored.error().code, core::Code::P7611);
      continue;
    }
    EXPECT_TRUE(stored->values == filled(5'000, 3)) << size;  // in the first slot
    ++older;
  }
  EXPECT_GT(none, 5'000u);
  EXPECT_GT(older, 5'000u);
}

TEST(Store, AWriteThatEndsAtAnyByteLeavesOneOfTheTwoSets) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(9'000));
  for (unsigned n = 1; n <= 4; ++n) ASSERT_EQ(store.write(filled(9'000, n), 0, 0), "");
  const std::vector<std::byte> before = read_bytes(store.path());
  ASSERT_EQ(store.write(filled(9'000, 5), 0, 0), "");
  const std::vector<std::byte> after = read_bytes(store.path());
  ASSERT_EQ(before.size(), after.size());
  std::size_t old_sets = 0;
  const auto check = [&](const std::vector<std::byte>& bytes, std::size_t at) {
    const auto stored = retain::parse_file(bytes);
    ASSERT_TRUE(stored) << at;
    const bool old = stored->sequence == 4;
    ASSERT_TRUE(stored->values == filled(9'000, old ? 4 : 5)) << at;
    ASSERT_TRUE(old || stored->sequence == 5) << at;
    old_sets += old ? 1 : 0;
  };
  // In the order of the file, and in the other order, as a disk may do it.
  std::vector<std::byte> forth = before, back = before;
  for (std::size_t at = 0; at < before.size(); ++at) {
    check(forth, at);
    check(back, at);
    forth[at] = after[at];
    back[before.size() - 1 - at] = after[before.size() - 1 - at];
  }
  EXPECT_GT(old_sets, 9'000u);
}

TEST(Store, ADamagedSetIsNotTaken) {
  const ScratchFolder scratch;
  Store store(scratch.file("state"), layout_of(300));
  for (unsigned n = 1; n <= 2; ++n) ASSERT_EQ(store.write(filled(300, n), 0, 0), "");
  const std::vector<std::byte> bytes = read_bytes(store.path());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::vector<std::byte> damaged = bytes;
    damaged[at] ^= std::byte{0x10};
    const auto stored = retain::parse_file(damaged);
    if (!stored) continue;
    ASSERT_TRUE(stored->values == filled(300, static_cast<unsigned>(stored->sequence))) << at;
  }
}

}  // namespace
}  // namespace plc::test
