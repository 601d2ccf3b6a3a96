// What one look-up record costs in each form the linker makes: ns per record, minimum and median of interleaved
// batches.
//
// In: nothing. Out: a table on standard output. Records have random offsets in N/2 BOOLs (at least 32) and random truth
// tables, so that branch prediction cannot learn anything. Does not belong here: ladders and comparisons with C
// (bench.cpp).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "runtime/resource.h"
#include "tests/support/image_builder.h"

namespace {

using plc::bytecode::Opcode;
using plc::bytecode::PouKind;
using plc::runtime::Resource;

struct Shape {
  const char* name;
  bool four_inputs;      ///< truth tables ignore the fifth input
  std::uint32_t stride;  ///< bytes between BOOLs; large ones leave the 64 KiB window
  bool two_instances;    ///< a relative body
};
constexpr Shape kShapes[] = {{"four inputs", true, 1, false},
                             {"five inputs", false, 1, false},
                             {"wide", false, 40, false},
                             {"five inputs, relative body", false, 1, true}};

std::unique_ptr<Resource> make(const Shape& shape, std::uint32_t records) {
  plc::test::ImageBuilder b;
  std::mt19937 random(records);
  const std::uint32_t bools = std::max<std::uint32_t>(records / 2, 32);
  // The wide shape must not fit a window whatever the number of BOOLs.
  const std::uint32_t stride = shape.stride == 1 ? 1 : std::max<std::uint32_t>(shape.stride, 400'000 / bools);
  auto logic = b.pou("Logic", PouKind::kFunctionBlock);
  const std::uint32_t base = logic.variable("v", b.array(b.boolean(), bools * stride));
  std::vector<std::uint32_t> words;
  for (std::uint32_t i = 0; i < records; ++i) {
    auto truth = static_cast<std::uint32_t>(random());
    if (shape.four_inputs) truth = (truth & 0xffffu) * 0x10001u;
    words.push_back(truth);
    for (int operand = 0; operand < 6; ++operand) {
      words.push_back(base + static_cast<std::uint32_t>(random() % bools) * stride);
    }
  }
  logic.list(Opcode::kBoolRun, records, words);
  const std::uint32_t fb = logic.finish();
  auto main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t first = main.instance_of("first", fb);
  main.op(Opcode::kCallPou, {fb, first});
  if (shape.two_instances) {
    const std::uint32_t second = main.instance_of("second", fb);
    const std::uint32_t never = main.jump(Opcode::kJump);
    main.op(Opcode::kCallPou, {fb, second});
    main.land(never);
  }
  b.task("T", 10'000'000, {main.finish()});
  plc::core::Diagnostics diagnostics;
  auto verified = plc::bytecode::verify(b.build(), diagnostics);
  if (!verified) return nullptr;
  auto resource = Resource::load(std::move(*verified));
  return resource ? std::move(*resource) : nullptr;
}

}  // namespace

int main() {
  std::printf("%-28s %8s %8s %8s   ns per record\n", "form", "records", "minimum", "median");
  for (const std::uint32_t records : {100u, 1000u, 10000u}) {
    constexpr std::size_t kBatches = 15;
    std::vector<std::unique_ptr<Resource>> resources;
    std::vector<std::vector<double>> times(std::size(kShapes));
    for (const Shape& shape : kShapes) {
      resources.push_back(make(shape, records));
      if (resources.back() == nullptr) return 1;
    }
    const std::uint32_t scans = 1'000'000 / records;
    for (std::size_t batch = 0; batch < kBatches; ++batch) {
      for (std::size_t i = 0; i < resources.size(); ++i) {
        const auto start = std::chrono::steady_clock::now();
        for (std::uint32_t scan = 0; scan < scans; ++scan) resources[i]->program(0).execute({});
        const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
        times[i].push_back(spent.count() / scans / records);
      }
    }
    for (std::size_t i = 0; i < resources.size(); ++i) {
      std::sort(times[i].begin(), times[i].end());
      std::printf("%-28s %8u %8.2f %8.2f\n", kShapes[i].name, records, times[i].front(), times[i][kBatches / 2]);
    }
  }
  return 0;
}
