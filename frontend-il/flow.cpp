#include "frontend-il/flow.h"

#include <algorithm>
#include <unordered_map>

#include "core/guess.h"
#include "core/text.h"

namespace plc::il {
namespace {

using core::Code;

class Maker {
 public:
  Maker(const Listing& listing, const st::SourceText& source, bool gives_value, core::Diagnostics& diagnostics,
        std::string_view pou)
      : listing_(listing), source_(source), gives_value_(gives_value), diagnostics_(diagnostics), pou_(pou) {}

  Flow make() {
    name_labels();
    cut();
    connect();
    find_needs();
    return std::move(flow_);
  }

 private:
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(listing_.instructions.size()); }
  [[nodiscard]] std::string_view name_of(const Instruction& jump) const {
    const st::Node& name = listing_.ast[jump.operand];
    return source_.slice(name.name, name.name_end);
  }
  /// Whether control does not simply go on after it.
  [[nodiscard]] bool ends_block(const Instruction& one) const {
    if (one.kind == Kind::kJump) return true;
    return one.kind == Kind::kReturn && (gives_value_ || one.condition == Condition::kAlways);
  }

  void name_labels() {
    for (const Label& label : listing_.labels) {
      const std::string_view name = source_.slice(label.begin, label.end);
      const auto [known, fresh] = labels_.try_emplace(std::string(name), &label);
      if (fresh) continue;
      fail(label.begin,
           "label \"" + std::string(name) + "\" is in line " +
               std::to_string(source_.locate(known->second->begin).line) + ", too",
           "a label stands once in a body");
    }
  }

  void fail(std::uint32_t at, std::string message, std::string help) {
    diagnostics_.report(Code::P4505, source_.locate(at), pou_, std::move(message), std::move(help));
    flow_.failed = true;
  }

  [[nodiscard]] std::optional<std::uint32_t> target(const Instruction& jump) {
    const auto known = labels_.find(name_of(jump));
    if (known != labels_.end()) return known->second->instruction;
    core::Guess guess(name_of(jump));
    for (const Label& label : listing_.labels) guess.offer(source_.slice(label.begin, label.end));
    fail(listing_.ast[jump.operand].begin, "there is no label \"" + std::string(name_of(jump)) + '"',
         guess.help().empty() ? "a label and its colon stand before the instruction that is meant" : guess.help());
    return std::nullopt;
  }

  void cut() {
    std::vector<bool> first(count() + 1, false);
    first[0] = true;
    first[count()] = true;
    for (std::uint32_t i = 0; i < count(); ++i) {
      if (!ends_block(listing_.instructions[i])) continue;
      first[i + 1] = true;
    }
    for (const Label& label : listing_.labels) first[label.instruction] = true;
    for (std::uint32_t i = 0; i < count(); ++i) {
      if (!first[i]) continue;
      if (!flow_.blocks.empty()) flow_.blocks.back().last = i;
      block_at_.resize(count() + 1);
      block_at_[i] = static_cast<BlockId>(flow_.blocks.size());
      Block& block = flow_.blocks.emplace_back();
      block.first = i;
    }
    if (!flow_.blocks.empty()) flow_.blocks.back().last = count();
    block_at_.resize(count() + 1);
    block_at_[count()] = static_cast<BlockId>(flow_.blocks.size());
    Block& end = flow_.blocks.emplace_back();
    end.first = end.last = count();
    end.reads = gives_value_;
  }

  void connect() {
    for (BlockId id = 0; id + 1 < flow_.blocks.size(); ++id) {
      Block& block = flow_.blocks[id];
      const Instruction& last = listing_.instructions[block.last - 1];
      const bool always = last.condition == Condition::kAlways;
      if (last.kind == Kind::kJump) {
        if (const auto to = target(last)) block.jump = block_at_[*to];
      } else if (last.kind == Kind::kReturn && gives_value_) {
        block.jump = flow_.end();
      }
      if (!ends_block(last) || !always) block.next = id + 1;
      if (block.jump) flow_.blocks[*block.jump].jump_target = true;
      if (block.jump) flow_.blocks[*block.jump].before.push_back(id);
      if (block.next) flow_.blocks[*block.next].before.push_back(id);
      for (std::uint32_t i = block.first; i < block.last; ++i) {
        const Instruction& one = listing_.instructions[i];
        block.reads = block.reads || (!block.writes && reads_accumulator(one));
        block.writes = block.writes || writes_accumulator(one);
      }
    }
  }

  // Backwards, from blocks that read to those before them that put nothing into the accumulator.
  void find_needs() {
    std::vector<BlockId> open;
    for (BlockId id = 0; id < flow_.blocks.size(); ++id) {
      if (flow_.blocks[id].reads) open.push_back(id);
    }
    while (!open.empty()) {
      Block& block = flow_.blocks[open.back()];
      open.pop_back();
      if (block.needs_value) continue;
      block.needs_value = true;
      for (const BlockId before : block.before) {
        if (!flow_.blocks[before].writes) open.push_back(before);
      }
    }
  }

  const Listing& listing_;
  const st::SourceText& source_;
  bool gives_value_;
  core::Diagnostics& diagnostics_;
  std::string_view pou_;
  std::unordered_map<std::string, const Label*, core::NameHash, core::NameEqual> labels_;
  std::vector<BlockId> block_at_;  ///< by instruction that begins a block
  Flow flow_;
};

}  // namespace

bool reads_accumulator(const Instruction& instruction) {
  switch (instruction.kind) {
    case Kind::kStore:
    case Kind::kSet:
    case Kind::kReset:
    case Kind::kNot:
    case Kind::kBinary:
    case Kind::kInput:
    case Kind::kClose:
      return true;
    case Kind::kJump:
    case Kind::kCall:
    case Kind::kReturn:
      return instruction.condition != Condition::kAlways;
    case Kind::kFunction:
      return !instruction.formal;
    case Kind::kLoad:
    case Kind::kBroken:
      return false;
  }
  return false;
}

bool writes_accumulator(const Instruction& instruction) {
  switch (instruction.kind) {
    case Kind::kLoad:
    case Kind::kNot:
    case Kind::kBinary:
    case Kind::kClose:
    case Kind::kFunction:
    case Kind::kBroken:
      return true;
    default:
      return false;
  }
}

Flow flow_of(const Listing& listing, const st::SourceText& source, bool gives_value, core::Diagnostics& diagnostics,
             std::string_view pou) {
  return Maker(listing, source, gives_value, diagnostics, pou).make();
}

}  // namespace plc::il
