// Engines: --engine, and the thread that compiles while the interpreter runs (docs/guides/engines.md).
//
// In: a resource that is to run, or runs. Out: compiled tasks, installed; what could not be compiled and why. Does not
// belong here: the compiler (native/).
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/resource.h"
#include "runtime/sched/task_plan.h"

namespace plc::tools {

enum class Engine : std::uint8_t {
  kInterpreter,
  kNative,  ///< compiled before the first scan; a task that cannot be compiled is an error
  kAuto,    ///< the interpreter at once, native code as soon as there is some
};

/// Adds --engine. `engine` must outlive the parsing and holds the default.
void add_engine_option(CLI::App& app, Engine& engine);

/// "interpreter" or "native": what the task's last scan ran in.
std::string engine_name(const runtime::Program& program);

/// Compiles and installs all tasks of a resource. The first problem, when a task cannot be compiled.
/// `evaluate`: what scans are to execute, by task; empty = everything.
std::optional<core::Problem> compile_all(runtime::Resource& resource, std::span<const runtime::Evaluate> evaluate);

/// "97 % of 10000 groups left out, 34 of 5000 scans whole", or nothing for a task that executes everything.
std::string skipped_text(const runtime::Program& program);
/// The same as numbers with the names that documents give them; none for a task that executes everything.
std::vector<std::pair<std::string, std::uint64_t>> skipped_counts(const runtime::Program& program);

/// Compiles the tasks one after the other in a thread of the lowest priority, which takes nothing from anybody. A task
/// that cannot be compiled stays with the interpreter.
class BackgroundCompiler {
 public:
  BackgroundCompiler(runtime::Resource& resource, std::vector<runtime::Evaluate> evaluate);
  /// Waits for the task that is being compiled.
  ~BackgroundCompiler() = default;
  BackgroundCompiler(const BackgroundCompiler&) = delete;
  BackgroundCompiler& operator=(const BackgroundCompiler&) = delete;

  /// Why a task stays with the interpreter: a sentence for each, once compiling has ended. Once.
  std::vector<std::string> take_notes();

 private:
  void run(const std::stop_token& stop);

  runtime::Resource& resource_;
  std::vector<runtime::Evaluate> evaluate_;
  std::vector<std::string> notes_;
  std::atomic<bool> ended_{false};
  std::jthread thread_;  // the last member: it uses all others
};

}  // namespace plc::tools
