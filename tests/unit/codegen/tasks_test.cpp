// Bodies of tasks: in which order they copy globals under each coherence protocol, and what they do around it.
#include "bytecode/codegen/tasks.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "bytecode/codegen/generate.h"
#include "bytecode/opcode.h"
#include "ir/check.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using bytecode::Opcode;
using test::ModuleBuilder;
using Names = std::vector<std::string>;

/// Tasks and BOOL globals; what reads and writes what is said by name.
struct Plant {
  ModuleBuilder m;
  std::map<std::string, std::uint32_t> globals;

  explicit Plant(core::Coherence coherence) { m.module.options.coherence = coherence; }

  std::uint32_t global(const std::string& name) {
    const auto known = globals.find(name);
    if (known != globals.end()) return known->second;
    return globals.emplace(name, m.global(name, ir::kBoolType)).first->second;
  }
  void task(const std::string& name, std::int32_t priority, const Names& reads, const Names& writes) {
    const std::uint32_t pou = m.pou("Program" + name);
    for (const Names* names : {&reads, &writes}) {
      for (const std::string& g : *names) global(g);
    }
    const std::uint32_t own = m.variable(pou, "own", ir::kBoolType);
    ir::Builder b = m.body(pou);
    for (const std::string& g : reads) b.store(b.variable(own), b.load(b.global(global(g))));
    for (const std::string& g : writes) b.store(b.global(global(g)), b.load(b.variable(own)));
    m.task(name, pou, name).priority = priority;
  }
  /// The body of each task, one line an instruction: mnemonic and the globals of its range, in the order of the table.
  std::vector<std::vector<std::string>> bodies() {
    EXPECT_TRUE(ir::check(m.module, m.diagnostics));
    const auto image = bytecode::generate(m.module, m.diagnostics);
    EXPECT_TRUE(image.has_value());
    std::vector<std::vector<std::string>> all;
    if (!image) return all;
    for (const bytecode::ImageTask& task : image->tasks) all.push_back(body(*image, task));
    core::Diagnostics verdict;
    EXPECT_TRUE(bytecode::verify(*image, verdict).has_value()) << bytecode::disassemble(*image);
    return all;
  }

 private:
  static std::vector<std::string> body(const bytecode::Image& image, const bytecode::ImageTask& task) {
    std::vector<std::string> lines;
    const std::vector<std::uint32_t>& code = image.pous[task.body].code;
    for (std::size_t at = 0; at < code.size();) {
      const auto opcode = static_cast<Opcode>(code[at]);
      const bytecode::OpcodeInfo& info = bytecode::info(opcode);
      std::string line(info.mnemonic);
      const bool ranged = opcode == Opcode::kReadN || opcode == Opcode::kWriteN || opcode == Opcode::kWriteChangedN ||
                          opcode == Opcode::kRaisePriority;
      for (std::uint32_t f = 0; ranged && f < code[at + 2]; ++f) {
        line += " " + image.types[image.global_type].fields[code[at + 1] + f].name;
      }
      lines.push_back(line);
      at += 1u + info.operands.count;  // no lists in bodies without paths
    }
    return lines;
  }
};

/// Low writes Own for itself, ForMiddle and ForHigh for others; Order comes from High, Key from nobody, and Mode is
/// written by two.
std::vector<std::vector<std::string>> three_tasks(core::Coherence coherence) {
  Plant p(coherence);
  p.task("High", 1, {"ForHigh", "Key"}, {"Order"});
  p.task("Middle", 2, {"ForMiddle"}, {"Mode"});
  p.task("Low", 3, {"Order", "Key"}, {"Own", "ForMiddle", "ForHigh", "Mode"});
  return p.bodies();
}

TEST(TaskBodies, WaitFreeOnesCopyAndNothingElse) {
  const auto bodies = three_tasks(core::Coherence::kWaitFree);
  ASSERT_EQ(bodies.size(), 3u);
  for (const auto& body : bodies) {
    for (const std::string& line : body) {
      for (const char* word : {"RAISE_PRIORITY", "RESCHEDULE", "LOCK", "UNLOCK"}) {
        EXPECT_NE(line.substr(0, line.find(' ')), word);
      }
    }
  }
  EXPECT_EQ(bodies[0], (Names{"READ_N Key Order ForHigh", "CALL_POU", "WRITE_N Order", "RETURN"}));
}

TEST(TaskBodies, ALockIsAroundTheCopiesAndNotAroundThePrograms) {
  const auto bodies = three_tasks(core::Coherence::kGlobalLock);
  ASSERT_EQ(bodies.size(), 3u);
  for (const auto& body : bodies) {
    ASSERT_GE(body.size(), 7u);
    EXPECT_EQ(body.front(), "LOCK");
    EXPECT_EQ(body[body.size() - 2], "UNLOCK");
    bool locked = false;
    for (const std::string& line : body) {
      EXPECT_EQ(line.rfind("READ_N ", 0) == 0 || line.rfind("WRITE_", 0) == 0, locked && line != "UNLOCK") << line;
      if (line == "LOCK" || line == "UNLOCK") locked = line == "LOCK";
    }
  }
}

TEST(TaskBodies, UnderCeilingsGroupsAscendAndThePriorityIsGivenBack) {
  const auto bodies = three_tasks(core::Coherence::kPriorityCeiling);
  ASSERT_EQ(bodies.size(), 3u);
  // The most urgent user of all it exchanges: it never has to rise, unless the machine has other priorities.
  EXPECT_EQ(bodies[0], (Names{"READ_N Key Order", "READ_N ForHigh", "RESCHEDULE", "CALL_POU", "WRITE_N Order",
                              "RESCHEDULE", "RETURN"}));
  // Its own priority is the ceiling of ForMiddle, and Mode goes by stamps.
  EXPECT_EQ(bodies[1],
            (Names{"READ_N ForMiddle", "READ_N Mode", "RESCHEDULE", "CALL_POU", "WRITE_CHANGED_N Mode", "RETURN"}));
  EXPECT_EQ(bodies[2],
            (Names{"READ_N Key", "READ_N Own", "READ_N Mode",                 // at its own priority
                   "RAISE_PRIORITY ForMiddle", "READ_N ForMiddle",            // at Middle's
                   "RAISE_PRIORITY Order", "READ_N Order", "READ_N ForHigh",  // at High's, raised once
                   "RESCHEDULE", "CALL_POU", "WRITE_N Own", "WRITE_CHANGED_N Mode", "RAISE_PRIORITY ForMiddle",
                   "WRITE_N ForMiddle", "RAISE_PRIORITY ForHigh", "WRITE_N ForHigh", "RESCHEDULE", "RETURN"}));
}

TEST(TaskBodies, ReadersOfOneCeilingAreCopiedAtOnce) {
  Plant p(core::Coherence::kPriorityCeiling);
  p.task("High", 0, {"a", "c", "e"}, {});
  p.task("Low", 5, {}, {"a", "b", "c", "d", "e"});
  const auto bodies = p.bodies();
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[1], (Names{"READ_N b d", "RAISE_PRIORITY a c e", "READ_N a c e", "RESCHEDULE", "CALL_POU",
                              "WRITE_N b d", "RAISE_PRIORITY a c e", "WRITE_N a c e", "RESCHEDULE", "RETURN"}))
      << "what has the same ceiling lies together, the least urgent first";
}

TEST(TaskBodies, EqualPrioritiesNeedNoCeiling) {
  Plant p(core::Coherence::kPriorityCeiling);
  p.task("A", 4, {"x"}, {"y"});
  p.task("B", 4, {"y"}, {"x"});
  for (const auto& body : p.bodies()) {
    ASSERT_EQ(body.size(), 6u);
    EXPECT_EQ(body, (Names{"READ_N y x", "RESCHEDULE", "CALL_POU", body[3], "RESCHEDULE", "RETURN"}));
    EXPECT_EQ(body[3].rfind("WRITE_N ", 0), 0u);
  }
}

TEST(TaskBodies, ATaskWithoutGlobalsExchangesNothing) {
  for (const core::Coherence coherence :
       {core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling, core::Coherence::kGlobalLock}) {
    Plant p(coherence);
    p.task("Busy", 0, {"a"}, {"b"});
    p.task("Alone", 1, {}, {});
    const auto bodies = p.bodies();
    ASSERT_EQ(bodies.size(), 2u);
    EXPECT_EQ(bodies[1], (Names{"CALL_POU", "RETURN"}));
  }
}

}  // namespace
}  // namespace plc
