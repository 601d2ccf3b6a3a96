// LOG_MSG: when it tells what, and that it waits for nobody.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

struct Message {
  picard::Instance block{signals_library(), "LOG_MSG", std::chrono::milliseconds(1)};

  explicit Message(std::string_view text, std::int32_t severity = 0) {
    block.port<picard::Text<159>>("TEXT") = text;
    block.port<std::int32_t>("SEVERITY") = severity;
    block.ready();
  }
  void fire(bool execute) {
    block.port<bool>("EXECUTE") = execute;
    block.fire();
  }
  std::string told() {
    fire(true);
    fire(false);
    return block.told().back().text;
  }
};

TEST(LogMsg, TellsAtRisingEdges) {
  Message message("door open", 1);
  const bool inputs[] = {true, true, false, false, true, false, true, true};
  const std::uint32_t counts[] = {1, 1, 1, 1, 2, 2, 3, 3};
  for (std::size_t i = 0; i < std::size(inputs); ++i) {
    message.fire(inputs[i]);
    EXPECT_EQ(message.block.port<std::uint32_t>("COUNT"), counts[i]) << i;
    EXPECT_EQ(message.block.port<bool>("DONE"), inputs[i]) << i;
  }
  const auto told = message.block.told();
  ASSERT_EQ(told.size(), 3u);
  for (const picard::Told& one : told) {
    EXPECT_EQ(one.text, "door open");
    EXPECT_EQ(one.severity, picard::Severity::Warning);
  }
}

TEST(LogMsg, HasThreeSeverities) {
  const std::pair<std::int32_t, picard::Severity> expected[] = {{-7, picard::Severity::Note},
                                                                {0, picard::Severity::Note},
                                                                {1, picard::Severity::Warning},
                                                                {2, picard::Severity::Error},
                                                                {99, picard::Severity::Error}};
  for (const auto& [number, severity] : expected) {
    Message message("x", number);
    message.fire(true);
    EXPECT_EQ(message.block.told().back().severity, severity) << number;
  }
}

TEST(LogMsg, FillsInItsValues) {
  Message message("{1} of {2} bar, {3}{4} {5} {0} {x} {1");
  message.block.port<double>("VALUE1") = 3;
  message.block.port<double>("VALUE2") = 0.1 + 0.2;
  message.block.port<double>("VALUE3") = -123456789;
  message.block.port<double>("VALUE4") = 1e-9;
  EXPECT_EQ(message.told(), "3 of 0.3 bar, -1234567891e-09 {5} {0} {x} {1");
  message.block.port<double>("VALUE1") = std::numeric_limits<double>::quiet_NaN();
  message.block.port<double>("VALUE2") = -std::numeric_limits<double>::infinity();
  message.block.port<double>("VALUE3") = 1e15;
  message.block.port<double>("VALUE4") = -0.0;
  EXPECT_EQ(message.told(), "nan of -inf bar, 1e+150 {5} {0} {x} {1");
}

TEST(LogMsg, CutsWhatIsTooLong) {
  const std::string most(150, 'a');
  Message message(fmt::format("{}{}", most, "{1}{1}{1}{1}"));
  message.block.port<double>("VALUE1") = 12345;
  EXPECT_EQ(message.told(), fmt::format("{}123451234", most));
  EXPECT_EQ(Message(std::string("a\0b", 3)).told(), "a b");
  EXPECT_EQ(Message("").told(), "");
  EXPECT_EQ(Message("100 % done, %s %n").told(), "100 % done, %s %n") << "no format of printf";
}

TEST(LogMsg, AllocatesNothing) {
  Message message("level {1} {2} {3} {4}");
  message.block.port<double>("VALUE1") = std::numeric_limits<double>::max();
  message.block.port<double>("VALUE2") = 1.0 / 3;
  message.block.port<double>("VALUE3") = std::numeric_limits<double>::denorm_min();
  message.fire(true);
  const auto before = test::allocations();
  message.fire(false);
  message.fire(true);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace plc::blocks
