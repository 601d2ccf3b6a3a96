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

/// Characters of a text in UTF-8: all bytes but those that go on with one.
std::size_t characters_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// "12", "-1.5us", "3.0 %": what people compare digit by digit.
bool is_number(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && text.front() >= '0' && text.front() <= '9';
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
  struct Column {
    std::size_t width = 0;
    bool numbers = false, texts = false;  ///< below the heading
  };
  std::vector<Column> columns;
  for (const auto& row : rows) {
    columns.resize(std::max(columns.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      columns[i].width = std::max(columns[i].width, characters_of(row[i]));
      if (&row == &rows.front() || row[i].empty() || row[i] == "-") continue;
      (is_number(row[i]) ? columns[i].numbers : columns[i].texts) = true;
    }
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(columns[i].width - characters_of(row[i]), ' ');
      const bool right = i != 0 && columns[i].numbers && !columns[i].texts;
      line += (i == 0 ? "" : "  ") + (right ? blanks + row[i] : row[i] + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  }
}

}  // namespace plc::tools
