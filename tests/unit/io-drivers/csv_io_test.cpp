// Scripted inputs, traces and the CSV they are written in.
#include <cstdio>
#include <fstream>

#include "io-drivers/csv.h"
#include "io-drivers/stimulus.h"
#include "io-drivers/trace.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using core::Code;
using io::Stimulus;
using io::TraceWriter;

struct Follower : OneProgram {
  Follower() {
    const Word in = b.global("in", b.type(TypeId::kInt), {}, {.input = true});
    const Word out = b.global("out", b.type(TypeId::kInt));
    b.global("text", b.string(10), {}, {.input = true});
    b.global("fixed", b.type(TypeId::kInt), {}, {.constant = true});
    main.op(Opcode::kAdd16, {out, in, b.constant<std::int16_t>(TypeId::kInt, 1)});
  }
};

TEST(Csv, QuotesAsInRfc4180) {
  const auto rows = io::parse_csv("\xef\xbb\xbf# note\r\na,\"b,\"\"c\"\"\n2\",\"\"\r\n\r\nx,,", "f");
  ASSERT_TRUE(rows.has_value());
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0][1].text, "b,\"c\"\n2");
  EXPECT_TRUE((*rows)[0][2].quoted);
  EXPECT_EQ((*rows)[0][1].line, 2u);
  EXPECT_EQ((*rows)[0][1].column, 3u);
  EXPECT_EQ((*rows)[1].size(), 3u);
  EXPECT_EQ((*rows)[1][0].line, 5u);
  EXPECT_NE(io::parse_csv("a\nb,\"c", "f").error().message.find("f:2:3:"), std::string::npos);
  EXPECT_FALSE(io::parse_csv("\"a\"b", "f"));
  EXPECT_FALSE(io::parse_csv("a\"b", "f"));
}

TEST(Csv, PlacesAreThoseOfTheFileWhateverItsLineEnds) {
  for (const std::string end : {"\n", "\r\n", "\r\r\n"}) {
    const auto rows = io::parse_csv("# note" + end + "a,b" + end + end + "\xC3\xA4\xE2\x82\xAC,\"c\",d", "f");
    ASSERT_TRUE(rows.has_value());
    ASSERT_EQ(rows->size(), 2u);
    EXPECT_EQ((*rows)[0][1].line, 2u);
    EXPECT_EQ((*rows)[0][1].column, 3u);
    EXPECT_EQ((*rows)[1][2].line, 4u);
    EXPECT_EQ((*rows)[1][2].column, 8u);
  }
  // A CR alone ends a row, and no line of the file.
  const auto rows = io::parse_csv("a,b\rc,d\n", "f");
  ASSERT_TRUE(rows.has_value());
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[1][1].line, 1u);
  EXPECT_EQ((*rows)[1][1].column, 7u);
}

TEST(Time, MillisecondsAsText) {
  EXPECT_EQ(io::parse_time_ms("12.5"), 12'500'000);
  EXPECT_EQ(io::parse_time_ms(" 0.000001 "), 1);
  EXPECT_EQ(io::parse_time_ms("0.0000001"), std::nullopt);
  EXPECT_EQ(io::parse_time_ms("1e3"), std::nullopt);
  EXPECT_EQ(io::parse_time_ms(""), std::nullopt);
  EXPECT_EQ(io::parse_time_ms("-1"), std::nullopt);
  EXPECT_EQ(io::parse_time_ms("99999999999999999999"), std::nullopt);
  for (const core::TimeNs ns :
       {core::TimeNs{0}, core::TimeNs{1}, core::TimeNs{12'500'000}, core::TimeNs{1'000'000'010}}) {
    std::string text;
    io::append_time_ms(text, ns);
    EXPECT_EQ(io::parse_time_ms(text), ns) << text;
  }
}

TEST(Simulated, RowsApplyAtTheFirstInstantAtOrAfterTheirTime) {
  Follower p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  auto driver = Stimulus::parse("time_ms,IN,text\n0,1,\n5,2,'hi'\n10,3\n10.5,,\"\"\n30,9,x\n", "s.csv", *r);
  ASSERT_TRUE(driver.has_value()) << driver.error().message;
  auto trace = TraceWriter::open("", {"in", "out", "text"}, *r);
  ASSERT_TRUE(trace.has_value());
  runtime::Simulation simulation(*r);
  driver->attach(simulation);
  (*trace)->attach(simulation);
  simulation.run_cycles(4);
  EXPECT_EQ((*trace)->text(),
            "cycle,time_ms,in,out,text\n"
            "0,0,1,2,''\n"
            "1,10,3,4,'hi'\n"
            "2,20,3,4,''\n"
            "3,30,9,10,'x'\n");
  EXPECT_EQ(driver->end_ns(), 30'000'000);
}

TEST(Simulated, ProblemsNameFileLineAndColumn) {
  Follower p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const struct {
    const char* text;
    Code code;
    const char* place;
  } cases[] = {
      {"", Code::P7202, "s.csv:1:1:"},
      {"ms,in\n", Code::P7202, "s.csv:1:1:"},
      {"time_ms,nope\n", Code::P7101, "s.csv:1:9:"},
      {"time_ms,fixed\n", Code::P7106, "s.csv:1:9:"},
      {"time_ms,in,IN\n", Code::P7202, "s.csv:1:12:"},
      {"time_ms,in\n0,1\nx,1\n", Code::P7202, "s.csv:3:1:"},
      {"time_ms,in\n5,1\n4,1\n", Code::P7202, "s.csv:3:1:"},
      {"time_ms,in\n0,1,2\n", Code::P7202, "s.csv:2:5:"},
      {"time_ms,in\n0,99999\n", Code::P7104, "s.csv:2:3:"},
      {"time_ms,text\n0,elevenchars\n", Code::P7105, "s.csv:2:3:"},
      {"time_ms,in\n0,\"\n", Code::P7201, "s.csv:2:3:"},
  };
  for (const auto& c : cases) {
    const auto driver = Stimulus::parse(c.text, "s.csv", *r);
    ASSERT_FALSE(driver.has_value()) << c.text;
    EXPECT_EQ(driver.error().code, c.code) << c.text << driver.error().message;
    EXPECT_TRUE(driver.error().message.starts_with(c.place)) << driver.error().message;
  }
  EXPECT_EQ(Stimulus::load("/no/such/file.csv", *r).error().code, Code::P7001);
}

TEST(Trace, WritesFilesAndReportsWhatItCannotWrite) {
  Follower p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const std::string file = testing::TempDir() + "trace_test.csv";
  auto trace = TraceWriter::open(file, {"out"}, *r);
  ASSERT_TRUE(trace.has_value());
  runtime::Simulation simulation(*r);
  (*trace)->attach(simulation);
  simulation.run_cycles(10'000);
  EXPECT_FALSE((*trace)->close());
  std::ifstream in(file);
  std::string line;
  std::string last;
  std::size_t lines = 0;
  while (std::getline(in, line)) {
    ++lines;
    last = line;
  }
  EXPECT_EQ(lines, 10'001u);
  EXPECT_EQ(last, "9999,99990,1");
  std::remove(file.c_str());
  EXPECT_EQ(TraceWriter::open("", {"Nope"}, *r).error().code, Code::P7101);
  EXPECT_EQ(TraceWriter::open("/no/such/dir/t.csv", {"out"}, *r).error().code, Code::P7001);
  auto full = TraceWriter::open("/dev/full", {"out"}, *r);
  ASSERT_TRUE(full.has_value());
  const auto problem = (*full)->close();
  ASSERT_TRUE(problem.has_value());
  EXPECT_EQ(problem->code, Code::P7203);
}

}  // namespace
}  // namespace plc::test
