// Alarms of a plant whose scans are recorded: each begins in the scan in which it did, in the order of the scans.
#include "alarms/alarms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

#include "runtime/sched/realtime.h"
#include "shadow/shadow.h"
#include "tests/support/counting_image.h"

namespace plc::test {
namespace {

using namespace alarms;

/// Total goes up by two with each scan; Away is written from outside.
bytecode::VerifiedImage alarm_image() {
  ImageBuilder b;
  b.global("Away", b.boolean(), {}, {false, true, {}, {}});
  return counting_image(b, 2);
}

struct Plant {
  explicit Plant(std::vector<Definition> definitions, bool recorded = true,
                 bytecode::VerifiedImage image = alarm_image())
      : resource(std::move(*runtime::Resource::load(std::move(image)))),
        alarms(*resource, std::move(definitions), recorded, diagnostics) {
    if (!recorded) return;
    auto started = shadow::Shadow::start(
        *resource, {}, {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource->image())});
    EXPECT_TRUE(started) << started.error().message;
    shadow = std::move(*started);
    shadow->observe(alarms);
  }
  void scans(int count, std::uint32_t task = 0) {
    for (int i = 0; i < count; ++i) {
      now_ns += 10'000'000;
      ASSERT_FALSE(resource->program(task).execute({now_ns, 0, now_ns}));
    }
  }
  void write(const char* path, const char* value) {
    runtime::Access access(*resource);
    ASSERT_FALSE(access.write(*access.find(path), value));
  }
  /// What has happened, once the shadow knows all scans.
  std::vector<Event> events(std::size_t least) {
    std::vector<Event> all;
    std::vector<Kept> states;
    for (int turn = 0; turn < 1000; ++turn) {
      alarms.take(all, states);
      if (all.size() >= least) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return all;
  }

  core::Diagnostics diagnostics;
  core::TimeNs now_ns = 0;
  std::unique_ptr<runtime::Resource> resource;
  Alarms alarms;
  std::unique_ptr<shadow::Shadow> shadow;  // ends before what it tells
};

Definition above(const std::string& name, const std::string& variable, double limit) {
  Definition made;
  made.name = name;
  made.variable = variable;
  made.comparison = Comparison::kAbove;
  made.limit = limit;
  made.text = name;
  return made;
}

TEST(Alarms, BeginInTheirScanAndInTheirOrder) {
  std::vector<Definition> all = {above("Late", "Main0.Count", 150), above("First", "Total", 120),
                                 above("Second", "Main0.Count", 100)};
  for (Definition& one : all) one.group = "G";
  all[2].on_delay_ns = 200'000'000;
  Plant plant(std::move(all));
  ASSERT_EQ(plant.diagnostics.error_count(), 0u);
  plant.scans(300);
  const auto events = plant.events(3);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].alarm, "First");
  EXPECT_EQ(events[0].scan, 60u) << "Total is 122 after the scan with number 60";
  EXPECT_EQ(events[0].task, "Fast");
  EXPECT_EQ(events[0].value, 122);
  EXPECT_EQ(events[0].utc_ns, 610'000'000) << "the time of the scan, not of the look";
  EXPECT_EQ(events[1].alarm, "Second");
  EXPECT_EQ(events[1].scan, 120u) << "Count is 101 after scan 100; 200 ms are 20 scans";
  EXPECT_EQ(events[2].alarm, "Late");
  EXPECT_EQ(events[2].scan, 150u);
  const auto views = plant.alarms.list(false);
  ASSERT_EQ(views.size(), 3u);
  for (const View& view : views) {
    const std::uint32_t order = view.definition.name == "First" ? 1 : view.definition.name == "Second" ? 2 : 3;
    EXPECT_EQ(view.order, order) << view.definition.name;
    EXPECT_EQ(view.state, State::kUnackedActive);
  }
}

TEST(Alarms, AreAcknowledgedShelvedAndTakenOutOfService) {
  Plant plant({above("Total", "Total", 10)});
  plant.scans(20);
  ASSERT_EQ(plant.events(1).size(), 1u);
  EXPECT_EQ(plant.alarms.acknowledge({"total"}, {"otto", "seen", 5, 0}), 1u);
  EXPECT_EQ(plant.alarms.acknowledge({}, {"otto", "", 5, 0}), 0u);
  auto view = plant.alarms.list(false).front();
  EXPECT_EQ(view.state, State::kAckedActive);
  EXPECT_EQ(view.user + " " + view.comment, "otto seen");
  EXPECT_FALSE(plant.alarms.shelve("None", 100, {}));
  EXPECT_TRUE(plant.alarms.shelve("Total", 100, {"otto", "trial", 6, plant.now_ns}));
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kShelved);
  plant.alarms.service(plant.now_ns, 99);
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kShelved);
  plant.alarms.service(plant.now_ns, 100);
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kUnackedActive) << "the shelf has ended";
  EXPECT_TRUE(plant.alarms.take_out_of_service("Total", true, {"emil", "no sensor", 200, 0}));
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kOutOfService);
  std::vector<std::string> happened;
  for (const Event& event : plant.events(5))
    happened.emplace_back(kHappenedTexts[static_cast<std::size_t>(event.what)]);
  EXPECT_EQ(happened, (std::vector<std::string>{"acknowledged", "shelved", "unshelved", "raised", "out of service"}));
}

TEST(Alarms, AShelfLastsNoLongerBecauseTheClockIsSetBack) {
  constexpr core::TimeNs kS = 1'000'000'000;
  Plant plant({above("Total", "Total", 10)});
  plant.scans(20);
  ASSERT_EQ(plant.events(1).size(), 1u);
  ASSERT_TRUE(plant.alarms.shelve("Total", 5060 * kS, {"otto", "trial", 5000 * kS, 1 * kS}));
  plant.alarms.service(60 * kS, 1000 * kS);
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kShelved);
  plant.alarms.service(61 * kS, 1001 * kS);
  EXPECT_EQ(plant.alarms.list(false).front().state, State::kUnackedActive) << "60 s are over";
}

TEST(Alarms, OfALargeGroupAreListedAtOnce) {
  constexpr int kMany = 4000;
  const auto list_ns = [](const std::string& group) {
    std::vector<Definition> all;
    for (int i = 0; i < kMany; ++i) {
      all.push_back(above("A" + std::to_string(i), "Total", 2 * i));
      all.back().group = group;
    }
    Plant plant(std::move(all), false);
    for (int i = 0; i <= kMany; ++i) {
      plant.scans(1);
      plant.alarms.service(plant.now_ns, plant.now_ns);
    }
    std::chrono::nanoseconds best = std::chrono::hours(1);
    for (int turn = 0; turn < 5; ++turn) {
      const auto begin = std::chrono::steady_clock::now();
      const auto views = plant.alarms.list(false);
      best = std::min<std::chrono::nanoseconds>(best, std::chrono::steady_clock::now() - begin);
      EXPECT_EQ(views.size(), static_cast<std::size_t>(kMany));
      EXPECT_EQ(views.front().order, group.empty() ? 0u : static_cast<std::uint32_t>(kMany)) << "the newest first";
    }
    return best.count();
  };
  const auto without = list_ns("");
  EXPECT_LT(list_ns("G"), 10 * without + 5'000'000);
}

TEST(Alarms, ThatCanNeverBeRaisedAreLeftOutAndSaid) {
  const auto said = [](Definition wrong) {
    Plant plant({above("Good", "Total", 10), std::move(wrong)}, false);
    std::ostringstream lines;
    plant.diagnostics.render(lines);
    EXPECT_EQ(plant.alarms.count(), plant.diagnostics.all().empty() ? 2u : 1u);
    return lines.str();
  };
  const auto is = [](const char* variable, Comparison comparison, double limit) {
    Definition made = above("Wrong", variable, limit);
    made.comparison = comparison;
    return made;
  };
  EXPECT_EQ(said(is("Total", Comparison::kAbove, 2'147'483'646)), "");
  EXPECT_EQ(said(is("Total", Comparison::kEqual, -3)), "");
  EXPECT_EQ(said(is("Away", Comparison::kEqual, 1)), "");
  EXPECT_NE(said(is("Total", Comparison::kAbove, 2'147'483'647)).find("P7104"), std::string::npos);
  EXPECT_NE(said(is("Total", Comparison::kBelow, -2'147'483'648.0)).find("P7104"), std::string::npos);
  EXPECT_NE(said(is("Total", Comparison::kEqual, 1.5)).find("P7104"), std::string::npos);
  EXPECT_NE(said(is("Away", Comparison::kEqual, 2)).find("P7104"), std::string::npos);
  EXPECT_NE(said(is("Away", Comparison::kAbove, 0)).find("P7322"), std::string::npos);
  Definition suppressed = above("Wrong", "Total", 10);
  suppressed.suppress = "Total";
  EXPECT_NE(said(suppressed).find("\"Total\" has type DINT, \"suppress\" takes a BOOL"), std::string::npos);
}

TEST(Alarms, AreAsBeforeAfterARestart) {
  std::vector<Event> events;
  std::vector<Kept> states;
  {
    Plant plant({above("Total", "Total", 10)});
    plant.scans(20);
    ASSERT_EQ(plant.events(1).size(), 1u);
    plant.alarms.acknowledge({}, {"otto", "", 5, 0});
    plant.alarms.take(events, states);
    states[0].user = "otto";  // as the store has it
  }
  Plant again({above("Total", "Total", -10)});
  again.alarms.restore(states, 7);
  EXPECT_EQ(again.alarms.list(false).front().state, State::kAckedActive);
  EXPECT_EQ(again.alarms.list(false).front().user, "otto");
  again.scans(5);
  again.alarms.service(0, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(again.events(0).empty()) << "it holds all the time: nothing new";
  EXPECT_EQ(again.alarms.list(false).front().state, State::kAckedActive);
}

TEST(Alarms, AreSuppressedByThePlant) {
  Definition away;
  away.name = away.variable = "Away";
  Definition total = above("Total", "Total", 10);
  total.suppress = "Away";
  Plant plant({away, total});
  plant.scans(20);
  ASSERT_EQ(plant.events(1).size(), 1u);
  plant.write("Away", "1");
  plant.scans(1);
  const auto events = plant.events(2);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].what, Happened::kSuppressed) << "before what begins in the same scan";
  EXPECT_EQ(events[0].scan, 20u) << "what an HMI writes is there with the next scan";
  EXPECT_EQ(events[1].what, Happened::kRaised);
  for (const View& view : plant.alarms.list(false))
    EXPECT_EQ(view.state, view.definition.name == "Total" ? State::kSuppressed : State::kUnackedActive);
}

TEST(Alarms, WithoutRecordsAreThoseOfGlobals) {
  Plant plant({above("Count", "Main0.Count", 10), above("Total", "Total", 10), above("None", "Nothing", 1)}, false);
  EXPECT_EQ(plant.alarms.count(), 1u);
  ASSERT_EQ(plant.diagnostics.all().size(), 2u);
  EXPECT_EQ(plant.diagnostics.all()[0].code, core::Code::P7720);
  EXPECT_EQ(plant.diagnostics.all()[1].code, core::Code::P7101);
  EXPECT_FALSE(plant.alarms.needs_scans());
  plant.scans(20);
  plant.alarms.service(plant.now_ns, plant.now_ns);
  const auto events = plant.events(1);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].alarm, "Total");
  EXPECT_FALSE(events[0].scan) << "looked at between scans";
  EXPECT_EQ(events[0].value, 40);
}

TEST(Alarms, OfGlobalsGoOnWhenARecordingDoesNotStart) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word total = b.global("Total", dint, {}, {false, false, {}, {}, 0});
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word count = main.variable("Count", dint);
  main.variable("Flag", b.boolean());
  main.op(Opcode::kAdd32, {count, count, b.constant<std::int32_t>(TypeId::kDint, 1)});
  main.op(Opcode::kAdd32, {total, total, b.constant<std::int32_t>(TypeId::kDint, 2)});
  b.task("Fast", 10'000'000, {main.finish()});
  core::Diagnostics wrong;
  auto image = bytecode::verify(b.build(), wrong);
  ASSERT_TRUE(image);
  const auto resource = std::move(*runtime::Resource::load(std::move(*image)));
  core::Diagnostics diagnostics;
  Definition suppressed = above("Suppressed", "Total", 10);
  suppressed.suppress = "Main0.Flag";
  Alarms alarms(*resource, {above("Count", "Main0.Count", 10), suppressed, above("Total", "Total", 10)}, true,
                diagnostics);
  ASSERT_TRUE(diagnostics.all().empty());
  EXPECT_TRUE(alarms.needs_scans());
  EXPECT_EQ(alarms.do_without_scans(), (std::vector<std::string>{"Count", "Suppressed"}));
  EXPECT_FALSE(alarms.needs_scans());
  ASSERT_EQ(alarms.count(), 1u);
  for (core::TimeNs now_ns = 10'000'000; now_ns <= 200'000'000; now_ns += 10'000'000)
    ASSERT_FALSE(resource->program(0).execute({now_ns, 0, now_ns}));
  alarms.service(200'000'000, 200'000'000);
  std::vector<Event> events;
  std::vector<Kept> states;
  alarms.take(events, states);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].alarm, "Total");
  EXPECT_EQ(events[0].value, 40);
}

std::vector<Happened> kinds(const std::vector<Event>& events) {
  std::vector<Happened> all;
  for (const Event& event : events) all.push_back(event.what);
  return all;
}

TEST(Alarms, AreNotSeenWhenTheirSuppressionBeginsOrEndsWithThem) {
  for (const bool recorded : {true, false}) {
    Definition low = above("Low", "Total", 100);
    low.comparison = Comparison::kBelow;
    low.suppress = "Away";
    Plant plant({low}, recorded);
    const auto scans = [&](int count) {
      plant.scans(count);
      if (!recorded) plant.alarms.service(plant.now_ns, plant.now_ns);
    };
    plant.write("Away", "1");
    scans(1);
    EXPECT_EQ(kinds(plant.events(1)), (std::vector<Happened>{Happened::kSuppressed})) << recorded;
    scans(48);
    plant.write("Away", "0");
    scans(1);  // Total is 100
    EXPECT_EQ(kinds(plant.events(1)), (std::vector<Happened>{Happened::kUnsuppressed})) << recorded;
    EXPECT_EQ(plant.alarms.list(true).front().state, State::kNormal);
  }
}

TEST(Alarms, AreRaisedAfterARestartWhenTheyWereSuppressedBefore) {
  AlarmState before;
  before.condition(true, false);
  before.suppress(true);
  Plant again({above("Total", "Total", -10)});
  again.alarms.restore({{"Total", before.packed(), std::nullopt, 1}}, 7);
  EXPECT_TRUE(again.alarms.list(false).empty());
  again.scans(1);
  EXPECT_EQ(kinds(again.events(1)), (std::vector<Happened>{Happened::kRaised})) << "nobody has seen it";
}

/// Level is an input of both tasks; both write Copy.
bytecode::VerifiedImage two_speeds() {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word level = b.global("Level", dint, {}, {.input = true});
  const Word copy = b.global("Copy", dint);
  PouBuilder slow = b.pou("Slow", PouKind::kProgram);
  slow.op(Opcode::kMove32, {copy, level});
  b.task("Lazy", 50'000'000, {slow.finish()}, 1);
  PouBuilder fast = b.pou("Fast", PouKind::kProgram);
  fast.op(Opcode::kMove32, {copy, level});
  b.task("Quick", 10'000'000, {fast.finish()}, 0);
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  EXPECT_TRUE(image);
  return std::move(*image);
}

TEST(Alarms, OfAGlobalOfSeveralTasksAreThoseOfTheFastest) {
  Plant plant({above("Level", "Level", 0), above("Copy", "Copy", 0)}, true, two_speeds());
  ASSERT_EQ(plant.diagnostics.all().size(), 0u);
  // All of it is taken at once: replicas execute the scans of one task after those of the other.
  for (int round = 0; round < 4; ++round) {
    if (round == 2) plant.write("Level", "1");
    plant.scans(5, 1);
    plant.scans(1, 0);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  const auto events = plant.events(2);
  ASSERT_EQ(kinds(events), (std::vector<Happened>{Happened::kRaised, Happened::kRaised}));
  for (const Event& event : events) {
    EXPECT_EQ(event.task, "Quick");
    EXPECT_EQ(event.scan, 10u);
  }
}

TEST(Alarms, GoOnWithTheGlobalsOfATaskThatHasStopped) {
  Plant plant({above("Total", "Total", 10)});
  plant.scans(20);
  ASSERT_EQ(kinds(plant.events(1)), (std::vector<Happened>{Happened::kRaised}));
  const auto place = runtime::Access(*plant.resource).find("Total");
  ASSERT_TRUE(place);
  const std::int32_t safe = 0;
  const runtime::GlobalWrite value{place->offset, place->type, reinterpret_cast<const std::byte*>(&safe), nullptr};
  plant.resource->program(0).publish_safe({&value, 1});
  plant.resource->globals().task_stopped(0);
  plant.alarms.service(plant.now_ns, plant.now_ns);
  std::vector<Event> events = plant.events(0);
  EXPECT_TRUE(events.empty()) << "scans from before may still come";
  for (int turn = 0; turn < 1000 && events.empty(); ++turn) {
    plant.now_ns += 100'000'000;
    plant.alarms.service(plant.now_ns, plant.now_ns);
    std::vector<Kept> states;
    plant.alarms.take(events, states);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(kinds(events), (std::vector<Happened>{Happened::kReturned}));
  EXPECT_FALSE(events[0].scan);
  EXPECT_EQ(events[0].value, 0);
}

TEST(Alarms, DelaysAreThoseOfTheClockOfThePrograms) {
  Definition total = above("Total", "Total", 2);
  total.on_delay_ns = 3'000'000'000'000;
  Plant plant({total});
  runtime::RealtimeOptions options;
  options.realtime_priority = false;
  options.lock_memory = false;
  // A long time behind the clock of the machine, or ahead of it, as after a restart with values that were kept.
  const core::MonotonicClock clock;
  const core::TimeNs begin_ns = clock.now_ns() + 10'000'000'000'000;
  options.program_time_ns = begin_ns;
  runtime::RealtimeScheduler scheduler(*plant.resource, options);
  EXPECT_EQ(scheduler.program_ns(clock.now_ns()), begin_ns) << "it stands until the start";
  scheduler.start();
  while (scheduler.statistics(0).scans < 10) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  const core::TimeNs now_ns = clock.now_ns();
  EXPECT_GE(scheduler.program_ns(now_ns), begin_ns + 80'000'000);
  EXPECT_EQ(scheduler.program_ns(now_ns + 5) - scheduler.program_ns(now_ns), 5);
  scheduler.request_stop();
  scheduler.join();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto after = [&](core::TimeNs time_ns) { return scheduler.program_ns(clock.now_ns() + time_ns); };
  plant.alarms.service(after(0), 0);
  plant.alarms.service(after(2'990'000'000'000), 0);
  EXPECT_TRUE(plant.events(0).empty()) << "the delay still runs";
  plant.alarms.service(after(3'100'000'000'000), 0);
  EXPECT_EQ(plant.events(1).size(), 1u) << "also when no scan comes any more";
}

}  // namespace
}  // namespace plc::test
