// Mutations of images that mostly keep them valid: a fuzzer that only breaks images never comes past the verifier.
//
// In: an image and random numbers. Out: the image with one change. Gentle changes keep the rules (another leaf of the
// same representation, another value, another truth table, an instruction twice); rough ones overwrite any number of
// the structure. Does not belong here: files, checksums.
#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "bytecode/image.h"
#include "tests/support/sample_image.h"

namespace plc::test {

class ImageMutator {
 public:
  ImageMutator(Image& image, std::uint32_t seed) : image_(image), random_(seed) {}

  void gentle() {
    if (image_.pous.empty() || image_.types.empty()) return;
    switch (below(8)) {
      case 0:
      case 1:
        return change_value();
      case 2:
        return change_truth_table();
      case 3:
        return double_instruction();
      case 4:
        return change_opcode();
      case 5:
        return drop_instruction();
      default:
        return change_operand();
    }
  }

  void rough() {
    if (image_.pous.empty() || image_.types.empty()) return;
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    ImageType& type = image_.types[below(image_.types.size())];
    switch (below(22)) {
      case 14:
        return rough_library();
      case 15:
        if (!image_.tasks.empty()) image_.tasks[below(image_.tasks.size())].single = below(2) == 0 ? "level" : "go";
        return;
      case 16:
        if (!image_.tasks.empty()) image_.tasks[below(image_.tasks.size())].period_ns = -1;
        return;
      case 17:
        if (!image_.globals.empty()) image_.globals.pop_back();
        return;
      case 18:
        if (!pou.debug.empty()) pou.debug[below(pou.debug.size())].word = word();
        return;
      case 19:
        type.lower = static_cast<std::int64_t>(word());
        return;
      case 20:
      case 21:
        return rough_list(pou);
      case 0:
        if (!pou.code.empty()) pou.code[below(pou.code.size())] = word();
        return;
      case 1:
        if (!pou.code.empty()) pou.code[below(pou.code.size())] ^= 1u << below(32);
        return;
      case 2:
        if (!pou.code.empty()) pou.code.resize(below(pou.code.size()) + 1);
        return;
      case 3:
        type.size = word();
        return;
      case 4:
        type.element = word();
        return;
      case 5:
        type.count = word();
        return;
      case 6:
        type.kind = static_cast<TypeKind>(below(5));
        return;
      case 7:
        type.elementary = static_cast<TypeId>(below(core::kTypeCount));
        return;
      case 8:
        if (!type.fields.empty()) type.fields[below(type.fields.size())].offset = word();
        return;
      case 9:
        if (!type.fields.empty()) type.fields[below(type.fields.size())].type = word();
        return;
      case 10:
        if (!pou.instance_initial.empty()) pou.instance_initial[below(pou.instance_initial.size())] = byte();
        return;
      case 11:
        if (!image_.global_initial.empty()) image_.global_initial[below(image_.global_initial.size())] = byte();
        return;
      case 12:
        (below(2) == 0 ? pou.instance_type : pou.frame_type) = static_cast<Word>(below(image_.types.size() + 1));
        return;
      default:
        pou.kind = static_cast<PouKind>(below(4));
        return;
    }
  }

  std::size_t below(std::size_t n) { return random_() % n; }

 private:
  void rough_library() {
    if (!image_.blocks.empty()) {
      bytecode::ImageBlock& block = image_.blocks[below(image_.blocks.size())];
      if (below(3) == 0) block.name = "NOPE";
      if (below(3) == 0) block.layout_hash ^= 1;
      if (below(3) == 0) block.type = word();
    }
    if (!image_.functions.empty() && below(2) == 0) {
      image_.functions[below(image_.functions.size())] = below(2) == 0 ? "NOPE:INT" : "LIMIT:INT";
    }
  }

  /// One item more or less in a list.
  void rough_list(ImagePou& pou) {
    const std::vector<std::size_t> starts = starts_of(pou);
    std::vector<std::size_t> lists;
    for (const std::size_t at : starts) {
      if (pou.code[at] >> 16 != 0) lists.push_back(at);
    }
    if (lists.empty()) return;
    const std::size_t at = lists[below(lists.size())];
    const auto end = static_cast<std::ptrdiff_t>(at + length_of(pou, at));
    if (below(2) == 0) {
      pou.code[at] += 1u << 16;
      pou.code.insert(pou.code.begin() + end, pou.code[static_cast<std::size_t>(end) - 1]);
    } else {
      pou.code[at] -= 1u << 16;
      pou.code.erase(pou.code.begin() + end - 1);
    }
  }

  struct Leaf {
    Word word;
    core::Rep rep;
    std::uint32_t type;
  };

  std::byte byte() { return static_cast<std::byte>(random_()); }
  Word word() {
    switch (below(4)) {
      case 0:
        return static_cast<Word>(random_());
      case 1:
        return static_cast<Word>(below(300));
      case 2:
        return static_cast<Word>(0u - below(5));
      default:
        return bytecode::operand_word(static_cast<Space>(below(4)), static_cast<Word>(below(100)));
    }
  }

  void collect(std::uint32_t type, Space space, std::uint32_t offset, std::vector<Leaf>& leaves,
               unsigned depth = 0) const {
    if (type >= image_.types.size() || leaves.size() > 2000 || depth > 20) return;
    const ImageType& t = image_.types[type];
    if (t.kind == TypeKind::kStruct) {
      for (const ImageField& f : t.fields) collect(f.type, space, offset + f.offset, leaves, depth + 1);
    } else if (t.kind == TypeKind::kArray) {
      if (t.element >= image_.types.size()) return;
      for (std::uint32_t i = 0; i < t.count && i < 20; ++i) {
        collect(t.element, space, offset + i * image_.types[t.element].size, leaves, depth + 1);
      }
    } else if (offset <= bytecode::kMaxTableBytes) {
      leaves.push_back({bytecode::operand_word(space, offset), bytecode::rep_of(t), type});
    }
  }
  std::vector<Leaf> leaves_of(const ImagePou& pou) const {
    std::vector<Leaf> leaves;
    collect(image_.global_type, Space::kGlobal, 0, leaves);
    collect(pou.instance_type, Space::kInstance, 0, leaves);
    collect(pou.frame_type, Space::kFrame, 0, leaves);
    collect(image_.const_type, Space::kConst, 0, leaves);
    return leaves;
  }

  /// Starts of the whole instructions, as far as they can be followed.
  static std::vector<std::size_t> starts_of(const ImagePou& pou) {
    std::vector<std::size_t> starts;
    for (std::size_t at = 0; at < pou.code.size();) {
      const std::uint32_t opcode = pou.code[at] & 0xffffu;
      if (opcode >= bytecode::opcodes().size()) break;
      starts.push_back(at);
      at += length_of(pou, at);
    }
    if (!starts.empty() && starts.back() + length_of(pou, starts.back()) > pou.code.size()) starts.pop_back();
    return starts;
  }
  static std::size_t length_of(const ImagePou& pou, std::size_t at) {
    const bytecode::Operands& operands = bytecode::opcodes()[pou.code[at] & 0xffffu].operands;
    const std::size_t items = pou.code[at] >> 16;
    std::size_t length = 1;
    for (std::uint8_t i = 0; i < operands.count; ++i) {
      const bytecode::OperandKind kind = operands.specs[i].kind;
      length += kind == bytecode::OperandKind::kRecords   ? items * bytecode::kRecordWords
                : kind == bytecode::OperandKind::kStdArgs ? items
                : kind == bytecode::OperandKind::kFnArgs  ? items * 2
                                                          : 1;
    }
    return length;
  }

  /// Another leaf of the representation that the old one has.
  void change_leaf(ImagePou& pou, Word& old) {
    const std::vector<Leaf> leaves = leaves_of(pou);
    std::vector<Word> fitting;
    for (const Leaf& leaf : leaves) {
      if (leaf.word != old) continue;
      for (const Leaf& other : leaves) {
        if (other.rep == leaf.rep) fitting.push_back(other.word);
      }
    }
    if (!fitting.empty()) old = fitting[below(fitting.size())];
  }

  void change_operand() {
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    const std::vector<std::size_t> starts = starts_of(pou);
    if (starts.empty()) return;
    const std::size_t at = starts[below(starts.size())];
    const std::size_t length = length_of(pou, at);
    if (length > 1) change_leaf(pou, pou.code[at + 1 + below(length - 1)]);
  }

  void change_truth_table() {
    for (ImagePou& pou : image_.pous) {
      for (const std::size_t at : starts_of(pou)) {
        if ((pou.code[at] & 0xffffu) != static_cast<Word>(Opcode::kBoolRun) || pou.code[at] >> 16 == 0) continue;
        if (below(3) == 0)
          pou.code[at + 1 + bytecode::kRecordWords * below(pou.code[at] >> 16)] = static_cast<Word>(random_());
      }
    }
  }

  /// Another instruction with the same operands.
  void change_opcode() {
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    const std::vector<std::size_t> starts = starts_of(pou);
    if (starts.empty()) return;
    Word& code = pou.code[starts[below(starts.size())]];
    const auto same = [](const bytecode::Operands& a, const bytecode::Operands& b) {
      if (a.count != b.count) return false;
      for (std::uint8_t i = 0; i < a.count; ++i) {
        if (a.specs[i].kind != b.specs[i].kind || a.specs[i].reps != b.specs[i].reps) return false;
      }
      return true;
    };
    std::vector<Word> fitting;
    for (Word other = 1; other < bytecode::opcodes().size(); ++other) {
      if (same(bytecode::opcodes()[other].operands, bytecode::opcodes()[code & 0xffffu].operands))
        fitting.push_back(other);
    }
    if (!fitting.empty()) code = (code & 0xffff0000u) | fitting[below(fitting.size())];
  }

  void move_targets(ImagePou& pou, std::size_t from, std::ptrdiff_t by) {
    for (const std::size_t at : starts_of(pou)) {
      const bytecode::Operands& operands = bytecode::opcodes()[pou.code[at] & 0xffffu].operands;
      for (std::uint8_t i = 0; i < operands.count; ++i) {
        if (operands.specs[i].kind != bytecode::OperandKind::kTarget) continue;
        Word& target = pou.code[at + 1 + i];
        if (target > from) target = static_cast<Word>(target + static_cast<Word>(by));
      }
    }
    pou.debug.clear();
  }

  void double_instruction() {
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    const std::vector<std::size_t> starts = starts_of(pou);
    if (starts.empty() || pou.code.size() > 2000) return;
    const std::size_t at = starts[below(starts.size())];
    const std::size_t length = length_of(pou, at);
    const std::vector<Word> copy(pou.code.begin() + static_cast<std::ptrdiff_t>(at),
                                 pou.code.begin() + static_cast<std::ptrdiff_t>(at + length));
    move_targets(pou, at, static_cast<std::ptrdiff_t>(length));
    pou.code.insert(pou.code.begin() + static_cast<std::ptrdiff_t>(at), copy.begin(), copy.end());
  }

  void drop_instruction() {
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    const std::vector<std::size_t> starts = starts_of(pou);
    if (starts.size() < 2) return;
    const std::size_t at = starts[below(starts.size() - 1)];
    const std::size_t length = length_of(pou, at);
    move_targets(pou, at, -static_cast<std::ptrdiff_t>(length));
    pou.code.erase(pou.code.begin() + static_cast<std::ptrdiff_t>(at),
                   pou.code.begin() + static_cast<std::ptrdiff_t>(at + length));
  }

  void change_value() {
    ImagePou& pou = image_.pous[below(image_.pous.size())];
    const std::vector<Leaf> leaves = leaves_of(pou);
    if (leaves.empty()) return;
    const Leaf& leaf = leaves[below(leaves.size())];
    std::vector<std::byte>* const tables[] = {&image_.global_initial, &pou.instance_initial, &pou.frame_initial,
                                              &image_.const_bytes};
    std::vector<std::byte>& table = *tables[static_cast<std::size_t>(bytecode::space_of(leaf.word))];
    const std::size_t at = bytecode::offset_of(leaf.word);
    const ImageType& type = image_.types[leaf.type];
    if (type.kind != TypeKind::kScalar || type.size == 0 || at + type.size > table.size()) return;
    constexpr std::int64_t kEdges[] = {0, 1, -1, INT64_MAX, INT64_MIN, INT32_MIN, INT16_MIN, 127, -128};
    std::int64_t value = below(2) == 0 ? kEdges[below(std::size(kEdges))] : static_cast<std::int64_t>(random_());
    if (leaf.rep == core::Rep::kBool) value &= 1;
    if (type.limited) value = type.lower;
    if (leaf.rep == core::Rep::kF32 || leaf.rep == core::Rep::kF64) value &= 0x3fffffff;  // no NaN
    std::memcpy(table.data() + at, &value, std::min<std::size_t>(type.size, sizeof value));
  }

  Image& image_;
  std::mt19937 random_;
};

}  // namespace plc::test
