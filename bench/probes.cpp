// What a replica costs that somebody looks at: drawn rungs with a probe at every contact, coil and pin, beside the same
// replica without probes and native code.
#include "bytecode/probes.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <memory>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/measurements.h"
#include "bench/scratch.h"
#include "bench/workload.h"
#include "compiler/compile.h"
#include "core/clock.h"
#include "native/compile.h"
#include "runtime/access.h"
#include "runtime/probes.h"
#include "runtime/record/replay.h"
#include "runtime/resource.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kScansPerBatch = 50;

bytecode::VerifiedImage compile(const Source& source) {
  const Scratch scratch;
  const std::string path = scratch.file(std::string("project.") + source.extension);
  std::ofstream(path, std::ios::binary) << source.project;
  compiler::Compilation compilation;
  compiler::Request request{path, {}, compiler::Goal::kRun};
  request.drawings = true;
  compiler::compile(request, compilation);
  if (!compilation.ok()) throw std::runtime_error("the project of the probe benchmark does not compile");
  return std::move(*compilation.image);
}

/// A replica whose records say that nothing came in; its inputs are set by hand.
class Side {
 public:
  Side(const bytecode::VerifiedImage& image, const std::vector<std::uint32_t>& inputs) : inputs_(inputs) {
    auto program = runtime::Program::link_replica(image, 0, replay_);
    if (!program) throw std::runtime_error(program.error().message);
    program_ = std::move(*program);
    head_.bytes = sizeof head_;
  }
  [[nodiscard]] runtime::Program& program() { return *program_; }
  /// The same scans on each side: one of the inputs changes before each.
  double batch(std::uint64_t first) {
    const core::TimeNs begin = clock_.now_ns();
    for (std::uint64_t scan = first; scan < first + kScansPerBatch; ++scan) {
      std::byte& input = program_->table().data()[inputs_[scan * 7919 % inputs_.size()]];
      input ^= std::byte{1};
      replay_.begin(std::as_bytes(std::span(&head_, 1)));
      good_ = !program_->execute({static_cast<core::TimeNs>(scan) * 1'000'000}) && good_;
    }
    return static_cast<double>(clock_.now_ns() - begin) / kScansPerBatch;
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  const std::vector<std::uint32_t>& inputs_;
  core::MonotonicClock clock_;
  runtime::Replay replay_;
  runtime::RecordHead head_;
  std::unique_ptr<runtime::Program> program_;
  bool good_ = true;
};

/// Places of BOOL inputs in the table.
std::vector<std::uint32_t> inputs_of(const bytecode::VerifiedImage& image, const Source& source) {
  const auto resource = runtime::Resource::load(bytecode::VerifiedImage(image));
  if (!resource) throw std::runtime_error(resource.error().message);
  const runtime::Access access(**resource);
  std::vector<std::uint32_t> inputs;
  for (const Variable& variable : source.variables) {
    if (variable.stimulus != Stimulus::kBool) continue;
    const auto place = access.find_leaf(variable.path);
    if (place) inputs.push_back(place->offset);
  }
  return inputs;
}

Verdict measure(const char* name, std::uint32_t rungs, std::uint32_t batches, bool limited) {
  Verdict verdict;
  const Source source = find_workload(name)->make(rungs, 1);
  const bytecode::VerifiedImage image = compile(source);
  const std::vector<std::uint32_t> inputs = inputs_of(image, source);
  Side plain(image, inputs), native(image, inputs), looked(image, inputs);
  if (auto compiled = native::compile(native.program())) native.program().install(std::move(*compiled));
  std::size_t steps = 0, points = 0;
  std::vector<runtime::ProbedPou> views;
  const runtime::TaskLayout& layout = looked.program().table().layout();
  const bytecode::ImagePou& body = image.image().pous[image.image().tasks[0].body];
  for (std::uint32_t pou = 0; pou < image.image().pous.size(); ++pou) {
    if (image.image().probes[pou].empty()) continue;
    // The program that is drawn.
    for (const bytecode::ImageField& field : image.image().types[body.instance_type].fields) {
      if (field.type != image.image().pous[pou].instance_type) continue;
      views.push_back({pou, layout.instance + field.offset});
    }
    steps += image.image().probes[pou].steps.size();
    points += image.image().probes[pou].points.size();
  }
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  if (const auto problem = looked.program().look_at(views)) throw std::runtime_error(problem->message);
  const double look_ms = static_cast<double>(clock.now_ns() - begin) / 1e6;
  std::vector<double> without, as_code, with;
  for (std::uint64_t batch = 0; batch < std::max(batches, 1u); ++batch) {
    without.push_back(plain.batch(batch * kScansPerBatch));
    as_code.push_back(native.batch(batch * kScansPerBatch));
    with.push_back(looked.batch(batch * kScansPerBatch));
  }
  const auto same = [&](Side& side) {
    return std::equal(side.program().table().data(), side.program().table().data() + layout.total,
                      plain.program().table().data());
  };
  std::size_t ran = 0;
  for (const runtime::ProbedPou& view : views) {
    const runtime::ProbeValues* const values = looked.program().probes()->find(view);
    const auto count = static_cast<std::uint32_t>(image.image().probes[view.pou].steps.size());
    for (std::uint32_t step = 0; values != nullptr && step < count; ++step) {
      if ((values->bits(step) & runtime::ProbeValues::kRan) != 0) ++ran;
    }
  }
  verdict.correct = plain.good() && native.good() && looked.good() && same(native) && same(looked) && ran > steps / 2;
  std::cout << fmt::format("  {} rungs {}: {} points, {} steps, map {} kB of an image of {} kB: {}\n", rungs, name,
                           points, steps, bytecode::pack_probes(image.image().probes).size() / 1000,
                           bytecode::save(image.image()).size() / 1000,
                           verdict.correct ? "results right" : "RESULTS WRONG");
  if (!verdict.correct || batches == 0) return verdict;
  std::cout << fmt::format(
      "    a scan: native {:.1f} us, interpreter {:.1f}, with all probes {:.1f}{}; linked in {:.0f} ms\n",
      median(as_code) / 1000, median(without) / 1000, median(with) / 1000,
      limited ? ", " + limit_text(median(with) / 1000, limit::kProbes, verdict) : "", look_ms);
  return verdict;
}

}  // namespace

Verdict measure_probes(std::uint32_t batches) {
  Verdict verdict;
  if (batches == 0) return measure("mixed", 100, 0, false);
  verdict.merge(measure("plain", 1'000, batches, true));
  verdict.merge(measure("mixed", 1'000, batches, true));
  verdict.merge(measure("plain", 10'000, batches / 10 + 1, false));
  verdict.merge(measure("mixed", 10'000, batches / 10 + 1, false));
  return verdict;
}

}  // namespace plc::bench
