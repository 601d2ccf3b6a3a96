// plc explain --flow: who owns, writes and reads each global, and the drawing.
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/golden.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

std::string example() { return (source_root() / "docs/guides/flow.st").string(); }

ToolResult flow_of(const std::string& file, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {PLC_TOOL, "explain", file, "--flow"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_tool(arguments);
}

/// What --flow prints for `text`, with blanks run together so that cells can be looked for.
std::string tables_of(const std::string& text, std::vector<std::string> more = {}) {
  const ScratchFolder scratch;
  write_text(scratch.file("plant.st"), text);
  const ToolResult result = flow_of(scratch.file("plant.st"), std::move(more));
  EXPECT_EQ(result.code, 0) << result.err;
  return std::regex_replace(result.out, std::regex(" +"), " ");
}

bool has(const std::string& tables, const std::string& line) {
  return tables.find("\n" + line + "\n") != std::string::npos;
}

/// The drawing of `file`.
std::string svg_of(const std::string& file) {
  const ScratchFolder scratch;
  const std::string path = scratch.file("flow.svg");
  const ToolResult result = flow_of(file, {"--svg", path});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  return read_text(path);
}

/// Programs Fast and Slow with these bodies, in tasks of 10 ms and 100 ms, and the globals.
std::string two_tasks(const std::string& globals, const std::string& fast, const std::string& slow) {
  std::string names, text;
  const std::regex name(R"((\w+)( AT [%\w.]+)? : \w+)");
  for (std::sregex_iterator it(globals.begin(), globals.end(), name), end; it != end; ++it) {
    names += (*it)[1].str() + " : INT; ";
  }
  for (const auto& [pou, body] : {std::pair{"Fast", fast}, std::pair{"Slow", slow}}) {
    text += std::string("PROGRAM ") + pou + " VAR_EXTERNAL " + names + "END_VAR " + body + " END_PROGRAM\n";
  }
  return text + "CONFIGURATION C VAR_GLOBAL " + globals +
         " END_VAR RESOURCE R ON PLC\n"
         "TASK TFast(INTERVAL := T#10ms, PRIORITY := 3); TASK TSlow(INTERVAL := T#100ms, PRIORITY := 5);\n"
         "PROGRAM fast WITH TFast : Fast; PROGRAM slow WITH TSlow : Slow; END_RESOURCE END_CONFIGURATION\n";
}

TEST(Flow, TablesOfTheExample) {
  const ToolResult result = flow_of(example());
  EXPECT_EQ(result.code, 0) << result.err;
  expect_golden("tests/golden/flow.txt", result.out);
}

TEST(Flow, ThePictureOfTheGuideIsWhatTheCommandDraws) {
  const std::string svg = svg_of(example());
  expect_golden("docs/guides/flow.svg", svg);
  EXPECT_EQ(svg_of(example()), svg) << "equal inputs, equal output";
}

TEST(Flow, AnImageShowsTheSameAsItsProject) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("flow.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", example(), "-o", image}).code, 0);
  EXPECT_EQ(flow_of(image).out, flow_of(example()).out);
  EXPECT_EQ(svg_of(image), svg_of(example()));
}

TEST(Flow, AgeIsTheSumOfTheIntervals) {
  const std::string tables =
      tables_of(two_tasks("X : INT; In AT %IW0 : INT; Out AT %QW0 : INT; Set : INT;", "X := In;", "Out := X + Set;"));
  EXPECT_TRUE(has(tables, "TFast TSlow 1 2 110ms")) << tables;
  EXPECT_TRUE(has(tables, "devices TFast 1 2 10ms")) << tables;
  EXPECT_TRUE(has(tables, "TSlow devices 1 2 100ms")) << tables;
  EXPECT_TRUE(has(tables, "outside TSlow 1 2 100ms")) << tables;
}

TEST(Flow, OwnersAndUsers) {
  const std::string tables =
      tables_of(two_tasks("X : INT; In AT %IW0 : INT; Out AT %QW0 : INT; Set : INT; Idle : INT; Both : INT;",
                          "X := In; Both := 1;", "Out := X + Set; Both := 2;"));
  EXPECT_TRUE(has(tables, "X INT - TFast TFast TSlow")) << tables;
  EXPECT_TRUE(has(tables, "In INT %IW0 devices devices TFast")) << tables;
  EXPECT_TRUE(has(tables, "Out INT %QW0 TSlow TSlow devices")) << tables;
  EXPECT_TRUE(has(tables, "Set INT - outside - TSlow")) << tables;
  EXPECT_TRUE(has(tables, "Idle INT - outside - -")) << tables;
  EXPECT_TRUE(has(tables, "Both INT - shared TFast, TSlow -")) << tables;
}

TEST(Flow, AQueueGoesFromThoseWhoPutToTheOneWhoTakes) {
  const std::string tables = tables_of(
      "PROGRAM Fast VAR ok : BOOL; END_VAR ok := QUEUE_PUT(Q, 1); END_PROGRAM\n"
      "PROGRAM Slow VAR ok : BOOL; n : INT; END_VAR ok := QUEUE_GET(Q, OUT => n); END_PROGRAM\n"
      "CONFIGURATION C VAR_GLOBAL Q : ARRAY [0..7] OF INT; END_VAR RESOURCE R ON PLC "
      "TASK TFast(INTERVAL := T#10ms, PRIORITY := 0); TASK TSlow(INTERVAL := T#100ms, PRIORITY := 1); "
      "PROGRAM fast WITH TFast : Fast; PROGRAM slow WITH TSlow : Slow; END_RESOURCE END_CONFIGURATION\n");
  EXPECT_TRUE(has(tables, "Q queue [8] of INT - queue TFast TSlow")) << tables;
  EXPECT_TRUE(has(tables, "TFast TSlow 1 2 110ms")) << tables;
}

TEST(Flow, AmongSeveralWritersThoseRead) {
  // Of a word without interest in the value, of one that counts on from what the other left.
  const std::string text = two_tasks("X : INT;", "X := 5;", "X := X + 1;");
  const std::string tables = tables_of(text);
  EXPECT_TRUE(has(tables, "X INT - shared TFast, TSlow TSlow")) << tables;
  EXPECT_TRUE(has(tables, "TFast TSlow 1 2 110ms")) << tables;
  EXPECT_FALSE(has(tables, "TSlow TFast 1 2 110ms")) << tables;
}

TEST(Flow, APartOfAnArrayIsTheWholeVariable) {
  const std::string text = two_tasks("A : ARRAY[1..4] OF INT; I : INT;", "A[2] := 1; I := 3;", "I := A[I];");
  const std::string tables = tables_of(std::regex_replace(text, std::regex("A : INT;"), "A : ARRAY[1..4] OF INT;"));
  EXPECT_TRUE(has(tables, "A ARRAY[1..4] OF INT - TFast TFast TSlow")) << tables;
  EXPECT_TRUE(has(tables, "I INT - shared TFast, TSlow TSlow")) << tables;
  EXPECT_TRUE(has(tables, "TFast TSlow 2 10 110ms")) << tables;
}

TEST(Flow, CeilingsAreThoseOfTheProtocolThatHasThem) {
  const std::string text =
      two_tasks("X : INT; Y : INT; Both : INT; Set : INT;", "X := Set; Both := 1;", "Y := X; Both := 2;");
  const std::string tables = tables_of(text, {"--coherence=priority-ceiling"});
  EXPECT_TRUE(has(tables, "variable type address owner written by read by ceiling")) << tables;
  EXPECT_TRUE(has(tables, "X INT - TFast TFast TSlow 3")) << tables;
  EXPECT_TRUE(has(tables, "Y INT - TSlow TSlow - 5")) << tables;
  EXPECT_TRUE(has(tables, "Both INT - shared TFast, TSlow - -")) << tables;
  EXPECT_TRUE(has(tables, "Set INT - outside - TFast -")) << tables;
  EXPECT_EQ(tables_of(text).find("ceiling"), std::string::npos);
}

TEST(Flow, AnEventTaskReadsItsEvent) {
  const std::string tables = tables_of(
      "PROGRAM P VAR_EXTERNAL Go : BOOL; END_VAR Go := NOT Go; END_PROGRAM\n"
      "PROGRAM P2 VAR n : INT; END_VAR n := n + 1; END_PROGRAM\n"
      "PROGRAM Q VAR_EXTERNAL Again : BOOL; END_VAR Again := FALSE; END_PROGRAM\n"
      "CONFIGURATION C VAR_GLOBAL Go, Again : BOOL; END_VAR RESOURCE R ON PLC\n"
      "TASK Beat(INTERVAL := T#10ms); TASK Act(SINGLE := Go); TASK Own(SINGLE := Again);\n"
      "PROGRAM p WITH Beat : P; PROGRAM q WITH Act : P2; PROGRAM r WITH Own : Q; END_RESOURCE END_CONFIGURATION\n");
  EXPECT_TRUE(has(tables, "Go BOOL - Beat Beat Act")) << tables;
  EXPECT_TRUE(has(tables, "Beat Act 1 1 -")) << tables;
  EXPECT_TRUE(has(tables, "Act on Go 0")) << tables;
  EXPECT_TRUE(has(tables, "Again BOOL - Own Own -")) << "nothing flows from a task to itself\n" << tables;
}

TEST(Flow, NamesAreNoMarkup) {
  const ScratchFolder scratch;
  std::string project = small_project();
  const std::string name = "name=\"small\"";
  project.replace(project.find(name), name.size(), "name=\"a&lt;b&gt; &amp; &quot;\xc3\xa4\xe6\xb0\xb4\"");
  write_text(scratch.file("small.xml"), project);
  const std::string svg = svg_of(scratch.file("small.xml"));
  EXPECT_NE(svg.find("a&lt;b&gt; &amp; &quot;\xc3\xa4\xe6\xb0\xb4"), std::string::npos) << svg;
}

TEST(Flow, LongNamesAreCutAndManyAreCounted) {
  std::string globals, fast, slow = "Sum := 0";
  for (int i = 0; i < 9; ++i) {
    const std::string name = "AVeryLongNameOfAVariableThatSaysEverything" + std::to_string(i);
    globals += name + " : INT; ";
    fast += name + " := 1; ";
    slow += " + " + name;
  }
  const ScratchFolder scratch;
  write_text(scratch.file("many.st"), two_tasks(globals + "Sum : INT;", fast + " Sum := 1;", slow + ";"));
  const std::string svg = svg_of(scratch.file("many.st"));
  EXPECT_NE(svg.find(">9 variables</text>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("\nAVeryLongNameOfAVariableThatSaysEverything8 : INT</title>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("class=\"name shared\""), std::string::npos) << "Sum has two writers";
  write_text(scratch.file("few.st"), two_tasks(globals, "AVeryLongNameOfAVariableThatSaysEverything1 := 1;",
                                               "AVeryLongNameOfAVariableThatSaysEverything2 := "
                                               "AVeryLongNameOfAVariableThatSaysEverything1;"));
  EXPECT_NE(svg_of(scratch.file("few.st")).find(">AVeryLongNameOfA..sEverything1</text>"), std::string::npos);
}

TEST(Flow, WrongUsesAreTold) {
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", example(), "Motion", "--flow"}).code, 2);
  EXPECT_EQ(flow_of("nowhere.st").code, 2);
  const ScratchFolder scratch;
  const std::string own = scratch.file("plant.st");
  write_text(own, two_tasks("X : INT;", "X := 1;", ""));
  EXPECT_EQ(flow_of(own, {"--svg", own}).code, 2);
  EXPECT_EQ(read_text(own), two_tasks("X : INT;", "X := 1;", "")) << "a source is never overwritten";
  const ToolResult unwritable = flow_of(example(), {"--svg", "/nowhere/flow.svg"});
  EXPECT_EQ(unwritable.code, 2);
  EXPECT_NE(unwritable.err.find("/nowhere/flow.svg cannot be written"), std::string::npos) << unwritable.err;
}

}  // namespace
}  // namespace plc::test
