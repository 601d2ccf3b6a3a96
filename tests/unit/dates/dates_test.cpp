// Date and time in programs: the same in every engine, once a scan, and nothing that timers notice.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "runtime/sched/realtime.h"
#include "runtime/sched/simulation.h"
#include "tests/support/engines.h"
#include "tests/support/run_tool.h"
#include "tools/date.h"

namespace plc::test {
namespace {

constexpr core::TimeNs kMs = 1'000'000;
constexpr core::TimeNs kSecond = 1'000'000'000;
constexpr core::TimeNs kHour = 3'600 * kSecond;
// 2026-03-29T01:00:00Z: in central Europe 02:00 becomes 03:00.
constexpr core::TimeNs kSpring = 1'774'746'000 * kSecond;

const char* const kProgram =
    "FUNCTION Now : LDT Now := UTC_LDT(); END_FUNCTION\n"
    "PROGRAM Main\n"
    "VAR Utc, Local, Shown : DT; Wide, LocalWide, Called : LDT; Offset : TIME; Clock : SYS_TIME; Set : RTC; Go : "
    "BOOL;\n"
    "    Delay, Pulse : TON; Edge : BOOL; Runs, Scans, Uneven : DINT; Up : TIME; END_VAR\n"
    "  Utc := UTC_DT(); Wide := UTC_LDT(); Local := LOCAL_DT(); LocalWide := LOCAL_LDT(); Called := Now();\n"
    "  Clock(); Shown := Clock.LOCAL; Offset := Clock.OFFSET;\n"
    "  IF Clock.UTC <> Utc OR Clock.UTC <> UTC_DT() OR Called <> Wide THEN Uneven := Uneven + 1; END_IF;\n"
    "  Delay(IN := TRUE, PT := T#95ms);\n"
    "  Pulse(IN := NOT Pulse.Q, PT := T#20ms);\n"
    "  IF Pulse.Q THEN Runs := Runs + 1; END_IF;\n"
    "  Go := Delay.Q;\n"
    "  Set(IN := Go, PDT := DT#2000-01-01-00:00:00);\n"
    "  Up := TIME(); Scans := Scans + 1;\n"
    "END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC\n"
    "  TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main;\n"
    "END_RESOURCE END_CONFIGURATION\n";

std::optional<bytecode::VerifiedImage> compiled() {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("plant.st")) << kProgram;
  compiler::Compilation compilation;
  compiler::compile({scratch.file("plant.st"), {}, compiler::Goal::kRun}, compilation);
  for (const auto& one : compilation.diagnostics.all()) ADD_FAILURE() << one.message;
  return std::move(compilation.image);
}

std::string value(runtime::Resource& resource, const std::string& path) {
  const runtime::Access access(resource);
  const auto found = access.find("main." + path);
  return found ? access.read(*found, runtime::ValueStyle::kNames) : found.error().message;
}

class Dates : public testing::Test {
 protected:
  void SetUp() override {
    image_ = compiled();
    ASSERT_TRUE(image_);
    zone_ = core::TimeZone::load("CET-1CEST,M3.5.0,M10.5.0/3");
    ASSERT_TRUE(zone_);
    options_.zone = &*zone_;
  }
  std::unique_ptr<runtime::Resource> load() {
    auto loaded = runtime::Resource::load(bytecode::VerifiedImage(*image_), options_);
    EXPECT_TRUE(loaded);
    return loaded ? std::move(*loaded) : nullptr;
  }
  std::optional<bytecode::VerifiedImage> image_;
  std::optional<core::TimeZone> zone_;
  runtime::ProgramOptions options_;
};

TEST_F(Dates, AreThoseOfTheScanInUtcAndLocalTime) {
  const auto resource = load();
  ASSERT_FALSE(resource->program(0).execute({0, 0, kSpring - 1500 * kMs}));
  EXPECT_EQ(value(*resource, "Utc"), "DT#2026-03-29-00:59:58.5");
  EXPECT_EQ(value(*resource, "Wide"), "LDT#2026-03-29-00:59:58.5");
  EXPECT_EQ(value(*resource, "Local"), "DT#2026-03-29-01:59:58.5");
  EXPECT_EQ(value(*resource, "Offset"), "T#1h");
  EXPECT_EQ(value(*resource, "Set.CDT"), "DT#2026-03-29-00:59:58.5") << "RTC with IN FALSE";
  ASSERT_FALSE(resource->program(0).execute({10 * kMs, 0, kSpring}));
  EXPECT_EQ(value(*resource, "Local"), "DT#2026-03-29-03:00:00");
  EXPECT_EQ(value(*resource, "LocalWide"), "LDT#2026-03-29-03:00:00");
  EXPECT_EQ(value(*resource, "Shown"), "DT#2026-03-29-03:00:00");
  EXPECT_EQ(value(*resource, "Offset"), "T#2h");
  EXPECT_EQ(value(*resource, "Uneven"), "0");
}

TEST_F(Dates, AreTheSameInEveryEngineWhateverTheClockDoes) {
  std::string problem;
  const auto engines = Engines::load(*image_, problem, options_);
  ASSERT_NE(engines, nullptr) << problem;
  core::TimeNs utc = 0;
  for (int scan = 0; scan < 2000; ++scan) {
    utc = utc > INT64_MAX - 10 * kMs ? INT64_MAX : utc + 10 * kMs;
    if (scan % 7 == 3) utc = kSpring + scan * kHour;
    if (scan % 11 == 5) utc -= 40 * 365 * 24 * kHour;
    if (scan % 501 == 500) utc = INT64_MAX - 10 * kMs;
    ASSERT_EQ(engines->scan(0, scan * 10 * kMs, utc), "") << "scan " << scan;
  }
  EXPECT_EQ(value((*engines)[0], "Uneven"), "0");
}

// Two runs of the same scans: one of them with a clock that is set again and again.
TEST_F(Dates, TimersDoNotNoticeThatTheClockIsSet) {
  const auto even = load(), stepped = load();
  core::TimeNs utc = kSpring;
  for (int scan = 0; scan < 500; ++scan) {
    const core::TimeNs now = scan * 10 * kMs;
    utc += 10 * kMs;
    if (scan == 5) utc = 0;                      // back to 1970, before the delay is over
    if (scan == 8) utc = kSpring + 100 * kHour;  // NTP has the time
    if (scan % 50 == 49) utc += (scan % 100 == 99 ? -1 : 1) * kHour;
    ASSERT_FALSE(even->program(0).execute({now, 0, kSpring + now}));
    ASSERT_FALSE(stepped->program(0).execute({now, 0, utc}));
    for (const char* const path : {"Delay.Q", "Delay.ET", "Pulse.Q", "Pulse.ET", "Runs", "Up", "Go", "Set.Q"})
      ASSERT_EQ(value(*stepped, path), value(*even, path)) << path << " in scan " << scan;
    if (scan >= 10) {
      ASSERT_EQ(value(*stepped, "Set.CDT"), value(*even, "Set.CDT")) << "RTC runs from its preset";
    }
  }
  EXPECT_NE(value(*stepped, "Utc"), value(*even, "Utc"));
  EXPECT_EQ(value(*even, "Set.CDT"), "DT#2000-01-01-00:00:04.89");
}

/// A clock that goes backwards, an hour each time it is asked.
class Backwards final : public core::Calendar {
 public:
  [[nodiscard]] core::TimeNs utc_ns() const noexcept override { return kSpring - ++asked * kHour; }
  mutable std::atomic<std::int64_t> asked{0};
};

TEST_F(Dates, ArePickedOnceAScanInRealTime) {
  const auto resource = load();
  const Backwards calendar;
  struct Seen : runtime::CycleListener {
    void before_scan(const runtime::ReleaseContext& context) noexcept override { utc.store(context.utc_ns); }
    void after_scan(const runtime::ReleaseContext&) noexcept override {}
    void safe_state() noexcept override {}
    std::atomic<core::TimeNs> utc{0};
  } seen;
  runtime::RealtimeOptions options;
  options.calendar = &calendar;
  options.realtime_priority = false;
  options.lock_memory = false;
  runtime::RealtimeScheduler scheduler(*resource, options);
  scheduler.add_listener(seen);
  scheduler.start();
  while (scheduler.statistics(0).scans < 30) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  scheduler.request_stop();
  scheduler.join();
  const auto scans = static_cast<std::int64_t>(scheduler.statistics(0).scans);
  EXPECT_EQ(calendar.asked, scans);
  EXPECT_EQ(seen.utc, kSpring - scans * kHour);
  EXPECT_EQ(value(*resource, "Scans"), std::to_string(scans));
  EXPECT_EQ(value(*resource, "Uneven"), "0");
  EXPECT_EQ(value(*resource, "Delay.Q"), "1");
  EXPECT_GE(std::stoll(value(*resource, "Runs")), 5);
}

TEST_F(Dates, InSimulationGoOnWithVirtualTime) {
  const auto resource = load();
  runtime::Simulation simulation(*resource, {.date_ns = kSpring - 20 * kMs});
  simulation.run_cycles(3);
  EXPECT_EQ(value(*resource, "Utc"), "DT#2026-03-29-01:00:00");
  EXPECT_EQ(value(*resource, "Local"), "DT#2026-03-29-03:00:00");
  simulation.set_utc(0, simulation.now_ns());
  simulation.run_cycles(1);
  EXPECT_EQ(value(*resource, "Utc"), "DT#1970-01-01-00:00:00.01");
  EXPECT_EQ(value(*resource, "Up"), "T#30ms");
}

TEST(DateText, IsReadAsPeopleWriteIt) {
  const auto ns = [](std::string_view text) { return tools::parse_date_ns(text).value_or(-1); };
  EXPECT_EQ(ns("2026-03-29T01:00:00"), kSpring);
  EXPECT_EQ(ns("2026-03-29T01:00:00Z"), kSpring);
  EXPECT_EQ(ns("2026-03-29 01:00"), kSpring);
  EXPECT_EQ(ns("DT#2026-03-29-01:00:00.25"), kSpring + 250 * kMs);
  EXPECT_EQ(ns("ldt#2026-03-29-01:00:00.0000000019"), kSpring + 1);
  EXPECT_EQ(ns("1970-01-01"), 0);
  EXPECT_EQ(ns("2024-02-29"), 1'709'164'800 * kSecond);
  EXPECT_EQ(ns("2261-12-31T23:59:59.999999999"), 9'214'646'399'999'999'999);
  for (const char* const wrong :
       {"", "now", "2026", "2026-03", "26-03-29", "2026-02-29", "2026-13-01", "2026-03-29T24:00:00",
        "2026-03-29T1:00:00", "2026-03-29T01:60:00", "2026-03-29T01:00:60", "2026-03-29T01:00:00.",
        "2026-03-29T01:00:00+01:00", "1969-12-31", "2262-01-01", "2026-03-29T", "2026-03-29x", "-026-03-29"})
    EXPECT_EQ(ns(wrong), -1) << wrong;
}

}  // namespace
}  // namespace plc::test
