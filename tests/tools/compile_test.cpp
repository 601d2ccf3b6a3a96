#include <gtest/gtest.h>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

TEST(Compile, ImageRunsLikeTheProject) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("tank.pbc");
  const auto compiled = run_tool({PLC_TOOL, "compile", tank(), "-o", image});
  ASSERT_EQ(compiled.code, 0) << compiled.err;
  const std::string from_xml = scratch.file("xml.csv"), from_image = scratch.file("pbc.csv");
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--stimulus", tank_stimulus(), "--trace", from_xml}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", image, "--stimulus", tank_stimulus(), "--trace", from_image}).code, 0);
  EXPECT_GT(read_text(from_xml).size(), 1000u);
  EXPECT_EQ(read_text(from_xml), read_text(from_image));
}

TEST(Compile, OptionsAreStoredInTheImage) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("tank.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", image, "--order=document", "--compat", "beremiz",
                      "--profile=overlay"})
                .code,
            0);
  const auto run = run_tool({PLC_TOOL, "sim", image, "--cycles", "1"});
  EXPECT_NE(run.out.find("order=document compat=beremiz profile=overlay"), std::string::npos) << run.out;
  const auto other = run_tool({PLC_TOOL, "sim", image, "--order=drawing"});
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("stored in it"), std::string::npos) << other.err;
}

TEST(Compile, DefinesAreStoredInTheImage) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("plant.st");
  write_text(project,
             "PROGRAM Main VAR n : INT; END_VAR {IF hasvalue (MODE, 'fast day')} n := 1; {ELSE} n := 2; {END_IF} "
             "END_PROGRAM\n");
  const std::string image = scratch.file("plant.pbc");
  const auto compiled = run_tool(
      {PLC_TOOL, "compile", project, "--pou", "Main", "--define", "OTHER", "--define=MODE=fast day", "-o", image});
  ASSERT_EQ(compiled.code, 0) << compiled.err;
  const auto run = run_tool({PLC_TOOL, "sim", image, "--cycles", "1", "--watch", "Main.n"});
  EXPECT_NE(run.err.find("define=OTHER define=MODE=fast day"), std::string::npos) << run.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", image, "--define", "X"}).code, 2) << "stored in it";
  const auto wrong = run_tool({PLC_TOOL, "check", project, "--define", "2X"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("is no name"), std::string::npos) << wrong.err;
}

TEST(Compile, EqualInputsGiveEqualImages) {
  const ScratchFolder scratch;
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", scratch.file("a.pbc")}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", scratch.file("b.pbc")}).code, 0);
  EXPECT_EQ(read_text(scratch.file("a.pbc")), read_text(scratch.file("b.pbc")));
}

TEST(Compile, WritesNothingOnErrors) {
  const ScratchFolder scratch;
  write_text(scratch.file("bad.xml"), small_project(true, kUnknownVariableBody));
  write_text(scratch.file("x.pbc"), "as it was");
  EXPECT_EQ(run_tool({PLC_TOOL, "compile", scratch.file("bad.xml"), "-o", scratch.file("x.pbc")}).code, 1);
  EXPECT_EQ(read_text(scratch.file("x.pbc")), "as it was");
}

TEST(Compile, UnwritableTargetIsAnIoError) {
  const ScratchFolder scratch;
  EXPECT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", scratch.file("no/such/folder.pbc")}).code, 2);
}

TEST(Dump, ListsAProjectAndItsImageAlike) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("tank.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", image}).code, 0);
  const auto listing = run_tool({PLC_TOOL, "dump", image});
  EXPECT_EQ(listing.code, 0) << listing.err;
  EXPECT_NE(listing.out.find("RUNTB"), std::string::npos);
  EXPECT_NE(listing.out.find("BOOL_RUN"), std::string::npos);
  EXPECT_EQ(listing.out, run_tool({PLC_TOOL, "dump", tank()}).out);
}

TEST(Image, DamageIsRefused) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("tank.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", image}).code, 0);
  std::string bytes = read_text(image);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_text(image, bytes);
  const auto result = run_tool({PLC_TOOL, "sim", image});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("P60"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace plc::test
