// ImageBuilder: images for tests, made by hand. Tables grow field by field, and every field added returns the operand
// word that names it, so instructions can be written at once.
//
// Out: an Image that verify() accepts unless the test asked for something wrong. Does not belong here: code generation.
//
//   ImageBuilder b;
//   const auto x = b.global("x", b.type(TypeId::kInt));
//   const auto one = b.constant<std::int16_t>(TypeId::kInt, 1);
//   PouBuilder main = b.pou("Main", PouKind::kProgram);
//   main.op(Opcode::kAdd16, {x, x, one});
//   b.task("T", 20'000'000, {main.finish()});
//   Image image = b.build();
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "stdlib/library.h"

namespace plc::test {

using bytecode::FieldRole;
using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImagePou;
using bytecode::ImageType;
using bytecode::Opcode;
using bytecode::PathStep;
using bytecode::PouKind;
using bytecode::Space;
using bytecode::TypeKind;
using core::TypeId;

/// Operand word of a field.
using Word = std::uint32_t;

/// A structure that grows, with its initial bytes.
struct GrowingStruct {
  ImageType type;
  std::vector<std::byte> bytes;

  GrowingStruct() { type.kind = TypeKind::kStruct; }
  /// Appends a field; returns its offset.
  std::uint32_t add(const Image& image, std::string name, std::uint32_t field_type, FieldRole role,
                    const std::vector<std::byte>& initial, bool constant = false) {
    const ImageType& t = image.types[field_type];
    const std::uint32_t offset = (type.size + t.align - 1) / t.align * t.align;
    ImageField field;
    field.name = std::move(name);
    field.type = field_type;
    field.offset = offset;
    field.role = role;
    field.constant = constant;
    type.fields.push_back(std::move(field));
    type.size = offset + t.size;
    type.align = std::max(type.align, t.align);
    bytes.resize(type.size);
    if (!initial.empty()) std::memcpy(bytes.data() + offset, initial.data(), initial.size());
    return offset;
  }
  /// Rounds the size up to the alignment.
  void close() {
    type.size = (type.size + type.align - 1) / type.align * type.align;
    bytes.resize(type.size);
  }
};

template <class T>
std::vector<std::byte> bytes_of(const T& value) {
  std::vector<std::byte> bytes(sizeof(T));
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

class ImageBuilder;

/// One POU under construction. finish() appends it to the image.
class PouBuilder {
 public:
  /// A variable of the instance; `initial` empty = the type's default.
  Word variable(std::string name, std::uint32_t type, FieldRole role = FieldRole::kLocal,
                std::vector<std::byte> initial = {});
  /// A variable of the frame. For functions its index among the frame's variables is what CALL_FN lists.
  Word frame(std::string name, std::uint32_t type, FieldRole role = FieldRole::kTemp,
             std::vector<std::byte> initial = {});
  /// An instance of FB or program `pou` as a variable.
  Word instance_of(std::string name, std::uint32_t pou);

  /// A name for global number `global` (in the order of ImageBuilder::global) below the instances of this POU.
  void alias(std::string name, std::uint32_t global) {
    instance_struct.type.aliases.push_back({std::move(name), global});
  }

  /// Appends an instruction: its operand words.
  PouBuilder& op(Opcode opcode, std::initializer_list<Word> words = {}) { return list(opcode, 0, words); }
  /// Appends an instruction with a list of `items` items; `words` holds the plain operands, then the list's words.
  PouBuilder& list(Opcode opcode, std::uint32_t items, std::vector<Word> words) {
    code.push_back(bytecode::opcode_word(opcode, items));
    code.insert(code.end(), words.begin(), words.end());
    return *this;
  }
  struct Step {
    PathStep step;
    Word number;  ///< a field, an element from 0, or the leaf of an index
  };
  /// Appends an instruction with a path.
  PouBuilder& path(Opcode opcode, std::vector<Word> words, const std::vector<Step>& steps) {
    for (const Step& s : steps) words.insert(words.end(), {static_cast<Word>(s.step), s.number});
    return list(opcode, static_cast<std::uint32_t>(steps.size()), std::move(words));
  }
  /// One BOOL_RUN record; unused inputs repeat the first.
  PouBuilder& record(std::uint32_t table, Word out, std::vector<Word> in) {
    std::vector<Word> words{table, out};
    for (std::size_t i = 0; i < 5; ++i) words.push_back(i < in.size() ? in[i] : in[0]);
    return list(Opcode::kBoolRun, 1, words);
  }
  /// CALL_STD of the library function with this key ("ADD:DINT").
  PouBuilder& call_std(std::string_view key, Word result, std::vector<Word> args);

  /// The word index of the next instruction, as the target of a LOOP_JUMP.
  [[nodiscard]] std::uint32_t here() const { return static_cast<std::uint32_t>(code.size()); }
  /// Appends a forward jump (`words` come before the target); returns what land() takes.
  std::uint32_t jump(Opcode opcode, std::initializer_list<Word> words = {}) {
    op(opcode, words);
    code.push_back(0);
    return here() - 1;
  }
  /// The forward jump goes here.
  void land(std::uint32_t jump) { code[jump] = here(); }
  /// Adds RETURN (unless told not to), appends the POU to the image, returns its index.
  std::uint32_t finish(bool with_return = true);

  std::vector<std::uint32_t> code;
  GrowingStruct instance_struct;
  GrowingStruct frame_struct;

 private:
  friend class ImageBuilder;
  PouBuilder(ImageBuilder& owner, std::string name, PouKind kind)
      : owner_(owner), name_(std::move(name)), kind_(kind) {}
  ImageBuilder& owner_;
  std::string name_;
  PouKind kind_;
};

class ImageBuilder {
 public:
  Image image;

  ImageBuilder() {
    image.project = "test";
    image.product = "PICARD test";
  }

  /// Type index of an elementary type (one per TypeId).
  std::uint32_t type(TypeId id) {
    for (std::uint32_t i = 0; i < image.types.size(); ++i) {
      const ImageType& t = image.types[i];
      if (t.kind == TypeKind::kScalar && t.elementary == id && !t.limited && t.name.empty()) return i;
    }
    ImageType t;
    t.elementary = id;
    t.size = t.align = core::rep_bytes(core::rep_of(id));
    return add_type(std::move(t));
  }
  std::uint32_t boolean() { return type(TypeId::kBool); }
  /// STRING[capacity] or WSTRING[capacity].
  std::uint32_t string(std::uint16_t capacity, TypeId id = TypeId::kString) {
    ImageType t;
    t.kind = TypeKind::kString;
    t.elementary = id;
    t.capacity = capacity;
    t.align = 2;
    t.size = (4u + capacity * (id == TypeId::kWstring ? 2u : 1u) + 1u) / 2u * 2u;
    return add_type(std::move(t));
  }
  std::uint32_t array(std::uint32_t element, std::uint32_t count, std::int64_t lower = 0) {
    ImageType t;
    t.kind = TypeKind::kArray;
    t.element = element;
    t.count = count;
    t.lower = lower;
    t.align = image.types[element].align;
    t.size = image.types[element].size * count;
    return add_type(std::move(t));
  }
  std::uint32_t ref(std::uint32_t target) {
    ImageType t;
    t.kind = TypeKind::kRef;
    t.element = target;
    t.size = t.align = 8;
    return add_type(std::move(t));
  }
  /// A subrange or (with members) an enumeration.
  std::uint32_t limited(TypeId base, std::int64_t lower, std::int64_t upper, std::string name = {}) {
    ImageType t;
    t.elementary = base;
    t.size = t.align = core::rep_bytes(core::rep_of(base));
    t.limited = true;
    t.lower = lower;
    t.upper = upper;
    t.name = std::move(name);
    return add_type(std::move(t));
  }
  struct NamedField {
    std::string name;
    std::uint32_t type;
  };
  std::uint32_t structure(std::string name, std::initializer_list<NamedField> fields) {
    GrowingStruct s;
    for (const NamedField& f : fields) s.add(image, f.name, f.type, FieldRole::kMember, {});
    s.close();
    s.type.name = std::move(name);
    return add_type(std::move(s.type));
  }
  /// The port structure of a standard block; makes the entry in Image::blocks. One entry per name.
  std::uint32_t block_type(std::string_view name) { return image.blocks[block(name)].type; }
  /// Index in Image::blocks of a standard block.
  std::uint32_t block(std::string_view name) {
    const stdlib::BlockSpec* spec = stdlib::block_named(name);
    for (std::uint32_t i = 0; i < image.blocks.size(); ++i) {
      if (image.blocks[i].name == spec->name) return i;
    }
    ImageType t;
    t.kind = TypeKind::kStruct;
    t.name = spec->name;
    t.size = spec->size;
    t.align = spec->align;
    for (const stdlib::Field& f : spec->fields) {
      ImageField field;
      field.name = f.name;
      field.type = f.type == TypeId::kString ? string(core::kDefaultStringCapacity) : type(f.type);
      field.offset = f.offset;
      field.role = f.direction == stdlib::Direction::kInput    ? FieldRole::kInput
                   : f.direction == stdlib::Direction::kOutput ? FieldRole::kOutput
                   : f.direction == stdlib::Direction::kInOut  ? FieldRole::kInOut
                                                               : FieldRole::kState;
      t.fields.push_back(std::move(field));
    }
    // Specifications list ports by pin order, images by offset.
    std::sort(t.fields.begin(), t.fields.end(),
              [](const ImageField& x, const ImageField& y) { return x.offset < y.offset; });
    bytecode::ImageBlock entry;
    entry.name = spec->name;
    entry.layout_hash = stdlib::layout_hash(*spec);
    entry.type = add_type(std::move(t));
    image.blocks.push_back(std::move(entry));
    return static_cast<std::uint32_t>(image.blocks.size() - 1);
  }
  /// Index in Image::functions of a library function.
  std::uint32_t function(std::string_view key) {
    for (std::uint32_t i = 0; i < image.functions.size(); ++i) {
      if (image.functions[i] == key) return i;
    }
    image.functions.emplace_back(key);
    return static_cast<std::uint32_t>(image.functions.size() - 1);
  }

  /// Initial bytes of a fresh value: zeros, string capacities in place, block ports as their specification says.
  std::vector<std::byte> fresh(std::uint32_t type_index) const {
    const ImageType& t = image.types[type_index];
    std::vector<std::byte> bytes(t.size);
    for (const ImagePou& p : image.pous) {
      if (p.instance_type == type_index) return p.instance_initial;
    }
    for (const bytecode::ImageBlock& b : image.blocks) {
      const stdlib::BlockSpec* spec = b.type == type_index ? stdlib::block_named(b.name) : nullptr;
      if (spec != nullptr && spec->initial != nullptr) {
        std::memcpy(bytes.data(), spec->initial, spec->size);
        return bytes;
      }
    }
    switch (t.kind) {
      case TypeKind::kScalar:
        if (t.limited && (t.lower > 0 || t.upper < 0)) std::memcpy(bytes.data(), &t.lower, t.size);
        break;
      case TypeKind::kString:
        std::memcpy(bytes.data(), &t.capacity, 2);
        break;
      case TypeKind::kArray: {
        const std::vector<std::byte> element = fresh(t.element);
        for (std::uint32_t i = 0; i < t.count && !element.empty(); ++i) {
          std::memcpy(bytes.data() + i * element.size(), element.data(), element.size());
        }
        break;
      }
      case TypeKind::kStruct:
        for (const ImageField& f : t.fields) {
          const std::vector<std::byte> field = fresh(f.type);
          if (!field.empty()) std::memcpy(bytes.data() + f.offset, field.data(), field.size());
        }
        break;
      case TypeKind::kRef:
        break;
    }
    return bytes;
  }

  struct GlobalOptions {
    bool constant = false;
    bool input = false;  ///< no task exports it
    std::string list{};
    std::string address{};
    std::optional<std::uint32_t> owner{};  ///< the only task that exports it; otherwise all do
  };
  /// A global variable; `initial` empty = default. Returns its operand word.
  Word global(std::string name, std::uint32_t type_index, std::vector<std::byte> initial = {}) {
    return global(std::move(name), type_index, std::move(initial), GlobalOptions{});
  }
  Word global(std::string name, std::uint32_t type_index, std::vector<std::byte> initial, GlobalOptions options) {
    if (initial.empty()) initial = fresh(type_index);
    bytecode::ImageGlobal entry;
    entry.list = std::move(options.list);
    entry.address = std::move(options.address);
    image.globals.push_back(std::move(entry));
    exported_.push_back(!options.constant && !options.input);
    owner_.push_back(options.owner);
    return bytecode::operand_word(Space::kGlobal, globals_.add(image, std::move(name), type_index, FieldRole::kMember,
                                                               initial, options.constant));
  }
  /// A constant; returns its operand word.
  template <class T>
  Word constant(TypeId id, T value) {
    return constant_bytes(type(id), bytes_of(value));
  }
  Word constant_bytes(std::uint32_t type_index, std::vector<std::byte> value) {
    return bytecode::operand_word(
        Space::kConst, constants_.add(image, "c#" + std::to_string(constants_.type.fields.size()), type_index,
                                      FieldRole::kHidden, value, true));
  }
  /// A STRING constant of exactly the text's length.
  Word text(std::string_view value) {
    const std::uint32_t t = string(static_cast<std::uint16_t>(value.size()));
    std::vector<std::byte> bytes(image.types[t].size);
    const core::StringHeader header{static_cast<std::uint16_t>(value.size()), static_cast<std::uint16_t>(value.size())};
    std::memcpy(bytes.data(), &header, sizeof header);
    if (!value.empty()) std::memcpy(bytes.data() + sizeof header, value.data(), value.size());
    return constant_bytes(t, std::move(bytes));
  }

  PouBuilder pou(std::string name, PouKind kind) { return {*this, std::move(name), kind}; }

  /// A task that runs an instance of each program or function block: reads all globals, calls, writes all globals that
  /// are not constants or inputs. The body is made by build().
  void task(std::string name, std::int64_t period_ns, std::vector<std::uint32_t> programs, std::int32_t priority = 0,
            std::string single = {}) {
    tasks_.push_back({std::move(name), period_ns, std::move(programs), priority, std::move(single)});
  }

  /// Completes the tables and the task bodies.
  Image build() {
    globals_.close();
    constants_.close();
    globals_.type.name = "globals";
    constants_.type.name = "constants";
    image.global_type = add_type(globals_.type);
    image.global_initial = globals_.bytes;
    image.const_type = add_type(constants_.type);
    image.const_bytes = constants_.bytes;
    for (std::size_t i = 0; i < exported_.size(); ++i) {
      const auto all = static_cast<std::uint32_t>(tasks_.size());
      image.globals[i].writers = !exported_[i] ? 0 : owner_[i] ? 1 : all;
    }
    std::uint32_t index = 0;
    for (const PendingTask& t : tasks_) {
      PouBuilder body = pou(t.name, PouKind::kTask);
      const auto count = static_cast<std::uint32_t>(exported_.size());
      if (count != 0) hold_others_off(body, count);
      if (count != 0) body.op(Opcode::kReadN, {0, count});
      if (count != 0) let_others_on(body);
      for (std::size_t i = 0; i < t.programs.size(); ++i) {
        const Word at = body.instance_of(image.pous[t.programs[i]].name + std::to_string(i), t.programs[i]);
        body.op(Opcode::kCallPou, {t.programs[i], at});
      }
      if (count != 0) hold_others_off(body, count);
      for (const bool alone : {true, false}) {
        const auto exports = [&](std::uint32_t f) {
          const bool mine = exported_[f] && owner_[f].value_or(index) == index;
          return mine && (image.globals[f].writers == 1) == alone;
        };
        for (std::uint32_t first = 0; first < count;) {
          std::uint32_t last = first;
          while (last < count && exports(last)) ++last;
          if (last > first) body.op(alone ? Opcode::kWriteN : Opcode::kWriteChangedN, {first, last - first});
          first = std::max(last, first + 1);
        }
      }
      if (count != 0) let_others_on(body);
      ++index;
      bytecode::ImageTask entry;
      entry.name = t.name;
      entry.period_ns = t.period_ns;
      entry.priority = t.priority;
      entry.single = t.single;
      entry.body = body.finish();
      image.tasks.push_back(std::move(entry));
    }
    return image;
  }

  std::uint32_t add_type(ImageType type) {
    image.types.push_back(std::move(type));
    return static_cast<std::uint32_t>(image.types.size() - 1);
  }

 private:
  /// Bounds of an exchange, as the protocol of image.options has them.
  void hold_others_off(PouBuilder& body, std::uint32_t globals) {
    if (image.options.coherence == core::Coherence::kGlobalLock) body.op(Opcode::kLock, {});
    if (image.options.coherence == core::Coherence::kPriorityCeiling) body.op(Opcode::kRaisePriority, {0, globals});
  }
  void let_others_on(PouBuilder& body) {
    if (image.options.coherence == core::Coherence::kGlobalLock) body.op(Opcode::kUnlock, {});
    if (image.options.coherence == core::Coherence::kPriorityCeiling) body.op(Opcode::kReschedule, {});
  }

  struct PendingTask {
    std::string name;
    std::int64_t period_ns;
    std::vector<std::uint32_t> programs;
    std::int32_t priority;
    std::string single;
  };
  GrowingStruct globals_;
  GrowingStruct constants_;
  std::vector<bool> exported_;
  std::vector<std::optional<std::uint32_t>> owner_;
  std::vector<PendingTask> tasks_;
};

inline Word PouBuilder::variable(std::string name, std::uint32_t type, FieldRole role, std::vector<std::byte> initial) {
  if (initial.empty()) initial = owner_.fresh(type);
  return bytecode::operand_word(Space::kInstance,
                                instance_struct.add(owner_.image, std::move(name), type, role, initial));
}
inline Word PouBuilder::frame(std::string name, std::uint32_t type, FieldRole role, std::vector<std::byte> initial) {
  if (initial.empty()) initial = owner_.fresh(type);
  return bytecode::operand_word(Space::kFrame, frame_struct.add(owner_.image, std::move(name), type, role, initial));
}
inline Word PouBuilder::instance_of(std::string name, std::uint32_t pou) {
  return variable(std::move(name), owner_.image.pous[pou].instance_type, FieldRole::kLocal,
                  owner_.image.pous[pou].instance_initial);
}
inline PouBuilder& PouBuilder::call_std(std::string_view key, Word result, std::vector<Word> args) {
  std::vector<Word> words{owner_.function(key), result};
  words.insert(words.end(), args.begin(), args.end());
  return list(Opcode::kCallStd, static_cast<std::uint32_t>(args.size() + 1), std::move(words));
}
inline std::uint32_t PouBuilder::finish(bool with_return) {
  if (with_return) op(Opcode::kReturn);
  instance_struct.close();
  frame_struct.close();
  instance_struct.type.name = name_;
  frame_struct.type.name = name_ + "#frame";
  ImagePou pou;
  pou.name = name_;
  pou.kind = kind_;
  pou.instance_type = owner_.add_type(instance_struct.type);
  pou.instance_initial = instance_struct.bytes;
  pou.frame_type = owner_.add_type(frame_struct.type);
  pou.frame_initial = frame_struct.bytes;
  pou.code = code;
  owner_.image.pous.push_back(std::move(pou));
  return static_cast<std::uint32_t>(owner_.image.pous.size() - 1);
}

}  // namespace plc::test
