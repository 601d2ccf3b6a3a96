// The chain of the audit: whatever is done to a record is seen.
#include "engineering/audit.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engineering/state_files.h"
#include "tests/support/run_tool.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::Audit;
using engineering::AuditCheck;
using engineering::check_audit_file;
using engineering::FolderLock;

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end - at + 1));
    at = end + 1;
  }
  return lines;
}
std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

class Chain : public testing::Test {
 protected:
  static constexpr int kRecords = 12;
  void SetUp() override {
    std::string said;
    Audit audit(folder_, calendar_, said);
    for (int i = 0; i < kRecords; ++i) {
      audit.add("anna", "10.0.0.1", "values.write", {{"value", i}});
      calendar_.now_ns += 1'000'000'000;
      if (i % 3 == 0) {
        ASSERT_EQ(audit.write_waiting(), "");
      }
    }
    ASSERT_EQ(audit.write_waiting(), "");
    text_ = read(file_);
    ASSERT_EQ(lines_of(text_).size(), std::size_t{kRecords});
  }
  AuditCheck check(const std::string& bytes) {
    write(file_, bytes);
    auto result = check_audit_file(folder_);
    EXPECT_TRUE(result);
    return *result;
  }
  ScratchFolder scratch_;
  std::string folder_ = scratch_.file("audit-folder"), file_ = folder_ + "/audit";
  SetCalendar calendar_;
  std::string text_;
};

TEST_F(Chain, IsWholeAsWritten) {
  const AuditCheck found = check(text_);
  EXPECT_EQ(found.why, "");
  EXPECT_EQ(found.texts.size(), std::size_t{kRecords});
  EXPECT_EQ(found.first, 1u);
  EXPECT_EQ(found.last, std::uint64_t{kRecords});
  struct stat status {};
  ASSERT_EQ(::stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(Chain, IsBrokenAtEachRecordThatWasChanged) {
  for (std::size_t i = 0; i < std::size_t{kRecords}; ++i) {
    auto lines = lines_of(text_);
    const std::size_t at = lines[i].find("\"value\":") + 8;
    lines[i][at] = lines[i][at] == '9' ? '8' : static_cast<char>(lines[i][at] + 1);
    EXPECT_EQ(check(joined(lines)).broken_line, i + 1);
  }
}

TEST_F(Chain, IsBrokenByEachByteThatIsFlipped) {
  for (std::size_t at = 0; at < text_.size(); at += 7) {
    std::string bytes = text_;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    EXPECT_NE(check(bytes).why, "") << "byte " << at;
  }
}

TEST_F(Chain, IsBrokenWhereARecordIsTakenOutPutInOrMoved) {
  for (std::size_t i = 0; i < std::size_t{kRecords}; ++i) {
    auto lines = lines_of(text_);
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_NE(check(joined(lines)).why, "") << "without record " << i + 1;
    lines = lines_of(text_);
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(i), lines[i]);
    EXPECT_NE(check(joined(lines)).why, "") << "record " << i + 1 << " twice";
    if (i + 1 == std::size_t{kRecords}) continue;
    lines = lines_of(text_);
    std::swap(lines[i], lines[i + 1]);
    EXPECT_NE(check(joined(lines)).why, "") << "records " << i + 1 << " and " << i + 2 << " exchanged";
  }
}

TEST_F(Chain, IsBrokenWhenItEndsEarly) {
  for (std::size_t size = 0; size < text_.size(); size += 11) EXPECT_NE(check(text_.substr(0, size)).why, "") << size;
  EXPECT_NE(check("").why, "");
}

TEST_F(Chain, GoesOnAfterARestart) {
  std::string said;
  {
    Audit audit(folder_, calendar_, said);
    EXPECT_EQ(audit.recent(100).size(), std::size_t{kRecords});
    audit.add("ben", "10.0.0.2", "login", nlohmann::ordered_json::object());
  }
  EXPECT_EQ(said, "");
  const auto found = check_audit_file(file_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->why, "");
  EXPECT_EQ(found->last, std::uint64_t{kRecords} + 1);
}

TEST_F(Chain, ALossOfPowerWhileItIsWrittenBreaksNothing) {
  write(file_, text_ + text_.substr(0, 100));
  std::string said;
  {
    Audit audit(folder_, calendar_, said);
    audit.add("ben", "10.0.0.2", "login", nlohmann::ordered_json::object());
  }
  EXPECT_EQ(said, "");
  const auto found = check_audit_file(folder_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->why, "");
  EXPECT_EQ(found->texts.size(), std::size_t{kRecords} + 1);
}

TEST_F(Chain, SoDoesOneBeforeTheHeadIsWritten) {
  // Of the first record, of a later one, of the first one of a new file.
  const auto lines = lines_of(text_);
  write(folder_ + "/audit.head", "0 " + std::string(64, '0') + "\n");
  EXPECT_EQ(check(lines[0]).why, "");
  write(folder_ + "/audit.head", "11 " + lines[10].substr(0, 64) + "\n");
  EXPECT_EQ(check(text_).why, "");
  write(file_ + ".1", joined({lines.begin(), lines.begin() + 11}));
  EXPECT_EQ(check(lines[11]).why, "");
  EXPECT_NE(check(lines[10]).why, "") << "one that does not follow";
}

TEST_F(Chain, ABrokenOneIsPutAsideAndSaid) {
  auto lines = lines_of(text_);
  lines.erase(lines.begin() + 4);
  write(file_, joined(lines));
  std::string said;
  { const Audit audit(folder_, calendar_, said); }
  EXPECT_NE(said.find("P7702"), std::string::npos) << said;
  EXPECT_EQ(read(folder_ + "/audit.broken"), joined(lines));
  const auto found = check_audit_file(folder_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->why, "");
  ASSERT_EQ(found->texts.size(), 1u);
  EXPECT_NE(found->texts[0].find("audit.broken"), std::string::npos);
}

TEST_F(Chain, GoesThroughSeveralFiles) {
  std::string said;
  {
    Audit audit(folder_, calendar_, said, 2000);
    for (int i = 0; i < 60; ++i) {
      audit.add("anna", "10.0.0.1", "values.write", {{"value", i}});
      ASSERT_EQ(audit.write_waiting(), "");
    }
  }
  std::uint64_t expected = 0;
  int files = 0;
  for (int n = 9; n >= 0; --n) {
    const std::string path = file_ + (n == 0 ? "" : "." + std::to_string(n));
    if (!std::filesystem::exists(path)) continue;
    const auto found = check_audit_file(path);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->why, "") << path;
    if (expected != 0) {
      EXPECT_EQ(found->first, expected);
    }
    expected = found->last + 1;
    ++files;
  }
  EXPECT_GE(files, 5);
  EXPECT_EQ(expected, std::uint64_t{kRecords} + 61);
  // The first record of a file goes on from the last one of the file before.
  auto lines = lines_of(read(file_ + ".2"));
  lines.pop_back();
  write(file_ + ".2", joined(lines));
  EXPECT_NE(check_audit_file(file_ + ".1")->why, "");
}

TEST(Audit, ADiskThatRefusesLosesNothingAtFirst) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("folder");
  write(folder, "a file is in the way");
  SetCalendar calendar;
  std::string said;
  {
    Audit audit(folder, calendar, said);
    audit.add("anna", "10.0.0.1", "login", nlohmann::ordered_json::object());
    EXPECT_NE(audit.write_waiting(), "");
    std::filesystem::remove(folder);
    EXPECT_EQ(audit.write_waiting(), "");
  }
  const auto found = check_audit_file(folder);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->texts.size(), 1u);
}

TEST(Audit, AHeadThatCouldNotBeWrittenIsWrittenLater) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("folder");
  std::filesystem::create_directories(folder + "/audit.head.new");
  SetCalendar calendar;
  std::string said;
  Audit audit(folder, calendar, said);
  audit.add("anna", "10.0.0.1", "login", nlohmann::ordered_json::object());
  EXPECT_NE(audit.write_waiting(), "");
  EXPECT_NE(audit.write_waiting(), "") << "it is said as long as it is so";
  std::filesystem::remove(folder + "/audit.head.new");
  EXPECT_EQ(audit.write_waiting(), "");
  EXPECT_EQ(check_audit_file(folder)->why, "");
}

TEST(Audit, TellsOfWhatItLost) {
  SetCalendar calendar;
  std::string said;
  Audit audit("/proc/nowhere", calendar, said);
  for (std::size_t i = 0; i < Audit::kMostWaiting + 5; ++i) audit.add("", "", "x", nlohmann::ordered_json::object());
  EXPECT_EQ(audit.lost(), 5u);
}

TEST(Audit, HoldsWhoWroteWhat) {
  EngineeringRig rig;
  rig.post("/api/login", {{"user", "viewer"}, {"password", "wrong-password"}}, "");
  rig.post("/api/values/write", {{"values", {{{"path", "Start"}, {"value", true}}}}});
  rig.post("/api/values/write", {{"values", {{{"path", "Start"}, {"value", false}}}}, {"reason", "valve stuck"}});
  const Json records = body_of(rig.get("/api/audit", "admin"))["records"];
  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(records[0]["what"], "login.refused");
  EXPECT_EQ(records[0]["user"], "viewer");
  EXPECT_EQ(records[1]["what"], "values.write");
  EXPECT_EQ(records[1]["user"], "operator");
  EXPECT_EQ(records[1]["details"]["values"][0], (Json{{"path", "Start"}, {"value", true}, {"before", false}}));
  EXPECT_FALSE(records[1]["details"].contains("reason"));
  EXPECT_EQ(records[2]["details"]["reason"], "valve stuck");
  EXPECT_EQ(rig.get("/api/audit", "admin").body.find("wrong-password"), std::string::npos);
}

TEST(FolderLock, IsHadByOne) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("engineering");
  FolderLock second;
  {
    FolderLock first;
    EXPECT_EQ(first.take(folder), "") << "a folder that is not there has nobody in it";
    std::filesystem::create_directory(folder);
    EXPECT_EQ(first.take(folder), "");
    EXPECT_EQ(first.take(folder), "") << "again";
    EXPECT_EQ(second.take(folder), "folder " + folder + " is in use by another plc-run");
  }
  EXPECT_EQ(second.take(folder), "");
}

}  // namespace
}  // namespace plc::test
