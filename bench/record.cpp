// What recording costs: a scan that takes in some bytes, a checkpoint, executing recorded scans again, and how late a
// task of 1 ms wakes while everything it does is executed again beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/measurements.h"
#include "bench/process.h"
#include "bench/scratch.h"
#include "compiler/compile.h"
#include "core/clock.h"
#include "io-drivers/stimulus.h"
#include "native/compile.h"
#include "runtime/record/recorder.h"
#include "runtime/resource.h"
#include "runtime/sched/simulation.h"
#include "shadow/history.h"
#include "shadow/player.h"
#include "shadow/record_folder.h"
#include "shadow/recording.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kScansPerBatch = 200;
constexpr std::size_t kSweptBytes = 8u << 20;

std::unique_ptr<runtime::Resource> load(const std::string& path) {
  compiler::Compilation compilation;
  compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
  if (!compilation.ok()) throw std::runtime_error(path + " does not compile");
  auto loaded = runtime::Resource::load(std::move(*compilation.image));
  if (!loaded) throw std::runtime_error(loaded.error().message);
  // Where there is no native engine, the interpreter tells the same.
  for (std::size_t task = 0; task < (*loaded)->task_count(); ++task) {
    if (auto compiled = native::compile((*loaded)->program(task)))
      (*loaded)->program(task).install(std::move(*compiled));
  }
  return std::move(*loaded);
}

std::unique_ptr<runtime::Resource> load_text(const std::string& text) {
  const Scratch scratch;
  const std::string path = scratch.file("record.st");
  std::ofstream(path) << text;
  return load(path);
}

/// One task writes `dints` values, of which some change in each scan; another one takes them in.
std::string exchange_source(std::uint32_t dints) {
  return fmt::format(
      "VAR_GLOBAL Values : ARRAY [1..{0}] OF DINT; Sum : DINT; END_VAR\n"
      "PROGRAM Makes\nVAR n, i : DINT; END_VAR\nVAR_EXTERNAL Values : ARRAY [1..{0}] OF DINT; END_VAR\n"
      "n := n + 1;\nFOR i := 1 TO {0} BY {1} DO Values[i] := Values[i] + n; END_FOR;\nEND_PROGRAM\n"
      "PROGRAM Takes\nVAR_EXTERNAL Values : ARRAY [1..{0}] OF DINT; Sum : DINT; END_VAR\n"
      "Sum := Sum + Values[1] + Values[{0}];\nEND_PROGRAM\n"
      "CONFIGURATION C\nRESOURCE R ON Plc\n  TASK A(INTERVAL := T#1ms, PRIORITY := 0);\n"
      "  TASK B(INTERVAL := T#1ms, PRIORITY := 1);\n"
      "  PROGRAM makes WITH A : Makes;\n  PROGRAM takes WITH B : Takes;\nEND_RESOURCE\nEND_CONFIGURATION\n",
      dints, std::max(dints / 10, 1u));
}

/// A resource with two tasks, and what it records when that is asked for.
struct Side {
  Side(const std::string& source, bool recorded) : resource(load_text(source)) {
    if (!recorded) return;
    auto started = shadow::Recording::start(*resource, [](const shadow::BlockInfo&, const std::vector<std::byte>&) {});
    if (!started) throw std::runtime_error(started.error().message);
    recording = std::move(*started);
  }
  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<shadow::Recording> recording;
};

class Exchange {
 public:
  explicit Exchange(std::uint32_t bytes)
      : off_(exchange_source(bytes / 4), false), on_(exchange_source(bytes / 4), true), swept_(kSweptBytes) {}

  /// ns that recording adds to a scan of the task that takes the values in: medians of all scans of both sides.
  double added(std::uint32_t batches, bool cold) {
    std::vector<double> off, on;
    for (std::uint32_t batch = 0; batch < batches; ++batch) {
      for (Side* const side : {&off_, &on_}) {
        std::vector<double>& times = side == &off_ ? off : on;
        for (std::uint32_t scan = 0; scan < (cold ? kScansPerBatch / 10 : kScansPerBatch); ++scan)
          times.push_back(timed(*side, cold));
        if (side->recording) side->recording->drain();
      }
    }
    return median(on) - median(off);
  }
  /// Both sides have the same values, and nothing was left out.
  [[nodiscard]] bool right() const {
    runtime::Program& a = off_.resource->program(1);
    runtime::Program& b = on_.resource->program(1);
    const std::size_t bytes = a.table().layout().total;
    return good_ && bytes == b.table().layout().total &&
           std::equal(a.table().data(), a.table().data() + bytes, b.table().data()) &&
           on_.recording->counts(1).lost == 0;
  }

 private:
  double timed(Side& side, bool cold) {
    good_ = !side.resource->program(0).execute({0}) && good_;
    if (cold) {
      for (std::size_t i = 0; i < swept_.size(); i += 64) swept_[i] = static_cast<char>(swept_[i] + 1);
    }
    const core::TimeNs begin = clock_.now_ns();
    good_ = !side.resource->program(1).execute({0}) && good_;
    return static_cast<double>(clock_.now_ns() - begin);
  }

  Side off_, on_;
  std::vector<char> swept_;
  core::MonotonicClock clock_;
  bool good_ = true;
};

void scans(const RecordPlan& plan, Verdict& verdict) {
  struct Row {
    std::uint32_t bytes;
    const Limit* warm;
    const Limit* cold;
  };
  for (const Row& row : {Row{64, &limit::kRecordSmall, &limit::kRecordSmallCold},
                         Row{1024, &limit::kRecordSmall, &limit::kRecordSmallCold},
                         Row{8192, &limit::kRecordLarge, &limit::kRecordLargeCold}}) {
    Exchange exchange(row.bytes);
    const double warm = exchange.added(std::max(plan.batches, 1u), false);
    const double cold = exchange.added(std::max(plan.batches, 1u), true);
    const bool right = exchange.right();
    verdict.correct = verdict.correct && right;
    std::cout << fmt::format("  a scan that takes in {} bytes: {}", row.bytes,
                             right ? "results right" : "RESULTS WRONG");
    if (plan.batches != 0) {
      std::cout << fmt::format("; {:.0f} ns more, {}; with caches cold {:.0f} ns more, {}", warm,
                               limit_text(warm, *row.warm, verdict), cold, limit_text(cold, *row.cold, verdict));
    }
    std::cout << '\n';
  }
}

void checkpoints(const RecordPlan& plan, Verdict& verdict) {
  const auto resource = load_text(
      "PROGRAM Main\nVAR a : ARRAY [0..262143] OF DINT; n : DINT; END_VAR\n n := n + 1; a[n MOD 1000] := "
      "n;\nEND_PROGRAM\n"
      "CONFIGURATION C\nRESOURCE R ON Plc\n  TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n"
      "  PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n");
  auto ring = runtime::RecordRing::make(1u << 20, 1u << 16);
  if (!ring) throw std::runtime_error(ring.error().message);
  runtime::Program& program = resource->program(0);
  const std::span<std::byte> table(program.table().data(), program.table().layout().total);
  runtime::Recorder recorder(**ring, table);
  program.set_recorder(&recorder);
  const core::MonotonicClock clock;
  std::vector<double> with, without;
  bool good = true;
  for (std::uint32_t batch = 0; batch < std::max(plan.batches, 1u); ++batch) {
    for (const bool asked : {false, true}) {
      if (asked) recorder.ask();
      const core::TimeNs begin = clock.now_ns();
      good = !program.execute({0}) && good;
      (asked ? with : without).push_back(static_cast<double>(clock.now_ns() - begin));
      while (!(*ring)->next().empty()) {
      }
      if (!asked) continue;
      good = std::equal(table.begin(), table.end(), recorder.checkpoint().begin()) && good;
      recorder.give_back();
    }
  }
  program.set_recorder(nullptr);
  verdict.correct = verdict.correct && good;
  const double us = (median(with) - median(without)) / 1000 / (static_cast<double>(table.size()) / (1u << 20));
  std::cout << fmt::format("  checkpoint: {}", good ? "results right" : "RESULTS WRONG");
  if (plan.batches != 0)
    std::cout << fmt::format("; {:.1f} us a MB, {}", us, limit_text(us, limit::kCheckpoint, verdict));
  std::cout << '\n';
}

void replays(const RecordPlan& plan, Verdict& verdict) {
  const auto resource = load(PLC_TANK "/tank.xml");
  std::vector<std::byte> bytes =
      shadow::file_head({"", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource->image())});
  auto recording =
      shadow::Recording::start(*resource, [&bytes](const shadow::BlockInfo&, const std::vector<std::byte>& block) {
        bytes.insert(bytes.end(), block.begin(), block.end());
      });
  if (!recording) throw std::runtime_error(recording.error().message);
  runtime::Simulation simulation(*resource);
  auto stimulus = io::Stimulus::load(PLC_TANK "/stimulus.csv", *resource);
  if (!stimulus) throw std::runtime_error(stimulus.error().message);
  stimulus->attach(simulation);
  const std::uint64_t cycles = plan.batches == 0 ? 1000 : 2'000'000;
  for (std::uint64_t i = 0; i < cycles; i += 1000) {
    simulation.run_cycles(1000);
    (*recording)->drain();
  }
  (*recording)->finish();
  const auto file = shadow::RecordFile::read(std::move(bytes), "tank");
  core::Diagnostics diagnostics;
  auto made = shadow::Player::make(*file, diagnostics);
  if (!made) throw std::runtime_error(made.error().message);
  shadow::Player& player = **made;
  for (std::size_t task = 0; task < player.resource().task_count(); ++task) {
    if (auto compiled = native::compile(player.resource().program(task)))
      player.resource().program(task).install(std::move(*compiled));
  }
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  std::uint64_t scans = 0;
  bool equal = true;
  while (const auto played = player.step()) {
    equal = equal && played->outcome.equal;
    ++scans;
  }
  const double ns = static_cast<double>(clock.now_ns() - begin) / static_cast<double>(scans);
  const bool right = equal && scans >= cycles && file->damaged_bytes() == 0;
  verdict.correct = verdict.correct && right;
  std::uint64_t stored = 0;
  for (const shadow::BlockInfo& block : file->blocks()) stored += block.stored_bytes;
  std::cout << fmt::format("  replay of examples/tank, {} scans, {:.1f} bytes each: {}", scans,
                           static_cast<double>(stored) / static_cast<double>(scans),
                           right ? "every scan gives what it gave" : "RESULTS WRONG");
  if (plan.batches != 0) {
    std::cout << fmt::format("; {:.0f} ns a scan, {:.1f} million a second, {}", ns, 1e3 / ns,
                             limit_text(ns, limit::kReplayedScan, verdict));
  }
  std::cout << '\n';
}

/// p99.9 of how late the task of 1 ms woke, in ns; of a process of its own.
double wake_up(const std::string& project, const std::string& record, std::uint32_t seconds) {
  const Cost cost = run({PLC_RUN_TOOL, project, "--duration", std::to_string(seconds), "--modbus", "off", "--record",
                         record, "--stats=json"},
                        true);
  if (!cost.ok) throw std::runtime_error("plc-run did not end by itself");
  return nlohmann::json::parse(cost.output)["tasks"][0]["latency"]["p99_9_ns"].get<double>();
}

void wake_ups(const RecordPlan& plan, Verdict& verdict) {
  const Scratch scratch;
  const std::string path = scratch.file("record.st");
  std::ofstream(path) << exchange_source(256);
  std::vector<double> off, on;
  for (std::uint32_t round = 0; round < plan.rounds; ++round) {
    off.push_back(wake_up(path, "off", plan.seconds));
    on.push_back(wake_up(path, "check", plan.seconds));
  }
  const double ratio = median(on) / median(off);
  std::cout << fmt::format(
      "  wake-up of a task of 1 ms, p99.9: {:.1f} us not recorded, {:.1f} us recorded and executed again beside it, "
      "{:.2f} "
      "times, {}\n",
      median(off) / 1000, median(on) / 1000, ratio, limit_text(ratio, limit::kWakeUpRecorded, verdict));
}

/// A task of 1 ms with a noisy input, recorded for a day of virtual time: what is kept, and how long a view of the past
/// takes to open.
void day(const RecordPlan& plan, Verdict& verdict) {
  const auto resource = load_text(
      "VAR_GLOBAL Raw : INT; Level : REAL; Pump : BOOL; END_VAR\n"
      "PROGRAM Main\nVAR_EXTERNAL Raw : INT; Level : REAL; Pump : BOOL; END_VAR\nVAR Late : TON; Strokes : DINT; "
      "END_VAR\n"
      "Level := Level + (INT_TO_REAL(Raw) / 276.48 - Level) * 0.05;\n"
      "IF Level > 80.0 THEN Pump := TRUE; ELSIF Level < 20.0 THEN Pump := FALSE; END_IF;\n"
      "Late(IN := Pump, PT := T#5s);\nIF Late.Q THEN Strokes := Strokes + 1; END_IF;\nEND_PROGRAM\n"
      "CONFIGURATION C\nRESOURCE R ON Plc\n  TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n"
      "  PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n");
  const Scratch scratch;
  const shadow::RecordingHead head{"", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource->image())};
  shadow::RecordFolderOptions options;
  options.path = scratch.file("records");
  options.most_bytes = 256u << 20;
  auto folder = shadow::RecordFolder::open(options, head);
  if (!folder) throw std::runtime_error(folder.error().message);
  constexpr std::uint64_t kMemory = 32u << 20;
  shadow::History history(kMemory);
  std::uint64_t written = 0;
  auto recording =
      shadow::Recording::start(*resource, [&](const shadow::BlockInfo& info, const std::vector<std::byte>& block) {
        history.add(info.first_ns, info.last_ns, block);
        written += block.size();
        if (!(*folder)->write(block)) throw std::runtime_error((*folder)->problem()->message);
      });
  if (!recording) throw std::runtime_error(recording.error().message);
  const bytecode::ImageType& globals = resource->image().types[resource->image().global_type];
  runtime::GlobalWrite raw;
  for (const bytecode::ImageField& field : globals.fields) {
    if (field.name == "Raw") raw.offset = field.offset, raw.type = field.type;
  }
  std::uint32_t noise = 1;
  runtime::Program& program = resource->program(0);
  std::uint64_t scan = 0;
  for (; scan < plan.day_scans; ++scan) {
    noise = noise * 1'664'525 + 1'013'904'223;
    const double wave = 0.5 + 0.5 * std::sin(static_cast<double>(scan) / 20'000.0);
    const auto value = static_cast<std::int16_t>(wave * 27'000 + (noise >> 30));
    raw.value = reinterpret_cast<const std::byte*>(&value);
    resource->globals().write(std::span(&raw, 1));
    const auto now_ns = static_cast<core::TimeNs>(scan) * 1'000'000;
    if (program.execute({now_ns, 0, now_ns})) throw std::runtime_error("a scan of the day failed");
    if (scan % 1000 == 999) (*recording)->drain();
  }
  std::uint64_t disk = 0;
  for (const auto& entry : std::filesystem::directory_iterator(options.path)) disk += entry.file_size();
  const std::vector<std::byte> past = history.recording(shadow::file_head(head), {});
  const core::MonotonicClock clock;
  const core::TimeNs opened = clock.now_ns();
  const auto file = shadow::RecordFile::read(past, "memory");
  if (!file) throw std::runtime_error(file.error().message);
  core::Diagnostics diagnostics;
  auto player = shadow::Player::make(*file, diagnostics);
  if (!player) throw std::runtime_error(player.error().message);
  const double open_ms = static_cast<double>(clock.now_ns() - opened) / 1e6;
  const std::uint64_t first = file->blocks().front().first_scan;
  const std::uint64_t last = file->blocks().back().first_scan + file->blocks().back().scans - 1;
  const std::uint64_t hour = std::min<std::uint64_t>(3'600'000, last - first);
  double longest_ms = 0;
  bool right = (*recording)->counts(0).lost == 0 && history.bytes() <= kMemory;
  for (int i = 0; i < 200; ++i) {
    noise = noise * 1'664'525 + 1'013'904'223;
    const core::TimeNs begin = clock.now_ns();
    right = (*player)->seek(0, last - noise % (hour + 1)) && right;
    longest_ms = std::max(longest_ms, static_cast<double>(clock.now_ns() - begin) / 1e6);
  }
  const std::uint64_t most_disk = options.most_bytes + options.file_bytes;
  right = right && disk <= most_disk + (2u << 20);
  verdict.correct = verdict.correct && right;
  std::cout << fmt::format(
      "  {} scans of 1 ms: {:.1f} bytes each, {:.0f} MB in all; {:.1f} MB of memory have {:.1f} h, {:.0f} MB of files "
      "are "
      "kept: {}\n  any scan of {:.0f} min: opened in {:.0f} ms, then at most {:.1f} ms, {}\n",
      scan, static_cast<double>(written) / static_cast<double>(scan), static_cast<double>(written) / 1e6,
      static_cast<double>(history.bytes()) / 1e6, static_cast<double>(last - first) / 3.6e6,
      static_cast<double>(disk) / 1e6, right ? "within what was allowed" : "NOT AS ALLOWED",
      static_cast<double>(hour) / 60'000, open_ms, longest_ms, limit_text(open_ms + longest_ms, limit::kSeek, verdict));
}

}  // namespace

Verdict measure_record(const RecordPlan& plan) {
  Verdict verdict;
  scans(plan, verdict);
  checkpoints(plan, verdict);
  replays(plan, verdict);
  if (plan.batches != 0 && plan.day_scans != 0) day(plan, verdict);
  if (plan.batches != 0 && plan.rounds != 0) wake_ups(plan, verdict);
  return verdict;
}

}  // namespace plc::bench
