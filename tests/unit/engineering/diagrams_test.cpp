// Drawings and their power flow as clients have them: parts, search, live frames against what probes say, the past.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "engineering/flow_stream.h"
#include "engineering/validate.h"
#include "runtime/sched/simulation.h"
#include "shadow/past.h"
#include "tests/support/drawn_image.h"
#include "tests/support/golden.h"
#include "tests/unit/engineering/rig.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using engineering::FlowPoint;

bytecode::VerifiedImage tank() { return drawn_image((source_root() / "examples/tank/tank.xml").string()); }

/// A plant with drawings whose scans are recorded.
struct DrawnPlant {
  explicit DrawnPlant(bytecode::VerifiedImage image = tank()) : rig(std::move(image)) {
    auto started = shadow::Shadow::start(
        *rig.resource, {},
        {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(rig.resource->image())});
    EXPECT_TRUE(started) << started.error().message;
    shadow = std::move(*started);
    rig.context.shadow = shadow.get();
    rig.drawn.live.set_shadow(shadow.get());
    simulation.emplace(*rig.resource);
  }
  void scans(std::uint64_t count) { simulation->run_cycles(count); }
  void wait_for_all() {
    std::uint64_t all = 0;
    for (std::uint32_t task = 0; task < rig.resource->task_count(); ++task) all += simulation->scans(task);
    for (int turn = 0; turn < 2000 && shadow->counts().scans != all; ++turn)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  Json call(const std::string& target) {
    const HttpResponse response = rig.get(target);
    EXPECT_EQ(response.status, 200) << target << ": " << response.body;
    return body_of(response);
  }

  EngineeringRig rig;
  std::unique_ptr<shadow::Shadow> shadow;
  std::optional<runtime::Simulation> simulation;
};

/// Values of an attribute in pieces of SVG.
std::set<std::string> attributes(const std::string& svg, const std::string& name) {
  std::set<std::string> found;
  const std::string begin = " " + name + "=\"";
  for (std::size_t at = svg.find(begin); at != std::string::npos; at = svg.find(begin, at + 1)) {
    const std::size_t from = at + begin.size();
    found.insert(svg.substr(from, svg.find('"', from) - from));
  }
  return found;
}

Json all_points(DrawnPlant& p, const std::string& pou) {
  Json points = Json::array();
  const std::int64_t count = p.call("/api/diagrams/sheet?pou=" + pou)["points"].get<std::int64_t>();
  for (std::int64_t i = 0; i < count; ++i) points.push_back(static_cast<std::uint64_t>(i));
  return points;
}

TEST(Diagrams, AreListedWithTheirInstances) {
  DrawnPlant p;
  const Json pous = p.call("/api/diagrams")["pous"];
  ASSERT_EQ(pous.size(), 5u) << pous;
  EXPECT_EQ(
      pous[0],
      (Json{{"pou", "RawToUnit"}, {"owner", "function block"}, {"language", "FBD"}, {"instances", 2}, {"live", true}}));
  EXPECT_EQ(pous[3]["language"], "LD");
  const Json instances = p.call("/api/diagrams/instances?pou=rawtounit&pattern=TEMP");
  EXPECT_EQ(instances["total"], 1);
  EXPECT_EQ(instances["instances"][0]["path"], "Measuring.TempScale");
  EXPECT_EQ(instances["instances"][0]["task"], "Fast");
  EXPECT_EQ(p.rig.get("/api/diagrams/instances?pou=Nothing").status, 404);
  EXPECT_EQ(p.rig.get("/api/diagrams", "").status, 401);
}

TEST(Diagrams, AnswerAsTheirRowsSay) {
  DrawnPlant p;
  p.scans(20);
  p.wait_for_all();
  ASSERT_EQ(p.rig.post("/api/diagrams/past", Json::object(), "viewer").status, 200);
  for (const engineering::Call& call : engineering::calls()) {
    if (!call.name.starts_with("diagrams.") || call.form != engineering::Form::kJson) continue;
    const Json example = Json::parse(call.example);
    std::string query;
    for (const auto& [name, value] : example.items())
      query += (query.empty() ? "?" : "&") + name + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
    const HttpResponse answer = call.method == engineering::Method::kGet
                                    ? p.rig.get(std::string(call.path) + query)
                                    : p.rig.post(std::string(call.path), example, "viewer");
    ASSERT_EQ(answer.status, 200) << call.name << ": " << answer.body;
    const auto wrong = engineering::wrong_fields(body_of(answer), call.response);
    EXPECT_FALSE(wrong) << call.name << " " << wrong->field << " " << wrong->text << "\n" << answer.body;
  }
}

TEST(Diagrams, WithoutDrawingsSaySo) {
  EngineeringRig rig;
  EXPECT_EQ(body_of(rig.get("/api/diagrams"))["pous"].size(), 0u);
  EXPECT_EQ(body_of(rig.get("/api/diagrams/sheet?pou=Main"))["code"], "P7740");
  EXPECT_EQ(body_of(rig.post("/api/diagrams/past", Json::object(), "viewer"))["code"], "P7720");
}

TEST(Diagrams, PartsTogetherHaveAllAndEachHasLittle) {
  DrawnPlant p;
  const Json sheet = p.call("/api/diagrams/sheet?pou=Station&breaks=true");
  EXPECT_GE(sheet["breaks"].size(), 5u) << "between rungs";
  std::set<std::string> whole, together;
  const auto part = [&](int x, int y, int width, int height) {
    return p
        .call("/api/diagrams/tile?pou=Station&x=" + std::to_string(x) + "&y=" + std::to_string(y) +
              "&width=" + std::to_string(width) + "&height=" + std::to_string(height))["svg"]
        .get<std::string>();
  };
  whole = attributes(part(0, 0, 8000, 8000), "data-k");
  EXPECT_GT(whole.size(), 100u);
  std::size_t most = 0;
  for (int y = 0; y < sheet["height"].get<int>(); y += 150) {
    for (int x = 0; x < sheet["width"].get<int>(); x += 200) {
      const auto some = attributes(part(x, y, 200, 150), "data-k");
      most = std::max(most, some.size());
      together.insert(some.begin(), some.end());
    }
  }
  EXPECT_EQ(together, whole);
  EXPECT_LT(most, whole.size() / 2);
}

TEST(Diagrams, HostileNamesAreText) {
  DrawnPlant p(drawn_text(R"(PROGRAM Main
VAR a : STRING := '<script>alert(1)</script>'; b : BOOL; END_VAR
b := a = '<b>&amp;"'; (* "/><img src=x onerror=alert(2)> *)
b := TRUE;
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)"));
  const auto svg = p.call("/api/diagrams/tile?pou=Main&x=0&y=0&width=2000&height=2000")["svg"].get<std::string>();
  EXPECT_EQ(svg.find("<img"), std::string::npos) << svg;
  EXPECT_EQ(svg.find("<b>"), std::string::npos);
  EXPECT_NE(svg.find("&lt;img src=x"), std::string::npos) << svg;
}

TEST(Diagrams, FindTextsAndUsesOfOneVariable) {
  DrawnPlant p;
  const Json text = p.call("/api/diagrams/find?text=stopbut");
  ASSERT_EQ(text["found"].size(), 2u) << text;
  EXPECT_EQ(text["found"][0]["place"]["kind"], "contact");
  EXPECT_EQ(text["found"][0]["place"]["pou"], "Station");
  EXPECT_GT(text["found"][0]["place"]["network"].get<int>(), 0);
  const Json uses = p.call("/api/diagrams/find?text=Running&pou=Station&instance=Sequence&uses=true");
  EXPECT_EQ(uses["path"], "Sequence.Running");
  std::map<std::string, int> by_pou;
  int writes = 0;
  for (const Json& one : uses["found"]) {
    ++by_pou[one["place"]["pou"].get<std::string>()];
    writes += one["writes"] == true ? 1 : 0;
  }
  EXPECT_GE(by_pou["Station"], 4) << uses;
  EXPECT_GE(by_pou["Signals"], 1) << uses;
  EXPECT_EQ(writes, 1);
  // Found places have a place in the drawing.
  const Json place = p.call("/api/diagrams/place?pou=Station&body=0&element=" +
                            std::to_string(text["found"][0]["place"]["element"].get<int>()));
  EXPECT_GT(place["width"].get<int>(), 0);
  EXPECT_EQ(p.rig.get("/api/diagrams/place?pou=Station&body=0&element=100000").status, 404);
  EXPECT_EQ(p.rig.get("/api/diagrams/svg?pou=Station").status, 200);
}

/// What a client has after a frame, by point.
using Seen = std::map<std::uint64_t, std::pair<int, std::string>>;
void take(Seen& seen, const Json& points) {
  for (const Json& one : points)
    seen[one["point"].get<std::uint64_t>()] = {one["state"].get<int>(), one.value("text", std::string())};
}

TEST(FlowStream, ShowsWhatProbesHadInThousandRandomStates) {
  DrawnPlant p;
  const Json points = all_points(p, "Station");
  engineering::FlowStream stream(p.rig.context, 0);
  const Json answer = Json::parse(stream.take(Json{{"pou", "Station"}, {"points", points}}.dump()));
  EXPECT_EQ(answer["instance"], "Sequence") << answer;
  // From here on its replica has probes: the first frame says so.
  std::optional<engineering::Frame> frame;
  for (int turn = 0; turn < 2000 && !frame; ++turn) {
    p.scans(1);
    p.wait_for_all();
    frame = stream.next();
  }
  ASSERT_TRUE(frame);
  struct Told {
    std::uint64_t scan;
    Seen seen;
  };
  std::vector<Told> told;
  Seen seen;
  take(seen, Json::parse(frame->bytes)["points"]);
  told.push_back({Json::parse(frame->bytes)["scan"].get<std::uint64_t>(), seen});
  std::mt19937 random(20261127);
  int states = 0;
  while (states < 1000) {
    const int batch = 1 + static_cast<int>(random() % 10);
    for (int i = 0; i < batch; ++i, ++states) {
      for (const char* const input : {"StartButton", "StopButton", "EmergencyOk"})
        set(*p.rig.resource, input, random() % 4 == 0 ? "0" : "1");
      set(*p.rig.resource, "LevelRaw", std::to_string(random() % 27648));
      p.scans(1);
    }
    const std::uint64_t newest = p.simulation->scans(0) - 1;
    for (int turn = 0; turn < 2000 && told.back().scan != newest; ++turn) {
      if ((frame = stream.next())) {
        const Json body = Json::parse(frame->bytes);
        take(seen, body["points"]);
        told.push_back({body["scan"].get<std::uint64_t>(), seen});
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
    ASSERT_EQ(told.back().scan, newest);
  }
  EXPECT_GT(told.size(), 50u);

  // The same scans again, from their records, by probes of another replica.
  p.wait_for_all();
  auto past = std::move(*shadow::Past::open(p.shadow->recording(), {}));
  const auto& diagrams = p.rig.drawn.diagrams;
  const auto book = p.rig.drawn.diagrams.book();
  const engineering::DrawnPou& pou = *book->find("Station");
  const auto instance = diagrams.instance(pou, {}, {});
  const auto all = diagrams.points(pou);
  std::uint64_t compared = 0;
  for (std::size_t f = 1; f < told.size(); ++f) {
    std::vector<int> bits(all.size());
    std::vector<std::string> texts(all.size());
    for (std::uint64_t scan = told[f - 1].scan + 1; scan <= told[f].scan; ++scan) {
      ASSERT_TRUE(past->look(0, scan, {&instance->at.view, 1}, [&](const runtime::RecordHead&) {
        const shadow::ProbeView view(past->resource().program(0), instance->at.view);
        for (std::size_t i = 0; i < all.size(); ++i) {
          const shadow::Shown shown = view.at(all[i]);
          bits[i] |= (shown.ran ? 1 : 0) | (shown.was_on ? 256 : 0) | (shown.was_off ? 512 : 0);
          if (!shown.ran) continue;
          bits[i] = (bits[i] & ~14) | (shown.is_bool ? 2 : 0) | (shown.known ? 4 : 0) |
                    (shown.is_bool && shown.known && shown.on ? 8 : 0);
          texts[i] = shown.is_bool ? std::string() : view.text(all[i], runtime::ValueStyle::kNames);
        }
      }));
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto& [state, text] = told[f].seen.at(i);
      ASSERT_EQ(state & FlowPoint::kRan, bits[i] & 1) << "point " << i << " in scan " << told[f].scan;
      ASSERT_EQ((state & FlowPoint::kBoth) != 0, (bits[i] & 768) == 768)
          << "point " << i << " in scans " << told[f - 1].scan + 1 << " to " << told[f].scan << ": " << state << ", "
          << bits[i];
      ++compared;
      if ((bits[i] & 1) == 0) continue;  // what was before still stands there
      ASSERT_EQ(state & 14, bits[i] & 14) << "point " << i << " in scan " << told[f].scan;
      ASSERT_EQ(text, texts[i]) << "point " << i;
    }
  }
  EXPECT_GT(compared, 10'000u);
}

TEST(FlowStream, MarksWhatIsForced) {
  DrawnPlant p;
  const Json forced = {{"path", "StopButton"}, {"value", true}, {"reason", "trial"}};
  ASSERT_EQ(p.rig.post("/api/forces/set", forced, "engineer").status, 200);
  engineering::FlowStream stream(p.rig.context, 0);
  stream.take(Json{{"pou", "Station"}, {"points", all_points(p, "Station")}}.dump());
  Seen seen;
  for (int turn = 0; turn < 2000 && seen.empty(); ++turn) {
    p.scans(1);
    p.wait_for_all();
    if (const auto frame = stream.next()) take(seen, Json::parse(frame->bytes)["points"]);
  }
  const auto opened = p.rig.drawn.diagrams.open("Station");
  int marked = 0;
  for (const auto& [point, what] : seen) {
    const bool is = (what.first & FlowPoint::kForced) != 0;
    EXPECT_EQ(is, opened->names[point] == "StopButton") << opened->names[point];
    marked += is ? 1 : 0;
  }
  EXPECT_EQ(marked, 2) << "two contacts";
}

TEST(FlowStream, RefusesWhatIsNotThere) {
  DrawnPlant p;
  engineering::FlowStream stream(p.rig.context, 0);
  EXPECT_FALSE(stream.next());
  for (const char* text :
       {"", "[]", "{}", R"({"pou": "Station", "points": [-1]})", R"({"pou": "Station", "points": ["a"]})"})
    EXPECT_EQ(Json::parse(stream.take(text))["code"], "P7714") << text;
  EXPECT_EQ(Json::parse(stream.take(R"({"pou": "Nothing", "points": []})"))["code"], "P7101");
  EXPECT_EQ(Json::parse(stream.take(R"({"pou": "Station", "instance": "Nobody", "points": []})"))["code"], "P7101");
  EXPECT_FALSE(stream.next());
}

TEST(FlowStream, PreparesOnAnyThreadWhatTakesLong) {
  DrawnPlant p;
  engineering::FlowStream at_once(p.rig.context, 0), prepared(p.rig.context, 0);
  const std::string good = R"({"pou": "Station", "points": [0, 1]})";
  for (const std::string& text :
       {good, std::string("no JSON"), std::string(R"({"pou": "Nothing", "points": []})"), good}) {
    std::thread(prepared.prepare(text)).join();
    EXPECT_EQ(prepared.take(text), at_once.take(text));
  }
  const auto late = engineering::FlowStream(p.rig.context, 0).prepare(good);
  late();  // its client has gone
}

TEST(PastFlow, GivesAnyScanAndStepsBack) {
  DrawnPlant p;
  p.scans(100);
  p.wait_for_all();
  const Json opened = body_of(p.rig.post("/api/diagrams/past", Json::object(), "viewer"));
  ASSERT_EQ(opened["recording"], 1) << opened;
  EXPECT_EQ(opened["tasks"][0]["task"], "Fast");
  const std::uint64_t last = opened["tasks"][0]["last"].get<std::uint64_t>();
  const auto flow = [&](Json more) {
    Json request = {{"recording", 1}, {"pou", "Station"}, {"points", {0, 1, 2}}};
    request.update(more);
    return p.rig.post("/api/diagrams/flow", request, "viewer");
  };
  const Json newest = body_of(flow(Json::object()));
  EXPECT_EQ(newest["scan"], last) << newest;
  EXPECT_EQ(newest["points"].size(), 3u);
  const Json before = body_of(flow({{"scan", last - 1}}));
  EXPECT_EQ(before["scan"], last - 1);
  EXPECT_EQ(before["now_ns"].get<std::int64_t>(), newest["now_ns"].get<std::int64_t>() - 20'000'000);
  EXPECT_EQ(body_of(flow({{"now_ns", before["now_ns"]}}))["scan"], last - 1);
  // The plant goes on; the recording does not.
  p.scans(10);
  p.wait_for_all();
  EXPECT_EQ(body_of(flow(Json::object()))["scan"], last);
  EXPECT_EQ(body_of(flow({{"recording", 9}}))["code"], "P7741");
  EXPECT_EQ(body_of(flow({{"instance", "Nobody"}}))["code"], "P7101");
  // Three are kept.
  for (int i = 2; i <= 4; ++i) {
    p.rig.clock.sleep_until_ns(p.rig.clock.now_ns() + 3'000'000'000);
    EXPECT_EQ(body_of(p.rig.post("/api/diagrams/past", Json::object(), "viewer"))["recording"], i);
  }
  EXPECT_EQ(body_of(flow(Json::object()))["code"], "P7741");
  EXPECT_EQ(body_of(flow({{"recording", 2}})).value("scan", 0), last + 10);
}

TEST(PastFlow, SaysWhyACoilIsOff) {
  DrawnPlant p;
  set(*p.rig.resource, "EmergencyOk", "1");
  set(*p.rig.resource, "StartButton", "1");
  p.scans(5);
  set(*p.rig.resource, "StartButton", "0");
  p.scans(10);
  set(*p.rig.resource, "StopButton", "1");
  p.scans(10);
  p.wait_for_all();
  const Json request = {{"pou", "Station"}, {"name", "Running"}};
  const Json why = body_of(p.rig.post("/api/diagrams/why", request, "viewer"));
  ASSERT_EQ(why["links"].size(), 4u) << why;
  EXPECT_EQ(why["links"][1]["kind"], "wrote");
  EXPECT_EQ(why["links"][1]["place"]["kind"], "coil");
  EXPECT_EQ(why["links"][2]["variable"], "StopButton");
  EXPECT_EQ(why["links"][2]["instance"], "Sequence");
  EXPECT_EQ(why["links"][3]["kind"], "outside");
  const Json number = {{"pou", "Station"}, {"name", "Level"}};
  EXPECT_EQ(body_of(p.rig.post("/api/diagrams/why", number, "viewer"))["code"], "P7742");
}

}  // namespace
}  // namespace plc::test
