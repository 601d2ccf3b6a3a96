#include <fstream>
#include <iostream>
#include <string>

#include "bench/scratch.h"
#include "bench/side.h"
#include "bench/taskblock_types.h"
#include "compiler/compile.h"
#include "native/compile.h"
#include "runtime/access.h"
#include "runtime/resource.h"

namespace plc::bench {
namespace {

class PlcSide final : public Side {
 public:
  PlcSide(std::unique_ptr<runtime::Resource> resource, Engine engine) : resource_(std::move(resource)) {
    for (std::size_t task = 0; task < resource_->task_count(); ++task) {
      runtime::Program& program = resource_->program(task);
      programs_.push_back(&program);
      footprint_.data += program.table().layout().total;
      if (engine == Engine::kInterpreter) footprint_.data += program.link_report().code_bytes;
    }
  }

  /// Lets every task run as machine code from now on.
  bool compile(const native::CompileOptions& options) {
    for (std::size_t task = 0; task < resource_->task_count(); ++task) {
      auto code = native::compile(resource_->program(task), options);
      if (!code) {
        std::cerr << code.error().message << '\n';
        return false;
      }
      footprint_.code += (*code)->report().code_bytes;
      resource_->program(task).install(std::move(*code));
    }
    return true;
  }
  /// Looks up all variables.
  bool find(const Source& source) {
    const runtime::Access access(*resource_);
    for (const Variable& variable : source.variables) {
      const auto place = access.find_leaf(variable.path);
      if (!place) {
        std::cerr << variable.path << ": " << place.error().message << '\n';
        return false;
      }
      // Of a global, the copy that the first task has at the start of its table.
      const std::uint32_t task = place->task == runtime::Place::kGlobal ? 0 : place->task;
      std::byte* const table = resource_->program(task).table().data();
      variables_.push_back(reinterpret_cast<unsigned char*>(table + place->offset));
    }
    return true;
  }
  bool scan(core::TimeNs now_ns) override {
    bool good = true;
    for (runtime::Program* const program : programs_) good = !program->execute({now_ns}) && good;
    return good;
  }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<runtime::Program*> programs_;  ///< of its tasks: as a scheduler has them, each at hand
};

}  // namespace

std::unique_ptr<Side> make_plc_side(const bytecode::VerifiedImage& image, const Source& source, Engine engine) {
  runtime::ProgramOptions options;
  options.loop_budget = 2'000'000'000;  // all end by themselves; far more than any workload of a million takes
  options.taskblocks = &bench_taskblocks();
  auto loaded = runtime::Resource::load(image, options);
  if (!loaded) {
    std::cerr << loaded.error().message << '\n';
    return nullptr;
  }
  auto side = std::make_unique<PlcSide>(std::move(*loaded), engine);
  if (engine != Engine::kInterpreter && !side->compile({})) return nullptr;
  return side->find(source) ? std::move(side) : nullptr;
}

std::optional<bytecode::VerifiedImage> compile_project(const Source& source) {
  const Scratch scratch;
  const std::string path = scratch.file(std::string("project.") + source.extension);
  std::ofstream(path, std::ios::binary) << source.project;
  compiler::Compilation compilation;
  compiler::Request request{path, {}, compiler::Goal::kRun};
  request.taskblocks = &bench_taskblocks();
  compiler::compile(request, compilation);
  if (compilation.ok()) return std::move(compilation.image);
  compilation.diagnostics.render(std::cerr);
  return std::nullopt;
}

}  // namespace plc::bench
