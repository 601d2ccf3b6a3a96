// An image with a task that counts, for tests of what looks at a plant: alarms, the engineering server.
//
// In: a builder that has the other globals. Out: an image whose task "Fast", every 10 ms, has a program Main that
// counts its scans in Count and in the global Total. Does not belong here: what else a plant has.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

#include "tests/support/image_builder.h"

namespace plc::test {

/// `step`: by which Total goes up with each scan.
inline bytecode::VerifiedImage counting_image(ImageBuilder& b, std::int32_t step) {
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word total = b.global("Total", dint, {}, {false, false, {}, {}, 0});
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word count = main.variable("Count", dint);
  main.op(Opcode::kAdd32, {count, count, b.constant<std::int32_t>(TypeId::kDint, 1)});
  main.op(Opcode::kAdd32, {total, total, b.constant<std::int32_t>(TypeId::kDint, step)});
  b.task("Fast", 10'000'000, {main.finish()});
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  if (!image) {
    for (const auto& found : diagnostics.all()) ADD_FAILURE() << found.message;
  }
  return std::move(*image);
}

}  // namespace plc::test
