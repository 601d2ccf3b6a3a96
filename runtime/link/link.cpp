#include "runtime/link/link.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/operations.h"
#include "runtime/interpreter/value_runs.h"
#include "runtime/link/arrange.h"
#include "runtime/link/body_reader.h"
#include "runtime/link/link_bool.h"
#include "runtime/link/link_library.h"
#include "runtime/link/link_path.h"
#include "runtime/link/link_probes.h"
#include "runtime/link/link_types.h"
#include "runtime/pointers/packed_types.h"
#include "runtime/probes.h"
#include "runtime/taskblocks.h"
#include "stdlib/library.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::ImagePou;
using bytecode::ImageType;
using bytecode::Opcode;
using bytecode::OperandKind;
using bytecode::Space;
using bytecode::TypeKind;

class Linker {
 public:
  Linker(const Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous, const TaskLayout& layout,
         Exchange& exchange, bool arranged, const Probes* looked_at)
      : image_(image),
        pous_(pous),
        layout_(layout),
        exchange_(exchange),
        arranged_(arranged),
        looked_at_(looked_at),
        bindings_(image, body, pous, layout),
        reader_(image, bindings_),
        entries_(image.pous.size()) {
    for (std::size_t op = 0; op < kOps; ++op) {
      handlers_[0][op] = handler_word(Addressing::kFixed, static_cast<ResolvedOp>(op));
      handlers_[1][op] = handler_word(Addressing::kRelative, static_cast<ResolvedOp>(op));
    }
  }

  core::Result<LinkedCode> link(std::uint32_t body) {
    for (const std::uint32_t pou : pous_) {
      const bool fixed = bindings_.addressing(pou) == Addressing::kFixed;
      ++(fixed ? result_.report.fixed_bodies : result_.report.relative_bodies);
      link_body(pou);
    }
    if (problem_) return *problem_;
    for (const auto& [position, callee] : call_patches_) stream_[position] = entries_[callee];
    arrange(stream_, result_, layout_.scratch);
    result_.words = TableMemory(stream_.size() * sizeof(std::uint32_t));
    std::memcpy(result_.words.data(), stream_.data(), stream_.size() * sizeof(std::uint32_t));
    result_.entry = entries_[body];
    result_.report.code_bytes = stream_.size() * sizeof(std::uint32_t);
    return std::move(result_);
  }

 private:
  static constexpr std::size_t kOps = static_cast<std::size_t>(ResolvedOp::kCount);

  [[nodiscard]] std::optional<std::uint32_t> absolute(std::uint32_t pou, std::uint32_t operand) const {
    return bindings_.absolute(pou, operand);
  }
  [[nodiscard]] std::uint32_t resolve(std::uint32_t operand) const { return bindings_.resolve(pou_, operand); }
  [[nodiscard]] std::uint32_t position() const { return static_cast<std::uint32_t>(stream_.size()); }
  void put(std::uint32_t word) { stream_.push_back(word); }
  void put_operand(std::uint32_t operand) { put(resolve(operand)); }
  /// The next instruction is one of these.
  ResolvedOp note(ResolvedOp op) {
    result_.instructions.push_back({position(), op});
    return op;
  }
  [[nodiscard]] std::uint32_t handler(ResolvedOp op) const {
    return handlers_[bindings_.addressing(pou_) == Addressing::kFixed ? 0 : 1][static_cast<std::size_t>(op)];
  }
  void put_handler(ResolvedOp op) { put(handler(note(op))); }
  template <class T>
  void put_pointer(T pointer) {
    std::uint32_t words[2];
    static_assert(sizeof pointer == sizeof words);
    std::memcpy(words, &pointer, sizeof words);
    put(words[0]);
    put(words[1]);
  }
  void put_target(std::uint32_t word) {
    jump_patches_.push_back({position(), word, jump_order_});
    put(0);
  }
  void put_entry(std::uint32_t callee) {
    call_patches_.emplace_back(position(), callee);
    put(0);
  }
  void refuse(std::string message) {
    if (!problem_) {
      problem_ = core::Problem{core::Code::P9001, std::move(message), "compile the project again with this version"};
    }
  }

  [[nodiscard]] const ImageType& leaf_type(std::uint32_t operand) const { return reader_.leaf_type(operand); }
  static std::uint32_t capacities(std::uint16_t to, std::uint16_t from) { return to | std::uint32_t{from} << 16; }

  void link_body(std::uint32_t pou) {
    pou_ = pou;
    reader_.open(pou);
    const std::vector<std::uint32_t>& code = reader_.code();
    std::vector<std::uint32_t> positions(code.size(), 0);
    const std::uint32_t number = looked_at_ == nullptr ? Probes::kNobody : looked_at_->number_of(pou);
    probes_ = LinkProbes(number == Probes::kNobody ? nullptr : &image_.probes[pou], number);
    jump_patches_.clear();
    entries_[pou] = position();
    result_.bodies.push_back(
        {pou, bindings_.addressing(pou), position(), static_cast<std::uint32_t>(result_.instructions.size())});
    std::uint32_t block_end = 0;
    for (std::uint32_t word = 0; word < code.size();) {
      const Decoded d = decode(code, word);
      positions[word] = position();
      result_.marks.push_back({position(), pou, word});
      put_probes(word);
      jump_order_ = probes_.order_of_jump(word);
      if (word >= block_end) {
        end_block();
        block_end = begin_block(word);
      }
      if (d.opcode == Opcode::kBoolRun) {
        probes_.any() ? put_probed_records(d, word) : put_records(reader_.records(d, word));
      } else if (const auto jump = probes_.any() ? std::nullopt : reader_.fused_jump(d)) {
        put_handler(jump->op);
        for (std::uint32_t i = 0; i < 3; ++i) put_operand(d.operands[i]);
        put_target(jump->target);
        word = jump->next;
      } else {
        put_instruction(d);
        word = d.next;
      }
    }
    end_block();
    for (const auto& [at, word, order] : jump_patches_) stream_[at] = probes_.target(word, order, positions[word]);
  }

  // ---- what somebody looks at (link_probes.h)

  void put_probes(std::uint32_t word) {
    probes_.place(word, stream_, [this](std::uint32_t first, std::uint32_t end) {
      put_handler(ResolvedOp::kProbe);
      put(probes_.number());
      put(first);
      put(end);
    });
  }
  /// The records of one run, in parts where steps come between them.
  void put_probed_records(const Decoded& d, std::uint32_t& next) {
    std::vector<GeneralRecord> records;
    for (std::uint32_t i = 0; i < d.items; ++i) {
      const std::uint32_t word = d.word + 1 + i * bytecode::kRecordWords;
      if (i != 0 && probes_.at(word)) {
        put_records(std::exchange(records, {}));
        put_probes(word);
      }
      records.push_back(reader_.record(&reader_.code()[word]));
    }
    put_records(records);
    next = d.next;
  }

  // ---- straight code (arrange.h)

  /// What is shorter is not worth a jump.
  static constexpr std::size_t kLeastBlock = 12;

  /// Marks the straight code that begins at `word`, if there is enough. Returns the word after it.
  std::uint32_t begin_block(std::uint32_t word) {
    std::size_t count = 0;
    std::uint32_t end = word;
    while (end < reader_.code().size() && (end == word || !reader_.is_target(end))) {
      const Decoded d = decode(reader_.code(), end);
      if (!can_be_arranged(d) || reader_.fused_jump(d)) break;
      count += d.opcode == Opcode::kBoolRun ? d.items : 1;
      end = d.next;
    }
    if (count < kLeastBlock || !arranged_ || probes_.any()) return end;
    const std::uint32_t at = position();
    put_handler(ResolvedOp::kBlockStart);
    put(at + 2);
    result_.blocks.push_back({bindings_.addressing(pou_), at, 0, result_.instructions.size()});
    in_block_ = true;
    return end;
  }
  void end_block() {
    if (std::exchange(in_block_, false)) result_.blocks.back().end = position();
  }
  /// Computes, and does nothing else.
  [[nodiscard]] bool can_be_arranged(const Decoded& d) const {
    if (d.opcode == Opcode::kBoolRun) return true;
    if (d.opcode == Opcode::kRunTb) return !is_taskblock(d.operands[0]);
    return value_op(d.opcode == Opcode::kCallStd ? library_op(d) : static_cast<ResolvedOp>(d.opcode)) != nullptr;
  }
  [[nodiscard]] ResolvedOp library_op(const Decoded& call) const {
    const stdlib::Overload* const overload = stdlib::overload_with_key(image_.functions[call.operands[0]]);
    return overload == nullptr ? ResolvedOp::kCallStd
                               : runtime::library_op(*overload, call.items - 1, is_number_of_places(call));
  }
  /// Whether the second argument of a call is a constant from 0 to 63.
  [[nodiscard]] bool is_number_of_places(const Decoded& call) const {
    if (call.items != 3 || bytecode::space_of(call.list[2]) != Space::kConst) return false;
    const std::byte* const at = image_.const_bytes.data() + bytecode::offset_of(call.list[2]);
    const std::uint32_t bytes = leaf_type(call.list[2]).size;
    return load<std::uint8_t>(at) < 64 && std::all_of(at + 1, at + bytes, [](std::byte b) { return b == std::byte{}; });
  }

  void put_records(const std::vector<GeneralRecord>& records) {
    auto& report = result_.report;
    const bool fixed = bindings_.addressing(pou_) == Addressing::kFixed;
    for (const BoolSegment& segment : cut_into_segments(records)) {
      const auto part = std::span(records).subspan(segment.first, segment.count);
      append_segment(stream_, handler(note(op_of(segment.form))), segment, part);
      (segment.form == BoolSegment::Form::kShort4   ? report.short4_records
       : segment.form == BoolSegment::Form::kShort5 ? report.short5_records
       : fixed                                      ? report.wide_records
                                                    : report.mixed_records) += segment.count;
    }
  }
  static ResolvedOp op_of(BoolSegment::Form form) {
    return form == BoolSegment::Form::kShort4   ? ResolvedOp::kBoolRun4
           : form == BoolSegment::Form::kShort5 ? ResolvedOp::kBoolRun5
                                                : ResolvedOp::kBoolRun;
  }

  void put_instruction(const Decoded& d) {
    switch (d.opcode) {
      case Opcode::kMoveStr:
      case Opcode::kMoveWstr:
        put_plain(d);
        put(capacities(leaf_type(d.operands[0]).capacity, leaf_type(d.operands[1]).capacity));
        return;
      case Opcode::kCopy:
        put_handler(ResolvedOp::kCopy);
        put_operand(d.operands[0]);
        put_operand(d.operands[1]);
        put(image_.types[d.operands[2]].size);
        return;
      case Opcode::kRunTb:
        if (is_taskblock(d.operands[0])) {
          put_handler(ResolvedOp::kRunTaskblock);
        } else {
          put_handler(ResolvedOp::kRunTb);
          put_step(d.operands[0]);
        }
        put_operand(d.operands[1]);
        return;
      case Opcode::kCallPou:
        if (bindings_.addressing(d.operands[0]) == Addressing::kFixed) {
          const bool last = bindings_.addressing(pou_) == Addressing::kFixed && !probes_.any() &&
                            decode(image_.pous[pou_].code, d.next).opcode == Opcode::kReturn;
          put_handler(last ? ResolvedOp::kEnterPou : ResolvedOp::kCallPouFixed);
          put_entry(d.operands[0]);
        } else {
          put_handler(ResolvedOp::kCallPou);
          put_entry(d.operands[0]);
          put_operand(d.operands[1]);
        }
        return;
      case Opcode::kCallFn:
        put_function_call(d);
        return;
      case Opcode::kCallStd: {
        const std::string& key = image_.functions[d.operands[0]];
        const stdlib::Overload* const overload = stdlib::overload_with_key(key);
        put_handler(library_op(d));
        if (overload == nullptr) refuse("standard function \"" + key + "\" is not in this library");
        put_pointer(overload == nullptr ? stdlib::Kernel{} : overload->kernel);
        put(d.items - 1);
        for (std::uint32_t i = 0; i < d.items; ++i) put_operand(d.list[i]);
        return;
      }
      case Opcode::kLoadAt:
      case Opcode::kStoreAt:
      case Opcode::kLoadVia:
      case Opcode::kStoreVia:
        put_access(d);
        return;
      case Opcode::kRefAt:
      case Opcode::kRefVia:
        put_ref(d);
        return;
      case Opcode::kRunAt:
      case Opcode::kRunVia:
      case Opcode::kCallAt:
      case Opcode::kCallVia:
        put_execution(d);
        return;
      case Opcode::kAdrAt:
      case Opcode::kAdrVia:
      case Opcode::kAdrPtr:
      case Opcode::kRefPtr:
        put_address(d);
        return;
      case Opcode::kLoadPtr:
      case Opcode::kStorePtr:
        put_pointer_access(d);
        return;
      case Opcode::kExtract:
        put_extract(d);
        return;
      case Opcode::kInsert:
        put_insert(d);
        return;
      case Opcode::kReadN:
      case Opcode::kWriteN:
      case Opcode::kWriteChangedN:
        put_handler(static_cast<ResolvedOp>(d.opcode));
        put(exchange_.add_range(d.operands[0], d.operands[1],
                                d.opcode == Opcode::kReadN ? Exchange::Use::kImport : Exchange::Use::kExport));
        return;
      case Opcode::kQueuePut:
      case Opcode::kQueueGet:
      case Opcode::kQueueCount:
      case Opcode::kQueueSpace:
        put_handler(static_cast<ResolvedOp>(d.opcode));
        put_operand(d.operands[0]);
        put(d.operands[1]);
        if (bytecode::info(d.opcode).operands.count > 2) put_operand(d.operands[2]);
        return;
      case Opcode::kRaisePriority:
        put_handler(static_cast<ResolvedOp>(d.opcode));
        put(exchange_.add_range(d.operands[0], d.operands[1], Exchange::Use::kRaise));
        return;
      default:
        put_plain(d);
        return;
    }
  }

  static ResolvedOp move_of(std::uint32_t bytes) {
    return bytes == 1   ? ResolvedOp::kMove8
           : bytes == 2 ? ResolvedOp::kMove16
           : bytes == 4 ? ResolvedOp::kMove32
                        : ResolvedOp::kMove64;
  }
  // Words are little-endian: a wide part is a value of its own inside the word, a bit is one of a byte.
  static_assert(std::endian::native == std::endian::little);
  void put_extract(const Decoded& d) {
    const ImageType& part = leaf_type(d.operands[0]);
    const bool bit = bytecode::rep_of(part) == core::Rep::kBool;
    put_handler(bit ? ResolvedOp::kExtract : move_of(part.size));
    put_operand(d.operands[0]);
    put(resolve(d.operands[1]) + d.operands[2] / 8);
    if (bit) put(d.operands[2] % 8);
  }
  void put_insert(const Decoded& d) {
    if (resolve(d.operands[0]) != resolve(d.operands[1])) {
      put_handler(move_of(leaf_type(d.operands[0]).size));
      put_operand(d.operands[0]);
      put_operand(d.operands[1]);
    }
    const ImageType& part = leaf_type(d.operands[2]);
    const bool bit = bytecode::rep_of(part) == core::Rep::kBool;
    put_handler(bit ? ResolvedOp::kInsert : move_of(part.size));
    put(resolve(d.operands[0]) + d.operands[3] / 8);
    put_operand(d.operands[2]);
    if (bit) put(d.operands[3] % 8);
  }

  // ---- parts of values (link_path.h)

  static bool is_via(Opcode opcode) { return opcode >= Opcode::kLoadVia && opcode <= Opcode::kCallVia; }
  void put_index(const PathIndex& index) {
    put_operand(index.operand);
    put(index.count);
    put(index.stride);
    put_pointer(index.lower);
    put(static_cast<std::uint32_t>(index.rep));
  }
  void put_path(const ResolvedPath& path) {
    put(path.offset);
    put(static_cast<std::uint32_t>(path.indices.size()));
    for (const PathIndex& index : path.indices) put_index(index);
  }

  void put_access(const Decoded& d) {
    const ResolvedPath path = reader_.path_of(d);
    const bool via = is_via(d.opcode);
    const bool load = d.opcode == Opcode::kLoadAt || d.opcode == Opcode::kLoadVia;
    const std::uint32_t base = d.operands[load ? 1 : 0];
    const std::uint32_t value = d.operands[load ? 0 : 1];
    const ImageType& part = image_.types[path.type];
    if (!via && path.indices.empty()) return put_known_access(path, base, value, load);
    if (const auto several = path_access(image_, path, load); several && !via) {
      put_handler(*several);
      put_operand(value);
      put_operand(base);
      return put_path(path);
    }
    if (const auto quick = quick_access(image_, path, load, via)) {
      put_handler(*quick);
      put_operand(value);
      if (via) {
        put_operand(base);
        put(types_.canonical(d.operands[2]));
        put(path.offset);
      } else {
        put(resolve(base) + path.offset);
      }
      if (!path.indices.empty()) put_index(path.indices.front());
      return;
    }
    put_handler(static_cast<ResolvedOp>(d.opcode));
    put_operand(value);
    put_operand(base);
    if (via) put(types_.canonical(d.operands[2]));
    put_bytes(part, value, load);
    if (load) put_pointer(types_.zeros(path.type));
    put_path(path);
  }
  /// The two words that say how pass() moves a value of type `type` to (or from) the leaf or place `outside`.
  void put_bytes(const ImageType& type, std::uint32_t outside, bool to_outside) {
    if (type.kind != TypeKind::kString) {
      put(type.size);
      put(0);
      return;
    }
    const std::uint16_t other = leaf_type(outside).capacity;
    put(bytecode::rep_of(type) == core::Rep::kStr ? kPassStr : kPassWstr);
    put(to_outside ? capacities(other, type.capacity) : capacities(type.capacity, other));
  }
  /// An access whose path leads to one place is a move.
  void put_known_access(const ResolvedPath& path, std::uint32_t base, std::uint32_t value, bool load) {
    const ImageType& part = image_.types[path.type];
    const std::uint32_t inside = resolve(base) + path.offset;
    const bool string = part.kind == TypeKind::kString;
    const bool scalar = part.kind == TypeKind::kScalar || part.kind == TypeKind::kRef;
    put_handler(string   ? (bytecode::rep_of(part) == core::Rep::kStr ? ResolvedOp::kMoveStr : ResolvedOp::kMoveWstr)
                : scalar ? move_of(part.size)
                         : ResolvedOp::kCopy);
    put(load ? resolve(value) : inside);
    put(load ? inside : resolve(value));
    if (string) {
      const std::uint16_t other = leaf_type(value).capacity;
      put(load ? capacities(other, part.capacity) : capacities(part.capacity, other));
    } else if (!scalar) {
      put(part.size);
    }
  }
  void put_ref(const Decoded& d) {
    const ResolvedPath path = reader_.path_of(d);
    put_handler(static_cast<ResolvedOp>(d.opcode));
    put_operand(d.operands[0]);
    put_operand(d.operands[1]);
    if (d.opcode == Opcode::kRefVia) put(types_.canonical(d.operands[2]));
    put(types_.canonical(path.type));
    put_path(path);
  }
  /// Instructions that make a pointer, or a handle of one.
  void put_address(const Decoded& d) {
    const bool through = d.opcode == Opcode::kAdrPtr || d.opcode == Opcode::kRefPtr;
    const ResolvedPath path = through ? packed_path(d) : reader_.path_of(d);
    put_handler(static_cast<ResolvedOp>(d.opcode));
    put_operand(d.operands[0]);
    put_operand(d.operands[1]);
    if (d.opcode == Opcode::kAdrVia) put(types_.canonical(d.operands[2]));
    if (d.opcode != Opcode::kAdrPtr) put(types_.canonical(path.type));
    put_path(path);
  }
  void put_pointer_access(const Decoded& d) {
    const bool load = d.opcode == Opcode::kLoadPtr;
    const ResolvedPath path = packed_path(d);
    const std::uint32_t value = d.operands[load ? 0 : 1];
    put_handler(static_cast<ResolvedOp>(d.opcode));
    put_operand(value);
    put_operand(d.operands[load ? 1 : 0]);
    put(path.type);
    put(image_.types[path.type].kind == TypeKind::kString ? leaf_type(value).capacity : 0);
    if (load) put_pointer(types_.zeros(path.type));
    put_path(path);
  }
  /// The path of an instruction in the layout that pointers see.
  [[nodiscard]] ResolvedPath packed_path(const Decoded& d) {
    if (!packed_) packed_.emplace(image_);
    return reader_.path_of(d, &*packed_);
  }
  void put_execution(const Decoded& d) {
    const ResolvedPath path = reader_.path_of(d);
    put_handler(static_cast<ResolvedOp>(d.opcode));
    if (d.opcode == Opcode::kRunAt || d.opcode == Opcode::kRunVia) {
      put_step(d.operands[0]);
    } else {
      put_entry(d.operands[0]);
    }
    put_operand(d.operands[1]);
    if (is_via(d.opcode)) put(types_.canonical(d.operands[2]));
    put_path(path);
  }

  /// An instruction whose operands are leaves and targets.
  void put_plain(const Decoded& d) {
    put_handler(static_cast<ResolvedOp>(d.opcode));
    const bytecode::Operands& operands = bytecode::info(d.opcode).operands;
    for (std::uint32_t i = 0; i < operands.count; ++i) {
      if (operands.specs[i].kind == OperandKind::kTarget) {
        put_target(d.operands[i]);
      } else {
        put_operand(d.operands[i]);
      }
    }
  }

  void put_step(std::uint32_t block) {
    const bytecode::ImageBlock& wanted = image_.blocks[block];
    const stdlib::BlockSpec* const spec = stdlib::block_named(wanted.name);
    if (spec == nullptr) {
      // Whether this machine has it is found out when its objects are made.
      put_pointer(&Taskblocks::step);
      return;
    }
    if (stdlib::layout_hash(*spec) != wanted.layout_hash) {
      refuse("function block \"" + wanted.name + "\" has other ports in this library than in the image");
    }
    put_pointer(spec->step);
  }
  [[nodiscard]] bool is_taskblock(std::uint32_t block) const {
    return stdlib::block_named(image_.blocks[block].name) == nullptr;
  }

  void put_function_call(const Decoded& d) {
    const std::uint32_t callee = d.operands[0];
    const ImagePou& function = image_.pous[callee];
    const std::uint32_t frame = layout_.frames[callee];
    put_handler(ResolvedOp::kCallFn);
    put(frame);
    put(static_cast<std::uint32_t>(function.frame_initial.size()));
    put_pointer(function.frame_initial.empty() ? &kNoBytes : function.frame_initial.data());
    put_entry(callee);
    const std::uint32_t counts = position();
    put(0);
    put(0);
    for (const bool inputs : {true, false}) {
      for (std::uint32_t i = 0; i < d.items; ++i) {
        const bytecode::ImageField& parameter = image_.types[function.frame_type].fields[d.list[2 * i]];
        const bool is_input =
            parameter.role == bytecode::FieldRole::kInput || parameter.role == bytecode::FieldRole::kInOut;
        if (is_input != inputs) continue;
        ++stream_[counts + (inputs ? 0 : 1)];
        put_argument(frame + parameter.offset, image_.types[parameter.type], d.list[2 * i + 1], inputs);
      }
    }
  }
  void put_argument(std::uint32_t parameter, const ImageType& type, std::uint32_t operand, bool input) {
    const std::uint32_t outside = resolve(operand);
    put(input ? parameter : outside);
    put(input ? outside : parameter);
    put_bytes(type, operand, !input);
  }

  static constexpr std::byte kNoBytes{};

  const Image& image_;
  const std::vector<std::uint32_t>& pous_;
  const TaskLayout& layout_;
  Exchange& exchange_;
  bool arranged_;
  const Probes* looked_at_;
  Bindings bindings_;
  BodyReader reader_;
  std::vector<std::uint32_t> entries_;
  std::uint32_t handlers_[2][kOps] = {};
  std::vector<std::uint32_t> stream_;
  std::vector<std::array<std::uint32_t, 3>> jump_patches_;  ///< position, word, order
  LinkProbes probes_{nullptr, Probes::kNobody};             ///< of the POU that is linked
  std::uint32_t jump_order_ = 0;                            ///< of the instruction that is linked
  std::vector<std::pair<std::uint32_t, std::uint32_t>> call_patches_;
  std::optional<PackedTypes> packed_;  ///< made when an instruction goes through a pointer
  std::optional<core::Problem> problem_;
  std::uint32_t pou_ = 0;
  bool in_block_ = false;
  LinkedCode result_;
  LinkTypes types_{image_, result_};
};

}  // namespace

core::Result<LinkedCode> link_task(const Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous,
                                   const TaskLayout& layout, Exchange& exchange, bool arranged, const Probes* probes) {
  return Linker(image, body, pous, layout, exchange, arranged, probes).link(body);
}

}  // namespace plc::runtime
