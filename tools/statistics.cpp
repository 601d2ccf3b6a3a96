#include "tools/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <ostream>

#include "core/diagnostics.h"

namespace plc::tools {
namespace {

/// A row of /proc/self/status in kB; 0 where there is none.
long status_kb(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind(key + ":", 0) == 0) return std::stol(line.substr(key.size() + 1));
  }
  return 0;
}

}  // namespace

std::string place_text(const bytecode::Image& image, std::uint32_t pou, std::uint32_t word) {
  const core::SourceRef at = runtime::source_of(image, pou, word);
  std::string text;
  if (at.line != 0) {
    const std::string file = at.file < image.files.size() ? image.files[at.file] : std::string("?");
    text = fmt::format("{}:{}:{} ", file, at.line, at.column);
  }
  text += fmt::format("[POU {}", image.pous[pou].name);
  if (at.local_id >= 0) text += fmt::format(", {} {}", core::element_word(at.kind), at.local_id);
  return text + "]";
}

void print_events(const runtime::Resource& resource, std::ostream& out) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    const runtime::Program& program = resource.program(task);
    std::vector<runtime::EventCount> events = program.events();
    std::sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.count > b.count; });
    for (const runtime::EventCount& event : events) {
      out << fmt::format("event: {} at {}, {} times\n", stdlib::event_name(event.last),
                         place_text(program.image(), event.pou, event.word), event.count);
    }
    if (program.other_events() != 0) out << fmt::format("event: {} more elsewhere\n", program.other_events());
  }
}

std::string fault_text(const runtime::Resource& resource, const runtime::TaskFault& fault) {
  const bytecode::Image& image = resource.image();
  const std::string taskblock = resource.program(fault.task).taskblock_text(fault.fault);
  const core::CodeInfo& code = core::info(runtime::fault_code(fault.fault.kind));
  return fmt::format("fault {}: {} in task {}, cycle {}, at {}{}{}", code.name, code.title,
                     image.tasks[fault.task].name, fault.cycle, place_text(image, fault.fault.pou, fault.fault.word),
                     taskblock.empty() ? "" : ", taskblock ", taskblock);
}

void print_fault(const runtime::Resource& resource, const runtime::TaskFault& fault, std::ostream& out) {
  out << fault_text(resource, fault) << '\n';
}

void print_allocations(const runtime::Resource& resource, std::ostream& out) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    for (const auto& found : resource.program(task).allocations()) {
      out << fmt::format("taskblock {}: {} allocations in its cycle\n", found.taskblock, found.count);
    }
  }
}

void print_memory(std::ostream& out) {
  out << fmt::format("memory: {:.1f} MB resident, {:.1f} MB at most\n", static_cast<double>(status_kb("VmRSS")) / 1024,
                     static_cast<double>(status_kb("VmHWM")) / 1024);
}

void print_link_report(const runtime::Resource& resource, std::ostream& out) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    const runtime::Program& program = resource.program(task);
    const runtime::Program::LinkReport& report = program.link_report();
    const std::string& name = program.task().name;
    out << fmt::format("task {}: table {} bytes, code {} bytes, boolean records {}+{} short, {} wide, {} mixed\n", name,
                       program.table().layout().total, report.code_bytes, report.short4_records, report.short5_records,
                       report.wide_records, report.mixed_records)
        << fmt::format("task {}: interpreter: {} instructions in {} runs\n", name, report.arranged, report.runs);
  }
}

void print_table(const std::vector<std::vector<std::string>>& rows, std::ostream& out) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += i == 0 ? fmt::format("{:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    }
    out << line << '\n';
  }
}

}  // namespace plc::tools
