// Records as text, JSON and datagrams of the journal.
#include "log/format.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace plc::log {
namespace {

// 2026-03-29T01:02:03.045Z
constexpr core::TimeNs kTime = 1'774'746'123'045'999'999;

Record bare() {
  Record record;
  record.utc_ns = kTime;
  record.text = "ends after 12.5 s: signal SIGTERM";
  return record;
}

Record full() {
  Record record;
  record.utc_ns = kTime;
  record.severity = core::Severity::kError;
  record.text = "fault R1004: the \"taskblock\" failed";
  record.source = "taskblock";
  record.code = "R1004";
  record.task = "Fast";
  record.block = "LOWPASS main.filter";
  record.details = "  help: look\n  at it";
  record.scan = 4711;
  return record;
}

TEST(LogFormat, TextIsALine) {
  EXPECT_EQ(text_line(bare()), "2026-03-29T01:02:03.045Z note: ends after 12.5 s: signal SIGTERM\n");
  EXPECT_EQ(text_line(full()),
            "2026-03-29T01:02:03.045Z error: fault R1004: the \"taskblock\" failed\n  help: look\n  at it\n");
  EXPECT_EQ(text_line(bare(), false), "note: ends after 12.5 s: signal SIGTERM\n");
}

TEST(LogFormat, JsonHasWhatIsKnown) {
  EXPECT_EQ(
      json_line(bare()),
      R"({"time": "2026-03-29T01:02:03.045Z", "severity": "note", "message": "ends after 12.5 s: signal SIGTERM"})"
      "\n");
  EXPECT_EQ(json_line(full()),
            R"({"time": "2026-03-29T01:02:03.045Z", "severity": "error", "message": "fault R1004: the \"taskblock\" )"
            R"(failed", "source": "taskblock", "code": "R1004", "task": "Fast", "scan": 4711, "block": )"
            R"("LOWPASS main.filter", "details": "  help: look\n  at it"})"
            "\n");
}

TEST(LogFormat, TheJournalGetsFields) {
  EXPECT_EQ(journal_datagram(bare()),
            "MESSAGE=ends after 12.5 s: signal SIGTERM\nPRIORITY=6\nSYSLOG_IDENTIFIER=plc-run\n");
  std::string details("PICARD_DETAILS\n");
  const char size[8] = {20, 0, 0, 0, 0, 0, 0, 0};
  details.append(size, sizeof size).append("  help: look\n  at it\n");
  EXPECT_EQ(journal_datagram(full()),
            "MESSAGE=fault R1004: the \"taskblock\" failed\nPRIORITY=3\nSYSLOG_IDENTIFIER=plc-run\n"
            "PICARD_SOURCE=taskblock\nPICARD_CODE=R1004\nPICARD_TASK=Fast\nPICARD_SCAN=4711\n"
            "PICARD_BLOCK=LOWPASS main.filter\n" +
                details);
  Record warning = bare();
  warning.severity = core::Severity::kWarning;
  EXPECT_NE(journal_datagram(warning).find("\nPRIORITY=4\n"), std::string::npos);
}

TEST(LogFormat, NoTextLooksLikeAnotherMessage) {
  Record record = bare();
  record.text = "a\n2026-03-29T01:02:03.045Z error: b\r\x1b[2J \xff \xc3\xa4\xc2\x9b";
  const std::string clean = "a?2026-03-29T01:02:03.045Z error: b??[2J ? \xc3\xa4?";
  EXPECT_EQ(text_line(record), "2026-03-29T01:02:03.045Z note: " + clean + "\n");
  EXPECT_NE(json_line(record).find("\"message\": \"" + clean + "\""), std::string::npos) << json_line(record);
  EXPECT_EQ(journal_datagram(record).find("MESSAGE=" + clean + "\n"), 0u);
}

}  // namespace
}  // namespace plc::log
