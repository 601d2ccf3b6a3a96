// The seeds of the image fuzzer: listings of images that the verifier accepts, kept as golden files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "bytecode/image.h"
#include "tests/support/golden.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

/// Opcodes that only the body of a task may have.
bool is_critical(Opcode opcode) {
  return opcode == Opcode::kReschedule || opcode == Opcode::kLock || opcode == Opcode::kUnlock;
}

/// One instruction of every opcode whose operands are leaves only, in a program.
Image every_plain_opcode() {
  ImageBuilder b;
  PouBuilder p = b.pou("All", PouKind::kProgram);
  std::vector<Word> leaf(core::kRepCount);
  const auto variable = [&](core::Rep rep, std::uint32_t type) {
    leaf[static_cast<std::size_t>(rep)] = p.variable(std::string(core::rep_name(rep)), type);
  };
  for (const TypeId id : {TypeId::kBool, TypeId::kSint, TypeId::kUsint, TypeId::kInt, TypeId::kUint, TypeId::kDint,
                          TypeId::kUdint, TypeId::kLint, TypeId::kUlint, TypeId::kReal, TypeId::kLreal}) {
    variable(core::rep_of(id), b.type(id));
  }
  variable(core::Rep::kStr, b.string(10));
  variable(core::Rep::kWstr, b.string(5, TypeId::kWstring));
  variable(core::Rep::kRef, b.ref(b.type(TypeId::kInt)));
  for (std::size_t code = 0; code < bytecode::opcodes().size(); ++code) {
    const bytecode::Operands& operands = bytecode::opcodes()[code].operands;
    std::vector<Word> words;
    for (std::uint8_t i = 0; i < operands.count; ++i) {
      for (std::size_t rep = 0; rep < core::kRepCount && words.size() == i; ++rep) {
        if ((operands.specs[i].reps & bytecode::mask_of(static_cast<core::Rep>(rep))) != 0) words.push_back(leaf[rep]);
      }
    }
    const auto opcode = static_cast<Opcode>(code);
    const bool plain = words.size() == operands.count && opcode != Opcode::kReturn && !is_critical(opcode);
    if (plain) p.list(opcode, 0, words);
  }
  b.task("T", 1'000'000, {p.finish()});
  return b.build();
}

/// Two tasks that exchange globals in critical sections.
Image sections(core::Coherence coherence) {
  ImageBuilder b;
  b.image.options.coherence = coherence;
  const std::uint32_t dint = b.type(TypeId::kDint);
  std::vector<Word> globals;
  for (std::uint32_t task = 0; task < 2; ++task) {
    globals.push_back(b.global("g" + std::to_string(task), dint, {}, {.owner = task}));
  }
  const Word both = b.global("both", dint);
  for (std::uint32_t task = 0; task < 2; ++task) {
    PouBuilder p = b.pou("P" + std::to_string(task), PouKind::kProgram);
    p.op(Opcode::kAdd32, {globals[task], globals[task], globals[1 - task]}).op(Opcode::kMove32, {both, globals[task]});
    b.task("T" + std::to_string(task), 1'000'000, {p.finish()}, static_cast<std::int32_t>(task));
  }
  return b.build();
}

void expect_accepted(Image image, const std::string& what) {
  core::Diagnostics diagnostics;
  const auto verified = bytecode::verify(std::move(image), diagnostics);
  std::ostringstream out;
  diagnostics.render(out);
  EXPECT_TRUE(verified) << what << '\n' << out.str();
}

TEST(Seeds, AreListingsOfTheSampleOfEveryPlainOpcodeAndOfSections) {
  expect_golden("tests/fuzz/corpus/verify_image/sample.pasm", bytecode::disassemble(sample_image().image));
  expect_golden("tests/fuzz/corpus/verify_image/drawn.pasm", bytecode::disassemble(whole_sample_image()));
  Sample probed = sample_image();
  add_sample_probes(probed);
  expect_golden("tests/fuzz/corpus/verify_image/probes.pasm", bytecode::disassemble(probed.image));
  expect_golden("tests/fuzz/corpus/verify_image/opcodes.pasm", bytecode::disassemble(every_plain_opcode()));
  expect_golden("tests/fuzz/corpus/verify_image/lock.pasm",
                bytecode::disassemble(sections(core::Coherence::kGlobalLock)));
  expect_golden("tests/fuzz/corpus/verify_image/ceilings.pasm",
                bytecode::disassemble(sections(core::Coherence::kPriorityCeiling)));
}

TEST(Seeds, AreAccepted) {
  std::size_t seeds = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_root() / "tests/fuzz/corpus/verify_image")) {
    if (entry.path().extension() != ".pasm") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    auto image = bytecode::assemble(text);
    ASSERT_TRUE(image) << entry.path() << ": " << image.error().message;
    expect_accepted(std::move(*image), entry.path());
    ++seeds;
  }
  EXPECT_GE(seeds, 4u);
}

}  // namespace
}  // namespace plc::test
