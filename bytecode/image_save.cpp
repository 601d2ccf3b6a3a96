#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>

#include "bytecode/byte_io.h"
#include "bytecode/format.h"
#include "bytecode/image.h"

namespace plc::bytecode {

namespace {

using format::Section;

// Sections are written in the order of use; the pool, which comes first in the file, fills meanwhile.
class Saver {
 public:
  explicit Saver(const Image& image) : image_(image) {}

  std::vector<std::byte> run() {
    ByteWriter project, types, tables, pous, library, queues, tasks;
    put_project(project);
    put_types(types);
    put_tables(tables);
    put_pous(pous);
    put_library(library);
    put_queues(queues);
    put_tasks(tasks);
    ByteWriter strings;
    strings.put(static_cast<std::uint32_t>(pool_.size()));
    for (const std::string_view text : pool_) {
      strings.put(static_cast<std::uint32_t>(text.size()));
      strings.put_bytes(std::as_bytes(std::span(text)));
    }

    std::size_t bytes = 0;
    for (const ByteWriter* part : {&strings, &project, &types, &tables, &pous, &library, &queues, &tasks}) {
      bytes += part->size();
    }
    ByteWriter probes;
    if (!image_.probes.empty()) probes.put_bytes(pack_probes(image_.probes));
    bytes += image_.frozen_addresses.size() + image_.drawings.size() + probes.size();
    ByteWriter out;
    constexpr std::size_t kAllHeads = 256;
    out.bytes().reserve(bytes + kAllHeads);
    out.put_bytes(std::as_bytes(std::span(format::kMagic)));
    out.put(kFormatVersion);
    out.put(format::kSectionCount + (image_.frozen_addresses.empty() ? 0 : 1) + (image_.drawings.empty() ? 0 : 1) +
            (image_.probes.empty() ? 0 : 1));
    out.put(std::uint64_t{0});
    put_section(out, Section::kStrings, strings);
    put_section(out, Section::kProject, project);
    put_section(out, Section::kTypes, types);
    put_section(out, Section::kTables, tables);
    put_section(out, Section::kPous, pous);
    put_section(out, Section::kLibrary, library);
    put_section(out, Section::kQueues, queues);
    put_section(out, Section::kTasks, tasks);
    if (!image_.frozen_addresses.empty()) {
      ByteWriter addresses;
      addresses.put_bytes(std::as_bytes(std::span(image_.frozen_addresses)));
      put_section(out, Section::kAddresses, addresses);
    }
    if (!image_.drawings.empty()) {
      ByteWriter drawings;
      drawings.put_bytes(image_.drawings);
      put_section(out, Section::kDrawings, drawings);
    }
    if (!image_.probes.empty()) put_section(out, Section::kProbes, probes);
    reseal(out.bytes());
    return std::move(out.bytes());
  }

 private:
  static void put_section(ByteWriter& out, Section id, ByteWriter& content) {
    out.put(static_cast<std::uint32_t>(id));
    out.put(static_cast<std::uint64_t>(content.size()));
    out.put_bytes(content.bytes());
  }

  void put_text(ByteWriter& out, std::string_view text) {
    const auto [it, added] = index_.emplace(text, static_cast<std::uint32_t>(pool_.size()));
    if (added) pool_.push_back(text);
    out.put(it->second);
  }
  static void put_count(ByteWriter& out, std::size_t count) { out.put(static_cast<std::uint32_t>(count)); }
  static void put_block(ByteWriter& out, std::span<const std::byte> bytes) {
    put_count(out, bytes.size());
    out.put_bytes(bytes);
  }

  void put_project(ByteWriter& out) {
    const core::CompileOptions& options = image_.options;
    core::for_each_choice([&](const auto& choice) { out.put(static_cast<std::uint8_t>(options.*choice.value)); });
    for (const core::Switch& flag : core::kSwitches) {
      if (flag.stored) out.put(static_cast<std::uint8_t>(options.*flag.value));
    }
    put_text(out, options.pou);
    put_text(out, image_.project);
    put_text(out, image_.product);
    put_count(out, image_.files.size());
    for (const std::string& file : image_.files) put_text(out, file);
    for (const core::Texts& texts : core::kTexts) {
      for (const std::string& text : options.*texts.value) put_text(out, text);
    }
  }

  void put_types(ByteWriter& out) {
    put_count(out, image_.types.size());
    for (const ImageType& type : image_.types) {
      out.put(static_cast<std::uint8_t>(type.kind));
      out.put(static_cast<std::uint8_t>(type.elementary));
      out.put(static_cast<std::uint8_t>(type.limited));
      put_text(out, type.name);
      out.put(type.size);
      out.put(type.align);
      out.put(type.capacity);
      out.put(type.element);
      out.put(type.count);
      out.put(type.lower);
      out.put(type.upper);
      put_count(out, type.members.size());
      for (std::size_t i = 0; i < type.members.size(); ++i) {
        put_text(out, type.members[i]);
        out.put(i < type.member_values.size() ? type.member_values[i] : std::int64_t{0});
      }
      put_count(out, type.fields.size());
      for (const ImageField& field : type.fields) {
        put_text(out, field.name);
        out.put(field.type);
        out.put(field.offset);
        out.put(static_cast<std::uint8_t>(field.role));
        out.put(static_cast<std::uint8_t>(
            (field.retain ? format::kFieldRetain : 0) | (field.constant ? format::kFieldConstant : 0) |
            (field.persistent ? format::kFieldPersistent : 0) | (field.fresh ? format::kFieldFresh : 0) |
            (field.internal ? format::kFieldInternal : 0)));
      }
      put_count(out, type.aliases.size());
      for (const ImageAlias& alias : type.aliases) {
        put_text(out, alias.name);
        out.put(alias.global);
      }
    }
  }

  void put_tables(ByteWriter& out) {
    out.put(image_.global_type);
    out.put(image_.const_type);
    put_count(out, image_.globals.size());
    for (const ImageGlobal& global : image_.globals) {
      put_text(out, global.list);
      put_text(out, global.address);
      out.put(global.writers);
    }
    put_block(out, image_.global_initial);
    put_block(out, image_.const_bytes);
  }

  void put_pous(ByteWriter& out) {
    put_count(out, image_.pous.size());
    for (const ImagePou& pou : image_.pous) {
      put_text(out, pou.name);
      out.put(static_cast<std::uint8_t>(pou.kind));
      out.put(pou.instance_type);
      out.put(pou.frame_type);
      put_block(out, pou.instance_initial);
      put_block(out, pou.frame_initial);
      put_count(out, pou.code.size());
      out.put_words(pou.code);
      put_count(out, pou.debug.size());
      for (const DebugEntry& entry : pou.debug) {
        out.put(entry.word);
        out.put(entry.at.line);
        out.put(entry.at.column);
        out.put(entry.at.local_id);
        out.put(entry.at.file);
        out.put(static_cast<std::uint8_t>(entry.at.kind));
      }
      put_count(out, pou.wires.size());
      for (const ImageWire& wire : pou.wires) {
        out.put(wire.block);
        out.put(wire.input);
        out.put(wire.source);
      }
      put_count(out, pou.queue_ports.size());
      for (const ImageQueuePort& port : pou.queue_ports) {
        out.put(port.block);
        put_text(out, port.port);
        out.put(port.queue);
        out.put(static_cast<std::uint8_t>(port.takes));
      }
    }
  }

  void put_library(ByteWriter& out) {
    put_count(out, image_.blocks.size());
    for (const ImageBlock& block : image_.blocks) {
      put_text(out, block.name);
      out.put(block.layout_hash);
      out.put(block.type);
    }
    put_count(out, image_.functions.size());
    for (const std::string& function : image_.functions) put_text(out, function);
  }

  void put_queues(ByteWriter& out) {
    put_count(out, image_.queues.size());
    for (const ImageQueue& queue : image_.queues) {
      put_text(out, queue.name);
      out.put(queue.type);
      out.put(queue.capacity);
      put_count(out, queue.puts.size());
      for (const std::uint32_t task : queue.puts) out.put(task);
      out.put(queue.takes);
    }
  }

  void put_tasks(ByteWriter& out) {
    put_count(out, image_.tasks.size());
    for (const ImageTask& task : image_.tasks) {
      put_text(out, task.name);
      out.put(task.period_ns);
      out.put(task.priority);
      put_text(out, task.single);
      out.put(task.body);
    }
  }

  const Image& image_;
  std::vector<std::string_view> pool_;
  std::unordered_map<std::string_view, std::uint32_t> index_;
};

}  // namespace

std::vector<std::byte> save(const Image& image) { return Saver(image).run(); }

void reseal(std::span<std::byte> bytes) {
  if (bytes.size() < format::kHeaderBytes) return;
  const auto rest = bytes.subspan(format::kHeaderBytes);
  store_le(bytes.data() + format::kChecksumAt, static_cast<std::uint64_t>(XXH3_64bits(rest.data(), rest.size())));
}

}  // namespace plc::bytecode
