#include "runtime/resource.h"

#include "core/text.h"
#include "runtime/sched/task.h"

namespace plc::runtime {

core::Result<std::unique_ptr<Resource>> Resource::load(bytecode::VerifiedImage image, const ProgramOptions& options) {
  std::unique_ptr<Resource> resource(new Resource(std::move(image)));
  const bytecode::Image& i = resource->image();
  for (std::uint32_t task = 0; task < i.tasks.size(); ++task) {
    const bytecode::ImageTask& entry = i.tasks[task];
    if (!entry.single.empty() && !find_trigger(i, entry.single)) {
      return core::Problem{
          core::Code::P7112,
          "task \"" + entry.name + "\" is released by \"" + entry.single + "\", which is no global BOOL",
          "declare a global variable of type BOOL with this name, or give the task a period"};
    }
    auto program = Program::link(resource->image_, task, resource->globals_, options);
    if (!program) return program.error();
    resource->programs_.push_back(std::move(*program));
  }
  return resource;
}

}  // namespace plc::runtime
