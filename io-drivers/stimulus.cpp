#include "io-drivers/stimulus.h"

#include <sys/stat.h>

#include <cerrno>
#include <fstream>
#include <limits>
#include <sstream>
#include <system_error>

#include "core/text.h"
#include "io-drivers/csv.h"
#include "runtime/value_text.h"

namespace plc::io {
namespace {

constexpr core::TimeNs kNsPerMs = 1'000'000;

core::Problem at_cell(std::string_view file, const CsvCell& cell, const core::Problem& problem) {
  return {
      problem.code,
      std::string(file) + ":" + std::to_string(cell.line) + ":" + std::to_string(cell.column) + ": " + problem.message,
      problem.help};
}
core::Problem wrong(std::string_view file, const CsvCell& cell, std::string message, std::string help) {
  return at_cell(file, cell, {core::Code::P7202, std::move(message), std::move(help)});
}

}  // namespace

std::optional<core::TimeNs> parse_time_ms(std::string_view text) {
  text = core::trimmed(text);
  core::TimeNs ns = 0;
  core::TimeNs unit = kNsPerMs;
  bool in_fraction = false;
  bool any = false;
  for (const char c : text) {
    if (c == '.' && !in_fraction) {
      in_fraction = true;
      continue;
    }
    if (c < '0' || c > '9') return std::nullopt;
    const core::TimeNs digit = c - '0';
    any = true;
    if (!in_fraction) {
      if (ns > std::numeric_limits<core::TimeNs>::max() / 10 - 10 * kNsPerMs) return std::nullopt;
      ns = ns * 10 + digit * kNsPerMs;
    } else {
      unit /= 10;
      // Beyond nanoseconds only zeros are exact.
      if (unit == 0 && digit != 0) return std::nullopt;
      ns += digit * unit;
    }
  }
  if (!any) return std::nullopt;
  return ns;
}

void append_time_ms(std::string& out, core::TimeNs time_ns) {
  out += std::to_string(time_ns / kNsPerMs);
  core::TimeNs rest = time_ns % kNsPerMs;
  if (rest == 0) return;
  out += '.';
  for (core::TimeNs unit = kNsPerMs / 10; rest != 0; unit /= 10) {
    out += static_cast<char>('0' + rest / unit);
    rest %= unit;
  }
}

core::Result<Stimulus> Stimulus::parse(std::string_view text, std::string_view file, runtime::Resource& resource) {
  auto rows = parse_csv(text, file);
  if (!rows) return rows.error();
  Stimulus driver(resource);
  if (rows->empty() || !core::iequals(core::trimmed(rows->front().front().text), "time_ms")) {
    const CsvCell place = rows->empty() ? CsvCell{{}, false, 1, 1} : rows->front().front();
    return wrong(file, place, "the first column is not \"time_ms\"",
                 "the first line names time_ms, then the variables");
  }
  const CsvRow& header = rows->front();
  for (std::size_t i = 1; i < header.size(); ++i) {
    const auto place = driver.access_.find_leaf(header[i].text);
    if (!place) return at_cell(file, header[i], place.error());
    if (place->constant) {
      return at_cell(file, header[i],
                     {core::Code::P7106, "\"" + header[i].text + "\" is declared CONSTANT", "take the column out"});
    }
    for (const runtime::Place& other : driver.places_) {
      if (other.task == place->task && other.offset == place->offset) {
        return wrong(file, header[i], "\"" + header[i].text + "\" has a column already", "one column per variable");
      }
    }
    driver.places_.push_back(*place);
  }
  std::vector<std::byte> checked;
  for (std::size_t r = 1; r < rows->size(); ++r) {
    const CsvRow& cells = (*rows)[r];
    Row row;
    const auto time = parse_time_ms(cells[0].text);
    if (!time) {
      return wrong(file, cells[0], "\"" + cells[0].text + "\" is not a time in ms",
                   "a decimal number such as 12 or 12.5");
    }
    row.time_ns = *time;
    if (!driver.rows_.empty() && row.time_ns < driver.rows_.back().time_ns) {
      return wrong(file, cells[0], "time goes back", "rows are in ascending time");
    }
    if (cells.size() > header.size()) {
      return wrong(file, cells[header.size()], "more cells than the header has columns", {});
    }
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i].text.empty() && !cells[i].quoted) continue;
      const bytecode::ImageType& type = resource.image().types[driver.places_[i - 1].type];
      checked.resize(type.size);
      if (const auto problem = runtime::parse_value(type, cells[i].text, checked))
        return at_cell(file, cells[i], *problem);
      row.values.push_back({static_cast<std::uint32_t>(i - 1), cells[i].text});
    }
    driver.rows_.push_back(std::move(row));
  }
  return driver;
}

core::Result<Stimulus> Stimulus::load(const std::string& path, runtime::Resource& resource) {
  // A pipe or a device may block, or never come to an end.
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    return core::Problem{core::Code::P7001, path + ": not a regular file", "give a CSV file"};
  }
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in || in.bad()) {
    return core::Problem{core::Code::P7001, path + ": " + std::system_category().message(errno), {}};
  }
  return parse(text.str(), path, resource);
}

std::optional<core::Problem> Stimulus::check_real_time(std::string_view name, std::uint32_t task) const {
  const auto& tasks = resource_->image().tasks;
  for (const runtime::Place& place : places_) {
    if (place.task == runtime::Place::kGlobal || place.task == task) continue;
    return core::Problem{core::Code::P7205,
                         std::string(name) + " names variables of task \"" + tasks[place.task].name +
                             "\", and is applied by task \"" + tasks[task].name + "\"",
                         "in real time a stimulus writes globals, or variables of one task; plc sim takes any"};
  }
  return std::nullopt;
}

void Stimulus::apply(core::TimeNs now_ns, const Sink& sink) {
  for (; next_ < rows_.size() && rows_[next_].time_ns <= now_ns; ++next_) {
    for (const Value& value : rows_[next_].values) sink(places_[value.column], value.text);
  }
}

void Stimulus::apply(core::TimeNs now_ns) {
  apply(now_ns, [&](const runtime::Place& place, std::string_view text) { write(place, text, now_ns); });
}

void Stimulus::write(const runtime::Place& place, std::string_view text, core::TimeNs now_ns) {
  const auto problem = access_.write(place, text);
  if (!problem || lost_.values++ != 0) return;
  std::string at;
  append_time_ms(at, now_ns);
  lost_.first = core::Problem{problem->code, "at " + at + " ms: " + problem->message, problem->help};
}

void Stimulus::attach(runtime::Simulation& simulation) {
  simulation.before_instant([this](const runtime::Instant& instant) { apply(instant.now_ns); });
}

}  // namespace plc::io
