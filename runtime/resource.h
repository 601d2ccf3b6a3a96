// Resource: a verified image made ready to run: the global table and one Program per task (IEC 61131-3, 6.8: a
// resource).
//
// In: VerifiedImage. Out: linked programs that schedulers (sched/) run and tools (access.h) look into.
// Does not belong here: threads, clocks, drivers.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "runtime/memory/process_image.h"
#include "runtime/program.h"

namespace plc::runtime {

class Resource {
 public:
  /// Links every task. Takes the image: programs point into it.
  static core::Result<std::unique_ptr<Resource>> load(bytecode::VerifiedImage image,
                                                      const ProgramOptions& options = {});

  /// The same image whose tasks are replicas (Program::link_replica()): task n takes what it asks for from replays[n],
  /// which outlive it. Its global table has what somebody puts there (GlobalTable::reset()).
  static core::Result<std::unique_ptr<Resource>> load_replicas(bytecode::VerifiedImage image, std::span<Replay> replays,
                                                               const ProgramOptions& options = {});

  /// Makes the objects of the taskblocks of all tasks, where ProgramOptions::start_taskblocks was false. Before
  /// anything runs, once. P7803 when one is not ready.
  std::optional<core::Problem> start_taskblocks();

  /// Other values than the initial ones: of the global table, and of the instance of each task. Typed as the verifier
  /// demands of initial values. Before the taskblocks start, and before anything runs.
  void restore(std::span<const std::byte> globals, std::span<const std::vector<std::byte>> instances);

  [[nodiscard]] const bytecode::Image& image() const { return image_.image(); }
  [[nodiscard]] GlobalTable& globals() { return globals_; }
  [[nodiscard]] const GlobalTable& globals() const { return globals_; }
  /// Overlapping direct addresses; schedulers sync it around each scan.
  [[nodiscard]] ProcessImage& process_image() { return process_image_; }
  [[nodiscard]] std::size_t task_count() const { return programs_.size(); }
  [[nodiscard]] Program& program(std::size_t task) { return *programs_[task]; }
  [[nodiscard]] const Program& program(std::size_t task) const { return *programs_[task]; }

 private:
  Resource(bytecode::VerifiedImage image, std::span<const std::int32_t> priorities)
      : image_(std::move(image)), globals_(image_.image(), priorities), process_image_(image_.image(), globals_) {}
  bytecode::VerifiedImage image_;
  GlobalTable globals_;
  ProcessImage process_image_;
  std::vector<std::unique_ptr<Program>> programs_;
};

}  // namespace plc::runtime
