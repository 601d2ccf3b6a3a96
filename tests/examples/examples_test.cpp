// The tests of the examples pass and see every contact; and they are worth something: a fault that is planted into a
// rung makes one of them fail.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A copy of an example, where its project can be changed.
class Example {
 public:
  explicit Example(const std::string& name) : name_(name) {
    for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(PLC_EXAMPLES) / name)) {
      if (!entry.is_regular_file()) continue;
      const std::string file = entry.path().filename().string();
      std::ofstream(folder_.file(file), std::ios::binary) << text_of(entry.path());
    }
    if (name != "cnc") return;
    fs::create_directory(folder_.file("build"));
    fs::copy_file(PLC_CNC_BLOCKS, folder_.file("build/libcnc.so"));
  }
  [[nodiscard]] std::string project() const { return folder_.file(name_ + ".xml"); }
  /// `plc test .` in its folder.
  [[nodiscard]] ToolResult test(const std::string& flags = "") const {
    return run_tool({"/bin/sh", "-ec", R"(cd "$0"; exec "$1" test . )" + flags, folder_.file(""), PLC_TOOL}, 300);
  }

 private:
  std::string name_;
  ScratchFolder folder_;
};

/// The start tag of element `id` of POU `pou`, to be changed; {0, 0} when there is none.
std::pair<std::size_t, std::size_t> tag_of(const std::string& xml, const std::string& pou, const std::string& id) {
  const std::size_t begin = xml.find("<pou name=\"" + pou + "\"");
  if (begin == std::string::npos) return {0, 0};
  const std::size_t end = xml.find("</pou>", begin);
  for (const char* kind : {"<contact localId=\"", "<coil localId=\""}) {
    const std::size_t at = xml.find(kind + id + "\"", begin);
    if (at < end) return {at, xml.find('>', at)};
  }
  return {0, 0};
}

/// Replaces `from` by `to`, or the other way round, in the tag.
bool swap_in_tag(std::string& xml, std::pair<std::size_t, std::size_t> tag, const std::string& from,
                 const std::string& to) {
  for (const auto& [a, b] : {std::pair(from, to), std::pair(to, from)}) {
    const std::size_t at = xml.find(a, tag.first);
    if (at >= tag.second) continue;
    xml.replace(at, a.size(), b);
    return true;
  }
  return false;
}

bool negate(std::string& xml, const std::string& pou, const std::string& id) {
  return swap_in_tag(xml, tag_of(xml, pou, id), "negated=\"true\"", "negated=\"false\"");
}
bool swap_set_and_reset(std::string& xml, const std::string& pou, const std::string& id) {
  return swap_in_tag(xml, tag_of(xml, pou, id), "storage=\"set\"", "storage=\"reset\"");
}
/// The coil writes nothing that anybody knows.
bool drop_coil(std::string& xml, const std::string& pou, const std::string& id) {
  const auto tag = tag_of(xml, pou, id);
  const std::size_t begin = xml.find("<coil", tag.first);
  if (tag.second == 0 || begin != tag.first) return false;
  const std::string end = "</coil>";
  xml.erase(begin, xml.find(end, begin) + end.size() - begin);
  return true;
}

struct Fault {
  const char* example;
  const char* pou;
  int rung;
  const char* what;
  bool (*plant)(std::string&, const std::string&, const std::string&);
  const char* element;
};
std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.example << " rung " << fault.rung << ": " << fault.what;
}

class PlantedFault : public ::testing::TestWithParam<Fault> {};

TEST_P(PlantedFault, IsFound) {
  const Fault fault = GetParam();
  const Example example(fault.example);
  std::string xml = text_of(example.project());
  ASSERT_TRUE(fault.plant(xml, fault.pou, fault.element)) << "the example was drawn anew: name another element here";
  std::ofstream(example.project(), std::ios::binary) << xml;
  const ToolResult result = example.test();
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_NE(result.out.find("  FAIL  "), std::string::npos) << "it is found by a test, not by the compiler\n"
                                                            << result.all();
}

INSTANTIATE_TEST_SUITE_P(
    Rungs, PlantedFault,
    ::testing::Values(Fault{"tank", "Station", 1, "the stop button is negated", negate, "5"},
                      Fault{"tank", "Station", 2, "StepMix does not hold StepA off", negate, "15"},
                      Fault{"tank", "Station", 3, "StepA is negated", negate, "23"},
                      Fault{"tank", "Station", 4, "StepB is set where it is reset", swap_set_and_reset, "33"},
                      Fault{"tank", "Station", 5, "nobody begins to drain", drop_coil, "40"},
                      Fault{"tank", "Station", 6, "StepDrain stays", drop_coil, "52"},
                      Fault{"tank", "Station", 7, "stop does not end StepB", drop_coil, "59"},
                      Fault{"tank", "Station", 8, "heat starts the mixer", negate, "72"},
                      Fault{"hmi", "Belt", 2, "the door is negated", negate, "7"},
                      Fault{"hmi", "Belt", 3, "the lamp test is negated", negate, "12"},
                      Fault{"hmi", "Belt", 4, "parts count while the belt stands", negate, "17"},
                      Fault{"cnc", "Interlocks", 4, "the door does not matter", negate, "29"},
                      Fault{"cnc", "Interlocks", 9, "a wrong program starts", negate, "73"},
                      Fault{"cnc", "Interlocks", 19, "M30 does not stop the spindle", negate, "149"}),
    [](const auto& param) { return std::string(param.param.example) + "_rung_" + std::to_string(param.param.rung); });

class ExampleTests : public ::testing::TestWithParam<std::string> {};

TEST_P(ExampleTests, PassAndSeeEveryContact) {
  const ToolResult result = Example(GetParam()).test("--cover-all");
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find(" 0 failed"), std::string::npos) << result.all();
}

TEST_P(ExampleTests, SayTheSameInEveryEngineAndOrder) {
  const Example example(GetParam());
  const auto passed = [&](const std::string& flags) {
    const ToolResult result = example.test(flags);
    EXPECT_EQ(result.code, 0) << flags << "\n" << result.all();
  };
  passed("--engine interp");
  passed("--engine native --seed 1");
  passed("--seed 2 --coherence=global-lock");
}

INSTANTIATE_TEST_SUITE_P(All, ExampleTests, ::testing::Values("tank", "hmi", "cnc", "three_tasks"),
                         [](const auto& param) { return param.param; });

/// Ids of all contacts of a POU.
std::vector<std::string> contacts_of(const std::string& xml, const std::string& pou) {
  std::vector<std::string> ids;
  const std::size_t begin = xml.find("<pou name=\"" + pou + "\"");
  const std::size_t end = xml.find("</pou>", begin);
  const std::string tag = "<contact localId=\"";
  for (std::size_t at = xml.find(tag, begin); at < end; at = xml.find(tag, at + 1)) {
    const std::size_t id = at + tag.size();
    ids.push_back(xml.substr(id, xml.find('"', id) - id));
  }
  return ids;
}

TEST(PlantedFaults, EachContactCounts) {
  for (const auto& [name, pou] :
       {std::pair("tank", "Station"), std::pair("hmi", "Belt"), std::pair("cnc", "Interlocks")}) {
    const Example example(name);
    const std::string xml = text_of(example.project());
    const std::vector<std::string> contacts = contacts_of(xml, pou);
    ASSERT_GE(contacts.size(), 7u);
    for (const std::string& id : contacts) {
      std::string changed = xml;
      ASSERT_TRUE(negate(changed, pou, id));
      std::ofstream(example.project(), std::ios::binary) << changed;
      EXPECT_EQ(example.test().code, 1) << name << ": no test notices that contact " << id << " is negated";
    }
  }
}

}  // namespace
