// plc test: runs the tests of projects in virtual time.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "core/glob.h"
#include "drawings/make.h"
#include "testing/case_run.h"
#include "testing/coverage.h"
#include "testing/discover.h"
#include "testing/runner.h"
#include "tools/command_line.h"
#include "tools/date.h"
#include "tools/engine.h"
#include "tools/plc/commands.h"
#include "tools/plc/coverage_svg.h"
#include "tools/plc/test_report.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

namespace fs = std::filesystem;
using tests::Unit;

struct Test {
  std::vector<std::string> paths, filters, libraries;
  std::string configuration, junit, svg;
  std::uint64_t seed = 0;
  DateOptions date;
  std::uint64_t max_cycles = tests::RunnerOptions::kMaxCycles;
  bool tap = false, list = false, coverage = false, cover_all = false;
  Engine engine = Engine::kAuto;
  runtime::ProgramOptions program;
  core::CompileOptions options;

  [[nodiscard]] bool covers() const { return coverage || cover_all || !svg.empty(); }
};

/// Numbers 0 to `count` - 1, with a seed in an order that it decides: the same on every machine (Fisher and Yates, with
/// SplitMix64 of G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
std::vector<std::size_t> order_of(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (seed == 0) return order;
  const auto next = [&seed] {
    std::uint64_t z = seed += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  };
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[next() % i]);
  return order;
}

/// Runs the units, one after the other, and keeps what they gave.
class TestRun {
 public:
  explicit TestRun(const Test& test) : test_(test), text_(test.tap ? std::cerr : std::cout) {}

  void run(const Unit& unit) {
    Suite& suite = suites_.emplace_back();
    suite.name = unit.path;
    if (const auto problem = unit.is_case ? run_case(unit, suite) : run_project(unit, suite)) {
      complain(*problem);
      suite.errors.push_back(problem->message);
      code_ = std::max(code_, exit_code_of(*problem));
    }
    if (suite.results.empty() && suite.errors.empty()) return suites_.pop_back();
    if (!test_.tap && !test_.list) print_suite(suite, std::cout);
    if (!report_.empty()) text_ << report_;
    report_.clear();
  }

  int finish() {
    if (test_.list) return code_;
    if (test_.tap) print_tap(suites_, std::cout);
    const TestTotals totals = totals_of(suites_);
    if (!test_.junit.empty()) {
      std::string why;
      if (!write_file(test_.junit, junit_xml(suites_), why)) {
        complain("plc test", "cannot write " + test_.junit + ": " + why);
        return kExitUsage;
      }
    }
    text_ << totals_text(totals);
    if (test_.seed != 0) text_ << ", seed " << test_.seed;
    text_ << '\n';
    if (totals.tests + totals.broken == 0) {
      complain("plc test", test_.filters.empty() ? "there are no tests" : "no test has a name that --filter matches",
               test_.filters.empty()
                   ? "write TEST 'what it shows' .. END_TEST in plant_test.st beside plant.xml or plant.st"
                   : "--list shows all names");
      return kExitUsage;
    }
    return std::max(code_, totals.good() && missed_ == 0 ? kExitOk : kExitErrors);
  }

 private:
  [[nodiscard]] bool wanted(const std::string& name) const {
    return test_.filters.empty() ||
           std::any_of(test_.filters.begin(), test_.filters.end(),
                       [&](const std::string& pattern) { return core::glob_match(pattern, name); });
  }

  /// Taskblocks and libraries that --config, or else the plc.toml beside the project, adds.
  std::optional<int> configure(const fs::path& folder, taskblocks::Registry& registry,
                               std::vector<std::string>& libraries) const {
    std::string configuration = test_.configuration;
    const fs::path beside = folder / "plc.toml";
    if (configuration.empty() && fs::exists(beside)) configuration = beside.string();
    return load_taskblocks(configuration, registry, libraries);
  }

  std::optional<core::Problem> run_case(const Unit& unit, Suite& suite) {
    if (!wanted(unit.path)) return std::nullopt;
    if (test_.list) {
      std::cout << unit.path << '\n';
      return std::nullopt;
    }
    taskblocks::Registry registry;
    std::vector<std::string> libraries = test_.libraries;
    if (const auto code = configure(unit.path, registry, libraries)) return broken(suite, "plc.toml has errors", *code);
    auto results = tests::run_case({unit.path, fs::path(unit.path).filename().string(), libraries, &registry});
    if (!results) return results.error();
    suite.results = std::move(*results);
    return std::nullopt;
  }

  std::optional<core::Problem> broken(Suite& suite, std::string why, int code) {
    suite.errors.push_back(std::move(why));
    code_ = std::max(code_, code);
    return std::nullopt;
  }

  std::optional<core::Problem> run_project(const Unit& unit, Suite& suite) {
    taskblocks::Registry registry;
    std::vector<std::string> libraries = test_.libraries;
    if (const auto code = configure(fs::path(unit.path).parent_path(), registry, libraries))
      return broken(suite, "plc.toml has errors", *code);
    if (auto problem = registry.add(tests::host_library())) return problem;
    compiler::Compilation compilation;
    compiler::Request request{unit.path, test_.options, compiler::Goal::kRun, libraries, {}, &registry};
    request.tests = true;
    request.test_files = unit.files;
    request.coverage = test_.covers();
    compiler::compile(request, compilation);
    compilation.diagnostics.render_with_lines(std::cerr);
    if (!compilation.ok()) {
      return broken(suite,
                    compilation.diagnostics.all().empty()
                        ? "file cannot be read"
                        : compilation.diagnostics.render_one(first_error(compilation.diagnostics)),
                    compilation.readable ? kExitErrors : kExitUsage);
    }
    if (!compilation.tests) return broken(suite, "has no tests", kExitUsage);

    std::vector<std::string> files;
    for (std::size_t f = 0; f < compilation.diagnostics.file_count(); ++f)
      files.push_back(compilation.diagnostics.file_name(static_cast<std::uint16_t>(f)));
    const std::vector<ir::CoverSite> sites = compilation.cover_sites;
    std::vector<tests::Waiver> waivers = tests::waivers_of(compilation.tests->pragmas);
    tests::RunnerOptions options;
    options.program = test_.program;
    options.program.zone = &test_.date.time_zone;
    options.date_ns = test_.date.date_ns;
    options.max_cycles = test_.max_cycles;
    const Engine engine = test_.covers() ? Engine::kInterpreter : test_.engine;
    options.prepare = [engine](runtime::Resource& resource) { return prepare_engine(resource, engine, "plc test"); };
    auto runner = tests::Runner::make(std::move(compilation), registry, std::move(options));
    if (!runner) return runner.error();
    bool all = true;
    for (const std::size_t index : order_of((*runner)->tests().size(), test_.seed)) {
      const std::string& name = (*runner)->tests()[index].name;
      if (!wanted(name)) {
        all = false;
        continue;
      }
      if (test_.list) {
        std::cout << unit.path << ": " << name << '\n';
        continue;
      }
      auto result = (*runner)->run(index);
      if (!result) return result.error();
      suite.results.push_back(std::move(*result));
    }
    if (test_.covers() && !test_.list && !suite.results.empty())
      return cover(unit, files, tests::CoverageReport(sites, (*runner)->seen(), std::move(waivers)), all);
    return std::nullopt;
  }

  static const core::Diagnostic& first_error(const core::Diagnostics& diagnostics) {
    const std::vector<core::Diagnostic>& all = diagnostics.all();
    const auto error = std::find_if(all.begin(), all.end(),
                                    [](const core::Diagnostic& one) { return one.severity == core::Severity::kError; });
    return error == all.end() ? all.front() : *error;
  }

  /// Prints what was seen and paints it; `all`: every test has run.
  std::optional<core::Problem> cover(const Unit& unit, const std::vector<std::string>& files,
                                     const tests::CoverageReport& coverage, bool all) {
    report_ = coverage.text(files);
    if (test_.cover_all && coverage.open_contacts() != 0) {
      missed_ += coverage.open_contacts();
      report_ += fmt::format("--cover-all: {} of contacts not seen, without a {{not_covered ..}}{}\n",
                             counted(coverage.open_contacts(), "outcome"), all ? "" : "; --filter left tests out");
    }
    if (test_.svg.empty()) return std::nullopt;
    // The compiler gives bodies back as soon as they are lowered.
    compiler::Compilation again;
    compiler::compile({unit.path, {}, compiler::Goal::kRead}, again);
    if (!again.project) return std::nullopt;
    std::error_code failed;
    fs::create_directories(test_.svg, failed);
    std::map<std::string, std::size_t> worksheets;
    for (const bytecode::DrawnBody& body : drawings::make(*again.project, again.diagnostics).bodies) {
      const std::size_t number = ++worksheets[body.name];
      if (body.elements.empty()) continue;
      const std::string name = body.name + (number == 1 ? "" : "_" + std::to_string(number));
      const std::string path = (fs::path(test_.svg) / (name + ".svg")).string();
      std::string why;
      if (!write_file(path, coverage_svg(body, coverage), why))
        return core::Problem{core::Code::P7203, "cannot write " + path + ": " + why, {}};
    }
    return std::nullopt;
  }

  const Test& test_;
  std::ostream& text_;
  std::vector<Suite> suites_;
  std::string report_;
  std::size_t missed_ = 0;
  int code_ = kExitOk;
};

int run(Test& test) {
  if (const auto code = parse_date_options("plc test", test.date)) return *code;
  const auto units = tests::find_units(test.paths);
  if (!units) return complain(units.error()), exit_code_of(units.error());
  TestRun run(test);
  for (const Unit& unit : *units) run.run(unit);
  return run.finish();
}

std::string list_of_calls() {
  std::vector<std::vector<std::string>> lines;
  for (const ir::TestCallInfo& one : ir::test_calls())
    lines.push_back({fmt::format("{}({})", one.name, one.arguments), std::string(one.summary)});
  return "What tests call beside everything else:\n" + columns_text(lines, 2);
}

}  // namespace

void add_test(Command program) {
  static Test test;
  const Command command = program.sub(
      "test",
      "Runs tests in virtual time, each from a cold start, and says what was not as expected. Exit code 1 when a test\n"
      "fails.\n"
      "\n"
      "Examples:\n"
      "  plc test plant_test.st                     the tests of plant.xml or plant.st beside it\n"
      "  plc test plant.st                          those in the file, and in plant_test.st\n"
      "  plc test .                                 all tests and cases below this folder\n"
      "  plc test plant_test.st --filter '*pump*'   those whose name has it\n"
      "  plc test . --tap --junit tests.xml         for harnesses and build servers\n"
      "  plc test plant_test.st --coverage          which contacts, rungs and branches the tests have shown\n"
      "\n"
      "A test is a text among declarations:\n"
      "\n"
      "  TEST 'the pump stops when the tank is full'\n"
      "  VAR i : INT; END_VAR\n"
      "    %IX0.0 := TRUE;                        inputs, globals and variables of programs by name or path\n"
      "    RUN_CYCLES(1);                         the tasks run\n"
      "    ASSERT_TRUE(Main.Pump);\n"
      "    Main.Level := 95.0;\n"
      "    ADVANCE_TIME(T#2s);\n"
      "    ASSERT_EQ(FALSE, Main.Pump, 'full');   expected first\n"
      "  END_TEST\n"
      "\n"
      "A case is a folder with project.st or project.xml, expected.csv and perhaps stimulus.csv and case.txt.");
  command.option("FILE", test.paths, "files and folders with tests").required();
  command
      .option("--filter=GLOB", test.filters,
              "only tests whose name matches; * and ? match; may be repeated. Cases go by their folder")
      .repeated();
  command.flag("--list", test.list, "print the names of the tests, and run none");
  command.option("--seed=N", test.seed, "run the tests of each project in an order that N decides; 0 = as written");
  command.flag("--tap", test.tap, "Test Anything Protocol on stdout, all else on stderr");
  command.option("--junit=FILE", test.junit, "write results as JUnit's XML");
  command.flag("--coverage", test.coverage,
               "print which contacts were seen open and closed with power before them, coils with and without power, "
               "rungs executed, branches of IF and CASE taken; what was not seen, and why");
  command.flag("--cover-all", test.cover_all,
               "the same, and exit code 1 when an outcome of a contact was neither seen nor named by a pragma "
               "{not_covered POU 'contact' open 'reason'} in the file of tests");
  command.option("--svg=FOLDER", test.svg, "paint coverage into a picture of each drawn POU");
  command.option("--max-cycles=N", test.max_cycles, "release instants that one test may run")
      .check(wrong_count)
      .shows_default();
  add_date_options(command, test.date);
  add_loop_budget(command, test.program);
  add_engine_option(command, test.engine);
  add_library_option(command, test.libraries);
  command.option("--config=plc.toml", test.configuration,
                 "configuration whose [project] and [taskblocks] libraries the projects use; default: the plc.toml "
                 "beside each");
  command.footer(list_of_calls());
  add_compile_options(command, test.options);
  command.on_run([] { return run(test); });
}

}  // namespace plc::tools
