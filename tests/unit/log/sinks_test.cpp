// Files that are renamed, disks that are full, journals that stall.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "log/file_sink.h"
#include "log/format.h"
#include "log/log.h"

namespace plc::log {
namespace {

namespace fs = std::filesystem;

bool soon(const std::function<bool()>& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

Record said(const std::string& text) {
  Record record;
  record.text = text;
  record.utc_ns = 1;
  return record;
}
std::string plain(const Record& record) { return text_line(record, false); }

class Folder : public testing::Test {
 protected:
  Folder() {
    std::string name = (fs::temp_directory_path() / "picard-log-XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Folder() override { fs::remove_all(path); }
  [[nodiscard]] std::string file(const std::string& name = "plant.log") const { return (path / name).string(); }
  static std::string read(const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] FileOptions options(std::uint64_t size = 1'000'000, std::uint32_t keep = 3) const {
    return {file(), size, keep, plain, 20'000'000};
  }
  fs::path path;
};
class LogFile : public Folder {};
class Journal : public Folder {};

constexpr core::TimeNs kPatience = 2'000'000'000;

TEST_F(LogFile, HasItsLinesAlsoFromBeforeTheThread) {
  FileSink sink(options());
  sink.write(said("first"));
  EXPECT_FALSE(fs::exists(file())) << "a process that forks writes nothing twice";
  sink.start();
  sink.write(said("second"));
  sink.stop(kPatience);
  EXPECT_EQ(read(file()), "note: first\nnote: second\n");
}

TEST_F(LogFile, IsWrittenAtTheEndThoughNoThreadBegan) {
  FileSink sink(options());
  sink.write(said("the project has errors"));
  sink.stop(kPatience);
  EXPECT_EQ(read(file()), "note: the project has errors\n");
}

TEST_F(LogFile, IsRenamedWhenItIsLarge) {
  {
    FileSink sink(options(100, 2));  // nine lines of eleven bytes
    sink.start();
    for (int i = 0; i < 40; ++i) sink.write(said("n " + std::to_string(10 + i)));
    sink.stop(kPatience);
  }
  // 9 lines a file: 10..18 and 19..27 in the oldest two, of which one is deleted.
  EXPECT_EQ(read(file()).substr(0, 11), "note: n 46\n");
  EXPECT_EQ(read(file() + ".1").substr(0, 11), "note: n 37\n");
  EXPECT_EQ(read(file() + ".2").substr(0, 11), "note: n 28\n");
  EXPECT_EQ(read(file() + ".1").size(), 99u);
  EXPECT_FALSE(fs::exists(file() + ".3"));
}

TEST_F(LogFile, BeginsAnewWhenNoneIsKept) {
  FileSink sink(options(100, 0));
  sink.start();
  for (int i = 0; i < 40; ++i) sink.write(said("n " + std::to_string(10 + i)));
  sink.stop(kPatience);
  EXPECT_EQ(read(file()), "note: n 46\nnote: n 47\nnote: n 48\nnote: n 49\n");
  EXPECT_FALSE(fs::exists(file() + ".1"));
}

TEST_F(LogFile, GoesOnAfterARestartAndEndsATornLine) {
  std::ofstream(file()) << "note: before\nnote: half a li";
  FileSink sink(options());
  sink.write(said("after"));
  sink.stop(kPatience);
  EXPECT_EQ(read(file()), "note: before\nnote: half a li\nnote: after\n");
}

TEST_F(LogFile, IsMadeAnewWhenSomebodyTakesItAway) {
  FileSink sink(options());
  sink.start();
  sink.write(said("first"));
  ASSERT_TRUE(soon([&] { return read(file()) == "note: first\n"; }));
  fs::rename(file(), file("taken"));
  sink.write(said("second"));
  EXPECT_TRUE(soon([&] { return read(file()) == "note: second\n"; })) << read(file());
  EXPECT_EQ(read(file("taken")), "note: first\n");
}

TEST_F(LogFile, WaitsForItsFolder) {
  FileOptions late = options();
  late.path = file("later/plant.log");
  FileSink sink(late);
  sink.start();
  sink.write(said("first"));
  ASSERT_TRUE(soon([&] { return sink.problem() == "No such file or directory"; })) << sink.problem();
  fs::create_directory(path / "later");
  EXPECT_TRUE(soon([&] { return read(late.path) == "note: first\n"; }));
  EXPECT_TRUE(soon([&] { return sink.problem().empty(); }));
}

TEST_F(LogFile, IsNotWrittenByTwo) {
  FileSink one(options()), two(options());
  one.start();
  one.write(said("one"));
  ASSERT_TRUE(soon([&] { return read(file()) == "note: one\n"; }));
  two.start();
  two.write(said("two"));
  EXPECT_TRUE(soon([&] { return two.problem() == "another process writes it"; })) << two.problem();
  EXPECT_EQ(read(file()), "note: one\n");
}

// A limit on the size of files is a disk that is full: at any byte of a line. It is taken away, and there is space
// again.
TEST_F(LogFile, SurvivesAFullDiskAndSaysWhatIsLost) {
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &ignore, &before);
  rlimit was{};
  getrlimit(RLIMIT_FSIZE, &was);
  for (rlim_t full = 30; full < 50; full += 3) {
    fs::remove(file());
    FileSink sink(options(100'000'000));
    sink.start();
    const rlimit small{full, was.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    for (int i = 0; i < 5; ++i) sink.write(said("n " + std::to_string(10 + i)));
    EXPECT_TRUE(soon([&] { return sink.problem() == "File too large"; })) << sink.problem();
    // Of what comes meanwhile as much waits as there is room for.
    const std::string large(60'000, 'x');
    for (int i = 0; i < 20; ++i) sink.write(said(large));
    setrlimit(RLIMIT_FSIZE, &was);
    EXPECT_TRUE(soon([&] { return sink.problem().empty(); }));
    sink.write(said("well again"));
    sink.stop(kPatience);
    std::istringstream in(read(file()));
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 5u + 17 + 2) << full;
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(lines[i], "note: n " + std::to_string(10 + i)) << full;
    std::size_t lost = 0;
    for (const std::string& line : lines)
      lost += line == "warning: 3 messages are lost: " + file() + " could not be written in time" ? 1 : 0;
    EXPECT_EQ(lost, 1u) << lines.back();
  }
  sigaction(SIGXFSZ, &before, nullptr);
}

TEST_F(LogFile, ADeviceThatIsAlwaysFullHoldsNobodyUp) {
  FileOptions full = options();
  full.path = "/dev/full";
  FileSink sink(full);
  sink.start();
  for (int i = 0; i < 100'000; ++i) sink.write(said("0123456789"));
  EXPECT_TRUE(soon([&] { return sink.problem() == "No space left on device"; })) << sink.problem();
  const auto begin = std::chrono::steady_clock::now();
  sink.stop(kPatience);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
}

/// A journal in a folder of the test's own.
class Receiver {
 public:
  explicit Receiver(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Receiver() { ::close(fd_); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  std::vector<std::string> take() const {
    std::vector<std::string> all;
    char text[8192];
    for (;;) {
      const ssize_t n = ::recv(fd_, text, sizeof text, 0);
      if (n < 0) return all;
      all.emplace_back(text, static_cast<std::size_t>(n));
    }
  }

 private:
  int fd_;
};

TEST_F(Journal, IsADatagramForEachRecord) {
  const Receiver receiver(file("socket"));
  const auto sink = journal_sink(file("socket"));
  sink->write(said("first"));
  sink->write(said("second"));
  EXPECT_EQ(receiver.take(),
            (std::vector<std::string>{journal_datagram(said("first")), journal_datagram(said("second"))}));
  EXPECT_EQ(sink->problem(), "");
}

TEST_F(Journal, ThatStallsHoldsNobodyUpAndGetsItLater) {
  const Receiver receiver(file("socket"));
  const auto sink = journal_sink(file("socket"));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 2000; ++i) sink->write(said("number " + std::to_string(i)));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  EXPECT_EQ(sink->problem(), "");
  std::vector<std::string> all;
  for (;;) {
    const auto some = receiver.take();
    if (some.empty()) break;
    all.insert(all.end(), some.begin(), some.end());
    sink->flush();
  }
  ASSERT_EQ(all.size(), 2000u);
  EXPECT_EQ(all.back(), journal_datagram(said("number 1999")));
}

TEST_F(Journal, ThatIsNotThereYetGetsWhatWasSaidBefore) {
  const auto sink = journal_sink(file("socket"));
  sink->write(said("early"));
  EXPECT_EQ(sink->problem(), "No such file or directory");
  const Receiver receiver(file("socket"));
  sink->flush();
  EXPECT_EQ(sink->problem(), "");
  EXPECT_EQ(receiver.take().size(), 1u);
}

TEST_F(Journal, CountsWhatIsLost) {
  const auto sink = journal_sink(file("socket"));
  const std::string large(100'000, 'x');
  for (int i = 0; i < 15; ++i) sink->write(said(large));  // ten fit
  const Receiver receiver(file("socket"));
  std::vector<std::string> all;
  for (int i = 0; i < 20; ++i) {
    sink->flush();
    const auto some = receiver.take();
    all.insert(all.end(), some.begin(), some.end());
  }
  ASSERT_EQ(all.size(), 11u);
  EXPECT_EQ(all.back(),
            "MESSAGE=5 messages are lost: the journal did not take them\nPRIORITY=4\nSYSLOG_IDENTIFIER=plc-run\n");
}

TEST_F(LogFile, FurtherLinesOfATextBelongToItsMessage) {
  std::ostringstream aside;
  Log log({core::Severity::kNote, 60'000'000'000, 200}, std::make_unique<FileSink>(options()), "plant.log", aside);
  log.start();
  log.write(said(
      "historian.toml:2:8: error P7102: \"Txt\" is a text\n  help: take a number\nhistorian.toml:3:1: error P7303\n"));
  log.stop(kPatience);
  EXPECT_EQ(read(file()),
            "note: historian.toml:2:8: error P7102: \"Txt\" is a text\n"
            "  help: take a number\n"
            "  historian.toml:3:1: error P7303\n");
}

TEST_F(LogFile, TheLogLeavesOutWhatIsNotSevereAndSaysWhyItCannotWrite) {
  std::ostringstream aside;
  FileOptions late = options();
  late.path = file("later/plant.log");
  Log log({core::Severity::kWarning, 60'000'000'000, 200}, std::make_unique<FileSink>(late), late.path, aside);
  log.start();
  Record warning = said("careful");
  warning.severity = core::Severity::kWarning;
  log.write(said("nice to know"));
  log.write(warning);
  log.write(warning);
  const auto shows = [&](const std::string& part) {
    return soon([&] { return log.service(), aside.str().find(part) != std::string::npos; });
  };
  EXPECT_TRUE(shows("warning: P7620: the log cannot be written to " + late.path + ": No such file or directory"))
      << aside.str();
  fs::create_directory(path / "later");
  EXPECT_TRUE(shows("note: the log is written again to " + late.path)) << aside.str();
  log.stop(kPatience);
  EXPECT_EQ(read(late.path).substr(0, 17), "warning: careful\n");
  EXPECT_NE(read(late.path).find("warning: careful (1 time more in "), std::string::npos) << read(late.path);
}

Record careful(const std::string& text) {
  Record record = said(text);
  record.severity = core::Severity::kWarning;
  return record;
}
std::size_t times_in(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_F(LogFile, WhatIsNeverWrittenIsShownAsideOnce) {
  std::ostringstream aside;
  FileOptions none = options();
  none.path = file("later/plant.log");
  Log log({core::Severity::kNote, 60'000'000'000, 200}, std::make_unique<FileSink>(none), none.path, aside);
  log.write(careful("before the problem is known"));
  log.write(said("a note"));
  Record seen = careful("printed before");
  seen.shown = true;
  log.write(seen);
  log.start();
  ASSERT_TRUE(soon([&] { return log.service(), aside.str().find("P7620") != std::string::npos; }));
  EXPECT_EQ(times_in(aside.str(), "warning: before the problem is known\n"), 1u) << aside.str();
  log.write(careful("while there is one"));
  EXPECT_EQ(times_in(aside.str(), "warning: while there is one\n"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "a note"), 0u) << "notes may still be written in time";
  log.stop(kPatience);
  EXPECT_EQ(times_in(aside.str(), "note: a note\n"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "before the problem is known"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "while there is one"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "printed before"), 0u) << aside.str();
}

TEST_F(LogFile, WhatIsWrittenInTheEndIsShownOnceWhereItWasUrgent) {
  std::ostringstream aside;
  FileOptions late = options();
  late.path = file("later/plant.log");
  Log log({core::Severity::kNote, 60'000'000'000, 200}, std::make_unique<FileSink>(late), late.path, aside);
  log.start();
  log.write(careful("urgent"));
  log.write(said("a note"));
  ASSERT_TRUE(soon([&] { return log.service(), times_in(aside.str(), "urgent") == 1; })) << aside.str();
  fs::create_directory(path / "later");
  ASSERT_TRUE(soon([&] { return read(late.path) == "warning: urgent\nnote: a note\n"; })) << read(late.path);
  log.stop(kPatience);
  EXPECT_EQ(times_in(aside.str(), "urgent"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "a note"), 0u) << aside.str();
}

TEST_F(Journal, ThatIsNotThereLeavesItsRecordsAside) {
  std::ostringstream aside;
  Log log({core::Severity::kNote, 60'000'000'000, 2000}, journal_sink(file("socket")), "the journal", aside);
  log.start();
  log.write(said("a note"));
  log.write(careful("urgent"));
  log.service();
  EXPECT_EQ(times_in(aside.str(), "warning: urgent\n"), 1u) << aside.str();
  const std::string large(100'000, 'x');
  for (int i = 0; i < 15; ++i) log.write(said(large + std::to_string(i)));
  log.stop(kPatience);
  EXPECT_EQ(times_in(aside.str(), "urgent"), 1u) << aside.str();
  EXPECT_EQ(times_in(aside.str(), "note: a note\n"), 1u) << aside.str();
  EXPECT_NE(aside.str().find(" messages are lost: the journal could not be written in time"), std::string::npos);
}

}  // namespace
}  // namespace plc::log
