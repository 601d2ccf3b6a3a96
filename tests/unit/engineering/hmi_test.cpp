// HMI pages over the API: the file, what operators may write, buttons that are held, pictures.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "engineering/validate.h"
#include "tests/support/run_tool.h"
#include "tests/unit/engineering/rig.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

constexpr const char* kPages = R"(# The panel.

[[page]]
name = "panel"
columns = 24
rows = 14

[[page.element]]
kind = "slider"
x = 0
y = 0
width = 6
height = 2
variable = "GVL.Level"
low = 10
high = 20

[[page.element]]
kind = "switch"
x = 6
y = 0
width = 3
height = 2
variable = "%IX0.0"

[[page.element]]
kind = "button"
x = 0
y = 2
width = 3
height = 2
variable = "Lamp"
value = "Green"

[[page.element]]
kind = "button"
x = 3
y = 2
width = 3
height = 2
variable = "Small"
value = -3

[[page.element]]
kind = "number"
x = 6
y = 2
width = 4
height = 2
variable = "Large"
high = 1000
entered = true

[[page.element]]
kind = "number"
x = 10
y = 2
width = 4
height = 2
variable = "Points[1].X"
)";

constexpr const char* kButton = R"([[page]]
name = "panel"
[[page.element]]
kind = "button"
x = 0
y = 0
variable = "Start"
)";

class Hmi : public ::testing::Test {
 protected:
  void write(const std::string& text, const std::string& name = "pages.toml") {
    std::ofstream(scratch_.file(name), std::ios::binary) << text;
  }
  std::string file() const {
    std::ifstream in(scratch_.file("pages.toml"), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// A plant with this file.
  EngineeringRig& rig(const std::string& pages) {
    if (!pages.empty()) write(pages);
    rig_ = std::make_unique<EngineeringRig>(false, true, std::string(), scratch_.file("."));
    rig_->hmi.read();
    return *rig_;
  }
  /// "200", or code and field of the refusal.
  static std::string outcome(const HttpResponse& response) {
    if (response.status == 200) return "200";
    const Json body = body_of(response);
    return body.value("code", "") + " " + body.value("field", "");
  }
  std::string written(const std::string& path, const Json& value, const std::string& role = "operator",
                      bool offered = false) {
    Json body = {{"values", {{{"path", path}, {"value", value}}}}};
    if (offered) body["offered"] = true;
    return outcome(rig_->post("/api/values/write", body, role));
  }
  HttpResponse press(const std::string& path, bool pressed, const std::string& role = "operator") {
    return rig_->post("/api/pages/press", {{"path", path}, {"pressed", pressed}}, role);
  }
  /// Time goes on, and the plant is served.
  void wait_ms(std::int64_t ms) {
    rig_->clock.sleep_until_ns(rig_->clock.now_ns() + ms * 1'000'000);
    rig_->presses.service(rig_->clock.now_ns());
  }
  std::string start() { return value_of(*rig_->resource, "Start"); }

  ScratchFolder scratch_;
  std::unique_ptr<EngineeringRig> rig_;
};

TEST_F(Hmi, WithoutFileOperatorsWriteWhatTheyCould) {
  rig("");
  const Json pages = body_of(rig_->get("/api/pages"));
  EXPECT_EQ(pages["made"], true);
  EXPECT_EQ(pages["version"], "");
  EXPECT_EQ(written("Long", "12"), "200");
  EXPECT_EQ(written("Fixed", 1), "P7106 values[0].value");
}

TEST_F(Hmi, OperatorsWriteWhatPagesOffer) {
  rig(kPages);
  EXPECT_EQ(body_of(rig_->get("/api/pages"))["problems"], Json::array());
  EXPECT_EQ(written("GVL.Level", 15), "200");
  EXPECT_EQ(written("gvl.level", 10), "200");
  EXPECT_EQ(written("GVL.Level", 20), "200");
  EXPECT_EQ(written("GVL.Level", 20.5), "P7777 values");
  EXPECT_EQ(written("GVL.Level", 9.99), "P7777 values");
  EXPECT_EQ(written("GVL.Level", "NaN"), "P7777 values");
  EXPECT_EQ(written("Start", true), "200") << "the page has its address";
  EXPECT_EQ(written("%IX0.0", false), "200");
  EXPECT_EQ(written("Lamp", "Green"), "200");
  EXPECT_EQ(written("Lamp", 1), "200") << "the same member by its number";
  EXPECT_EQ(written("Lamp", "Red"), "P7777 values");
  EXPECT_EQ(written("Small", -3), "200");
  EXPECT_EQ(written("Small", 3), "P7777 values");
  EXPECT_EQ(written("Large", "1000"), "200");
  EXPECT_EQ(written("Large", "1001"), "P7777 values");
  EXPECT_EQ(written("Points[1].X", 1), "P7777 values") << "it is shown only";
  EXPECT_EQ(written("Long", "12"), "P7777 values");
  EXPECT_EQ(written("Points", Json::array({{{"X", 1}}, {{"X", 1}}, {{"X", 1}}})), "P7777 values");
  EXPECT_EQ(written("GVL.Level", 15, "viewer"), "P7711 ");
  const Json refused = body_of(rig_->post("/api/values/write", {{"values", {{{"path", "GVL.Level"}, {"value", 21}}}}}));
  EXPECT_EQ(refused["text"], "\"GVL.Level\" may be from 10 to 20");
}

TEST_F(Hmi, OfSeveralValuesNoneIsWrittenWhenOneIsNotOffered) {
  rig(kPages);
  const Json both = {{"values", {{{"path", "GVL.Level"}, {"value", 12}}, {{"path", "Long"}, {"value", "1"}}}}};
  EXPECT_EQ(outcome(rig_->post("/api/values/write", both)), "P7777 values");
  rig_->scan();
  EXPECT_EQ(value_of(*rig_->resource, "GVL.Level"), "0");
}

TEST_F(Hmi, EngineersWriteEverythingUnlessAPageAsks) {
  rig(kPages);
  EXPECT_EQ(written("Long", "12", "engineer"), "200");
  EXPECT_EQ(written("GVL.Level", 100, "engineer"), "200");
  EXPECT_EQ(written("GVL.Level", 100, "engineer", true), "P7777 values");
  EXPECT_EQ(written("GVL.Level", 11, "engineer", true), "200");
}

TEST_F(Hmi, AFileWithMistakesOffersNothingAndSaysWhy) {
  rig("[[page]]\nname = \"a\"\n[[page.element]]\nkind = \"lmap\"\n");
  const Json pages = body_of(rig_->get("/api/pages"));
  EXPECT_EQ(pages["usable"], false);
  ASSERT_EQ(pages["problems"].size(), 1u) << pages["problems"];
  EXPECT_EQ(pages["problems"][0].get<std::string>().substr(0, 30), "pages.toml:4:8: error P7771: \"");
  EXPECT_EQ(written("GVL.Level", 15), "P7777 values");
  EXPECT_EQ(
      outcome(rig_->post("/api/pages/save", {{"version", pages["version"]}, {"pages", Json::array()}}, "engineer")),
      "P7779 pages")
      << "what somebody wrote by hand is not lost";
  // Mended, it counts.
  write(kPages);
  EXPECT_EQ(body_of(rig_->post("/api/pages/reload", Json::object(), "viewer"))["usable"], true);
  EXPECT_EQ(written("GVL.Level", 15), "200");
  // With a mistake again, those of before count.
  write("[[page");
  rig_->post("/api/pages/reload", Json::object(), "viewer");
  EXPECT_EQ(written("GVL.Level", 15), "200");
  EXPECT_EQ(body_of(rig_->get("/api/pages"))["pages"].size(), 1u);
}

TEST_F(Hmi, WhatIsNotThereIsSaidAndNotOffered) {
  rig("[[page]]\nname = \"a\"\n[[page.element]]\nkind = \"lamp\"\nx = 0\ny = 0\nvariable = \"Lamb\"\n"
      "[[page.element]]\nkind = \"switch\"\nx = 0\ny = 0\nvariable = \"Fixed\"\n"
      "[[page.element]]\nkind = \"switch\"\nx = 0\ny = 0\nvariable = \"Long\"\n"
      "[[page.element]]\nkind = \"plot\"\nx = 0\ny = 0\nvariables = [\"Long\", \"Short\"]\n");
  const Json problems = body_of(rig_->get("/api/pages"))["problems"];
  ASSERT_EQ(problems.size(), 4u) << problems;
  EXPECT_EQ(problems[0].get<std::string>().substr(0, 32), "pages.toml:7:12: warning P7776: ") << problems;
  EXPECT_NE(problems.dump().find("pages.toml:17:12: warning P7776: \\\"Long\\\" is no BOOL"), std::string::npos)
      << problems;
  EXPECT_NE(problems.dump().find("pages.toml:12:12: warning P7776: \\\"Fixed\\\" cannot be written"), std::string::npos)
      << problems;
  EXPECT_NE(problems.dump().find("pages.toml:22:13: warning P7776"), std::string::npos) << problems;
  EXPECT_NE(problems.dump().find("Short"), std::string::npos);
  EXPECT_EQ(written("Long", "1"), "P7777 values");
}

TEST_F(Hmi, WhatWasGotIsSavedAsTheSameBytes) {
  rig(kPages);
  const Json pages = body_of(rig_->get("/api/pages"));
  const Json saved = {{"version", pages["version"]}, {"pages", pages["pages"]}, {"comment", pages["comment"]}};
  EXPECT_EQ(outcome(rig_->post("/api/pages/save", saved, "operator")), "P7711 ");
  const HttpResponse answer = rig_->post("/api/pages/save", saved, "engineer");
  EXPECT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(file(), kPages);
  EXPECT_EQ(body_of(answer)["version"], pages["version"]);
  EXPECT_EQ(Json::parse(rig_->audit.recent(1)[0])["what"], "pages.save");
}

TEST_F(Hmi, TheFirstPageIsSavedAndTakenFromThenOn) {
  rig("");
  Json made = body_of(rig_->get("/api/pages"));
  ASSERT_EQ(made["pages"].size(), 1u);
  const Json& elements = made["pages"][0]["elements"];
  ASSERT_EQ(elements.size(), 2u) << "there is an address: the heading and Start";
  EXPECT_EQ(elements[1]["kind"], "switch");
  EXPECT_EQ(elements[1]["variable"], "Start");
  made["pages"][0]["elements"][1]["kind"] = "lamp";
  const Json saved = {{"version", ""}, {"pages", made["pages"]}};
  EXPECT_EQ(outcome(rig_->post("/api/pages/save", saved, "engineer")), "200");
  EXPECT_EQ(body_of(rig_->get("/api/pages"))["made"], false);
  EXPECT_EQ(written("Start", true), "P7777 values") << "from now on the file says what is offered";
  struct stat status {};
  ASSERT_EQ(::stat((scratch_.file("pages.toml")).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0644u);
}

TEST_F(Hmi, SomebodyElsesChangeIsNotLost) {
  rig(kPages);
  const Json pages = body_of(rig_->get("/api/pages"));
  write(std::string(kPages) + "\n# by hand\n");
  const Json saved = {{"version", pages["version"]}, {"pages", Json::array()}};
  EXPECT_EQ(outcome(rig_->post("/api/pages/save", saved, "engineer")), "P7778 version");
  EXPECT_EQ(file(), std::string(kPages) + "\n# by hand\n");
  std::filesystem::remove(scratch_.file("pages.toml"));
  EXPECT_EQ(outcome(rig_->post("/api/pages/save", saved, "engineer")), "P7778 version");
}

TEST_F(Hmi, WrongPagesAreNotSaved) {
  rig(kPages);
  const Json pages = body_of(rig_->get("/api/pages"));
  const auto save = [&](auto change) {
    Json saved = {{"version", pages["version"]}, {"pages", pages["pages"]}};
    change(saved["pages"][0]);
    return outcome(rig_->post("/api/pages/save", saved, "engineer"));
  };
  EXPECT_EQ(save([](Json& page) { page["elements"][0]["kind"] = "lever"; }), "P7771 pages[0].elements[0].kind");
  EXPECT_EQ(save([](Json& page) { page["elements"][0]["unit"] = 5; }), "P7714 pages[0].elements[0].unit");
  EXPECT_EQ(save([](Json& page) { page["elements"][0]["seconds"] = 5; }), "P7771 pages[0].elements[0].seconds");
  EXPECT_EQ(save([](Json& page) { page["elements"][0]["x"] = 20; }), "P7774 pages[0].elements[0]");
  EXPECT_EQ(save([](Json& page) { page["elements"][4]["x"] = 24; }), "P7774 pages[0].elements[4].x");
  EXPECT_EQ(save([](Json& page) { page["elements"][0]["low"] = 20; }), "P7772 pages[0].elements[0].high");
  EXPECT_EQ(save([](Json& page) { page["elements"][1].erase("variable"); }), "P7773 pages[0].elements[1]");
  EXPECT_EQ(save([](Json& page) { page["name"] = "no name"; }), "P7772 pages[0].name");
  EXPECT_EQ(file(), kPages);
  // A comment is a comment, whatever is in it.
  EXPECT_EQ(save([](Json& page) { page["comment"] = {" a\nname = \"b\""}; }), "200");
  EXPECT_NE(file().find("# a name = \"b\"\n"), std::string::npos) << file();
}

TEST_F(Hmi, CallsAnswerAsTheirRowsSay) {
  for (const char* const path : {"/api/pages/press", "/api/pages/save"}) {
    rig(std::string(path).ends_with("press") ? kButton : "");
    if (std::string(path).ends_with("save")) std::filesystem::remove(scratch_.file("pages.toml"));
    rig_->hmi.read();
    const engineering::Call* const call = engineering::find_call(path);
    ASSERT_NE(call, nullptr) << path;
    const HttpResponse answer = rig_->post(path, Json::parse(call->example), "engineer");
    ASSERT_EQ(answer.status, 200) << answer.body;
    const auto wrong = engineering::wrong_fields(body_of(answer), call->response);
    EXPECT_FALSE(wrong) << wrong->field << " " << wrong->text << "\n" << answer.body;
  }
}

TEST_F(Hmi, LimitsOfDurationsAreSeconds) {
  rig("[[page]]\nname = \"panel\"\n[[page.element]]\nkind = \"slider\"\nx = 0\ny = 0\nvariable = \"Wait\"\n"
      "low = 0.5\nhigh = 10\n");
  EXPECT_EQ(written("Wait", "T#500ms"), "200");
  EXPECT_EQ(written("Wait", "T#10s"), "200");
  EXPECT_EQ(written("Wait", "T#10s1ms"), "P7777 values");
  EXPECT_EQ(written("Wait", "T#499ms"), "P7777 values");
}

TEST_F(Hmi, APressIsSeenByAScan) {
  rig(kButton);
  EXPECT_EQ(outcome(press("Start", true)), "200");
  EXPECT_EQ(outcome(press("Start", false)), "200");
  EXPECT_EQ(start(), "1") << "released at once, and seen by no scan yet";
  wait_ms(500);
  EXPECT_EQ(start(), "1");
  rig_->scan();
  wait_ms(500);
  EXPECT_EQ(start(), "1") << "the first scan that ended may have begun before";
  rig_->scan();
  wait_ms(100);
  EXPECT_EQ(start(), "0");
  std::string audited;
  for (const std::string& record : rig_->audit.recent(3)) audited += record;
  EXPECT_NE(audited.find("pages.press"), std::string::npos);
}

TEST_F(Hmi, AButtonIsHeldAsLongAsSomebodySaysSo) {
  rig(kButton);
  press("Start", true);
  for (int i = 0; i < 5; ++i) {
    rig_->scan();
    wait_ms(2000);
    EXPECT_EQ(start(), "1");
    EXPECT_EQ(body_of(press("%IX0.0", true))["held"], true);
  }
  // Two hold it: the last one who lets go counts.
  press("Start", true, "engineer");
  press("Start", false);
  rig_->scan();
  rig_->scan();
  wait_ms(100);
  EXPECT_EQ(start(), "1");
  press("Start", false, "engineer");
  wait_ms(100);
  EXPECT_EQ(start(), "0");
  // A browser that has gone holds nothing.
  press("Start", true);
  rig_->scan();
  rig_->scan();
  wait_ms(2900);
  EXPECT_EQ(start(), "1");
  wait_ms(200);
  EXPECT_EQ(start(), "0");
}

TEST_F(Hmi, WhatComesLatePressesNothing) {
  rig(kButton);
  const auto say = [&](const Json& more) {
    Json body = {{"path", "Start"}, {"pressed", true}};
    body.update(more);
    return body_of(rig_->post("/api/pages/press", body, "operator"))["held"].get<bool>();
  };
  // A line that stood still: the lease has run out, then the renewals of before come.
  EXPECT_FALSE(say({{"renews", true}})) << "nobody holds it";
  EXPECT_EQ(start(), "0");
  EXPECT_TRUE(say(Json::object()));
  EXPECT_TRUE(say({{"renews", true}}));
  rig_->scan();
  rig_->scan();
  wait_ms(3100);
  EXPECT_EQ(start(), "0");
  EXPECT_FALSE(say({{"renews", true}}));
  EXPECT_EQ(start(), "0");
  const std::int64_t now_ms = rig_->calendar.utc_ns() / 1'000'000;
  EXPECT_FALSE(say({{"until_ms", now_ms - 1}}));
  EXPECT_EQ(start(), "0");
  EXPECT_TRUE(say({{"until_ms", now_ms + 1}}));
  EXPECT_EQ(start(), "1");
}

TEST_F(Hmi, WhatComesLateWritesNothing) {
  rig(kPages);
  const auto say = [&](std::int64_t after_ms, const std::string& role = "operator") {
    const std::int64_t until_ms = rig_->calendar.utc_ns() / 1'000'000 + after_ms;
    const HttpResponse answer = rig_->post(
        "/api/values/write", {{"values", {{{"path", "Start"}, {"value", true}}}}, {"until_ms", until_ms}}, role);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return body_of(answer)["written"].get<int>();
  };
  const std::size_t audited = rig_->audit.recent(100).size();
  EXPECT_EQ(say(-1), 0);
  EXPECT_EQ(say(-3'600'000, "engineer"), 0);
  EXPECT_EQ(start(), "0");
  EXPECT_EQ(rig_->audit.recent(100).size(), audited) << "nothing was done";
  EXPECT_EQ(say(0), 1);
  EXPECT_EQ(start(), "1");
  EXPECT_EQ(rig_->audit.recent(100).size(), audited + 1);
  // What may not be is refused, late or not; and it is a whole number.
  const auto refused = [&](const Json& until) {
    return outcome(
        rig_->post("/api/values/write", {{"values", {{{"path", "Long"}, {"value", "1"}}}}, {"until_ms", until}}));
  };
  EXPECT_EQ(refused(0), "P7777 values");
  EXPECT_EQ(refused("soon"), "P7714 until_ms");
  EXPECT_EQ(refused(1.5), "P7714 until_ms");
}

TEST_F(Hmi, OnlyButtonsAreHeld) {
  rig(kButton);
  EXPECT_EQ(outcome(press("Start", true, "viewer")), "P7711 ");
  EXPECT_EQ(outcome(press("Long", true, "engineer")), "P7777 path");
  EXPECT_EQ(outcome(press("Nothing", true)), "P7777 path");
  EXPECT_EQ(outcome(press("Start", false)), "200") << "nobody holds it: nothing happens";
  EXPECT_EQ(written("Start", true), "P7777 values") << "it is held, not written";
  rig(kPages);
  EXPECT_EQ(outcome(press("Start", true)), "P7777 path") << "a switch is no button";
  // Forced, it is not pressed.
  rig(kButton);
  rig_->post("/api/forces/set", {{"path", "Start"}, {"value", false}, {"reason", "trial"}}, "engineer");
  EXPECT_EQ(outcome(press("Start", true)), "P7106 path");
}

TEST_F(Hmi, PicturesComeFromTheFolderAlone) {
  rig(kPages);
  const std::string png = "\x89PNG\r\n\x1a\nrest";
  write(png, "plant.png");
  write("<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "plant.svg");
  write("no picture", "wrong.png");
  write("secret", "plc.toml");
  write(std::string(5'000'001, '\x89'), "large.png");
  std::filesystem::create_symlink("/etc/passwd", scratch_.file("link.svg"));
  std::filesystem::create_directory(scratch_.file("folder.svg"));
  const auto get = [&](const std::string& file) { return rig_->get("/api/pages/picture?file=" + file); };
  const HttpResponse picture = get("plant.png");
  EXPECT_EQ(picture.status, 200);
  EXPECT_EQ(picture.content_type, "image/png");
  EXPECT_EQ(picture.body, png);
  EXPECT_EQ(picture.file_name, "") << "shown, not saved";
  EXPECT_TRUE(picture.is_picture);
  EXPECT_EQ(get("plant.svg").content_type, "image/svg+xml");
  for (const char* file : {"wrong.png", "plc.toml", "large.png", "link.svg", "folder.svg", "none.png", "..%2Fplant.png",
                           "%2Fetc%2Fpasswd", ".png", "plant.png%00.svg"}) {
    EXPECT_EQ(outcome(get(file)), "P7780 file") << file;
  }
  EXPECT_EQ(rig_->get("/api/pages/picture?file=plant.png", "").status, 401);
}

}  // namespace
}  // namespace plc::test
