#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "bytecode/listing.h"
#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

using listing::quoted;

constexpr std::uint32_t kNone = 0xffffffffu;

/// Text of a leaf that the assembler reads back to the same bytes, or nothing.
std::optional<std::string> value_text(const ImageType& type, const std::byte* at) {
  const auto read = [at](auto value) {
    std::memcpy(&value, at, sizeof value);
    return value;
  };
  switch (rep_of(type)) {
    case Rep::kBool:
    case Rep::kU8:
      return fmt::format("{}", read(std::uint8_t{}));
    case Rep::kI8:
      return fmt::format("{}", read(std::int8_t{}));
    case Rep::kI16:
      return fmt::format("{}", read(std::int16_t{}));
    case Rep::kU16:
      return fmt::format("{}", read(std::uint16_t{}));
    case Rep::kI32:
      return fmt::format("{}", read(std::int32_t{}));
    case Rep::kU32:
      return fmt::format("{}", read(std::uint32_t{}));
    case Rep::kI64:
      return fmt::format("{}", read(std::int64_t{}));
    case Rep::kU64:
      return fmt::format("{}", read(std::uint64_t{}));
    case Rep::kF32:
      return std::isnan(read(float{})) ? "nan" : fmt::format("{}", read(float{}));
    case Rep::kF64:
      return std::isnan(read(double{})) ? "nan" : fmt::format("{}", read(double{}));
    case Rep::kStr: {
      const auto length = read(core::StringHeader{}).length;
      if (length > type.capacity) return std::nullopt;
      return quoted({reinterpret_cast<const char*>(at) + sizeof(core::StringHeader), length});
    }
    case Rep::kWstr: {
      const auto length = read(core::StringHeader{}).length;
      if (length > type.capacity) return std::nullopt;
      std::string text = "w\"";
      for (std::size_t i = 0; i < length; ++i) {
        std::uint16_t unit = 0;
        std::memcpy(&unit, at + sizeof(core::StringHeader) + 2 * i, sizeof unit);
        text += fmt::format("{:04x}", unit);
      }
      return text + '"';
    }
    case Rep::kRef:
      return std::nullopt;
  }
  return std::nullopt;
}

class Disassembler {
 public:
  explicit Disassembler(const Image& image) : image_(image), names_(image) {
    core::Diagnostics ignored;
    Report report(image, ignored);
    verify_types(image, report);
    sound_ = report.clean();
  }

  std::string run() {
    line("image {}", kFormatVersion);
    line("project {}", quoted(image_.project));
    line("product {}", quoted(image_.product));
    if (!image_.frozen_addresses.empty()) line("addresses {}", quoted(image_.frozen_addresses));
    put_hex("drawings", image_.drawings);
    if (!image_.probes.empty()) put_hex("probes", pack_probes(image_.probes));
    const core::CompileOptions& options = image_.options;
    put("options");
    core::for_each_choice([&](const auto& choice) { put(" {}", word_of(choice, options)); });
    put(" {}", quoted(options.pou));
    for (const core::Switch& flag : core::kSwitches) {
      if (flag.stored && options.*flag.value) put(" {}", flag.name);
    }
    for (const core::Texts& texts : core::kTexts) {
      for (const std::string& text : options.*texts.value) put(" {} {}", texts.name, quoted(text));
    }
    line("");
    for (const std::string& file : image_.files) line("file {}", quoted(file));
    for (std::size_t i = 0; i < image_.types.size(); ++i) put_type(i, image_.types[i]);
    line("globals {}", image_.global_type);
    for (std::size_t i = 0; i < image_.globals.size(); ++i) {
      const ImageGlobal& global = image_.globals[i];
      if (global.list.empty() && global.address.empty() && global.writers == 0) continue;
      line("  global {} {} {} {}", i, quoted(global.list), quoted(global.address), global.writers);
    }
    put_bytes("init", image_.global_type, image_.global_initial);
    line("constants {}", image_.const_type);
    put_bytes("init", image_.const_type, image_.const_bytes);
    for (const ImageBlock& block : image_.blocks) {
      line("block {} {:#018x} t{}", quoted(block.name), block.layout_hash, block.type);
    }
    for (const std::string& function : image_.functions) line("function {}", quoted(function));
    for (const ImageQueue& queue : image_.queues) {
      put("queue {} t{} capacity {}", quoted(queue.name), queue.type, queue.capacity);
      if (queue.takes != ImageQueue::kNoTask) put(" takes {}", queue.takes);
      for (const std::uint32_t task : queue.puts) put(" puts {}", task);
      out_ += '\n';
    }
    for (const ImagePou& pou : image_.pous) put_pou(pou);
    for (const ImageTask& task : image_.tasks) {
      line("task {} period {} priority {} single {} body p{}", quoted(task.name), task.period_ns, task.priority,
           quoted(task.single), task.body);
    }
    return std::move(out_);
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), text, std::forward<Args>(args)...);
  }
  template <class... Args>
  void line(fmt::format_string<Args...> text, Args&&... args) {
    put(text, std::forward<Args>(args)...);
    out_ += '\n';
  }

  void put_type(std::size_t index, const ImageType& type) {
    put("type {} ", index);
    switch (type.kind) {
      case TypeKind::kScalar:
        put("scalar {}", core::name_of(type.elementary));
        if (type.limited) put(" limits {} {}", type.lower, type.upper);
        for (std::size_t i = 0; i < type.members.size() && i < type.member_values.size(); ++i) {
          put(" member {} {}", quoted(type.members[i]), type.member_values[i]);
        }
        break;
      case TypeKind::kString:
        put("string {} {} align {}", core::name_of(type.elementary), type.capacity, type.align);
        break;
      case TypeKind::kArray:
        put("array t{} {} from {}", type.element, type.count, type.lower);
        break;
      case TypeKind::kStruct:
        put("struct size {} align {}", type.size, type.align);
        break;
      case TypeKind::kRef:
        put("ref t{}", type.element);
        break;
    }
    line("{}", type.name.empty() ? "" : " name " + quoted(type.name));
    for (const ImageField& field : type.fields) {
      line("  field {} t{} at {} {}{}{}{}{}{}", quoted(field.name), field.type, field.offset,
           listing::kRoles[static_cast<std::size_t>(field.role)], field.retain ? " retain" : "",
           field.persistent ? " persistent" : "", field.fresh ? " fresh" : "", field.internal ? " internal" : "",
           field.constant ? " constant" : "");
    }
    for (const ImageAlias& alias : type.aliases) line("  alias {} global {}", quoted(alias.name), alias.global);
  }

  // ---- initial bytes

  void put_bytes(std::string_view word, std::uint32_t type, std::span<const std::byte> bytes) {
    const std::size_t start = out_.size();
    // A table that is larger than its bytes is not worth laying out.
    if (sound_ && type < image_.types.size() && image_.types[type].size == bytes.size()) {
      const auto fresh = listing::default_bytes(image_, type);
      if (fresh && put_values(word, type, type, 0, bytes, *fresh)) return;
    }
    out_.resize(start);
    put_hex(fmt::format("  {} hex", word), bytes);
  }

  void put_hex(std::string_view words, std::span<const std::byte> bytes) {
    constexpr std::size_t kPerLine = 32;
    for (std::size_t at = 0; at < bytes.size(); at += kPerLine) {
      put("{} {} ", words, at);
      for (const std::byte b : bytes.subspan(at, std::min(kPerLine, bytes.size() - at))) {
        put("{:02x}", static_cast<unsigned>(b));
      }
      out_ += '\n';
    }
  }

  /// Writes the leaves of `type` at `at` that differ from a fresh value. False when bytes differ that no leaf accounts
  /// for (padding, the rest of a string).
  bool put_values(std::string_view word, std::uint32_t root, std::uint32_t index, std::size_t at,
                  std::span<const std::byte> bytes, std::span<const std::byte> fresh) {
    const ImageType& type = image_.types[index];
    if (type.size == 0 || std::memcmp(bytes.data() + at, fresh.data() + at, type.size) == 0) return true;
    switch (type.kind) {
      case TypeKind::kArray: {
        const std::size_t size = image_.types[type.element].size;
        for (std::size_t i = 0; i < type.count; ++i) {
          if (!put_values(word, root, type.element, at + i * size, bytes, fresh)) return false;
        }
        return true;
      }
      case TypeKind::kStruct: {
        std::size_t end = 0;
        for (const ImageField& field : type.fields) {
          if (!is_zero(bytes, at + end, at + field.offset)) return false;
          if (!put_values(word, root, field.type, at + field.offset, bytes, fresh)) return false;
          end = field.offset + std::size_t{image_.types[field.type].size};
        }
        return is_zero(bytes, at + end, at + type.size);
      }
      default:
        return put_value(word, root, type, at, bytes);
    }
  }
  static bool is_zero(std::span<const std::byte> bytes, std::size_t from, std::size_t to) {
    for (; from < to; ++from) {
      if (bytes[from] != std::byte{0}) return false;
    }
    return true;
  }
  bool put_value(std::string_view word, std::uint32_t root, const ImageType& type, std::size_t at,
                 std::span<const std::byte> bytes) {
    const auto text = value_text(type, bytes.data() + at);
    if (!text) return false;
    if (type.kind == TypeKind::kString) {
      core::StringHeader header;
      std::memcpy(&header, bytes.data() + at, sizeof header);
      const std::size_t unit = type.elementary == core::TypeId::kWstring ? 2 : 1;
      if (header.capacity != type.capacity) return false;
      if (!is_zero(bytes, at + sizeof header + header.length * unit, at + type.size)) return false;
    }
    const auto offset = static_cast<std::uint32_t>(at);
    const auto path = names_.path(root, offset, kNone);
    line("  {} {} = {}", word, path ? *path : fmt::format("+{}", offset), *text);
    return true;
  }

  // ---- code

  void put_pou(const ImagePou& pou) {
    line("pou {} {} instance t{} frame t{}", quoted(pou.name), listing::kPouKinds[static_cast<std::size_t>(pou.kind)],
         pou.instance_type, pou.frame_type);
    put_bytes("instance", pou.instance_type, pou.instance_initial);
    put_bytes("frame", pou.frame_type, pou.frame_initial);
    for (const ImageWire& wire : pou.wires) line("  wire {} {} {}", wire.block, wire.input, wire.source);
    for (const ImageQueuePort& port : pou.queue_ports) {
      line("  port {} {} queue q{}{}", port.block, quoted(port.port), port.queue, port.takes ? " takes" : "");
    }
    roots_ = {image_.global_type, pou.instance_type, pou.frame_type, image_.const_type};
    find_labels(pou);
    std::size_t debug = 0;
    for (std::size_t at = 0; at < pou.code.size();) {
      for (; debug < pou.debug.size() && pou.debug[debug].word <= at; ++debug) put_debug(pou.debug[debug]);
      if (labels_[at] && starts_[at]) line("L{}:", at);
      const std::size_t length = length_at(pou.code, at);
      if (length == 0) {
        line("    word {:#010x}", pou.code[at++]);
        continue;
      }
      put_instruction(std::span(pou.code).subspan(at, length));
      at += length;
    }
    for (; debug < pou.debug.size(); ++debug) put_debug(pou.debug[debug]);
  }

  void put_debug(const DebugEntry& entry) {
    line("  debug {} file {} line {} column {} id {} kind {}", entry.word, entry.at.file, entry.at.line,
         entry.at.column, entry.at.local_id, static_cast<unsigned>(entry.at.kind));
  }

  /// Words of the instruction at `at`; 0 when there is no whole one.
  static std::size_t length_at(std::span<const std::uint32_t> code, std::size_t at) {
    const std::uint32_t opcode = code[at] & 0xffffu;
    const std::uint32_t items = code[at] >> 16;
    if (opcode >= opcodes().size()) return 0;
    const Operands& operands = opcodes()[opcode].operands;
    const std::size_t length = words_of(operands, items);
    const bool list = length != words_of(operands, 0);
    return length > code.size() - at || (items != 0 && !list) ? 0 : length;
  }

  void find_labels(const ImagePou& pou) {
    labels_.assign(pou.code.size(), false);
    starts_.assign(pou.code.size(), false);
    for (std::size_t at = 0; at < pou.code.size();) {
      starts_[at] = true;
      const std::size_t length = length_at(pou.code, at);
      if (length == 0) {
        ++at;
        continue;
      }
      const Operands& operands = info(static_cast<Opcode>(pou.code[at] & 0xffffu)).operands;
      for (std::uint8_t i = 0; i < operands.count; ++i) {
        if (operands.specs[i].kind != OperandKind::kTarget) continue;
        const std::uint32_t target = pou.code[at + 1 + i];
        if (target < labels_.size()) labels_[target] = true;
      }
      at += length;
    }
  }

  std::string operand(std::uint32_t word, std::uint32_t wanted) {
    const auto space = static_cast<std::size_t>(space_of(word));
    const auto path = sound_ ? names_.path(roots_[space], offset_of(word), wanted) : std::nullopt;
    return path ? fmt::format("{}:{}", listing::kSpaces[space], *path)
                : fmt::format("{}+{}", listing::kSpaces[space], offset_of(word));
  }

  void put_instruction(std::span<const std::uint32_t> words) {
    const OpcodeInfo& op = info(static_cast<Opcode>(words[0] & 0xffffu));
    const std::uint32_t items = words[0] >> 16;
    put("    {}", op.mnemonic);
    wanted_ = executed_ = end_ = kNone;
    comment_.clear();
    std::size_t word = 1;
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      if (op.operands.specs[i].kind == OperandKind::kType) wanted_ = words[1 + i];
      if (op.operands.specs[i].kind == OperandKind::kPath) end_ = end_of(words.subspan(words_of(op.operands, 0)));
    }
    for (std::uint8_t i = 0; i < op.operands.count; ++i) {
      const OperandKind kind = op.operands.specs[i].kind;
      const std::uint32_t item = words_per_item(kind);
      if (kind == OperandKind::kRecords) {
        put_records(words.subspan(word));
        return;
      }
      if (item == 0) {
        put("{}{}", i == 0 ? " " : ", ", operand_text(kind, words[word++]));
        continue;
      }
      for (std::uint32_t n = 0; n < items; ++n, word += item) {
        if (kind == OperandKind::kFnArgs) {
          put(", {}={}", words[word], operand(words[word + 1], kNone));
        } else if (kind == OperandKind::kPath) {
          put(", {}", step_text(words[word], words[word + 1]));
        } else {
          put(", {}", operand(words[word], kNone));
        }
      }
    }
    line("{}", comment_.empty() ? "" : "  ; " + comment_);
  }

  /// Type where the path ends that `items` are, or kNone.
  std::uint32_t end_of(std::span<const std::uint32_t> items) const {
    if (!sound_ || wanted_ >= image_.types.size()) return kNone;
    std::uint32_t type = wanted_;
    for (; !items.empty(); items = items.subspan(kPathWords)) {
      const auto next = follow_path(image_, type, items[0], items[1]);
      if (!next) return kNone;
      type = next->type;
    }
    return type;
  }
  std::string step_text(std::uint32_t step, std::uint32_t number) {
    if (step == static_cast<std::uint32_t>(PathStep::kField)) return fmt::format(".{}", number);
    if (step == static_cast<std::uint32_t>(PathStep::kElement)) return fmt::format("[{}]", number);
    return fmt::format("[{}]", operand(number, kNone));
  }

  void put_records(std::span<const std::uint32_t> words) {
    out_ += '\n';
    for (; !words.empty(); words = words.subspan(kRecordWords)) {
      put("      | {:#010x} {}", words[0], operand(words[1], kNone));
      for (std::size_t i = 2; i < kRecordWords; ++i) put(", {}", operand(words[i], kNone));
      out_ += '\n';
    }
  }

  std::string operand_text(OperandKind kind, std::uint32_t word) {
    switch (kind) {
      case OperandKind::kIn:
      case OperandKind::kOut:
        return operand(word, kNone);
      case OperandKind::kPlaceIn:
      case OperandKind::kPlaceOut:
      case OperandKind::kBaseIn:
      case OperandKind::kBaseOut:
        return operand(word, wanted_);
      case OperandKind::kPlaceInOut:
        return operand(word, executed_);
      case OperandKind::kValueIn:
      case OperandKind::kValueOut:
        return operand(word, end_);
      case OperandKind::kTarget:
        return word < labels_.size() && starts_[word] ? fmt::format("L{}", word) : fmt::format("@{}", word);
      case OperandKind::kType:
        return fmt::format("t{}", word);
      case OperandKind::kPou:
        if (word < image_.pous.size()) {
          executed_ = image_.pous[word].instance_type;
          comment_ = quoted(image_.pous[word].name);
        }
        return fmt::format("p{}", word);
      case OperandKind::kBlock:
        if (word < image_.blocks.size()) {
          executed_ = image_.blocks[word].type;
          comment_ = quoted(image_.blocks[word].name);
        }
        return fmt::format("b{}", word);
      case OperandKind::kFunction:
        if (word < image_.functions.size()) comment_ = quoted(image_.functions[word]);
        return fmt::format("s{}", word);
      case OperandKind::kQueue:
        if (word < image_.queues.size()) comment_ = quoted(image_.queues[word].name);
        return fmt::format("q{}", word);
      default:
        return fmt::format("{}", word);
    }
  }

  const Image& image_;
  listing::Names names_;
  bool sound_ = false;  // the types may be walked
  std::string out_;
  std::array<std::uint32_t, 4> roots_{};
  std::vector<bool> labels_, starts_;
  std::uint32_t wanted_ = kNone;    // type of the instruction's places, or where its path starts
  std::uint32_t end_ = kNone;       // type where its path ends
  std::uint32_t executed_ = kNone;  // type of its block or POU
  std::string comment_;
};

}  // namespace

std::string disassemble(const Image& image) { return Disassembler(image).run(); }

}  // namespace plc::bytecode
