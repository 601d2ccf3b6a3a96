// The opcode table: codes never move, mnemonics are unique, and operand lists keep the shapes the format promises.
#include "bytecode/opcode.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "bytecode/rules.h"
#include "tests/support/golden.h"

namespace plc::test {
namespace {

using bytecode::OperandKind;

TEST(Opcodes, CodesInImagesNeverMove) {
  std::string text;
  std::size_t code = 0;
  for (const bytecode::OpcodeInfo& op : bytecode::opcodes()) {
    text += std::to_string(code++) + ' ' + std::string(op.mnemonic);
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      text += ' ' + std::to_string(static_cast<unsigned>(op.operands.specs[i].kind)) + ':' +
              std::to_string(op.operands.specs[i].reps);
    }
    text += '\n';
  }
  expect_golden("tests/golden/opcodes.txt", text);
}

TEST(Opcodes, MnemonicsAreUnique) {
  std::set<std::string_view> seen;
  for (const bytecode::OpcodeInfo& op : bytecode::opcodes())
    EXPECT_TRUE(seen.insert(op.mnemonic).second) << op.mnemonic;
}

TEST(Opcodes, AListIsTheLastOperand) {
  for (const bytecode::OpcodeInfo& op : bytecode::opcodes()) {
    for (std::uint8_t i = 0; i + 1 < op.operands.count; ++i) {
      const OperandKind kind = op.operands.specs[i].kind;
      EXPECT_EQ(bytecode::words_per_item(kind), 0u) << op.mnemonic;
    }
  }
}

TEST(Opcodes, InstructionsFindTheirRow) {
  EXPECT_EQ(bytecode::info(bytecode::Opcode::kReturn).mnemonic, "RETURN");
  EXPECT_EQ(bytecode::info(bytecode::Opcode::kAddF64).mnemonic, "ADD_F64");
  EXPECT_EQ(bytecode::info(bytecode::Opcode::kWriteChangedN).mnemonic, "WRITE_CHANGED_N");
  EXPECT_EQ(bytecode::info(bytecode::Opcode::kDivI16).function, "DIV");
}

TEST(Opcodes, OperandWordsHoldSpaceAndOffset) {
  const std::uint32_t word = bytecode::operand_word(bytecode::Space::kConst, bytecode::kMaxTableBytes);
  EXPECT_EQ(bytecode::space_of(word), bytecode::Space::kConst);
  EXPECT_EQ(bytecode::offset_of(word), bytecode::kMaxTableBytes);
}

/// docs/reference/verifier.md: a text and the rows of rules.def.
TEST(Rules, ThePageListsThem) {
  std::string page =
      "<!-- Generated from bytecode/rules.def by a test; PLC_GOLDEN_UPDATE=1 rewrites it. -->\n"
      "# What the verifier checks\n\n"
      "The runtime takes a `VerifiedImage` only, and only `verify()` makes one. An accepted image cannot make the "
      "runtime\n"
      "read or write outside a typed place, whatever its values are at run time.\n\n"
      "## Equal types\n\n"
      "Some rules ask whether two type indices mean the same type. They do when the indices are equal, or when\n\n"
      "- both are scalars of one elementary type with the same limits (names do not count),\n"
      "- both are strings of one elementary type and capacity,\n"
      "- both are arrays with the same bounds and equal element types,\n"
      "- both are references with equal targets, where a target that is itself a reference or an array of references "
      "is\n"
      "  equal to its own index only (so the question always ends).\n\n"
      "Structures are equal to their own index only.\n\n"
      "## What the runtime still has to do\n\n"
      "- Handles of references may be null, and one read from the global table may have been made by another task: "
      "they\n"
      "  are checked when they are followed.\n"
      "- A place and what a reference refers to may be the same: copies allow overlap.\n"
      "- Strings given to functions may have another capacity than the parameter: they are copied as strings.\n"
      "- Limits of subranges and enumerations hold for initial values; code checks assignments by instructions of its "
      "own.\n"
      "- Loops are bounded by the budget of the task (LOOP_JUMP), everything else by rules V405 to V407.\n\n"
      "## Rules\n\n"
      "| rule | problem | holds in an accepted image |\n| --- | --- | --- |\n";
  for (const bytecode::RuleInfo& rule : bytecode::rules()) {
    const std::string code(core::info(rule.code).name);
    page += "| " + std::string(rule.id) + " | [" + code + "](../problems/" + code + ".md) | " +
            std::string(rule.meaning) + " |\n";
  }
  expect_golden("docs/reference/verifier.md", page);
}

}  // namespace
}  // namespace plc::test
