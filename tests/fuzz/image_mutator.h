// Mutations of images that mostly keep them valid: a fuzzer that only breaks images never comes past the verifier.
//
// In: an image and random numbers. Out: the image with one change. Gentle changes keep the rules (another leaf of the
// same representation, another value, another truth table, an instruction twice); rough ones overwrite any number of
// the structure; excesses pass one limit of the verifier that single steps would hardly come to. Does not belong here:
// files, checksums.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "bytecode/image.h"
#include "bytecode/rules.h"
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
    switch (below(32)) {
      case 31:
        return rough_probes();
      case 30:
        if (!image_.drawings.empty()) image_.drawings[below(image_.drawings.size())] = byte();
        return;
      case 29:
        return rough_part(pou);
      case 25:
      case 26:
      case 27:
      case 28:
        return rough_path(pou);
      case 24:
        return rough_alias();
      case 22:
        return rough_value(type);
      case 23:
        return rough_code(pou);
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

  /// Passes one of the limits. Never by little where the amount is work: what is just below the limit would be
  /// accepted, and running it would take minutes.
  void excess() {
    if (image_.pous.empty() || image_.tasks.empty() || image_.types.empty() || is_large()) return;
    switch (below(7)) {
      case 0:
        return nest_types(60 + below(8));
      case 1:
        return refer_to_constant();
      case 2:
        return add_chain(1 + below(4), 1, true);
      case 3:
        return add_chain(66 + below(8), 1, false);
      case 4:
        return add_chain(60, 8, false);
      case 5:
        image_.tasks.resize(bytecode::kMaxTasks + 1 + below(4), image_.tasks[0]);
        return;
      default:
        // Both numbers count: the file is smallest (650 kB) when tasks and variables take about the same room.
        if (below(2) == 0) return;
        enlarge_globals(310'000);
        image_.tasks.resize(14'000, image_.tasks[0]);
        return;
    }
  }

  std::size_t below(std::size_t n) { return random_() % n; }

 private:
  /// A number of a probe map; elsewhere nothing.
  void rough_probes() {
    if (image_.probes.empty()) return;
    bytecode::PouProbes& map = image_.probes[below(image_.probes.size())];
    if (map.steps.empty()) return;
    bytecode::ProbeStep& step = map.steps[below(map.steps.size())];
    Word* const numbers[] = {&step.word, &step.order, &step.a, &step.b, &step.type, &step.when};
    *numbers[below(6)] = below(2) == 0 ? static_cast<Word>(below(40)) : word();
    if (below(8) == 0) step.op = static_cast<bytecode::ProbeOp>(below(8));
    if (below(8) == 0) map.jumps.push_back({static_cast<Word>(below(40)), static_cast<Word>(below(4))});
  }

  /// So large that an excess came before, or nearly.
  bool is_large() const { return image_.pous.size() > 40 || image_.types.size() > 300 || image_.tasks.size() > 40; }

  void nest_types(std::size_t depth) {
    for (std::size_t i = 0; i < depth; ++i) {
      ImageType type;
      type.kind = TypeKind::kArray;
      type.element = static_cast<std::uint32_t>(image_.types.size() - 1);
      type.count = 1;
      type.size = image_.types.back().size;
      type.align = image_.types.back().align;
      image_.types.push_back(std::move(type));
    }
  }

  void enlarge_globals(std::uint32_t bytes) {
    if (image_.global_type >= image_.types.size() || image_.types[image_.global_type].kind != TypeKind::kStruct) return;
    ImageType element;
    element.elementary = TypeId::kUsint;
    element.size = 1;
    ImageType array;
    array.kind = TypeKind::kArray;
    array.element = static_cast<std::uint32_t>(image_.types.size());
    array.count = array.size = bytes;
    // A structure is built from types below it: the table gets a new one.
    ImageType table = image_.types[image_.global_type];
    ImageField field;
    field.name = "large#";
    field.type = array.element + 1;
    field.offset = table.size;
    table.fields.push_back(std::move(field));
    table.size = (table.size + bytes + 63) & ~63u;
    image_.global_type = array.element + 2;
    image_.types.insert(image_.types.end(), {std::move(element), std::move(array)});
    image_.global_initial.resize(table.size);
    image_.types.push_back(std::move(table));
    image_.globals.emplace_back();
  }

  /// Functions that each call the one before `times` times, the last called by a task. Closed, the first calls the
  /// last.
  void add_chain(std::size_t length, std::size_t times, bool closed) {
    const auto nothing = static_cast<std::uint32_t>(image_.types.size());
    image_.types.emplace_back().kind = TypeKind::kStruct;
    const auto first = static_cast<std::uint32_t>(image_.pous.size());
    const auto last = static_cast<std::uint32_t>(first + length - 1);
    for (std::uint32_t i = first; i <= last; ++i) {
      ImagePou f;
      f.name = "chain#";
      f.kind = PouKind::kFunction;
      f.instance_type = f.frame_type = nothing;
      for (std::size_t n = 0; n < times && (i != first || closed); ++n) {
        f.code.insert(f.code.end(), {bytecode::opcode_word(Opcode::kCallFn), i == first ? last : i - 1});
      }
      f.code.push_back(bytecode::opcode_word(Opcode::kReturn));
      image_.pous.push_back(std::move(f));
    }
    const std::uint32_t body = image_.tasks[0].body;
    if (body < first) insert(image_.pous[body], 0, {bytecode::opcode_word(Opcode::kCallFn), last});
  }

  void refer_to_constant() {
    std::vector<Leaf> constants;
    collect(image_.const_type, Space::kConst, 0, constants);
    if (constants.empty()) return;
    const Leaf& constant = constants[below(constants.size())];
    // Any POU will do that has a reference.
    const std::size_t start = below(image_.pous.size());
    for (std::size_t i = 0; i < image_.pous.size(); ++i) {
      ImagePou& pou = image_.pous[(start + i) % image_.pous.size()];
      for (const Leaf& leaf : leaves_of(pou)) {
        if (leaf.rep != core::Rep::kRef) continue;
        return insert(pou, 0, {bytecode::opcode_word(Opcode::kRefAt), leaf.word, constant.word, constant.type});
      }
    }
  }

  /// An alias of any structure that has one: another global, or a name that a field has.
  void rough_alias() {
    for (ImageType& type : image_.types) {
      if (type.aliases.empty() || below(3) == 0) continue;
      if (below(2) == 0) {
        type.aliases.front().global = word();
      } else {
        type.aliases.front().name = type.fields.empty() ? "" : type.fields.front().name;
      }
      return;
    }
  }

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

  /// Names, limits, members, and values that only some types forbid.
  void rough_value(ImageType& any) {
    std::vector<Leaf> leaves, chosen;
    collect(image_.global_type, Space::kGlobal, 0, leaves);
    for (const Leaf& leaf : leaves) {
      const bool real = leaf.rep == core::Rep::kF32 || leaf.rep == core::Rep::kF64;
      if (real || image_.types[leaf.type].limited) chosen.push_back(leaf);
    }
    if (chosen.empty()) return;
    const Leaf& leaf = chosen[below(chosen.size())];
    ImageType& type = image_.types[leaf.type];
    switch (below(5)) {
      case 4:
        any.name = "\x1b";
        return;
      case 0:
        any.limited = !any.limited;
        return;
      case 1:
        type.upper = type.lower - 1;
        return;
      case 2:
        if (!type.member_values.empty()) type.member_values.pop_back();
        return;
      default: {
        // A NaN with a payload, and beyond any limits that are not those of the type.
        const std::uint64_t bits = leaf.rep == core::Rep::kF32 ? 0x7fc00001u : 0x7ff8000000007f01u;
        const std::size_t at = bytecode::offset_of(leaf.word);
        if (at + type.size > image_.global_initial.size()) return;
        std::memcpy(image_.global_initial.data() + at, &bits, std::min<std::size_t>(type.size, sizeof bits));
        return;
      }
    }
  }

  /// Operands and instructions that are right elsewhere.
  void rough_code(ImagePou& any) {
    if (below(3) == 0) return insert(any, 0, {bytecode::opcode_word(Opcode::kReadN), 0, 1});
    if (below(6) == 0) return insert(any, 0, {bytecode::opcode_word(Opcode::kLock)});
    const bool in_function = below(2) == 0;
    std::vector<Word*> operands;
    for (ImagePou& pou : image_.pous) {
      if (in_function && pou.kind != PouKind::kFunction) continue;
      for (const std::size_t at : starts_of(pou)) {
        const bool call = (pou.code[at] & 0xffffu) == static_cast<Word>(Opcode::kCallStd);
        if (!in_function && !call) continue;
        // The first operand of a call is the function.
        for (std::size_t i = call ? 2 : 1; i < length_of(pou, at); ++i) operands.push_back(&pou.code[at + i]);
      }
    }
    if (operands.empty()) return;
    Word& operand = *operands[below(operands.size())];
    if (in_function) {
      operand = bytecode::operand_word(Space::kInstance, 0);
    } else {
      const std::vector<Leaf> leaves = leaves_of(image_.pous[0]);
      if (!leaves.empty()) operand = leaves[below(leaves.size())].word;
    }
  }

  /// A path that leads elsewhere, starts elsewhere, is longer or shorter, or whose value is another leaf.
  void rough_path(ImagePou& pou) {
    std::vector<std::size_t> paths;
    for (const std::size_t at : starts_of(pou)) {
      const bytecode::Operands& operands = bytecode::opcodes()[pou.code[at] & 0xffffu].operands;
      const bool path = operands.count != 0 && operands.specs[operands.count - 1].kind == bytecode::OperandKind::kPath;
      if (path) paths.push_back(at);
    }
    if (paths.empty()) return;
    const std::size_t at = paths[below(paths.size())];
    const std::size_t list = at + 4;
    const std::size_t items = pou.code[at] >> 16;
    const std::vector<Leaf> leaves = leaves_of(pou);
    switch (below(6)) {
      case 0:  // another type to start from
        pou.code[at + 3] = static_cast<Word>(below(image_.types.size() + 1));
        return;
      case 1:  // another value, reference or base
        if (!leaves.empty()) pou.code[at + 1 + below(2)] = leaves[below(leaves.size())].word;
        return;
      case 2:  // a step of another kind
        if (items != 0) pou.code[list + bytecode::kPathWords * below(items)] = static_cast<Word>(below(4));
        return;
      case 3:  // a step to another number or leaf
        if (items == 0) return;
        pou.code[list + bytecode::kPathWords * below(items) + 1] =
            below(2) == 0 || leaves.empty() ? static_cast<Word>(below(5)) : leaves[below(leaves.size())].word;
        return;
      case 4: {  // a step more
        const Word number = below(2) == 0 || leaves.empty() ? 0 : leaves[below(leaves.size())].word;
        const std::size_t end = list + bytecode::kPathWords * items;
        move_targets(pou, end - 1, bytecode::kPathWords);
        pou.code[at] += 1u << 16;
        pou.code.insert(pou.code.begin() + static_cast<std::ptrdiff_t>(end), {static_cast<Word>(below(3)), number});
        return;
      }
      default: {  // a step less
        if (items == 0) return;
        const std::size_t last = list + bytecode::kPathWords * (items - 1);
        move_targets(pou, last, -static_cast<std::ptrdiff_t>(bytecode::kPathWords));
        pou.code[at] -= 1u << 16;
        pou.code.erase(pou.code.begin() + static_cast<std::ptrdiff_t>(last),
                       pou.code.begin() + static_cast<std::ptrdiff_t>(last + bytecode::kPathWords));
        return;
      }
    }
  }

  /// Another bit of EXTRACT or INSERT.
  void rough_part(ImagePou& pou) {
    for (const std::size_t at : starts_of(pou)) {
      const auto opcode = static_cast<Opcode>(pou.code[at] & 0xffffu);
      if (opcode == Opcode::kExtract) pou.code[at + 3] = static_cast<Word>(below(70));
      if (opcode == Opcode::kInsert && below(2) == 0) pou.code[at + 4] = static_cast<Word>(below(70));
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
    return bytecode::words_of(bytecode::opcodes()[pou.code[at] & 0xffffu].operands, pou.code[at] >> 16);
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
    // Calls doubled along a chain of functions would take minutes to run.
    if (starts.empty() || pou.code.size() > 2000 || is_large()) return;
    const std::size_t at = starts[below(starts.size())];
    const std::size_t length = length_of(pou, at);
    const std::vector<Word> copy(pou.code.begin() + static_cast<std::ptrdiff_t>(at),
                                 pou.code.begin() + static_cast<std::ptrdiff_t>(at + length));
    insert(pou, at, copy);
  }

  /// A jump to the instruction at `at` goes to what is inserted there.
  void insert(ImagePou& pou, std::size_t at, const std::vector<Word>& words) {
    move_targets(pou, at, static_cast<std::ptrdiff_t>(words.size()));
    pou.code.insert(pou.code.begin() + static_cast<std::ptrdiff_t>(at), words.begin(), words.end());
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
