// Forces, recorded scans, traces and variables of tasks, as clients have them.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "engineering/kept_forces.h"
#include "engineering/shadow_values.h"
#include "engineering/state_files.h"
#include "shadow/player.h"
#include "tests/unit/engineering/rig.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

HttpResponse force(EngineeringRig& rig, const Json& wanted, const std::string& role = "engineer") {
  return rig.post("/api/forces/set", wanted, role);
}
Json list(EngineeringRig& rig) { return body_of(rig.get("/api/forces"))["forces"]; }

TEST(Forces, AreSetListedAndReleased) {
  EngineeringRig rig;
  const HttpResponse set = force(rig, {{"path", "Total"}, {"value", 500}, {"reason", "trial"}, {"seconds", 60}});
  ASSERT_EQ(set.status, 200) << set.body;
  const Json made = body_of(set)["force"];
  EXPECT_EQ(made["path"], "Total");
  EXPECT_EQ(made["value"], "500");
  EXPECT_EQ(made["owner"], "engineer");
  EXPECT_EQ(made["since"], "2027-01-15T08:00:00.000Z");
  EXPECT_EQ(made["until"], "2027-01-15T08:01:00.000Z");
  EXPECT_EQ(made["yields"], true) << "its task writes it";
  rig.scan();
  rig.scan();
  EXPECT_EQ(value_of(*rig.resource, "Total"), "500");
  EXPECT_EQ(list(rig).size(), 1u);
  EXPECT_EQ(force(rig, {{"path", "Start"}, {"value", true}, {"reason", "trial"}}).status, 200);
  EXPECT_EQ(force(rig, {{"path", "Main0.Count"}, {"value", 7}, {"reason", "trial"}}).status, 200);
  EXPECT_EQ(force(rig, {{"path", "Lamp"}, {"value", "Green"}, {"reason", "trial"}}).status, 200);
  EXPECT_EQ(list(rig).size(), 4u);
  EXPECT_EQ(list(rig)[1]["value"], "TRUE");
  EXPECT_EQ(list(rig)[3]["value"], "Green");
  rig.scan();
  EXPECT_EQ(value_of(*rig.resource, "Main0.Count"), "7");
  EXPECT_EQ(value_of(*rig.resource, "Lamp"), "1");
  // An HMI may not write it meanwhile.
  const HttpResponse refused = rig.post("/api/values/write", {{"values", {{{"path", "Start"}, {"value", false}}}}});
  EXPECT_EQ(refused.status, 409) << refused.body;
  EXPECT_EQ(body_of(rig.post("/api/forces/release", {{"path", "total"}}, "engineer"))["released"], 1);
  EXPECT_EQ(body_of(rig.post("/api/forces/release", Json::object(), "engineer"))["released"], 3);
  rig.scan();
  EXPECT_EQ(value_of(*rig.resource, "Total"), "501");
  const std::vector<std::string> changes = rig.forces.take_changes();
  ASSERT_EQ(changes.size(), 8u);
  EXPECT_EQ(changes.front(), "forced Total to 500 by engineer: trial");
  EXPECT_EQ(changes.back(), "Lamp is released by engineer");
}

TEST(Forces, AreForEngineersWithAReason) {
  EngineeringRig rig;
  const Json wanted = {{"path", "Total"}, {"value", 1}, {"reason", "trial"}};
  EXPECT_EQ(force(rig, wanted, "operator").status, 403);
  EXPECT_EQ(force(rig, {{"path", "Total"}, {"value", 1}}).status, 400);
  EXPECT_EQ(force(rig, {{"path", "Total"}, {"value", 1}, {"reason", ""}}).status, 400);
  EXPECT_EQ(rig.post("/api/forces/release", Json::object(), "operator").status, 403);
  const auto refusal = [&](const std::string& path, const Json& value) {
    const HttpResponse response = force(rig, {{"path", path}, {"value", value}, {"reason", "trial"}});
    const Json body = body_of(response);
    return body.value("code", "") + " " + body.value("field", "");
  };
  EXPECT_EQ(refusal("Totl", 1), "P7101 path");
  EXPECT_EQ(refusal("Points", 1), "P7102 path");
  EXPECT_EQ(refusal("Percent", 101), "P7104 value");
  EXPECT_EQ(refusal("Total", "much"), "P7103 value");
  EXPECT_EQ(refusal("Fixed", 1), "P7106 value");
  EXPECT_TRUE(list(rig).empty());
}

TEST(KeptForces, HoldAfterAWarmStartWhenAsked) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("engineering");
  ASSERT_EQ(engineering::make_private_folder(folder), "");
  const std::pair<const char*, Json> wanted[] = {
      {"Start", true},       {"Level", 1.5},      {"Large", "18446744073709551615"},
      {"Long", "-5"},        {"Small", -128},     {"Text", "it's $1"},
      {"Wide", "w\u00e4rm"}, {"Wait", "T#1s5ms"}, {"Day", "D#2024-02-29"},
      {"Lamp", "Blue"},      {"Points[2].Y", 7},  {"Main0.Count", 9}};
  std::map<std::string, std::string> values;
  {
    EngineeringRig rig;
    EXPECT_EQ(body_of(force(rig, {{"path", "Start"}, {"value", true}, {"reason", "trial"}, {"warm", true}}))["code"],
              "P7701")
        << "without a folder";
    engineering::KeptForces kept(folder, rig.forces);
    rig.context.kept_forces = &kept;
    for (const auto& [path, value] : wanted) {
      const HttpResponse set = force(rig, {{"path", path}, {"value", value}, {"reason", "trial"}, {"warm", true}});
      ASSERT_EQ(set.status, 200) << path << set.body;
      EXPECT_EQ(body_of(set)["force"]["warm"], true);
    }
    EXPECT_EQ(force(rig, {{"path", "Total"}, {"value", 1}, {"reason", "not over a start"}}).status, 200);
    EXPECT_EQ(
        force(rig, {{"path", "Percent"}, {"value", 1}, {"reason", "short"}, {"warm", true}, {"seconds", 1}}).status,
        200);
    EXPECT_EQ(force(rig, {{"path", "Deep"}, {"value", 1}, {"reason", "released"}, {"warm", true}}).status, 200);
    EXPECT_EQ(rig.post("/api/forces/release", {{"path", "Deep"}}, "engineer").status, 200);
    for (const Json& one : list(rig)) values[one["path"]] = one["value"];
  }
  EngineeringRig rig;
  EXPECT_EQ(engineering::force_again(folder, rig.calendar.utc_ns() + 2'000'000'000, 0, rig.forces),
            std::vector<std::string>());
  const Json all = list(rig);
  ASSERT_EQ(all.size(), std::size(wanted)) << all;
  for (const Json& one : all) {
    EXPECT_EQ(one["value"], values[one["path"]]) << one;
    EXPECT_EQ(one["owner"], "engineer");
    EXPECT_EQ(one["reason"], "trial");
    EXPECT_EQ(one["since"], "2027-01-15T08:00:00.000Z") << "since it was forced, not since the start";
  }
  // A program that has the variable no more says so.
  EXPECT_EQ(engineering::store_kept_forces(folder, {{"Gone", "1", "anna", "trial", 0, {}, true}}), "");
  EXPECT_EQ(engineering::force_again(folder, 0, 0, rig.forces).size(), 1u);
  EXPECT_EQ(engineering::ended_by_start(folder),
            std::vector<std::string>{"Gone is not forced any more: it was a cold start"});
  EXPECT_EQ(engineering::store_kept_forces(folder, {}), "");
  EngineeringRig cold;
  EXPECT_TRUE(engineering::force_again(folder, 0, 0, cold.forces).empty());
  EXPECT_EQ(cold.forces.size(), 0u);
}

TEST(Forces, OfAProgramOnTrialAreKeptOnceItStays) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("");
  EngineeringRig rig;
  engineering::KeptForces kept(folder, rig.forces);
  rig.context.kept_forces = &kept;
  const auto on_the_disk = [&folder] {
    EngineeringRig next;
    EXPECT_TRUE(engineering::force_again(folder, 0, 0, next.forces).empty());
    std::vector<std::string> paths;
    for (const runtime::Force& force : next.forces.list()) paths.push_back(force.path);
    return paths;
  };
  const auto set = [&rig](const char* path) {
    EXPECT_EQ(force(rig, {{"path", path}, {"value", 1}, {"reason", "valve is changed"}, {"warm", true}}).status, 200);
  };
  set("Total");
  ASSERT_EQ(on_the_disk(), std::vector<std::string>{"Total"});
  kept.hold();
  set("Percent");
  EXPECT_EQ(rig.post("/api/forces/release", {{"path", "Total"}}, "engineer").status, 200);
  EXPECT_FALSE(kept.is_due()) << "on trial";
  EXPECT_EQ(on_the_disk(), std::vector<std::string>{"Total"}) << "those of the program before";
  kept.release();
  ASSERT_TRUE(kept.is_due());
  EXPECT_EQ(kept.store(), "");
  EXPECT_FALSE(kept.is_due());
  EXPECT_EQ(on_the_disk(), std::vector<std::string>{"Percent"});
}

TEST(KeptForces, AreDueUntilTheDiskTakesThem) {
  const ScratchFolder scratch;
  EngineeringRig rig;
  engineering::KeptForces kept(scratch.file("none/there"), rig.forces);
  ASSERT_TRUE(rig.forces.set({"Total", "1", "anna", "trial", 0, {}, true}));
  EXPECT_NE(kept.store(), "");
  EXPECT_TRUE(kept.is_due());
  std::filesystem::create_directories(scratch.file("none/there"));
  EXPECT_EQ(kept.store(), "");
  EXPECT_FALSE(kept.is_due());
}

TEST(Forces, EndByAClockThatNobodySets) {
  EngineeringRig rig;
  ASSERT_EQ(force(rig, {{"path", "Total"}, {"value", 1}, {"reason", "trial"}, {"seconds", 60}}).status, 200);
  constexpr core::TimeNs kHourNs = 3'600'000'000'000, kSecondNs = 1'000'000'000;
  rig.calendar.now_ns += kHourNs;
  EXPECT_TRUE(rig.forces.expire(rig.clock.now_ns() + 59 * kSecondNs).empty());
  rig.calendar.now_ns -= 2 * kHourNs;
  EXPECT_EQ(rig.forces.expire(rig.clock.now_ns() + 60 * kSecondNs).size(), 1u);
}

TEST(KeptForces, HoldForTheRestOfTheirTime) {
  const ScratchFolder scratch;
  constexpr core::TimeNs kSecondNs = 1'000'000'000, kSetNs = 1'800'000'000 * kSecondNs, kNowNs = 7 * kSecondNs;
  const auto rest_at = [&](core::TimeNs utc_ns) {
    EngineeringRig rig;
    EXPECT_EQ(engineering::store_kept_forces(scratch.file(""),
                                             {{"Total", "1", "anna", "trial", kSetNs, kSetNs + 60 * kSecondNs, true}}),
              "");
    EXPECT_TRUE(engineering::force_again(scratch.file(""), utc_ns, kNowNs, rig.forces).empty());
    const auto all = rig.forces.list();
    return all.empty() ? core::TimeNs{0} : all[0].until_mono_ns.value_or(0) - kNowNs;
  };
  EXPECT_EQ(rest_at(kSetNs + 20 * kSecondNs), 40 * kSecondNs);
  EXPECT_EQ(rest_at(kSetNs + 60 * kSecondNs), 0) << "it is over";
  EXPECT_EQ(rest_at(kSetNs - 3600 * kSecondNs), 60 * kSecondNs) << "UTC was set back";
}

/// A plant whose scans are recorded.
struct Recorded {
  Recorded() : values(rig.resource->globals()) {
    auto started = shadow::Shadow::start(
        *rig.resource, {},
        {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(rig.resource->image())});
    EXPECT_TRUE(started) << started.error().message;
    shadow = std::move(*started);
    rig.context.shadow = shadow.get();
  }
  EngineeringRig rig;
  std::unique_ptr<shadow::Shadow> shadow;
  engineering::ShadowValues values;  // looks at the shadow, which goes after it
};

TEST(RecordedScans, CanBeHadAsATraceChosenAfterwards) {
  Recorded r;
  for (int i = 0; i < 200; ++i) r.rig.scan();
  for (int turn = 0; turn < 1000 && r.shadow->counts().scans < 200; ++turn)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Json status = body_of(r.rig.get("/api/recording"));
  EXPECT_EQ(status["scans"], 200) << status;
  EXPECT_EQ(status["left_out"], 0);
  const HttpResponse trace =
      r.rig.post("/api/trace", {{"paths", {"Main0.Count", "Total"}}, {"seconds", 0.02}}, "viewer");
  ASSERT_EQ(trace.status, 200) << trace.body;
  EXPECT_EQ(trace.body, "scan,time_ms,Main0.Count,Total\n197,0,198,198\n198,10,199,199\n199,20,200,200\n");
  const HttpResponse around = r.rig.post("/api/trace",
                                         {{"paths", {"Total"}},
                                          {"seconds", 60},
                                          {"trigger", "Main0.Count"},
                                          {"level", 100},
                                          {"before", 0.01},
                                          {"after", 0}},
                                         "viewer");
  EXPECT_EQ(around.body, "scan,time_ms,Total\n98,-10,99\n99,0,100\n") << around.status;
  // For ever is a time, too.
  const HttpResponse all = r.rig.post("/api/trace",
                                      {{"paths", {"Total"}},
                                       {"seconds", 1e300},
                                       {"trigger", "Main0.Count"},
                                       {"level", 100},
                                       {"before", 1e300},
                                       {"after", 1e300}},
                                      "viewer");
  EXPECT_EQ(std::count(all.body.begin(), all.body.end(), '\n'), 201) << all.body.substr(0, 200);
  EXPECT_EQ(all.file_name, "trace.csv");
  EXPECT_EQ(r.rig.post("/api/trace", {{"paths", {"Nothing"}}}, "viewer").status, 404);
  EXPECT_EQ(r.rig.post("/api/trace", {{"paths", {"Total"}}, {"task", "None"}}, "viewer").status, 404);
  // The recording itself has the program: not for viewers.
  EXPECT_EQ(r.rig.get("/api/recording/download").status, 403);
  const HttpResponse file = r.rig.get("/api/recording/download", "engineer");
  ASSERT_EQ(file.status, 200);
  const auto bytes = std::as_bytes(std::span(file.body));
  EXPECT_TRUE(shadow::RecordFile::read({bytes.begin(), bytes.end()}, "download"));
}

TEST(RecordedScans, GiveNewValuesOfTasksAlsoAfterNobodyHasAsked) {
  Recorded r;
  r.values.attach(*r.shadow);
  const auto place = runtime::Access(*r.rig.resource).find("Main0.Count");
  ASSERT_TRUE(place);
  const auto count = [&] {
    std::int32_t value = -1;
    r.values.take();
    r.values.read(place->task, place->offset, sizeof value, reinterpret_cast<std::byte*>(&value));
    return value;
  };
  for (int i = 0; i < 10; ++i) r.rig.scan();
  EXPECT_EQ(count(), 10);
  // A page of globals alone is open for long: the replicas rest.
  for (int i = 0; i < 300; ++i) r.values.take();
  for (int i = 0; i < 50; ++i) r.rig.scan();
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  EXPECT_EQ(count(), 60);
}

TEST(RecordedScans, AreTheFinestHistory) {
  Recorded r;
  r.rig.calendar.now_ns = 1'800'000'000'000'000'000;
  for (int i = 0; i < 200; ++i) {
    r.rig.calendar.now_ns += 10'000'000;
    r.rig.scan();
  }
  for (int turn = 0; turn < 1000 && r.shadow->counts().scans < 200; ++turn)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto ask = [&](double from, double to, Json tags) {
    return body_of(r.rig.post("/api/history/scans", {{"tags", std::move(tags)}, {"from", from}, {"to", to}}, "viewer"));
  };
  const Json some = ask(1'800'000'001.0, 1'800'000'001.025, {"Main0.Count", "Total"});
  ASSERT_EQ(some["scans"].size(), 3u) << some;
  EXPECT_EQ(some["whole"], true);
  EXPECT_EQ(some["scans"][0]["scan"], 99) << "the hundredth scan is that of 1 s";
  EXPECT_EQ(some["scans"][0]["values"], Json({100.0, 100.0}));
  EXPECT_NEAR(some["scans"][2]["time"].get<double>(), 1'800'000'001.02, 1e-6);
  EXPECT_EQ(ask(1'799'999'000.0, 1'800'000'000.05, {"Total"})["whole"], false) << "it begins later";
  EXPECT_EQ(ask(0, 9e9, {"Nothing"})["code"], "P7101");
  EXPECT_EQ(ask(0, 9e9, {"Text"})["code"], "P7102");
}

TEST(RecordedScans, GiveVariablesOfTasks) {
  Recorded r;
  r.values.attach(*r.shadow);
  for (int i = 0; i < 50; ++i) r.rig.scan();
  const runtime::Access access(*r.rig.resource);
  const auto place = access.find("Main0.Count");
  ASSERT_TRUE(place);
  EXPECT_TRUE(r.values.knows(place->task));
  std::int32_t count = 0;
  for (int turn = 0; turn < 1000 && count != 50; ++turn) {
    r.values.take();
    r.values.read(place->task, place->offset, sizeof count, reinterpret_cast<std::byte*>(&count));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(count, 50);
  const auto total = access.find("Total");
  r.values.read(runtime::Place::kGlobal, total->offset, sizeof count, reinterpret_cast<std::byte*>(&count));
  EXPECT_EQ(count, 50);
  r.values.detach();
  EXPECT_FALSE(r.values.knows(place->task));
}

TEST(RecordedScans, WithoutARecordingTheCallsSaySo) {
  EngineeringRig rig;
  EXPECT_EQ(body_of(rig.get("/api/recording"))["on"], false);
  EXPECT_EQ(body_of(rig.post("/api/trace", {{"paths", {"Total"}}}, "viewer"))["code"], "P7720");
}

}  // namespace
}  // namespace plc::test
