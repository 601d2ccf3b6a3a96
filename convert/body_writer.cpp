#include "convert/body_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "convert/body_plan.h"
#include "convert/expressions.h"
#include "convert/literals.h"
#include "frontend-st/lexer.h"

namespace plc::convert {

using ir::Inst;
using ir::Op;

std::string AddedVariables::unused(const std::string& wish) {
  const auto known = [&](const std::string& name) {
    return owner_.by_name.contains(name) || owner_.actions.contains(name) || module_.global_by_name.contains(name) ||
           module_.pou_by_name.contains(name) || taken_.contains(name);
  };
  std::string name = wish;
  for (int i = 2; known(name); ++i) name = fmt::format("{}_{}", wish, i);
  taken_.insert(name);
  return name;
}

std::optional<std::string> AddedVariables::hidden(std::uint32_t index) {
  const auto known = hidden_.find(index);
  if (known != hidden_.end()) return known->second;
  const ir::Variable& variable = owner_.variables[index];
  const auto type = type_text(module_.types, variable.type);
  if (!type) return std::nullopt;
  std::string initial;
  if (!variable.initial.empty()) {
    if (variable.initial.size() != 1 || !variable.initial[0].path.empty()) return std::nullopt;
    const auto value = literal_text(module_.types, variable.initial[0].value);
    if (!value) return std::nullopt;
    initial = *value;
  }
  std::string wish = "kept";
  for (const char c : variable.name)
    wish += st::is_identifier_char(c) && static_cast<unsigned char>(c) < 0x80 ? c : '_';
  // IEC 61131-3, 6.1.2: no two underscores in a row.
  wish.erase(std::unique(wish.begin(), wish.end(), [](char a, char b) { return a == '_' && b == '_'; }), wish.end());
  std::string name = unused(wish);
  all_.push_back({name, *type, std::move(initial), false});
  hidden_.emplace(index, name);
  return name;
}

std::optional<std::string> AddedVariables::temporary(ir::TypeRef type) {
  const auto text = type_text(module_.types, type);
  if (!text) return std::nullopt;
  std::string name = unused(fmt::format("value_{}", all_.size() + 1));
  all_.push_back({name, *text, {}, true});
  return name;
}

namespace {

class BodyWriter {
 public:
  BodyWriter(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner, AddedVariables& added)
      : module_(module),
        pou_(pou),
        body_(pou.body),
        added_(added),
        plan_(module, pou, owner),
        expressions_(module, pou, owner, plan_, added) {}

  WrittenBody run() {
    WrittenBody out;
    AddedVariables::State before = added_.save();
    if (!range(plan_.first(), end(), 1)) {
      if (expressions_.problem().empty()) {
        // Jumps that are no IF.
        text_.clear();
        added_.restore(std::move(before));
        expressions_.reset();
        out.loop = true;
        blocks();
      }
    }
    out.problem = expressions_.problem();
    out.at = expressions_.problem_at();
    out.text = std::move(text_);
    return out;
  }

 private:
  [[nodiscard]] std::uint32_t end() const { return static_cast<std::uint32_t>(body_.insts.size()); }

  void line(int depth, std::string_view text) {
    text_.append(static_cast<std::size_t>(depth) * 2, ' ');
    text_ += text;
    text_ += '\n';
  }

  /// True when only labels are from `begin` on: a jump there ends what is open.
  [[nodiscard]] bool only_labels(std::uint32_t begin, std::uint32_t last) const {
    for (std::uint32_t i = begin; i < last; ++i) {
      if (body_.insts[i].op != Op::kLabel) return false;
    }
    return true;
  }

  /// Instructions from `begin` to `last` as statements. False at a jump that is no IF, or with a problem.
  bool range(std::uint32_t begin, std::uint32_t last, int depth) {
    const std::size_t at_begin = text_.size();
    for (std::uint32_t i = begin; i < last; ++i) {
      const Inst& inst = body_.insts[i];
      switch (inst.op) {
        case Op::kLabel:
          // Who jumps here from the right is a loop.
          if (!plan_.label_is_known(inst.a)) return false;
          break;
        case Op::kReturn:
          if (!only_labels(i + 1, end())) line(depth, "RETURN;");
          break;
        case Op::kJump: {
          const std::uint32_t target = plan_.position_of(inst.a);
          if (target <= i) return false;
          if (only_labels(target, end())) {
            if (!only_labels(i + 1, end())) line(depth, "RETURN;");
          } else if (!only_labels(i + 1, target) &&
                     !(target >= last && only_labels(i + 1, last) && only_labels(last, target))) {
            return false;
          }
          break;
        }
        case Op::kJumpIf:
        case Op::kJumpIfNot:
          if (!conditional(i, last, depth)) return false;
          i = next_;
          break;
        default:
          if (!statement(i, depth)) return false;
          break;
      }
      if (!expressions_.problem().empty()) return false;
    }
    if (text_.size() == at_begin && depth > 1) line(depth, ";");
    return true;
  }

  /// An IF for the jump at `i`; next_ is the last instruction of it.
  bool conditional(std::uint32_t i, std::uint32_t last, int depth) {
    const Inst& inst = body_.insts[i];
    const std::uint32_t target = plan_.position_of(inst.a);
    // A jump to the end of what is open, labels in between.
    const std::uint32_t stop = target < last ? target : last;
    if (target <= i || (target > last && !only_labels(last, target))) return false;
    const bool negate = inst.op == Op::kJumpIf;
    const std::string condition = expressions_.condition(inst.b, negate);
    line(depth, "IF " + condition + " THEN");
    // "jump done" right before the target: what follows it is ELSE.
    std::uint32_t then_end = stop;
    std::uint32_t done = stop;
    if (stop == target && stop > i + 1 && body_.insts[stop - 1].op == Op::kJump) {
      const std::uint32_t after = plan_.position_of(body_.insts[stop - 1].a);
      if (after > target && (after <= last || only_labels(last, after)) && !only_labels(after, end())) {
        then_end = stop - 1;
        done = std::min(after, last);
      } else if (after > target && after <= last) {
        then_end = stop - 1;
        done = after;
      }
    }
    if (!range(i + 1, then_end, depth + 1)) return false;
    if (done != stop) {
      line(depth, "ELSE");
      if (!range(stop, done, depth + 1)) return false;
    }
    line(depth, "END_IF;");
    next_ = done - 1;
    return true;
  }

  /// One instruction that neither jumps nor is a place to jump to.
  bool statement(std::uint32_t i, int depth) {
    for (const std::string& text : expressions_.statements(i)) line(depth, text);
    return expressions_.problem().empty();
  }

  /// The body as basic blocks, run by a loop.
  void blocks() {
    std::vector<std::uint32_t> starts = {plan_.first()};
    for (std::uint32_t i = plan_.first(); i < end(); ++i) {
      const Op op = body_.insts[i].op;
      const bool jumps = op == Op::kJump || op == Op::kJumpIf || op == Op::kJumpIfNot || op == Op::kReturn;
      if (op == Op::kLabel) starts.push_back(i);
      if (jumps) starts.push_back(i + 1);
    }
    std::sort(starts.begin(), starts.end());
    starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
    while (!starts.empty() && starts.back() >= end()) starts.pop_back();
    const auto next = expressions_.counter();
    if (!next) return;
    const auto block_of = [&](std::uint32_t position) {
      return std::lower_bound(starts.begin(), starts.end(), position) - starts.begin();
    };
    const auto target = [&](std::uint32_t position) {
      return position >= end() ? std::string("-1") : fmt::format("{}", block_of(position));
    };
    line(1, *next + " := 0;");
    line(1, "WHILE " + *next + " >= 0 DO");
    line(2, "CASE " + *next + " OF");
    for (std::size_t b = 0; b < starts.size(); ++b) {
      const std::uint32_t stop = b + 1 < starts.size() ? starts[b + 1] : end();
      line(3, fmt::format("{}:", b));
      std::string after = target(stop);
      for (std::uint32_t i = starts[b]; i < stop && expressions_.problem().empty(); ++i) {
        const Inst& inst = body_.insts[i];
        if (inst.op == Op::kLabel) continue;
        if (inst.op == Op::kReturn) {
          after = "-1";
        } else if (inst.op == Op::kJump) {
          after = target(plan_.position_of(inst.a));
        } else if (inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot) {
          line(4, "IF " + expressions_.condition(inst.b, false) + " THEN");
          const std::string there = target(plan_.position_of(inst.a));
          line(5, *next + " := " + (inst.op == Op::kJumpIf ? there : after) + ";");
          line(4, "ELSE");
          line(5, *next + " := " + (inst.op == Op::kJumpIf ? after : there) + ";");
          line(4, "END_IF;");
          after.clear();
        } else {
          statement(i, 4);
        }
      }
      if (!after.empty()) line(4, *next + " := " + after + ";");
    }
    line(2, "END_CASE;");
    line(1, "END_WHILE;");
  }

  const ir::Module& module_;
  const ir::Pou& pou_;
  const ir::Body& body_;
  AddedVariables& added_;
  BodyPlan plan_;
  Expressions expressions_;
  std::string text_;
  std::uint32_t next_ = 0;
};

}  // namespace

WrittenBody write_body(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner, AddedVariables& added) {
  return BodyWriter(module, pou, owner, added).run();
}

}  // namespace plc::convert
