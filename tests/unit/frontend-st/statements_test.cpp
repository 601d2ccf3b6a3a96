#include "tests/unit/frontend-st/fixture.h"

namespace plc::st::test {
namespace {

using core::Code;

struct StatementsTest : ::testing::Test {
  World world;
  void SetUp() override {
    world.project.pous.push_back(
        pou("Scale", plcopen::PouKind::kFunctionBlock,
            {variable("IN", named("INT"), Section::kInput), variable("ACC", named("INT"), Section::kInOut),
             variable("OUT", named("INT"), Section::kOutput), variable("inner", named("INT"))}));
    world.project.pous.push_back(
        pou("Split", plcopen::PouKind::kFunction,
            {variable("IN", named("INT"), Section::kInput), variable("HI", named("INT"), Section::kOutput)}));
    world.project.pous.back().return_type = named("INT");
    world.program("Main", {variable("a", named("INT")), variable("b", named("INT")), variable("c", named("INT")),
                           variable("x", named("BOOL")), variable("y", named("BOOL")), variable("T1", named("TON")),
                           variable("S1", named("Scale")), variable("d", named("DINT")), variable("w", named("DWORD")),
                           constant("cTwo", "INT", "2"), variable("arr", array_of(named("INT"), {{"0", "2"}}))});
    world.declare_cleanly();
  }
  static plcopen::Variable constant(std::string name, std::string type, std::string value) {
    plcopen::Variable v = variable(std::move(name), named(std::move(type)), Section::kLocal, simple(std::move(value)));
    v.constant = true;
    return v;
  }
  bool lower(std::string_view text) {
    ir::Builder b(*world.module, 2, world.diagnostics);
    return lower_statements(text, at_line(10, 5), b);
  }
  std::map<std::string, std::uint64_t> run(std::string_view text, std::map<std::string, std::uint64_t> cells = {}) {
    world.module->pous[2].body = {};
    EXPECT_TRUE(lower(text)) << text << "\n" << world.rendered();
    Machine machine(*world.module, world.module->pous[2]);
    machine.cells = std::move(cells);
    machine.run();
    runs = machine.runs;
    return machine.cells;
  }
  std::vector<std::string> runs;
};

TEST_F(StatementsTest, Assignments) {
  const auto cells = run("a := 5; b := a + 1;\n; (* empty *) c := -b");
  EXPECT_EQ(cells.at("a"), 5u);
  EXPECT_EQ(cells.at("b"), 6u);
  EXPECT_EQ(cells.at("c"), 0xfffau);
}

TEST_F(StatementsTest, ElementsByVariableIndex) { EXPECT_EQ(run("arr[a + 1] := 9;", {{"a", 1}}).at("arr[2]"), 9u); }

TEST_F(StatementsTest, FunctionsOfSeveralOutputs) {
  const auto cells = run("SPLIT_DATE(D#2024-02-29, a, b, c);");
  EXPECT_EQ(cells.at("a"), 2024u);
  EXPECT_EQ(cells.at("b"), 2u);
  EXPECT_EQ(cells.at("c"), 29u);
  const auto some = run("split_tod(IN := TOD#01:02:03, SECOND => d, ENO => x);");
  EXPECT_EQ(some.at("d"), 3u);
  EXPECT_EQ(some.at("x"), 1u);
  const auto skipped = run("SPLIT_DATE(EN := y, IN := D#2024-02-29, YEAR => a, ENO => x);", {{"a", 7}, {"x", 1}});
  EXPECT_EQ(skipped.at("a"), 7u);
  EXPECT_EQ(skipped.at("x"), 0u);
}

TEST_F(StatementsTest, FunctionsOfSeveralOutputsAreRefusedWhereTheyDoNotFit) {
  const std::pair<const char*, Code> cases[] = {
      {"a := SPLIT_DATE(D#2024-02-29);", Code::P4009},
      {"SPLIT_DATE(YEAR => a);", Code::P4106},
      {"SPLIT_DATE(T#1s, a);", Code::P4101},
      {"SPLIT_DATE(IN := D#2024-02-29, HOUR => a);", Code::P4010},
      {"SPLIT_DATE(IN := D#2024-02-29, YEAR := a);", Code::P4010},
      {"SPLIT_DATE(IN := D#2024-02-29, YEAR => a, YEAR => b);", Code::P4010},
      {"SPLIT_DATE(D#2024-02-29, a, b, c, d);", Code::P4010},
      {"SPLIT_DATES(D#2024-02-29);", Code::P4009},
  };
  for (const auto& [text, code] : cases) {
    world.diagnostics = {};
    EXPECT_FALSE(lower(text)) << text;
    ASSERT_EQ(world.diagnostics.error_count(), 1u) << text << "\n" << world.rendered();
    EXPECT_EQ(world.diagnostics.all().front().code, code) << text << "\n" << world.rendered();
  }
  EXPECT_NE(world.diagnostics.all().front().help.find("SPLIT_DATE"), std::string::npos);
}

TEST_F(StatementsTest, IfChainsTakeOneBranch) {
  const std::string_view text =
      "IF a > 10 THEN b := 1; ELSIF a > 5 THEN b := 2; ELSIF a > 3 THEN b := 3; ELSE b := 4; END_IF; c := 1;";
  for (const auto& [a, b] : std::map<std::uint64_t, std::uint64_t>{{11, 1}, {6, 2}, {4, 3}, {0, 4}}) {
    const auto cells = run(text, {{"a", a}});
    EXPECT_EQ(cells.at("b"), b);
    EXPECT_EQ(cells.at("c"), 1u);
  }
}

TEST_F(StatementsTest, NestedIfAndReturn) {
  const std::string_view text = "IF x THEN IF y THEN RETURN; END_IF; a := 1; END_IF a := a + 10;";
  EXPECT_EQ(run(text, {{"x", 1}}).at("a"), 11u);  // many tools take END_IF without a semicolon
  const std::string_view good = "if x then if y then return; end_if; a := 1; end_if; a := a + 10;";
  EXPECT_EQ(run(good, {{"x", 1}, {"y", 0}}).at("a"), 11u);
  EXPECT_EQ(run(good, {{"x", 1}, {"y", 1}, {"a", 3}}).at("a"), 3u);
  EXPECT_EQ(run(good, {{"x", 0}, {"a", 3}}).at("a"), 13u);
}

TEST_F(StatementsTest, BlockCalls) {
  const auto cells = run("T1(IN := x, PT := T#2s, Q => y);", {{"x", 1}});
  ASSERT_EQ(runs, std::vector<std::string>{"T1"});
  EXPECT_EQ(cells.count("y"), 1u);
  std::size_t durations = 0;
  for (const auto& [path, bits] : cells) durations += bits == 2'000'000'000u ? 1u : 0u;
  EXPECT_EQ(durations, 1u);
  EXPECT_EQ(run("S1(IN := 3, ACC := b, OUT => c);").at("S1.0"), 3u);
}

TEST_F(StatementsTest, SkippedBlockCallRunsNothing) {
  run("T1(EN := x, IN := TRUE, PT := T#1s);", {{"x", 0}});
  EXPECT_TRUE(runs.empty());
}

TEST_F(StatementsTest, FunctionCallsWithOutputs) {
  EXPECT_TRUE(lower("a := Split(IN := b, HI => d);")) << world.rendered();
  EXPECT_TRUE(lower("Split(b);")) << world.rendered();
  EXPECT_FALSE(lower("a := Split(IN := b, HI => x);"));
  EXPECT_EQ(world.count(Code::P4101), 1u) << world.rendered();
}

TEST_F(StatementsTest, WrongCalls) {
  EXPECT_FALSE(lower("T1(INN := x);"));
  EXPECT_FALSE(lower("T1(IN => x);"));
  EXPECT_FALSE(lower("S1(IN := 1, ACC := d);"));
  EXPECT_FALSE(lower("T1(IN := x, x);"));
  EXPECT_EQ(world.count(Code::P4010), 4u) << world.rendered();
  EXPECT_FALSE(lower("a(1);"));
  EXPECT_FALSE(lower("TON(IN := x);"));
  EXPECT_FALSE(lower("nothing(1);"));
  EXPECT_EQ(world.count(Code::P4009), 3u) << world.rendered();
  EXPECT_FALSE(lower("S1.inner := 3;"));
  EXPECT_EQ(world.count(Code::P4005), 1u) << world.rendered();
}

TEST_F(StatementsTest, EveryIndependentErrorOnceAndTheRestIsLowered) {
  EXPECT_FALSE(lower("a := ;\nb := wrong1;\nIF wrong2 THEN c := wrong3; END_IF;\na = 5;\nx := 5 + ;\nb := 2;"));
  EXPECT_EQ(world.diagnostics.error_count(), 6u) << world.rendered();
  std::vector<std::uint32_t> lines;
  for (const auto& d : world.diagnostics.all()) {
    if (d.severity == core::Severity::kError) lines.push_back(d.at.line);
  }
  std::sort(lines.begin(), lines.end());
  EXPECT_EQ(lines, (std::vector<std::uint32_t>{10, 11, 12, 12, 13, 14}));
}

TEST_F(StatementsTest, PlacesOfErrors) {
  EXPECT_FALSE(lower("a := 1;\n  b := nope;"));
  const core::Diagnostic* d = world.first(Code::P4004);
  ASSERT_NE(d, nullptr);
  EXPECT_EQ(d->at.line, 11u);
  EXPECT_EQ(d->at.column, 8u);
  EXPECT_FALSE(lower("nope := 1;"));
  EXPECT_EQ(world.diagnostics.all().back().at.line, 10u);
  EXPECT_EQ(world.diagnostics.all().back().at.column, 5u);
}

TEST_F(StatementsTest, ForCountsUpAndDown) {
  const auto up = run("b := 0; FOR a := 1 TO 5 DO b := b + a; END_FOR;");
  EXPECT_EQ(up.at("b"), 15u);
  EXPECT_EQ(up.at("a"), 6u);
  const auto down = run("b := 0; FOR a := 5 TO 1 BY -2 DO b := b * 10 + a; END_FOR");
  EXPECT_EQ(down.at("b"), 531u);
  EXPECT_EQ(down.at("a"), 0xffffu);
  EXPECT_EQ(run("b := 7; FOR a := 5 TO 1 DO b := 0; END_FOR;").at("b"), 7u);
  EXPECT_EQ(run("b := 0; FOR a := 1 TO c BY 4 DO b := b + 1; END_FOR;", {{"c", 13}}).at("b"), 4u);
  EXPECT_EQ(run("b := 0; FOR a := 1 TO c BY 4 DO b := b + 1; END_FOR;", {{"c", 12}}).at("b"), 3u);
}

TEST_F(StatementsTest, ForEndsAtTheLimitsOfItsType) {
  EXPECT_EQ(run("b := 0; FOR a := 32766 TO 32767 DO b := b + 1; END_FOR;").at("b"), 2u);
  EXPECT_EQ(run("b := 0; FOR a := -32767 TO -32768 BY -1 DO b := b + 1; END_FOR;").at("b"), 2u);
  EXPECT_EQ(run("b := 0; FOR a := 30000 TO c BY 5000 DO b := b + 1; END_FOR;", {{"c", 32767}}).at("b"), 1u);
  EXPECT_EQ(run("b := 0; FOR a := -32768 TO c BY 5000 DO b := b + 1; END_FOR;", {{"c", 0x8000}}).at("b"), 1u);
  EXPECT_EQ(run("b := 0; FOR a := 32000 TO 32767 BY c DO b := b + 1; END_FOR;", {{"c", 500}}).at("b"), 2u);
}

TEST_F(StatementsTest, ForWithAStepThatIsKnownWhenItRuns) {
  EXPECT_EQ(run("b := 0; FOR a := 1 TO 7 BY c DO b := b * 10 + a; END_FOR;", {{"c", 3}}).at("b"), 147u);
  EXPECT_EQ(run("b := 0; FOR a := 7 TO 1 BY c DO b := b * 10 + a; END_FOR;", {{"c", 0xfffd}}).at("b"), 741u);
  EXPECT_EQ(run("b := 0; FOR a := 1 TO 7 BY c DO b := b * 10 + a; END_FOR;", {{"c", 0xfffd}}).at("b"), 0u);
}

TEST_F(StatementsTest, TheBoundsOfForAreComputedOnce) {
  const auto cells = run("c := 3; b := 0; FOR a := 1 TO c DO c := 100; b := b + 1; END_FOR;");
  EXPECT_EQ(cells.at("b"), 3u);
}

TEST_F(StatementsTest, WhileAndRepeat) {
  EXPECT_EQ(run("a := 10; b := 0; WHILE a > 3 DO a := a - 2; b := b + 1; END_WHILE;").at("b"), 4u);
  EXPECT_EQ(run("b := 0; WHILE FALSE DO b := 1; END_WHILE;").at("b"), 0u);
  EXPECT_EQ(run("a := 10; b := 0; REPEAT a := a - 2; b := b + 1; UNTIL a <= 3 END_REPEAT;").at("b"), 4u);
  EXPECT_EQ(run("b := 0; REPEAT b := b + 1; UNTIL TRUE; END_REPEAT").at("b"), 1u);
}

TEST_F(StatementsTest, ExitAndContinueMeanTheInnermostLoop) {
  const auto cells =
      run("d := 0; FOR a := 1 TO 3 DO FOR b := 1 TO 10 DO IF b = 2 THEN CONTINUE; END_IF;"
          " IF b > 4 THEN EXIT; END_IF; d := d + 1; END_FOR; END_FOR;");
  EXPECT_EQ(cells.at("d"), 9u);
  EXPECT_EQ(run("a := 0; b := 0; WHILE TRUE DO a := a + 1; IF a > 5 THEN EXIT; END_IF; IF a = 2 THEN CONTINUE; END_IF;"
                " b := b + a; END_WHILE;")
                .at("b"),
            13u);
  EXPECT_EQ(run("a := 0; REPEAT a := a + 1; IF a < 4 THEN CONTINUE; END_IF; EXIT; UNTIL a > 9 END_REPEAT;").at("a"),
            4u);
}

TEST_F(StatementsTest, CaseTakesTheFirstBranchThatFits) {
  const std::string_view text =
      "CASE a OF 1: b := 10; 2, 3: b := 20; -5..-3, 7..9: b := 30; 11: ; ELSE b := 99; END_CASE; c := 1;";
  const std::map<std::uint64_t, std::uint64_t> expected{{1, 10},      {2, 20},      {3, 20},      {0xfffb, 30},
                                                        {0xfffd, 30}, {0xfffa, 99}, {0xfffe, 99}, {7, 30},
                                                        {9, 30},      {10, 99},     {11, 5}};
  for (const auto& [a, b] : expected) {
    const auto cells = run(text, {{"a", a}, {"b", 5}});
    EXPECT_EQ(cells.at("b"), b) << a;
    EXPECT_EQ(cells.at("c"), 1u);
  }
  EXPECT_EQ(run("CASE a + 1 OF 4: CASE b OF 1: c := 1; ELSE c := 2; END_CASE 5: c := 3; END_CASE", {{"a", 3}}).at("c"),
            2u);
}

TEST(Case, OfEnumerationsByNumber) {
  World w;
  w.project.data_types = {data_type("Color", enumeration({{"Red", ""}, {"Green", "5"}}))};
  w.program("P", {variable("e", named("Color")), variable("n", named("INT"))});
  ir::Builder b(w.declare_cleanly(), 0, w.diagnostics);
  EXPECT_TRUE(lower_statements("CASE e OF 0: n := 1; 5..6: n := 2; END_CASE", at_line(1), b)) << w.rendered();
  EXPECT_FALSE(lower_statements("CASE e OF 100000: n := 1; END_CASE", at_line(2), b));
}

TEST_F(StatementsTest, CaseLabelsAreConstantAndUnique) {
  EXPECT_FALSE(lower("CASE a OF b: c := 1; END_CASE;"));
  EXPECT_FALSE(lower("CASE a OF 5..1: c := 1; END_CASE;"));
  EXPECT_EQ(world.count(Code::P4070), 2u) << world.rendered();
  EXPECT_TRUE(lower("CASE a OF 1..5: c := 1; 3: c := 2; 4..6: c := 3; END_CASE;"));
  EXPECT_EQ(world.count(Code::P4072), 1u) << world.rendered();
  EXPECT_FALSE(lower("CASE a OF 100000: c := 1; TRUE: c := 2; END_CASE;"));
  EXPECT_EQ(world.diagnostics.error_count(), 4u) << world.rendered();
}

TEST_F(StatementsTest, ForRefusesWhatCannotCount) {
  EXPECT_FALSE(lower("FOR x := 1 TO 3 DO a := nope; END_FOR;"));
  EXPECT_EQ(world.count(Code::P4071), 1u);
  EXPECT_EQ(world.count(Code::P4004), 1u) << world.rendered();
  EXPECT_FALSE(lower("FOR a := 1 TO 3 BY 0 DO b := 1; END_FOR;"));
  EXPECT_EQ(world.count(Code::P4071), 2u);
  EXPECT_FALSE(lower("FOR a := 1 TO 100000 DO b := 1; END_FOR; FOR a := 1 TO 3 BY 40000 DO b := 1; END_FOR;"));
  EXPECT_EQ(world.count(Code::P4107), 2u) << world.rendered();
}

TEST_F(StatementsTest, ErrorsInHeadsDoNotHideTheRest) {
  EXPECT_FALSE(
      lower("FOR a = 1 TO 3 DO b := nope1; END_FOR; WHILE a > DO b := nope2; END_WHILE; CASE OF 1: b := nope3;"
            " END_CASE; REPEAT b := nope4; UNTIL END_REPEAT; b := nope5;"));
  EXPECT_EQ(world.count(Code::P4001), 4u) << world.rendered();
  EXPECT_EQ(world.count(Code::P4004), 5u) << world.rendered();
  EXPECT_EQ(world.diagnostics.error_count(), 9u) << world.rendered();
}

TEST_F(StatementsTest, PartsAreWritten) {
  EXPECT_EQ(run("w.3 := x; w.%X0 := TRUE; w.%B1 := 16#AB; w.%W1 := 16#1234;", {{"x", 1}}).at("w"), 0x1234ab09u);
  EXPECT_EQ(run("w.3 := x;", {{"w", 0xffffffff}}).at("w"), 0xfffffff7u);
  EXPECT_EQ(run("arr[a].0 := TRUE; b := arr[a];", {{"a", 1}, {"arr[1]", 4}}).at("b"), 5u);
  EXPECT_EQ(run("T1(IN := x, PT := T#1s, Q => w.31);", {{"x", 1}, {"w", 0xffffffff}}).at("w"), 0x7fffffffu);
  EXPECT_FALSE(lower("w.32 := x;"));
  EXPECT_FALSE(lower("w.%B4 := 1;"));
  EXPECT_FALSE(lower("w.%D0 := 1;"));
  EXPECT_EQ(world.count(Code::P4008), 3u) << world.rendered();
  EXPECT_FALSE(lower("S1(IN := 1, ACC := w.%W0);"));
  EXPECT_EQ(world.count(Code::P4010), 1u) << world.rendered();
}

TEST_F(StatementsTest, ConstantsAreKnown) {
  EXPECT_EQ(run("CASE a OF cTwo: b := 1; cTwo + 1: b := 2; END_CASE;", {{"a", 3}}).at("b"), 2u);
  EXPECT_EQ(run("arr[cTwo] := 7;").at("arr[2]"), 7u);
  EXPECT_FALSE(lower("cTwo := 3;"));
  EXPECT_FALSE(lower("b := arr[cTwo + 1];"));
  EXPECT_EQ(world.count(Code::P4008), 1u) << world.rendered();
}

TEST_F(StatementsTest, InOutsAreGivenInEveryCall) {
  EXPECT_FALSE(lower("S1(IN := 3);"));
  EXPECT_EQ(world.count(Code::P4010), 1u) << world.rendered();
}

TEST_F(StatementsTest, ShortCircuit) {
  const std::string_view text = "x := a <> 0 AND_THEN 10 / a > 4; y := a = 0 OR_ELSE 10 / a > 4;";
  const auto zero = run(text, {{"a", 0}});
  EXPECT_EQ(zero.at("x"), 0u);
  EXPECT_EQ(zero.at("y"), 1u);
  const auto two = run(text, {{"a", 2}});
  EXPECT_EQ(two.at("x"), 1u);
  EXPECT_EQ(two.at("y"), 1u);
  EXPECT_EQ(run(text, {{"a", 5}}).at("y"), 0u);
}

TEST_F(StatementsTest, StrayAndMissingKeywords) {
  EXPECT_FALSE(lower("IF x THEN a := 1;"));
  EXPECT_EQ(world.diagnostics.error_count(), 1u) << world.rendered();
  EXPECT_FALSE(lower("END_IF; a := 1;"));
  EXPECT_EQ(world.diagnostics.error_count(), 2u) << world.rendered();
  EXPECT_FALSE(lower("IF x a := 1; END_IF; b := nope;"));
  EXPECT_EQ(world.diagnostics.error_count(), 4u) << world.rendered();
}

TEST_F(StatementsTest, MissingEndsNameTheStatementThatIsOpen) {
  const auto errors_of = [this](std::string_view text) {
    const std::size_t before = world.diagnostics.all().size();
    EXPECT_FALSE(lower(text)) << text;
    std::vector<core::Diagnostic> errors;
    for (std::size_t i = before; i < world.diagnostics.all().size(); ++i) {
      const core::Diagnostic& one = world.diagnostics.all()[i];
      if (one.severity == core::Severity::kError) errors.push_back(one);
    }
    return errors;
  };
  const auto loop = errors_of("FOR a := 1 TO 3 DO\n  IF x THEN\n    b := 1;\nEND_FOR;\nc := nope;");
  ASSERT_EQ(loop.size(), 2u) << world.rendered();
  EXPECT_EQ(loop[0].at.line, 13u);
  EXPECT_NE(loop[0].message.find("END_IF"), std::string::npos) << loop[0].message;
  EXPECT_EQ(loop[0].help, "the IF of line 11 is open: write END_IF where it ends");
  // The label of the next branch ends what the branch before left open, and its statements are read.
  const auto branch = errors_of("CASE a OF\n1: IF x THEN\n     b := 1;\n2, 3: c := nope;\nELSE c := 2;\nEND_CASE;");
  ASSERT_EQ(branch.size(), 2u) << world.rendered();
  EXPECT_EQ(branch[0].at.line, 13u);
  EXPECT_EQ(branch[0].help, "the IF of line 11 is open: write END_IF where it ends");
  EXPECT_NE(branch[1].message.find("nope"), std::string::npos) << branch[1].message;
  EXPECT_TRUE(lower("CASE a OF 1: IF x THEN b := 1; ELSE b := 2; END_IF; 2: WHILE x DO EXIT; END_WHILE; END_CASE;"))
      << world.rendered();
}

TEST_F(StatementsTest, OperatorsOfOtherLanguagesAreNamed) {
  const auto help = [this](const std::string& text) {
    const auto before = static_cast<std::ptrdiff_t>(world.diagnostics.all().size());
    EXPECT_FALSE(lower(text)) << text;
    const auto& all = world.diagnostics.all();
    const auto first = std::find_if(all.begin() + before, all.end(),
                                    [](const core::Diagnostic& d) { return d.severity == core::Severity::kError; });
    return first == all.end() ? std::string() : first->help;
  };
  const std::pair<const char*, const char*> cases[] = {
      {"IF a == b THEN c := 1; END_IF;", "\"equal\" is written ="},
      {"IF a != b THEN c := 1; END_IF;", "\"not equal\" is written <>"},
      {"IF x && y THEN c := 1; END_IF;", "\"and\" is written AND"},
      {"IF x || y THEN c := 1; END_IF;", "\"or\" is written OR"},
      {"IF x&&!y THEN c := 1; END_IF;", "\"and\" is written AND"},
      {"IF !x THEN c := 1; END_IF;", "\"not\" is written NOT"},
      {"IF a := b THEN c := 1; END_IF;", ":= assigns"},
      {"IF (a := b) THEN c := 1; END_IF;", ":= assigns"},
      {"WHILE a =< b DO c := 1; END_WHILE;", "<="},
      {"IF a => b THEN c := 1; END_IF;", ">="},
      {"c := a % b;", "MOD"},
      {"c := a%2;", "MOD"},
      {"x := y || x;", "\"or\" is written OR"},
      {"a++;", ":= a + 1"},
      {"a += 2;", ":= a + "},
      {"c := a << 2;", "SHL"},
      {"c := x ? a : b;", "SEL"},
  };
  for (const auto& [text, part] : cases)
    EXPECT_NE(help(text).find(part), std::string::npos) << text << ": " << help(text);
  EXPECT_EQ(help("c := a %IX0.0;").find("MOD"), std::string::npos);
}

TEST_F(StatementsTest, FunctionsAreGuessedByTheTypesInTheirNames) {
  const auto help = [this](const std::string& text) {
    EXPECT_FALSE(lower(text)) << text;
    return world.diagnostics.all().back().help;
  };
  EXPECT_EQ(help("a := INT_TO_STR(a);"), "did you mean \"INT_TO_STRING\"?");
  EXPECT_EQ(help("a := FLOAT_TO_INT(a);"), "did you mean \"REAL_TO_INT\"?");
  EXPECT_EQ(help("a := TO_STRNG(a);"), "did you mean \"TO_STRING\"?");
  EXPECT_EQ(help("a := LIMTI(a);"), "did you mean \"LIMIT\"?");
}

TEST_F(StatementsTest, FunctionsOfOtherToolsAreNamed) {
  const auto help = [this](const std::string& text) {
    EXPECT_FALSE(lower(text)) << text;
    return world.diagnostics.all().back().help;
  };
  EXPECT_NE(help("a := POW(a, 2);").find("EXPT(base, exponent)"), std::string::npos);
  EXPECT_NE(help("INC(a);").find("x := x + 1"), std::string::npos);
  EXPECT_NE(help("memcpy(a, b, 2);").find("as a whole"), std::string::npos);
  EXPECT_NE(help("x := RE(x);").find("R_TRIG"), std::string::npos);
}

TEST_F(StatementsTest, WritesThatAreNotAllowed) {
  EXPECT_FALSE(lower("T1.Q := TRUE;"));
  EXPECT_EQ(world.count(Code::P4007), 1u);
  EXPECT_FALSE(lower("x := a;"));
  EXPECT_FALSE(lower("a := 100000;"));
  EXPECT_EQ(world.count(Code::P4101) + world.count(Code::P4107), 2u) << world.rendered();
}

TEST_F(StatementsTest, DeepIfsAreAnError) {
  std::string text;
  for (int i = 0; i < 20'000; ++i) text += "IF x THEN ";
  EXPECT_FALSE(lower(text));
  EXPECT_GE(world.count(Code::P4002), 1u);
  EXPECT_LE(world.diagnostics.error_count(), 1000u);
}

TEST_F(StatementsTest, EmptyTextIsNothing) {
  EXPECT_TRUE(lower(""));
  EXPECT_TRUE(lower("  // only a comment"));
  EXPECT_TRUE(world.module->pous[2].body.insts.empty());
}

}  // namespace
}  // namespace plc::st::test
