// Programs that are kept: which one a start takes, whatever happened before.
#include "engineering/program_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "engineering/secrets.h"
#include "engineering/tar.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using core::Code;
using engineering::ProgramStore;
using engineering::StoredProgram;

constexpr core::TimeNs kNow = 1'800'000'000'000'000'000;
const std::string kOld(3000, 'a'), kNew(5000, 'b'), kThird(4000, 'c');

std::string good(const std::string&) { return {}; }

class Store : public testing::Test {
 protected:
  std::unique_ptr<ProgramStore> open() {
    auto store = ProgramStore::open(folder());
    EXPECT_TRUE(store) << store.error().message;
    return std::move(*store);
  }
  [[nodiscard]] std::string folder() const { return scratch_.file("state/program"); }
  /// Uploads `bytes` while `kOld` runs, and asks for its start.
  static void upload_and_start(ProgramStore& store, const std::string& bytes) {
    ASSERT_TRUE(store.put(bytes, "anna", kNow, good));
    const auto problem =
        store.try_next(engineering::sha256(bytes), "cold", {engineering::sha256(kOld), {}, {}, 0}, kOld, "given");
    ASSERT_FALSE(problem) << problem->message;
  }
  /// What a start takes: its image and whether it is tried.
  static std::pair<std::string, bool> next(ProgramStore& store) {
    auto choice = store.choose(kNow);
    EXPECT_TRUE(choice) << choice.error().message;
    if (!choice || !*choice) return {};
    std::ifstream in((*choice)->file, std::ios::binary);
    return {std::string{std::istreambuf_iterator<char>(in), {}}, (*choice)->trial};
  }
  /// Nothing can be written in place of chosen.json, whoever tries it.
  void refuse_writes() const { fs::create_directories(folder() + "/chosen.json.new/in the way"); }
  void allow_writes() const { fs::remove_all(folder() + "/chosen.json.new"); }
  [[nodiscard]] std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& file : fs::directory_iterator(folder())) names.insert(file.path().filename().string());
    return names;
  }

 private:
  ScratchFolder scratch_;
};

TEST_F(Store, NothingIsTakenBeforeSomethingWasStarted) {
  EXPECT_EQ(next(*open()).first, "");
  auto store = open();
  ASSERT_TRUE(store->put(kNew, "anna", kNow, good));
  EXPECT_EQ(store->waiting()->by, "anna");
  EXPECT_EQ(next(*open()).first, "") << "an upload alone starts nothing";
}

TEST_F(Store, AProgramIsTriedOnceAndThenIsTheOne) {
  auto store = open();
  upload_and_start(*store, kNew);
  EXPECT_FALSE(store->waiting());
  store = open();
  const auto choice = store->choose(kNow);
  ASSERT_TRUE(choice && *choice);
  EXPECT_EQ((*choice)->start, "cold");
  EXPECT_TRUE((*choice)->trial);
  EXPECT_EQ(store->confirm(engineering::sha256(kNew)), "");
  store = open();
  EXPECT_EQ(next(*store), std::pair(kNew, false));
  EXPECT_EQ(store->given(), "given");
  EXPECT_EQ(files().size(), 2u) << "chosen.json and one image";
}

TEST_F(Store, AnEndDuringTheTrialBringsTheOneBeforeBack) {
  upload_and_start(*open(), kNew);
  EXPECT_EQ(next(*open()), std::pair(kNew, true));
  auto store = open();
  EXPECT_EQ(next(*store), std::pair(kOld, false)) << "the process ended without a word";
  EXPECT_EQ(store->failed()->program.image, engineering::sha256(kNew));
  EXPECT_EQ(next(*open()), std::pair(kOld, false)) << "and it stays so";
}

TEST_F(Store, ATrialThatFailsSaysWhy) {
  upload_and_start(*open(), kNew);
  auto store = open();
  EXPECT_EQ(next(*store), std::pair(kNew, true));
  EXPECT_EQ(store->fail(engineering::sha256(kNew), "R1001: index", kNow), "");
  store = open();
  EXPECT_EQ(next(*store), std::pair(kOld, false));
  EXPECT_EQ(store->failed()->why, "R1001: index");
  EXPECT_EQ(files().size(), 2u) << "the image that failed is gone";
}

TEST_F(Store, WhatWasUploadedMeanwhileWaitsThoughAStartComesToNothing) {
  auto store = open();
  upload_and_start(*store, kNew);
  ASSERT_TRUE(store->put("newer", "ben", kNow, good));
  // Another one than was looked at is not started.
  const auto refused =
      store->try_next(engineering::sha256(kNew), "warm", {engineering::sha256(kOld), {}, {}, 0}, kOld, "given");
  EXPECT_TRUE(refused && refused->code == Code::P7755);
  store->wait_again();
  EXPECT_EQ(store->waiting()->image, engineering::sha256("newer"));
  EXPECT_EQ(next(*open()), std::pair(kOld, false));
}

TEST_F(Store, AnImageThatIsRefusedLeavesNothing) {
  auto store = open();
  ASSERT_TRUE(store->put(kNew, "anna", kNow, good));
  const auto before = files();
  std::string seen;
  const auto refused = store->put("rubbish", "eve", kNow, [&](const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    seen.assign(std::istreambuf_iterator<char>(in), {});
    return std::string("no image");
  });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::P7750);
  EXPECT_EQ(refused.error().message, "no image");
  EXPECT_EQ(seen, "rubbish");
  EXPECT_EQ(files(), before);
  EXPECT_EQ(store->waiting()->image, engineering::sha256(kNew));
}

TEST_F(Store, AProjectGoesWithItsImage) {
  auto store = open();
  EXPECT_EQ(store->put_project("<xml/>", "plant.xml").error().code, Code::P7755);
  ASSERT_TRUE(store->put(kNew, "anna", kNow, good));
  ASSERT_TRUE(store->put_project("<xml/>", "plant.xml"));
  ASSERT_FALSE(
      store->try_next(engineering::sha256(kNew), "warm", {engineering::sha256(kOld), {}, {}, 0}, kOld, "given"));
  const auto choice = store->choose(kNow);
  ASSERT_TRUE(choice && *choice);
  EXPECT_EQ((*choice)->program.project, "plant.xml");
  std::ifstream in(store->project_file((*choice)->program));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "<xml/>");
}

TEST_F(Store, WhatIsDamagedIsNotRun) {
  upload_and_start(*open(), kNew);
  EXPECT_EQ(next(*open()), std::pair(kNew, true));
  ASSERT_EQ(open()->confirm(engineering::sha256(kNew)), "");
  const std::string image = folder() + "/" + engineering::sha256(kNew) + ".pbc";
  std::ofstream(image, std::ios::binary | std::ios::in).seekp(100).write("?", 1);
  EXPECT_EQ(open()->choose(kNow).error().code, Code::P7753);
  std::ofstream(folder() + "/chosen.json")
      << R"({"given": "", "start": "", "tried": false, "runs": {"image": "../../etc"}})";
  EXPECT_EQ(ProgramStore::open(folder()).error().code, Code::P7753);
}

TEST_F(Store, ATrialWhoseImageIsDamagedGivesWayToWhatRan) {
  upload_and_start(*open(), kNew);
  const std::string image = folder() + "/" + engineering::sha256(kNew) + ".pbc";
  std::ofstream(image, std::ios::binary | std::ios::in).seekp(100).write("?", 1);
  auto store = open();
  EXPECT_EQ(next(*store), std::pair(kOld, false));
  EXPECT_NE(store->failed()->why.find("is damaged"), std::string::npos) << store->failed()->why;
  EXPECT_EQ(next(*open()), std::pair(kOld, false)) << "and it stays so";
}

TEST_F(Store, ATrialThatCannotBeNotedIsNoneAndWhatRanStarts) {
  upload_and_start(*open(), kNew);
  refuse_writes();
  auto store = open();
  EXPECT_EQ(next(*store), std::pair(kOld, false));
  EXPECT_NE(store->failed()->why.find("it was not tried: cannot write"), std::string::npos) << store->failed()->why;
  EXPECT_TRUE(store->has_unkept());
  EXPECT_NE(store->keep(), "");
  allow_writes();
  EXPECT_EQ(store->keep(), "");
  EXPECT_FALSE(store->has_unkept());
  store = open();
  EXPECT_EQ(next(*store), std::pair(kOld, false)) << "nobody wants it any more at a later start";
  EXPECT_TRUE(store->failed());
}

TEST_F(Store, AnEndDuringTheTrialBringsTheOneBeforeBackWithoutADisk) {
  upload_and_start(*open(), kNew);
  EXPECT_EQ(next(*open()), std::pair(kNew, true));
  refuse_writes();
  for (int starts = 0; starts < 3; ++starts) EXPECT_EQ(next(*open()), std::pair(kOld, false));
}

TEST_F(Store, WhatIsKnownOfATrialIsKnownOfItsProgramAlone) {
  upload_and_start(*open(), kNew);
  auto store = open();
  EXPECT_EQ(store->confirm(engineering::sha256(kNew)), "") << "it was not begun";
  EXPECT_EQ(next(*store), std::pair(kNew, true));
  // It ran well, and before that is on the disk the next one is started.
  ASSERT_TRUE(store->put(kThird, "anna", kNow, good));
  ASSERT_FALSE(store->try_next(engineering::sha256(kThird), "warm", {engineering::sha256(kNew), {}, "anna", kNow}, kNew,
                               "given"));
  EXPECT_EQ(store->confirm(engineering::sha256(kNew)), "");
  EXPECT_EQ(store->fail(engineering::sha256(kNew), "late", kNow), "");
  EXPECT_EQ(next(*open()), std::pair(kThird, true)) << "as ever a trial";
  EXPECT_EQ(next(*open()), std::pair(kNew, false)) << "which gives way";
}

/// A loss of power between any two changes of the disk: the states that the folder had, one after another.
TEST_F(Store, EveryStateOfTheDiskHasOneOfTheTwo) {
  upload_and_start(*open(), kNew);
  EXPECT_EQ(next(*open()), std::pair(kNew, true));
  ASSERT_EQ(open()->confirm(engineering::sha256(kNew)), "");
  // From here on kNew runs and kOld is uploaded: the same names of files, so that each state is made of the two.
  const fs::path before = folder() + ".before", after = folder() + ".after";
  fs::copy(folder(), before, fs::copy_options::recursive);
  {
    auto store = open();
    ASSERT_TRUE(store->put(kOld, "anna", kNow, good));
    ASSERT_FALSE(store->try_next(engineering::sha256(kOld), "warm", {engineering::sha256(kNew), {}, "anna", kNow}, kNew,
                                 "given"));
  }
  fs::copy(folder(), after, fs::copy_options::recursive);
  // Files are written in this order, and each is whole or not there at its place.
  const std::string image = engineering::sha256(kOld) + ".pbc";
  for (const bool has_piece : {false, true}) {
    for (const bool has_image : {false, true}) {
      for (const bool has_chosen : {false, true}) {
        if (has_chosen && !has_image) continue;  // chosen.json comes after what it names
        fs::remove_all(folder());
        fs::copy(before, folder(), fs::copy_options::recursive);
        if (has_piece) std::ofstream(folder() + "/checked.pbc.new") << "half";
        if (has_image) fs::copy(after / image, fs::path(folder()) / image);
        if (has_chosen)
          fs::copy(after / "chosen.json", fs::path(folder()) / "chosen.json", fs::copy_options::overwrite_existing);
        const auto found = next(*open());
        EXPECT_EQ(found.first, has_chosen ? kOld : kNew) << has_piece << has_image << has_chosen;
      }
    }
  }
}

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

TEST(Fingerprint, OfAFolderIsThatOfItsSourcesAlone) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.file("plant");
  write(folder / "main.st", "PROGRAM Main");
  write(folder / "parts/Motor.TcPOU", "<TcPlcObject/>");
  const std::string before = engineering::fingerprint_of(folder.string());
  EXPECT_EQ(before.size(), std::string("sources:").size() + 64);
  for (const char* beside : {"pages.toml", "alarms.toml", "plant.log", "state/retain", "state/program/chosen.json",
                             "state/program/stored.project", ".hidden/old.st"}) {
    write(folder / beside, "something");
    EXPECT_EQ(engineering::fingerprint_of(folder.string()), before) << beside;
  }
  EXPECT_EQ(engineering::fingerprint_of(folder.string() + "/"), before);
  fs::rename(folder / "main.st", folder / "start.st");
  const std::string renamed = engineering::fingerprint_of(folder.string());
  EXPECT_NE(renamed, before);
  write(folder / "parts/Motor.TcPOU", "<TcPlcObject />");
  EXPECT_NE(engineering::fingerprint_of(folder.string()), renamed);
}

TEST(Fingerprint, OfAProjectFileIsThatOfWhatItLists) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.file("plant");
  const std::string project = (folder / "Plant.plcproj").string();
  write(project, "<Project/>");
  write(folder / "POUs/Main.TcPOU", "<TcPlcObject/>");
  const std::string before = engineering::fingerprint_of(project);
  write(folder / "pages.toml", "[[page]]");
  EXPECT_EQ(engineering::fingerprint_of(project), before);
  write(folder / "POUs/Main.TcPOU", "<TcPlcObject />");
  EXPECT_NE(engineering::fingerprint_of(project), before);
}

TEST(Fingerprint, OfAFileIsItsHash) {
  const ScratchFolder scratch;
  write(scratch.file("plant.xml"), std::string(200'000, 'x'));
  EXPECT_EQ(engineering::fingerprint_of(scratch.file("plant.xml")),
            "file:" + engineering::sha256(std::string(200'000, 'x')));
  write(scratch.file("empty.st"), "");
  EXPECT_EQ(engineering::fingerprint_of(scratch.file("empty.st")), "file:" + engineering::sha256(""));
  EXPECT_EQ(engineering::fingerprint_of(scratch.file("none.xml")), "");
}

TEST(Fingerprint, OfAVersionBeforeIsThatOfAFileOrUnknown) {
  using engineering::compare_fingerprints;
  using engineering::SameFile;
  EXPECT_EQ(compare_fingerprints("file:12", "file:12"), SameFile::kYes);
  EXPECT_EQ(compare_fingerprints("file:12", "file:13"), SameFile::kNo);
  EXPECT_EQ(compare_fingerprints("file:12", "sources:12"), SameFile::kNo) << "a folder in place of a file";
  EXPECT_EQ(compare_fingerprints("sources:12", "sources:13"), SameFile::kNo);
  EXPECT_EQ(compare_fingerprints("12", "file:12"), SameFile::kYes);
  EXPECT_EQ(compare_fingerprints("12", "file:13"), SameFile::kNo);
  EXPECT_EQ(compare_fingerprints("12", "sources:12"), SameFile::kUnknown);
}

TEST(Tar, LooksAtSizesBeforeItReads) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.file("plant");
  write(folder / "main.st", "PROGRAM Main");
  EXPECT_EQ(engineering::tar_of(folder.string(), 1'000'000)->size(), 4u * 512);
  write(folder / "state/engineering/users.json", "{}");
  EXPECT_EQ(engineering::tar_of(folder.string(), 1'000'000, {(folder / "state").string(), ""})->size(), 4u * 512);
  EXPECT_EQ(engineering::tar_of(folder.string(), 1'000'000, {(folder / "main.st").string()})->size(), 4u * 512);
  EXPECT_EQ(engineering::tar_of(folder.string(), 1'000'000)->size(), 6u * 512);
  write(folder / "plant.log", "");
  fs::resize_file(folder / "plant.log", 100'000'000'000);  // no block of it is on the disk
  const auto refused = engineering::tar_of(folder.string(), 1'000'000);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::P7717);
}

}  // namespace
}  // namespace plc::test
