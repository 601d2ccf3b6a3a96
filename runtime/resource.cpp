#include "runtime/resource.h"

#include "runtime/record/replay.h"

namespace plc::runtime {

core::Result<std::unique_ptr<Resource>> Resource::load(bytecode::VerifiedImage image, const ProgramOptions& options) {
  std::unique_ptr<Resource> resource(new Resource(std::move(image), options.priorities));
  for (std::uint32_t task = 0; task < resource->image().tasks.size(); ++task) {
    auto program = Program::link(resource->image_, task, resource->globals_, options);
    if (!program) return program.error();
    resource->programs_.push_back(std::move(*program));
  }
  return resource;
}

core::Result<std::unique_ptr<Resource>> Resource::load_replicas(bytecode::VerifiedImage image,
                                                                std::span<Replay> replays,
                                                                const ProgramOptions& options) {
  std::unique_ptr<Resource> resource(new Resource(std::move(image), options.priorities));
  for (std::uint32_t task = 0; task < resource->image().tasks.size(); ++task) {
    auto program = Program::link_replica(resource->image_, task, replays[task], options);
    if (!program) return program.error();
    resource->programs_.push_back(std::move(*program));
  }
  return resource;
}

std::optional<core::Problem> Resource::start_taskblocks() {
  for (const auto& program : programs_) {
    if (auto problem = program->start_taskblocks()) return problem;
  }
  return std::nullopt;
}

void Resource::restore(std::span<const std::byte> globals, std::span<const std::vector<std::byte>> instances) {
  globals_.reset(globals);
  for (std::size_t task = 0; task < programs_.size(); ++task) programs_[task]->restore(globals, instances[task]);
}

}  // namespace plc::runtime
