// plc-test-engines: generated programs in every engine; tables, events and faults are equal after every scan (README.md
// of this folder).
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>

#include "compiler/compile.h"
#include "tests/engines/coverage.h"
#include "tests/engines/drawing.h"
#include "tests/engines/probes.h"
#include "tests/engines/reduce.h"
#include "tests/programs/model.h"
#include "tests/support/engines.h"
#include "tests/support/failing_taskblock.h"
#include "tests/support/random_chart.h"
#include "tests/support/random_image.h"
#include "tests/support/random_inputs.h"
#include "tests/support/replayed.h"
#include "tools/cli.h"

namespace plc::test {
namespace {

enum class Kind { kImage, kText, kDrawing, kChart, kMixed };

struct Plan {
  Kind kind = Kind::kMixed;
  std::uint64_t first = 1, programs = 1000;
  std::uint64_t scans = 8;
  std::uint64_t most_failures = 1;
  bool coverage = false, print = false, replay = false, probes = false;
  PlantedFault planted = PlantedFault::kNone;
  std::string folder{};  ///< for files of the front ends
};

struct Tally {
  std::uint64_t programs[4] = {};  ///< by kind
  std::uint64_t faults[2] = {};    ///< loop budgets, taskblocks
  std::uint64_t scans = 0, events = 0, failures = 0, recorded_bytes = 0;
};

/// What the programs of a seed are made from: most are images, which take the least time.
Kind kind_of(std::uint64_t seed, const Plan& plan) {
  if (plan.kind != Kind::kMixed) return plan.kind;
  if (seed % 100 == 0) return Kind::kText;
  if (seed % 100 == 50) return Kind::kChart;
  return seed % 10 == 1 ? Kind::kDrawing : Kind::kImage;
}

/// A program, or why there is none.
struct Program {
  std::optional<bytecode::VerifiedImage> image;
  std::string source;  ///< as text
  std::string problem;
};

Program compile_source(std::string source, const std::string& path) {
  Program out;
  if (std::FILE* const file = std::fopen(path.c_str(), "wb")) {
    std::fwrite(source.data(), 1, source.size(), file);
    std::fclose(file);
  }
  compiler::Compilation compilation;
  compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
  if (compilation.ok() && compilation.image) {
    out.image = std::move(*compilation.image);
  } else {
    std::ostringstream text;
    compilation.diagnostics.render(text);
    out.problem = text.str();
  }
  out.source = std::move(source);
  return out;
}

Program make(std::uint64_t seed, Kind kind, const Plan& plan) {
  switch (kind) {
    case Kind::kText:
      return compile_source(programs::generate(seed).st(), plan.folder + "/program.st");
    case Kind::kDrawing:
      return compile_source(random_drawing(seed), plan.folder + "/program.xml");
    case Kind::kChart:
      return compile_source(chart_program(RandomChart(static_cast<std::uint32_t>(seed)).net()),
                            plan.folder + "/program.st");
    default:
      break;
  }
  Program out;
  core::Diagnostics diagnostics;
  out.image = bytecode::verify(RandomImage(seed, &registry_with_failures()).make(4 + seed % 29), diagnostics);
  if (!out.image) out.problem = diagnostics.all().empty() ? "refused" : diagnostics.all().front().message;
  return out;
}

/// Runs a program with inputs of its seed. What differs first, or nothing.
std::string run(const bytecode::VerifiedImage& image, std::uint64_t seed, Kind kind, const Plan& plan,
                const std::vector<Engine>& list, Tally& tally) {
  Random random(seed + (std::uint64_t{1} << 40));
  // Generated texts have loops that end; those of images and drawings end at the budget, at the latest.
  static constexpr std::uint32_t kBudgets[] = {2, 40, 300};
  runtime::ProgramOptions options;
  if (kind == Kind::kImage || kind == Kind::kDrawing) options.loop_budget = random.one_of(kBudgets);
  options.taskblocks = &registry_with_failures();
  std::string problem;
  const auto engines = Engines::link(image, problem, options, list);
  if (engines == nullptr) return "not linked: " + problem;
  // Recorded in one engine, executed again in the other.
  std::unique_ptr<Replayed> replayed;
  const std::size_t recorded = seed % 2;
  if (plan.replay) {
    replayed = Replayed::make(image, (*engines)[recorded], options, list[1 - recorded], problem);
    if (replayed == nullptr) return "no replica: " + problem;
  }
  RandomInputs inputs(image.image());
  // Mostly at once, now and then between two scans.
  const std::uint64_t compiled = random.once_in(8) ? random.below(plan.scans) : 0;
  const std::uint64_t reset = random.once_in(16) ? random.below(plan.scans) : plan.scans;
  const std::size_t sparsity = 2 + random.below(20);
  core::TimeNs now_ns = 0;
  for (std::uint64_t scan = 0; scan < plan.scans; ++scan) {
    if (scan == compiled) {
      problem = engines->compile();
      if (!problem.empty()) return problem;
    }
    for (std::size_t task = 0; scan == reset && task < engines->tasks(); ++task) {
      for (std::size_t e = 0; e < engines->size(); ++e) (*engines)[e].program(task).reset();
      if (replayed) replayed->load(static_cast<std::uint32_t>(task));
    }
    if (scan > 0) inputs.choose(random, sparsity);
    for (std::size_t e = 0; scan > 0 && e < engines->size(); ++e) inputs.write((*engines)[e]);
    const std::size_t turn = random.below(engines->tasks());
    for (std::size_t n = 0; n < engines->tasks(); ++n) {
      if (n > 0 && random.once_in(4)) continue;
      const std::size_t task = (turn + n) % engines->tasks();
      const std::string difference = engines->scan(task, now_ns);
      ++tally.scans;
      if (engines->fault()) ++tally.faults[engines->fault().kind == runtime::FaultKind::kLoopBudget ? 0 : 1];
      if (!difference.empty()) return fmt::format("scan {}, task {}: {}", scan, task, difference);
      const std::string other = replayed ? replayed->check(static_cast<std::uint32_t>(task)) : std::string();
      if (!other.empty()) return fmt::format("scan {}, task {}, executed again: {}", scan, task, other);
    }
    now_ns += static_cast<core::TimeNs>(random.below(4)) * RandomImage::kPeriodNs;
  }
  for (std::size_t task = 0; task < engines->tasks(); ++task) {
    tally.events += (*engines)[0].program(task).event_total();
  }
  if (replayed) tally.recorded_bytes += replayed->bytes();
  return {};
}

void report(const Program& program, std::uint64_t seed, Kind kind, const Plan& plan, const std::string& difference) {
  const std::vector<Engine> engines = all_engines();
  Tally ignored;
  const bytecode::Image smaller = reduce(program.image->image(), [&](const bytecode::Image& image) {
    core::Diagnostics diagnostics;
    const auto verified = bytecode::verify(bytecode::Image(image), diagnostics);
    return verified && !run(*verified, seed, kind, plan, engines, ignored).empty();
  });
  std::cout << fmt::format("seed {}: {}\nmade smaller:\n{}\n", seed, difference, bytecode::disassemble(smaller));
}

/// Wrong code may also crash: the seed is then the last that is heard of it.
volatile std::sig_atomic_t crashed = 0;
std::uint64_t running_seed = 0;
void name_seed(int signal) {
  if (crashed != 0) return;
  crashed = 1;
  char text[] = "crash in seed 00000000000000000000\n";
  std::size_t at = sizeof text - 3;
  for (std::uint64_t seed = running_seed; seed != 0; seed /= 10) text[at--] = static_cast<char>('0' + seed % 10);
  static_cast<void>(!::write(STDERR_FILENO, text, sizeof text - 1));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Of a run that somebody ends before its time, what was done counts.
volatile std::sig_atomic_t ended = 0;
void end(int) { ended = 1; }

/// One line on standard error in every minute.
class Progress {
 public:
  explicit Progress(const Plan& plan) : plan_(plan) {}
  void tell(std::uint64_t seed) {
    const auto now = std::chrono::steady_clock::now();
    if (now - told_ < std::chrono::minutes(1)) return;
    told_ = now;
    std::cerr << fmt::format("{} of {} programs, next seed {}\n", seed - plan_.first, plan_.programs, seed);
  }

 private:
  const Plan& plan_;
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

int run(const Plan& plan) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) std::signal(signal, name_seed);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, end);
  Coverage coverage;
  std::vector<Engine> engines = all_engines();
  for (Engine& engine : engines) {
    if (engine.name == native_code().name) engine = coverage.native_code();
  }
  Tally tally;
  Progress progress(plan);
  for (std::uint64_t seed = plan.first; seed < plan.first + plan.programs && ended == 0; ++seed) {
    running_seed = seed;
    progress.tell(seed);
    const Kind kind = kind_of(seed, plan);
    const Program program = make(seed, kind, plan);
    if (plan.print) {
      std::cout << (kind == Kind::kImage && program.image ? bytecode::disassemble(program.image->image())
                                                          : program.source);
    }
    coverage.next_program();
    ++tally.programs[static_cast<std::size_t>(kind)];
    if (!program.image) {
      std::cout << fmt::format("seed {}: refused\n{}\n", seed, program.problem);
    } else {
      const std::string difference = run(*program.image, seed, kind, plan, engines, tally);
      if (difference.empty()) continue;
      report(program, seed, kind, plan, difference);
    }
    std::cout << std::flush;
    if (++tally.failures == plan.most_failures) break;
  }
  std::cout << fmt::format(
      "{} programs from seed {} ({} images, {} texts, {} drawings, {} charts), {} scans in each of {} engines, {} "
      "events, {} "
      "loop budgets used up, {} taskblocks failed; {} failed\n",
      std::accumulate(std::begin(tally.programs), std::end(tally.programs), std::uint64_t{0}), plan.first,
      tally.programs[0], tally.programs[1], tally.programs[2], tally.programs[3], tally.scans, engines.size(),
      tally.events, tally.faults[0], tally.faults[1], tally.failures);
  if (plan.replay) std::cout << fmt::format("executed again from {} bytes of records\n", tally.recorded_bytes);
  coverage.print_summary(std::cout);
  if (plan.coverage) coverage.print(std::cout);
  return tally.failures == 0 ? 0 : 1;
}

std::string source_of(std::uint64_t seed, Kind kind) {
  switch (kind) {
    case Kind::kText:
      return programs::generate(seed).st();
    case Kind::kChart:
      return chart_program(RandomChart(static_cast<std::uint32_t>(seed)).net());
    default:
      return random_drawing(seed);
  }
}

/// Drawings, texts and charts with probes. A fault that is planted has to be found.
int run_with_probes(const Plan& plan) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) std::signal(signal, name_seed);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, end);
  ProbeTally tally;
  Progress progress(plan);
  std::uint64_t failures = 0, seed = plan.first;
  for (; seed < plan.first + plan.programs && ended == 0; ++seed) {
    running_seed = seed;
    progress.tell(seed);
    static constexpr Kind kKinds[] = {Kind::kDrawing, Kind::kText, Kind::kDrawing, Kind::kChart, Kind::kDrawing};
    const Kind kind = plan.kind == Kind::kMixed ? kKinds[seed % std::size(kKinds)] : plan.kind;
    const std::string source = source_of(seed, kind);
    const std::string path = plan.folder + (kind == Kind::kDrawing ? "/program.xml" : "/program.st");
    std::ofstream(path, std::ios::binary) << source;
    if (plan.print) std::cout << source;
    const std::string difference = compare_probes(path, seed, plan.scans, plan.planted, tally);
    if (difference.empty()) continue;
    std::cout << fmt::format("seed {}: {}\n", seed, difference) << std::flush;
    if (++failures == plan.most_failures) break;
  }
  std::cout << fmt::format(
      "{} programs from seed {}, {} points, {} scans: {} values compared, {} not computed, {} places not come by; {} "
      "failed\n",
      tally.programs, plan.first, tally.points, tally.scans, tally.values, tally.not_computed, tally.not_run, failures);
  const bool found = failures != 0;
  return found == (plan.planted != PlantedFault::kNone) ? 0 : 1;
}

}  // namespace
}  // namespace plc::test

int main(int argc, char** argv) {
  using namespace plc::test;
  const plc::tools::Program program(
      "plc-test-engines",
      "Generated programs in every engine: tables, events and faults are equal after every scan.\n"
      "\n"
      "Examples:\n"
      "  plc-test-engines --programs 3000             what ctest runs\n"
      "  plc-test-engines --programs 1000000          the long run\n"
      "  plc-test-engines --seed 7 --programs 1       one program again\n"
      "\n"
      "Long runs say every minute how far they are; Ctrl-C ends one with its counts.\n"
      "Exit codes: 0 all equal, 1 a difference, 2 trouble with files.");
  Plan plan;
  program.option("--seed", plan.first, "of the first program; the next have the next seeds").shows_default();
  program.option("--programs", plan.programs, "how many").shows_default();
  program.option("--scans", plan.scans, "of each task of a program, about").shows_default().range(1, 1'000'000);
  program.choice("--kind", plan.kind,
                 {{"images", Kind::kImage},
                  {"texts", Kind::kText},
                  {"drawings", Kind::kDrawing},
                  {"charts", Kind::kChart},
                  {"mixed", Kind::kMixed}},
                 "images (made of instructions), texts (ST), drawings (LD and FBD), charts (SFC), or mixed");
  program.option("--failures", plan.most_failures, "stop after this many, 0 = never").shows_default();
  program.flag("--replay", plan.replay, "record each scan in one engine and execute each task alone in another");
  program.flag("--probes", plan.probes,
               "compare what probes of drawings, texts and charts show with programs that store each value");
  program.choice("--plant", plan.planted, {{"order", PlantedFault::kOrder}, {"late", PlantedFault::kLate}},
                 "put a fault into the probe maps, which has to be found: jumps execute all steps, or captures are a "
                 "word late");
  program.flag("--coverage", plan.coverage, "print how many programs had which instruction");
  program.flag("--print", plan.print, "print the programs: text, XML, or a listing of the image");
  if (const auto code = program.parse(argc, argv)) return *code;
  std::string folder = (std::filesystem::temp_directory_path() / "plc-engines-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) return 2;
  plan.folder = folder;
  const int result = plan.probes ? run_with_probes(plan) : run(plan);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return result;
}
