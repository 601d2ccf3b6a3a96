// Source folders and plc convert on the command line: every command takes a folder, hostile folders are refused.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;

const char* const kTool = PLC_TOOL;

void write(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string pou(const std::string& name, const std::string& variables, const std::string& body) {
  return "<TcPlcObject><POU Name=\"" + name + "\"><Declaration><![CDATA[PROGRAM " + name + "\nVAR " + variables +
         " END_VAR]]></Declaration><Implementation><ST><![CDATA[" + body +
         "]]></ST></Implementation></POU></TcPlcObject>";
}

std::string task(const std::string& program) {
  return "<TcPlcObject><Task Name=\"T\"><CycleTime>10000</CycleTime><Priority>1</Priority><PouCall><Name>" + program +
         "</Name></PouCall></Task></TcPlcObject>";
}

std::string project(const std::string& entries) {
  return "<Project xmlns=\"http://schemas.microsoft.com/developer/msbuild/2003\"><ItemGroup>" + entries +
         "</ItemGroup></Project>";
}

TEST(SourceFolders, EveryCommandTakesThem) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("plant");
  write(folder + "/POUs/MAIN.TcPOU", pou("MAIN", "n : INT;", "n := n + 1;"));
  write(folder + "/T.TcTTO", task("MAIN"));
  write(folder + "/more.st", "FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR Twice := x * 2; END_FUNCTION\n");
  const ToolResult checked = run_tool({kTool, "check", folder});
  EXPECT_EQ(checked.code, 0) << checked.all();
  EXPECT_NE(checked.out.find("2 POUs, 1 task"), std::string::npos) << checked.out;
  const ToolResult simulated = run_tool({kTool, "sim", folder, "--cycles", "3"});
  EXPECT_EQ(simulated.code, 0) << simulated.all();
  const ToolResult compiled = run_tool({kTool, "compile", folder, "-o", scratch.file("plant.pbc")});
  EXPECT_EQ(compiled.code, 0) << compiled.all();
  const ToolResult reported = run_tool({kTool, "report", folder});
  EXPECT_EQ(reported.code, 0) << reported.all();
  EXPECT_NE(reported.out.find("MAIN.TcPOU, line"), std::string::npos) << reported.out;
  EXPECT_EQ(run_tool({kTool, "explain", folder}).code, 0);
  EXPECT_EQ(run_tool({kTool, "map", folder}).code, 0);
  // As a library, too.
  write(
      scratch.file("use.st"),
      "PROGRAM P VAR x : INT; END_VAR x := Twice(x); END_PROGRAM CONFIGURATION c TASK t (INTERVAL := T#10ms, PRIORITY "
      ":= 1); PROGRAM p WITH t : P; END_CONFIGURATION\n");
  const ToolResult used = run_tool({kTool, "check", scratch.file("use.st"), "--lib", folder});
  EXPECT_EQ(used.code, 0) << used.all();
}

TEST(SourceFolders, TextsOfAFolderAreOneProject) {
  const ScratchFolder scratch;
  write(scratch.file("plant/GVL.st"), "{attribute 'qualified_only'}\nVAR_GLOBAL level : INT := 3; END_VAR\n");
  write(scratch.file("plant/main.st"), "PROGRAM Main VAR x : INT; END_VAR x := GVL.level + One(); END_PROGRAM\n");
  write(scratch.file("plant/sub/one.st"), "FUNCTION One : INT One := 1; END_FUNCTION\n");
  const ToolResult result =
      run_tool({kTool, "sim", scratch.file("plant/"), "--pou", "Main", "--cycles", "1", "--trace", "-"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find("Main.x"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(",4"), std::string::npos) << result.out;
}

TEST(SourceFolders, HostileFoldersAreRefused) {
  const ScratchFolder scratch;
  write(scratch.file("secret.TcPOU"), pou("Secret", "n : INT;", "n := 1;"));
  write(scratch.file("a/MAIN.TcPOU"), pou("MAIN", "n : INT;", "n := n + 1;"));
  // A link that leads out, and one that leads back.
  fs::create_symlink(scratch.file("secret.TcPOU"), scratch.file("a/Linked.TcPOU"));
  fs::create_directory_symlink(scratch.file("a"), scratch.file("a/loop"));
  const ToolResult linked = run_tool({kTool, "check", scratch.file("a")});
  EXPECT_EQ(linked.code, 0) << linked.all();
  EXPECT_NE(linked.out.find("1 POU"), std::string::npos) << linked.out;
  write(scratch.file("a/P.plcproj"),
        project("<Compile Include=\"Linked.TcPOU\"/><Compile Include=\"loop\\MAIN.TcPOU\"/>"
                "<Compile Include=\"..\\secret.TcPOU\"/><Compile Include=\"\\etc\\passwd.TcPOU\"/>"
                "<Compile Include=\"%2e%2e\\secret.TcPOU\"/><Compile Include=\"\"/>"));
  const ToolResult outside = run_tool({kTool, "check", scratch.file("a/P.plcproj")});
  EXPECT_EQ(outside.code, 1) << outside.all();
  EXPECT_EQ(outside.all().find("Secret"), std::string::npos) << outside.all();
  std::size_t refused = 0;
  for (std::size_t at = outside.err.find("P1205"); at != std::string::npos; at = outside.err.find("P1205", at + 1))
    ++refused;
  EXPECT_EQ(refused, 4u) << outside.err;
  // Broken in several ways: an error with a place, exit code 1, and nothing worse.
  for (const std::string& text :
       {std::string(), std::string("<TcPlcObject>"), std::string("\0\0", 2), std::string(200000, '<'),
        std::string("<TcPlcObject><POU Name=\"A\"></TcPlcObject>")}) {
    write(scratch.file("b/MAIN.TcPOU"), text);
    const ToolResult broken = run_tool({kTool, "check", scratch.file("b")});
    EXPECT_EQ(broken.code, 1) << broken.all().substr(0, 2000);
    EXPECT_NE(broken.err.find("error P1"), std::string::npos) << broken.all().substr(0, 2000);
  }
  EXPECT_EQ(run_tool({kTool, "check", scratch.file("not there")}).code, 2);
}

TEST(ConvertSources, AreRefusedWhereTheyCannotBe) {
  const ScratchFolder scratch;
  write(
      scratch.file("p.st"),
      "PROGRAM P VAR x : INT; END_VAR x := x + 1; END_PROGRAM CONFIGURATION c TASK t (INTERVAL := T#10ms, PRIORITY := "
      "1); PROGRAM p WITH t : P; END_CONFIGURATION\n");
  EXPECT_EQ(run_tool({kTool, "convert", scratch.file("p.st"), "-o", scratch.file("p.st")}).code, 2);
  ASSERT_EQ(run_tool({kTool, "compile", scratch.file("p.st"), "-o", scratch.file("p.pbc")}).code, 0);
  EXPECT_EQ(run_tool({kTool, "convert", scratch.file("p.pbc"), "-o", scratch.file("q.st")}).code, 2);
  const ToolResult printed = run_tool({kTool, "convert", scratch.file("p.st"), "-o", "-"});
  EXPECT_EQ(printed.code, 0) << printed.all();
  EXPECT_NE(printed.out.find("x := x + 1;\nEND_PROGRAM"), std::string::npos) << printed.out;
  const ToolResult same = run_tool({kTool, "convert", scratch.file("p.st"), "-o", scratch.file("q.st")});
  EXPECT_EQ(same.code, 0) << same.all();
  EXPECT_NE(same.out.find("same image"), std::string::npos) << same.out;
  write(scratch.file("bad.st"), "PROGRAM P x := 1; END_PROGRAM\n");
  EXPECT_EQ(run_tool({kTool, "convert", scratch.file("bad.st"), "-o", scratch.file("r.st")}).code, 1);
  EXPECT_FALSE(fs::exists(scratch.file("r.st")));
}

}  // namespace
