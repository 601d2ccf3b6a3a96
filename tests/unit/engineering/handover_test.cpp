// What a start of another program leaves to the process that follows: sessions, the port, forces that are kept.
#include "engineering/handover.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engineering/engineering.h"
#include "engineering/kept_forces.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::Engineering;
using engineering::Sessions;

class Handover : public testing::Test {
 protected:
  [[nodiscard]] std::string folder() const { return scratch_.file("engineering"); }
  /// A server of its own, on any port of this machine.
  std::unique_ptr<Engineering> server() {
    engineering::Options options;
    options.port = 0;
    options.folder = folder();
    return std::make_unique<Engineering>(options, rig.identity, *rig.resource, rig.values, rig.forces, rig.scheduler,
                                         rig.log, rig.clock, rig.calendar);
  }
  static Json sessions_of(const Engineering& server) { return Json::parse(server.handover())["sessions"]; }
  /// What is kept for a warm start.
  std::size_t kept() {
    EngineeringRig other;
    EXPECT_TRUE(engineering::force_again(folder(), 0, other.clock.now_ns(), other.forces).empty());
    return other.forces.size();
  }
  void keep_a_force() {
    std::filesystem::create_directories(folder());
    ASSERT_EQ(engineering::store_kept_forces(folder(), {{"Total", "1", "anna", "trial", 0, {}, true}}), "");
  }

  EngineeringRig rig;

 private:
  ScratchFolder scratch_;
};

TEST_F(Handover, SessionsOfWhoIsGoneOrHasAnotherRoleEnd) {
  {
    std::filesystem::create_directories(folder());
    const auto users = std::move(*engineering::Users::open(folder()));
    const std::string hash = engineering::hash_password("a password", rig.context.cost);
    ASSERT_FALSE(users->add(engineering::User{"anna", Right::kAdmin, hash}));
    ASSERT_FALSE(users->add(engineering::User{"ben", Right::kViewer, hash}));
  }
  Sessions before;
  const core::TimeNs now = rig.clock.now_ns();
  before.begin("anna", Right::kAdmin, "127.0.0.1", now);
  before.begin("ben", Right::kEngineer, "127.0.0.1", now);
  before.begin("carl", Right::kViewer, "127.0.0.1", now);
  const auto next = server();
  next->take_over(engineering::handover_text(before, 0));
  next->start();
  const Json stay = sessions_of(*next);
  ASSERT_EQ(stay.size(), 1u) << stay;
  EXPECT_EQ(stay[0]["user"], "anna");
}

TEST_F(Handover, OfAServerThatDiesHasNobodyWhoIsGone) {
  const auto now = server();
  std::string latest;
  now->on_sessions([&latest](std::string handover) { latest = std::move(handover); });
  Sessions before;
  before.begin("anna", Right::kAdmin, "127.0.0.1", rig.clock.now_ns());
  now->take_over(engineering::handover_text(before, 0));
  EXPECT_EQ(latest, "");
  now->start();  // there is no such user
  EXPECT_EQ(Json::parse(latest)["sessions"].size(), 0u);
}

TEST_F(Handover, HasThePortAlsoAfterTheServerHasStopped) {
  const auto now = server();
  now->start();
  const std::uint16_t port = now->port();
  ASSERT_NE(port, 0);
  now->stop();
  EXPECT_EQ(Json::parse(now->handover())["port"], port);
}

TEST_F(Handover, AColdStartOnTrialForgetsForcesWhenItIsConfirmed) {
  keep_a_force();
  {
    const auto tried = server();
    EXPECT_EQ(tried->force_again(false, true).size(), 1u) << "it says what is not forced any more";
    tried->start();
    tried->service(rig.clock.now_ns());
    tried->stop();
  }
  EXPECT_EQ(kept(), 1u) << "the program before has it";
  {
    const auto tried = server();
    EXPECT_EQ(tried->force_again(false, true).size(), 1u) << "it says what is not forced any more";
    tried->start();
    tried->confirmed();
    tried->stop();
  }
  EXPECT_EQ(kept(), 0u);
  EXPECT_EQ(rig.forces.size(), 0u);
}

TEST_F(Handover, AColdStartOfWhatRanForgetsForcesAtOnce) {
  keep_a_force();
  const auto said = server()->force_again(false);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].text.find("is not forced any more: it was a cold start"), std::string::npos);
  EXPECT_EQ(kept(), 0u);
}

TEST_F(Handover, TheEndOfTheServerIsOneOfWhatTakesLong) {
  const auto now = server();
  now->set_program(&rig.control);
  now->start();
  EXPECT_FALSE(rig.control.ending);
  now->stop();
  EXPECT_TRUE(rig.control.ending);
}

}  // namespace
}  // namespace plc::test
