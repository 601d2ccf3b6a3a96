// plc blocks: what it prints (golden files in blocks/; PLC_GOLDEN_UPDATE=1 rewrites them), its declarations in
// projects, and the drawn example of each block.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "picard/taskblock.h"
#include "taskblocks/registry.h"
#include "testing/table.h"
#include "tests/support/golden.h"
#include "tests/tools/fixture.h"
#include "tools/taskblock_html.h"
#include "tools/taskblock_text.h"
#include "tools/taskblock_xml.h"

namespace plc::test {
using plc::tests::CsvTable;
using plc::tests::read_csv;
using plc::tests::same_value;
namespace {

using nlohmann::json;
using taskblocks::Registry;

const std::vector<Registry::Entry>& blocks() { return Registry::built_in().entries(); }

// ---- text -------------------------------------------------------------------------------------------------------

TEST(Blocks, ExplainsABlock) {
  const auto result = run_tool({PLC_TOOL, "blocks", "LowPass"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_golden("tests/tools/blocks/lowpass.txt", result.out);
}

TEST(Blocks, ListsEverythingInGroups) {
  const auto result = run_tool({PLC_TOOL, "blocks"});
  EXPECT_EQ(result.code, 0);
  for (const Registry::Entry& entry : blocks()) {
    const std::size_t group = result.out.find(std::string(entry.block->group) + "\n");
    EXPECT_NE(group, std::string::npos) << entry.block->group;
    EXPECT_NE(result.out.find(std::string("\n  ") + entry.block->name + " ", group), std::string::npos)
        << entry.block->name;
    EXPECT_NE(result.out.find(entry.block->summary), std::string::npos) << entry.block->name;
  }
}

TEST(Blocks, AnUnknownNameExitsWith1AndTheNearest) {
  const auto result = run_tool({PLC_TOOL, "blocks", "LOWPAS"});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_NE(result.err.find("no taskblock \"LOWPAS\""), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("did you mean \"LOWPASS\"?"), std::string::npos) << result.err;
  EXPECT_NE(run_tool({PLC_TOOL, "blocks", "SEMA"}).err.find("plc lib SEMA"), std::string::npos);
}

TEST(Blocks, WrongFlagsExitWith2) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--json", "--xml"}, {"--st", "--example", "LOWPASS"}, {"--example"}, {"-o", "x"}, {"LOWPASS", "--html", "x"}};
  for (std::vector<std::string> arguments : wrong) {
    arguments.insert(arguments.begin(), {PLC_TOOL, "blocks"});
    EXPECT_EQ(run_tool(arguments).code, 2) << command_line(arguments);
  }
}

TEST(Blocks, PrintsJson) {
  const json all = json::parse(run_tool({PLC_TOOL, "blocks", "--json"}).out);
  EXPECT_EQ(all.at("blocks").size(), blocks().size());
  const json block = json::parse(run_tool({PLC_TOOL, "blocks", "gear", "--json"}).out).at("blocks").at(0);
  EXPECT_EQ(block.at("name"), "GEAR");
  EXPECT_EQ(block.at("group"), "Motion");
  const json& modulo = block.at("ports").at(5);
  EXPECT_EQ(modulo.at("name"), "MODULO");
  EXPECT_EQ(modulo.at("direction"), "configuration");
  EXPECT_EQ(modulo.at("type"), "LREAL");
  EXPECT_EQ(modulo.at("unit"), "u");
  EXPECT_EQ(modulo.at("min"), 0.0);
  EXPECT_TRUE(modulo.at("max").is_null());
  EXPECT_EQ(modulo.at("default"), "0.0");
}

// ---- words ------------------------------------------------------------------------------------------------------

constexpr picard_type kLreal{PICARD_ELEMENTARY, "LREAL", 0, 8, 8, nullptr, nullptr, 0, 0, nullptr};
constexpr picard_type kBool{PICARD_ELEMENTARY, "BOOL", 0, 1, 1, nullptr, nullptr, 0, 0, nullptr};
constexpr picard_type kSint{PICARD_ELEMENTARY, "SINT", 0, 1, 1, nullptr, nullptr, 0, 0, nullptr};
constexpr picard_type kRow{PICARD_ARRAY, "", 4, 32, 8, &kLreal, nullptr, 0, 0, nullptr};
constexpr picard_field kFields[] = {{"X", &kLreal, 0}, {"ROWS", &kRow, 8}};
constexpr picard_type kMove{PICARD_STRUCT_TYPE, "MOVE", 0, 40, 8, nullptr, kFields, 2, 0, nullptr};
constexpr picard_enumerator kModes[] = {{"Off", 0}, {"Manual", 5}};
constexpr picard_type kMode{PICARD_ENUM_TYPE, "MODE", 0, 1, 1, &kSint, nullptr, 0, 2, kModes};
constexpr picard_field kModeFields[] = {{"HOW", &kMode, 0}, {"WHERE_TO", &kLreal, 8}};
constexpr picard_type kPlan{PICARD_STRUCT_TYPE, "PLAN", 0, 16, 8, nullptr, kModeFields, 2, 0, nullptr};
constexpr double kNone = picard::kNoLimit;

/// A block with ports of every direction, which no program has.
picard_block block_of(const std::vector<picard_port>& ports) {
  picard_block block{};
  block.name = "MIXER";
  block.group = "Own blocks";
  block.summary = "Mixes & matches.";
  block.details = "Gives `a<b`.\n\n- first\n- **second**\n\nEnd.";
  block.ports = ports.data();
  block.port_count = static_cast<std::uint32_t>(ports.size());
  return block;
}
const std::vector<picard_port> kPorts = {{"OUT", &kLreal, PICARD_OUTPUT, "result", "mm", "", 0, 1},
                                         {"SIZES", &kRow, PICARD_CONFIG, "sizes", "", "", -kNone, kNone},
                                         {"ON", &kBool, PICARD_INPUT, "works", "", "TRUE", -kNone, kNone},
                                         {"MOVES", &kMove, PICARD_QUEUE_READER, "orders", "", "", -kNone, kNone},
                                         {"STEP", &kMove, PICARD_INPUT, "next", "", "", -kNone, kNone},
                                         {"LIMIT", &kLreal, PICARD_CONFIG, "largest", "", "", -kNone, 5e-12}};

TEST(BlockText, DrawsPortsOfEveryKind) {
  EXPECT_EQ(tools::box_text(block_of(kPorts)),
            "                          +----------+\n"
            "                          |  MIXER   |\n"
            "                 BOOL ----|ON     OUT|---- LREAL\n"
            "                 MOVE ----|STEP      |\n"
            "                 MOVE >>>>|MOVES     |\n"
            "ARRAY [0..3] OF LREAL ====|SIZES     |\n"
            "                LREAL ====|LIMIT     |\n"
            "                          +----------+\n");
}

TEST(BlockText, RangesAndDefaults) {
  EXPECT_EQ(tools::range_text(kPorts[0]), "0 .. 1");
  EXPECT_EQ(tools::range_text(kPorts[1]), "");
  EXPECT_EQ(tools::range_text(kPorts[5]), "<= 5e-12");
  EXPECT_EQ(tools::default_text(kPorts[2]), "TRUE");
  EXPECT_EQ(tools::default_text(kPorts[5]), "0.0");
  EXPECT_EQ(tools::default_text(kPorts[0]), "") << "outputs have what the block gives";
}

// What has enumerations, and initial values that are no literals: as text for people and for editors.
const std::vector<picard_port> kPlanned = {
    {"MODE_IN", &kMode, PICARD_INPUT, "how", "", "Manual", -kNone, kNone},
    {"PLAIN", &kMode, PICARD_INPUT, "likewise", "", "", -kNone, kNone},
    {"PLANS", &kPlan, PICARD_INPUT, "when", "", "(HOW := Manual)", -kNone, kNone},
    {"ROW", &kRow, PICARD_CONFIG, "where", "m", "[1.0, 3(2.0)]", -kNone, kNone}};

TEST(BlockText, DeclaresTypesAndInitialValues) {
  const picard_block block = block_of(kPlanned);
  EXPECT_EQ(taskblocks::declaration(block),
            "TYPE MODE : SINT (Off := 0, Manual := 5); END_TYPE\n"
            "TYPE PLAN : STRUCT\n  HOW : MODE;\n  WHERE_TO : LREAL;\nEND_STRUCT; END_TYPE\n"
            "FUNCTION_BLOCK MIXER (* Mixes & matches. *)\n"
            "VAR_INPUT\n"
            "  MODE_IN : MODE := Manual; (* how *)\n"
            "  PLAIN : MODE; (* likewise *)\n"
            "  PLANS : PLAN := (HOW := Manual); (* when *)\n"
            "END_VAR\n"
            "VAR_INPUT CONSTANT\n"
            "  ROW : ARRAY [0..3] OF LREAL := [1.0, 3(2.0)]; (* where, m *)\n"
            "END_VAR\n"
            "END_FUNCTION_BLOCK\n");
  EXPECT_EQ(tools::default_text(kPlanned[1]), "Off");
  EXPECT_EQ(tools::default_text(kPlanned[3]), "[1.0, 3(2.0)]");
  const ScratchFolder scratch;
  const std::string file = scratch.file("call.st");
  write_text(file, taskblocks::declaration(block) + "PROGRAM Main\n" + tools::call_text(block) + "END_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", file, "--lint", "none"});
  EXPECT_EQ(check.code, 0) << tools::call_text(block) << check.all();
  EXPECT_NE(tools::call_text(block).find("PLAN := (HOW := Manual);"), std::string::npos) << tools::call_text(block);
}

TEST(BlocksXml, HasEnumerationsAndWhatEditorsCannotSay) {
  const picard_block block = block_of(kPlanned);
  const Registry::Entry entry{nullptr, &block, ""};
  const Registry::Entry* const entries[] = {&entry};
  const std::string xml = tools::taskblocks_xml(entries);
  for (const char* const part :
       {"<dataType name=\"MODE\">", "<value name=\"Off\" value=\"0\"/><value name=\"Manual\" value=\"5\"/>",
        "<baseType><SINT/></baseType>", "<type><derived name=\"MODE\"/></type>", "<simpleValue value=\"Manual\"/>",
        "where, m, default [1.0, 3(2.0)]", "when, default (HOW := Manual)"}) {
    EXPECT_NE(xml.find(part), std::string::npos) << part << '\n' << xml;
  }
  const ScratchFolder scratch;
  const std::string file = scratch.file("blocks.xml");
  write_text(file, xml);
  const auto check = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(check.code, 0) << check.all();
}

TEST(BlockText, BreaksLinesOfDetails) {
  EXPECT_EQ(tools::wrapped("aaa bbb\nccc ddd\n\n- eee fff ggg\n- hhh\n\niii", 2, 11),
            "  aaa bbb\n  ccc ddd\n\n  - eee fff\n    ggg\n  - hhh\n\n  iii\n");
}

TEST(BlockText, PagesInHtmlEscapeWhatIsWritten) {
  static const picard_block block = block_of(kPorts);
  const std::string drawing = tools::taskblock_svg(block);
  EXPECT_NE(drawing.find(">MIXER</text>"), std::string::npos);
  for (const picard_port& port : kPorts) {
    EXPECT_NE(drawing.find(std::string(port.name) + "</text>"), std::string::npos) << port.name;
  }
  picard_library library{PICARD_ABI_VERSION,
                         sizeof(picard_block),
                         sizeof(picard_port),
                         sizeof(picard_type),
                         "own",
                         "1.0.0",
                         nullptr,
                         &block,
                         1};
  Registry registry;
  ASSERT_FALSE(registry.add(&library, "/opt/own.so"));
  const std::vector<tools::HtmlFile> files = tools::taskblock_html(registry);
  ASSERT_EQ(files.size(), 2u) << "an index and a page; blocks of others have no example";
  EXPECT_EQ(files[1].name, "mixer.html");
  EXPECT_NE(files[0].text.find("Mixes &amp; matches."), std::string::npos);
  EXPECT_NE(
      files[1].text.find("<p>Gives <code>a&lt;b</code>.</p>\n<ul>\n<li>first</li>\n<li><b>second</b></li>\n</ul>"),
      std::string::npos)
      << files[1].text;
  EXPECT_NE(files[1].text.find("TYPE MOVE : STRUCT"), std::string::npos);
}

TEST(BlockText, DefaultsAreInTheRangesOfTheirPorts) {
  for (const Registry::Entry& entry : blocks()) {
    for (std::uint32_t i = 0; i < entry.block->port_count; ++i) {
      const picard_port& port = entry.block->ports[i];
      const bool limited = std::isfinite(port.lowest) || std::isfinite(port.highest);
      if (!limited || port.direction == PICARD_OUTPUT || port.type->kind != PICARD_ELEMENTARY) continue;
      const double value = std::strtod(tools::default_text(port).c_str(), nullptr);
      EXPECT_TRUE(value >= port.lowest && value <= port.highest)
          << entry.block->name << '.' << port.name << ": " << value;
    }
  }
}

/// The call on every page compiles.
TEST(BlockText, CallsCompile) {
  const ScratchFolder scratch;
  for (const Registry::Entry& entry : blocks()) {
    const std::string file = scratch.file("call.st");
    write_text(file, "PROGRAM Main\n" + tools::call_text(*entry.block) + "END_PROGRAM\n");
    const auto check = run_tool({PLC_TOOL, "check", file, "--lint", "none"});
    EXPECT_EQ(check.code, 0) << entry.block->name << '\n' << tools::call_text(*entry.block) << check.all();
  }
}

// ---- HTML -------------------------------------------------------------------------------------------------------

TEST(BlocksHtml, IsWholeAndItsLinksLeadSomewhere) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("made/reference");
  const auto result = run_tool({PLC_TOOL, "blocks", "--html", folder});
  ASSERT_EQ(result.code, 0) << result.all();
  std::size_t pages = 0;
  static const std::regex kLink("href=\"([^\"]+)\"");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".html") continue;
    ++pages;
    const std::string text = read_text(entry.path().string());
    EXPECT_EQ(text.find("<script"), std::string::npos);
    EXPECT_EQ(text.find("src="), std::string::npos) << "self-contained";
    for (std::sregex_iterator it(text.begin(), text.end(), kLink), end; it != end; ++it) {
      EXPECT_TRUE(std::filesystem::exists(folder + "/" + (*it)[1].str())) << entry.path() << ": " << (*it)[1];
    }
    // Well-formed XML but for the DOCTYPE and the empty elements of HTML.
    const std::string whole = std::regex_replace(text, std::regex("<!DOCTYPE html>|<meta [^>]*>"), "");
    write_text(scratch.file("page.xml"), whole);
    const auto lint = run_tool({"/usr/bin/env", "xmllint", "--noout", scratch.file("page.xml")});
    if (lint.code != 127) {
      EXPECT_EQ(lint.code, 0) << entry.path() << lint.err;
    }
  }
  EXPECT_EQ(pages, blocks().size() + 1);
  EXPECT_NE(read_text(folder + "/lowpass.html").find("<svg"), std::string::npos);
  EXPECT_EQ(run_tool({PLC_TOOL, "blocks", "--html", folder}).code, 0) << "again, over the old one";
  write_text(scratch.file("file"), "");
  EXPECT_EQ(run_tool({PLC_TOOL, "blocks", "--html", scratch.file("file")}).code, 2);
}

// ---- declarations for editors -----------------------------------------------------------------------------------

TEST(BlocksXml, IsValidAgainstTheSchemaOfPlcopen) {
  const char* const named = std::getenv("PLC_TC6_SCHEMA");
  const std::string schema = named != nullptr ? named : PLC_TC6_SCHEMA_DEFAULT;
  if (!std::filesystem::exists(schema)) {
    GTEST_SKIP() << "no file " << schema << ": PLCopen's schema is not part of this repository (set PLC_TC6_SCHEMA)";
  }
  const ScratchFolder scratch;
  const std::string library = scratch.file("blocks.xml");
  ASSERT_EQ(run_tool({PLC_TOOL, "blocks", "--xml", "-o", library}).code, 0);
  const auto lint = run_tool({"/usr/bin/env", "xmllint", "--noout", "--schema", schema, library});
  EXPECT_EQ(lint.code, 0) << lint.err;
}

constexpr const char* kUser = R"(PROGRAM Main
VAR filter : LOWPASS := (CUTOFF := 5.0); statistics : MOVING_STATISTICS := (WINDOW := 5); signal, mean : LREAL; END_VAR
  signal := 1.0 - signal;
  filter(IN := signal);
  statistics(IN := filter.OUT);
  mean := statistics.MEAN;
END_PROGRAM
CONFIGURATION C TASK T(INTERVAL := T#20ms); PROGRAM main WITH T : Main; END_CONFIGURATION
)";

/// Lines of a listing without those about files and places in them.
std::string code_of(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {PLC_TOOL, "dump"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const auto dump = run_tool(command);
  EXPECT_EQ(dump.code, 0) << dump.all();
  return dump.out;
}

TEST(BlocksXml, ImportingItChangesNothing) {
  const ScratchFolder scratch;
  const std::string user = scratch.file("user.st"), library = scratch.file("blocks.xml");
  write_text(user, kUser);
  ASSERT_EQ(run_tool({PLC_TOOL, "blocks", "--xml", "-o", library}).code, 0);
  EXPECT_EQ(code_of({user}), code_of({user, "--lib", library}));
  const auto check = run_tool({PLC_TOOL, "check", user, "--lib", library, "--werror"});
  EXPECT_EQ(check.code, 0) << check.all();
  EXPECT_EQ(check.err, "") << "not a word about what is imported and not used";
  // Alone it is a library, and in order.
  const auto alone = run_tool({PLC_TOOL, "check", library, "--werror"});
  EXPECT_EQ(alone.code, 0) << alone.all();
}

TEST(BlocksXml, AProjectThatComesBackWithItIsAsItWas) {
  const ScratchFolder scratch;
  const std::string drawn = scratch.file("drawn.xml"), imported = scratch.file("imported.xml");
  ASSERT_EQ(run_tool({PLC_TOOL, "blocks", "LOWPASS", "--example", "-o", drawn}).code, 0);
  const std::string library = run_tool({PLC_TOOL, "blocks", "--xml"}).out;
  const auto inside = [&library](const std::string& element) {
    const std::size_t begin = library.find("<" + element + ">");
    if (begin == std::string::npos) return std::string();
    const std::size_t from = begin + element.size() + 2;
    return library.substr(from, library.find("</" + element + ">") - from);
  };
  std::string text = read_text(drawn);
  const std::size_t types = text.find("<dataTypes/>");
  ASSERT_NE(types, std::string::npos);
  text.replace(types, 12, "<dataTypes>" + inside("dataTypes") + "</dataTypes>");
  const std::size_t pous = text.find("</pous>");
  ASSERT_NE(pous, std::string::npos);
  text.insert(pous, inside("pous"));
  write_text(imported, text);
  const auto trace = [](const std::string& file) {
    return run_tool({PLC_TOOL, "sim", file, "--cycles", "30", "--trace", "-"}).all();
  };
  EXPECT_EQ(trace(imported), trace(drawn));
  const auto check = run_tool({PLC_TOOL, "check", imported, "--werror"});
  EXPECT_EQ(check.code, 0) << check.all();
}

TEST(BlocksSt, DeclaresTheSame) {
  const ScratchFolder scratch;
  const std::string user = scratch.file("user.st"), library = scratch.file("blocks.st");
  write_text(user, kUser);
  ASSERT_EQ(run_tool({PLC_TOOL, "blocks", "--st", "-o", library}).code, 0);
  EXPECT_EQ(code_of({user}), code_of({user, "--lib", library}));
  EXPECT_EQ(run_tool({PLC_TOOL, "check", library, "--werror"}).code, 0);
}

TEST(BlocksSt, AreNoPousOfTheProjectThatNamesThem) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("user.st");
  write_text(file, "PROGRAM Main\nVAR filter : LOWPASS; END_VAR\n  filter(IN := 1.0);\nEND_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(check.out, file + ": ok, 1 warning, 1 POU, no task runs a program\n");
  EXPECT_NE(check.err.find("--pou NAME runs one of Main alone"), std::string::npos) << check.err;
}

TEST(BlocksSt, AMisspeltTypeIsGuessed) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("user.st");
  write_text(file, "PROGRAM Main\nVAR filter : LOWPAS; END_VAR\nEND_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", file});
  EXPECT_NE(check.err.find("did you mean \"LOWPASS\"?"), std::string::npos) << check.err;
}

TEST(BlocksXml, WhatDiffersFromTheTaskblockCountsAsItStands) {
  const ScratchFolder scratch;
  const std::string user = scratch.file("user.st");
  for (const char* own :
       {"FUNCTION_BLOCK LOWPASS VAR_INPUT IN, CUTOFF : LREAL; END_VAR VAR_OUTPUT OUT : LREAL; END_VAR\n"
        "  OUT := IN;\nEND_FUNCTION_BLOCK\n",
        "FUNCTION_BLOCK LOWPASS VAR_INPUT IN, CUTOFF, MORE : LREAL; END_VAR VAR_OUTPUT OUT : LREAL; END_VAR\n"
        "END_FUNCTION_BLOCK\n",
        "FUNCTION_BLOCK LOWPASS VAR_INPUT IN, OUT : LREAL; END_VAR VAR_OUTPUT CUTOFF : LREAL; END_VAR\n"
        "END_FUNCTION_BLOCK\n"}) {
    write_text(user, std::string(kUser) + own);
    const auto check = run_tool({PLC_TOOL, "check", user});
    EXPECT_NE(check.err.find("hides the taskblock"), std::string::npos) << own << check.all();
  }
}

// ---- configuration ports ----------------------------------------------------------------------------------------

TEST(BlocksConfiguration, NothingWritesAPortThatReadyHasChecked) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("main.st");
  for (const char* const statement :
       {"f.START := 7.0;", "r := REF(f.START);", "Twice(f.START);", "SPLIT_DATE(D#2024-01-01, YEAR => f.START);"}) {
    write_text(file,
               std::string("FUNCTION_BLOCK Twice_\nVAR_IN_OUT x : LREAL; END_VAR\n  x := 2.0 * x;\nEND_FUNCTION_BLOCK\n"
                           "PROGRAM Main\nVAR f : GEAR; r : REF_TO LREAL; Twice : Twice_; END_VAR\n  ") +
                   statement + "\n  f(MASTER := 1.0);\nEND_PROGRAM\n");
    const auto check = run_tool({PLC_TOOL, "check", file});
    EXPECT_EQ(check.code, 1) << statement;
    EXPECT_NE(check.err.find("error P4007"), std::string::npos) << statement << '\n' << check.err;
  }
  write_text(file, kUser);
  write_text(scratch.file("stimulus.csv"), "time_ms,main.statistics.WINDOW\n0,50\n");
  const auto sim = run_tool({PLC_TOOL, "sim", file, "--stimulus", scratch.file("stimulus.csv")});
  EXPECT_NE(sim.err.find("P7106"), std::string::npos) << sim.all();
}

// ---- examples ---------------------------------------------------------------------------------------------------

class BlockExamples : public testing::TestWithParam<std::string> {};

std::vector<std::string> block_names() {
  std::vector<std::string> names;
  for (const Registry::Entry& entry : blocks()) names.emplace_back(entry.block->name);
  return names;
}

std::string text_of(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  return text;
}

/// Equal texts, or numbers that differ by no more than the rounding of another mathematical library.
bool alike(const std::string& expected, const std::string& actual) {
  if (same_value(expected, actual)) return true;
  char *expected_end = nullptr, *actual_end = nullptr;
  const double a = std::strtod(expected.c_str(), &expected_end), b = std::strtod(actual.c_str(), &actual_end);
  constexpr double kRelative = 1e-9, kAbsolute = 1e-12;
  return expected_end != expected.c_str() && *expected_end == '\0' && actual_end != actual.c_str() &&
         *actual_end == '\0' && std::abs(a - b) <= kRelative * std::abs(a) + kAbsolute;
}

/// What is traced when there is no golden file yet: variables of the program, without what lies inside of instances; of
/// arrays the first elements.
std::vector<std::string> program_variables(const std::string& example) {
  std::istringstream header(run_tool({PLC_TOOL, "sim", example, "--cycles", "1", "--trace", "-"}).out);
  std::string line;
  std::getline(header, line);
  std::vector<std::string> names;
  std::istringstream cells(line);
  static const std::regex kVariable(R"([^.]*\.[^.[]*(\[[0-3]\])?)");
  for (std::string cell; std::getline(cells, cell, ',');) {
    if (std::regex_match(cell, kVariable)) names.push_back(cell);
  }
  return names;
}

// The golden file beside the example says what is compared: its columns are the variables, its rows the cycles.
// PLC_GOLDEN_UPDATE=1 writes them anew; where there is no file, 200 cycles of the program's variables.
TEST_P(BlockExamples, AreAcceptedAndDoWhatTheyDid) {
  const picard_block& block = *Registry::built_in().find(GetParam())->block;
  const tools::TaskblockExample* const example = tools::taskblock_example(block);
  ASSERT_NE(example, nullptr) << "no project shows it: taskblocks/" << tools::taskblock_folder(block.group)
                              << "/<name>.xml, with the name of the block";
  const std::string file = (source_root() / "taskblocks" / example->path).string();
  EXPECT_NE(example->text.find("typeName=\"" + GetParam() + "\""), std::string::npos) << file << " does not draw it";
  const auto check = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(check.code, 0) << check.all();

  const ScratchFolder scratch;
  ::setenv("PICARD_LOG_DIRECTORY", scratch.file("").c_str(), 1);
  const std::filesystem::path golden = std::filesystem::path(file).replace_extension(".csv");
  const char* const update = std::getenv("PLC_GOLDEN_UPDATE");
  const bool updates = update != nullptr && std::string(update) == "1";
  std::vector<std::string> variables;
  std::size_t cycles = 200;
  CsvTable expected;
  if (std::filesystem::exists(golden)) {
    expected = read_csv(golden.string());
    ASSERT_GT(expected.header.size(), 2u) << golden;
    variables.assign(expected.header.begin() + 2, expected.header.end());
    cycles = expected.rows.size();
  } else {
    ASSERT_TRUE(updates) << "no " << golden << ": run the test with PLC_GOLDEN_UPDATE=1";
    variables = program_variables(file);
    ASSERT_FALSE(variables.empty());
  }
  std::vector<std::string> command = {PLC_TOOL, "sim", file, "--cycles", std::to_string(cycles)};
  for (const std::string& name : variables) command.insert(command.end(), {"--watch", name});
  const auto sim = run_tool(command);
  ASSERT_EQ(sim.code, 0) << sim.all();
  if (updates) {
    write_text(golden.string(), sim.out);
    return;
  }
  write_text(scratch.file("trace.csv"), sim.out);
  const CsvTable actual = read_csv(scratch.file("trace.csv"));
  EXPECT_EQ(actual.header, expected.header);
  ASSERT_EQ(actual.rows.size(), expected.rows.size());
  for (std::size_t row = 0; row < expected.rows.size(); ++row) {
    const bool equal = std::equal(expected.rows[row].begin(), expected.rows[row].end(), actual.rows[row].begin(),
                                  actual.rows[row].end(), alike);
    ASSERT_TRUE(equal) << golden << ':' << expected.lines[row] << '\n'
                       << text_of(expected.rows[row]) << "\nis now\n"
                       << text_of(actual.rows[row])
                       << "\nif the change is meant, run the test with PLC_GOLDEN_UPDATE=1";
  }
}

INSTANTIATE_TEST_SUITE_P(All, BlockExamples, testing::ValuesIn(block_names()),
                         [](const auto& name) { return name.param; });

TEST(BlockExamplesFolder, HoldsNoExampleOfNothing) {
  std::set<std::string> known;
  for (const Registry::Entry& entry : blocks()) {
    if (const auto* const example = tools::taskblock_example(*entry.block)) known.emplace(example->path);
  }
  const std::filesystem::path root = source_root() / "taskblocks";
  for (const Registry::Entry& entry : blocks()) {
    for (const auto& file : std::filesystem::directory_iterator(root / tools::taskblock_folder(entry.block->group))) {
      if (file.path().extension() != ".xml") continue;
      EXPECT_EQ(known.count(std::filesystem::relative(file.path(), root).generic_string()), 1u) << file.path();
    }
  }
}

}  // namespace
}  // namespace plc::test
