#include "tools/plc-run/recording.h"

#include <fmt/format.h>

#include <ostream>
#include <utility>

#include "bytecode/image.h"
#include "native/compile.h"
#include "shadow/arithmetic.h"
#include "tools/command_line.h"
#include "tools/version.h"

namespace plc::tools {
namespace {

constexpr std::uint64_t kMegabyte = 1u << 20;

/// A task that cannot be compiled stays with the interpreter: nobody has to be told, values are the same.
void compile_replicas(runtime::Resource& replicas) {
  for (std::size_t task = 0; task < replicas.task_count(); ++task) {
    if (auto compiled = native::compile(replicas.program(task))) replicas.program(task).install(std::move(*compiled));
  }
}

}  // namespace

RecordingSettings recording_settings(const std::string& given, const io::Configuration& configuration,
                                     const std::string& state, Engine engine) {
  const io::RecordConfig& record = configuration.record;
  RecordingSettings settings;
  settings.mode = record.mode;
  std::string folder = configuration.beside(record.folder.text);
  if (given == "off") {
    settings.mode = io::RecordMode::kOff;
  } else if (given == "on" || given == "check") {
    settings.mode = given == "on" ? io::RecordMode::kOn : io::RecordMode::kCheck;
  } else if (!given.empty()) {
    if (settings.mode == io::RecordMode::kOff) settings.mode = io::RecordMode::kOn;
    folder = given;
  }
  shadow::ShadowOptions& options = settings.options;
  options.recording.ring_bytes = record.ring_mb * kMegabyte;
  options.history_bytes = record.memory_mb * kMegabyte;
  options.check = settings.mode == io::RecordMode::kCheck;
  if (!folder.empty()) {
    options.folder.emplace();
    options.folder->path = folder;
    options.folder->most_bytes = record.folder_mb * kMegabyte;
  }
  if (!state.empty() && record.faults != 0) {
    options.fault_folder = state + "/records";
    options.crash_folder = shadow::CrashMemory::folder_of(state);
  }
  options.fault_files = record.faults;
  if (engine != Engine::kInterpreter) options.prepare = compile_replicas;
  return settings;
}

std::unique_ptr<shadow::Shadow> start_shadow(runtime::Resource& resource, RecordingSettings settings,
                                             std::uint32_t loop_budget, const std::string& zone,
                                             std::optional<core::Problem>& trouble) {
  if (settings.mode == io::RecordMode::kOff) return nullptr;
  const shadow::RecordingHead head = {
      kVersionText, shadow::processor_kind(),        shadow::arithmetic_fingerprint(), loop_budget,
      zone,         bytecode::save(resource.image())};
  auto started = shadow::Shadow::start(resource, std::move(settings.options), head);
  if (started) return std::move(*started);
  trouble = started.error();
  return nullptr;
}

void print_recording(const shadow::Shadow& shadow, std::ostream& out) {
  const shadow::RecordingCounts counts = shadow.counts();
  const double scans = counts.scans == 0 ? 1.0 : static_cast<double>(counts.scans);
  out << fmt::format(
      "recording: {} scans, {} left out; {:.1f} bytes a scan, {:.1f} compressed; the last {} in {:.1f} MB of memory",
      counts.scans, counts.lost, static_cast<double>(counts.record_bytes) / scans,
      static_cast<double>(counts.stored_bytes) / scans, duration_text(static_cast<double>(shadow.history_ns())),
      static_cast<double>(shadow.history_bytes()) / 1e6);
  if (!shadow.file().empty()) out << ", all in " << shadow.file();
  out << '\n';
}

}  // namespace plc::tools
