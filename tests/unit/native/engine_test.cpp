// Native code against the interpreter: tables, events and faults after every scan.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/image_mutator.h"
#include "tests/support/engines.h"
#include "tests/support/golden.h"
#include "tests/support/random_image.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

constexpr core::TimeNs kPeriodNs = 10'000'000;

/// Runs both engines; what differs first, or nothing.
std::string difference(const Image& image, int scans, bool must_load = true, std::uint32_t budget = 1000) {
  std::string problem;
  const auto engines = Engines::load(image, problem, {.loop_budget = budget});
  if (engines == nullptr) return must_load ? problem : std::string();
  for (int scan = 0; scan < scans; ++scan) {
    const std::string text = engines->scan(scan * kPeriodNs);
    if (!text.empty()) return "scan " + std::to_string(scan) + ": " + text;
  }
  return {};
}

TEST(NativeEngine, EveryInstructionOfTheSample) { EXPECT_EQ(difference(sample_image().image, 50), ""); }

TEST(NativeEngine, RandomPrograms) {
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    RandomImage random(seed);
    ASSERT_EQ(difference(random.make(4 + seed % 60), 12), "") << "seed " << seed;
  }
}

TEST(NativeEngine, MutationsOfTheSample) {
  Image image = sample_image().image;
  for (std::uint32_t seed = 1; seed <= 2000; ++seed) {
    Image mutant = image;
    ImageMutator mutator(mutant, seed);
    for (int n = 0; n < 3; ++n) mutator.gentle();
    ASSERT_EQ(difference(mutant, 4, false, 100), "") << "seed " << seed;
    // Go on from some that were accepted, so that programs drift away from the sample.
    core::Diagnostics diagnostics;
    if (bytecode::verify(Image(mutant), diagnostics)) image = std::move(mutant);
    if (seed % 100 == 0) image = sample_image().image;
  }
}

/// Variables that count through all their values, one scan each.
std::vector<Word> counting_inputs(ImageBuilder& b, PouBuilder& pou, Word bits) {
  const Word count = pou.variable("count", b.type(TypeId::kByte));
  std::vector<Word> inputs;
  for (Word bit = 0; bit < bits; ++bit) {
    inputs.push_back(pou.variable("in" + std::to_string(bit), b.boolean()));
    pou.op(Opcode::kExtract, {inputs.back(), count, bit});
  }
  pou.op(Opcode::kAdd8, {count, count, b.constant<std::uint8_t>(TypeId::kByte, 1)});
  return inputs;
}

/// Runs the program through all rows of its inputs.
void expect_all_rows(ImageBuilder& b, PouBuilder& main, int rows) {
  b.task("Cyclic", kPeriodNs, {main.finish()});
  EXPECT_EQ(difference(b.build(), rows), "");
}

TEST(NativeEngine, EveryFunctionOfFourInputs) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::vector<Word> in = counting_inputs(b, main, 4);
  const Word out = main.variable("out", b.array(b.boolean(), 1u << 16));
  constexpr std::uint32_t kAtOnce = 0x8000;
  for (std::uint32_t first = 0; first < 1u << 16; first += kAtOnce) {
    std::vector<Word> words;
    for (std::uint32_t truth = first; truth < first + kAtOnce; ++truth) {
      words.insert(words.end(), {truth * 0x10001u, out + truth, in[0], in[1], in[2], in[3], in[0]});
    }
    main.list(Opcode::kBoolRun, kAtOnce, std::move(words));
  }
  expect_all_rows(b, main, 16);
}

TEST(NativeEngine, ASampleOfFunctionsOfFiveInputs) {
  std::mt19937 random(3);
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::vector<Word> in = counting_inputs(b, main, 5);
  constexpr std::uint32_t kFunctions = 20'000;
  const Word out = main.variable("out", b.array(b.boolean(), kFunctions));
  std::vector<Word> words;
  for (std::uint32_t n = 0; n < kFunctions; ++n) {
    words.insert(words.end(), {static_cast<Word>(random()), out + n});
    std::shuffle(in.begin(), in.end(), random);
    words.insert(words.end(), in.begin(), in.end());
  }
  main.list(Opcode::kBoolRun, kFunctions, std::move(words));
  expect_all_rows(b, main, 32);
}

TEST(NativeEngine, GoesOnWhereTheInterpreterWas) {
  RandomImage random(7);
  const Image image = random.make(30);
  const auto load = [&image] {
    core::Diagnostics diagnostics;
    auto verified = bytecode::verify(Image(image), diagnostics);
    auto loaded = runtime::Resource::load(std::move(*verified), {.loop_budget = 100});
    return std::move(*loaded);
  };
  const auto plain = load();
  const auto swapped = load();
  runtime::Program& program = swapped->program(0);
  EXPECT_FALSE(program.is_compiled());
  for (int scan = 0; scan < 30; ++scan) {
    if (scan == 10) {
      auto compiled = native::compile(program);
      ASSERT_TRUE(compiled.has_value()) << compiled.error().message;
      program.install(std::move(*compiled));
    }
    EXPECT_EQ(static_cast<int>(plain->program(0).execute({scan * kPeriodNs}).kind),
              static_cast<int>(program.execute({scan * kPeriodNs}).kind));
    EXPECT_EQ(program.is_compiled(), scan >= 10);
    ASSERT_EQ(std::memcmp(plain->program(0).table().data(), program.table().data(), program.table().layout().total), 0);
  }
  EXPECT_EQ(program.event_total(), plain->program(0).event_total());
}

TEST(NativeEngine, APlaceInsideTheInterpretersShareNamesItsInstruction) {
  // An endless loop around an instruction that the interpreter runs.
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word text = main.variable("text", b.string(3));
  const Word source = b.text("abcdef");
  const std::uint32_t top = main.here();
  main.op(Opcode::kMoveStr, {text, source});
  const std::uint32_t loop = main.here();
  main.op(Opcode::kLoopJump, {top});
  b.task("Cyclic", kPeriodNs, {main.finish()});
  std::string problem;
  const auto engines = Engines::load(b.build(), problem, {.loop_budget = 9});
  ASSERT_NE(engines, nullptr) << problem;
  EXPECT_EQ(engines->scan(0), "");
  runtime::Program& program = (*engines)[1].program(0);
  const auto events = program.events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].word, top);
  EXPECT_EQ(events[0].count, 10u);
  EXPECT_EQ(program.place(runtime::FaultKind::kWatchdog).word, loop);
  const auto compiled = native::compile(program);
  ASSERT_TRUE(compiled.has_value());
  EXPECT_EQ((*compiled)->report().interpreted.at(runtime::ResolvedOp::kMoveStr), 1u);
}

TEST(NativeEngine, ManyTaskblocksInARowStopWhereOneFails) {
  ImageBuilder b;
  const std::uint32_t block = add_taskblock(b, registry_with_failures(), kFailingTaskblock).value();
  const std::uint32_t type = b.image.blocks[block].type;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  constexpr std::uint32_t kBlocks = 40, kFails = 23;
  std::uint32_t at_failing = 0;
  for (std::uint32_t i = 0; i < kBlocks; ++i) {
    const Word instance = main.variable("b" + std::to_string(i), type);
    if (i == kFails) at_failing = main.here();
    main.op(Opcode::kRunTb, {block, instance});
  }
  b.task("Cyclic", kPeriodNs, {main.finish()});
  const Image image = b.build();
  std::string problem;
  const auto engines = Engines::load(image, problem, {.taskblocks = &registry_with_failures()});
  ASSERT_NE(engines, nullptr) << problem;
  const auto port = [&](runtime::Program& program, std::uint32_t of, const char* name) {
    const auto& fields = image.types[type].fields;
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == name; });
    return program.table().data() + program.table().layout().instance +
           image.types[image.pous[0].instance_type].fields[of].offset + field->offset;
  };
  EXPECT_EQ(engines->scan(0), "");
  for (std::size_t e = 0; e < engines->size(); ++e) *port((*engines)[e].program(0), kFails, "BAD") = std::byte{1};
  EXPECT_EQ(engines->scan(kPeriodNs), "");
  runtime::Program& program = (*engines)[1].program(0);
  EXPECT_EQ(engines->fault().kind, runtime::FaultKind::kTaskblock);
  EXPECT_EQ(engines->fault().word, at_failing);
  EXPECT_EQ(*port(program, kFails - 1, "COUNT"), std::byte{2});
  EXPECT_EQ(*port(program, kFails, "COUNT"), std::byte{1});
  EXPECT_EQ(*port(program, kFails + 1, "COUNT"), std::byte{1});
  const auto compiled = native::compile(program);
  ASSERT_TRUE(compiled.has_value());
  EXPECT_EQ((*compiled)->report().interpreted.at(runtime::ResolvedOp::kRunTaskblock), kBlocks);
}

/// SHL of a DWORD by an INT, which code leaves to the library when the INT is negative.
std::string shift_left() {
  const auto overloads = stdlib::overloads_named("SHL");
  const auto found = std::find_if(overloads.begin(), overloads.end(), [](const stdlib::Overload& overload) {
    return overload.t == TypeId::kDword && overload.u == TypeId::kInt;
  });
  return stdlib::key_of(*found);
}

TEST(NativeEngine, RareCodeAfterABodyOfManyInterpretedInstructions) {
  // What is copied for the interpreter is longer than the code itself: nothing may point into the copy.
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word value = main.variable("value", b.type(TypeId::kDword), FieldRole::kLocal, bytes_of(0x80000001u));
  const Word by = main.variable("by", b.type(TypeId::kInt), FieldRole::kLocal, bytes_of(std::int16_t{-1}));
  const Word text = main.variable("text", b.string(3));
  const Word source = b.text("abcdef");
  main.call_std(shift_left(), value, {value, by});
  for (int i = 0; i < 5000; ++i) main.op(Opcode::kMoveStr, {text, source});
  b.task("Cyclic", kPeriodNs, {main.finish()});
  EXPECT_EQ(difference(b.build(), 3), "");
}

TEST(NativeEngine, ABodyOfManyRareCases) {
  // So many that they lie further after it than conditional jumps of some processors reach.
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word value = main.variable("value", b.type(TypeId::kDword), FieldRole::kLocal, bytes_of(0x80000001u));
  const Word by = main.variable("by", b.type(TypeId::kInt), FieldRole::kLocal, bytes_of(std::int16_t{-1}));
  const Word number = main.variable("number", b.type(TypeId::kDint), FieldRole::kLocal, bytes_of(std::int32_t{7}));
  const Word zero = main.variable("zero", b.type(TypeId::kDint));
  const std::string shift = shift_left();
  for (int i = 0; i < 15'000; ++i) {
    main.call_std(shift, value, {value, by});
    main.op(Opcode::kDivI32, {number, number, zero});
    main.op(Opcode::kAdd32, {number, number, value});
  }
  b.task("Cyclic", kPeriodNs, {main.finish()});
  EXPECT_EQ(difference(b.build(), 3), "");
}

TEST(NativeEngine, VariablesFarAway) {
  // Beyond 4 KiB and 16 MiB, in a program and in a function block with two instances.
  ImageBuilder b;
  const auto use = [&b](PouBuilder& pou) {
    const Word element = pou.variable("element", b.type(TypeId::kDint), FieldRole::kLocal, bytes_of(std::int32_t{3}));
    for (const std::uint32_t bytes : {5'000u, 17u << 20}) {
      const std::string suffix = std::to_string(bytes);
      pou.variable("room" + suffix, b.array(b.type(TypeId::kByte), bytes));
      const std::uint32_t array = b.array(b.type(TypeId::kInt), 5);
      const Word row = pou.variable("row" + suffix, array);
      const Word bit = pou.variable("bit" + suffix, b.boolean());
      const Word small = pou.variable("small" + suffix, b.type(TypeId::kInt));
      const Word count = pou.variable("count" + suffix, b.type(TypeId::kDint));
      const Word real = pou.variable("real" + suffix, b.type(TypeId::kReal));
      const Word wide = pou.variable("wide" + suffix, b.type(TypeId::kLint));
      const Word timer = pou.variable("timer" + suffix, b.image.blocks[b.block("TON")].type);
      pou.op(Opcode::kAdd32, {count, count, b.constant<std::int32_t>(TypeId::kDint, 3)});
      pou.op(Opcode::kAddF32, {real, real, b.constant<float>(TypeId::kReal, 0.1f)});
      pou.op(Opcode::kAdd64, {wide, wide, b.constant<std::int64_t>(TypeId::kLint, -5)});
      pou.op(Opcode::kDivI32, {count, count, element});
      pou.op(Opcode::kAdd16, {small, small, b.constant<std::int16_t>(TypeId::kInt, 1)});
      pou.path(Opcode::kStoreAt, {row, small, array}, {{PathStep::kIndex, element}});
      pou.op(Opcode::kLtI16, {bit, small, b.constant<std::int16_t>(TypeId::kInt, 4)});
      pou.list(Opcode::kBoolRun, 1, {0x55555555u, bit, bit, bit, bit, bit, bit});
      pou.op(Opcode::kRunTb, {b.block("TON"), timer});
    }
  };
  PouBuilder block = b.pou("Block", PouKind::kFunctionBlock);
  use(block);
  const std::uint32_t pou = block.finish();
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  use(main);
  for (const char* const name : {"first", "second"}) main.op(Opcode::kCallPou, {pou, main.instance_of(name, pou)});
  b.task("Cyclic", kPeriodNs, {main.finish()});
  EXPECT_EQ(difference(b.build(), 5), "");
}

/// Which instructions have code of their own: a new one is one more line here.
TEST(NativeEngine, InstructionsOfTheInterpreter) {
  std::string text = "# Instructions that run in the interpreter when a task runs as native code.\n";
  for (std::size_t op = 0; op < static_cast<std::size_t>(runtime::ResolvedOp::kCount); ++op) {
    const auto resolved = static_cast<runtime::ResolvedOp>(op);
    if (native::operation_of(resolved).form == native::Form::kInterpreted) {
      text += std::string(native::name_of(resolved)) + "\n";
    }
  }
  expect_golden("tests/golden/interpreted_instructions.txt", text);
}

}  // namespace
}  // namespace plc::test
