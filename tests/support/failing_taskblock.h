// A taskblock that fails when it is told to, beside those that come with PICARD: a scan may end inside of any block.
//
// Out: a registry, and taskblocks in images. Does not belong here: blocks that crash, allocate or take their time
// (tests/taskblocks).
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "taskblocks/registry.h"
#include "tests/support/image_builder.h"

namespace plc::test {

inline constexpr const char* kFailingTaskblock = "FAILING";

namespace failing_taskblock {

/// BAD: fire() fails; else COUNT is one more.
struct Object {
  const std::uint8_t* bad;
  std::int32_t* count;
};
inline void* create(void* const* ports, const picard_context*, picard_failure*) {
  return new Object{static_cast<const std::uint8_t*>(ports[0]), static_cast<std::int32_t*>(ports[1])};
}
inline int ready(void*, picard_failure*) { return 1; }
inline int fire(void* object, picard_failure* failure) {
  const Object& o = *static_cast<const Object*>(object);
  if (*o.bad != 0) {
    std::strcpy(failure->text, "told to");
    return 0;
  }
  *o.count = *o.count >= 1000 ? 0 : *o.count + 1;
  return 1;
}
inline void destroy(void* object) { delete static_cast<Object*>(object); }

}  // namespace failing_taskblock

/// The set that comes with PICARD, and the one that fails.
inline const taskblocks::Registry& registry_with_failures() {
  static const taskblocks::Registry kRegistry = [] {
    static const picard_type kBool{PICARD_ELEMENTARY, "BOOL", 0, 1, 1, nullptr, nullptr, 0, 0, nullptr};
    static const picard_type kDint{PICARD_ELEMENTARY, "DINT", 0, 4, 4, nullptr, nullptr, 0, 0, nullptr};
    constexpr double kNoLimit = std::numeric_limits<double>::infinity();
    static const picard_port kPorts[] = {{"BAD", &kBool, PICARD_INPUT, "fails", "", "", -kNoLimit, kNoLimit},
                                         {"COUNT", &kDint, PICARD_OUTPUT, "executions", "", "", -kNoLimit, kNoLimit}};
    static const picard_block kBlock{kFailingTaskblock,
                                     "Tests",
                                     "Fails while BAD is TRUE.",
                                     "",
                                     kPorts,
                                     2,
                                     0,
                                     failing_taskblock::create,
                                     failing_taskblock::ready,
                                     failing_taskblock::fire,
                                     failing_taskblock::destroy};
    static const picard_library kLibrary{PICARD_ABI_VERSION,
                                         sizeof(picard_block),
                                         sizeof(picard_port),
                                         sizeof(picard_type),
                                         "tests",
                                         "1.0.0",
                                         nullptr,
                                         &kBlock,
                                         1};
    taskblocks::Registry registry = taskblocks::Registry::built_in();
    // Refused, it is missed where images name it.
    static_cast<void>(registry.add(&kLibrary));
    return registry;
  }();
  return kRegistry;
}

/// Declares a taskblock of scalars, laid out as the compiler does. Its index in Image::blocks; nothing where the
/// registry has none of the name, or one with other ports.
inline std::optional<std::uint32_t> add_taskblock(ImageBuilder& b, const taskblocks::Registry& registry,
                                                  const char* name) {
  const taskblocks::Registry::Entry* const entry = registry.find(name);
  if (entry == nullptr) return {};
  GrowingStruct ports;
  ports.add(b.image, bytecode::kObjectField, b.type(TypeId::kUdint), FieldRole::kHidden, {});
  for (std::uint32_t i = 0; i < entry->block->port_count; ++i) {
    const picard_port& port = entry->block->ports[i];
    if (port.type == nullptr || port.type->kind != PICARD_ELEMENTARY) return {};
    const FieldRole role = port.direction == PICARD_OUTPUT ? FieldRole::kOutput : FieldRole::kInput;
    ports.add(b.image, port.name, b.type(*core::type_named(port.type->name)), role, {});
  }
  ports.close();
  ports.type.name = entry->block->name;
  const std::uint32_t index = b.add_type(ports.type);
  b.image.blocks.push_back({entry->block->name, taskblocks::layout_hash(*entry->block), index});
  return static_cast<std::uint32_t>(b.image.blocks.size() - 1);
}

}  // namespace plc::test
