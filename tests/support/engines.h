// Engines: one image in every engine, scan by scan; whatever differs from the interpreter is a fault.
//
// In: an image, a list of engines. Out: after each scan what differs between task tables, global tables, events and
// faults, in words. Does not belong here: what programs compute, inputs (random_inputs.h).
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "native/compile.h"
#include "runtime/resource.h"

namespace plc::test {

/// A way to run tasks.
struct Engine {
  std::string name;
  /// Makes what a task runs instead of the interpreter; empty: the interpreter itself.
  std::function<core::Result<std::unique_ptr<runtime::CompiledTask>>(runtime::Program&)> compile{};
};

inline Engine interpreter() { return {"interpreter"}; }
inline Engine native_code(const native::CompileOptions& options = {}, std::string name = "native code") {
  return {std::move(name),
          [options](runtime::Program& program) -> core::Result<std::unique_ptr<runtime::CompiledTask>> {
            auto compiled = native::compile(program, options);
            if (!compiled) return compiled.error();
            return std::unique_ptr<runtime::CompiledTask>(std::move(*compiled));
          }};
}
/// Those that this processor has. The first is what the others are compared with.
inline std::vector<Engine> all_engines() {
#if defined(__x86_64__) || defined(__aarch64__)
  using native::Naming;
  return {interpreter(), native_code({.naming = Naming::kFromCode}),
          native_code({.naming = Naming::kFromRegister}, "native code, variables from a register"),
          native_code({.baseline = true}, "native code of any processor")};
#else
  return {interpreter()};
#endif
}

class Engines {
 public:
  /// Links the image once for each engine; the interpreter runs all of them until compile(). Null when the linker
  /// refuses the image; `problem` says what.
  static std::unique_ptr<Engines> link(const bytecode::VerifiedImage& image, std::string& problem,
                                       const runtime::ProgramOptions& options = {},
                                       std::vector<Engine> engines = all_engines()) {
    auto made = std::make_unique<Engines>();
    made->engines_ = std::move(engines);
    for (std::size_t i = 0; i < made->engines_.size(); ++i) {
      auto loaded = runtime::Resource::load(bytecode::VerifiedImage(image), options);
      if (!loaded) {
        problem = loaded.error().message;
        return nullptr;
      }
      made->resources_.push_back(std::move(*loaded));
    }
    const std::size_t globals = made->resources_.front()->globals().size();
    made->expected_.resize(globals);
    made->found_.resize(globals);
    return made;
  }
  /// The same, and compiles. Null also when an engine refuses a task.
  static std::unique_ptr<Engines> load(const bytecode::VerifiedImage& image, std::string& problem,
                                       const runtime::ProgramOptions& options = {},
                                       std::vector<Engine> engines = all_engines()) {
    auto made = link(image, problem, options, std::move(engines));
    if (made == nullptr) return nullptr;
    problem = made->compile();
    return problem.empty() ? std::move(made) : nullptr;
  }
  /// The same of an image that may be wrong: null also when the verifier refuses it.
  static std::unique_ptr<Engines> load(const bytecode::Image& image, std::string& problem,
                                       const runtime::ProgramOptions& options = {},
                                       std::vector<Engine> engines = all_engines()) {
    core::Diagnostics diagnostics;
    const auto verified = bytecode::verify(bytecode::Image(image), diagnostics);
    if (!verified) {
      problem = diagnostics.all().empty() ? "refused" : diagnostics.all().front().message;
      return nullptr;
    }
    return load(*verified, problem, options, std::move(engines));
  }

  /// From the next scan on each engine runs what it makes of the tasks. Returns why one refuses, or nothing.
  std::string compile() {
    for (std::size_t i = 0; i < engines_.size(); ++i) {
      for (std::size_t task = 0; engines_[i].compile && task < tasks(); ++task) {
        auto compiled = engines_[i].compile(resources_[i]->program(task));
        if (!compiled) return engines_[i].name + ": " + compiled.error().message;
        resources_[i]->program(task).install(std::move(*compiled));
      }
    }
    return {};
  }

  [[nodiscard]] std::size_t tasks() const { return resources_.front()->task_count(); }
  /// How many engines, and the image as each of them runs it.
  [[nodiscard]] std::size_t size() const { return engines_.size(); }
  runtime::Resource& operator[](std::size_t engine) { return *resources_[engine]; }

  /// One scan of one task in all engines; date and time go with `now_ns` from 1970 on if nothing else is said. What
  /// differs then, or an empty text.
  std::string scan(std::size_t task, core::TimeNs now_ns, std::optional<core::TimeNs> utc_ns = std::nullopt) {
    runtime::Fault expected;
    for (std::size_t i = 0; i < engines_.size(); ++i) {
      resources_[i]->process_image().sync();
      const runtime::Fault fault = resources_[i]->program(task).execute({now_ns, 0, utc_ns.value_or(now_ns)});
      resources_[i]->process_image().sync();
      if (i == 0) expected = fault;
      if (std::tie(fault.kind, fault.pou, fault.word, fault.taskblock) !=
          std::tie(expected.kind, expected.pou, expected.word, expected.taskblock)) {
        return text(expected) + ", in " + engines_[i].name + " " + text(fault);
      }
    }
    fault_ = expected;
    if (std::string different = difference(task); !different.empty()) return different;
    return difference_of_globals();
  }
  /// One scan of every task.
  std::string scan(core::TimeNs now_ns) {
    for (std::size_t task = 0; task < tasks(); ++task) {
      if (std::string different = scan(task, now_ns); !different.empty()) return different;
    }
    return {};
  }
  /// How the last scan ended, in all engines.
  [[nodiscard]] const runtime::Fault& fault() const { return fault_; }

  /// What differs now: tables and events of all tasks, and the global table.
  std::string difference() {
    for (std::size_t task = 0; task < tasks(); ++task) {
      if (std::string different = difference(task); !different.empty()) return different;
    }
    return difference_of_globals();
  }

 private:
  static std::string text(const runtime::Fault& fault) {
    if (!fault) return "no fault";
    return std::string("fault ") + std::to_string(static_cast<int>(fault.kind)) + " at word " +
           std::to_string(fault.word) + " of POU " + std::to_string(fault.pou);
  }
  static std::string text(std::byte byte) { return std::to_string(static_cast<int>(byte)); }

  std::string difference(std::size_t task) {
    runtime::Program& expected = resources_.front()->program(task);
    for (std::size_t i = 1; i < engines_.size(); ++i) {
      runtime::Program& found = resources_[i]->program(task);
      const std::byte* const x = expected.table().data();
      const std::byte* const y = found.table().data();
      const std::size_t size = expected.table().layout().total;
      const auto [at, other] = std::mismatch(x, x + size, y);
      if (at != x + size) {
        return "byte " + std::to_string(at - x) + " of the table of task " + std::to_string(task) + " is " + text(*at) +
               ", in " + engines_[i].name + " " + text(*other);
      }
      if (expected.event_total() != found.event_total() || events(expected) != events(found)) {
        return "events of task " + std::to_string(task) + " differ in " + engines_[i].name;
      }
    }
    return {};
  }
  std::string difference_of_globals() {
    resources_.front()->globals().copy(expected_.data());
    for (std::size_t i = 1; i < engines_.size(); ++i) {
      resources_[i]->globals().copy(found_.data());
      const auto [at, other] = std::mismatch(expected_.begin(), expected_.end(), found_.begin());
      if (at != expected_.end()) {
        return "byte " + std::to_string(at - expected_.begin()) + " of the global table is " + text(*at) + ", in " +
               engines_[i].name + " " + text(*other);
      }
    }
    return {};
  }
  static std::vector<std::tuple<std::uint32_t, std::uint32_t, int, std::uint64_t>> events(
      const runtime::Program& program) {
    std::vector<std::tuple<std::uint32_t, std::uint32_t, int, std::uint64_t>> all;
    for (const runtime::EventCount& e : program.events()) {
      all.emplace_back(e.pou, e.word, static_cast<int>(e.last), e.count);
    }
    return all;  // those without a slot of their own: event_total()
  }

  std::vector<Engine> engines_;
  std::vector<std::unique_ptr<runtime::Resource>> resources_;
  std::vector<std::byte> expected_;  ///< copies of the global table
  std::vector<std::byte> found_;
  runtime::Fault fault_;
};

}  // namespace plc::test
