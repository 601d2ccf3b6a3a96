// The program that tests of recordings run.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "bytecode/image.h"
#include "tests/support/image_builder.h"

namespace plc::test {

/// Two tasks: each counts in a variable of its own and in a global of its own; Slow also adds what Fast has.
inline bytecode::VerifiedImage two_tasks() {
  ImageBuilder b;
  const std::uint32_t dint = b.type(core::TypeId::kDint);
  const Word one = b.constant<std::int32_t>(core::TypeId::kDint, 1);
  const Word fast_global = b.global("FastCount", dint, {}, {.owner = 0});
  const Word slow_global = b.global("SlowSum", dint, {}, {.owner = 1});
  PouBuilder fast = b.pou("Fast", PouKind::kProgram);
  const Word count = fast.variable("count", dint);
  fast.op(Opcode::kAdd32, {count, count, one});
  fast.op(Opcode::kMove32, {fast_global, count});
  b.task("Quick", 10'000'000, {fast.finish()}, 0);
  PouBuilder slow = b.pou("Slow", PouKind::kProgram);
  slow.op(Opcode::kAdd32, {slow_global, slow_global, fast_global});
  b.task("Lazy", 30'000'000, {slow.finish()}, 1);
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  EXPECT_TRUE(image);
  return std::move(*image);
}

}  // namespace plc::test
