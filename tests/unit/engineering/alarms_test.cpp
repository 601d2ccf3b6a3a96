// Alarms and values of the past, as clients have them: rights, fields, the audit.
#include "alarms/alarms.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

#include "alarms/alarm_store.h"
#include "engineering/validate.h"
#include "historian/historian.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

/// A rig with an alarm on Total, which goes up by one with each scan.
struct AlarmRig {
  AlarmRig() {
    alarms::Definition high;
    high.name = "High";
    high.variable = "Total";
    high.comparison = alarms::Comparison::kAbove;
    high.limit = 4;
    high.text = "Total is too high";
    core::Diagnostics diagnostics;
    alarms = std::make_unique<alarms::Alarms>(*rig.resource, std::vector{high}, false, diagnostics);
    EXPECT_EQ(diagnostics.error_count(), 0u);
    std::vector<std::string> said;
    store = std::make_unique<alarms::AlarmStore>("", said);
    store->start();
    rig.context.alarms = alarms.get();
    rig.context.alarm_store = store.get();
  }
  void scans(int count) {
    for (int i = 0; i < count; ++i) rig.scan();
    alarms->service(rig.clock.now_ns(), rig.calendar.now_ns);
  }
  Json list(const std::string& query = "") { return body_of(rig.get("/api/alarms" + query)); }

  EngineeringRig rig;
  std::unique_ptr<alarms::Alarms> alarms;
  std::unique_ptr<alarms::AlarmStore> store;
};

/// The row of a call, and its example with other fields.
const engineering::Call& row(const char* path) { return *engineering::find_call(path); }
Json example(const char* path, const Json& changes) {
  Json fields = Json::parse(row(path).example);
  for (const auto& [name, value] : changes.items()) {
    if (value.is_null())
      fields.erase(name);
    else
      fields[name] = value;
  }
  return fields;
}
/// A refusal as "400 P7714 field".
std::string refusal_of(const HttpResponse& response) {
  const Json body = body_of(response);
  return std::to_string(response.status) + " " + body.value("code", "") + " " + body.value("field", "");
}
void expect_as_row_says(const HttpResponse& response, const char* path) {
  ASSERT_EQ(response.status, 200) << response.body;
  const auto wrong = engineering::wrong_fields(body_of(response), row(path).response);
  EXPECT_FALSE(wrong) << wrong->field << " " << wrong->text << "\n" << response.body;
}

TEST(AlarmCalls, ShelveAnswersAndRefusesAsItsRowSays) {
  constexpr const char* kPath = "/api/alarms/shelve";
  AlarmRig r;
  r.scans(5);
  const auto refused = [&](const Json& changes, const std::string& role = "operator") {
    return refusal_of(r.rig.post(kPath, example(kPath, changes), role));
  };
  EXPECT_EQ(refused({}, ""), "401 P7710 ");
  EXPECT_EQ(refused({}, "viewer"), "403 P7711 ");
  for (const char* const field : {"name", "seconds", "reason"}) {
    EXPECT_EQ(refused({{field, nullptr}}), std::string("400 P7714 ") + field) << "is missing";
    EXPECT_EQ(refused({{field, Json::array()}}), std::string("400 P7714 ") + field);
  }
  EXPECT_EQ(refused({{"name", ""}}), "400 P7714 name");
  EXPECT_EQ(refused({{"name", std::string(1001, 'n')}}), "400 P7714 name");
  for (const Json& seconds : {Json(0), Json(-1), Json(1.5), Json("60"), Json(INT64_MAX)})
    EXPECT_EQ(refused({{"seconds", seconds}}), "400 P7714 seconds") << seconds;
  EXPECT_EQ(refused({{"reason", std::string(501, 'r')}}), "400 P7714 reason");
  EXPECT_EQ(refused({{"until", "tomorrow"}}), "400 P7714 until");
  EXPECT_EQ(refused({{"name", "None"}}), "404 P7101 name");
  EXPECT_EQ(r.list()["hidden"], 0) << "nothing was shelved";
  expect_as_row_says(r.rig.post(kPath, example(kPath, {{"name", "High"}})), kPath);
  EXPECT_EQ(r.list()["hidden"], 1);
}

TEST(AlarmCalls, ListAcknowledgeAndShelve) {
  AlarmRig r;
  r.scans(4);
  EXPECT_EQ(r.list()["alarms"].size(), 0u);
  EXPECT_EQ(r.list()["all"], 1);
  EXPECT_EQ(r.list("?all=true")["alarms"][0]["state"], "normal");
  r.scans(1);
  const Json now = r.list();
  ASSERT_EQ(now["alarms"].size(), 1u) << now;
  EXPECT_EQ(now["unacked"], 1);
  EXPECT_EQ(now["newest"]["name"], "High");
  EXPECT_EQ(now["alarms"][0]["value"], 5.0);
  EXPECT_EQ(now["alarms"][0]["since"], "2027-01-15T08:00:00.000Z");
  EXPECT_FALSE(now["alarms"][0].contains("scan")) << "looked at between scans";
  EXPECT_EQ(r.list("?most=0")["alarms"].size(), 0u);
  // Who may what.
  EXPECT_EQ(r.rig.post("/api/alarms/ack", Json::object(), "viewer").status, 403);
  EXPECT_EQ(r.rig.post("/api/alarms/service", {{"name", "High"}, {"out", true}, {"reason", "x"}}, "operator").status,
            403);
  EXPECT_EQ(body_of(r.rig.post("/api/alarms/ack", {{"names", {"High", "None"}}}))["field"], "names[1]");
  EXPECT_EQ(body_of(r.rig.post("/api/alarms/ack", {{"names", Json::array()}}))["acknowledged"], 0);
  EXPECT_EQ(body_of(r.rig.post("/api/alarms/ack", {{"names", {"high"}}, {"comment", "seen"}}))["acknowledged"], 1);
  EXPECT_EQ(r.list()["alarms"][0]["state"], "acked active");
  EXPECT_EQ(r.list()["alarms"][0]["user"], "operator");
  EXPECT_FALSE(r.list().contains("newest"));
  EXPECT_EQ(r.rig.post("/api/alarms/shelve", {{"name", "High"}, {"seconds", 0}, {"reason", "x"}}).status, 400);
  EXPECT_EQ(r.rig.post("/api/alarms/shelve", {{"name", "High"}, {"seconds", 60}, {"reason", ""}}).status, 400);
  const Json shelved =
      body_of(r.rig.post("/api/alarms/shelve", {{"name", "High"}, {"seconds", 60}, {"reason", "trial"}}));
  EXPECT_EQ(shelved["until"], "2027-01-15T08:01:00.000Z") << shelved;
  EXPECT_EQ(r.list()["hidden"], 1);
  EXPECT_EQ(r.rig.post("/api/alarms/unshelve", {{"name", "High"}}).status, 200);
  EXPECT_EQ(r.list()["alarms"][0]["state"], "unacked active");
  EXPECT_EQ(r.rig.post("/api/alarms/service", {{"name", "High"}, {"out", true}, {"reason", "x"}}, "engineer").status,
            200);
  EXPECT_EQ(r.list()["alarms"][0]["state"], "out of service");
  std::string audit;
  for (const std::string& record : r.rig.audit.recent(10))
    audit += Json::parse(record)["what"].get<std::string>() + " ";
  EXPECT_EQ(audit, "alarms.ack alarms.shelve alarms.unshelve alarms.service ");
}

TEST(AlarmCalls, HaveAHistory) {
  AlarmRig r;
  r.scans(5);
  r.rig.post("/api/alarms/ack", {{"comment", "seen"}});
  std::vector<alarms::Event> events;
  std::vector<alarms::Kept> states;
  r.alarms->take(events, states);
  r.store->add(std::move(events), std::move(states));
  r.store->stop();
  const Json history = body_of(r.rig.get("/api/alarms/history"))["events"];
  ASSERT_EQ(history.size(), 2u) << history;
  EXPECT_EQ(history[0]["what"], "acknowledged");
  EXPECT_EQ(history[0]["user"], "operator");
  EXPECT_EQ(history[0]["comment"], "seen");
  EXPECT_EQ(history[1]["what"], "raised");
  EXPECT_EQ(history[1]["value"], 5.0);
  EXPECT_EQ(body_of(r.rig.get("/api/alarms/history?before=2"))["events"].size(), 1u);
  EXPECT_EQ(body_of(r.rig.get("/api/alarms/history?name=None"))["events"].size(), 0u);
  EXPECT_EQ(body_of(r.rig.get("/api/alarms/history?from=1900000000"))["events"].size(), 0u);
}

TEST(AlarmCalls, WithoutAlarmsAreEmpty) {
  EngineeringRig rig;
  EXPECT_EQ(body_of(rig.get("/api/alarms"))["all"], 0);
  EXPECT_EQ(body_of(rig.get("/api/alarms/history"))["events"].size(), 0u);
  EXPECT_EQ(rig.post("/api/alarms/ack", Json::object()).status, 200);
  EXPECT_EQ(rig.post("/api/alarms/shelve", {{"name", "High"}, {"seconds", 60}, {"reason", "trial"}}).status, 404);
}

TEST(HistoryCalls, TellWhatWasSampled) {
  namespace fs = std::filesystem;
  std::string folder = fs::temp_directory_path() / "history-XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  EngineeringRig rig;
  EXPECT_EQ(rig.get("/api/history?tag=Total&from=0&to=9000000000").status, 404) << "nothing is kept";
  EXPECT_EQ(body_of(rig.get("/api/history/tags"))["interval_ms"], 0);
  historian::Settings settings;
  settings.tags = {"Total", "Nothing", "Main0.Count"};
  settings.interval_ns = 10'000'000;
  core::Diagnostics diagnostics;
  const core::SystemCalendar calendar;
  std::int32_t total = 0;
  historian::Source source{[&total] { ++total; }, [&total](const runtime::Place&, std::uint32_t bytes,
                                                           std::byte* to) { std::memcpy(to, &total, bytes); }};
  historian::Historian historian(settings, folder, *rig.resource, false, source, calendar, diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 2u) << "one that is not there, and one of a task without recording";
  historian.start();
  rig.context.historian = &historian;
  Json points;
  for (int turn = 0; turn < 1000 && points.size() < 5; ++turn) {
    const HttpResponse response = rig.get("/api/history?tag=Total&from=0&to=9000000000&points=5000");
    ASSERT_EQ(response.status, 200) << response.body;
    points = body_of(response)["points"];
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_GE(points.size(), 5u);
  EXPECT_EQ(points[0]["least"], 1.0);
  EXPECT_EQ(points[4]["greatest"], 5.0);
  historian.stop();
  const Json after = body_of(rig.get("/api/history?tag=Total&from=0&to=9000000000&points=1"));
  ASSERT_EQ(after["points"].size(), 1u) << after;
  EXPECT_EQ(after["points"][0]["least"], 1.0);
  EXPECT_EQ(after["points"][0]["greatest"], total);
  EXPECT_EQ(body_of(rig.get("/api/history/tags"))["tags"], Json({"Total"}));
  expect_as_row_says(rig.get("/api/history?tag=Total&from=0&to=9000000000&points=10"), "/api/history");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=None&from=0&to=1")), "404 P7101 tag");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=Total&from=0&to=1", "")), "401 P7710 ") << "without login";
  EXPECT_EQ(refusal_of(rig.get("/api/history?from=0&to=1")), "400 P7714 tag");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=&from=0&to=1")), "400 P7714 tag");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=" + std::string(1001, 't') + "&from=0&to=1")), "400 P7714 tag");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=Total&to=1")), "400 P7714 from");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=Total&from=0")), "400 P7714 to");
  EXPECT_EQ(refusal_of(rig.get("/api/history?tag=Total&from=0&to=1&step=1")), "400 P7714 step");
  for (const char* const wrong : {"-1", "1.5", "many", "", "99999999999999999999"})
    EXPECT_EQ(refusal_of(rig.get(std::string("/api/history?tag=Total&from=0&to=1&points=") + wrong)),
              "400 P7714 points")
        << wrong;
  EXPECT_EQ(rig.get("/api/history?tag=Total&from=0&to=1&points=0").status, 400);
  EXPECT_EQ(rig.get("/api/history?tag=Total&from=0.5&to=1e3").status, 200);
  for (const char* const wrong : {"", "nan", "inf", "1e999", "1s", "0x1"})
    EXPECT_EQ(rig.get(std::string("/api/history?tag=Total&from=0&to=") + wrong).status, 400) << wrong;
  fs::remove_all(folder);
}

}  // namespace
}  // namespace plc::test
