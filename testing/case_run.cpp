#include "testing/case_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>

#include "core/clock.h"
#include "frontend-ld/lower.h"
#include "io-drivers/stimulus.h"
#include "retain/keeper.h"
#include "runtime/access.h"
#include "runtime/sched/simulation.h"
#include "stdlib/library.h"
#include "testing/case_file.h"
#include "testing/table.h"

namespace plc::tests {
namespace {

namespace fs = std::filesystem;
using core::Code;

core::Problem unusable(const fs::path& file, const std::string& why, const std::string& help = {}) {
  return {Code::P7904, file.string() + ": " + why, help};
}

/// The compile options of a run, as words of a command line. What is wrong with them, or empty.
std::string apply(const std::vector<std::string>& words, core::CompileOptions& options) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    const std::string name = words[i].substr(0, equals);
    const auto is = [&name](std::string_view option) { return name == fmt::format("--{}", option); };
    bool known = false;
    for (const core::Switch& row : core::kSwitches) {
      if (!is(row.name) || equals != std::string::npos) continue;
      options.*row.value = true;
      known = true;
    }
    if (known) continue;
    if (equals == std::string::npos && i + 1 == words.size()) return "\"" + words[i] + "\" is no compile option";
    const std::string value = equals == std::string::npos ? words[++i] : words[i].substr(equals + 1);
    std::string wrong = "\"" + name + "\" is no compile option";
    core::for_each_choice([&]<class E>(const core::Choice<E>& choice) {
      if (!is(choice.name)) return;
      wrong = name + " has no value \"" + value + '"';
      for (std::size_t n = 0; n < choice.words.size(); ++n) {
        if (value != choice.words[n]) continue;
        options.*choice.value = static_cast<E>(n);
        wrong.clear();
      }
    });
    for (const core::Texts& row : core::kTexts) {
      if (!is(row.name)) continue;
      wrong = row.wrong(value);
      (options.*row.value).push_back(value);
    }
    if (is("pou")) {
      options.pou = value;
      wrong.clear();
    }
    if (!wrong.empty()) return wrong;
  }
  return {};
}

/// localIds of everything that is drawn, in the order of execution, POU by POU, as `plc explain` lists them.
std::vector<std::string> drawn_order(const plcopen::Project& project, core::Order rule) {
  std::vector<std::string> ids;
  const auto add = [&](const plcopen::Pou& pou) {
    for (const plcopen::Body& body : pou.bodies) {
      if (body.language != plcopen::Language::kLd && body.language != plcopen::Language::kFbd) continue;
      for (const ld::OrderLine& line : ld::explain_order(body, rule)) ids.push_back(std::to_string(line.at.local_id));
    }
  };
  for (const plcopen::Pou& pou : project.pous) {
    add(pou);
    for (const plcopen::Pou& action : pou.actions) add(action);
  }
  return ids;
}

/// One run of a case: what it is compared with, and the result that grows.
class CaseOfTable {
 public:
  CaseOfTable(const CaseRequest& request, const CaseFile& the_case, const CaseRun& run, TestResult& result)
      : request_(request), case_(the_case), run_(run), result_(result), table_(request.folder / run.expected) {}

  std::optional<core::Problem> run() {
    const CsvTable expected = read_csv(table_.string());
    if (expected.header.size() < 3)
      return unusable(table_, "a table has the columns cycle, time_ms and at least one path");
    if (expected.rows.empty()) return unusable(table_, "a table has one row for each cycle, and this one has none");
    for (std::size_t r = 0; r < expected.rows.size(); ++r) {
      if (expected.rows[r].size() != expected.header.size())
        return unusable(table_, fmt::format("line {} has not as many cells as the header", expected.lines[r]));
    }
    compiler::Compilation compilation;
    compiler::Request request;
    request.path = project_of(request_.folder).string();
    request.goal = compiler::Goal::kRun;
    request.libraries = request_.libraries;
    for (const std::string& library : case_.libraries)
      request.libraries.push_back((request_.folder / library).string());
    request.taskblocks = request_.taskblocks;
    if (const std::string wrong = apply(run_.options, request.options); !wrong.empty())
      return unusable(request_.folder / "case.txt", wrong, "plc sim --help lists compile options");
    compiler::compile(request, compilation);
    // Warnings are those of the first run: options of others may add to them.
    check_messages(compilation, is_first());
    if (is_first() && !case_.order.empty()) check_order(request.path);
    if (!compilation.ok() || !compilation.image) return std::nullopt;
    runtime::ProgramOptions program;
    program.taskblocks = request_.taskblocks;
    auto resource = runtime::Resource::load(std::move(*compilation.image), program);
    if (!resource) return resource.error();
    return compare(expected, **resource);
  }

 private:
  void fail(std::size_t line, std::string what, std::string expected = {}, std::string got = {}) {
    Failure failure;
    failure.file = line == 0 ? request_.folder.string() : table_.string();
    failure.line = static_cast<std::uint32_t>(line);
    failure.what = std::move(what);
    failure.expected = std::move(expected);
    failure.got = std::move(got);
    failure.cycle = result_.cycles;
    failure.at_ns = result_.virtual_ns;
    add_failure(result_, std::move(failure));
  }

  [[nodiscard]] bool is_first() const { return &run_ == &case_.runs.front(); }

  /// The order that `plc explain` shows of the project, whatever the options of its runs are.
  void check_order(const std::string& path) {
    core::Diagnostics ignored;
    const auto project = compiler::read_project(path, ignored);
    if (!project) return;  // reported when it was compiled
    ++result_.checks;
    const std::vector<std::string> order = drawn_order(*project, core::Order::kDrawing);
    if (in_sequence(case_.order, order)) return;
    fail(0, "order of execution", fmt::format("{}", fmt::join(case_.order, " ")),
         fmt::format("{}", fmt::join(order, " ")));
  }

  void check_messages(const compiler::Compilation& compilation, bool with_warnings) {
    const core::Diagnostics& diagnostics = compilation.diagnostics;
    std::vector<std::string> warnings;
    for (const core::Diagnostic& one : diagnostics.all()) {
      const std::string line = diagnostics.render_one(one);
      if (one.severity == core::Severity::kError) fail(0, line);
      if (one.severity == core::Severity::kWarning) warnings.push_back(line);
    }
    if (!with_warnings) return;
    const auto matches = [](const ExpectedWarning& expected, const std::string& line) {
      return (expected.code == "?" || line.find(" " + expected.code) != std::string::npos) &&
             std::all_of(expected.texts.begin(), expected.texts.end(),
                         [&](const std::string& text) { return line.find(text) != std::string::npos; });
    };
    for (const ExpectedWarning& expected : case_.warnings) {
      ++result_.checks;
      if (std::none_of(warnings.begin(), warnings.end(), [&](const std::string& w) { return matches(expected, w); }))
        fail(0, "warning of the compiler", expected.code, "none");
    }
    for (const std::string& line : warnings) {
      if (std::none_of(case_.warnings.begin(), case_.warnings.end(),
                       [&](const ExpectedWarning& expected) { return matches(expected, line); }))
        fail(0, "not expected: " + line);
    }
  }

  std::optional<core::Problem> compare(const CsvTable& expected, runtime::Resource& resource) {
    const runtime::Access access(resource);
    std::vector<runtime::Place> places;
    for (std::size_t c = 2; c < expected.header.size(); ++c) {
      const auto place = access.find_leaf(expected.header[c]);
      if (!place) return unusable(table_, place.error().message, place.error().help);
      places.push_back(*place);
    }
    runtime::SimulationOptions options;
    if (!case_.start.empty()) {
      retain::KeeperOptions kept;
      kept.folder = (request_.folder / case_.start).string();
      kept.what = retain::What::kEverything;
      const retain::Restored restored = retain::Keeper(resource, kept).restore(retain::Start::kWarm);
      if (restored.problem) return *restored.problem;
      if (!restored.found) return unusable(request_.folder / "case.txt", "there are no values in " + kept.folder);
      options.program_time_ns = restored.program_time_ns.value_or(0);
      options.date_ns = restored.time_of_day_ns;
    }
    runtime::Simulation simulation(resource, options);
    std::optional<io::Stimulus> stimulus;
    if (fs::exists(request_.folder / "stimulus.csv")) {
      auto loaded = io::Stimulus::load((request_.folder / "stimulus.csv").string(), resource);
      if (!loaded) return loaded.error();
      stimulus.emplace(std::move(*loaded));
      stimulus->attach(simulation);
    }
    for (std::size_t r = 0; r < expected.rows.size(); ++r) {
      if (!simulation.step()) {
        fail(expected.lines[r], "release instants", std::to_string(expected.rows.size()), std::to_string(r));
        break;
      }
      result_.cycles = r;
      result_.virtual_ns = simulation.now_ns();
      std::string time;
      io::append_time_ms(time, simulation.now_ns());
      check(expected, r, 0, std::to_string(r));
      check(expected, r, 1, time);
      for (std::size_t p = 0; p < places.size(); ++p) check(expected, r, p + 2, access.read(places[p]));
    }
    result_.cycles = simulation.cycles();
    check_faults(resource, simulation);
    check_events(resource);
    return std::nullopt;
  }

  void check(const CsvTable& expected, std::size_t row, std::size_t column, const std::string& got) {
    ++result_.checks;
    const std::string& path = expected.header[column];
    const std::string& wanted = expected.rows[row][column];
    const double tolerance = tolerance_of(case_, path);
    if (same_value(wanted, got, tolerance)) return;
    fail(expected.lines[row], path, tolerance == 0 ? wanted : fmt::format("{} +- {}", wanted, tolerance), got);
  }

  void check_faults(const runtime::Resource& resource, const runtime::Simulation& simulation) {
    std::vector<ExpectedFault> missing = case_.faults;
    for (const runtime::TaskFault& fault : simulation.faults()) {
      const std::string code(core::info(runtime::fault_code(fault.fault.kind)).name);
      const std::string& task = resource.image().tasks[fault.task].name;
      const auto known = std::find_if(missing.begin(), missing.end(), [&](const ExpectedFault& one) {
        return one.code == code && one.task == task && one.cycle == std::to_string(fault.cycle);
      });
      if (known == missing.end()) {
        fail(0, fmt::format("fault {} of task {} in cycle {} is not expected", code, task, fault.cycle));
      } else {
        missing.erase(known);
      }
    }
    result_.checks += case_.faults.size();
    for (const ExpectedFault& one : missing)
      fail(0, fmt::format("fault {} of task {} in cycle {}", one.code, one.task, one.cycle), "happens", "did not");
  }

  void check_events(const runtime::Resource& resource) {
    std::map<std::string, std::uint64_t> events;
    for (std::size_t task = 0; task < resource.task_count(); ++task) {
      for (const runtime::EventCount& event : resource.program(task).events())
        events[std::string(stdlib::event_name(event.last))] += event.count;
    }
    std::map<std::string, std::uint64_t> all = events;
    for (const auto& [kind, count] : case_.events) all[kind];
    for (const auto& [kind, ignored] : all) {
      const auto expected = case_.events.find(kind);
      const std::uint64_t wanted = expected == case_.events.end() ? 0 : expected->second;
      ++result_.checks;
      if (wanted != events[kind]) fail(0, "events " + kind, std::to_string(wanted), std::to_string(events[kind]));
    }
  }

  const CaseRequest& request_;
  const CaseFile& case_;
  const CaseRun& run_;
  TestResult& result_;
  fs::path table_;
};

}  // namespace

core::Result<std::vector<TestResult>> run_case(const CaseRequest& request) {
  const CaseFile the_case = read_case(request.folder);
  if (!the_case.wrong.empty())
    return unusable(request.folder, the_case.wrong.front(), "the lines of case.txt are in tests/cases/README.md");
  std::vector<TestResult> results;
  for (const CaseRun& run : the_case.runs) {
    if (!fs::exists(request.folder / run.expected))
      return unusable(request.folder, "there is no table " + run.expected, "write what the variables should be");
    TestResult result;
    result.name = request.name;
    for (const std::string& option : run.options) result.name += " " + option;
    if (the_case.runs.size() > 1 && run.options.empty()) result.name += " " + run.expected;
    result.file = (request.folder / run.expected).string();
    result.line = 1;
    const core::MonotonicClock clock;
    const core::TimeNs begin = clock.now_ns();
    if (auto problem = CaseOfTable(request, the_case, run, result).run()) return *problem;
    result.took_ns = clock.now_ns() - begin;
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace plc::tests
