// run_image: executes an accepted image for the fuzzer and looks whether its tables stay well typed.
//
// In: a verified image. Out: scans run; ends the process when a table holds what no program may put there (a BOOL other
// than 0 and 1, a string header beyond its type). Crashes and wild accesses are the sanitizers' business.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "runtime/record/replay.h"
#include "runtime/resource.h"
#include "shadow/probe_view.h"

namespace plc::test {

/// Ends the process when a BOOL or a string header under `at` is not what its type allows.
inline void expect_well_typed(const bytecode::Image& image, std::uint32_t index, const std::byte* at) {
  const bytecode::ImageType& type = image.types[index];
  switch (type.kind) {
    case bytecode::TypeKind::kScalar:
      if (bytecode::rep_of(type) == core::Rep::kBool && static_cast<unsigned>(*at) > 1) {
        std::fprintf(stderr, "a BOOL of %u in a %s\n", static_cast<unsigned>(*at), type.name.c_str());
        std::abort();
      }
      return;
    case bytecode::TypeKind::kString: {
      core::StringHeader header;
      std::memcpy(&header, at, sizeof header);
      if (header.capacity != type.capacity || header.length > type.capacity) {
        std::fprintf(stderr, "a string of %u in %u characters, declared %u\n", header.length, header.capacity,
                     type.capacity);
        std::abort();
      }
      return;
    }
    case bytecode::TypeKind::kArray:
      for (std::uint32_t i = 0; i < type.count && type.size != 0; ++i) {
        expect_well_typed(image, type.element, at + std::size_t{i} * image.types[type.element].size);
      }
      return;
    case bytecode::TypeKind::kStruct:
      for (const bytecode::ImageField& field : type.fields) expect_well_typed(image, field.type, at + field.offset);
      return;
    case bytecode::TypeKind::kRef:
      return;
  }
}

/// Runs every task `scans` times in turn; returns the number of scans. Images that the linker refuses run none.
inline std::uint64_t run_image(bytecode::VerifiedImage verified, unsigned scans) {
  runtime::ProgramOptions options;
  options.loop_budget = 100;
  auto loaded = runtime::Resource::load(std::move(verified), options);
  if (!loaded) return 0;
  runtime::Resource& resource = **loaded;
  const bytecode::Image& image = resource.image();
  std::uint64_t done = 0;
  for (unsigned scan = 0; scan < scans; ++scan) {
    for (std::size_t task = 0; task < resource.task_count() && task < 4; ++task) {
      runtime::Program& program = resource.program(task);
      program.execute({static_cast<core::TimeNs>(scan) * 100'000'000});
      ++done;
      const std::byte* const table = program.table().data();
      const runtime::TaskLayout& layout = program.table().layout();
      expect_well_typed(image, image.global_type, table);
      expect_well_typed(image, image.const_type, table + layout.constants);
      expect_well_typed(image, image.pous[image.tasks[task].body].instance_type, table + layout.instance);
      for (std::size_t pou = 0; pou < layout.frames.size(); ++pou) {
        if (layout.frames[pou] == runtime::TaskLayout::kAbsent) continue;
        expect_well_typed(image, image.pous[pou].frame_type, table + layout.frames[pou]);
      }
    }
    std::vector<std::byte> globals(resource.globals().size());
    resource.globals().copy(globals.data());
    expect_well_typed(image, image.global_type, globals.data());
  }
  return done;
}

/// Executes two scans of a task of an image with probe maps in a replica that looks at all of them: whatever the maps
/// say, nothing outside of the table is read.
inline void look_at_image(const bytecode::VerifiedImage& verified, std::uint32_t task) {
  runtime::Replay replay;
  runtime::ProgramOptions options;
  options.loop_budget = 100;
  auto program = runtime::Program::link_replica(verified, task, replay, options);
  if (!program) return;
  std::vector<runtime::ProbedPou> views;
  const auto pous = static_cast<std::uint32_t>(verified.image().pous.size());
  for (std::uint32_t pou = 0; pou < pous; ++pou) {
    views.push_back({pou, (*program)->table().layout().instance});
    for (const shadow::PouInstance& one : shadow::instances_of(**program, pou, 4)) views.push_back(one.view);
  }
  if ((*program)->look_at(views)) return;
  for (core::TimeNs scan = 0; scan < 2; ++scan) {
    runtime::RecordHead head;
    head.bytes = sizeof head;
    replay.begin(std::as_bytes(std::span(&head, 1)));
    (*program)->execute({scan * 100'000'000});
  }
}

}  // namespace plc::test
