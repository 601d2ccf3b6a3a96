// Calibration files: what is written is read again; whatever is wrong is P7607 at its place. The built-in one is whole.
#include "io-drivers/config/calibration.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "stdlib/library.h"

namespace plc::test {
namespace {

using io::read_calibration;
using runtime::Cost;
using runtime::CostKind;
using runtime::CostTable;

TEST(Calibration, TheTypicalMachineHasEverything) {
  const CostTable& costs = io::typical_costs();
  EXPECT_FALSE(costs.machine.empty());
  EXPECT_EQ(costs.functions.size(), stdlib::overloads().size());
  EXPECT_EQ(costs.blocks.size(), stdlib::blocks().size());
  for (const CostKind kind :
       {CostKind::kMove, CostKind::kCompute, CostKind::kRecord, CostKind::kScan, CostKind::kRelease}) {
    EXPECT_GT(costs[kind].first, 0) << runtime::info(kind).key;
  }
  for (std::size_t k = 0; k < runtime::kCostKinds; ++k) EXPECT_GE(costs.kinds[k].first, costs.kinds[k].again);
}

TEST(Calibration, IsReadAsItWasWritten) {
  CostTable costs = io::typical_costs();
  costs.machine = "this one";
  costs[CostKind::kMove] = {12.345, 1.25};
  costs.functions["SIN:REAL"] = 17.5;
  costs.blocks["TON"] = 4.5;
  core::Diagnostics diagnostics;
  const auto again = read_calibration(io::calibration_text(costs), "machine.toml", diagnostics);
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(diagnostics.all().empty());
  EXPECT_EQ(again->machine, "this one");
  EXPECT_EQ((*again)[CostKind::kMove], (Cost{12.345, 1.25}));
  EXPECT_EQ(again->functions.at("SIN:REAL"), 17.5);
  EXPECT_EQ(again->blocks.at("TON"), 4.5);
}

/// The messages for the typical file with `from` replaced by `to`.
std::string messages(const std::string& from, const std::string& to) {
  std::string text(io::typical_calibration());
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, text.find('\n', at) - at, to);
  core::Diagnostics diagnostics;
  EXPECT_FALSE(read_calibration(text, "machine.toml", diagnostics).has_value());
  std::ostringstream out;
  diagnostics.render(out);
  return out.str();
}

TEST(Calibration, WhatIsWrongIsToldWithItsPlace) {
  EXPECT_EQ(messages("machine", "").find("machine.toml: error P7607: \"machine\" is missing"), 0u);
  const std::string number = messages("move ", "move = [\"fast\", 1]");
  EXPECT_NE(number.find("error P7607: \"move\" is no time"), std::string::npos) << number;
  EXPECT_EQ(number.find("machine.toml:8:9:"), 0u) << number;
  EXPECT_NE(messages("move ", "move = [-1.0, 1.0]").find("\"move\" is no time"), std::string::npos);
  EXPECT_NE(messages("move ", "move = [nan, 1.0]").find("\"move\" is no time"), std::string::npos);
  EXPECT_NE(messages("move ", "move = 1.0").find("\"move\" is not two times"), std::string::npos);
  EXPECT_NE(messages("move ", "moves = [1.0, 1.0]").find("\"moves\" is no cost"), std::string::npos);
  EXPECT_NE(messages("move ", "").find("\"move\" is not two times"), std::string::npos);
  EXPECT_NE(messages("\"SIN:REAL\"", "").find("\"SIN:REAL\" is missing: the file is from another version"),
            std::string::npos);
  EXPECT_NE(messages("[blocks]", "[others]").find("[blocks] is missing"), std::string::npos);
  EXPECT_NE(messages("move ", "move = [1.0, ").find("error P7607"), std::string::npos);
  EXPECT_NE(messages("move ", "a" + std::string(1000, '.') + "b = 1").find("error P7607"), std::string::npos);
}

TEST(Calibration, AFileThatIsNotThere) {
  core::Diagnostics diagnostics;
  core::SourceRef at;
  at.file = diagnostics.add_file("plc.toml");
  at.line = 3;
  EXPECT_FALSE(io::load_calibration("/nowhere/machine.toml", at, diagnostics).has_value());
  ASSERT_EQ(diagnostics.all().size(), 1u);
  EXPECT_EQ(diagnostics.all()[0].code, core::Code::P7607);
  EXPECT_EQ(diagnostics.all()[0].at.line, 3u);
}

}  // namespace
}  // namespace plc::test
