#include "runtime/taskblocks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/text.h"
#include "runtime/interpreter/operations.h"
#include "runtime/link/link.h"
#include "runtime/program.h"
#include "runtime/record/recorder.h"
#include "runtime/record/replay.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::ImageBlock;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

/// Whether values of an image's type look in memory as the component sees them.
bool same_shape(const Image& image, const ImageType& type, const picard_type& port) {
  if (type.size != port.size) return false;
  switch (port.kind) {
    case PICARD_ELEMENTARY:
      return type.kind == TypeKind::kScalar && core::name_of(type.elementary) == port.name;
    case PICARD_STRING:
      return type.kind == TypeKind::kString && core::name_of(type.elementary) == port.name &&
             type.capacity == port.capacity;
    case PICARD_ARRAY:
      return type.kind == TypeKind::kArray && type.count == port.capacity && type.lower == 0 &&
             same_shape(image, image.types[type.element], *port.element);
    case PICARD_STRUCT_TYPE:
      if (type.kind != TypeKind::kStruct || type.fields.size() != port.field_count) return false;
      for (std::uint32_t i = 0; i < port.field_count; ++i) {
        const ImageField& field = type.fields[i];
        if (field.offset != port.fields[i].offset || !core::iequals(field.name, port.fields[i].name) ||
            !same_shape(image, image.types[field.type], *port.fields[i].type)) {
          return false;
        }
      }
      return true;
    case PICARD_ENUM_TYPE:
      if (type.kind != TypeKind::kScalar || core::name_of(type.elementary) != port.element->name ||
          type.members.size() != port.enumerator_count) {
        return false;
      }
      for (std::uint32_t i = 0; i < port.enumerator_count; ++i) {
        const picard_enumerator& one = port.enumerators[i];
        if (!core::iequals(type.members[i], one.name) || type.member_values[i] != one.value) return false;
      }
      return true;
    default:
      return false;
  }
}

bool is_queue(const picard_port& port) {
  return port.direction == PICARD_QUEUE_READER || port.direction == PICARD_QUEUE_WRITER;
}

/// Calls visit(block, ports, path) for each instance of a taskblock in a value of `type` at `at`; stops at a problem.
template <class Visit>
std::optional<core::Problem> for_each_instance(const Image& image, std::uint32_t type, std::byte* at,
                                               const std::string& path, const Visit& visit) {
  const ImageType& t = image.types[type];
  for (const ImageBlock& block : image.blocks) {
    if (block.type == type && stdlib::block_named(block.name) == nullptr) return visit(block, at, path);
  }
  if (t.kind == TypeKind::kArray && image.types[t.element].kind >= TypeKind::kArray) {
    for (std::uint32_t i = 0; i < t.count; ++i) {
      const std::string element = path + "[" + std::to_string(t.lower + i) + "]";
      if (auto problem =
              for_each_instance(image, t.element, at + std::size_t{i} * image.types[t.element].size, element, visit))
        return problem;
    }
  }
  if (t.kind != TypeKind::kStruct) return {};
  for (const ImageField& field : t.fields) {
    const TypeKind kind = image.types[field.type].kind;
    if (kind != TypeKind::kStruct && kind != TypeKind::kArray) continue;
    const std::string inner = path.empty() ? field.name : path + "." + field.name;
    if (auto problem = for_each_instance(image, field.type, at + field.offset, inner, visit)) return problem;
  }
  return {};
}

template <class T>
bool limit(std::byte* at, double lowest, double highest) noexcept {
  const T value = load<T>(at);
  const auto number = static_cast<double>(value);
  if (number >= lowest && number <= highest) return true;
  // Not a number counts as too small: no limit is nearer.
  store(at, static_cast<T>(number > highest ? highest : lowest));
  return false;
}

bool limit(core::TypeId type, std::byte* at, double lowest, double highest) noexcept {
  switch (core::rep_of(type)) {
    case core::Rep::kI8:
      return limit<std::int8_t>(at, lowest, highest);
    case core::Rep::kU8:
      return limit<std::uint8_t>(at, lowest, highest);
    case core::Rep::kI16:
      return limit<std::int16_t>(at, lowest, highest);
    case core::Rep::kU16:
      return limit<std::uint16_t>(at, lowest, highest);
    case core::Rep::kI32:
      return limit<std::int32_t>(at, lowest, highest);
    case core::Rep::kU32:
      return limit<std::uint32_t>(at, lowest, highest);
    case core::Rep::kI64:
      return limit<std::int64_t>(at, lowest, highest);
    case core::Rep::kU64:
      return limit<std::uint64_t>(at, lowest, highest);
    case core::Rep::kF32:
      return limit<float>(at, lowest, highest);
    case core::Rep::kF64:
      return limit<double>(at, lowest, highest);
    default:
      return true;
  }
}

}  // namespace

namespace {

bool has_taskblocks(const Image& image) {
  return std::any_of(image.blocks.begin(), image.blocks.end(),
                     [](const ImageBlock& block) { return stdlib::block_named(block.name) == nullptr; });
}

/// Blocks of the set that only tell something, and have all their state in their ports: a replica executes them, and
/// tells the same.
bool tells_again(const ImageBlock& block) {
  if (block.name != "LOG_MSG") return false;
  const taskblocks::Registry::Entry* const entry = taskblocks::Registry::built_in().find(block.name);
  return entry != nullptr && taskblocks::layout_hash(*entry->block) == block.layout_hash;
}

/// Calls visit(block, ports, path) for each instance that a task runs, in the order of their numbers; stops at a
/// problem.
template <class Visit>
std::optional<core::Problem> for_each_of_task(const Image& image, std::uint32_t task, TaskTable& table,
                                              const ProgramOptions& options, const Visit& visit) {
  const std::uint32_t body = image.tasks[task].body;
  const ImageType& globals = image.types[image.global_type];
  for (const FieldRange& range : exchanged_ranges(image, body)) {
    if (!range.exported || !options.global_taskblocks) continue;
    for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
      const ImageField& field = globals.fields[f];
      if (auto problem = for_each_instance(image, field.type, table.data() + field.offset, field.name, visit))
        return problem;
    }
  }
  return for_each_instance(image, image.pous[body].instance_type, table.data() + table.layout().instance, {}, visit);
}

}  // namespace

core::Result<std::unique_ptr<Taskblocks>> Taskblocks::make(const Image& image, std::uint32_t task,
                                                           const taskblocks::Registry& registry, TaskTable& table,
                                                           std::span<QueueEnd> queues, const ProgramOptions& options) {
  if (!has_taskblocks(image)) return std::unique_ptr<Taskblocks>();
  std::unique_ptr<Taskblocks> made(new Taskblocks());
  made->clock_ = options.budget_clock;
  made->context_.owner = made.get();
  made->context_.tell = tell;
  made->context_.period_ns = image.tasks[task].single.empty() ? image.tasks[task].period_ns : 0;
  const auto add = [&](const ImageBlock& block, std::byte* ports, const std::string& path) {
    return made->add(image, block, ports, path, registry);
  };
  if (auto problem = for_each_of_task(image, task, table, options, add)) return *problem;
  const std::uint32_t body = image.tasks[task].body;
  const ImageType& globals = image.types[image.global_type];
  made->connect(image, image.pous[body].instance_type, table.data() + table.layout().instance, queues);
  // A program that is called by name is a global.
  for (const FieldRange& range : exchanged_ranges(image, body)) {
    if (!range.exported) continue;
    for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
      const ImageField& field = globals.fields[f];
      if (image.types[field.type].kind >= TypeKind::kArray)
        made->connect(image, field.type, table.data() + field.offset, queues);
    }
  }
  if (auto problem = made->check_queues()) return *problem;
  return made;
}

std::unique_ptr<Taskblocks> Taskblocks::make_replica(const Image& image, std::uint32_t task, TaskTable& table,
                                                     const ProgramOptions& options, Replay& replay) {
  if (!has_taskblocks(image)) return nullptr;
  std::unique_ptr<Taskblocks> made(new Taskblocks());
  made->replay_ = &replay;
  made->context_.owner = made.get();
  made->context_.tell = tell;
  static_cast<void>(for_each_of_task(
      image, task, table, options, [&](const ImageBlock& block, std::byte* ports, const std::string& path) {
        if (tells_again(block)) {
          auto problem = made->add(image, block, ports, path, taskblocks::Registry::built_in());
          if (problem) return problem;
        } else {
          made->add_instance(image, block, ports, path);
        }
        const auto number = static_cast<std::uint32_t>(made->calls_.size() - 1);
        std::memcpy(ports, &number, sizeof number);
        made->calls_.back().ports = ports;
        return std::optional<core::Problem>();
      }));
  const auto has_object = [](const Object* object) { return object->block != nullptr; };
  if (std::none_of(made->by_number_.begin(), made->by_number_.end(), has_object)) return made;
  made->connect(image, image.pous[image.tasks[task].body].instance_type, table.data() + table.layout().instance, {});
  for (std::uint32_t number = 0; number < made->by_number_.size(); ++number) {
    if (has_object(made->by_number_[number])) static_cast<void>(made->start(number));
  }
  return made;
}

Taskblocks::~Taskblocks() {
  for (Object& object : objects_) {
    if (object.object != nullptr) object.block->destroy(object.object);
  }
}

Taskblocks::Object& Taskblocks::add_instance(const Image& image, const ImageBlock& block, std::byte* ports,
                                             std::string path) {
  Object& object = objects_.emplace_back();
  object.ports = ports;
  object.path = std::move(path);
  object.name = block.name + " " + object.path;
  for (const ImageField& field : image.types[block.type].fields) {
    if (field.role == bytecode::FieldRole::kOutput)
      object.outputs.push_back({ports + field.offset, image.types[field.type].size});
  }
  by_number_.push_back(&object);
  calls_.emplace_back();
  return object;
}

std::optional<core::Problem> Taskblocks::add(const Image& image, const ImageBlock& block, std::byte* ports,
                                             std::string path, const taskblocks::Registry& registry) {
  const taskblocks::Registry::Entry* const entry = registry.find(block.name);
  if (entry == nullptr) {
    return core::Problem{core::Code::P7802, "taskblock " + block.name + " of " + path + " is not on this machine",
                         "name its library in plc.toml: [taskblocks] libraries"};
  }
  const auto differs = [&] {
    return core::Problem{core::Code::P7802,
                         "taskblock " + block.name + " of " + path + " has other ports here than in the image",
                         "compile the project again"};
  };
  if (taskblocks::layout_hash(*entry->block) != block.layout_hash) return differs();
  Object& object = add_instance(image, block, ports, std::move(path));
  object.block = entry->block;
  object.name = std::string(object.block->name) + " " + object.path;
  object.budget_ns = entry->block->budget_ns;
  const std::vector<ImageField>& fields = image.types[block.type].fields;
  for (std::uint32_t i = 0; i < object.block->port_count; ++i) {
    const picard_port& port = object.block->ports[i];
    if (is_queue(port)) {
      object.places.push_back(nullptr);  // connect() gives it its queue
      continue;
    }
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [&port](const ImageField& f) { return core::iequals(f.name, port.name); });
    if (field == fields.end() || !same_shape(image, image.types[field->type], *port.type)) return differs();
    object.places.push_back(ports + field->offset);
    object.port_of_field.resize(fields.size());
    object.port_of_field[static_cast<std::size_t>(field - fields.begin())] = i;
    const bool limited = std::isfinite(port.lowest) || std::isfinite(port.highest);
    if (port.direction == PICARD_OUTPUT && limited && port.type->kind == PICARD_ELEMENTARY) {
      object.ranges.push_back({ports + field->offset, *core::type_named(port.type->name), port.lowest, port.highest});
    }
  }
  return {};
}

// Wires lead from variable to variable of one instance.
void Taskblocks::connect(const Image& image, std::uint32_t type, std::byte* at, std::span<QueueEnd> queues) {
  const ImageType& t = image.types[type];
  for (const bytecode::ImagePou& pou : image.pous) {
    if (pou.instance_type != type) continue;
    for (const bytecode::ImageWire& w : pou.wires) {
      Object* const object = object_at(at + w.block);
      if (object != nullptr && object->block != nullptr) object->places[object->port_of_field[w.input]] = at + w.source;
    }
    for (const bytecode::ImageQueuePort& p : pou.queue_ports) {
      Object* const object = object_at(at + p.block);
      if (object == nullptr || object->block == nullptr) continue;
      for (std::uint32_t i = 0; i < object->block->port_count; ++i) {
        const picard_port& port = object->block->ports[i];
        const bool same = core::iequals(port.name, p.port) && is_queue(port) &&
                          (port.direction == PICARD_QUEUE_READER) == p.takes &&
                          same_shape(image, image.types[image.queues[p.queue].type], *port.type);
        if (same) object->places[i] = static_cast<picard_queue*>(&queues[p.queue]);
      }
    }
  }
  if (t.kind == TypeKind::kArray && image.types[t.element].kind >= TypeKind::kArray) {
    for (std::uint32_t i = 0; i < t.count; ++i)
      connect(image, t.element, at + std::size_t{i} * image.types[t.element].size, queues);
  }
  for (const ImageField& field : t.fields) {
    const TypeKind kind = image.types[field.type].kind;
    if (kind == TypeKind::kStruct || kind == TypeKind::kArray) connect(image, field.type, at + field.offset, queues);
  }
}

Taskblocks::Object* Taskblocks::object_at(const std::byte* ports) {
  const auto found =
      std::find_if(objects_.begin(), objects_.end(), [ports](const Object& o) { return o.ports == ports; });
  return found == objects_.end() ? nullptr : &*found;
}

std::optional<core::Problem> Taskblocks::check_queues() const {
  for (const Object* object : by_number_) {
    for (std::size_t i = 0; i < object->places.size(); ++i) {
      if (object->places[i] != nullptr) continue;
      return core::Problem{
          core::Code::P7802,
          "taskblock " + object->name + " has no queue of its elements at " + object->block->ports[i].name,
          "name a queue at this port where the block is called, and compile the project again"};
    }
  }
  return {};
}

std::optional<core::Problem> Taskblocks::restart() {
  for (std::uint32_t number = 0; number < by_number_.size(); ++number) {
    if (auto problem = start(number)) return problem;
  }
  return {};
}

namespace {
thread_local const char* being_made = nullptr;
}

const char* Taskblocks::making() noexcept { return being_made; }

std::optional<core::Problem> Taskblocks::start(std::uint32_t number) {
  Object& object = *by_number_[number];
  being_made = object.name.c_str();
  auto problem = make_object(object, number);
  being_made = nullptr;
  return problem;
}

std::optional<core::Problem> Taskblocks::make_object(Object& object, std::uint32_t number) {
  if (object.object != nullptr) object.block->destroy(object.object);
  object.object = nullptr;
  calls_[number] = {};
  std::memcpy(const_cast<std::byte*>(object.ports), &number, sizeof number);
  picard_failure failure{};
  context_.object = number;
  void* const made = object.block->create(object.places.data(), &context_, &failure);
  if (made != nullptr && object.block->ready(made, &failure) != 0) {
    object.object = made;
    set_call(number);
    return {};
  }
  if (made != nullptr) object.block->destroy(made);
  failure.text[PICARD_TEXT_BYTES - 1] = '\0';
  return core::Problem{core::Code::P7803,
                       std::string("taskblock ") + object.block->name + " of " + object.path + ": " + failure.text,
                       {},
                       object.path};
}

void Taskblocks::set_call(std::uint32_t number) noexcept {
  const Object& object = *by_number_[number];
  const bool plain = recorder_ == nullptr && replay_ == nullptr && object.ranges.empty() &&
                     (object.budget_ns == 0 || clock_ == nullptr);
  calls_[number] = {object.ports, plain ? object.block->fire : nullptr, object.object};
}

void Taskblocks::set_recorder(Recorder* recorder) noexcept {
  recorder_ = recorder;
  for (std::uint32_t number = 0; number < by_number_.size(); ++number) {
    if (by_number_[number]->object != nullptr) set_call(number);
  }
}

// RT:
void Taskblocks::step(void* ports, const stdlib::StepContext& context) noexcept {
  auto& self = *static_cast<Taskblocks*>(context.host);
  self.status_ = self.run(ports);
}

// RT:
Taskblocks::Status Taskblocks::fire_checked(std::uint32_t number) noexcept {
  const Object& object = *by_number_[number];
  if (replay_ != nullptr) {
    // Before its outputs are what was recorded: they are what it gives.
    if (object.object != nullptr) static_cast<void>(object.block->fire(object.object, &failure_));
    const auto status = static_cast<Status>(replay_->taskblock(number, object.outputs));
    return status == Status::kFailed || status == Status::kLate ? fail(number, status, {}) : status;
  }
  const Status status = fire(number);
  if (recorder_ != nullptr) recorder_->taskblock(number, static_cast<std::uint32_t>(status), object.outputs);
  return status;
}

// RT:
Taskblocks::Status Taskblocks::fire(std::uint32_t number) noexcept {
  const Object& object = *by_number_[number];
  const bool measured = object.budget_ns != 0 && clock_ != nullptr;
  const core::TimeNs begin = measured ? clock_->now_ns() : 0;
  if (object.block->fire(object.object, &failure_) == 0) return fail(number, Status::kFailed, failure_);
  if (measured && clock_->now_ns() - begin > object.budget_ns) return fail(number, Status::kLate, {});
  Status status = Status::kFine;
  for (const Range& range : object.ranges) {
    if (!limit(range.type, range.at, range.lowest, range.highest)) status = Status::kOutOfRange;
  }
  return status;
}

// RT:
Taskblocks::Status Taskblocks::fail(std::uint32_t number, Status status, const picard_failure& why) noexcept {
  failed_ = number;
  if (number == kNone) return status;
  Object& object = *by_number_[number];
  if (object.has_failed.load(std::memory_order_relaxed)) return status;
  object.failure = why;
  object.failure.text[PICARD_TEXT_BYTES - 1] = '\0';
  object.has_failed.store(true, std::memory_order_release);
  return status;
}

// RT: any thread.
void Taskblocks::tell(const picard_context* context, std::uint32_t object, std::uint32_t severity, const char* text) {
  Taskblocks& self = *static_cast<const Context*>(context)->owner;
  if (object >= self.by_number_.size() || text == nullptr) return;
  MessageRing::Message message;
  message.utc_ns = self.utc_ns_.load(std::memory_order_relaxed);
  const std::uint64_t begun = self.scans_.load(std::memory_order_relaxed);
  message.scan = begun == 0 ? 0 : begun - 1;
  message.object = object;
  message.severity = severity == PICARD_NOTE      ? core::Severity::kNote
                     : severity == PICARD_WARNING ? core::Severity::kWarning
                                                  : core::Severity::kError;
  self.messages_.push(message, text);
}

std::vector<TaskblockMessage> Taskblocks::messages() {
  std::vector<TaskblockMessage> all;
  messages_.drain([&](const MessageRing::Message& one) {
    all.push_back({one.severity, by_number_[one.object]->name, one.scan, one.utc_ns, one.text});
  });
  return all;
}

std::uint64_t Taskblocks::allocations(std::uint32_t object) const noexcept {
  const Object& o = *by_number_[object];
  return o.has_failed.load(std::memory_order_acquire) ? 0 : o.allocations.load(std::memory_order_relaxed);
}

std::string Taskblocks::text(std::uint32_t object) const {
  if (object >= by_number_.size()) return "a taskblock that this task has not";
  const Object& o = *by_number_[object];
  std::string text = o.name;
  if (o.has_failed.load(std::memory_order_acquire) && o.failure.text[0] != '\0')
    text += std::string(": ") + o.failure.text;
  return text;
}

}  // namespace plc::runtime
