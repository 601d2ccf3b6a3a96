#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <unordered_map>

#include "bytecode/assembler_line.h"
#include "bytecode/listing.h"

namespace plc::bytecode {

namespace {

using core::Code;
using core::Problem;
using listing::fail;
using listing::Line;
using listing::Mistake;

const std::unordered_map<std::string_view, Opcode>& mnemonics() {
  static const std::unordered_map<std::string_view, Opcode> kMap = [] {
    std::unordered_map<std::string_view, Opcode> map;
    for (std::size_t i = 0; i < opcodes().size(); ++i) map.emplace(opcodes()[i].mnemonic, static_cast<Opcode>(i));
    return map;
  }();
  return kMap;
}

class Assembler {
 public:
  Assembler() : names_(image_) {}

  /// Number of the line that is being read, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }

  /// Takes one line.
  void take(std::string_view text) {
    ++line_;
    Line line(text);
    if (line.empty()) return;
    const std::string_view word = line.word();
    if (in_code_ && word != "pou" && word != "task") {
      take_in_pou(word, line);
    } else {
      take_top(word, line);
    }
    line.end();
  }
  Image finish() {
    close_pou();
    if (!probes_.empty() && !unpack_probes(probes_, image_.probes)) fail("the probe maps are not whole");
    return std::move(image_);
  }

 private:
  void take_top(std::string_view word, Line& line) {
    if (word == "image") {
      const auto version = line.number<std::uint32_t>();
      if (version != kFormatVersion) fail(fmt::format("version {} of the format", version));
    } else if (word == "project") {
      image_.project = line.text();
    } else if (word == "product") {
      image_.product = line.text();
    } else if (word == "addresses") {
      image_.frozen_addresses = line.text();
    } else if (word == "drawings") {
      take_hex(image_.drawings, line, true);
    } else if (word == "probes") {
      take_hex(probes_, line, true);
    } else if (word == "options") {
      take_options(line);
    } else if (word == "file") {
      image_.files.push_back(line.text());
    } else if (word == "type") {
      take_type(line);
    } else if (word == "field") {
      take_field(line);
    } else if (word == "alias") {
      take_alias(line);
    } else if (word == "globals") {
      image_.global_type = line.number<std::uint32_t>();
      image_.globals.resize(type_at(image_.global_type).fields.size());
      open_table(image_.global_type, image_.global_initial);
    } else if (word == "global") {
      take_global(line);
    } else if (word == "constants") {
      image_.const_type = line.number<std::uint32_t>();
      open_table(image_.const_type, image_.const_bytes);
    } else if (word == "init") {
      if (table_bytes_ == nullptr) fail("an initial value outside a table");
      take_value(table_type_, *table_bytes_, line);
    } else if (word == "block") {
      ImageBlock block;
      block.name = line.text();
      block.layout_hash = line.number<std::uint64_t>();
      block.type = line.index('t');
      image_.blocks.push_back(std::move(block));
    } else if (word == "function") {
      image_.functions.push_back(line.text());
    } else if (word == "queue") {
      take_queue(line);
    } else if (word == "pou") {
      take_pou(line);
    } else if (word == "task") {
      take_task(line);
    } else {
      fail(fmt::format("\"{}\" is unknown here", word));
    }
  }

  void take_options(Line& line) {
    core::CompileOptions& options = image_.options;
    core::for_each_choice(
        [&]<class E>(const core::Choice<E>& choice) { options.*choice.value = line.one_of<E>(choice.words); });
    options.pou = line.text();
    for (const core::Switch& flag : core::kSwitches) {
      if (flag.stored) options.*flag.value = line.accept(flag.name);
    }
    for (const core::Texts& texts : core::kTexts) {
      while (line.accept(texts.name)) (options.*texts.value).push_back(line.text());
    }
  }

  // ---- types

  const ImageType& type_at(std::uint32_t index) const {
    if (index >= image_.types.size()) fail(fmt::format("type {} is not known yet", index));
    return image_.types[index];
  }

  void take_type(Line& line) {
    if (table_bytes_ != nullptr) fail("a type after the tables");
    if (line.number<std::size_t>() != image_.types.size())
      fail(fmt::format("the next type is {}", image_.types.size()));
    constexpr std::array<std::string_view, 5> kKinds = {"scalar", "string", "array", "struct", "ref"};
    ImageType type;
    type.kind = line.one_of<TypeKind>(kKinds);
    switch (type.kind) {
      case TypeKind::kScalar:
        take_scalar(type, line);
        break;
      case TypeKind::kString: {
        type.elementary = elementary(line);
        type.capacity = line.number<std::uint16_t>();
        line.expect("align");
        type.align = std::max(line.number<std::uint32_t>(), 1u);
        const std::uint32_t unit = type.elementary == core::TypeId::kWstring ? 2 : 1;
        type.size = (4u + type.capacity * unit + type.align - 1) / type.align * type.align;
        break;
      }
      case TypeKind::kArray: {
        type.element = line.index('t');
        const ImageType& element = type_at(type.element);
        type.count = line.number<std::uint32_t>();
        line.expect("from");
        type.lower = line.number<std::int64_t>();
        const std::uint64_t size = std::uint64_t{element.size} * type.count;
        if (size > kMaxTableBytes) fail(fmt::format("the array takes {} bytes", size));
        type.size = static_cast<std::uint32_t>(size);
        type.align = element.align;
        break;
      }
      case TypeKind::kStruct:
        line.expect("size");
        type.size = line.number<std::uint32_t>();
        line.expect("align");
        type.align = line.number<std::uint32_t>();
        break;
      case TypeKind::kRef:
        type.element = line.index('t');
        type.size = type.align = 8;
        break;
    }
    if (line.accept("name")) type.name = line.text();
    image_.types.push_back(std::move(type));
  }
  static core::TypeId elementary(Line& line) {
    const std::string_view name = line.word();
    const auto id = core::type_named(name);
    if (!id) fail(fmt::format("\"{}\" is no elementary type", name));
    return *id;
  }
  static void take_scalar(ImageType& type, Line& line) {
    type.elementary = elementary(line);
    type.size = type.align = core::rep_bytes(core::rep_of(type.elementary));
    if (line.accept("limits")) {
      type.limited = true;
      type.lower = line.number<std::int64_t>();
      type.upper = line.number<std::int64_t>();
    }
    while (line.accept("member")) {
      type.members.push_back(line.text());
      type.member_values.push_back(line.number<std::int64_t>());
    }
  }

  void take_field(Line& line) {
    if (image_.types.empty() || image_.types.back().kind != TypeKind::kStruct) fail("a field without a structure");
    if (table_bytes_ != nullptr) fail("a field after the tables");
    ImageField field;
    field.name = line.text();
    field.type = line.index('t');
    line.expect("at");
    field.offset = line.number<std::uint32_t>();
    field.role = line.one_of<FieldRole>(listing::kRoles);
    field.retain = line.accept("retain");
    field.persistent = line.accept("persistent");
    field.fresh = line.accept("fresh");
    field.internal = line.accept("internal");
    field.constant = line.accept("constant");
    image_.types.back().fields.push_back(std::move(field));
  }

  void take_alias(Line& line) {
    if (image_.types.empty() || image_.types.back().kind != TypeKind::kStruct) fail("an alias without a structure");
    if (table_bytes_ != nullptr) fail("an alias after the tables");
    ImageAlias alias;
    alias.name = line.text();
    line.expect("global");
    alias.global = line.number<std::uint32_t>();
    image_.types.back().aliases.push_back(std::move(alias));
  }

  // ---- tables

  void open_table(std::uint32_t type, std::vector<std::byte>& bytes) {
    auto fresh = listing::default_bytes(image_, type);
    if (!fresh) fail(fmt::format("type {} cannot be laid out", type));
    bytes = std::move(*fresh);
    table_type_ = type;
    table_bytes_ = &bytes;
  }

  void take_global(Line& line) {
    const auto index = line.number<std::size_t>();
    if (index >= image_.globals.size()) fail(fmt::format("there are {} globals", image_.globals.size()));
    ImageGlobal& global = image_.globals[index];
    global.list = line.text();
    global.address = line.text();
    global.writers = line.number<std::uint32_t>();
  }

  /// "path = value" or "hex offset digits".
  void take_value(std::uint32_t table, std::vector<std::byte>& bytes, Line& line) {
    const std::string_view path = line.word();
    if (path == "hex" && line.peek() != "=") {
      take_hex(bytes, line);
      return;
    }
    listing::Names::Place place;
    if (path.front() == '+') {
      place.offset = Line::to_number<std::uint32_t>(path.substr(1));
      const auto leaf = leaf_at(image_, table, place.offset);
      if (!leaf) fail(fmt::format("no value begins at byte {}", place.offset));
      place.type = *leaf;
    } else {
      const auto found = names_.find(table, path);
      if (!found) fail(fmt::format("\"{}\" is not in the table", path));
      place = *found;
    }
    const ImageType& type = type_at(place.type);
    if (place.offset > bytes.size() || type.size > bytes.size() - place.offset)
      fail("the value lies outside the table");
    line.expect("=");
    put_value(type, bytes.data() + place.offset, line.word());
  }

  /// `grows`: the bytes follow those that are there.
  static void take_hex(std::vector<std::byte>& bytes, Line& line, bool grows = false) {
    const auto offset = line.number<std::size_t>();
    const std::string_view digits = line.word();
    if (grows && offset == bytes.size()) bytes.resize(offset + digits.size() / 2);
    if (digits.size() % 2 != 0 || offset > bytes.size() || digits.size() / 2 > bytes.size() - offset) {
      fail("the bytes do not fit the table");
    }
    for (std::size_t i = 0; i < digits.size() / 2; ++i) {
      bytes[offset + i] = static_cast<std::byte>(hex_number(digits.substr(2 * i, 2)));
    }
  }
  static std::uint16_t hex_number(std::string_view digits) {
    std::uint16_t value = 0;
    const char* const end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, value, 16);
    if (error != std::errc{} || stop != end) fail(fmt::format("\"{}\" are not hexadecimal digits", digits));
    return value;
  }

  template <class T>
  static void put_number(std::byte* at, std::string_view text) {
    const T value = Line::to_number<T>(text);
    std::memcpy(at, &value, sizeof value);
  }
  static void put_value(const ImageType& type, std::byte* at, std::string_view text) {
    if (type.kind == TypeKind::kStruct || type.kind == TypeKind::kArray) fail("the place is no single value");
    switch (rep_of(type)) {
      case Rep::kBool:
      case Rep::kU8:
        return put_number<std::uint8_t>(at, text);
      case Rep::kI8:
        return put_number<std::int8_t>(at, text);
      case Rep::kI16:
        return put_number<std::int16_t>(at, text);
      case Rep::kU16:
        return put_number<std::uint16_t>(at, text);
      case Rep::kI32:
        return put_number<std::int32_t>(at, text);
      case Rep::kU32:
        return put_number<std::uint32_t>(at, text);
      case Rep::kI64:
        return put_number<std::int64_t>(at, text);
      case Rep::kU64:
        return put_number<std::uint64_t>(at, text);
      case Rep::kF32:
        return put_number<float>(at, text);
      case Rep::kF64:
        return put_number<double>(at, text);
      case Rep::kStr:
        return put_string(type, at, text);
      case Rep::kWstr:
        return put_wide(type, at, text);
      case Rep::kRef:
        fail("a reference has no initial value");
    }
  }
  static void put_string(const ImageType& type, std::byte* at, std::string_view text) {
    const auto value = listing::unquoted(text);
    if (!value || value->size() > type.capacity || type.size < 4u + value->size()) fail("the text does not fit");
    const core::StringHeader header{type.capacity, static_cast<std::uint16_t>(value->size())};
    std::memcpy(at, &header, sizeof header);
    std::memcpy(at + sizeof header, value->data(), value->size());
  }
  static void put_wide(const ImageType& type, std::byte* at, std::string_view text) {
    if (text.size() < 3 || text.substr(0, 2) != "w\"" || text.back() != '"') fail("a WSTRING is w\"...\"");
    const std::string_view digits = text.substr(2, text.size() - 3);
    const std::size_t units = digits.size() / 4;
    if (digits.size() % 4 != 0 || units > type.capacity || type.size < 4u + 2 * units) fail("the text does not fit");
    const core::StringHeader header{type.capacity, static_cast<std::uint16_t>(units)};
    std::memcpy(at, &header, sizeof header);
    for (std::size_t i = 0; i < units; ++i) {
      const std::uint16_t unit = hex_number(digits.substr(4 * i, 4));
      std::memcpy(at + sizeof header + 2 * i, &unit, sizeof unit);
    }
  }

  // ---- POUs and tasks

  void take_pou(Line& line) {
    close_pou();
    ImagePou& pou = image_.pous.emplace_back();
    pou.name = line.text();
    pou.kind = line.one_of<PouKind>(listing::kPouKinds);
    line.expect("instance");
    pou.instance_type = line.index('t');
    line.expect("frame");
    pou.frame_type = line.index('t');
    open_table(pou.instance_type, pou.instance_initial);
    open_table(pou.frame_type, pou.frame_initial);
    in_code_ = true;
  }

  void take_queue(Line& line) {
    ImageQueue& queue = image_.queues.emplace_back();
    queue.name = line.text();
    queue.type = line.index('t');
    line.expect("capacity");
    queue.capacity = line.number<std::uint32_t>();
    if (line.accept("takes")) queue.takes = line.number<std::uint32_t>();
    while (line.accept("puts")) queue.puts.push_back(line.number<std::uint32_t>());
  }

  void take_task(Line& line) {
    close_pou();
    ImageTask& task = image_.tasks.emplace_back();
    task.name = line.text();
    line.expect("period");
    task.period_ns = line.number<std::int64_t>();
    line.expect("priority");
    task.priority = line.number<std::int32_t>();
    line.expect("single");
    task.single = line.text();
    line.expect("body");
    task.body = line.index('p');
  }

  void take_in_pou(std::string_view word, Line& line) {
    ImagePou& pou = image_.pous.back();
    if (word == "instance") {
      take_value(pou.instance_type, pou.instance_initial, line);
    } else if (word == "frame") {
      take_value(pou.frame_type, pou.frame_initial, line);
    } else if (word == "wire") {
      ImageWire& wire = pou.wires.emplace_back();
      wire.block = line.number<std::uint32_t>();
      wire.input = line.number<std::uint32_t>();
      wire.source = line.number<std::uint32_t>();
    } else if (word == "port") {
      ImageQueuePort& port = pou.queue_ports.emplace_back();
      port.block = line.number<std::uint32_t>();
      port.port = line.text();
      line.expect("queue");
      port.queue = line.index('q');
      port.takes = line.accept("takes");
    } else if (word == "debug") {
      take_debug(pou, line);
    } else if (word == "word") {
      pou.code.push_back(line.number<std::uint32_t>());
    } else if (word == "|") {
      take_record(pou, line);
    } else if (word.back() == ':') {
      const auto at = static_cast<std::uint32_t>(pou.code.size());
      if (!labels_.emplace(std::string(word.substr(0, word.size() - 1)), at).second)
        fail(fmt::format("{} is there twice", word));
    } else {
      take_instruction(pou, word, line);
    }
  }

  static void take_debug(ImagePou& pou, Line& line) {
    DebugEntry entry;
    entry.word = line.number<std::uint32_t>();
    line.expect("file");
    entry.at.file = line.number<std::uint16_t>();
    line.expect("line");
    entry.at.line = line.number<std::uint32_t>();
    line.expect("column");
    entry.at.column = line.number<std::uint32_t>();
    line.expect("id");
    entry.at.local_id = line.number<std::int64_t>();
    line.expect("kind");
    const auto kind = line.number<std::uint8_t>();
    if (kind > static_cast<std::uint8_t>(core::kLastElementKind)) fail(fmt::format("element kind {}", kind));
    entry.at.kind = static_cast<core::ElementKind>(kind);
    pou.debug.push_back(entry);
  }

  void take_instruction(ImagePou& pou, std::string_view mnemonic, Line& line) {
    const auto found = mnemonics().find(mnemonic);
    if (found == mnemonics().end()) fail(fmt::format("\"{}\" is no instruction", mnemonic));
    const std::size_t at = pou.code.size();
    pou.code.push_back(opcode_word(found->second));
    const Operands& operands = info(found->second).operands;
    records_at_ = kNoRecords;
    for (std::uint8_t i = 0; i < operands.count; ++i) {
      const OperandKind kind = operands.specs[i].kind;
      switch (kind) {
        case OperandKind::kRecords:
          records_at_ = at;
          break;
        case OperandKind::kStdArgs:
          for (; !line.empty(); add_item(pou, at)) pou.code.push_back(place(pou, line.word()));
          break;
        case OperandKind::kPath:
          for (; !line.empty(); add_item(pou, at)) take_step(pou, line.word());
          break;
        case OperandKind::kFnArgs:
          for (; !line.empty(); add_item(pou, at)) {
            const std::string_view pair = line.word();
            const std::size_t sign = pair.find('=');
            if (sign == std::string_view::npos) fail(fmt::format("\"{}\" where <variable>=<operand> belongs", pair));
            pou.code.push_back(Line::to_number<std::uint32_t>(pair.substr(0, sign)));
            pou.code.push_back(place(pou, pair.substr(sign + 1)));
          }
          break;
        default:
          pou.code.push_back(operand(pou, kind, line));
          break;
      }
    }
  }
  /// ".3" a field, "[3]" an element, "[f:i]" an element whose index is in a leaf.
  void take_step(ImagePou& pou, std::string_view text) {
    const bool element = text.size() > 2 && text.front() == '[' && text.back() == ']';
    if (!element && (text.size() < 2 || text.front() != '.')) fail(fmt::format("\"{}\" is no step of a path", text));
    const std::string_view inside = text.substr(1, text.size() - (element ? 2 : 1));
    const bool number = inside.front() >= '0' && inside.front() <= '9';
    const PathStep step = !element ? PathStep::kField : number ? PathStep::kElement : PathStep::kIndex;
    pou.code.push_back(static_cast<std::uint32_t>(step));
    pou.code.push_back(step == PathStep::kIndex ? place(pou, inside) : Line::to_number<std::uint32_t>(inside));
  }
  static void add_item(ImagePou& pou, std::size_t at) {
    if (pou.code[at] >> 16 == kMaxListItems) fail("the list is too long for one instruction");
    pou.code[at] += 1u << 16;
  }

  void take_record(ImagePou& pou, Line& line) {
    if (records_at_ == kNoRecords) fail("a record without BOOL_RUN");
    pou.code.push_back(line.number<std::uint32_t>());
    for (std::size_t i = 1; i < kRecordWords; ++i) pou.code.push_back(place(pou, line.word()));
    add_item(pou, records_at_);
  }

  std::uint32_t operand(ImagePou& pou, OperandKind kind, Line& line) {
    switch (kind) {
      case OperandKind::kTarget: {
        const std::string_view label = line.word();
        if (label.front() == '@') return Line::to_number<std::uint32_t>(label.substr(1));
        jumps_.push_back({pou.code.size(), std::string(label), line_});
        return 0;
      }
      case OperandKind::kType:
        return line.index('t');
      case OperandKind::kPou:
        return line.index('p');
      case OperandKind::kBlock:
        return line.index('b');
      case OperandKind::kFunction:
        return line.index('s');
      case OperandKind::kQueue:
        return line.index('q');
      case OperandKind::kGlobal:
      case OperandKind::kCount:
      case OperandKind::kImm:
        return line.number<std::uint32_t>();
      default:
        return place(pou, line.word());
    }
  }

  /// "g:path" or "g+offset".
  std::uint32_t place(const ImagePou& pou, std::string_view text) {
    const auto letter = std::find(listing::kSpaces.begin(), listing::kSpaces.end(), text.empty() ? '\0' : text[0]);
    if (letter == listing::kSpaces.end() || text.size() < 3) fail(fmt::format("\"{}\" is no operand", text));
    const auto space = static_cast<Space>(letter - listing::kSpaces.begin());
    std::uint32_t offset = 0;
    if (text[1] == '+') {
      offset = Line::to_number<std::uint32_t>(text.substr(2));
    } else {
      const std::uint32_t roots[] = {image_.global_type, pou.instance_type, pou.frame_type, image_.const_type};
      const auto found = names_.find(roots[static_cast<std::size_t>(space)], text.substr(2));
      if (text[1] != ':' || !found) fail(fmt::format("\"{}\" names nothing", text));
      offset = found->offset;
    }
    if (offset > kMaxTableBytes) fail(fmt::format("\"{}\" lies outside every table", text));
    return operand_word(space, offset);
  }

  void close_pou() {
    for (const Jump& jump : jumps_) {
      const auto label = labels_.find(jump.label);
      if (label == labels_.end()) {
        line_ = jump.line;
        fail(fmt::format("label \"{}\" does not exist", jump.label));
      }
      image_.pous.back().code[jump.word] = label->second;
    }
    jumps_.clear();
    labels_.clear();
    records_at_ = kNoRecords;
    in_code_ = false;
  }

  static constexpr std::size_t kNoRecords = ~std::size_t{0};
  struct Jump {
    std::size_t word;
    std::string label;
    std::size_t line;
  };

  Image image_;
  std::vector<std::byte> probes_;  // as "probes" lines have them
  listing::Names names_;
  std::size_t line_ = 0;
  std::uint32_t table_type_ = 0;
  std::vector<std::byte>* table_bytes_ = nullptr;  // what "init" lines fill
  bool in_code_ = false;
  std::size_t records_at_ = kNoRecords;  // the BOOL_RUN that takes the next record
  std::unordered_map<std::string, std::uint32_t> labels_;
  std::vector<Jump> jumps_;
};

}  // namespace

core::Result<Image> assemble(std::string_view text) {
  Assembler assembler;
  try {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      assembler.take(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    return assembler.finish();
  } catch (const Mistake& mistake) {
    // WHY this code: assembler text is written by disassemble() and by tests, never by a user.
    return Problem{Code::P9001, fmt::format("line {}: {}", assembler.line(), mistake.what),
                   "docs/reference/assembler.md describes the text form"};
  }
}

}  // namespace plc::bytecode
