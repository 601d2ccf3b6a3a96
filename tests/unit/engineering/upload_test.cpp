// Another program by calls: what is refused, what is kept, what is asked of who runs the plant.
#include <gtest/gtest.h>

#include <string>

#include "engineering/client.h"
#include "engineering/secrets.h"
#include "engineering/signature.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::ProgramControl;

TEST(Upload, IsForEngineers) {
  EngineeringRig rig;
  for (const char* role : {"viewer", "operator"}) {
    EXPECT_EQ(rig.post_file("/api/program/upload", "an image", role).status, 403) << role;
    EXPECT_EQ(rig.post("/api/program/start", Json::object(), role).status, 403) << role;
    EXPECT_EQ(rig.post("/api/program/stop", Json::object(), role).status, 403) << role;
  }
  EXPECT_FALSE(rig.store->waiting());
  EXPECT_EQ(rig.post_file("/api/program/upload", "an image").status, 200);
  EXPECT_EQ(rig.store->waiting()->by, "engineer");
}

TEST(Upload, TakesALargeBodyOfWhoMaySendItAlone) {
  EngineeringRig rig;
  engineering::Dispatcher dispatcher(rig.context, rig.hosts, false);
  HttpRequest head = rig.request("POST", "/api/program/upload?signature=x");
  EXPECT_EQ(dispatcher.most_body_bytes(head), engineering::kMostBodyBytes);
  head.authorization = "Bearer " + rig.session("operator");
  EXPECT_EQ(dispatcher.most_body_bytes(head), engineering::kMostBodyBytes);
  head.authorization = "Bearer " + rig.session("engineer");
  EXPECT_EQ(dispatcher.most_body_bytes(head), engineering::kMostFileBytes);
  head.target = "/api/values/write";
  EXPECT_EQ(dispatcher.most_body_bytes(head), engineering::kMostBodyBytes);
}

TEST(Upload, ClientsWaitUntilItWasChecked) {
  for (const engineering::Call& call : engineering::calls()) {
    EXPECT_EQ(engineering::Client::patience_ms(call) > 60'000, engineering::file_field(call) != nullptr) << call.name;
  }
}

TEST(Upload, IsBytesAndNoJson) {
  EngineeringRig rig;
  EXPECT_EQ(rig.post("/api/program/upload", {{"image", "an image"}}, "engineer").status, 415);
  EXPECT_EQ(rig.post_file("/api/program/upload?image=x", "an image").status, 400);
  EXPECT_FALSE(rig.store->waiting());
}

TEST(Upload, OfAnImageThatCannotRunChangesNothing) {
  EngineeringRig rig;
  rig.check_says = "plant.pbc: error P6003: checksum";
  const HttpResponse refused = rig.post_file("/api/program/upload", "an image");
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(body_of(refused)["code"], "P7750");
  EXPECT_EQ(body_of(refused)["text"], rig.check_says);
  EXPECT_FALSE(rig.store->waiting());
  const Json record = Json::parse(rig.audit.recent(1).at(0));
  EXPECT_EQ(record["what"], "program.upload.failed");
  EXPECT_EQ(record["details"],
            (Json{{"image", engineering::sha256("an image")}, {"code", "P7750"}, {"why", rig.check_says}}));
}

TEST(Upload, MustBeSignedWhereThereAreKeys) {
  EngineeringRig rig;
  const auto anna = engineering::make_key("anna");
  rig.control.wants_signature = true;
  const auto upload = [&](const std::string& signature) {
    return rig.post_file("/api/program/upload" + (signature.empty() ? "" : "?signature=" + signature), "an image");
  };
  const std::string good = engineering::sign(anna, "an image");
  EXPECT_EQ(body_of(upload(good))["code"], "P7751") << "keys that cannot be read are no reason to take everything";
  rig.control.keys = *engineering::read_public_keys(anna.public_line(), "anna.pub");
  for (const std::string& wrong : {std::string(), engineering::sign(anna, "an imagf"),
                                   engineering::sign(engineering::make_key("eve"), "an image")}) {
    const HttpResponse refused = upload(wrong);
    EXPECT_EQ(refused.status, 409);
    EXPECT_EQ(body_of(refused)["code"], "P7751");
    EXPECT_FALSE(rig.store->waiting());
  }
  const HttpResponse taken = upload(good);
  ASSERT_EQ(taken.status, 200) << taken.body;
  EXPECT_EQ(body_of(taken)["signer"], "anna");
}

TEST(Upload, NeedsAFolder) {
  EngineeringRig rig;
  rig.control.store = nullptr;
  EXPECT_EQ(body_of(rig.post_file("/api/program/upload", "an image"))["code"], "P7753");
  EXPECT_EQ(body_of(rig.post("/api/program/start", Json::object(), "engineer"))["code"], "P7753");
}

TEST(Start, IsAWishForWhoRunsThePlant) {
  EngineeringRig rig;
  const core::TimeNs begin = rig.clock.now_ns();
  EXPECT_FALSE(rig.control.take(begin));
  ASSERT_EQ(rig.post_file("/api/program/upload", "an image").status, 200);
  const std::string image = engineering::sha256("an image");
  EXPECT_EQ(rig.post("/api/program/start", {{"image", std::string(64, '0')}}, "engineer").status, 409)
      << "another one waits";
  const HttpResponse started = rig.post("/api/program/start", {{"kind", "cold"}, {"image", image}}, "engineer");
  ASSERT_EQ(started.status, 200) << started.body;
  EXPECT_EQ(body_of(started)["image"], image);
  EXPECT_FALSE(rig.control.take(begin)) << "first the answer";
  const auto wish = rig.control.take(begin + ProgramControl::kAnswerNs);
  ASSERT_TRUE(wish);
  EXPECT_TRUE(wish->start);
  EXPECT_EQ(wish->kind, "cold");
  const auto choice = rig.store->choose(0);
  ASSERT_TRUE(choice && *choice);
  EXPECT_EQ((*choice)->program.image, image);
  EXPECT_TRUE((*choice)->trial);
}

TEST(Start, WithoutAnUploadIsOneOfTheSameProgram) {
  EngineeringRig rig;
  const HttpResponse started = rig.post("/api/program/start", Json::object(), "engineer");
  ASSERT_EQ(started.status, 200) << started.body;
  EXPECT_EQ(body_of(started)["image"], rig.identity.image_hash);
  EXPECT_FALSE(*rig.store->choose(0)) << "what plc-run was given";
}

TEST(Start, OneAtATime) {
  EngineeringRig rig;
  const std::vector<std::byte> runs = bytecode::save(rig.resource->image());
  rig.identity.image_hash = engineering::sha256({reinterpret_cast<const char*>(runs.data()), runs.size()});
  ASSERT_EQ(rig.post("/api/program/stop", Json::object(), "engineer").status, 200);
  ASSERT_EQ(rig.post_file("/api/program/upload", "an image").status, 200);
  EXPECT_EQ(body_of(rig.post("/api/program/start", Json::object(), "engineer"))["code"], "P7755");
  EXPECT_TRUE(rig.store->waiting()) << "it waits as before";
  const auto choice = rig.store->choose(0);
  ASSERT_TRUE(choice);
  EXPECT_FALSE(*choice) << "what runs: what plc-run was given";
  ASSERT_TRUE(rig.control.take(ProgramControl::kAnswerNs + rig.clock.now_ns()));
  rig.control.set_state(ProgramControl::State::kStopped);
  EXPECT_EQ(rig.post("/api/program/stop", Json::object(), "engineer").status, 409) << "it is stopped";
  EXPECT_EQ(body_of(rig.get("/api/target"))["state"], "stopped");
  EXPECT_EQ(rig.post("/api/program/start", Json::object(), "engineer").status, 200);
  rig.control.set_state(ProgramControl::State::kTrial);
  EXPECT_EQ(rig.post("/api/program/stop", Json::object(), "engineer").status, 409);
}

TEST(Start, DuringATrialLeavesTheWayBack) {
  EngineeringRig rig;
  const std::vector<std::byte> saved = bytecode::save(rig.resource->image());
  const std::string old(reinterpret_cast<const char*>(saved.data()), saved.size());
  const std::string hash = engineering::sha256("on trial");
  ASSERT_TRUE(rig.store->put("on trial", "engineer", 0, [](const std::string&) { return std::string(); }));
  ASSERT_FALSE(rig.store->try_next(hash, "warm", {engineering::sha256(old), {}, {}, 0}, old, "given"));
  const auto tried = rig.store->choose(0);
  ASSERT_TRUE(tried && *tried && (*tried)->trial);
  rig.control.running = (*tried)->program;
  rig.control.set_state(ProgramControl::State::kTrial);
  ASSERT_EQ(rig.post_file("/api/program/upload", "another image").status, 200);
  EXPECT_EQ(body_of(rig.post("/api/program/start", Json::object(), "engineer"))["code"], "P7755");
  EXPECT_EQ(rig.store->waiting()->image, engineering::sha256("another image"));
  ASSERT_EQ(rig.store->fail(hash, "R1001: index", 0), "");
  const auto back = rig.store->choose(0);
  ASSERT_TRUE(back && *back) << "the image of the one before is there";
  EXPECT_EQ((*back)->program.image, engineering::sha256(old));
}

TEST(Start, ThatFailsIsInTheAudit) {
  EngineeringRig rig;
  const auto last = [&rig] {
    const Json record = Json::parse(rig.audit.recent(1).at(0));
    return record["user"].get<std::string>() + " " + record["what"].get<std::string>() + " " +
           record["details"].value("code", "");
  };
  rig.control.set_state(ProgramControl::State::kTrial);
  EXPECT_EQ(rig.post("/api/program/start", {{"kind", "cold"}}, "engineer").status, 409);
  EXPECT_EQ(last(), "engineer program.start.failed P7755");
  EXPECT_EQ(Json::parse(rig.audit.recent(1).at(0))["details"]["kind"], "cold");
  EXPECT_EQ(rig.post("/api/program/stop", Json::object(), "engineer").status, 409);
  EXPECT_EQ(last(), "engineer program.stop.failed P7755");
  rig.control.store = nullptr;
  EXPECT_EQ(rig.post_file("/api/program/store-project?name=plant.xml", "<xml/>").status, 409);
  EXPECT_EQ(last(), "engineer program.store_project.failed P7753");
  EXPECT_EQ(rig.post("/api/users/add", {{"user", "ben"}, {"password", "short"}, {"role", "viewer"}}, "admin").status,
            400);
  EXPECT_EQ(last(), "admin users.add.failed P7714");
  EXPECT_EQ(rig.audit.recent(1).at(0).find("short"), std::string::npos) << "no password, not even a wrong one";
  const std::size_t records = rig.audit.recent(100).size();
  EXPECT_EQ(rig.post("/api/program/stop", Json::object(), "viewer").status, 403);
  EXPECT_EQ(rig.post("/api/program/stop", {{"kind", 1}}, "engineer").status, 400);
  EXPECT_EQ(rig.audit.recent(100).size(), records) << "what was no call changes nothing";
}

TEST(Start, EndsWhatTakesLong) {
  EngineeringRig rig;
  ASSERT_EQ(rig.post("/api/program/stop", Json::object(), "engineer").status, 200);
  ASSERT_TRUE(rig.control.take(ProgramControl::kAnswerNs + rig.clock.now_ns()));
  EXPECT_FALSE(rig.control.ending) << "the server goes on";
  ASSERT_EQ(rig.post("/api/program/start", Json::object(), "engineer").status, 200);
  EXPECT_FALSE(rig.control.ending) << "first the answer";
  ASSERT_TRUE(rig.control.take(ProgramControl::kAnswerNs + rig.clock.now_ns()));
  EXPECT_TRUE(rig.control.ending);
  EXPECT_EQ(body_of(rig.post_file("/api/program/upload", "an image"))["code"], "P7755");
  EXPECT_EQ(rig.post("/api/program/start", Json::object(), "engineer").status, 409);
}

TEST(Upload, ThatIsGivenUpSaysNothingAboutTheImage) {
  EngineeringRig rig;
  rig.control.check = [&rig](const std::string&) {
    rig.control.ending = true;
    return std::string("looking at it ended by signal 9");
  };
  EXPECT_EQ(body_of(rig.post_file("/api/program/upload", "an image"))["code"], "P7755");
  EXPECT_FALSE(rig.store->waiting());
}

TEST(Start, IsRefusedWhileTheProgramForbidsIt) {
  EngineeringRig rig;
  engineering::Veto veto(*rig.resource, "Start"), none(*rig.resource, ""), wrong(*rig.resource, "Nothing");
  EXPECT_FALSE(none.holds());
  EXPECT_FALSE(wrong.holds());
  rig.context.no_program = rig.context.no_force = &veto;
  const Json force = {{"path", "Total"}, {"value", 1}, {"reason", "trial"}};
  const auto set = [&](bool value) {
    EXPECT_EQ(rig.post("/api/values/write", {{"values", {{{"path", "Start"}, {"value", value}}}}}).status, 200);
    rig.scan();
  };
  set(true);
  EXPECT_TRUE(veto.holds());
  ASSERT_EQ(rig.post_file("/api/program/upload", "an image").status, 200) << "which changes nothing";
  for (const char* path : {"/api/program/start", "/api/program/stop"})
    EXPECT_EQ(body_of(rig.post(path, Json::object(), "engineer"))["code"], "P7756") << path;
  EXPECT_TRUE(rig.store->waiting());
  EXPECT_EQ(body_of(rig.post("/api/forces/set", force, "engineer"))["code"], "P7756");
  EXPECT_EQ(rig.post("/api/forces/release", Json::object(), "engineer").status, 200);
  set(false);
  EXPECT_EQ(rig.post("/api/forces/set", force, "engineer").status, 200);
  EXPECT_EQ(rig.post("/api/program/start", Json::object(), "engineer").status, 200);
}

TEST(Program, SaysWhatRunsAndWhatWaits) {
  EngineeringRig rig;
  Json body = body_of(rig.get("/api/program"));
  EXPECT_EQ(body["state"], "runs");
  EXPECT_FALSE(body.contains("waits"));
  ASSERT_EQ(rig.post_file("/api/program/upload", "an image").status, 200);
  ASSERT_EQ(rig.post_file("/api/program/store-project?name=plant.xml", "<xml/>").status, 200);
  EXPECT_EQ(rig.post_file("/api/program/store-project?name=..%2Fplant.xml", "<xml/>").status, 400);
  body = body_of(rig.get("/api/program"));
  EXPECT_EQ(body["waits"]["image"], engineering::sha256("an image"));
  EXPECT_EQ(body["waits"]["project"], "plant.xml");
  rig.control.running = *rig.store->waiting();
  EXPECT_EQ(rig.get("/api/program/project", "engineer").body, "<xml/>") << "the one that was stored with what runs";
  EXPECT_EQ(body_of(rig.get("/api/program"))["file"], "plant.xml");
}

}  // namespace
}  // namespace plc::test
