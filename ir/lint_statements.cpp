// Lints of statements and drawn elements: code that nothing reaches, assignments to oneself, empty IFs, CASEs that
// leave values of their enumeration out, control variables that their own loop writes.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "ir/lint_findings.h"
#include "ir/text.h"

namespace plc::ir {
namespace {

class Statements {
 public:
  Statements(const LintBody& body, Findings& findings) : b_(body), insts_(body.pou.body.insts), findings_(findings) {}

  void run() {
    for (std::uint32_t i = 0; i < insts_.size(); ++i) {
      switch (insts_[i].op) {
        case Op::kStore:
          look_at_store(i);
          break;
        case Op::kJumpIfNot:
          look_at_branch(i);
          break;
        case Op::kCall:
          if (insts_[i].part == Part::kCaseLabel) note_label(i);
          break;
        default:
          break;
      }
    }
    look_at_unreached();
    look_at_cases();
    look_at_loops();
  }

 private:
  void add(Lint lint, std::uint32_t index, std::string message, std::string help) {
    findings_.add(lint, b_.at(index), b_.pou.name, std::move(message), std::move(help));
  }
  [[nodiscard]] std::string text_of(std::uint32_t place) const { return place_text(b_.module, b_.pou, PlaceId{place}); }

  /// True when the place is part of a variable with a name.
  [[nodiscard]] bool is_named(std::uint32_t place) const {
    const Place* p = &b_.body().places[place];
    while (p->parent.valid()) p = &b_.body().places[p->parent.index];
    const bool own = p->kind == Place::Kind::kInstance || p->kind == Place::Kind::kFrame;
    return !own || is_visible(b_.variable(p->index));
  }

  // ---- unreachable ----

  /// True for what someone wrote or drew to happen; loops and branches leave jumps and counting behind.
  [[nodiscard]] bool acts(const Inst& inst) const {
    if (inst.part != Part::kPlain) return false;
    const bool writes = inst.op == Op::kStore || inst.op == Op::kCopy;
    return (writes && is_named(inst.a)) || inst.op == Op::kRun || inst.op == Op::kCallPou;
  }

  void look_at_unreached() {
    std::uint32_t begin = 0;  // of the present unreached stretch
    bool reported = true;
    for (std::uint32_t i = 0; i < insts_.size(); ++i) {
      if (b_.flow.reached[i]) {
        reported = false;
        begin = i + 1;
      } else if (!reported && acts(insts_[i])) {
        reported = true;
        add(Lint::kUnreachable, i, fmt::format("this never runs: {}", reason(begin)),
            "delete it, or what keeps it away");
      }
    }
  }

  /// Why the instruction at `begin` is not reached, though the one before it is.
  [[nodiscard]] std::string reason(std::uint32_t begin) const {
    const auto line = [](const SourceRef& at) { return at.line == 0 ? "" : fmt::format(" (line {})", at.line); };
    const std::string where = line(b_.at(begin - 1));
    switch (insts_[begin - 1].op) {
      case Op::kReturn:
        return "it comes after a RETURN" + where;
      case Op::kJump:
        return (b_.at(begin - 1).kind == core::ElementKind::kText ? "it comes after an EXIT, CONTINUE or ELSE"
                                                                  : "it comes after a jump") +
               where;
      case Op::kJumpIf:
        return (b_.flow.label_at[insts_[begin - 1].a] > begin ? "it comes after a jump that is always taken"
                                                              : "it comes after a loop that has no end") +
               where;
      default:
        return "its condition is always FALSE" + where;
    }
  }

  // ---- self-assignment ----

  void look_at_store(std::uint32_t index) {
    const Inst& store = insts_[index];
    if (!b_.flow.reached[index] || store.b + 1 != index) return;
    const Inst& value = insts_[store.b];
    if (value.op != Op::kLoad || value.a != store.a || !is_named(store.a)) return;
    add(Lint::kSelfAssignment, index, fmt::format("{} is assigned to itself", quoted(text_of(store.a))),
        "assign another value, or delete the assignment");
  }

  // ---- empty-branch ----

  /// Where the labels at `index` end.
  [[nodiscard]] std::uint32_t after_labels(std::uint32_t index) const {
    while (index < insts_.size() && insts_[index].op == Op::kLabel) ++index;
    return index;
  }

  void look_at_branch(std::uint32_t index) {
    const Inst& jump = insts_[index];
    if (jump.part != Part::kPlain || b_.at(index).kind != core::ElementKind::kText) return;
    const std::uint32_t target = b_.flow.target(b_.body(), index);
    if (target <= index || after_labels(index + 1) <= target) return;
    add(Lint::kEmptyBranch, index, "IF has no statements", "write what is to happen, or delete it");
  }

  // ---- missing-case ----

  struct Case {
    std::uint32_t selector;  ///< value
    std::uint32_t first;     ///< comparison with the first label
    std::uint32_t last;      ///< the latest comparison seen
    bool plain = true;       ///< all labels are single values
    std::unordered_set<std::int64_t> values;
  };

  void note_label(std::uint32_t index) {
    const Inst& call = insts_[index];
    const std::uint32_t selector = b_.body().args[call.b].index;
    if (b_.module.types[insts_[selector].type].kind != TypeKind::kEnum || call.count != 2) return;
    const auto [it, fresh] = case_of_.try_emplace(selector, cases_.size());
    if (fresh) cases_.push_back({selector, index, index, true, {}});
    Case& one = cases_[it->second];
    one.last = index;
    const Inst& label = insts_[b_.body().args[call.b + 1].index];
    const bool single = b_.body().functions[call.a]->spec->name == "EQ" && label.op == Op::kConst;
    one.plain = one.plain && single;
    if (single) one.values.insert(as_signed(b_.body().constants[label.a]));
  }

  [[nodiscard]] std::int64_t as_signed(const Constant& constant) const {
    const Rep rep = b_.module.types.rep_of(constant.type).value_or(Rep::kI64);
    const unsigned unused = 64 - core::rep_bytes(rep) * 8;
    const bool has_sign = rep == Rep::kI8 || rep == Rep::kI16 || rep == Rep::kI32 || rep == Rep::kI64;
    if (!has_sign) return static_cast<std::int64_t>(constant.bits);
    return static_cast<std::int64_t>(constant.bits << unused) >> unused;
  }

  /// An ELSE, even an empty one, is jumped around by the branch before it.
  [[nodiscard]] bool has_else(const Case& one) const {
    std::uint32_t jump = one.last;
    while (jump < insts_.size() && insts_[jump].op != Op::kJumpIfNot) ++jump;
    if (jump == insts_.size()) return true;
    const std::uint32_t next = b_.flow.target(b_.body(), jump);
    if (next == BodyFlow::kNowhere || next == 0 || insts_[next - 1].op != Op::kJump) return false;
    return insts_[next - 1].part == Part::kCaseLabel;
  }

  void look_at_cases() {
    for (const Case& one : cases_) {
      if (!one.plain || has_else(one)) continue;
      const Type& type = b_.module.types[insts_[one.selector].type];
      std::string missing;
      std::size_t count = 0;
      constexpr std::size_t kNamed = 5;
      for (const EnumMember& member : type.members) {
        if (one.values.contains(member.value)) continue;
        if (++count <= kNamed) missing += (missing.empty() ? "" : ", ") + member.name;
      }
      if (count == 0) continue;
      if (count > kNamed) missing += fmt::format(" and {} more", count - kNamed);
      add(Lint::kMissingCase, one.first,
          fmt::format("CASE over {} has no branch for {}, and no ELSE",
                      b_.module.types.name_of(insts_[one.selector].type), missing),
          "add the branches; an empty ELSE says that nothing is to happen");
    }
  }

  // ---- loop-variable ----

  struct Loop {
    std::uint32_t place, begin, end;  ///< from the first instruction of the body to the counting store
  };
  /// After the jump back the loop counts once more: label, load, constant, sum, store.
  static constexpr std::uint32_t kLastCount = 6;

  void look_at_loops() {
    std::unordered_map<std::uint32_t, std::vector<Loop>> loops;  // by place
    for (std::uint32_t i = 0; i < insts_.size(); ++i) {
      if (insts_[i].op != Op::kStore || insts_[i].part != Part::kForControl) continue;
      // The counting store is followed by the jump back; the first one by the entry of the loop.
      std::uint32_t jump = i + 1;
      while (jump < insts_.size() && b_.flow.target(b_.body(), jump) == BodyFlow::kNowhere) ++jump;
      if (jump == insts_.size() || b_.flow.target(b_.body(), jump) > i) continue;
      loops[insts_[i].a].push_back({insts_[i].a, b_.flow.target(b_.body(), jump), i});
    }
    if (loops.empty()) return;
    std::unordered_map<std::uint32_t, std::vector<Loop>> outermost;  // by place; they do not overlap
    for (const auto& [place, all] : loops) {
      std::vector<Loop>& kept = outermost[place];
      for (auto loop = all.rbegin(); loop != all.rend(); ++loop) {
        if (kept.empty() || loop->begin < kept.back().begin) kept.push_back(*loop);
      }
    }
    const auto look_at_write = [&](std::uint32_t index, std::uint32_t place) {
      const auto found = loops.find(place);
      if (found == loops.end()) return;
      // An inner loop on the same variable is one finding, where it sets it.
      const std::vector<Loop>& all = found->second;
      const auto after = std::upper_bound(all.begin(), all.end(), index,
                                          [](std::uint32_t at, const Loop& loop) { return at < loop.end; });
      const bool counted = after != all.begin() && index - (after - 1)->end <= kLastCount;
      if (insts_[index].part == Part::kForControl && counted) return;
      const std::vector<Loop>& around = outermost[place];
      const auto first = std::lower_bound(around.begin(), around.end(), index,
                                          [](const Loop& loop, std::uint32_t at) { return loop.begin >= at; });
      if (first == around.end() || index >= first->end) return;
      add(Lint::kLoopVariable, index,
          fmt::format("{} counts the FOR around it and is written here", quoted(text_of(place))),
          "leave the loop with EXIT, or count with another variable");
    };
    for (std::uint32_t i = 0; i < insts_.size(); ++i) {
      if (insts_[i].op == Op::kStore) look_at_write(i, insts_[i].a);
      if (insts_[i].op != Op::kCallPou) continue;
      for (std::uint32_t k = 0; k < insts_[i].count; ++k) {
        const CallArg& arg = b_.body().call_args[insts_[i].b + k];
        if (arg.kind == CallArg::Kind::kOutput) look_at_write(i, arg.place.index);
      }
    }
  }

  const LintBody& b_;
  const std::vector<Inst>& insts_;
  Findings& findings_;
  std::vector<Case> cases_;
  std::unordered_map<std::uint32_t, std::size_t> case_of_;  ///< by selector
};

}  // namespace

void lint_statements(const LintBody& body, Findings& findings) { Statements(body, findings).run(); }

}  // namespace plc::ir
