// Forced variables: every elementary type at every place, in both engines and under all protocols, held in each scan
// between force and release, as a recording shows it.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "compiler/compile.h"
#include "native/compile.h"
#include "runtime/force_list.h"
#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "shadow/recording.h"
#include "tests/support/run_tool.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using Bytes = std::vector<std::byte>;

struct Setting {
  bool native;
  const char* coherence;
};

struct Plant {
  Plant(const std::string& text, const Setting& setting) {
    const ScratchFolder scratch;
    const std::string path = scratch.file("p.st");
    std::ofstream(path) << text;
    compiler::Compilation compilation;
    compiler::Request request;
    request.path = path;
    request.goal = compiler::Goal::kRun;
    for (std::size_t i = 0; i < 3; ++i) {
      static constexpr const char* kNames[] = {"wait-free", "global-lock", "priority-ceiling"};
      if (setting.coherence == std::string(kNames[i])) request.options.coherence = static_cast<core::Coherence>(i);
    }
    compiler::compile(request, compilation);
    std::string why;
    for (const core::Diagnostic& one : compilation.diagnostics.all()) why += compilation.diagnostics.render_one(one);
    EXPECT_TRUE(compilation.ok() && compilation.image) << why;
    resource = std::move(*runtime::Resource::load(std::move(*compilation.image)));
    forces.emplace(*resource);
    for (std::size_t task = 0; setting.native && task < resource->task_count(); ++task)
      resource->program(task).install(std::move(*native::compile(resource->program(task))));
    bytes = shadow::file_head(
        {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource->image())});
    recording = std::move(*shadow::Recording::start(*resource, [this](const shadow::BlockInfo&, const Bytes& block) {
      bytes.insert(bytes.end(), block.begin(), block.end());
    }));
    simulation.emplace(*resource);
  }
  runtime::Force force(const std::string& path, const std::string& value) {
    runtime::Force wanted;
    wanted.path = path;
    wanted.value = value;
    wanted.owner = "test";
    auto made = forces->set(std::move(wanted));
    EXPECT_TRUE(made) << made.error().message;
    return made ? *made : runtime::Force{};
  }
  /// Values of `path` after each scan, as executed again from the records.
  std::vector<std::string> replayed(const std::string& path) {
    recording->finish();
    const auto file = shadow::RecordFile::read(bytes, "recording");
    core::Diagnostics diagnostics;
    const auto player = shadow::Player::make(*file, diagnostics);
    std::vector<std::string> values;
    while (const auto played = (*player)->step()) {
      EXPECT_TRUE(played->outcome.equal) << "scan " << played->scan << ": " << played->outcome.differs;
      (*player)->show_globals();
      values.push_back(value_of((*player)->resource(), path));
    }
    return values;
  }
  std::unique_ptr<runtime::Resource> resource;
  std::optional<runtime::ForceList> forces;
  Bytes bytes;
  std::unique_ptr<shadow::Recording> recording;
  std::optional<runtime::Simulation> simulation;
};

class Forced : public testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Engines, Forced,
                         testing::Values(Setting{false, "wait-free"}, Setting{true, "wait-free"},
                                         Setting{true, "global-lock"}, Setting{true, "priority-ceiling"}),
                         [](const auto& one) {
                           std::string name =
                               std::string(one.param.native ? "native" : "interpreter") + "_" + one.param.coherence;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

struct TypeCase {
  const char* type;
  const char* value;   ///< that is forced
  const char* change;  ///< what the program makes of `x`
};
constexpr TypeCase kTypes[] = {
    {"BOOL", "1", "NOT x"},
    {"SINT", "-128", "x + 1"},
    {"INT", "-32768", "x + 1"},
    {"DINT", "-2147483648", "x + 1"},
    {"LINT", "-9223372036854775808", "x + 1"},
    {"USINT", "255", "x + 1"},
    {"UINT", "65535", "x + 1"},
    {"UDINT", "4294967295", "x + 1"},
    {"ULINT", "18446744073709551615", "x + 1"},
    {"BYTE", "165", "NOT x"},
    {"WORD", "42405", "NOT x"},
    {"DWORD", "2779096485", "NOT x"},
    {"LWORD", "11936128518282651045", "NOT x"},
    {"REAL", "1.5", "x + 1.0"},
    {"LREAL", "-2.25", "x + 1.0"},
    {"TIME", "1500000000", "x + T#1s"},
    {"LTIME", "1500", "x + LT#1s"},
    {"DATE", "1709164800000000000", "D#2000-01-01"},
    {"TOD", "3600000000000", "TOD#00:00:01"},
    {"DT", "1709168400000000000", "DT#2000-01-01-00:00:00"},
    {"STRING[20]", "'forced'", "CONCAT(x, 'y')"},
    {"WSTRING[20]", "\"forced\"", "\"other\""},
};

/// A program that changes a variable of the type at each place, where it may.
std::string source(const TypeCase& one) {
  std::string change = one.change;
  const auto of = [&change](const std::string& name) {
    std::string text = change;
    for (std::size_t at = text.find('x'); at != std::string::npos; at = text.find('x', at + name.size())) {
      text.replace(at, 1, name);
    }
    return name + " := " + text + ";\n";
  };
  const std::string type = one.type;
  return "VAR_GLOBAL Own, Both, Outside : " + type + "; Many : ARRAY [1..3] OF " + type +
         "; END_VAR\nFUNCTION_BLOCK Block\nVAR_INPUT i : " + type + "; END_VAR\nVAR_OUTPUT o : " + type +
         "; END_VAR\nVAR s : " + type + "; END_VAR\n" + of("s") +
         "o := i;\nEND_FUNCTION_BLOCK\nPROGRAM First\nVAR local, seen : " + type +
         "; b : Block; END_VAR\nVAR_EXTERNAL Own, Both, Outside : " + type + "; Many : ARRAY [1..3] OF " + type +
         "; END_VAR\nseen := Own;\n" + of("Own") + of("Both") + of("local") + "b(i := Outside);\n" + of("Many[2]") +
         "END_PROGRAM\nPROGRAM Second\nVAR seen, also, out : " + type +
         "; END_VAR\nVAR_EXTERNAL Own, Both, Outside : " + type +
         "; END_VAR\nseen := Own; also := Both; out := Outside;\n" + of("Both") +
         "END_PROGRAM\nCONFIGURATION C RESOURCE R ON PLC TASK A(INTERVAL := T#10ms, PRIORITY := 0); TASK B(INTERVAL := "
         "T#20ms, "
         "PRIORITY := 1); PROGRAM first WITH A : First; PROGRAM second WITH B : Second; END_RESOURCE "
         "END_CONFIGURATION\n";
}

TEST_P(Forced, EveryTypeAtEveryPlaceIsHeldInEachScan) {
  for (const TypeCase& one : kTypes) {
    for (const char* const path : {"Own", "Both", "Outside", "Many[2]", "first.local", "first.b.s", "first.b.i"}) {
      Plant plant(source(one), GetParam());
      plant.simulation->run_cycles(4);
      const std::uint64_t before = plant.simulation->scans(0) + plant.simulation->scans(1);
      const runtime::Force made = plant.force(path, one.value);
      EXPECT_EQ(plant.force(path, made.value).value, made.value) << "what is shown can be entered";
      for (int cycle = 0; cycle < 6; ++cycle) {
        plant.simulation->step();
        EXPECT_EQ(value_of(*plant.resource, path), one.value) << one.type << " " << path << ", cycle " << cycle;
      }
      // What others have seen of it.
      if (path == std::string("Own")) {
        EXPECT_EQ(value_of(*plant.resource, "first.seen"), one.value) << one.type;
        EXPECT_EQ(value_of(*plant.resource, "second.seen"), one.value) << one.type;
      }
      if (path == std::string("Both")) {
        EXPECT_EQ(value_of(*plant.resource, "second.also"), one.value) << one.type;
      }
      if (path == std::string("Outside")) {
        EXPECT_EQ(value_of(*plant.resource, "first.b.o"), one.value) << one.type;
        EXPECT_EQ(value_of(*plant.resource, "second.out"), one.value) << one.type;
      }
      const std::uint64_t after = plant.simulation->scans(0) + plant.simulation->scans(1);
      EXPECT_TRUE(plant.forces->release(path));
      // An odd number: NOT changes it back and forth, in both tasks.
      plant.simulation->run_cycles(3);
      const bool back_and_forth = one.change == std::string("NOT x") && path == std::string("Both");
      if (!back_and_forth && path != std::string("Outside") && path != std::string("first.b.i") &&
          one.change[0] != 'D' && one.change[0] != 'T') {
        EXPECT_NE(value_of(*plant.resource, path), one.value) << one.type << " " << path << " is the program's again";
      }
      const std::vector<std::string> values = plant.replayed(path);
      ASSERT_EQ(values.size(), plant.simulation->scans(0) + plant.simulation->scans(1));
      for (std::uint64_t scan = before; scan < after; ++scan) {
        // Another task's scan may not have it yet in the first instant.
        if (scan > before) {
          EXPECT_EQ(values[scan], one.value) << one.type << " " << path << ", record " << scan;
        }
      }
    }
  }
}

TEST(ForceList, OwnersReasonsAndTheirEnd) {
  Plant plant(source(kTypes[3]), {false, "wait-free"});
  runtime::Force force;
  force.path = "OWN";
  force.value = "16#FF";
  force.owner = "ann";
  force.reason = "valve 3 is being changed";
  force.until_mono_ns = 5'000;
  ASSERT_TRUE(plant.forces->set(force));
  force.path = "first.local";
  force.owner = "bob";
  force.until_mono_ns.reset();
  const auto local = plant.forces->set(force);
  ASSERT_TRUE(local);
  EXPECT_TRUE(local->yields);
  force.path = "Outside";
  EXPECT_FALSE(plant.forces->set(force)->yields);
  ASSERT_EQ(plant.forces->list().size(), 3u);
  EXPECT_EQ(plant.forces->list()[0].reason, "valve 3 is being changed");
  EXPECT_EQ(plant.forces->list()[0].value, "255");
  // The same variable by another name: replaced.
  force.path = "Own";
  force.value = "7";
  ASSERT_TRUE(plant.forces->set(force));
  EXPECT_EQ(plant.forces->size(), 3u);
  plant.simulation->run_cycles(1);
  EXPECT_EQ(value_of(*plant.resource, "Own"), "7");
  force.until_ns = 1;  // UTC, which may be set: it ends nothing
  force.until_mono_ns = 9'000;
  ASSERT_TRUE(plant.forces->set(force));
  EXPECT_TRUE(plant.forces->expire(8'999).empty());
  const auto over = plant.forces->expire(9'000);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_EQ(over[0].path, "Own");
  EXPECT_EQ(plant.forces->release_all("ann"), 0u);
  EXPECT_EQ(plant.forces->release_all("bob"), 2u);
  EXPECT_FALSE(plant.forces->release("Own"));
}

TEST(ForceList, WritesFromOutsideAreRefusedUntilItIsReleased) {
  Plant plant(source(kTypes[3]), {true, "wait-free"});
  plant.force("Outside", "5");
  const runtime::Access find(*plant.resource);
  const auto place = find.find("Outside");
  runtime::Access access(*plant.resource);
  const auto refused = access.write(*place, "6");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->message, "the variable is forced");
  EXPECT_TRUE(plant.forces->holds(*place));
  plant.simulation->run_cycles(2);
  EXPECT_EQ(value_of(*plant.resource, "Outside"), "5");
  EXPECT_TRUE(plant.forces->release("Outside"));
  EXPECT_FALSE(access.write(*place, "6"));
  plant.simulation->run_cycles(2);
  EXPECT_EQ(value_of(*plant.resource, "first.b.o"), "6");
}

TEST(ForceList, RefusesWhatCannotBeForced) {
  Plant plant(source(kTypes[2]), {false, "wait-free"});
  const auto code = [&](const std::string& path, const std::string& value) {
    runtime::Force force;
    force.path = path;
    force.value = value;
    const auto made = plant.forces->set(force);
    return made ? std::string() : std::string(core::info(made.error().code).name);
  };
  EXPECT_EQ(code("Nothing", "1"), "P7101");
  EXPECT_EQ(code("Many", "1"), "P7102");
  EXPECT_EQ(code("Own", "x"), "P7103");
  EXPECT_EQ(code("Own", "70000"), "P7104");
  EXPECT_EQ(plant.forces->size(), 0u);
}

}  // namespace
}  // namespace plc::test
