#include <fstream>
#include <iostream>

#include "bench/side.h"
#include "native/compile.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

class PlcSide final : public Side {
 public:
  explicit PlcSide(std::unique_ptr<runtime::Resource> resource) : resource_(std::move(resource)) {}

  bool find(const Source& source) {
    const runtime::Access access(*resource_);
    for (const Variable& variable : source.variables) {
      const auto place = access.find_leaf(variable.path);
      if (!place || place->task == runtime::Place::kGlobal) {
        std::cerr << variable.path << ": "
                  << (place ? "is global, where the benchmark cannot set it" : place.error().message) << '\n';
        return false;
      }
      std::byte* const table = resource_->program(place->task).table().data();
      variables_.push_back(reinterpret_cast<unsigned char*>(table + place->offset));
    }
    return true;
  }
  bool scan(core::TimeNs now_ns) override { return !resource_->program(0).execute({now_ns}); }

 private:
  std::unique_ptr<runtime::Resource> resource_;
};

}  // namespace

std::unique_ptr<Side> make_plc_side(const bytecode::VerifiedImage& image, const Source& source, Engine engine) {
  runtime::ProgramOptions options;
  options.loop_budget = 10'000'000;  // the worst case of bubble sort: a thousand passes over a thousand elements
  auto loaded = runtime::Resource::load(image, options);
  if (!loaded) {
    std::cerr << loaded.error().message << '\n';
    return nullptr;
  }
  if (engine == Engine::kNative) {
    auto code = native::compile((*loaded)->program(0));
    if (!code) {
      std::cerr << code.error().message << '\n';
      return nullptr;
    }
    (*loaded)->program(0).install(std::move(*code));
  }
  auto side = std::make_unique<PlcSide>(std::move(*loaded));
  return side->find(source) ? std::move(side) : nullptr;
}

std::optional<bytecode::VerifiedImage> compile_project(const Source& source, const Scratch& scratch) {
  const std::string path = scratch.file("project.xml");
  std::ofstream(path, std::ios::binary) << source.xml;
  tools::Compilation compilation;
  tools::compile({path, {}, tools::Goal::kRun}, compilation);
  if (compilation.ok()) return std::move(compilation.image);
  compilation.diagnostics.render(std::cerr);
  return std::nullopt;
}

}  // namespace plc::bench
