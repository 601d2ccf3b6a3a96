#include "frontend-sfc/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/text.h"
#include "frontend-sfc/resolve.h"
#include "frontend-sfc/safety.h"
#include "stdlib/library.h"

namespace plc::sfc {

using core::Code;
using ir::TypeRef;

namespace {

constexpr TypeRef kTime = ir::ref_of(core::TypeId::kTime);
/// Name of the type of steps; no source can spell it.
constexpr const char* kStepType = "#STEP";

struct FlagRow {
  std::string_view name;
  core::TypeId type;
};
constexpr FlagRow kFlags[] = {
#define PLC_SFC_FLAG(Name, name, Type) {name, core::TypeId::k##Type},
#include "frontend-sfc/flags.def"
};

TypeRef step_type(ir::Module& module) {
  if (const auto known = module.types.find(kStepType)) return *known;
  ir::Type type;
  type.kind = ir::TypeKind::kStruct;
  type.name = kStepType;
  type.fields = {{"X", ir::kBoolType}, {"T", kTime}};
  module.types.declare(kStepType, std::move(type));
  return *module.types.find(kStepType);
}

class Preparation {
 public:
  Preparation(plcopen::Pou& pou, ir::Module& module, std::uint32_t index, core::Diagnostics& diagnostics)
      : from_(pou), module_(module), index_(index), diagnostics_(diagnostics) {}

  std::unique_ptr<PreparedCharts> run() {
    auto out = std::make_unique<PreparedCharts>();
    const std::size_t errors = diagnostics_.error_count();
    read_bodies(from_, index_, *out);
    for (const plcopen::Pou& action : from_.actions) {
      const auto known = pou().actions.find(action.name);
      if (known != pou().actions.end()) read_bodies(action, known->second, *out);
    }
    if (out->charts.empty()) return nullptr;
    if (from_.kind == plcopen::PouKind::kFunction) {
      diagnostics_.report(Code::P3111, out->charts.front().chart.at, pou().name,
                          "chart in the function \"" + pou().name + "\", which remembers nothing from call to call",
                          "make it a function block");
      return out;
    }
    for (PreparedChart& chart : out->charts) {
      declare_flags(chart.chart);
      chart.plan = make_plan(chart.chart);
      declare_steps(chart);
    }
    // Texts at steps become actions only now: the lists of actions were walked above.
    for (PreparedChart& chart : out->charts) {
      prepare_actions(chart);
      // A chart that is not read whole has dead ends of its own.
      const bool whole = diagnostics_.error_count() == errors;
      if (whole && !pou().from_library) report_unsafe(chart.chart, chart.plan, diagnostics_);
    }
    return out;
  }

 private:
  ir::Pou& pou() { return module_.pous[index_]; }

  std::uint32_t hidden(std::string_view hint, TypeRef type) {
    ir::Variable v;
    v.name = fmt::format("#{}.{}", hint, pou().variables.size());
    v.type = type;
    v.role = ir::Role::kHidden;
    pou().variables.push_back(std::move(v));
    return static_cast<std::uint32_t>(pou().variables.size() - 1);
  }

  void read_bodies(const plcopen::Pou& from, std::uint32_t index, PreparedCharts& out) {
    for (std::uint32_t b = 0; b < from.bodies.size(); ++b) {
      const plcopen::Body& body = from.bodies[b];
      const bool unread = body.drawn_elements != 0 && body.elements.empty() && body.text.empty();
      if (body.language != plcopen::Language::kSfc || unread) continue;
      PreparedChart& chart = out.charts.emplace_back();
      chart.pou = index;
      chart.body = b;
      chart.chart = read_chart(body, module_.pous[index].name, diagnostics_);
    }
  }

  /// Flags that the settings of a chart declare are variables of the POU, which its bodies may name.
  void declare_flags(const Chart& chart) {
    for (const std::string& used : chart.flags) {
      const auto* const row = std::find_if(std::begin(kFlags), std::end(kFlags),
                                           [&](const FlagRow& f) { return core::iequals(f.name, used); });
      if (row == std::end(kFlags)) {
        diagnostics_.report(Code::P3109, chart.at, chart.name, "chart uses the flag " + used + ", which is not known",
                            "switch it off in the settings of the chart");
        continue;
      }
      if (pou().by_name.contains(std::string(row->name))) continue;
      ir::Variable flag;
      flag.name = row->name;
      flag.type =
          row->type == core::TypeId::kString ? module_.types.string(core::TypeId::kString, 80) : ir::ref_of(row->type);
      flag.at = chart.at;
      pou().by_name.emplace(flag.name, static_cast<std::uint32_t>(pou().variables.size()));
      pou().variables.push_back(std::move(flag));
    }
  }

  [[nodiscard]] bool is_taken(std::string_view name) {
    const auto& all = pou().variables;
    return std::any_of(all.begin(), all.end(), [&](const ir::Variable& v) { return core::iequals(v.name, name); });
  }

  void declare_steps(PreparedChart& chart) {
    const bool action = chart.pou != index_;
    const std::string& body = module_.pous[chart.pou].name;
    const std::string prefix = action ? body.substr(body.rfind('.') + 1) + "_" : std::string();
    for (const Step& step : chart.chart.steps) {
      PreparedStep out;
      ir::Variable variable;
      variable.name = prefix + step.name;
      if (!action && is_taken(step.name) && pou().by_name.contains(step.name)) {
        diagnostics_.report(Code::P3102, step.at, chart.chart.name,
                            "step \"" + step.name + "\" has the name of a variable of " + pou().name,
                            "rename one of them");
      }
      while (is_taken(variable.name)) variable.name += '_';
      variable.type = step_type(module_);
      variable.step = true;
      variable.at = step.at;
      out.variable = static_cast<std::uint32_t>(pou().variables.size());
      pou().variables.push_back(std::move(variable));
      out.since = hidden("since", kTime);
      out.on = hidden("on", ir::kBoolType);
      out.off = hidden("off", ir::kBoolType);
      chart.steps.push_back(std::move(out));
    }
  }

  // ---- actions ----

  /// An action that is written at a step: one of the POU, by a name that no source can spell.
  Target written(const Association& action, const Step& step) {
    plcopen::Pou body;
    body.name = fmt::format("{}#{}", step.name, from_.actions.size());
    body.kind = from_.kind;
    body.at = action.at;
    plcopen::Body& text = body.bodies.emplace_back();
    text.language = plcopen::Language::kSt;
    text.text = action.text;
    text.at = text.text_at = action.text_at.line != 0 ? action.text_at : action.at;
    text.drawn_elements = 1;
    ir::Pou made;
    made.name = pou().name + "." + step.name;
    made.kind = pou().kind;
    made.at = action.at;
    made.owner = index_;
    made.from_library = pou().from_library;
    Target target;
    target.kind = Target::Kind::kAction;
    target.action = static_cast<std::uint32_t>(module_.pous.size());
    target.at = action.at;
    target.name = "ST at step \"" + step.name + '"';
    pou().actions.emplace(body.name, target.action);
    module_.pous.push_back(std::move(made));
    from_.actions.push_back(std::move(body));
    return target;
  }

  Target step_action(const std::string& name, const Step& step) {
    if (name.empty()) return {};
    return resolve(module_, pou(), name, step, step.at, true, diagnostics_);
  }

  void prepare_actions(PreparedChart& chart) {
    struct Found {
      std::uint32_t step;
      std::uint32_t association;
      Target target;
    };
    std::vector<Found> all;
    for (std::uint32_t s = 0; s < chart.chart.steps.size(); ++s) {
      const Step& step = chart.chart.steps[s];
      PreparedStep& out = chart.steps[s];
      out.entry = step_action(step.entry, step);
      out.main = step_action(step.main, step);
      out.exit = step_action(step.exit, step);
      if (out.entry.kind != Target::Kind::kNothing) out.entered = hidden("entered", ir::kBoolType);
      if (out.exit.kind != Target::Kind::kNothing) out.left = hidden("left", ir::kBoolType);
      for (std::uint32_t a = 0; a < step.actions.size(); ++a) {
        const Association& one = step.actions[a];
        if (needs_time(one.qualifier) && one.duration.empty()) {
          diagnostics_.report(Code::P3107, one.at, chart.chart.name,
                              "action \"" + one.name + "\" of step \"" + step.name + "\" has the qualifier " +
                                  std::string(qualifier_word(one.qualifier)) + " and no time",
                              "write one, as T#2s, or the name of a TIME variable");
          continue;
        }
        Target target =
            one.has_text ? written(one, step) : resolve(module_, pou(), one.name, step, one.at, false, diagnostics_);
        if (target.kind != Target::Kind::kNothing) all.push_back({s, a, std::move(target)});
      }
    }
    std::stable_partition(all.begin(), all.end(),
                          [](const Found& one) { return one.target.kind == Target::Kind::kVariable; });
    std::map<std::string, std::uint32_t> by_key;
    for (Found& one : all) {
      const auto [known, fresh] = by_key.emplace(key_of(one.target), static_cast<std::uint32_t>(chart.controls.size()));
      if (fresh) {
        Control control;
        control.target = std::move(one.target);
        control.active = hidden("q", ir::kBoolType);
        control.pending = hidden("pending", ir::kBoolType);
        if (control.runs_body()) {
          control.due = hidden("due", ir::kBoolType);
          control.ends = hidden("ends", ir::kBoolType);
        }
        chart.controls.push_back(std::move(control));
      }
      const std::uint32_t input =
          add_input(chart.controls[known->second], chart.chart.steps[one.step].actions[one.association]);
      chart.steps[one.step].uses.push_back({known->second, input, one.association});
    }
  }

  std::uint32_t add_input(Control& control, const Association& action) {
    const bool timed = needs_time(action.qualifier);
    const bool pulse =
        action.qualifier == Qualifier::kP || action.qualifier == Qualifier::kP0 || action.qualifier == Qualifier::kP1;
    for (std::uint32_t i = 0; i < control.inputs.size() && !timed && !pulse; ++i) {
      if (control.inputs[i].qualifier == action.qualifier) return i;
    }
    Input input;
    input.qualifier = action.qualifier;
    input.duration = action.duration;
    input.at = action.at;
    input.active = hidden("input", ir::kBoolType);
    switch (action.qualifier) {
      case Qualifier::kN:
      case Qualifier::kR:
      case Qualifier::kL:
      case Qualifier::kD:
        break;
      default:
        input.memory = hidden("memory", ir::kBoolType);
    }
    if (timed) input.timer = hidden("timer", module_.types.block(*stdlib::block_named("TON")));
    control.inputs.push_back(std::move(input));
    return static_cast<std::uint32_t>(control.inputs.size() - 1);
  }

  plcopen::Pou& from_;
  ir::Module& module_;
  std::uint32_t index_;
  core::Diagnostics& diagnostics_;
};

}  // namespace

void PreparedCharts::name_steps(ir::Module& module, std::uint32_t pou) const {
  ir::Pou& owner = module.pous[pou];
  std::map<std::string, std::uint32_t> count;
  for (const PreparedChart& chart : charts) {
    for (const Step& step : chart.chart.steps) ++count[core::folded(step.name)];
  }
  for (const bool own : {true, false}) {
    for (const PreparedChart& chart : charts) {
      if ((chart.pou == pou) != own) continue;
      for (std::size_t s = 0; s < chart.steps.size(); ++s) {
        const std::string& name = chart.chart.steps[s].name;
        if (own || count[core::folded(name)] == 1) owner.by_name.emplace(name, chart.steps[s].variable);
      }
    }
  }
}

std::unique_ptr<PreparedCharts> prepare(plcopen::Pou& pou, ir::Module& module, std::uint32_t index,
                                        core::Diagnostics& diagnostics) {
  auto out = Preparation(pou, module, index, diagnostics).run();
  if (out) out->name_steps(module, index);
  return out;
}

}  // namespace plc::sfc
