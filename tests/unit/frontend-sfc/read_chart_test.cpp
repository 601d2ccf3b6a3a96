// Charts as they are read: macro steps, and what texts have beyond the standard.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "frontend-sfc/chart.h"

namespace {

using namespace plc;
using core::ElementKind;

plcopen::Body text_body(const std::string& text) {
  plcopen::Body body;
  body.language = plcopen::Language::kSfc;
  body.text = text;
  body.at.line = body.at.column = 1;
  return body;
}

/// Codes of what was reported, separated by blanks.
std::string codes(const core::Diagnostics& diagnostics) {
  std::string all;
  for (const core::Diagnostic& one : diagnostics.all()) {
    all += (all.empty() ? "" : " ") + std::string(core::info(one.code).name);
  }
  return all;
}

TEST(TextOfAChart, TimesAndActionsOfSteps) {
  core::Diagnostics diagnostics;
  diagnostics.add_file("chart.st");
  const sfc::Chart chart = sfc::read_chart(
      text_body("INITIAL_STEP A (MIN := T#1s, MAX := limit): Begin(ENTRY); Pump.Run(MAIN); End(EXIT); v(N); END_STEP\n"
                "STEP B (MAX := T#5s) END_STEP TRANSITION FROM A TO B := TRUE; END_TRANSITION"),
      "Main", diagnostics);
  EXPECT_EQ(codes(diagnostics), "");
  ASSERT_EQ(chart.steps.size(), 2u);
  EXPECT_EQ(chart.steps[0].min_time, "T#1s");
  EXPECT_EQ(chart.steps[0].max_time, "limit");
  EXPECT_EQ(chart.steps[0].entry, "Begin");
  EXPECT_EQ(chart.steps[0].main, "Pump.Run");
  EXPECT_EQ(chart.steps[0].exit, "End");
  ASSERT_EQ(chart.steps[0].actions.size(), 1u);
  EXPECT_EQ(chart.steps[1].max_time, "T#5s");
}

TEST(TextOfAChart, WhatIsWrongWithThem) {
  for (const auto& [text, code] :
       {std::pair("INITIAL_STEP A: x(ENTRY); y(ENTRY); END_STEP", "P3107"),
        std::pair("INITIAL_STEP A (LEAST := T#1s): END_STEP", "P3110"),
        std::pair("INITIAL_STEP A (MIN := ): END_STEP", "P3110"), std::pair("INITIAL_STEP A (MIN := T#1s", "P3110"),
        std::pair("INITIAL_STEP A: x(N, T#1s); END_STEP", "P3107"),
        std::pair("INITIAL_STEP A: END_STEP TRANSITION FROM (A, a) TO A := x; END_TRANSITION", "P3104")}) {
    core::Diagnostics diagnostics;
    diagnostics.add_file("chart.st");
    sfc::read_chart(text_body(text), "Main", diagnostics);
    EXPECT_EQ(codes(diagnostics).substr(0, 5), code) << text;
  }
}

TEST(TextOfAChart, AMissingEndIsSaidWhereTheNextBegins) {
  const char* const last = "TRANSITION FROM B TO A := step; END_TRANSITION";
  for (const auto& [text, missing] :
       {std::pair("INITIAL_STEP A: x(N);\nSTEP B: END_STEP TRANSITION FROM A TO B := TRUE; END_TRANSITION ",
                  "END_STEP"),
        std::pair("INITIAL_STEP A: END_STEP STEP B: END_STEP TRANSITION FROM A TO B := TRUE;\n", "END_TRANSITION")}) {
    SCOPED_TRACE(missing);
    core::Diagnostics diagnostics;
    diagnostics.add_file("chart.st");
    const sfc::Chart chart = sfc::read_chart(text_body(std::string(text) + last), "Main", diagnostics);
    EXPECT_EQ(codes(diagnostics), "P3110");
    EXPECT_NE(diagnostics.all().at(0).message.find(missing), std::string::npos);
    EXPECT_EQ(diagnostics.all().at(0).at.line, 2u);
    EXPECT_EQ(chart.steps.size(), 2u);
  }
}

TEST(TextOfAChart, ListsOfConditionsChooseAndNothingElseDoes) {
  for (const auto& [text, expected] :
       {std::pair("TRANSITION FROM A TO A: LD a {IF defined (X)} AND b {END_IF} ST c END_TRANSITION", ""),
        std::pair("TRANSITION FROM A TO A: {IF defined (X)} LD a {END_IF} ST c END_TRANSITION", "P3110"),
        std::pair("{define X} TRANSITION FROM A TO A := a; END_TRANSITION", "P3110")}) {
    SCOPED_TRACE(text);
    core::Diagnostics diagnostics;
    diagnostics.add_file("chart.st");
    sfc::read_chart(text_body(std::string("INITIAL_STEP A: END_STEP ") + text), "Main", diagnostics);
    EXPECT_EQ(codes(diagnostics), expected);
  }
}

TEST(TextOfAChart, StepAndTransitionAreNamesOfVariables) {
  core::Diagnostics diagnostics;
  diagnostics.add_file("chart.st");
  const sfc::Chart chart = sfc::read_chart(text_body("INITIAL_STEP A: step(N); transition(S); END_STEP\n"
                                                     "TRANSITION FROM A TO A := step AND transition; END_TRANSITION"),
                                           "Main", diagnostics);
  EXPECT_EQ(codes(diagnostics), "");
  ASSERT_EQ(chart.steps.size(), 1u);
  EXPECT_EQ(chart.steps[0].actions.size(), 2u);
  EXPECT_EQ(chart.transitions.size(), 1u);
}

// ---- macro steps ----

/// A drawn chart, element by element.
struct Drawn {
  plcopen::Body body;

  Drawn() { body.language = plcopen::Language::kSfc; }
  plcopen::Element& add(ElementKind kind, std::int64_t id, std::vector<std::int64_t> from,
                        const std::string& text = "") {
    plcopen::Element& e = body.elements.emplace_back();
    e.kind = kind;
    e.text = text;
    e.at.local_id = id;
    e.at.kind = kind;
    e.chart = std::make_shared<plcopen::ChartPart>();
    for (const std::int64_t source : from) {
      plcopen::Pin pin;
      pin.connections.push_back({source, {}, {}, false, {}});
      e.inputs.push_back(pin);
    }
    return e;
  }
  Drawn& step(std::int64_t id, const std::string& name, std::vector<std::int64_t> from = {}, bool initial = false) {
    add(ElementKind::kStep, id, std::move(from), name).chart->initial = initial;
    return *this;
  }
  Drawn& transition(std::int64_t id, std::int64_t from) {
    add(ElementKind::kTransition, id, {from}).chart->text = "c" + std::to_string(id);
    return *this;
  }
  Drawn& jump(std::int64_t id, std::int64_t from, const std::string& to) {
    add(ElementKind::kJumpStep, id, {from}, to);
    return *this;
  }
  Drawn& macro(std::int64_t id, std::int64_t from, const std::string& name, const Drawn& inner) {
    add(ElementKind::kMacroStep, id, {from}, name).chart->macro = std::make_shared<plcopen::Body>(inner.body);
    return *this;
  }
};

/// Idle, M, and back from M to Idle.
Drawn around(const Drawn& inner) {
  return Drawn().step(1, "Idle", {}, true).transition(2, 1).macro(3, 2, "M", inner).transition(4, 3).jump(5, 4, "Idle");
}

sfc::Chart read(const Drawn& drawn, std::string& reported) {
  core::Diagnostics diagnostics;
  diagnostics.add_file("chart.xml");
  sfc::Chart chart = sfc::read_chart(drawn.body, "Main", diagnostics);
  reported = codes(diagnostics);
  return chart;
}

TEST(MacroSteps, AreEnteredAndLeftByTheirChart) {
  std::string reported;
  const Drawn drawn = around(Drawn().step(1, "In").transition(2, 1).step(3, "Out", {2}));
  const sfc::Chart chart = read(drawn, reported);
  EXPECT_EQ(reported, "");
  ASSERT_EQ(chart.steps.size(), 3u);
  EXPECT_EQ(chart.steps[1].name, "In");
  EXPECT_EQ(chart.steps[2].name, "Out");
  ASSERT_EQ(chart.transitions.size(), 3u);
  EXPECT_EQ(chart.transitions[0].targets, std::vector<std::uint32_t>{1});
  EXPECT_EQ(chart.transitions[1].condition.text, "c2");
  EXPECT_EQ(chart.transitions[2].sources, (std::vector<std::vector<std::uint32_t>>{{2}}));
  // The project still has what was drawn.
  EXPECT_EQ(drawn.body.elements[2].kind, ElementKind::kMacroStep);
  EXPECT_EQ(drawn.body.elements[2].chart->macro->elements[0].at.local_id, 1);
}

TEST(MacroSteps, OneStepMayBeEntryAndExit) {
  std::string reported;
  const sfc::Chart chart = read(around(Drawn().step(1, "Only", {}, true)), reported);
  EXPECT_EQ(reported, "");
  ASSERT_EQ(chart.steps.size(), 2u);
  EXPECT_FALSE(chart.steps[1].initial);
}

TEST(MacroSteps, WithoutAChartAnEntryOrAnExit) {
  std::string reported;
  read(around(Drawn()), reported);
  EXPECT_EQ(reported, "P3120") << "empty";
  Drawn none = around(Drawn().step(1, "In"));
  none.body.elements[2].chart->macro = nullptr;
  read(none, reported);
  EXPECT_EQ(reported, "P3120") << "no body";
  read(
      around(Drawn().step(1, "A").step(2, "B").transition(3, 1).step(4, "Out", {3}).transition(5, 2).jump(6, 5, "Out")),
      reported);
  EXPECT_EQ(reported, "P3120") << "two entries";
  read(around(Drawn().step(1, "In").transition(2, 1).jump(3, 2, "In")), reported);
  EXPECT_EQ(reported, "P3120") << "no entry, no exit";
  read(around(Drawn().step(1, "In", {}, true).transition(2, 1).jump(3, 2, "In")), reported);
  EXPECT_EQ(reported, "P3120") << "no exit";
}

TEST(MacroSteps, NamesOfStepsAreThoseOfTheWholeChart) {
  std::string reported;
  read(around(Drawn().step(1, "Idle")), reported);
  EXPECT_EQ(reported, "P3102");
}

}  // namespace
