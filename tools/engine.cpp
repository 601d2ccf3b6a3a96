#include "tools/engine.h"

#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>

#include <csignal>
#include <utility>

#include "native/compile.h"
#include "runtime/compiled_task.h"
#include "tools/command_line.h"

namespace plc::tools {

void add_engine_option(CLI::App& app, Engine& engine) {
  app.add_option(
         "--engine", engine,
         fmt::format("what runs the tasks: interp, native (machine code, made before the first scan) or auto (the "
                     "interpreter at once, native code as soon as it is made); default {}",
                     engine == Engine::kAuto ? "auto" : "interp"))
      ->transform(choice_validator<Engine>(
          {{"interp", Engine::kInterpreter}, {"native", Engine::kNative}, {"auto", Engine::kAuto}}))
      ->type_name("NAME");
}

std::string engine_name(const runtime::Program& program) { return program.compiled_since() ? "native" : "interpreter"; }

namespace {
native::CompileOptions options_of(std::span<const runtime::Evaluate> evaluate, std::size_t task) {
  return {.changed = task < evaluate.size() && evaluate[task] == runtime::Evaluate::kChanged};
}
}  // namespace

std::string skipped_text(const runtime::Program& program) {
  const runtime::SkipCounts* const skipped = program.skipped();
  if (skipped == nullptr) return {};
  const std::uint64_t scans = skipped->scans;
  const std::uint64_t whole = skipped->whole_scans;
  const double all = static_cast<double>(skipped->groups) * static_cast<double>(scans - whole);
  const double share = all == 0 ? 0 : 1 - static_cast<double>(skipped->runs) / all;
  return fmt::format("{:.1f} % of {} groups left out, {} of {} scans whole", share * 100, skipped->groups, whole,
                     scans);
}

std::vector<std::pair<std::string, std::uint64_t>> skipped_counts(const runtime::Program& program) {
  const runtime::SkipCounts* const skipped = program.skipped();
  if (skipped == nullptr) return {};
  return {{"groups", skipped->groups},
          {"group_runs", skipped->runs.load()},
          {"native_scans", skipped->scans.load()},
          {"whole_scans", skipped->whole_scans.load()}};
}

std::optional<core::Problem> compile_all(runtime::Resource& resource, std::span<const runtime::Evaluate> evaluate) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    auto compiled = native::compile(resource.program(task), options_of(evaluate, task));
    if (!compiled) return compiled.error();
    resource.program(task).install(std::move(*compiled));
  }
  ::malloc_trim(0);
  return std::nullopt;
}

BackgroundCompiler::BackgroundCompiler(runtime::Resource& resource, std::vector<runtime::Evaluate> evaluate)
    : resource_(resource),
      evaluate_(std::move(evaluate)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void BackgroundCompiler::run(const std::stop_token& stop) {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  // Refused nowhere: less is anybody's right.
  const sched_param none{};
  pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
  for (std::size_t task = 0; task < resource_.task_count() && !stop.stop_requested(); ++task) {
    runtime::Program& program = resource_.program(task);
    auto compiled = native::compile(program, options_of(evaluate_, task));
    if (compiled) {
      program.install(std::move(*compiled));
    } else {
      notes_.push_back(
          fmt::format("task {} stays with the interpreter: {}", program.task().name, compiled.error().message));
    }
  }
  ended_.store(true, std::memory_order_release);
}

std::vector<std::string> BackgroundCompiler::take_notes() {
  return ended_.load(std::memory_order_acquire) ? std::exchange(notes_, {}) : std::vector<std::string>();
}

}  // namespace plc::tools
