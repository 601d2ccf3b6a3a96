#include "tools/plc-run/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <ostream>

#include "core/text.h"
#include "engineering/task_times.h"
#include "io-drivers/config/template.h"
#include "tools/command_line.h"
#include "tools/engine.h"
#include "tools/plc-run/relaunch.h"
#include "tools/statistics.h"
#include "tools/version.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;
using runtime::Histogram;
using runtime::TaskStatistics;

std::string time_text(std::int64_t ns) { return duration_text(static_cast<double>(ns)); }

/// When the task is released: "every 20ms", "on Start", "freewheeling".
std::string release_text(const bytecode::ImageTask& task) {
  if (!task.single.empty()) return "on " + task.single;
  return task.period_ns == 0 ? "freewheeling" : "every " + time_text(task.period_ns);
}

/// Number of octaves: values up to 2^63 - 1.
constexpr std::size_t kOctaves = 64;
constexpr std::size_t kBarWidth = 16;
using Octaves = std::array<std::uint64_t, kOctaves>;

/// Counts of values with 0, 1, 2, .. binary digits; no step of a histogram crosses an octave.
Octaves octaves_of(const Histogram& histogram) {
  Octaves octaves{};
  for (const Histogram::Bucket& bucket : histogram.buckets()) {
    octaves[static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(bucket.upper_ns)))] += bucket.count;
  }
  return octaves;
}

/// Rounded up, so that a single scan in a million is seen.
std::string bar(std::uint64_t count, std::uint64_t most) {
  return std::string(most == 0 ? 0 : static_cast<std::size_t>((count * kBarWidth + most - 1) / most), '#');
}

ordered_json to_json(const Histogram& histogram) {
  ordered_json times = engineering::times_json(histogram);
  ordered_json& buckets = times["buckets"] = ordered_json::array();
  for (const Histogram::Bucket& bucket : histogram.buckets()) buckets.push_back({bucket.upper_ns, bucket.count});
  return times;
}

}  // namespace

void print_start(std::string_view program, const bytecode::Image& image, std::span<const runtime::TaskPlan> plan,
                 core::TimeNs load_ns, std::ostream& out) {
  out << fmt::format("{}: {} with {}, ready in {}\n", kVersionText, program, counted(image.tasks.size(), "task"),
                     time_text(load_ns));
  out << "options: " << describe(image.options) << '\n';
  for (std::size_t t = 0; t < plan.size(); ++t) {
    const bytecode::ImageTask& task = image.tasks[t];
    out << fmt::format("task {}: {}, priority {}", task.name, release_text(task), plan[t].priority);
    if (plan[t].cpu >= 0) out << fmt::format(", processor {}", plan[t].cpu);
    if (plan[t].offset_ns != 0) out << ", offset " << time_text(plan[t].offset_ns);
    if (plan[t].lead_ns) out << ", lead " << time_text(*plan[t].lead_ns);
    if (plan[t].watchdog_ns != 0) out << ", watchdog " << time_text(plan[t].watchdog_ns);
    out << '\n';
  }
}

void print_end(const End& end, const runtime::Resource& resource, const runtime::RealtimeScheduler& scheduler,
               core::TimeNs ran_ns, std::ostream& out) {
  const bool stops = end.fault != nullptr && scheduler.plan(end.fault->task).on_fault == runtime::FaultPolicy::kStop;
  std::string why;
  if (end.signal != 0) {
    why = fmt::format("signal SIG{}", ::sigabbrev_np(end.signal));
    // Its death is what sent the signal.
    if (const int guardian = Relaunch::instance().dead_guardian(); guardian != 0)
      why = fmt::format("the guardian (process {}) has died", guardian);
  } else if (stops) {
    why = fmt::format("fault {} in task {}, whose policy is stop",
                      core::info(runtime::fault_code(end.fault->fault.kind)).name,
                      resource.image().tasks[end.fault->task].name);
  } else if (end.duration_ns != 0 && ran_ns >= end.duration_ns) {
    why = "--duration";
  } else if (end.cycles != 0) {
    why = "--cycles";
  } else {
    why = "asked to";
  }
  out << fmt::format("ends after {}: {}\n", time_text(ran_ns), why);
}

void print_forces(const runtime::ForceList& forces, std::ostream& out) {
  for (const runtime::Force& force : forces.list())
    out << fmt::format("forced: {} to {} by {}: {}\n", force.path, force.value, force.owner, force.reason);
}

void print_devices(const io::Machine& machine, std::ostream& out) {
  for (const auto& driver : machine.drivers()) {
    const auto inputs = driver->inputs(0).size();
    const io::DriverStatus status = driver->status();
    out << fmt::format("driver {}: {}{}{}\n", driver->name(),
                       driver->timing() == io::Timing::kOffline ? "simulated"
                       : status.connected                       ? "open"
                       : status.problem.empty()                 ? "not asked yet"
                                                                : "not there yet",
                       inputs != 0 ? ", " + counted(inputs, "input") : "",
                       driver->has_outputs() ? ", with outputs" : "");
  }
  if (machine.guarded()) out << "guardian: drives the safe values should the runtime die or hang\n";
}

void print_realtime(const runtime::RealtimeReport& report, std::ostream& out) {
  for (const std::string& refused : report.refused) out << "real time: " << refused << '\n';
  if (report.refused.empty()) out << "real time: SCHED_FIFO priorities and locked memory\n";
}

void print_times(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out) {
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    const TaskStatistics& s = scheduler.statistics(i);
    out << fmt::format("\n{}, {}: {} cycles, {} overruns, {} missed, {} faults\n", image.tasks[i].name,
                       release_text(image.tasks[i]), s.scans.load(), s.overruns.load(), s.missed.load(),
                       s.faults.load());
    std::vector<std::vector<std::string>> rows = {{"          ", "min", "mean"}};
    for (const engineering::Share& share : engineering::shares()) rows[0].push_back(share.name);
    rows[0].push_back("max");
    for (const engineering::Quantity& quantity : engineering::quantities()) {
      const Histogram& h = s.*quantity.histogram;
      std::vector<std::string> row = {"  " + std::string(quantity.name), time_text(h.min_ns()),
                                      duration_text(h.mean_ns())};
      for (const engineering::Share& share : engineering::shares())
        row.push_back(time_text(h.percentile_ns(share.share)));
      row.push_back(time_text(h.max_ns()));
      rows.push_back(std::move(row));
    }
    print_table(rows, out);
  }
}

void print_histograms(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out) {
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    std::vector<Octaves> columns;
    for (const engineering::Quantity& quantity : engineering::quantities())
      columns.push_back(octaves_of(scheduler.statistics(i).*quantity.histogram));
    const auto used = [&](std::size_t octave) {
      return std::any_of(columns.begin(), columns.end(), [octave](const Octaves& c) { return c[octave] != 0; });
    };
    std::size_t first = 0, last = kOctaves;
    while (first < last && !used(first)) ++first;
    while (last > first && !used(last - 1)) --last;
    if (first == last) continue;
    std::string heading = fmt::format("{:<16}", image.tasks[i].name);
    for (const engineering::Quantity& quantity : engineering::quantities())
      heading += fmt::format("  {:>10} {:<{}}", quantity.name, "", kBarWidth);
    out << '\n' << core::trimmed(heading) << '\n';
    for (std::size_t octave = first; octave < last; ++octave) {
      std::string line =
          fmt::format("  up to {:>8}", time_text(static_cast<std::int64_t>((std::uint64_t{1} << octave) - 1)));
      for (const Octaves& column : columns) {
        const std::uint64_t most = *std::max_element(column.begin(), column.end());
        line += fmt::format("  {:>10} {:<{}}", column[octave], bar(column[octave], most), kBarWidth);
      }
      out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
    }
  }
}

void print_executions(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out) {
  out << "\nlongest scans, with all that interrupted them, for plc.toml:\n";
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    const Histogram& scans = scheduler.statistics(i).scan_time;
    if (scans.count() == 0) continue;
    // Rounded up: a bound stays one.
    const std::int64_t tenths_us = scans.max_ns() / 100 + 1;
    out << fmt::format("[tasks.{}]\nexecution = \"{}.{}us\"\n", io::toml_key(image.tasks[i].name), tenths_us / 10,
                       tenths_us % 10);
  }
}

void print_engines(const runtime::Resource& resource, std::ostream& out) {
  out << '\n';
  for (std::size_t i = 0; i < resource.task_count(); ++i) {
    const runtime::Program& program = resource.program(i);
    out << fmt::format("engine of {}: {}\n", program.task().name, engine_name(program));
  }
}

void print_json(const runtime::Resource& resource, const runtime::RealtimeScheduler& scheduler,
                const shadow::Shadow* shadow, std::ostream& out) {
  const bytecode::Image& image = resource.image();
  ordered_json document;
  document["realtime_priority"] = scheduler.report().realtime_priority;
  document["memory_locked"] = scheduler.report().memory_locked;
  document["refused"] = scheduler.report().refused;
  document["tasks"] = ordered_json::array();
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    const bytecode::ImageTask& declared = image.tasks[i];
    const TaskStatistics& s = scheduler.statistics(i);
    ordered_json task;
    task["name"] = declared.name;
    task["release"] = release_text(declared);
    task["period_ns"] = declared.single.empty() ? declared.period_ns : 0;
    const runtime::Program& program = resource.program(i);
    task["engine"] = engine_name(program);
    task["cycles"] = s.scans.load();
    task["overruns"] = s.overruns.load();
    task["missed"] = s.missed.load();
    task["faults"] = s.faults.load();
    for (const engineering::Quantity& quantity : engineering::quantities())
      task[quantity.name] = to_json(s.*quantity.histogram);
    document["tasks"].push_back(std::move(task));
  }
  // WHY replace: a name that is no UTF-8 must not spoil the document.
  if (shadow != nullptr) {
    const shadow::RecordingCounts counts = shadow->counts();
    document["recording"] = {{"scans", counts.scans},
                             {"left_out", counts.lost},
                             {"record_bytes", counts.record_bytes},
                             {"stored_bytes", counts.stored_bytes},
                             {"gaps", counts.gaps},
                             {"history_ns", shadow->history_ns()},
                             {"history_bytes", shadow->history_bytes()}};
  }
  out << document.dump(-1, ' ', false, ordered_json::error_handler_t::replace) << '\n';
}

void print_modbus(const modbus::ServerStatistics& s, std::ostream& out) {
  out << fmt::format(
      "modbus: {} requests, {} of them answered with an exception, {} connections, {} refused, {} dropped\n",
      s.requests, s.exceptions, s.accepted, s.refused, s.dropped);
}

void print_modbus(const modbus::SerialStatistics& s, std::ostream& out) {
  out << fmt::format(
      "modbus: on the serial line {} requests, {} of them answered with an exception, {} frames of others, {} "
      "damaged\n",
      s.requests, s.exceptions, s.others, s.damaged);
}

}  // namespace plc::tools
