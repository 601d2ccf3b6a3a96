// Scans of a recording, looked into: any scan as it was, which scans there are, why a BOOL has its value.
#include "shadow/past.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "runtime/sched/simulation.h"
#include "shadow/cause.h"
#include "shadow/shadow.h"
#include "tests/support/drawn_image.h"
#include "tests/support/golden.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using shadow::CauseLink;
using Kind = shadow::CauseLink::Kind;

/// A plant in virtual time, recorded; and what it left.
struct Recorded {
  explicit Recorded(bytecode::VerifiedImage image) {
    const std::vector<std::byte> bytes = bytecode::save(image.image());
    drawings = std::move(*bytecode::unpack(image.image().drawings));
    resource = std::move(*runtime::Resource::load(std::move(image)));
    shadow = std::move(
        *shadow::Shadow::start(*resource, {}, {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytes}));
    simulation.emplace(*resource);
  }
  void scans(std::uint64_t count) { simulation->run_cycles(count); }
  std::unique_ptr<shadow::Past> past() {
    std::uint64_t all = 0;
    for (std::uint32_t task = 0; task < resource->task_count(); ++task) all += simulation->scans(task);
    for (int turn = 0; turn < 2000 && shadow->counts().scans != all; ++turn)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    auto opened = shadow::Past::open(shadow->recording(), {});
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(*opened);
  }
  std::uint32_t pou(const std::string& name) const {
    std::uint32_t p = 0;
    while (resource->image().pous[p].name != name) ++p;
    return p;
  }
  shadow::PouInstance instance(std::uint32_t task, const std::string& name) {
    return shadow::instances_of(resource->program(task), pou(name)).at(0);
  }

  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<shadow::Shadow> shadow;
  std::optional<runtime::Simulation> simulation;
  bytecode::Drawings drawings;
};

bytecode::VerifiedImage tank() { return drawn_image((source_root() / "examples/tank/tank.xml").string()); }

TEST(Past, AnyScanIsAsItWas) {
  Recorded r(drawn_text(R"(PROGRAM Main
VAR n : DINT; END_VAR
n := n + 1;
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)"));
  // More than one block.
  constexpr std::uint64_t kScans = 3000;
  r.scans(kScans);
  const auto past = r.past();
  ASSERT_TRUE(past->scans(0));
  EXPECT_EQ(past->scans(0)->first, 0u);
  EXPECT_EQ(past->scans(0)->last, kScans - 1);
  EXPECT_EQ(past->nearest(0, kScans + 5), kScans - 1);
  EXPECT_EQ(past->scan_at(0, 0), 0u);
  EXPECT_EQ(past->scan_at(0, 12'345'678'901), 1234u);
  EXPECT_FALSE(past->nearest(1, 0)) << "no such task";
  const shadow::PouInstance main = r.instance(0, "Main");
  const auto n_at = [&](std::uint64_t scan) {
    std::string text;
    EXPECT_TRUE(past->look(0, scan, {&main.view, 1}, [&](const runtime::RecordHead& head) {
      EXPECT_EQ(head.scan, scan);
      const shadow::ProbeView view(past->resource().program(0), main.view);
      text = view.text(bytecode::DrawnKey{0, -1, 3, 1, 0, bytecode::DrawnSide::kOutput});
    }));
    return text;
  };
  std::mt19937 random(7);
  for (const std::uint64_t scan : {std::uint64_t{0}, kScans - 1, std::uint64_t{1}, std::uint64_t{2}, kScans / 2})
    EXPECT_EQ(n_at(scan), std::to_string(scan + 1));
  for (int i = 0; i < 20; ++i) {
    const std::uint64_t scan = random() % (kScans - 1);
    EXPECT_EQ(n_at(scan), std::to_string(scan + 1));
    EXPECT_EQ(n_at(scan + 1), std::to_string(scan + 2)) << "one forward";
  }
  EXPECT_FALSE(past->look(0, kScans, {&main.view, 1}, [](const runtime::RecordHead&) {}));
}

std::string words(const std::vector<CauseLink>& links) {
  constexpr const char* kKinds[] = {"asked",   "wrote",   "contact",  "block", "rail",
                                    "not run", "outside", "as begun", "seen",  "too far"};
  std::string text;
  for (const CauseLink& link : links) {
    text += std::string(kKinds[static_cast<std::size_t>(link.kind)]) + " " + link.variable + " " +
            (link.value ? "TRUE" : "FALSE") + " @" + std::to_string(link.scan);
    if (link.placed) text += " " + link.body->name;
    text += "\n";
  }
  return text;
}

std::vector<CauseLink> why(Recorded& r, shadow::Past& past, const std::string& pou, const std::string& name,
                           std::uint64_t scan, std::uint32_t task = 0) {
  return shadow::cause_of(past, r.drawings, task, scan, r.instance(task, pou), name, std::chrono::minutes(5));
}

TEST(Cause, GoesBackToTheContactThatOpened) {
  Recorded r(tank());
  const auto image = [&](const char* path, const char* value) { set(*r.resource, path, value); };
  image("EmergencyOk", "1");
  r.scans(10);
  image("StartButton", "1");
  r.scans(3);
  image("StartButton", "0");
  r.scans(40);
  image("StopButton", "1");
  r.scans(30);
  const auto past = r.past();
  const std::uint64_t last = past->scans(0)->last;
  const std::vector<CauseLink> links = why(r, *past, "Station", "ValveA", last);
  ASSERT_GE(links.size(), 5u) << words(links);
  const std::string scan = " @" + std::to_string(links[1].scan);
  EXPECT_EQ(words(links), "asked ValveA FALSE @" + std::to_string(last) + "\nwrote ValveA FALSE" + scan +
                              " Station\ncontact Running FALSE" + scan + " Station\nwrote Running FALSE" + scan +
                              " Station\ncontact StopButton TRUE" + scan + " Station\noutside StopButton TRUE" + scan +
                              "\n");
  // The scan in which the button came: after 53 instants.
  EXPECT_GE(links[1].now_ns, 53 * 20'000'000 - 100'000'000);
  // While it ran: by the start button, two scans before its release.
  const auto running = why(r, *past, "Station", "Running", links[1].scan - 5);
  ASSERT_GE(running.size(), 4u) << words(running);
  EXPECT_EQ(running[0].value, true);
  EXPECT_EQ(running[2].variable, "StartButton") << words(running);
  EXPECT_EQ(running[3].kind, Kind::kOutside) << words(running);
  EXPECT_TRUE(why(r, *past, "Station", "Level", last).empty()) << "no BOOL";
  EXPECT_TRUE(why(r, *past, "Station", "Nothing", last).empty());
  const std::atomic<bool> ending{true};
  const auto given_up = shadow::cause_of(*past, r.drawings, 0, last, r.instance(0, "Station"), "ValveA",
                                         std::chrono::minutes(5), &ending);
  ASSERT_EQ(given_up.size(), 2u) << words(given_up);
  EXPECT_EQ(given_up[1].kind, Kind::kTooFar);
}

TEST(Cause, GoesAcrossPousAndTasks) {
  Recorded r(tank());
  set(*r.resource, "EmergencyOk", "1");
  r.scans(10);
  set(*r.resource, "StartButton", "1");
  r.scans(50);
  set(*r.resource, "StartButton", "0");
  r.scans(50);
  set(*r.resource, "StopButton", "1");
  r.scans(50);
  const auto past = r.past();
  // The slow task writes LampRunning in Signals, the fast one Running in Station.
  const std::vector<CauseLink> links = why(r, *past, "Signals", "LampRunning", past->scans(1)->last, 1);
  ASSERT_EQ(links.size(), 6u) << words(links);
  EXPECT_EQ(links[1].body->name, "Signals") << words(links);
  EXPECT_EQ(links[1].task, 1u);
  EXPECT_EQ(links[2].variable, "Running") << words(links);
  EXPECT_EQ(links[3].body->name, "Station") << words(links);
  EXPECT_EQ(links[3].task, 0u);
  EXPECT_EQ(links[5].variable, "StopButton") << words(links);
}

TEST(Cause, GoesIntoBlocksOfTheProject) {
  Recorded r(tank());
  set(*r.resource, "EmergencyOk", "1");
  r.scans(10);
  set(*r.resource, "StartButton", "1");
  r.scans(5);
  set(*r.resource, "StartButton", "0");
  r.scans(5);
  set(*r.resource, "LevelRaw", "27648");
  r.scans(200);
  const auto past = r.past();
  const std::vector<CauseLink> links = why(r, *past, "Station", "Running", past->scans(0)->last);
  std::vector<std::string> pous;
  for (const CauseLink& link : links) {
    if (link.placed && (pous.empty() || pous.back() != link.body->name)) pous.push_back(link.body->name);
  }
  EXPECT_EQ(pous, (std::vector<std::string>{"Station", "Measure", "HighAlarm"})) << words(links);
}

TEST(Cause, OfWhatNeverChangedIsAsOldAsTheRecording) {
  Recorded r(tank());
  r.scans(50);
  const auto past = r.past();
  const auto links = why(r, *past, "Station", "Running", past->scans(0)->last);
  ASSERT_GE(links.size(), 2u);
  EXPECT_EQ(links[1].kind, Kind::kAsBegun) << words(links);
}

TEST(Cause, OfALatchIsTheCoilThatResetIt) {
  Recorded r(tank());
  set(*r.resource, "EmergencyOk", "1");
  set(*r.resource, "StartButton", "1");
  r.scans(5);
  set(*r.resource, "EmergencyOk", "0");
  r.scans(20);
  const auto past = r.past();
  const auto links = why(r, *past, "Station", "StepA", past->scans(0)->last);
  ASSERT_GE(links.size(), 3u) << words(links);
  EXPECT_EQ(links[1].kind, Kind::kWrote);
  const bytecode::DrawnElement& coil = links[1].body->elements[links[1].element];
  EXPECT_EQ(coil.modifiers.storage, bytecode::DrawnStorage::kReset) << words(links);
  EXPECT_EQ(links[2].variable, "EmergencyOk") << words(links);
}

}  // namespace
}  // namespace plc::test
