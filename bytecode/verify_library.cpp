#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

/// Characters that the string port at `field` of a fresh instance holds.
std::uint16_t capacity_of(const stdlib::BlockSpec& spec, const stdlib::Field& field) {
  core::StringHeader header;
  if (spec.initial == nullptr || field.offset + sizeof header > spec.size) return 0;
  std::memcpy(&header, static_cast<const std::byte*>(spec.initial) + field.offset, sizeof header);
  return header.capacity;
}

bool same_port(const Image& image, const ImageField& field, const stdlib::BlockSpec& spec, const stdlib::Field& port) {
  const ImageType& type = image.types[field.type];
  if (field.offset != port.offset || field.name != port.name || type.elementary != port.type || type.limited)
    return false;
  const core::Rep rep = core::rep_of(port.type);
  if (rep == core::Rep::kStr || rep == core::Rep::kWstr) {
    return type.kind == TypeKind::kString && type.capacity == capacity_of(spec, port);
  }
  return type.kind == TypeKind::kScalar;
}

bool same_ports(const Image& image, const ImageType& type, const stdlib::BlockSpec& spec) {
  if (type.kind != TypeKind::kStruct || type.size != spec.size || type.align != spec.align ||
      type.fields.size() != spec.fields.size()) {
    return false;
  }
  std::vector<const stdlib::Field*> ports;
  for (const stdlib::Field& port : spec.fields) ports.push_back(&port);
  std::sort(ports.begin(), ports.end(), [](auto a, auto b) { return a->offset < b->offset; });
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (!same_port(image, type.fields[i], spec, *ports[i])) return false;
  }
  return true;
}

}  // namespace

bool is_taskblock_type(const Image& image, std::uint32_t type) {
  if (type >= image.types.size() || image.types[type].kind != TypeKind::kStruct || image.types[type].fields.empty())
    return false;
  const ImageField& object = image.types[type].fields.front();
  const ImageType& number = image.types[object.type];
  return object.name == kObjectField && object.offset == 0 && object.role == FieldRole::kHidden &&
         number.kind == TypeKind::kScalar && number.elementary == core::TypeId::kUdint && !number.limited;
}

namespace {

/// The taskblock of which an instance begins at `offset` of the POU's instance, or null.
const ImageBlock* taskblock_at(const Image& image, const ImagePou& pou, std::uint32_t offset) {
  const auto block = std::find_if(image.blocks.begin(), image.blocks.end(), [&](const ImageBlock& b) {
    return stdlib::block_named(b.name) == nullptr && b.type < image.types.size() &&
           place_at(image, pou.instance_type, offset, b.type);
  });
  return block == image.blocks.end() ? nullptr : &*block;
}

bool is_wire(const Image& image, const ImagePou& pou, const ImageWire& wire) {
  const ImageBlock* const block = taskblock_at(image, pou, wire.block);
  if (block == nullptr) return false;
  const ImageType& type = image.types[block->type];
  if (wire.input >= type.fields.size() || type.fields[wire.input].role != FieldRole::kInput) return false;
  const std::uint64_t end = std::uint64_t{wire.block} + type.size;
  const std::uint64_t source_end = std::uint64_t{wire.source} + image.types[type.fields[wire.input].type].size;
  return place_at(image, pou.instance_type, wire.source, type.fields[wire.input].type) &&
         (source_end <= wire.block || wire.source >= end);
}

}  // namespace

void verify_library(const Image& image, Report& report) {
  for (const ImagePou& pou : image.pous) {
    for (std::size_t i = 0; i < pou.queue_ports.size(); ++i) {
      if (report.full()) return;
      const ImageQueuePort& port = pou.queue_ports[i];
      const bool twice =
          std::any_of(pou.queue_ports.begin(), pou.queue_ports.begin() + static_cast<std::ptrdiff_t>(i),
                      [&port](const ImageQueuePort& p) { return p.block == port.block && p.port == port.port; });
      if (twice || port.queue >= image.queues.size() || taskblock_at(image, pou, port.block) == nullptr) {
        report.broken(Rule::kV508, fmt::format("{}, port \"{}\"", pou.name, port.port));
      }
    }
    for (std::size_t i = 0; i < pou.wires.size(); ++i) {
      if (report.full()) return;
      const ImageWire& wire = pou.wires[i];
      const bool twice =
          std::any_of(pou.wires.begin(), pou.wires.begin() + static_cast<std::ptrdiff_t>(i),
                      [&wire](const ImageWire& w) { return w.block == wire.block && w.input == wire.input; });
      if (twice || !is_wire(image, pou, wire)) report.broken(Rule::kV507, fmt::format("{}, wire {}", pou.name, i));
    }
  }
  for (const ImageBlock& block : image.blocks) {
    if (report.full()) return;
    const stdlib::BlockSpec* spec = stdlib::block_named(block.name);
    if (spec == nullptr) {
      // A taskblock: which ones this machine has is known when the image is loaded.
      if (!is_taskblock_type(image, block.type)) report.broken(Rule::kV501, fmt::format("block {}", block.name));
      continue;
    }
    if (block.layout_hash != stdlib::layout_hash(*spec)) {
      report.broken(Rule::kV502, fmt::format("block {} has layout {:016x}, the library's {:016x}", block.name,
                                             block.layout_hash, stdlib::layout_hash(*spec)));
    }
    if (block.type >= image.types.size() || !same_ports(image, image.types[block.type], *spec)) {
      report.broken(Rule::kV503, fmt::format("block {}", block.name));
    }
  }
  for (const std::string& function : image.functions) {
    if (report.full()) return;
    if (stdlib::overload_with_key(function) == nullptr)
      report.broken(Rule::kV504, fmt::format("function {}", function));
  }
}

}  // namespace plc::bytecode
