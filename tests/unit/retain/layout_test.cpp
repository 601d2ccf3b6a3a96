// What a program keeps, and its stored form.
#include "retain/layout.h"

#include "tests/unit/retain/plant.h"

namespace plc::test {
namespace {

using Paths = std::vector<std::string>;

Paths paths_of(const std::string& text) {
  const auto resource = load_text(text);
  return resource == nullptr ? Paths{} : kept_paths(retain::find_kept(*resource).layout);
}

TEST(Layout, FindsVariablesOfProgramsBlocksAndLists) {
  EXPECT_EQ(
      paths_of(with_task("FUNCTION_BLOCK Counter VAR RETAIN n : INT; END_VAR VAR m : INT; END_VAR n := n + 1; "
                         "END_FUNCTION_BLOCK\n"
                         "TYPE Pair : STRUCT a : INT; c : Counter; END_STRUCT; END_TYPE\n"
                         "PROGRAM Main VAR RETAIN x : INT; s : STRING[5]; END_VAR VAR PERSISTENT p : REAL; END_VAR\n"
                         "VAR c : ARRAY [1..2] OF Counter; pair : Pair; plain : DINT; END_VAR\n"
                         "VAR_EXTERNAL Total, Setpoint : INT; END_VAR\n"
                         "  c[1](); pair.c(); Total := Setpoint; END_PROGRAM\n"
                         "VAR_GLOBAL RETAIN Total : INT; END_VAR\n"
                         "VAR_GLOBAL PERSISTENT Setpoint : INT; END_VAR\nVAR_GLOBAL None : INT; END_VAR\n")),
      (Paths{"main.x", "main.s", "main.p PERSISTENT", "main.c[1].n", "main.c[2].n", "main.pair.c.n", "Total",
             "Setpoint PERSISTENT"}));
}

TEST(Layout, LeavesOutConstantsReferencesPointersAndTaskblocks) {
  EXPECT_EQ(paths_of(with_task("PROGRAM Main VAR n : INT; END_VAR\n"
                               "VAR RETAIN r : REF_TO INT; p : POINTER TO INT; f : LOWPASS; k : INT; END_VAR\n"
                               "VAR CONSTANT c : INT := 3; END_VAR\n  r := REF(n); f(); k := c; END_PROGRAM\n")),
            (Paths{"main.k"}));
}

TEST(Layout, AProgramIsKeptWhole) {
  EXPECT_EQ(paths_of("PROGRAM Main VAR n : INT; END_VAR n := n + 1; END_PROGRAM\n"
                     "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms); PROGRAM RETAIN one WITH T : Main; "
                     "PROGRAM two WITH T : Main; END_RESOURCE END_CONFIGURATION\n"),
            Paths{"one"});
}

TEST(Layout, InstancesOfOneNameInTwoTasksAreToldApart) {
  EXPECT_EQ(paths_of("PROGRAM Main VAR RETAIN n : INT; END_VAR n := n + 1; END_PROGRAM\n"
                     "CONFIGURATION C RESOURCE R ON PLC TASK A(INTERVAL := T#10ms); TASK B(INTERVAL := T#20ms);\n"
                     "PROGRAM one WITH A : Main; PROGRAM two WITH B : Main; END_RESOURCE END_CONFIGURATION\n"),
            (Paths{"one.n", "two.n"}));
}

TEST(Layout, LocatedVariablesAreKeptAsTheirGlobals) {
  EXPECT_EQ(paths_of(with_task("PROGRAM Main VAR RETAIN m AT %MW3 : INT; END_VAR m := m + 1; END_PROGRAM\n")),
            Paths{"Main.m"});
}

const char* const kMany =
    "TYPE Mode : (Off, On := 5); Deep : STRUCT s : WSTRING[3]; a : ARRAY [-1..2] OF REAL; r : REF_TO INT; END_STRUCT;\n"
    "Small : INT (1..7) := 2; END_TYPE\n"
    "PROGRAM Main VAR RETAIN d : Deep; m : Mode; t : TON; k : ARRAY [0..1, 0..2] OF Small; END_VAR\n"
    "VAR RETAIN PERSISTENT l : LREAL; END_VAR t(IN := TRUE, PT := T#1h); END_PROGRAM\n";

TEST(Layout, ItsBytesGiveItAgain) {
  const auto resource = load_text(with_task(kMany));
  ASSERT_NE(resource, nullptr);
  const retain::Layout layout = retain::find_kept(*resource).layout;
  const std::vector<std::byte> bytes = encode(layout);
  const auto again = retain::decode(bytes);
  ASSERT_TRUE(again);
  EXPECT_EQ(encode(*again), bytes);
  EXPECT_EQ(kept_paths(*again), kept_paths(layout));
  EXPECT_EQ(again->bytes, layout.bytes);
  EXPECT_EQ(again->program, layout.program);
}

TEST(Layout, CutBytesAreRefused) {
  const auto resource = load_text(with_task(kMany));
  ASSERT_NE(resource, nullptr);
  const std::vector<std::byte> bytes = encode(retain::find_kept(*resource).layout);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(retain::decode(std::span(bytes).first(size))) << size;
  }
}

TEST(Layout, DamagedBytesAreRefusedOrSound) {
  const auto resource = load_text(with_task(kMany));
  ASSERT_NE(resource, nullptr);
  const std::vector<std::byte> bytes = encode(retain::find_kept(*resource).layout);
  std::size_t refused = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
      std::vector<std::byte> damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(flip);
      const auto layout = retain::decode(damaged);
      if (!layout) ++refused;
      if (!layout) continue;
      for (const retain::Root& root : layout->roots) {
        ASSERT_LT(root.type, layout->types.size());
        ASSERT_LE(root.at + layout->types[root.type].size, layout->bytes);
      }
    }
  }
  EXPECT_GT(refused, bytes.size());
}

}  // namespace
}  // namespace plc::test
