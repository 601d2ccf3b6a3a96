// Scans that leave groups out against the interpreter: tables, events and faults after every scan, while tables are
// written from outside.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "runtime/compiled_task.h"
#include "tests/fuzz/image_mutator.h"
#include "tests/support/random_image.h"
#include "tests/support/sample_image.h"
#include "tests/support/two_engines.h"

namespace plc::test {
namespace {

constexpr core::TimeNs kPeriodNs = 10'000'000;

/// Never gives up leaving out; the default; gives up at the first change.
constexpr std::uint32_t kPatiences[] = {1'000'000, native::kPatience, 0};

/// Between scans, values that variables once had are written into both tables, as a person at a panel does.
class Outside {
 public:
  explicit Outside(std::uint32_t seed) : random_(seed) {}

  void write(runtime::Program& left, runtime::Program& right) {
    const std::size_t size = left.table().layout().total;
    if (before_.size() < 4 || random_() % 4 == 0) {
      if (before_.size() == 4) before_.erase(before_.begin());
      before_.emplace_back(left.table().data(), left.table().data() + size);
    }
    for (std::size_t n = random_() % 4; n > 0; --n) {
      const std::vector<std::byte>& from = before_[random_() % before_.size()];
      // Whole variables: all of them lie inside of words of 8 bytes or are made of such.
      const std::size_t words = 1 + random_() % 8;
      const std::size_t at = random_() % (size / 8) * 8;
      const std::size_t bytes = std::min(words * 8, size - at);
      std::memcpy(left.table().data() + at, from.data() + at, bytes);
      std::memcpy(right.table().data() + at, from.data() + at, bytes);
    }
  }

 private:
  std::mt19937 random_;
  std::vector<std::vector<std::byte>> before_;
};

struct Outcome {
  std::string difference;
  std::uint64_t skipped = 0;  ///< groups that scans left out
};

Outcome run(const Image& image, int scans, std::uint32_t seed, std::uint32_t patience, bool outside = true) {
  Outcome outcome;
  std::string problem;
  const auto engines = TwoEngines::load(image, problem, {.loop_budget = 200}, {.changed = true, .patience = patience});
  if (engines == nullptr) return outcome;
  Outside hand(seed);
  for (int scan = 0; scan < scans; ++scan) {
    // At times nothing happens outside, so that what is inside comes to rest; and time stands still.
    const bool quiet = scan / 8 % 2 == 1;
    for (std::size_t task = 0; task < engines->tasks() && outside && !quiet; ++task) {
      hand.write(engines->interpreted().program(task), engines->native().program(task));
    }
    const std::string text = engines->scan((quiet ? scan / 8 * 8 : scan) * kPeriodNs);
    if (!text.empty()) {
      outcome.difference = "scan " + std::to_string(scan) + ": " + text;
      return outcome;
    }
  }
  for (std::size_t task = 0; task < engines->tasks(); ++task) {
    const runtime::SkipCounts& counts = *engines->native().program(task).skipped();
    outcome.skipped += (counts.scans - counts.whole_scans) * counts.groups - counts.runs;
  }
  return outcome;
}

TEST(Changed, RandomProgramsUnderEveryPatience) {
  // PLC_PROGRAMS: how many, in place of a few.
  const char* const asked = std::getenv("PLC_PROGRAMS");
  const std::uint32_t programs = asked != nullptr ? static_cast<std::uint32_t>(std::strtoul(asked, nullptr, 10)) : 300;
  std::uint64_t skipped = 0;
  for (std::uint32_t seed = 0; seed < programs; ++seed) {
    RandomImage random(seed);
    const Image image = random.make(4 + seed % 60);
    for (const std::uint32_t patience : kPatiences) {
      const Outcome outcome = run(image, 48, seed, patience);
      ASSERT_EQ(outcome.difference, "") << "seed " << seed << ", patience " << patience;
      skipped += outcome.skipped;
    }
  }
  EXPECT_GT(skipped, programs * 100u);
}

TEST(Changed, MutationsOfTheSample) {
  Image image = sample_image().image;
  for (std::uint32_t seed = 1; seed <= 1000; ++seed) {
    Image mutant = image;
    ImageMutator mutator(mutant, seed);
    for (int n = 0; n < 3; ++n) mutator.gentle();
    ASSERT_EQ(run(mutant, 16, seed, kPatiences[seed % 3]).difference, "") << "seed " << seed;
    core::Diagnostics diagnostics;
    if (bytecode::verify(Image(mutant), diagnostics)) image = std::move(mutant);
    if (seed % 100 == 0) image = sample_image().image;
  }
}

}  // namespace
}  // namespace plc::test
