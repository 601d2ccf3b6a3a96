// What SWITCH costs a group that it does not choose: one jump for each of its blocks, and nothing more.
#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

TEST(Switch, AJumpLeadsPastEveryBlockOfAGroup) {
  const std::string project = PLC_CASES "/fbd/switch-runs-one-of-three-groups/project.xml";
  const ToolResult dump = run_tool({PLC_TOOL, "dump", project});
  ASSERT_EQ(dump.code, 0) << dump.err;
  const std::size_t body = dump.out.find("pou \"Logic\"");
  ASSERT_NE(body, std::string::npos) << dump.out;

  // Two lines for each block and outVariable: what it does, and the jump before it.
  std::istringstream lines(dump.out.substr(body, dump.out.find("\npou ", body) - body));
  std::multiset<std::string> guarded;
  std::string past;  // label that the last jump leads to, until it is reached
  for (std::string line; std::getline(lines, line);) {
    const std::string text = line.substr(std::min(line.find_first_not_of(' '), line.size()));
    const std::string opcode = text.substr(0, text.find(' '));
    if (opcode == "COND_JUMP") past = text.substr(text.rfind('L')) + ":";
    if (text == past) past.clear();
    for (const char* work : {"ADD_16", "SUB_16", "CALL_POU", "RUNTB"}) {
      if (opcode != work) continue;
      EXPECT_FALSE(past.empty()) << "runs whatever SWITCH says: " << text;
      guarded.insert(opcode);
    }
  }
  EXPECT_EQ(guarded, (std::multiset<std::string>{"ADD_16", "SUB_16", "CALL_POU", "RUNTB"})) << dump.out;
}

}  // namespace
}  // namespace plc::test
