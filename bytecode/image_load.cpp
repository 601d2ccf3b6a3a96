#define XXH_INLINE_ALL
#include <fmt/format.h>
#include <xxhash.h>

#include <cstring>
#include <string>
#include <string_view>

#include "bytecode/byte_io.h"
#include "bytecode/drawings.h"
#include "bytecode/format.h"
#include "bytecode/image.h"

namespace plc::bytecode {

namespace {

using core::Code;
using core::Problem;
using format::Section;

constexpr std::string_view kDamagedHelp = "copy the image again, or compile the project again";

class Loader {
 public:
  explicit Loader(std::span<const std::byte> file) : text_budget_(file.size() * format::kTextExpansion) {}

  /// Reads one section; false when its bytes do not make sense.
  bool read(Section id, std::span<const std::byte> content) {
    ByteReader in(content);
    switch (id) {
      case Section::kStrings:
        get_strings(in);
        break;
      case Section::kProject:
        get_project(in);
        break;
      case Section::kTypes:
        get_types(in);
        break;
      case Section::kTables:
        get_tables(in);
        break;
      case Section::kPous:
        get_pous(in);
        break;
      case Section::kLibrary:
        get_library(in);
        break;
      case Section::kQueues:
        get_queues(in);
        break;
      case Section::kTasks:
        get_tasks(in);
        break;
      case Section::kAddresses:
        in.take(content.size());
        image_.frozen_addresses.assign(reinterpret_cast<const char*>(content.data()), content.size());
        if (content.empty()) in.fail();
        break;
      case Section::kDrawings:
        in.take(content.size());
        image_.drawings.assign(content.begin(), content.end());
        if (!unpack(content)) in.fail();
        break;
      case Section::kProbes:
        in.take(content.size());
        if (!unpack_probes(content, image_.probes) || image_.probes.empty()) in.fail();
        break;
    }
    return !in.failed() && in.at_end();
  }
  Image take() { return std::move(image_); }

 private:
  template <class E>
  static E get_enum(ByteReader& in, E last) {
    const auto value = in.get<std::uint8_t>();
    if (value > static_cast<std::uint8_t>(last)) {
      in.fail();
      return E{};
    }
    return static_cast<E>(value);
  }
  static bool get_bool(ByteReader& in) {
    const auto value = in.get<std::uint8_t>();
    if (value > 1) in.fail();
    return value == 1;
  }
  std::string get_text(ByteReader& in) {
    const auto index = in.get<std::uint32_t>();
    if (in.failed() || index >= pool_.size() || pool_[index].size() > text_budget_) {
      in.fail();
      return {};
    }
    text_budget_ -= pool_[index].size();
    return std::string(pool_[index]);
  }
  static std::vector<std::byte> get_block(ByteReader& in) {
    const auto bytes = in.take(in.get<std::uint32_t>());
    return {bytes.begin(), bytes.end()};
  }

  void get_strings(ByteReader& in) {
    const std::uint32_t n = in.count(format::kTextRecord);
    pool_.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      const auto size = in.get<std::uint32_t>();
      if (size > format::kMaxTextBytes) return in.fail();
      const auto bytes = in.take(size);
      pool_.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
  }

  void get_project(ByteReader& in) {
    core::for_each_choice([&]<class E>(const core::Choice<E>& choice) {
      image_.options.*choice.value = get_enum(in, static_cast<E>(choice.words.size() - 1));
    });
    for (const core::Switch& flag : core::kSwitches) {
      if (flag.stored) image_.options.*flag.value = get_bool(in);
    }
    image_.options.pou = get_text(in);
    image_.project = get_text(in);
    image_.product = get_text(in);
    const std::uint32_t n = in.count(4);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) image_.files.push_back(get_text(in));
    // To the end of the section: most images have none.
    static_assert(core::kTexts.size() == 1);
    while (!in.failed() && !in.at_end()) (image_.options.*core::kTexts[0].value).push_back(get_text(in));
  }

  void get_types(ByteReader& in) {
    constexpr auto kLastType = static_cast<core::TypeId>(core::kTypeCount - 1);
    const std::uint32_t n = in.count(format::kTypeRecord);
    image_.types.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      ImageType& type = image_.types.emplace_back();
      type.kind = get_enum(in, TypeKind::kRef);
      type.elementary = get_enum(in, kLastType);
      type.limited = get_bool(in);
      type.name = get_text(in);
      type.size = in.get<std::uint32_t>();
      type.align = in.get<std::uint32_t>();
      type.capacity = in.get<std::uint16_t>();
      type.element = in.get<std::uint32_t>();
      type.count = in.get<std::uint32_t>();
      type.lower = in.get<std::int64_t>();
      type.upper = in.get<std::int64_t>();
      const std::uint32_t members = in.count(format::kMemberRecord);
      type.members.reserve(members);
      type.member_values.reserve(members);
      for (std::uint32_t m = 0; m < members && !in.failed(); ++m) {
        type.members.push_back(get_text(in));
        type.member_values.push_back(in.get<std::int64_t>());
      }
      const std::uint32_t fields = in.count(format::kFieldRecord);
      type.fields.reserve(fields);
      for (std::uint32_t f = 0; f < fields && !in.failed(); ++f) {
        ImageField& field = type.fields.emplace_back();
        field.name = get_text(in);
        field.type = in.get<std::uint32_t>();
        field.offset = in.get<std::uint32_t>();
        field.role = get_enum(in, FieldRole::kState);
        const auto flags = in.get<std::uint8_t>();
        if (flags > format::kFieldFlags) in.fail();
        field.retain = (flags & format::kFieldRetain) != 0;
        field.constant = (flags & format::kFieldConstant) != 0;
        field.persistent = (flags & format::kFieldPersistent) != 0;
        field.fresh = (flags & format::kFieldFresh) != 0;
        field.internal = (flags & format::kFieldInternal) != 0;
      }
      const std::uint32_t aliases = in.count(format::kAliasRecord);
      type.aliases.reserve(aliases);
      for (std::uint32_t a = 0; a < aliases && !in.failed(); ++a) {
        ImageAlias& alias = type.aliases.emplace_back();
        alias.name = get_text(in);
        alias.global = in.get<std::uint32_t>();
      }
    }
  }

  void get_tables(ByteReader& in) {
    image_.global_type = in.get<std::uint32_t>();
    image_.const_type = in.get<std::uint32_t>();
    const std::uint32_t n = in.count(format::kGlobalRecord);
    image_.globals.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      ImageGlobal& global = image_.globals.emplace_back();
      global.list = get_text(in);
      global.address = get_text(in);
      global.writers = in.get<std::uint32_t>();
    }
    image_.global_initial = get_block(in);
    image_.const_bytes = get_block(in);
  }

  void get_pous(ByteReader& in) {
    const std::uint32_t n = in.count(format::kPouRecord);
    image_.pous.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      ImagePou& pou = image_.pous.emplace_back();
      pou.name = get_text(in);
      pou.kind = get_enum(in, PouKind::kTask);
      pou.instance_type = in.get<std::uint32_t>();
      pou.frame_type = in.get<std::uint32_t>();
      pou.instance_initial = get_block(in);
      pou.frame_initial = get_block(in);
      const std::uint32_t words = in.count(4);
      const auto code = in.take(std::uint64_t{words} * 4);
      pou.code.resize(code.size() / 4);
      for (std::size_t w = 0; w < pou.code.size(); ++w) pou.code[w] = load_le<std::uint32_t>(code.data() + w * 4);
      const std::uint32_t entries = in.count(format::kDebugRecord);
      pou.debug.reserve(entries);
      for (std::uint32_t d = 0; d < entries && !in.failed(); ++d) {
        DebugEntry& entry = pou.debug.emplace_back();
        entry.word = in.get<std::uint32_t>();
        entry.at.line = in.get<std::uint32_t>();
        entry.at.column = in.get<std::uint32_t>();
        entry.at.local_id = in.get<std::int64_t>();
        entry.at.file = in.get<std::uint16_t>();
        entry.at.kind = get_enum(in, core::kLastElementKind);
      }
      const std::uint32_t wires = in.count(format::kWireRecord);
      pou.wires.reserve(wires);
      for (std::uint32_t w = 0; w < wires && !in.failed(); ++w) {
        ImageWire& wire = pou.wires.emplace_back();
        wire.block = in.get<std::uint32_t>();
        wire.input = in.get<std::uint32_t>();
        wire.source = in.get<std::uint32_t>();
      }
      const std::uint32_t ports = in.count(format::kQueuePortRecord);
      pou.queue_ports.reserve(ports);
      for (std::uint32_t p = 0; p < ports && !in.failed(); ++p) {
        ImageQueuePort& port = pou.queue_ports.emplace_back();
        port.block = in.get<std::uint32_t>();
        port.port = get_text(in);
        port.queue = in.get<std::uint32_t>();
        port.takes = get_bool(in);
      }
    }
  }

  void get_library(ByteReader& in) {
    const std::uint32_t blocks = in.count(format::kBlockRecord);
    image_.blocks.reserve(blocks);
    for (std::uint32_t i = 0; i < blocks && !in.failed(); ++i) {
      ImageBlock& block = image_.blocks.emplace_back();
      block.name = get_text(in);
      block.layout_hash = in.get<std::uint64_t>();
      block.type = in.get<std::uint32_t>();
    }
    const std::uint32_t functions = in.count(4);
    image_.functions.reserve(functions);
    for (std::uint32_t i = 0; i < functions && !in.failed(); ++i) image_.functions.push_back(get_text(in));
  }

  void get_queues(ByteReader& in) {
    const std::uint32_t n = in.count(format::kQueueRecord);
    image_.queues.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      ImageQueue& queue = image_.queues.emplace_back();
      queue.name = get_text(in);
      queue.type = in.get<std::uint32_t>();
      queue.capacity = in.get<std::uint32_t>();
      const std::uint32_t tasks = in.count(4);
      queue.puts.reserve(tasks);
      for (std::uint32_t t = 0; t < tasks && !in.failed(); ++t) queue.puts.push_back(in.get<std::uint32_t>());
      queue.takes = in.get<std::uint32_t>();
    }
  }

  void get_tasks(ByteReader& in) {
    const std::uint32_t n = in.count(format::kTaskRecord);
    image_.tasks.reserve(n);
    for (std::uint32_t i = 0; i < n && !in.failed(); ++i) {
      ImageTask& task = image_.tasks.emplace_back();
      task.name = get_text(in);
      task.period_ns = in.get<std::int64_t>();
      task.priority = in.get<std::int32_t>();
      task.single = get_text(in);
      task.body = in.get<std::uint32_t>();
    }
  }

  Image image_;
  std::vector<std::string_view> pool_;
  std::uint64_t text_budget_;  // bytes that may still be copied out of the pool
};

}  // namespace

core::Result<Image> load(std::span<const std::byte> bytes) {
  if (bytes.size() < format::kHeaderBytes ||
      std::memcmp(bytes.data(), format::kMagic.data(), format::kMagic.size()) != 0) {
    return Problem{Code::P6001, "the file does not begin like a PICARD image",
                   "compile the project with `plc compile`, or run the project file itself"};
  }
  const auto version = load_le<std::uint32_t>(bytes.data() + format::kVersionAt);
  if (version != kFormatVersion) {
    return Problem{Code::P6002,
                   fmt::format("format version {}, this program reads version {}", version, kFormatVersion),
                   "compile the project again with this version of PICARD"};
  }
  const auto rest = bytes.subspan(format::kHeaderBytes);
  if (load_le<std::uint64_t>(bytes.data() + format::kChecksumAt) != XXH3_64bits(rest.data(), rest.size())) {
    return Problem{Code::P6003, "the checksum does not match the content", std::string(kDamagedHelp)};
  }
  const auto sections = load_le<std::uint32_t>(bytes.data() + format::kSectionCountAt);
  if (sections < format::kSectionCount || sections > format::kMostSectionCount) {
    return Problem{Code::P6004, fmt::format("the image does not have {} sections", format::kSectionCount),
                   std::string(kDamagedHelp)};
  }

  Loader loader(bytes);
  ByteReader in(rest);
  std::uint32_t last = 0;
  for (std::uint32_t i = 1; i <= sections; ++i) {
    const auto id = in.get<std::uint32_t>();
    const auto content = in.take(in.get<std::uint64_t>());
    const bool expected = i <= format::kSectionCount ? id == i : id > last && id <= format::kMostSectionCount;
    last = id;
    if (in.failed() || !expected || !loader.read(static_cast<Section>(id), content)) {
      return Problem{Code::P6004, fmt::format("section {} of the image does not make sense", i),
                     std::string(kDamagedHelp)};
    }
  }
  if (!in.at_end()) {
    return Problem{Code::P6004, fmt::format("{} bytes follow the last section", in.left()), std::string(kDamagedHelp)};
  }
  return loader.take();
}

}  // namespace plc::bytecode
