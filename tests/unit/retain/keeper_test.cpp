// Values of tasks that run, and their way through a restart.
#include "retain/keeper.h"

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/unit/retain/plant.h"

namespace plc::test {
namespace {

using retain::Keeper;
using retain::Start;

const std::string kCounter = with_task(
    "PROGRAM Main VAR RETAIN n : DINT; text : STRING[8]; END_VAR VAR PERSISTENT hours : DINT; END_VAR\n"
    "VAR_EXTERNAL Total, Setpoint : DINT; END_VAR\n"
    "  n := n + 1; hours := hours + 2; Total := n + Setpoint; text := DINT_TO_STRING(n); END_PROGRAM\n"
    "VAR_GLOBAL RETAIN Total, Setpoint : DINT; END_VAR\n");

/// One scan, and the end of it as the scheduler has it.
runtime::Fault scan(runtime::Resource& resource, core::TimeNs now_ns, std::size_t task = 0) {
  runtime::Program& program = resource.program(task);
  const runtime::Fault fault = program.execute({now_ns});
  program.offer_kept();
  return fault;
}

TEST(Keeper, StoresWhatWasAskedForAtTheEndOfAScan) {
  const ScratchFolder scratch;
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  EXPECT_FALSE(keeper.restore(Start::kWarm).found);
  for (int n = 0; n < 3; ++n) scan(*resource, n);
  keeper.ask();
  EXPECT_FALSE(keeper.answered());
  scan(*resource, 3);
  EXPECT_TRUE(keeper.answered());
  scan(*resource, 4);  // later than asked
  keeper.store(0);

  const auto next = load_text(kCounter);
  Keeper again(*next, {scratch.file("state")});
  const retain::Restored restored = again.restore(Start::kWarm);
  EXPECT_TRUE(restored.found);
  EXPECT_FALSE(restored.problem);
  EXPECT_TRUE(restored.carried.same_program);
  EXPECT_EQ(restored.program_time_ns, 3);
  EXPECT_EQ(value_of(*next, "main.n"), "4");
  EXPECT_EQ(value_of(*next, "main.text"), "'4'");
  EXPECT_EQ(value_of(*next, "Total"), "4");
  scan(*next, 5);
  EXPECT_EQ(value_of(*next, "main.n"), "5");
  EXPECT_EQ(value_of(*next, "Total"), "5");
}

TEST(Keeper, StoresWhatHmisWrite) {
  const ScratchFolder scratch;
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  set_value(*resource, "Setpoint", "40");
  keeper.store(0);  // no scan at all
  const auto next = load_text(kCounter);
  Keeper again(*next, {scratch.file("state")});
  again.restore(Start::kWarm);
  EXPECT_EQ(value_of(*next, "Setpoint"), "40");
  scan(*next, 1);
  EXPECT_EQ(value_of(*next, "Total"), "41");
}

TEST(Keeper, ColdAndOriginStarts) {
  const ScratchFolder scratch;
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  keeper.ask();
  scan(*resource, 1);
  keeper.store(0);
  const auto start = [&](Start how) {
    const auto next = load_text(kCounter);
    Keeper again(*next, {scratch.file("state")});
    again.restore(how);
    return value_of(*next, "main.n") + " " + value_of(*next, "main.hours");
  };
  EXPECT_EQ(start(Start::kWarm), "1 2");
  EXPECT_EQ(start(Start::kCold), "0 2");
  EXPECT_EQ(start(Start::kOrigin), "0 0");
}

TEST(Keeper, AScanThatFaultsIsNotStored) {
  const ScratchFolder scratch;
  runtime::ProgramOptions options;
  options.loop_budget = 100;
  const auto resource = load_text(
      with_task("PROGRAM Main VAR RETAIN n, m : DINT; END_VAR VAR i : DINT; END_VAR\n"
                "  n := n + 1;\n  IF n = 2 THEN WHILE TRUE DO i := i + 1; END_WHILE; END_IF;\n  m := n; END_PROGRAM\n"),
      options);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  EXPECT_FALSE(scan(*resource, 1));
  keeper.ask();
  EXPECT_TRUE(scan(*resource, 2));
  EXPECT_FALSE(keeper.answered());
  EXPECT_FALSE(scan(*resource, 3));
  EXPECT_TRUE(keeper.answered());
  keeper.store(0);
  const auto stored = retain::read_file(keeper.path());
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->values[0], std::byte{3});
  EXPECT_EQ(stored->values[4], std::byte{3});
}

TEST(Keeper, AnAnswerThatCameLateIsTakenNextTime) {
  const ScratchFolder scratch;
  const auto resource = load_text(
      "PROGRAM Main VAR RETAIN n : DINT; END_VAR n := n + 1; END_PROGRAM\n"
      "CONFIGURATION C RESOURCE R ON PLC TASK A(INTERVAL := T#10ms, PRIORITY := 0); TASK B(INTERVAL := T#10s, PRIORITY "
      ":= 1);\n"
      "PROGRAM fast WITH A : Main; PROGRAM slow WITH B : Main; END_RESOURCE END_CONFIGURATION\n");
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  keeper.ask();
  scan(*resource, 1, 0);
  keeper.store(0);
  scan(*resource, 2, 1);
  keeper.ask();
  scan(*resource, 3, 0);
  EXPECT_TRUE(keeper.answered());
  keeper.store(1);
  const auto stored = retain::read_file(keeper.path());
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->sequence, 2u);
  EXPECT_EQ(stored->values[0], std::byte{2});
  EXPECT_EQ(stored->values[4], std::byte{1});
}

TEST(Keeper, NothingIsWrittenWhenNothingChanged) {
  const ScratchFolder scratch;
  const auto resource = load_text(
      with_task("PROGRAM Main VAR RETAIN n : DINT := 3; END_VAR VAR x : DINT; END_VAR x := x + n; END_PROGRAM\n"));
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  for (int n = 0; n < 5; ++n) {
    keeper.ask();
    scan(*resource, n);
    keeper.store(n);
  }
  EXPECT_EQ(retain::read_file(keeper.path())->sequence, 1u);
}

TEST(Keeper, TroubleIsToldOnceAndItsEndToo) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("state")) << "in the way";
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  EXPECT_FALSE(keeper.restore(Start::kWarm).found);
  constexpr core::TimeNs kSecond = 1'000'000'000;
  keeper.store(0);
  keeper.store(kSecond);
  keeper.store(2 * kSecond);
  const std::vector<retain::Message> said = keeper.messages();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].text.find("P7613"), std::string::npos) << said[0].text;
  EXPECT_EQ(said[0].severity, core::Severity::kWarning);
  std::filesystem::remove(scratch.file("state"));
  keeper.store(2 * kSecond + 1);  // not yet
  EXPECT_TRUE(keeper.messages().empty());
  keeper.store(3 * kSecond);
  const std::vector<retain::Message> again = keeper.messages();
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].text, "retained values are stored again");
  EXPECT_EQ(again[0].severity, core::Severity::kNote);
}

TEST(Keeper, AFileThatCannotBeReadIsAProblemAndInitialValues) {
  const ScratchFolder scratch;
  std::filesystem::create_directory(scratch.file("state"));
  std::ofstream(scratch.file("state/retain")) << "half a fi";
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  const retain::Restored restored = keeper.restore(Start::kWarm);
  ASSERT_TRUE(restored.problem);
  EXPECT_EQ(restored.problem->code, core::Code::P7611);
  EXPECT_EQ(value_of(*resource, "main.n"), "0");
}

/// What a timer and a chart of a program that is kept do after a restart.
std::string timer_and_chart(const std::string& more) {
  return "PROGRAM Main VAR t : TON; edge : R_TRIG; n : INT; never : BOOL; END_VAR\n"
         "  t(IN := TRUE, PT := T#10s); edge(CLK := TRUE); IF edge.Q THEN n := n + 1; END_IF;\n" +
         more +
         "END_PROGRAM\nCONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms); PROGRAM RETAIN main WITH T : "
         "Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

TEST(Keeper, TimersAndEdgesGoOnWhereTheyWere) {
  for (const char* const more : {"", "  n := n + 0;\n"}) {  // the same program, and a changed one
    const ScratchFolder scratch;
    const auto resource = load_text(timer_and_chart(""));
    ASSERT_NE(resource, nullptr);
    Keeper keeper(*resource, {scratch.file("state")});
    keeper.restore(Start::kWarm);
    constexpr core::TimeNs kSecond = 1'000'000'000;
    scan(*resource, 100 * kSecond);
    keeper.ask();
    scan(*resource, 104 * kSecond);
    keeper.store(0);
    const auto next = load_text(timer_and_chart(more));
    Keeper again(*next, {scratch.file("state")});
    const retain::Restored restored = again.restore(Start::kWarm);
    EXPECT_EQ(restored.carried.misfits, std::vector<std::string>{});
    ASSERT_EQ(restored.program_time_ns, 104 * kSecond);
    EXPECT_EQ(value_of(*next, "main.t.ET"), "4000000000");
    scan(*next, *restored.program_time_ns + kSecond);
    EXPECT_EQ(value_of(*next, "main.t.ET"), "5000000000");
    EXPECT_EQ(value_of(*next, "main.n"), "1");
  }
}

TEST(Keeper, EveryProtocolRestoresTheExchange) {
  for (const core::Coherence coherence :
       {core::Coherence::kWaitFree, core::Coherence::kGlobalLock, core::Coherence::kPriorityCeiling}) {
    const ScratchFolder scratch;
    core::CompileOptions options;
    options.coherence = coherence;
    const std::string text =
        "VAR_GLOBAL RETAIN Own, Both : DINT; END_VAR\n"
        "PROGRAM One VAR_EXTERNAL Own, Both : DINT; END_VAR Own := Own + 1; Both := Both + 10; END_PROGRAM\n"
        "PROGRAM Two VAR RETAIN seen : DINT; END_VAR VAR_EXTERNAL Own, Both : DINT; END_VAR\n"
        "  seen := Own; Both := Both + 100; END_PROGRAM\n"
        "CONFIGURATION C RESOURCE R ON PLC TASK A(INTERVAL := T#10ms, PRIORITY := 0); TASK B(INTERVAL := T#10ms, "
        "PRIORITY := 1);\n"
        "PROGRAM one WITH A : One; PROGRAM two WITH B : Two; END_RESOURCE END_CONFIGURATION\n";
    const auto resource = load_text(text, {}, options);
    ASSERT_NE(resource, nullptr);
    Keeper keeper(*resource, {scratch.file("state")});
    keeper.restore(Start::kWarm);
    keeper.ask();
    scan(*resource, 1, 0);
    scan(*resource, 1, 1);
    keeper.store(0);
    const auto next = load_text(text, {}, options);
    Keeper again(*next, {scratch.file("state")});
    again.restore(Start::kWarm);
    scan(*next, 2, 1);
    EXPECT_EQ(value_of(*next, "two.seen"), "1");
    EXPECT_EQ(value_of(*next, "Both"), "210");
    scan(*next, 2, 0);
    EXPECT_EQ(value_of(*next, "Own"), "2");
    EXPECT_EQ(value_of(*next, "Both"), "220");
  }
}

TEST(Keeper, TheLastScanIsStoredAtTheEnd) {
  const ScratchFolder scratch;
  const auto resource = load_text(kCounter);
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  keeper.start();
  for (int n = 0; n < 1000; ++n) scan(*resource, n);
  keeper.stop();
  const auto next = load_text(kCounter);
  Keeper again(*next, {scratch.file("state")});
  again.restore(Start::kWarm);
  EXPECT_EQ(value_of(*next, "main.n"), "1000");
  EXPECT_EQ(value_of(*next, "Total"), "1000");
}

TEST(Keeper, EverySetIsOfOneScanWhileTheTaskRuns) {
  const ScratchFolder scratch;
  const auto resource = load_text(
      with_task("PROGRAM Main VAR RETAIN n : DINT; a : ARRAY [1..2000] OF DINT; END_VAR VAR i : DINT; END_VAR\n"
                "VAR_EXTERNAL Copy : DINT; END_VAR\n"
                "  n := n + 1; FOR i := 1 TO 2000 DO a[i] := n; END_FOR; Copy := n; END_PROGRAM\n"
                "VAR_GLOBAL RETAIN Copy : DINT; END_VAR\n"));
  ASSERT_NE(resource, nullptr);
  Keeper keeper(*resource, {scratch.file("state")});
  keeper.restore(Start::kWarm);
  std::atomic<bool> done{false};
  std::thread task([&] {
    for (core::TimeNs now = 0; !done; ++now) scan(*resource, now);
  });
  for (int round = 0; round < 50; ++round) {
    keeper.ask();
    while (!keeper.answered()) std::this_thread::yield();
    keeper.store(round);
    const auto stored = retain::read_file(keeper.path());
    ASSERT_TRUE(stored);
    for (std::size_t at = 4; at < stored->values.size(); at += 4) {
      ASSERT_EQ(std::memcmp(stored->values.data(), stored->values.data() + at, 4), 0) << at;
    }
  }
  done = true;
  task.join();
}

}  // namespace
}  // namespace plc::test
