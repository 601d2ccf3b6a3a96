// Configurations, resources, tasks and instances of TC6 files.
#include "plcopen/reader_configuration.h"

#include <unordered_map>

#include "core/text.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

void start_access(Reader& r, const Tag& tag) {
  push_var_list(r, tag, r.configurations.back()->access, Section::kAccess);
}
void start_configs(Reader& r, const Tag& tag) {
  push_var_list(r, tag, r.configurations.back()->configs, Section::kConfig);
}

/// TC6 1.01 writes the type as `type`.
void instance(Reader& r, const Tag& tag) {
  add_instance(r, tag, tag.attributes.has(Attr::kTypeName) ? Attr::kTypeName : Attr::kType);
}

constexpr Rule kRules[] = {
    used(State::kInstances, "configurations", State::kConfigurations),
    used(State::kInstances, "addData", State::kAddData),
    anchored(State::kConfigurations, "configuration", State::kConfiguration, start_configuration, end_configuration),

    anchored(State::kConfiguration, "resource", State::kResource, start_resource, end_resource),
    used(State::kConfiguration, "globalVars", State::kVarList, start_globals, end_var_list),
    used(State::kConfiguration, "accessVars", State::kAccessVars, start_access, end_var_list),
    used(State::kConfiguration, "configVars", State::kConfigVars, start_configs, end_var_list),
    used(State::kConfiguration, "addData", State::kAddData),
    ignored(State::kConfiguration, "documentation", kReasonNote),

    used(State::kResource, "task", State::kTask, start_task, end_task),
    used(State::kResource, "globalVars", State::kVarList, start_globals, end_var_list),
    used(State::kResource, "pouInstance", State::kPouInstance, instance),
    used(State::kResource, "addData", State::kAddData),
    ignored(State::kResource, "documentation", kReasonNote),

    used(State::kTask, "pouInstance", State::kPouInstance, instance),
    used(State::kTask, "addData", State::kAddData),
    ignored(State::kTask, "documentation", kReasonNote),
    used(State::kPouInstance, "addData", State::kAddData),
    ignored(State::kPouInstance, "documentation", kReasonNote),
};

}  // namespace

void start_configuration(Reader& r, const Tag& tag) {
  auto configuration = std::make_unique<Configuration>();
  configuration->name = r.required_name(tag, Attr::kName);
  configuration->at = tag.at;
  r.configurations.push_back(std::move(configuration));
}

void end_configuration(Reader& r) {
  r.project.configurations.push_back(std::move(*r.configurations.back()));
  r.configurations.pop_back();
}

void start_resource(Reader& r, const Tag& tag) {
  auto frame = std::make_unique<ResourceFrame>();
  frame->resource.name = r.required_name(tag, Attr::kName);
  frame->resource.at = tag.at;
  r.resources.push_back(std::move(frame));
}

void end_resource(Reader& r) {
  ResourceFrame& frame = *r.resources.back();
  // IEC 61131-10 names the task at the instance, which may come before the task.
  std::unordered_map<std::string_view, Task*, core::NameHash, core::NameEqual> tasks;
  for (Task& task : frame.resource.tasks) tasks.try_emplace(task.name, &task);
  std::vector<PouInstance> beside;
  for (std::size_t i = 0; i < frame.resource.instances.size(); ++i) {
    const std::string& name = frame.instance_tasks[i];
    const auto task = name.empty() ? tasks.end() : tasks.find(name);
    (task == tasks.end() ? beside : task->second->instances).push_back(std::move(frame.resource.instances[i]));
  }
  frame.resource.instances = std::move(beside);
  Configuration& owner = r.configurations.empty() ? r.outside() : *r.configurations.back();
  owner.resources.push_back(std::move(frame.resource));
  r.resources.pop_back();
}

void start_task(Reader& r, const Tag& tag) {
  auto task = std::make_unique<Task>();
  task->name = r.required_name(tag, Attr::kName);
  task->interval = core::trimmed(tag.attributes.get(Attr::kInterval));
  task->single = core::trimmed(tag.attributes.get(Attr::kSingle));
  task->priority = core::trimmed(tag.attributes.get(Attr::kPriority));
  task->at = tag.at;
  task->at.kind = ElementKind::kTask;
  r.tasks.push_back(std::move(task));
}

void end_task(Reader& r) {
  if (!r.resources.empty()) {
    r.resources.back()->resource.tasks.push_back(std::move(*r.tasks.back()));
  } else {
    Configuration& owner = r.configurations.empty() ? r.outside() : *r.configurations.back();
    if (owner.resources.empty()) owner.resources.emplace_back().at = r.tasks.back()->at;
    owner.resources.back().tasks.push_back(std::move(*r.tasks.back()));
  }
  r.tasks.pop_back();
}

void add_instance(Reader& r, const Tag& tag, Attr type) {
  PouInstance instance;
  instance.name = r.required_name(tag, Attr::kName);
  instance.type_name = r.optional_name(tag, type);
  instance.at = tag.at;
  instance.at.kind = ElementKind::kInstance;
  if (!r.tasks.empty()) {
    r.tasks.back()->instances.push_back(std::move(instance));
  } else if (!r.resources.empty()) {
    r.resources.back()->resource.instances.push_back(std::move(instance));
    r.resources.back()->instance_tasks.emplace_back(core::trimmed(tag.attributes.get(Attr::kAssociatedTaskName)));
  }
}

std::span<const Rule> configuration_rules() { return kRules; }

}  // namespace plc::plcopen
