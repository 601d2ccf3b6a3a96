// What declarations given as text become: edges, connections of instances, VAR_CONFIG, wrong constants.
#include <gtest/gtest.h>

#include <algorithm>

#include "declare/declare.h"
#include "declare/extended_structures.h"
#include "tests/unit/frontend-st/reading.h"

namespace plc::st {
namespace {

struct Declared : Reading {
  std::unique_ptr<ir::Module> module;
  explicit Declared(std::string_view text) : Reading(text), module(declare(*project, {}, diagnostics)) {}
};

TEST(DeclareText, EdgeInputsAreReadThroughTheirTrigger) {
  const Declared d("FUNCTION_BLOCK F VAR_INPUT up : BOOL R_EDGE; down : BOOL F_EDGE; END_VAR END_FUNCTION_BLOCK");
  ASSERT_EQ(d.diagnostics.error_count(), 0u) << d.rendered();
  const ir::Pou& pou = d.module->pous.at(0);
  ASSERT_EQ(pou.edges.count(pou.by_name.at("up")), 1u);
  EXPECT_EQ(pou.variables[pou.edges.at(pou.by_name.at("up"))].type, ir::kBoolType);
  EXPECT_EQ(pou.edges.size(), 2u);
  const auto runs = std::count_if(pou.body.insts.begin(), pou.body.insts.end(),
                                  [](const ir::Inst& inst) { return inst.op == ir::Op::kRun; });
  EXPECT_EQ(runs, 2);
  EXPECT_EQ(Declared("FUNCTION F : INT VAR_INPUT up : BOOL R_EDGE; END_VAR END_FUNCTION").places(),
            (Places{"1:28 P4046"}));
  EXPECT_EQ(Declared("FUNCTION_BLOCK F VAR_INPUT up : INT R_EDGE; END_VAR END_FUNCTION_BLOCK").places().front(),
            "1:28 P4046");
}

constexpr std::string_view kFiller = R"(VAR_GLOBAL speed : INT := 4; wrong : REAL; END_VAR
FUNCTION_BLOCK Inner VAR k : INT; END_VAR END_FUNCTION_BLOCK
PROGRAM Filler
VAR_INPUT Speed, Mode : INT; END_VAR VAR_OUTPUT Full : BOOL; END_VAR VAR valve AT %Q* : BOOL; i : Inner; END_VAR
END_PROGRAM
)";

TEST(DeclareText, ConnectionsOfProgramInstances) {
  const Declared d(std::string(kFiller) +
                   "CONFIGURATION C TASK t (INTERVAL := T#1s);\n"
                   "PROGRAM p WITH t : Filler (Speed := speed, Mode := 1 + 2, Full => %QX0.0); END_CONFIGURATION");
  ASSERT_EQ(d.diagnostics.error_count(), 0u) << d.rendered();
  const ir::ProgramInstance& p = d.module->tasks.at(0).programs.at(0);
  ASSERT_EQ(p.wires.size(), 2u);
  EXPECT_EQ(d.module->globals[p.wires[0].global].variable.name, "speed");
  EXPECT_TRUE(p.wires[1].output);
  EXPECT_EQ(d.module->globals[p.wires[1].global].variable.address, "%QX0.0");
  ASSERT_EQ(p.initial.size(), 1u);
  EXPECT_EQ(p.initial[0].value.bits, 3u);
  const Declared bad(std::string(kFiller) +
                     "CONFIGURATION C TASK t (INTERVAL := T#1s);\n"
                     "PROGRAM p WITH t : Filler (Speed := wrong, Nix := 1, Full => nothing, Mode := 'x');\n"
                     "END_CONFIGURATION");
  EXPECT_EQ(bad.places(), (Places{"7:37 P4048", "7:44 P4048", "7:62 P4048", "7:79 P4048"})) << bad.rendered();
}

TEST(DeclareText, VarConfigGivesAddressesAndInitialValues) {
  const std::string head = std::string(kFiller) + "CONFIGURATION C RESOURCE R ON X TASK t (INTERVAL := T#1s);\n" +
                           "PROGRAM p WITH t : Filler; END_RESOURCE\nVAR_CONFIG ";
  const Declared d(head + "R.p.valve AT %QX3.0 : BOOL := TRUE; p.i.k : INT := 7; END_VAR END_CONFIGURATION");
  ASSERT_EQ(d.diagnostics.error_count(), 0u) << d.rendered();
  const ir::Global& valve = d.module->globals[d.module->global_by_name.at("p.valve")];
  EXPECT_EQ(valve.variable.address, "%QX3.0");
  const ir::ProgramInstance& p = d.module->tasks.at(0).programs.at(0);
  ASSERT_EQ(p.located.size(), 1u);
  EXPECT_TRUE(p.located[0].output);
  EXPECT_TRUE(p.located[0].begins);
  EXPECT_EQ(d.module->globals[p.located[0].global].variable.name, "p.valve");
  ASSERT_EQ(p.initial.size(), 2u);
  EXPECT_EQ(p.initial[0].path, p.located[0].path);
  EXPECT_EQ(p.initial[0].value.bits, 1u);
  EXPECT_EQ(p.initial[1].value.bits, 7u);
  EXPECT_EQ(p.initial[1].path.size(), 2u);
  EXPECT_EQ(Declared(head + "R.q.valve AT %QX3.0 : BOOL; R.p.none AT %QX3.0 : BOOL; R.p.Full AT %QX3.0 : BOOL;"
                            " END_VAR END_CONFIGURATION")
                .places()
                .size(),
            3u);
}

TEST(DeclareText, PlacesOfWrongConstantsAreExact) {
  const Declared d(
      "TYPE\n"
      "  A : ARRAY [0..1, 0..M] OF INT;\n"      // 2:23
      "  S : STRING[M];\n"                      // 3:14
      "  E : INT (a := 1, b := M);\n"           // 4:25
      "  V : ARRAY [0..1] OF INT := [1, M];\n"  // 5:34
      "END_TYPE");
  EXPECT_EQ(d.places(), (Places{"2:23 P4034", "3:14 P4034", "4:25 P4034", "5:34 P4034"})) << d.rendered();
}

/// Structures that extend others are joined first.
struct Joined : Reading {
  std::unique_ptr<ir::Module> module;
  explicit Joined(std::string_view text, std::size_t limit = kMaxJoined) : Reading(text) {
    join_extended_structures(*project, limit);
    module = declare(*project, {}, diagnostics);
  }
};

TEST(DeclareText, LongChainsOfStructures) {
  constexpr int kLength = 20'000;
  std::string text = "TYPE\n";
  for (int i = 0; i < kLength; ++i) {
    text += "T" + std::to_string(i) + " EXTENDS " +
            (i + 1 == kLength ? std::string("Missing") : "T" + std::to_string(i + 1)) + " : STRUCT END_STRUCT\n";
  }
  const Joined unknown(text + "END_TYPE");
  EXPECT_GT(unknown.diagnostics.error_count(), 1u) << "too deep to be followed, and one is unknown";
  const Joined known(text + "Missing : STRUCT a : INT; END_STRUCT\nEND_TYPE");
  EXPECT_EQ(known.diagnostics.error_count(), 0u) << known.rendered().substr(0, 500);
  EXPECT_EQ(known.module->types[*known.module->types.find("T0")].fields.size(), 1u);
}

TEST(DeclareText, WhatExtendedStructuresMayGet) {
  // A copy of Base is its member and two members of that; one of Other a member, a dimension and three values.
  const std::string text =
      "TYPE Base : STRUCT s : STRUCT x, y : INT; END_STRUCT; END_STRUCT\n"
      "Other : STRUCT a : ARRAY [0..2] OF INT := [1, 2, 3]; END_STRUCT\n"
      "A EXTENDS Base : STRUCT END_STRUCT\n"
      "B EXTENDS Other : STRUCT END_STRUCT\n"
      "C EXTENDS A : STRUCT END_STRUCT END_TYPE";
  const auto errors = [&](std::size_t limit) { return Joined(text, limit).diagnostics.error_count(); };
  EXPECT_EQ(errors(kMaxJoined), 0u);
  EXPECT_EQ(errors(3 + 5 + 3), 0u) << Joined(text, 11).rendered();
  EXPECT_EQ(errors(3 + 5 + 2), 1u);
  EXPECT_EQ(errors(2), 2u) << "what extends a structure that is refused is not refused once more";
}

}  // namespace
}  // namespace plc::st
