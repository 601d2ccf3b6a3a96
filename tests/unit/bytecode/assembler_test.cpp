// Listing and assembler: text and image say the same, and what is wrong in a text is told with its line.
#include <gtest/gtest.h>

#include <string>

#include "bytecode/image.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using bytecode::assemble;
using bytecode::disassemble;
using bytecode::save;

TEST(Assembler, RoundTripKeepsEveryByte) {
  Sample s = sample_image();
  s.image.options = {core::Order::kDocument,
                     core::Compat::kBeremiz,
                     core::AddressProfile::kOverlay,
                     core::Coherence::kGlobalLock,
                     true,
                     false,
                     false,
                     core::FinalScan::kOn,
                     "Main \"x\"",
                     {"FIRST", "SECOND=a b"}};
  s.image.tasks[0].single = "go";
  const std::string text = disassemble(s.image);
  const auto image = assemble(text);
  ASSERT_TRUE(image) << image.error().message << "\n" << text;
  EXPECT_EQ(save(*image), save(s.image)) << text;
  EXPECT_EQ(disassemble(*image), text);
}

TEST(Assembler, TheListingNamesPlaces) {
  const std::string text = disassemble(sample_image().image);
  EXPECT_NE(text.find("ADD_16 g:level, g:level, c:c#0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("RUNTB b0, i:ton  ; \"TON\"\n"), std::string::npos);
  EXPECT_NE(text.find("| 0x00000002 i:ton.IN, i:run, g:go, i:run, i:run, i:run\n"), std::string::npos);
  EXPECT_NE(text.find("  init level = -7\n"), std::string::npos);
  EXPECT_NE(text.find("  init gain = nan\n"), std::string::npos);
  EXPECT_NE(text.find("  alias \"sensor\" global 3\n"), std::string::npos);
  EXPECT_NE(text.find("COND_JUMP f:t#0, L13\n"), std::string::npos);
}

TEST(Assembler, BytesThatNoValueExplainsAreKept) {
  Sample s = sample_image();
  s.image.global_initial[bytecode::offset_of(s.go) + 1] = std::byte{0x5a};  // padding
  const auto image = assemble(disassemble(s.image));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->global_initial, s.image.global_initial);
}

TEST(Assembler, EqualNamesGoByOffset) {
  ImageBuilder b;
  const Word first = b.global("x", b.type(TypeId::kInt), {}, {.list = "A"});
  const Word second = b.global("x", b.type(TypeId::kInt), bytes_of(std::int16_t{4}), {.list = "B"});
  const Word odd = b.global("with blank", b.type(TypeId::kInt));
  PouBuilder p = b.pou("P", PouKind::kProgram);
  p.op(Opcode::kAdd16, {first, second, odd});
  b.task("T", 0, {p.finish()});
  const Image image = b.build();
  const std::string text = disassemble(image);
  EXPECT_NE(text.find("ADD_16 g:x, g+2, g+4\n"), std::string::npos) << text;
  const auto again = assemble(text);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(save(*again), save(image));
}

TEST(Assembler, BrokenImagesAreListedToo) {
  const std::vector<std::byte> bytes = save(sample_image().image);
  for (std::size_t at = 24; at < bytes.size(); at += 3) {
    std::vector<std::byte> mutant = bytes;
    mutant[at] ^= std::byte{0x41};
    bytecode::reseal(mutant);
    const auto image = bytecode::load(mutant);
    if (image) {
      EXPECT_FALSE(disassemble(*image).empty());
    }
  }
}

TEST(Assembler, EveryTruncatedTextIsReadOrRefused) {
  const std::string text = disassemble(sample_image().image);
  for (std::size_t size = 0; size < text.size(); size += 7) {
    const auto image = assemble(std::string_view(text).substr(0, size));
    if (!image) {
      EXPECT_EQ(image.error().code, core::Code::P9001);
    }
  }
}

struct Wrong {
  const char* text;
  const char* message;
};

TEST(Assembler, MistakesAreToldWithTheirLine) {
  const std::string head =
      "image 7\n"                                  // 1
      "type 0 scalar INT\n"                        // 2
      "type 1 struct size 2 align 2\n"             // 3
      "  field \"x\" t0 at 0 member\n"             // 4
      "globals 1\n"                                // 5
      "constants 1\n"                              // 6
      "pou \"P\" program instance t1 frame t1\n";  // 7
  const Wrong wrongs[] = {
      {"FLY g:x", "line 8: \"FLY\" is no instruction"},
      {"ADD_16 g:x, g:x", "line 8: the line ends too early"},
      {"ADD_16 g:x, g:x, g:y", "line 8: \"g:y\" names nothing"},
      {"ADD_16 g:x, g:x, q:x", "line 8: \"q:x\" is no operand"},
      {"ADD_16 g:x, g:x, g:x, g:x", "line 8: \"g:x\" is too much"},
      {"RETURN\n\nJUMP L9", "line 10: label \"L9\" does not exist"},
      {"L1:\nL1:", "line 9: L1: is there twice"},
      {"| 1 g:x, g:x, g:x, g:x, g:x, g:x", "line 8: a record without BOOL_RUN"},
      {"instance x = 99999", "line 8: \"99999\" is not a number that fits here"},
      {"instance y = 1", "line 8: \"y\" is not in the table"},
      {"instance hex 1 0000", "line 8: the bytes do not fit the table"},
      {"LOAD_AT g:x, g:x, t0, 1", "line 8: \"1\" is no step of a path"},
      {"LOAD_AT g:x, g:x, t0, [", "line 8: \"[\" is no step of a path"},
      {"LOAD_AT g:x, g:x, t0, []", "line 8: \"[]\" is no step of a path"},
      {"LOAD_AT g:x, g:x, t0, .x", "line 8: \"x\" is not a number that fits here"},
      {"LOAD_AT g:x, g:x, t0, [g:y]", "line 8: \"g:y\" names nothing"},
      {"task \"T", "line 8: the quotes are not closed"},
  };
  for (const Wrong& wrong : wrongs) {
    const auto image = assemble(head + wrong.text + "\n");
    ASSERT_FALSE(image) << wrong.text;
    EXPECT_EQ(image.error().message, wrong.message);
    EXPECT_EQ(image.error().code, core::Code::P9001);
  }
  const auto unknown = assemble("image 7\ntype 0 scalar FLOAT\n");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message, "line 2: \"FLOAT\" is no elementary type");
}

}  // namespace
}  // namespace plc::test
