// Variables as clients see them: names, values as JSON, writes, frames of streams.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "engineering/value_stream.h"
#include "tests/support/image_builder.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

Json read(EngineeringRig& rig, const std::string& path) {
  const HttpResponse response = rig.post("/api/values/read", {{"paths", {path}}}, "viewer");
  EXPECT_EQ(response.status, 200) << response.body;
  return body_of(response)["values"][0];
}
HttpResponse write(EngineeringRig& rig, const std::string& path, const Json& value) {
  return rig.post("/api/values/write", {{"values", {{{"path", path}, {"value", value}}}}});
}

TEST(Browse, BeginsWithInstancesListsAndGlobals) {
  EngineeringRig rig;
  const Json nodes = body_of(rig.get("/api/values"))["nodes"];
  std::vector<std::string> names;
  for (const Json& node : nodes) names.push_back(node["path"]);
  EXPECT_EQ(names, (std::vector<std::string>{"Main0", "Start", "GVL", "Large", "Long", "Small", "Text", "Wide", "Wait",
                                             "Day", "Lamp", "Percent", "Points", "Fixed", "Total"}));
  EXPECT_EQ(nodes[1], (Json{{"name", "Start"},
                            {"path", "Start"},
                            {"kind", "value"},
                            {"type", "BOOL"},
                            {"readable", true},
                            {"writable", true},
                            {"address", "%IX0.0"}}));
  EXPECT_EQ(nodes[2], (Json{{"name", "GVL"}, {"path", "GVL"}, {"kind", "list"}}));
}

TEST(Browse, GoesDown) {
  EngineeringRig rig;
  const auto paths = [&](const std::string& path) {
    std::vector<std::string> found;
    const Json body = body_of(rig.get("/api/values?path=" + path));
    for (const Json& node : body["nodes"]) found.push_back(node["path"]);
    return found;
  };
  EXPECT_EQ(paths("gvl"), (std::vector<std::string>{"GVL.Level", "GVL.Deep"}));
  EXPECT_EQ(paths("Main0"), (std::vector<std::string>{"Main0.Count"}));
  EXPECT_EQ(paths("Points"), (std::vector<std::string>{"Points[1]", "Points[2]", "Points[3]"}));
  EXPECT_EQ(paths("Points%5B2%5D"), (std::vector<std::string>{"Points[2].X", "Points[2].Y"}));
  EXPECT_EQ(paths("Start"), std::vector<std::string>{});
  EXPECT_EQ(paths("Points&from=1&most=1"), (std::vector<std::string>{"Points[2]"}));
  EXPECT_EQ(body_of(rig.get("/api/values?path=Points&most=1"))["total"], 3);
  const HttpResponse none = rig.get("/api/values?path=Pints");
  EXPECT_EQ(none.status, 404);
  EXPECT_EQ(body_of(none)["code"], "P7101");
  EXPECT_EQ(body_of(none)["field"], "path");
}

TEST(Browse, SaysWhatMayBeReadAndWritten) {
  EngineeringRig rig;
  const auto node = [&](const std::string& path) {
    return body_of(rig.get("/api/values/search?pattern=" + path))["nodes"][0];
  };
  EXPECT_EQ(node("Fixed")["writable"], false);
  EXPECT_EQ(node("Total")["writable"], true);
  EXPECT_EQ(node("Main0.Count")["readable"], false) << "its task tells its globals alone";
  EXPECT_EQ(node("Main0.Count")["writable"], false);
}

TEST(Search, SaysWhenThereIsMore) {
  EngineeringRig rig;
  const Json some = body_of(rig.get("/api/values/search?pattern=*&most=3"));
  EXPECT_EQ(some["nodes"].size(), 3u);
  EXPECT_EQ(some["more"], true);
  const Json all = body_of(rig.get("/api/values/search?pattern=*points*"));
  EXPECT_EQ(all["nodes"].size(), 6u);
  EXPECT_EQ(all["more"], false);
}

struct Case {
  const char* path;
  Json value;  ///< written and read back
};
class EachType : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    Values, EachType,
    testing::Values(Case{"Start", true}, Case{"GVL.Level", 0.1}, Case{"GVL.Deep", 0.1}, Case{"GVL.Deep", "NaN"},
                    Case{"GVL.Level", "-Infinity"}, Case{"GVL.Deep", 1e300}, Case{"Large", "18446744073709551615"},
                    Case{"Long", "-9223372036854775808"}, Case{"Small", -128}, Case{"Text", "a'b$\"<\n"},
                    Case{"Text", "\u20ac\u00e4"}, Case{"Text", ""}, Case{"Wide", "\u4e2d\U0001f600"},
                    Case{"Wait", "T#1m2s3ms"}, Case{"Day", "D#2026-11-27"}, Case{"Lamp", "Blue"}, Case{"Percent", 100},
                    Case{"Points[2].X", 7}, Case{"Points[3]", {{"X", 1}, {"Y", -2}}},
                    Case{"Points", {{{"X", 1}, {"Y", 2}}, {{"X", 3}, {"Y", 4}}, {{"X", 5}, {"Y", 6}}}}));

TEST_P(EachType, IsReadAsItWasWritten) {
  EngineeringRig rig;
  const HttpResponse written = write(rig, GetParam().path, GetParam().value);
  ASSERT_EQ(written.status, 200) << written.body;
  EXPECT_EQ(read(rig, GetParam().path)["value"], GetParam().value);
}

TEST(Write, RefusesWhatIsNoValue) {
  EngineeringRig rig;
  struct Wrong {
    const char* path;
    Json value;
    const char* code;
    const char* field;
  };
  const std::vector<Wrong> all = {
      {"Start", 2, "P7103", "values[0].value"},
      {"Start", "maybe", "P7103", "values[0].value"},
      {"Small", true, "P7103", "values[0].value"},
      {"Small", 128, "P7104", "values[0].value"},
      {"Small", 1.5, "P7103", "values[0].value"},
      {"Small", nullptr, "P7103", "values[0].value"},
      {"Percent", 101, "P7104", "values[0].value"},
      {"Lamp", "Purple", "P7103", "values[0].value"},
      {"Text", "longer than ten", "P7105", "values[0].value"},
      {"Text", "\u4e2d", "P7103", "values[0].value"},
      {"Points", {1, 2, 3}, "P7102", "values[0].value[0]"},
      {"Points", Json::array(), "P7102", "values[0].value"},
      {"Points[1]", {{"Z", 1}}, "P7101", "values[0].value.Z"},
      {"Points[1]", {{"X", "far"}}, "P7103", "values[0].value.X"},
      {"Points[4]", {{"X", 1}}, "P7101", "values[0].path"},
      {"Fixed", 1, "P7106", "values[0].value"},
      {"Main0.Count", 1, "P7106", "values[0].value"},
      {"Nowhere", 1, "P7101", "values[0].path"},
  };
  for (const Wrong& wrong : all) {
    const HttpResponse response = write(rig, wrong.path, wrong.value);
    EXPECT_NE(response.status, 200) << wrong.path;
    EXPECT_EQ(body_of(response)["code"], wrong.code) << response.body;
    EXPECT_EQ(body_of(response)["field"], wrong.field) << response.body;
  }
}

TEST(Write, IsAllOrNothing) {
  EngineeringRig rig;
  const HttpResponse response = rig.post(
      "/api/values/write", {{"values", {{{"path", "Small"}, {"value", 5}}, {{"path", "Percent"}, {"value", 500}}}}});
  EXPECT_EQ(response.status, 409);
  EXPECT_EQ(body_of(response)["field"], "values[1].value");
  EXPECT_EQ(read(rig, "Small")["value"], 0);
  EXPECT_TRUE(rig.audit.recent(10).empty());
}

TEST(Write, OfATasksVariableComesWithItsNextScan) {
  EngineeringRig rig;
  rig.scan();
  ASSERT_EQ(write(rig, "Total", 100).status, 200);
  EXPECT_EQ(read(rig, "Total")["value"], 1);
  rig.scan();
  EXPECT_EQ(read(rig, "Total")["value"], 101);
}

TEST(Read, SaysOfEachPathWhatIsWrong) {
  EngineeringRig rig;
  rig.scan();
  const Json values = body_of(
      rig.post("/api/values/read", {{"paths", {"Total", "Nowhere", "Main0.Count", "%IX0.0"}}}, "viewer"))["values"];
  ASSERT_EQ(values.size(), 4u);
  EXPECT_EQ(values[0], (Json{{"path", "Total"}, {"value", 1}, {"type", "DINT"}}));
  EXPECT_EQ(values[1]["problem"]["code"], "P7101");
  EXPECT_EQ(values[2]["problem"]["code"], "P7720");
  EXPECT_EQ(values[3]["value"], false);
}

TEST(Tasks, AreAsTheyRan) {
  EngineeringRig rig;
  const Json task = body_of(rig.get("/api/tasks"))["tasks"][0];
  EXPECT_EQ(task["name"], "Fast");
  EXPECT_EQ(task["period_ns"], 10'000'000);
  EXPECT_EQ(task["state"], "starts");
  EXPECT_EQ(task["latency"]["count"], 0);
}

/// What a client makes of a frame.
struct Decoded {
  std::uint8_t version = 0, whole = 0;
  std::uint16_t subscription = 0;
  std::uint32_t count = 0;
  std::uint64_t scans = 0;
  std::int64_t time_ns = 0;
  std::vector<std::size_t> dirty;
  std::string values;
};
Decoded decode(const std::string& bytes) {
  Decoded frame;
  std::size_t at = 0;
  const auto take = [&](auto& to) {
    std::memcpy(&to, bytes.data() + at, sizeof to);
    at += sizeof to;
  };
  take(frame.version);
  take(frame.whole);
  take(frame.subscription);
  take(frame.count);
  take(frame.scans);
  take(frame.time_ns);
  for (std::size_t i = 0; i < frame.count; ++i) {
    if ((static_cast<unsigned char>(bytes[at + i / 8]) >> (i % 8) & 1u) != 0) frame.dirty.push_back(i);
  }
  frame.values = bytes.substr(at + (frame.count + 7) / 8);
  return frame;
}

TEST(ValueStream, SendsAllThenWhatChanged) {
  EngineeringRig rig;
  engineering::ValueStream stream(rig.context, 10'000'000);
  EXPECT_FALSE(stream.next()) << "nobody has asked";
  const Json layout = Json::parse(stream.take(R"({"subscribe": ["Total", "Text", "Points[1]", "Lamp", "Nowhere"]})"));
  EXPECT_EQ(layout["subscription"], 1);
  ASSERT_EQ(layout["layout"].size(), 5u);
  EXPECT_EQ(layout["layout"][0], (Json{{"path", "Total"}, {"type", "DINT"}, {"form", "i32"}}));
  EXPECT_EQ(layout["layout"][1]["form"], "text");
  EXPECT_EQ(layout["layout"][2]["path"], "Points[1].X");
  EXPECT_EQ(layout["layout"][4]["members"][2], (Json{{"name", "Blue"}, {"value", 2}}));
  EXPECT_EQ(layout["problems"][0]["code"], "P7101");

  ASSERT_EQ(write(rig, "Text", "h\u00e4").status, 200);
  auto frame = stream.next();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->binary);
  Decoded first = decode(frame->bytes);
  EXPECT_EQ(first.version, 1);
  EXPECT_EQ(first.whole, 1);
  EXPECT_EQ(first.subscription, 1);
  EXPECT_EQ(first.time_ns, rig.calendar.now_ns);
  EXPECT_EQ(first.dirty, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(first.values, std::string("\0\0\0\0\3\0h\xc3\xa4\0\0\0\0\0\0\0\0\0\0", 19));
  EXPECT_FALSE(stream.next()) << "nothing has changed";

  rig.scan();
  rig.scan();
  ASSERT_EQ(write(rig, "Points[1].Y", 258).status, 200);
  frame = stream.next();
  ASSERT_TRUE(frame);
  const Decoded second = decode(frame->bytes);
  EXPECT_EQ(second.whole, 0);
  EXPECT_EQ(second.dirty, (std::vector<std::size_t>{0, 3}));
  EXPECT_EQ(second.values, std::string("\2\0\0\0\2\1\0\0", 8));
}

TEST(ValueStream, TellsTheClockAlsoWhenNothingChanges) {
  EngineeringRig rig;
  engineering::ValueStream stream(rig.context, 10'000'000);
  stream.take(R"({"subscribe": ["Total", "Text"]})");
  ASSERT_TRUE(stream.next());
  rig.calendar.now_ns -= 3600 * engineering::ValueStream::kStillNs;
  rig.clock.sleep_until_ns(rig.clock.now_ns() + engineering::ValueStream::kStillNs - 1);
  EXPECT_FALSE(stream.next());
  rig.clock.sleep_until_ns(rig.clock.now_ns() + 1);
  const auto frame = stream.next();
  ASSERT_TRUE(frame);
  const Decoded still = decode(frame->bytes);
  EXPECT_EQ(still.whole, 0);
  EXPECT_EQ(still.count, 2u);
  EXPECT_TRUE(still.dirty.empty());
  EXPECT_EQ(still.values, "");
  EXPECT_EQ(still.time_ns, rig.calendar.now_ns);
  EXPECT_FALSE(stream.next());
}

TEST(ValueStream, ASlowClientGetsTheNewestAlone) {
  EngineeringRig rig;
  engineering::ValueStream stream(rig.context, 10'000'000);
  stream.take(R"({"subscribe": ["Total"]})");
  static_cast<void>(stream.next());
  for (int i = 0; i < 1000; ++i) rig.scan();
  const auto frame = stream.next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(decode(frame->bytes).values, std::string("\xe8\3\0\0", 4));
  EXPECT_FALSE(stream.next());
}

TEST(ValueStream, OnePathTooMuchLeavesTheOthers) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  b.global("Buffer", b.array(dint, 30'000, 0));
  b.global("Level", dint);
  b.task("Fast", 10'000'000, {b.pou("Main", PouKind::kProgram).finish()});
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  ASSERT_TRUE(image);
  EngineeringRig rig(std::move(*image));
  engineering::ValueStream stream(rig.context, 10'000'000);
  const Json answer = Json::parse(stream.take(R"({"subscribe": ["Buffer", "Level", "Buffer[7]"]})"));
  ASSERT_EQ(answer["layout"].size(), 2u) << answer;
  EXPECT_EQ(answer["layout"][0]["path"], "Level");
  EXPECT_EQ(answer["layout"][1]["path"], "Buffer[7]");
  ASSERT_EQ(answer["problems"].size(), 1u);
  EXPECT_EQ(answer["problems"][0]["path"], "Buffer");
  EXPECT_EQ(answer["problems"][0]["code"], "P7717");
  const auto frame = stream.next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(decode(frame->bytes).dirty, (std::vector<std::size_t>{0, 1}));
}

TEST(ValueStream, RefusesWhatIsNoSubscription) {
  EngineeringRig rig;
  engineering::ValueStream stream(rig.context, 10'000'000);
  for (const char* text :
       {"", "x", "[]", "{}", R"({"subscribe": 1})", R"({"subscribe": [1]})", R"({"subscribe": [], "x": 1})"}) {
    EXPECT_EQ(Json::parse(stream.take(text))["code"], "P7714") << text;
  }
  Json many;
  for (int i = 0; i < 4000; ++i) many["subscribe"].push_back("Points");
  const Json answer = Json::parse(stream.take(many.dump()));
  EXPECT_EQ(answer["layout"].size(), 19'998u) << "six values each";
  EXPECT_EQ(answer["problems"].size(), 667u);
  EXPECT_EQ(answer["problems"][0]["code"], "P7717");
}

TEST(LogStream, FollowsAndSaysWhatItMissed) {
  EngineeringRig rig;
  const auto add = [&](int count) {
    for (int i = 0; i < count; ++i) rig.log.add({core::Severity::kNote, "note", {}, {}, {}, {}, {}, {}, 1});
  };
  add(3);
  const auto* row = engineering::find_call("/api/log/stream");
  const auto stream = engineering::make_stream(*row, rig.context, {{"after", 1}});
  EXPECT_EQ(Json::parse(stream->next()->bytes)["number"], 2);
  EXPECT_EQ(Json::parse(stream->next()->bytes)["number"], 3);
  EXPECT_FALSE(stream->next());
  add(static_cast<int>(engineering::LogBook::kMost) + 10);
  EXPECT_EQ(Json::parse(stream->next()->bytes), (Json{{"missed", 10}}));
  EXPECT_EQ(Json::parse(stream->next()->bytes)["number"], 14);
}

TEST(Log, GivesTheLatestOrThoseAfter) {
  EngineeringRig rig;
  for (int i = 0; i < 5; ++i) {
    rig.log.add({i % 2 == 0 ? core::Severity::kError : core::Severity::kNote,
                 "text\x1b[31m",
                 "panel",
                 "P7510",
                 {},
                 {},
                 {},
                 {},
                 1});
  }
  const Json all = body_of(rig.get("/api/log"));
  EXPECT_EQ(all["records"].size(), 5u);
  EXPECT_EQ(all["last"], 5);
  EXPECT_EQ(all["records"][0]["message"], "text?[31m") << "as in the log itself";
  EXPECT_EQ(body_of(rig.get("/api/log?least=error&most=2"))["records"][0]["number"], 3);
  EXPECT_EQ(body_of(rig.get("/api/log?after=3"))["records"].size(), 2u);
  EXPECT_EQ(rig.get("/api/log?least=fatal").status, 400);
}

}  // namespace
}  // namespace plc::test
