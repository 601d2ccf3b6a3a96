// Fuzzes the loader, the verifier, the listing and the runtime: whatever the bytes are, they are refused with a message
// or run without harm.
//
// Input: an image file, or assembler text (the seeds). The mutator works on the structure and makes the checksum right
// again, so that at least a fifth of the executions reach the runtime. At the end it prints executions, accepted
// images, scans and the rules hit. Needs -max_len=1000000: the limit on memory takes a file of 650 kB to pass.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "bytecode/image.h"
#include "bytecode/rules.h"
#include "tests/fuzz/image_mutator.h"
#include "tests/fuzz/run_image.h"
#include "tests/support/engines.h"

// Weak: the replay, which does not mutate, has none.
extern "C" __attribute__((weak)) std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size,
                                                              std::size_t max_size);

namespace {

using namespace plc;

constexpr std::size_t kExcess = 150;  ///< one mutation in so many passes a limit; there are seven

struct Tally {
  std::uint64_t executions = 0, loaded = 0, accepted = 0, scans = 0;
  std::set<std::string> rules;
  std::vector<bytecode::Image> pool;  ///< accepted images that the mutator goes on from
};
Tally& tally() {
  static Tally t;
  return t;
}
void print_tally() {
  const Tally& t = tally();
  std::fprintf(stderr,
               "verify_image: %llu executions, %llu loaded, %llu accepted (%.0f %%), %llu scans, %zu of %zu rules hit:",
               static_cast<unsigned long long>(t.executions), static_cast<unsigned long long>(t.loaded),
               static_cast<unsigned long long>(t.accepted),
               t.executions == 0 ? 0.0 : 100.0 * static_cast<double>(t.accepted) / static_cast<double>(t.executions),
               static_cast<unsigned long long>(t.scans), t.rules.size(), bytecode::rules().size());
  for (const std::string& rule : t.rules) std::fprintf(stderr, " %s", rule.c_str());
  std::fprintf(stderr, "\n");
}

bool is_text(const std::uint8_t* data, std::size_t size) { return size > 5 && std::memcmp(data, "image", 5) == 0; }

core::Result<bytecode::Image> read(const std::uint8_t* data, std::size_t size) {
  if (is_text(data, size)) return bytecode::assemble({reinterpret_cast<const char*>(data), size});
  return bytecode::load({reinterpret_cast<const std::byte*>(data), size});
}

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

/// Ends the process when an engine leaves anything else than the interpreter does.
void compare_engines(const bytecode::Image& image) {
  constexpr std::size_t kTasks = 4;  // more are a limit that is tried, not a program
  if (image.tasks.size() > kTasks) return;
  std::string problem;
  const auto engines = test::Engines::load(image, problem, {.loop_budget = 100});
  for (int scan = 0; engines != nullptr && scan < 3; ++scan) {
    const std::string difference = engines->scan(core::TimeNs{scan} * 100'000'000);
    if (!difference.empty()) fail(difference.c_str());
  }
}

/// Keeps a sample of the accepted images.
void keep(const bytecode::Image& image) {
  constexpr std::size_t kPool = 64;
  Tally& t = tally();
  if (t.pool.size() < kPool) {
    t.pool.push_back(image);
  } else if (t.accepted % 16 == 0) {
    t.pool[t.accepted / 16 % kPool] = image;
  }
}

bool is_accepted(const core::Result<bytecode::Image>& image) {
  core::Diagnostics ignored;
  return image && bytecode::verify(*image, ignored).has_value();
}

std::size_t mutate_bytes(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (!is_text(data, size)) bytecode::reseal({reinterpret_cast<std::byte*>(data), size});
  return size;
}

void note_rules(const core::Diagnostics& diagnostics) {
  for (const core::Diagnostic& d : diagnostics.all()) {
    const std::size_t at = d.message.find("(rule V");
    if (at != std::string::npos) tally().rules.insert(d.message.substr(at + 6, 4));
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  tally();
  std::atexit(print_tally);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Tally& t = tally();
  ++t.executions;
  auto image = read(data, size);
  if (!image) return 0;
  ++t.loaded;
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(*image, diagnostics);
  if (!verified) {
    if (!diagnostics.has_errors()) fail("refused without a reason");
    note_rules(diagnostics);
    if (t.executions % 16 == 0) bytecode::disassemble(*image);
    return 0;
  }
  ++t.accepted;
  keep(*image);
  if (t.executions % 16 == 0) {
    const auto again = bytecode::assemble(bytecode::disassemble(*image));
    if (!again) fail(again.error().message.c_str());
    if (bytecode::save(*again) != bytecode::save(*image)) fail("the listing does not say what the image says");
  }
  for (std::uint32_t task = 0; !image->probes.empty() && task < image->tasks.size() && task < 4; ++task) {
    test::look_at_image(*verified, task);
  }
  t.scans += test::run_image(std::move(*verified), 3);
  compare_engines(*image);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  // Room for the images that pass a limit; everything else stays quick to run.
  constexpr std::size_t kUsual = 20'000;
  std::vector<bytecode::Image>& pool = tally().pool;
  if (seed % 64 == 1 && size <= kUsual) return mutate_bytes(data, size, std::min(max_size, kUsual));
  // What is broken stays broken under most changes: go on from an accepted image instead.
  const auto pooled = [&] { return core::Result<bytecode::Image>(pool[seed / 8 % pool.size()]); };
  const bool large = size > kUsual && !pool.empty();
  auto image = large ? pooled() : read(data, size);
  if (!large && seed % 8 != 0 && !pool.empty() && !is_accepted(image)) image = pooled();
  if (!image) return mutate_bytes(data, size, std::min(max_size, std::max(size, kUsual)));
  test::ImageMutator mutator(*image, seed);
  if (mutator.below(kExcess) == 0) {
    mutator.excess();
  } else {
    const std::size_t changes = 1 + mutator.below(3);
    for (std::size_t i = 0; i < changes; ++i) mutator.gentle();
    if (mutator.below(8) == 0) mutator.rough();
  }
  const std::vector<std::byte> bytes = bytecode::save(*image);
  if (bytes.size() > max_size) return size;
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}
