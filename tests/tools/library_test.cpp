// Libraries (--lib): what joins the project, and that what nothing uses may be anything.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

constexpr const char* kUser = R"(PROGRAM Main
VAR r : Ramp; c : Color; END_VAR
VAR_EXTERNAL gain : REAL; END_VAR
END_PROGRAM
CONFIGURATION C TASK t (INTERVAL := T#10ms); PROGRAM p WITH t : Main; END_CONFIGURATION
)";
constexpr const char* kLibrary = R"(TYPE Color : (Red, Green); END_TYPE
VAR_GLOBAL gain : REAL := 2.5; END_VAR
FUNCTION_BLOCK Ramp VAR_INPUT x : REAL; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK Chart INITIAL_STEP a: END_STEP END_FUNCTION_BLOCK
CONFIGURATION Own TASK never (INTERVAL := T#1s); PROGRAM q WITH never : Ramp; END_CONFIGURATION
)";

struct Library {
  ScratchFolder scratch;
  std::string user = scratch.file("user.st"), library = scratch.file("library.st"), image = scratch.file("user.pbc");
  Library() {
    write_text(user, kUser);
    write_text(library, kLibrary);
  }
};

TEST(Libraries, JoinTheProjectOnEveryCommand) {
  const Library l;
  const auto without = run_tool({PLC_TOOL, "check", l.user});
  EXPECT_EQ(without.code, 1);
  EXPECT_NE(without.err.find("Ramp"), std::string::npos) << without.err;
  const auto with = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library});
  EXPECT_EQ(with.code, 0) << with.all();
  EXPECT_NE(with.out.find("1 task"), std::string::npos) << with.out;
  for (const char* command : {"sim", "dump", "map"}) {
    std::vector<std::string> arguments = {PLC_TOOL, command, l.user, "--lib", l.library};
    if (command == std::string("sim")) arguments.insert(arguments.end(), {"--cycles", "1"});
    const auto result = run_tool(arguments);
    EXPECT_EQ(result.code, 0) << command_line(arguments) << result.all();
  }
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", l.user, "--lib", l.library, "-o", l.image}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", "--lib", l.library, l.user}).code, 0);
  EXPECT_EQ(run_plant({l.user, "--lib", l.library, "--duration", "30ms"}).code, 0);
  // An image has its libraries in it.
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", l.image, "--cycles", "1"}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", l.image, "--lib", l.library}).code, 2);
}

TEST(Libraries, WhatIsNotUsedCostsNothing) {
  const Library l;
  const auto listing = run_tool({PLC_TOOL, "dump", l.user, "--lib", l.library});
  ASSERT_EQ(listing.code, 0) << listing.err;
  EXPECT_EQ(listing.out.find("Chart"), std::string::npos) << listing.out;
  EXPECT_EQ(listing.out.find("never"), std::string::npos) << listing.out;
}

TEST(Libraries, TheProjectsOwnDeclarationCounts) {
  const Library l;
  write_text(l.user, std::string(kUser) +
                         "FUNCTION_BLOCK ramp VAR_INPUT own : REAL; END_VAR END_FUNCTION_BLOCK\n"
                         "VAR_GLOBAL Gain : REAL; END_VAR TYPE color : (Blue); END_TYPE");
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library});
  EXPECT_EQ(check.code, 0) << check.all();
  EXPECT_NE(check.err.find("user.st:6:16: warning P5110: \"Ramp\" hides"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("library.st:3"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("\"Color\" hides the data type"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("\"gain\" hides the global variable"), std::string::npos) << check.err;
  // The second of two libraries with one name is hidden by the first.
  const std::string second = l.scratch.file("second.st");
  write_text(second, kLibrary);
  write_text(l.user, kUser);
  const auto both = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library, "--lib", second});
  EXPECT_EQ(both.code, 0) << both.all();
  EXPECT_NE(both.err.find("library.st:3:16: warning P5110"), std::string::npos) << both.err;
}

TEST(Libraries, ErrorsNameTheLibrary) {
  const Library l;
  write_text(l.library, std::string(kLibrary) + "TYPE Bad : Missing; END_TYPE");
  const auto unused = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library});
  EXPECT_EQ(unused.code, 0) << unused.all();
  write_text(l.user, std::string(kUser) + "PROGRAM Other VAR b : Bad; END_VAR b := b; END_PROGRAM");
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library});
  EXPECT_EQ(check.code, 1);
  EXPECT_NE(check.err.find("library.st:6:12: error P4014"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("user.st:6:23: error P4060: \"Bad\" of library "), std::string::npos) << check.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "check", l.user, "--lib", l.scratch.file("none.st")}).code, 2);
  const auto image = run_tool({PLC_TOOL, "check", l.user, "--lib", l.scratch.file("x.pbc")});
  EXPECT_EQ(image.code, 1);
  EXPECT_NE(image.err.find("P5111"), std::string::npos) << image.err;
}

TEST(Libraries, MayBePlcopenXml) {
  const Library l;
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", tank(), "--lib", l.library});
  EXPECT_EQ(check.code, 0) << check.all();
  const auto onto_xml = run_tool({PLC_TOOL, "check", tank(), "--lib", l.library});
  EXPECT_EQ(onto_xml.code, 0) << onto_xml.all();
}

// ---- what is not understood -------------------------------------------------------------------------------------

/// A declaration of a library that cannot be used, and how a project would use it.
struct Broken {
  const char* name;
  const char* library;
  const char* variables;  ///< of the program that uses it
  const char* statements;
  const char* message;  ///< of P4060
  int line;             ///< of the first problem, in the library
};

constexpr Broken kBroken[] = {
    {"method", "FUNCTION_BLOCK B\nVAR_OUTPUT q : INT; END_VAR\nMETHOD Go : INT\nEND_METHOD\nEND_FUNCTION_BLOCK",
     "x : B;", "x();", "METHOD", 3},
    {"property", "FUNCTION_BLOCK B\nPROPERTY Speed : INT\nEND_PROPERTY\nEND_FUNCTION_BLOCK", "x : B;", "x();",
     "PROPERTY", 2},
    {"base", "FUNCTION_BLOCK A\nEND_FUNCTION_BLOCK\nFUNCTION_BLOCK B EXTENDS A\nEND_FUNCTION_BLOCK", "x : B;", "x();",
     "EXTENDS", 3},
    {"access word", "FUNCTION_BLOCK FINAL B\nEND_FUNCTION_BLOCK", "x : B;", "x();", "FINAL", 1},
    {"access word of a section", "FUNCTION_BLOCK B\nVAR PRIVATE a : INT; END_VAR\nEND_FUNCTION_BLOCK", "x : B;", "x();",
     "PRIVATE", 2},
    {"interface", "\nINTERFACE B\nMETHOD Go\nEND_METHOD\nEND_INTERFACE", "x : B;", ";", "INTERFACE", 2},
    {"class", "\nCLASS B\nEND_CLASS", "x : B;", ";", "CLASS", 2},
    {"namespace", "NAMESPACE N\nFUNCTION B : INT\nB := 1;\nEND_FUNCTION\nEND_NAMESPACE", "x : INT;", "x := B();",
     "NAMESPACE", 1},
    {"union", "TYPE\nA : INT;\nB : UNION a : WORD; b : TON; END_UNION;\nEND_TYPE", "x : B;", ";", "union", 3},
    {"member of an unknown type", "TYPE B : STRUCT\na : INT;\nb : Nowhere;\nEND_STRUCT;\nEND_TYPE", "x : B;",
     "x.a := 1;", "Nowhere", 3},
    {"type in a type", "TYPE A : Nowhere; END_TYPE\nTYPE B : ARRAY [1..3] OF A; END_TYPE", "x : B;", ";",
     "it needs \"A\"", 1},
    {"input of an unknown type", "FUNCTION B : INT\nVAR_INPUT a : Nowhere; END_VAR\nB := 1;\nEND_FUNCTION", "x : INT;",
     "x := B(1);", "Nowhere", 2},
    {"result of an unknown type", "\nFUNCTION B : Nowhere\nEND_FUNCTION", "x : INT;", "x := B();", "Nowhere", 2},
    {"section that cannot be read", "FUNCTION B : INT\nVAR_INPUT a INT; END_VAR\nB := 1;\nEND_FUNCTION", "x : INT;",
     "x := B(1);", "INT", 2},
    {"initial value that does not fit", "\nVAR_GLOBAL B : INT := 70000; END_VAR", "x : INT;", "x := B;", "70000", 2},
    {"constant that does not fit", "VAR_GLOBAL CONSTANT B : INT := 70000; END_VAR", "x : ARRAY [0..B] OF INT;",
     "x[0] := 1;", "70000", 1},
    {"global of an unknown type", "VAR_GLOBAL\na : INT; B : Nowhere;\nEND_VAR", "x : INT;", "x := B;", "Nowhere", 2},
    {"text beyond what a STRING holds", "TYPE B : STRUCT\ns : STRING[10] := '\u7B49';\nEND_STRUCT; END_TYPE", "x : B;",
     ";", "", 2},
    {"statement", "FUNCTION B : INT\nIF TRUE THEN B := 1;\nEND_FUNCTION", "x : INT;", "x := B();", "", 2},
    {"statement of what is called",
     "FUNCTION A : INT\nA := Nowhere;\nEND_FUNCTION\nFUNCTION B : INT\nB := A();\nEND_FUNCTION", "x : INT;",
     "x := B();", "it needs \"A\"", 2},
    {"chart",
     "FUNCTION_BLOCK B\nINITIAL_STEP S: END_STEP TRANSITION FROM S TO T := TRUE; END_TRANSITION\nEND_FUNCTION_BLOCK",
     "x : B;", "x();", "which is not in this chart", 2},
    {"block that contains itself", "FUNCTION_BLOCK B\nVAR b : B; END_VAR\nEND_FUNCTION_BLOCK", "x : B;", ";",
     "contains itself", 1},
    {"blocks that contain each other",
     "FUNCTION_BLOCK A\nVAR b : ARRAY [0..1] OF B; END_VAR\nEND_FUNCTION_BLOCK\nTYPE "
     "S : STRUCT a : A; END_STRUCT; END_TYPE\nFUNCTION_BLOCK B\nVAR s : S; END_VAR\nEND_FUNCTION_BLOCK",
     "x : B;", ";", "contains itself", 5},
    {"type that contains itself", "TYPE B : STRUCT\nb : B;\nEND_STRUCT; END_TYPE", "x : B;", ";", "contains itself", 2},
    {"no end", "FUNCTION_BLOCK B\nVAR a : INT; END_VAR\na := 1;", "x : B;", "x();", "END_FUNCTION_BLOCK", 1},
    {"other end", "FUNCTION_BLOCK B\nEND_PROGRAM", "x : B;", "x();", "END_PROGRAM", 2},
    {"word nobody knows", "FUNCTIONBLOK B\nEND_FUNCTION_BLOCK", "x : B;", ";", "FUNCTIONBLOK", 1},
    {"enumeration", "TYPE B : (Red := Nowhere, Green); END_TYPE", "x : B;", ";", "Nowhere", 1},
    {"subrange", "TYPE B : INT (5..1); END_TYPE", "x : B;", ";", "5..1", 1},
    {"string that is too long", "TYPE B : STRING[100000]; END_TYPE", "x : B;", ";", "100000", 1},
};

/// Whatever is broken, this one is not.
constexpr const char* kFour = "FUNCTION Four : INT\nFour := 4;\nEND_FUNCTION\n";

class BrokenLibrary : public ::testing::TestWithParam<Broken> {};

TEST_P(BrokenLibrary, DoesNoHarmUntilItIsUsed) {
  const Broken& b = GetParam();
  const Library l;
  // The program's names may be those of the library.
  write_text(l.user,
             "PROGRAM Main\nVAR B : INT; r : INT; A : INT; END_VAR\nr := Four(); B := r; A := B;\nEND_PROGRAM\n");
  for (const bool first : {true, false}) {
    write_text(l.library, first ? std::string(b.library) + "\n" + kFour : kFour + std::string(b.library) + "\n");
    // What does not end takes along what follows it.
    if (first && std::string(b.name) == "no end") continue;
    const auto sim =
        run_tool({PLC_TOOL, "sim", l.user, "--lib", l.library, "--cycles", "1", "--trace", "-", "--pou", "Main"});
    EXPECT_EQ(sim.code, 0) << sim.all();
    EXPECT_EQ(sim.err.find("library.st"), std::string::npos) << sim.err;
    EXPECT_NE(sim.out.find(",4"), std::string::npos) << sim.out;
  }
}

TEST_P(BrokenLibrary, SaysWhatItLacksWhereItIsUsed) {
  const Broken& b = GetParam();
  const Library l;
  write_text(l.library, std::string(b.library) + "\n");
  write_text(l.user, "PROGRAM Main\nVAR " + std::string(b.variables) + " END_VAR\n" + b.statements + "\nEND_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library});
  EXPECT_EQ(check.code, 1) << check.all();
  const std::size_t at = check.err.find("error P4060: \"B\" of library ");
  ASSERT_NE(at, std::string::npos) << check.err;
  const std::string line = check.err.substr(at, check.err.find('\n', at) - at);
  EXPECT_NE(line.find(b.message), std::string::npos) << check.err;
  const std::string place = std::to_string(b.line);
  EXPECT_NE(line.find("(line " + place + ")"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("library.st:" + place + ":"), std::string::npos) << check.err;
  // On its own the library is a project, and all of it counts.
  EXPECT_EQ(run_tool({PLC_TOOL, "check", l.library}).code, 1);
}

INSTANTIATE_TEST_SUITE_P(Declarations, BrokenLibrary, ::testing::ValuesIn(kBroken), [](const auto& test) {
  std::string name = test.param.name;
  for (char& c : name) {
    if (c == ' ') c = '_';
  }
  return name;
});

TEST(Libraries, TextBetweenDeclarationsIsNobodys) {
  const Library l;
  write_text(l.library, std::string("%& 12 garbage;\n") + kFour + "more of it\n");
  write_text(l.user, "PROGRAM Main\nVAR r : INT; END_VAR\nr := Four();\nEND_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library, "--pou", "Main"});
  EXPECT_EQ(check.code, 0) << check.all();
}

// Names of a library do not change what those of the project mean.
TEST(Libraries, NamesOfTheProjectKeepTheirMeaning) {
  const Library l;
  write_text(l.library,
             "TYPE Lamp : (Red := 10, Green, Off); END_TYPE\n"
             "VAR_GLOBAL Setup : REAL; level : REAL; END_VAR\n"
             "VAR_GLOBAL CONSTANT Width : INT := 3; END_VAR\n"
             "FUNCTION LampNumber : INT\nVAR l : Lamp := Green; END_VAR\nl := Off; LampNumber := 12;\nEND_FUNCTION\n");
  write_text(l.user,
             "TYPE State : (Off, Setup, Red, Width); END_TYPE\n"
             "PROGRAM Main\nVAR s, t : State := Width; r : INT; n : INT; END_VAR\n"
             "s := Setup; IF t = Width THEN r := 1; END_IF;\n"
             "n := LampNumber(); t := Red;\nEND_PROGRAM\n");
  const auto sim =
      run_tool({PLC_TOOL, "sim", l.user, "--lib", l.library, "--cycles", "1", "--trace", "-", "--pou", "Main"});
  EXPECT_EQ(sim.code, 0) << sim.all();
  const auto check = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library, "--pou", "Main", "--lint", "all"});
  EXPECT_EQ(check.err.find("library.st"), std::string::npos) << check.err;
  EXPECT_EQ(check.err.find("P4313"), std::string::npos) << check.err;
}

TEST(Libraries, AreLintedOnRequest) {
  const Library l;
  write_text(l.library, "FUNCTION Four : INT\nVAR idle : INT; x : INT; END_VAR\nx := x; Four := 4;\nEND_FUNCTION\n");
  write_text(l.user, "PROGRAM Main\nVAR r : INT; END_VAR\nr := Four();\nEND_PROGRAM\n");
  const auto quiet = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library, "--pou", "Main"});
  EXPECT_EQ(quiet.err.find("library.st"), std::string::npos) << quiet.err;
  const auto linted = run_tool({PLC_TOOL, "check", l.user, "--lib", l.library, "--pou", "Main", "--lint-libraries"});
  EXPECT_NE(linted.err.find("library.st:2:5: warning P4301"), std::string::npos) << linted.err;
}

// ---- PLCopen XML ------------------------------------------------------------------------------------------------

std::string xml_library(const std::string& types, const std::string& pous, const std::string& globals = {}) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="" productName="test" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="lib"><coordinateInfo><fbd><scaling x="0" y="0"/></fbd><ld><scaling x="0" y="0"/></ld><sfc><scaling x="0" y="0"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes>)" +
         types + "</dataTypes><pous>" + pous +
         R"(<pou name="Four" pouType="function"><interface><returnType><INT/></returnType></interface><body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">Four := 4;</xhtml></ST></body></pou>)"
         "</pous></types>\n<instances><configurations><configuration name=\"C\">" +
         globals + "<resource name=\"R\"/></configuration></configurations></instances></project>\n";
}

TEST(Libraries, OfXmlAreLazyToo) {
  const std::string block = R"(<pou name="B" pouType="functionBlock"><interface>%I</interface><body>%B</body></pou>)";
  const auto pou = [&](const std::string& interface, const std::string& body) {
    std::string out = block;
    out.replace(out.find("%I"), 2, interface);
    return out.replace(out.find("%B"), 2, body);
  };
  const std::string st = R"(<ST><xhtml xmlns="http://www.w3.org/1999/xhtml">)";
  const std::string empty = st + ";</xhtml></ST>";
  struct Case {
    const char* what;
    std::string library;
    const char* variables;
    const char* statements;
  };
  const Case cases[] = {
      {"unknown type",
       xml_library(
           "", pou("<localVars><variable name=\"v\"><type><derived name=\"Nowhere\"/></type></variable></localVars>",
                   empty)),
       "x : B;", "x();"},
      {"chart without an initial step",
       xml_library("", pou("", "<SFC><step localId=\"1\" name=\"S\"><position x=\"0\" y=\"0\"/></step></SFC>")),
       "x : B;", "x();"},
      {"no body", xml_library("", "<pou name=\"B\" pouType=\"functionBlock\"><interface/></pou>"), "x : B;", "x();"},
      {"no type of POU",
       xml_library("", "<pou name=\"B\" pouType=\"method\"><interface/><body>" + empty + "</body></pou>"), "x : B;",
       ";"},
      {"statements", xml_library("", pou("", st + "IF nowhere THEN</xhtml></ST>")), "x : B;", "x();"},
      {"drawing",
       xml_library("", pou("",
                           "<FBD><block localId=\"1\" typeName=\"NOWHERE\"><position x=\"0\" "
                           "y=\"0\"/><inputVariables/><inOutVariables/><outputVariables/></block></FBD>")),
       "x : B;", "x();"},
      {"data type", xml_library("<dataType name=\"B\"><baseType><derived name=\"Nowhere\"/></baseType></dataType>", ""),
       "x : B;", ";"},
      {"global",
       xml_library("", "",
                   "<globalVars name=\"G\"><variable name=\"B\"><type><derived "
                   "name=\"Nowhere\"/></type></variable></globalVars>"),
       "x : INT;", "x := G.B;"},
      {"initial value",
       xml_library("", "",
                   "<globalVars><variable name=\"B\"><type><INT/></type><initialValue><simpleValue "
                   "value=\"70000\"/></initialValue></variable></globalVars>"),
       "x : INT;", "x := B;"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.what);
    const Library l;
    const std::string library = l.scratch.file("library.xml");
    write_text(library, c.library);
    write_text(l.user, "PROGRAM Main\nVAR r : INT; END_VAR\nr := Four();\nEND_PROGRAM\n");
    const auto unused = run_tool({PLC_TOOL, "check", l.user, "--lib", library, "--pou", "Main"});
    EXPECT_EQ(unused.code, 0) << unused.all();
    EXPECT_EQ(unused.err.find("library.xml"), std::string::npos) << unused.err;
    write_text(l.user,
               std::string("PROGRAM Main\nVAR ") + c.variables + " END_VAR\n" + c.statements + "\nEND_PROGRAM\n");
    const auto used = run_tool({PLC_TOOL, "check", l.user, "--lib", library, "--pou", "Main"});
    EXPECT_EQ(used.code, 1) << used.all();
    EXPECT_NE(used.err.find("error P4060: \"B\" of library "), std::string::npos) << used.err;
    EXPECT_NE(used.err.find("library.xml:"), std::string::npos) << used.err;
  }
}

// A file that is no text or no XML at all is of no use to anybody.
TEST(Libraries, ThatCannotBeReadAreErrors) {
  const Library l;
  write_text(l.user, "PROGRAM Main\n;\nEND_PROGRAM\n");
  for (const std::string_view bytes : {std::string_view("FUNCTION\0", 9), std::string_view("<project><types>")}) {
    write_text(l.library, bytes);
    const std::string xml = l.scratch.file("library.xml");
    write_text(xml, bytes);
    const auto check =
        run_tool({PLC_TOOL, "check", l.user, "--lib", bytes[0] == '<' ? xml : l.library, "--pou", "Main"});
    EXPECT_EQ(check.code, 1) << check.all();
    EXPECT_NE(check.err.find("library."), std::string::npos) << check.err;
  }
}

}  // namespace
}  // namespace plc::test
