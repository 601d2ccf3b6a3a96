#include "frontend-sfc/lower.h"

#include "core/text.h"
#include "frontend-il/text.h"
#include "frontend-ld/lower.h"
#include "frontend-sfc/evaluation.h"
#include "frontend-sfc/name_scope.h"
#include "frontend-st/text.h"
#include "ir/builder.h"

namespace plc::sfc {

using core::Code;

bool lower_body(const PreparedCharts& charts, ir::Module& module, std::uint32_t pou_index,
                core::Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.error_count();
  ir::Builder builder(module, pou_index, diagnostics);
  const std::uint32_t owner = module.pous[pou_index].owner;
  NameScope scope(module, owner == ir::Pou::kDeclared ? pou_index : owner);
  st::lower_prologue(builder);
  for (const PreparedChart& chart : charts.charts) {
    if (chart.pou != pou_index || chart.steps.size() != chart.chart.steps.size()) continue;
    for (std::size_t s = 0; s < chart.steps.size(); ++s) scope.add(chart.chart.steps[s].name, chart.steps[s].variable);
    Evaluation(builder, chart, charts).emit();
  }
  const bool good = diagnostics.error_count() == errors;
  module.pous[pou_index].compiled = good;
  return good;
}

namespace {

bool lower_transition_text(const plcopen::Body& body, const std::string& name, ir::Builder& builder,
                           std::uint32_t result) {
  Condition condition;
  condition.text = body.text;
  condition.at = body.text_at.line != 0 ? body.text_at : body.at;
  trim_condition(condition, name);
  const auto value = st::lower_expression(condition.text, condition.at, builder, ir::kBoolType);
  return value && builder.assign(builder.variable(result), *value, "transition \"" + name + '"');
}

}  // namespace

bool lower_transition(const plcopen::Pou& transition, ir::Module& module, std::uint32_t pou_index,
                      core::Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.error_count();
  const std::uint32_t owner = module.pous[pou_index].owner;
  const std::uint32_t result = module.transitions.at(pou_index).result;
  // The result of a condition without a name is one that nothing can name.
  const bool unnamed = transition.result.empty() && transition.name.starts_with('#');
  const std::string name = unnamed ? "condition" : transition.result.empty() ? transition.name : transition.result;
  NameScope scope(module, owner);
  if (!unnamed) scope.add(name, result);
  bool good = !transition.bodies.empty();
  if (!good) {
    diagnostics.report(Code::P3105, transition.at, module.pous[pou_index].name, "transition has no condition",
                       "write one; TRUE goes on at once");
    return false;
  }
  switch (transition.bodies.front().language) {
    case plcopen::Language::kLd:
    case plcopen::Language::kFbd:
      if (unnamed) {
        diagnostics.report(Code::P3105, transition.at, module.pous[module.pous[pou_index].owner].name,
                           "drawn condition has no name for its result: \"condition\" is a variable",
                           "give the condition a name, or the variable another one");
        return false;
      }
      return ld::lower_body(transition, module, pou_index, diagnostics);
    case plcopen::Language::kSt: {
      ir::Builder builder(module, pou_index, diagnostics);
      good = lower_transition_text(transition.bodies.front(), name, builder, result);
      break;
    }
    case plcopen::Language::kIl: {
      ir::Builder builder(module, pou_index, diagnostics);
      const plcopen::Body& body = transition.bodies.front();
      const auto value = il::lower_value(body.text, body.text_at.line != 0 ? body.text_at : body.at, builder);
      good = value && builder.assign(builder.variable(result), *value, "transition \"" + name + '"');
      break;
    }
    default:
      good = false;
      diagnostics.report(Code::P3105, transition.at, module.pous[pou_index].name,
                         std::string("condition is written in ") +
                             plcopen::language_name(transition.bodies.front().language) +
                             ", which a condition cannot be",
                         "write it in ST, LD, FBD or IL");
  }
  good = good && diagnostics.error_count() == errors;
  module.pous[pou_index].compiled = good;
  return good;
}

}  // namespace plc::sfc
