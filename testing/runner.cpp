#include "testing/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <tuple>
#include <utility>

#include "core/clock.h"
#include "runtime/access.h"

namespace plc::tests {

using bytecode::Image;
using bytecode::ImageField;
using runtime::Place;

namespace {

/// The field of a structure; null when it has none of this name.
const ImageField* field_named(const Image& image, std::uint32_t type, std::string_view name) {
  const std::vector<ImageField>& fields = image.types[type].fields;
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const ImageField& f) { return f.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

std::string expectation(ir::TestCall call, const std::string& value, const std::string& tolerance) {
  switch (call) {
    case ir::TestCall::kAssertTrue:
      return "TRUE";
    case ir::TestCall::kAssertFalse:
      return "FALSE";
    case ir::TestCall::kAssertNe:
      return "not " + value;
    case ir::TestCall::kAssertLt:
      return "below " + value;
    case ir::TestCall::kAssertLe:
      return "at most " + value;
    case ir::TestCall::kAssertGt:
      return "above " + value;
    case ir::TestCall::kAssertGe:
      return "at least " + value;
    case ir::TestCall::kAssertNear:
      return value + " +- " + tolerance;
    default:
      return value;
  }
}

}  // namespace

void add_failure(TestResult& result, Failure failure) {
  ++result.failure_count;
  if (result.failures.size() < kMaxFailuresKept) result.failures.push_back(std::move(failure));
}

core::Result<std::unique_ptr<Runner>> Runner::make(compiler::Compilation compilation,
                                                   const taskblocks::Registry& registry, RunnerOptions options) {
  std::unique_ptr<Runner> made(new Runner());
  made->options_ = std::move(options);
  for (std::size_t f = 0; f < compilation.diagnostics.file_count(); ++f)
    made->files_.push_back(compilation.diagnostics.file_name(static_cast<std::uint16_t>(f)));
  made->tests_ = std::move(compilation.tests->tests);
  made->assertions_ = std::move(compilation.tests->assertions);
  made->seen_.resize(2 * compilation.cover_sites.size());
  if (compilation.image) {
    runtime::ProgramOptions program = made->options_.program;
    program.taskblocks = &registry;
    auto project = runtime::Resource::load(std::move(*compilation.image), program);
    if (!project) return project.error();
    made->project_ = std::move(*project);
    if (made->options_.prepare) {
      if (auto problem = made->options_.prepare(*made->project_)) return *problem;
    }
  }
  // WHY not arranged: what a test calls reads and writes its table in the middle of a scan.
  runtime::ProgramOptions bench;
  bench.arrange = false;
  bench.taskblocks = &registry;
  bench.zone = made->options_.program.zone;
  bench.global_taskblocks = made->project_ == nullptr;
  bench.loop_budget = made->options_.program.loop_budget;
  {
    const HostScope scope(*made);
    auto loaded = runtime::Resource::load(std::move(compilation.tests->image), bench);
    if (!loaded) return loaded.error();
    made->bench_ = std::move(*loaded);
  }
  if (made->project_) {
    auto mirror = Mirror::make(*made->project_, *made->bench_, compilation.tests->programs);
    if (!mirror) return mirror.error();
    made->mirror_ = std::move(*mirror);
  }
  const Image& image = made->bench_->image();
  const ImageField* const program =
      field_named(image, image.pous[image.tasks[0].body].instance_type, compiler::kTestsName);
  const ImageField* const which =
      program == nullptr ? nullptr : field_named(image, program->type, compiler::kWhichTest);
  const core::Problem broken{core::Code::P9001, "the image of the tests has no tests", {}};
  if (which == nullptr) return broken;
  const std::uint32_t begin = made->bench_->program(0).table().layout().instance + program->offset;
  made->which_ = begin + which->offset;
  for (const compiler::TestInfo& test : made->tests_) {
    const ImageField* const instance = field_named(image, program->type, test.instance);
    if (instance == nullptr) return broken;
    made->instances_.push_back({0, begin + instance->offset, instance->type, false});
  }
  return made;
}

std::optional<core::Problem> Runner::reset() {
  now_ns_ = 0;
  date_ns_ = options_.date_ns;
  faults_noted_ = 0;
  ended_ = false;
  if (!project_) return std::nullopt;
  project_->globals().reset();
  for (std::size_t task = 0; task < project_->task_count(); ++task) {
    if (auto problem = project_->program(task).reset()) return problem;
  }
  simulation_.emplace(*project_, runtime::SimulationOptions{.date_ns = date_ns_});
  return std::nullopt;
}

core::Result<TestResult> Runner::run(std::size_t test) {
  TestResult result;
  result.name = tests_[test].name;
  result.file = files_[tests_[test].at.file];
  result.line = tests_[test].at.line;
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  if (auto problem = reset()) return *problem;
  test_ = test;
  result_ = &result;
  runtime::Program& bench = bench_->program(0);
  const auto number = static_cast<std::uint32_t>(test);
  std::memcpy(bench.table().data() + which_, &number, sizeof number);
  const std::vector<runtime::EventCount> before = bench.events();
  const runtime::Fault fault = bench.execute({0, 0, date_ns_});
  if (fault && !ended_) {
    const core::SourceRef at = runtime::source_of(bench_->image(), fault.pou, fault.word);
    const core::Code code = runtime::fault_code(fault.kind);
    Failure failure = failure_at(at);
    failure.what = fmt::format("the test ended with fault {}: {}", core::info(code).name, core::info(code).title);
    const std::string block = bench.taskblock_text(fault);
    if (!block.empty()) failure.what += " (" + block + ")";
    add_failure(result, std::move(failure));
  }
  for (std::size_t task = 0; project_ && task < project_->task_count(); ++task) {
    note_events(project_->image(), project_->program(task).events(), {});
  }
  note_events(bench_->image(), bench.events(), before);
  collect_coverage();
  result.cycles = simulation_ ? simulation_->cycles() : 0;
  result.virtual_ns = now_ns_;
  result.took_ns = clock.now_ns() - begin;
  result_ = nullptr;
  return result;
}

bool Runner::on_call(const HostCall& call) {
  switch (call.call) {
    case ir::TestCall::kTestBegins:
      if (mirror_) mirror_->pull();
      return true;
    case ir::TestCall::kAdvanceTime:
      if (call.span_ns < 0) fail_test("ADVANCE_TIME with a negative time: time does not go back");
      return advance_to(now_ns_ + std::max<core::TimeNs>(call.span_ns, 0));
    case ir::TestCall::kRunCycles:
      if (call.cycles < 0) fail_test("RUN_CYCLES with a negative number");
      return run_cycles(call.cycles);
    case ir::TestCall::kSetClock:
      date_ns_ = call.utc_ns - now_ns_;
      if (simulation_) simulation_->set_utc(call.utc_ns, now_ns_);
      bench_->program(0).set_now(now_ns_, call.utc_ns);
      return true;
    default:
      ++result_->checks;
      if (!call.holds) fail_assertion(assertions_[call.site]);
      return true;
  }
}

void Runner::fail_test(std::string what) {
  Failure failure = failure_at(tests_[test_].at);
  failure.what = std::move(what);
  add_failure(*result_, std::move(failure));
}

bool Runner::run_instants(const std::function<bool(core::TimeNs next, std::uint64_t ran)>& more) {
  if (const auto problem = mirror_->push()) fail_test(problem->message);
  std::uint64_t ran = 0;
  for (auto next = simulation_->next_instant_ns(); next && more(*next, ran); next = simulation_->next_instant_ns()) {
    if (simulation_->cycles() >= options_.max_cycles) {
      fail_test(fmt::format("the test ran {} cycles, which is the most that --max-cycles allows", options_.max_cycles));
      ended_ = true;
      return false;
    }
    now_ns_ = *next;  // what happens in this instant is reported with its time
    simulation_->step();
    ++ran;
    if (simulation_->fault_count() != faults_noted_) note_faults();
  }
  return true;
}

bool Runner::advance_to(core::TimeNs end_ns) {
  if (project_) {
    if (!run_instants([&](core::TimeNs next, std::uint64_t) { return next < end_ns; })) return false;
  }
  now_ns_ = end_ns;
  if (mirror_) mirror_->pull();
  bench_->program(0).set_now(now_ns_, date_ns_ + now_ns_);
  return true;
}

bool Runner::run_cycles(std::int64_t count) {
  const auto wanted = static_cast<std::uint64_t>(std::max<std::int64_t>(count, 0));
  if (!run_instants([&](core::TimeNs, std::uint64_t ran) { return ran < wanted; })) return false;
  // Time stands where the next instant will be: what the test does before it runs is seen by it.
  if (wanted != 0) now_ns_ = std::max(now_ns_, simulation_->next_instant_ns().value_or(now_ns_));
  mirror_->pull();
  bench_->program(0).set_now(now_ns_, date_ns_ + now_ns_);
  return true;
}

void Runner::note_faults() {
  const std::vector<runtime::TaskFault>& faults = simulation_->faults();
  for (; faults_noted_ < faults.size(); ++faults_noted_) {
    const runtime::TaskFault& fault = faults[faults_noted_];
    const core::SourceRef at = runtime::source_of(project_->image(), fault.fault.pou, fault.fault.word);
    const core::Code code = runtime::fault_code(fault.fault.kind);
    Failure failure = failure_at(at);
    failure.what = fmt::format("task {} ended its scan with fault {}: {}", project_->image().tasks[fault.task].name,
                               core::info(code).name, core::info(code).title);
    add_failure(*result_, std::move(failure));
  }
  faults_noted_ = simulation_->fault_count();
}

void Runner::note_events(const Image& image, const std::vector<runtime::EventCount>& events,
                         const std::vector<runtime::EventCount>& before) {
  struct Noted {
    core::SourceRef at;
    std::string pou;
    std::uint64_t count = 0;
  };
  std::vector<Noted> all;
  for (const runtime::EventCount& event : events) {
    if (event.last != stdlib::Event::kAssertion) continue;
    const auto known = std::find_if(before.begin(), before.end(), [&](const runtime::EventCount& one) {
      return one.pou == event.pou && one.word == event.word;
    });
    const std::uint64_t count = event.count - (known == before.end() ? 0 : known->count);
    if (count == 0) continue;
    all.push_back({runtime::source_of(image, event.pou, event.word), image.pous[event.pou].name, count});
  }
  std::sort(all.begin(), all.end(), [](const Noted& a, const Noted& b) {
    return std::tie(a.at.file, a.at.line, a.at.column) < std::tie(b.at.file, b.at.line, b.at.column);
  });
  for (const Noted& one : all) {
    Failure failure = failure_at(one.at);
    failure.what = fmt::format("ASSERT of {} did not hold, {} time{}", one.pou, one.count, one.count == 1 ? "" : "s");
    add_failure(*result_, std::move(failure));
  }
}

Failure Runner::failure_at(const core::SourceRef& at) const {
  Failure failure;
  const bool known = at.line != 0 && at.file < files_.size();
  failure.file = known ? files_[at.file] : files_[tests_[test_].at.file];
  failure.line = known ? at.line : tests_[test_].at.line;
  failure.column = known ? at.column : tests_[test_].at.column;
  failure.at_ns = now_ns_;
  failure.cycle = simulation_ ? simulation_->cycles() : 0;
  return failure;
}

std::string Runner::value_of(const std::string& hidden) const {
  if (hidden.empty()) return {};
  const Place& instance = instances_[test_];
  const ImageField* const field = field_named(bench_->image(), instance.type, hidden);
  if (field == nullptr) return "?";
  return runtime::Access(*bench_).read({0, instance.offset + field->offset, field->type, false},
                                       runtime::ValueStyle::kNames);
}

void Runner::fail_assertion(const ir::Assertion& assertion) {
  Failure failure = failure_at(assertion.at);
  failure.what = assertion.text;
  failure.message = assertion.message;
  failure.expected = expectation(assertion.call, value_of(assertion.expected), value_of(assertion.tolerance));
  failure.got = assertion.call == ir::TestCall::kAssertTrue    ? "FALSE"
                : assertion.call == ir::TestCall::kAssertFalse ? "TRUE"
                                                               : value_of(assertion.got);
  add_failure(*result_, std::move(failure));
}

void Runner::collect_coverage() {
  if (seen_.empty()) return;
  std::vector<std::byte> bytes(seen_.size());
  const auto add = [&] {
    for (std::size_t i = 0; i < seen_.size(); ++i) seen_[i] = seen_[i] || bytes[i] != std::byte{0};
  };
  if (project_) {
    const Image& image = project_->image();
    const ImageField* const field = field_named(image, image.global_type, ir::kCoverageName);
    if (field != nullptr) {
      project_->globals().read(field->offset, static_cast<std::uint32_t>(bytes.size()), bytes.data());
      add();
    }
  }
  const Image& image = bench_->image();
  const ImageField* const field = field_named(image, image.global_type, ir::kCoverageName);
  if (field == nullptr) return;
  // What project POUs did that the test itself called.
  std::memcpy(bytes.data(), bench_->program(0).table().data() + field->offset, bytes.size());
  add();
}

}  // namespace plc::tests
