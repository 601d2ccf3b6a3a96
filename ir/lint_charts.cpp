// Lints of sequential function charts: a variable that a chart drives as an action and somebody else writes, a timer
// that freezes with the action it is in.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/text.h"
#include "ir/lint_findings.h"
#include "ir/text.h"

namespace plc::ir {
namespace {

/// A variable or a part of one, by its path: the same in all bodies that can name it.
using PathKey = std::vector<std::uint32_t>;

/// Nothing for what a reference or a computed index leads to.
std::optional<PathKey> key_of(const Module& module, std::uint32_t pou, PlaceId id) {
  const Body& body = module.pous[pou].body;
  PathKey key;
  for (const Place* p = &body.places[id.index];; p = &body.places[p->parent.index]) {
    switch (p->kind) {
      case Place::Kind::kGlobal:
        key.insert(key.end(), {p->index, Pou::kDeclared});
        return key;
      case Place::Kind::kInstance: {
        const std::uint32_t owner = module.pous[pou].owner;
        key.insert(key.end(), {p->index, owner == Pou::kDeclared ? pou : owner});
        return key;
      }
      case Place::Kind::kField:
      case Place::Kind::kElement:
        key.push_back(p->index);
        break;
      default:
        return std::nullopt;
    }
    if (!p->parent.valid()) return std::nullopt;
  }
}

/// One place that writes a variable.
struct Write {
  std::uint32_t pou = 0;
  SourceRef at;
};
struct Writers {
  std::vector<std::uint32_t> charts;  ///< POUs whose charts drive it, each once
  std::vector<Write> others;          ///< the first of each body
  std::string text;                   ///< as the first chart names it
};

class ChartVariables {
 public:
  ChartVariables(const Module& module, Findings& findings) : module_(module), findings_(findings) {}

  void run() {
    for (const bool charts : {true, false}) {
      for (std::uint32_t p = 0; p < module_.pous.size(); ++p) look_at(p, charts);
      if (writers_.empty()) return;
    }
    for (const auto& [key, writers] : writers_) report(writers);
  }

 private:
  [[nodiscard]] std::uint32_t owner_of(std::uint32_t pou) const {
    const std::uint32_t owner = module_.pous[pou].owner;
    return owner == Pou::kDeclared ? pou : owner;
  }

  void look_at(std::uint32_t pou, bool charts) {
    const Pou& from = module_.pous[pou];
    if (!findings_.is_linted(from)) return;
    for (const Inst& inst : from.body.insts) {
      switch (inst.op) {
        case Op::kStore:
        case Op::kCopy:
          if ((inst.part == Part::kChart) == charts) note(pou, PlaceId{inst.a}, inst, charts);
          break;
        case Op::kCallPou:
          for (std::uint32_t i = 0; i < inst.count && !charts; ++i) {
            const CallArg& arg = from.body.call_args[inst.b + i];
            if (arg.kind == CallArg::Kind::kOutput) note(pou, arg.place, inst, charts);
          }
          break;
        default:
          break;
      }
    }
  }

  void note(std::uint32_t pou, PlaceId place, const Inst& inst, bool chart) {
    const Pou& from = module_.pous[pou];
    const auto key = key_of(module_, pou, place);
    if (!key) return;
    if (!chart) {
      const auto known = writers_.find(*key);
      if (known == writers_.end()) return;
      std::vector<Write>& others = known->second.others;
      if (others.empty() || others.back().pou != pou) others.push_back({pou, from.body.sources[inst.source]});
      return;
    }
    // What charts keep for themselves, and the flags that they set.
    const Place* root = &from.body.places[place.index];
    while (root->parent.valid()) root = &from.body.places[root->parent.index];
    if (root->kind == Place::Kind::kInstance) {
      const Variable& variable = module_.owner_of(from).variables[root->index];
      if (!is_visible(variable) || core::folded(variable.name).starts_with("sfc")) return;
    }
    Writers& writers = writers_[*key];
    if (writers.text.empty()) writers.text = place_text(module_, from, place);
    const std::uint32_t owner = owner_of(pou);
    if (std::find(writers.charts.begin(), writers.charts.end(), owner) == writers.charts.end()) {
      writers.charts.push_back(owner);
      if (writers.charts.size() > 1) writers.others.push_back({pou, from.body.sources[inst.source]});
    }
  }

  void report(const Writers& writers) {
    const std::string& driver = module_.pous[writers.charts.front()].name;
    for (const Write& write : writers.others) {
      findings_.add(
          Lint::kChartVariable, write.at, module_.pous[write.pou].name,
          fmt::format("{} is an action of the chart of {}, and is written here, too", quoted(writers.text), driver),
          "the chart writes TRUE while the action is active and FALSE once when it ends: give the variable one "
          "writer, or let an action in ST assign it");
    }
  }

  const Module& module_;
  Findings& findings_;
  std::map<PathKey, Writers> writers_;
};

// ---- action-timer -------------------------------------------------------------------------------------------------

/// What all bodies do with one timer.
struct Timer {
  bool rearmed = false;       ///< somebody gives it the literal FALSE
  bool runs_outside = false;  ///< something but a frozen action runs it, too
  std::set<std::uint32_t> actions;
  Write first;
  std::string text;
  std::string_view type;
};

bool is_timer(const Type& type) {
  return type.kind == TypeKind::kBlock && std::any_of(type.block->fields.begin(), type.block->fields.end(),
                                                      [](const stdlib::Field& field) { return field.name == "PT"; });
}

void look_at_timers(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kActionTimer)) return;
  const bool any = std::any_of(module.pous.begin(), module.pous.end(), [](const Pou& pou) { return pou.freezes; });
  if (!any) return;
  std::map<PathKey, Timer> timers;
  for (std::uint32_t p = 0; p < module.pous.size(); ++p) {
    const Pou& pou = module.pous[p];
    for (const Inst& inst : pou.body.insts) {
      if (inst.op == Op::kStore) {
        const Place& port = pou.body.places[inst.a];
        const Inst& value = pou.body.insts[inst.b];
        if (port.kind != Place::Kind::kField || port.index != 0 || value.op != Op::kConst) continue;
        if (!is_timer(module.types[pou.body.places[port.parent.index].type])) continue;
        const auto key = key_of(module, p, port.parent);
        if (key && pou.body.constants[value.a].bits == 0) timers[*key].rearmed = true;
      } else if (inst.op == Op::kRun && inst.b == 0 && inst.part == Part::kPlain) {
        const Type& type = module.types[pou.body.places[inst.a].type];
        const auto key = is_timer(type) ? key_of(module, p, PlaceId{inst.a}) : std::nullopt;
        if (!key) continue;
        Timer& timer = timers[*key];
        if (!pou.freezes) {
          timer.runs_outside = true;
        } else if (timer.actions.insert(p).second && timer.actions.size() == 1 && findings.is_linted(pou)) {
          timer.first = {p, pou.body.sources[inst.source]};
          timer.text = place_text(module, pou, PlaceId{inst.a});
          timer.type = type.block->name;
        }
      }
    }
  }
  for (const auto& [key, timer] : timers) {
    // Several actions are what takes a timer from step to step.
    if (timer.rearmed || timer.runs_outside || timer.actions.size() != 1 || timer.text.empty()) continue;
    findings.add(Lint::kActionTimer, timer.first.at, module.pous[timer.first.pou].name,
                 fmt::format("{} {} runs only while this action is active: it keeps Q and ET when the action ends",
                             timer.type, quoted(timer.text)),
                 "call it in the body of a POU with the step in IN, as IN := Step.X, or choose --sfc-final-scan=on");
  }
}

}  // namespace

void lint_charts(const Module& module, Findings& findings) {
  if (findings.wants(Lint::kChartVariable)) ChartVariables(module, findings).run();
  look_at_timers(module, findings);
}

}  // namespace plc::ir
