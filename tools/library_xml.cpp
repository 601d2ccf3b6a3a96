#include "tools/library_xml.h"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "core/text.h"
#include "tools/library_text.h"
#include "tools/plcopen_text.h"

namespace plc::tools {
namespace {

using stdlib::Direction;

/// A type variable is the smallest generic type of the schema that holds all its types.
std::string param_type_xml(const stdlib::FunctionSpec& spec, stdlib::ParamType type) {
  if (type.kind == stdlib::ParamType::Kind::kFixed) return type_xml(type.fixed);
  const std::uint16_t categories = type.kind == stdlib::ParamType::Kind::kT ? spec.t_categories : spec.u_categories;
  constexpr struct {
    std::string_view name;
    std::uint16_t categories;
  } kGenerics[] = {{"ANY_REAL", core::kAnyReal},
                   {"ANY_INT", core::kAnyInt},
                   {"ANY_BIT", core::kAnyBit},
                   {"ANY_STRING", core::kAnyString},
                   {"ANY_DATE", core::kAnyDate},
                   {"ANY_NUM", core::kAnyNum},
                   {"ANY_MAGNITUDE", core::kAnyMagnitude},
                   {"ANY_ELEMENTARY", core::kAnyElementary}};
  for (const auto& generic : kGenerics) {
    if ((categories & ~generic.categories) == 0) return fmt::format("<{}/>", generic.name);
  }
  return "<ANY/>";
}

std::string row_xml(std::string_view name, std::string_view kind, const std::string& interface,
                    std::string_view summary, std::string_view clause) {
  return pou_xml(name, kind, interface, fmt::format("{} ({})", summary, clause),
                 fmt::format("The runtime has the body: plc lib {}", name));
}

std::string function_xml(const stdlib::FunctionSpec& spec) {
  std::string inputs;
  for (std::size_t i = 0; i < spec.param_count; ++i) {
    inputs += variable_xml(spec.params[i].name, param_type_xml(spec, spec.params[i].type), {});
  }
  return row_xml(spec.name, "function",
                 fmt::format("          <returnType>{}</returnType>\n", param_type_xml(spec, spec.result)) +
                     section_xml("inputVars", inputs),
                 spec.summary, spec.clause);
}

std::string bundle_xml(const stdlib::BundleSpec& bundle) {
  std::string outputs;
  for (const stdlib::FunctionSpec* output : bundle.outputs) {
    outputs += variable_xml(stdlib::output_name(*output), param_type_xml(*output, output->result), output->summary);
  }
  return row_xml(bundle.name, "function",
                 section_xml("inputVars", variable_xml(bundle.input.name, type_xml(bundle.input.type.fixed), {})) +
                     section_xml("outputVars", outputs),
                 bundle.summary, bundle.clause);
}

std::string special_xml(const stdlib::SpecialSpec& special) {
  return row_xml(special.name, "function",
                 "          <returnType><ANY/></returnType>\n" +
                     section_xml("inputVars", variable_xml(stdlib::kDrawnInput, "<ANY/>", {})),
                 special.summary, special.clause);
}

std::string block_xml(const stdlib::BlockSpec& block) {
  const auto section = [&block](std::string_view element, Direction direction) {
    std::string variables;
    for (const stdlib::Field& field : block.fields) {
      if (field.direction == direction) variables += variable_xml(field.name, type_xml(field.type), field.summary);
    }
    return section_xml(element, variables);
  };
  return row_xml(block.name, "functionBlock",
                 section("inputVars", Direction::kInput) + section("outputVars", Direction::kOutput) +
                     section("inOutVars", Direction::kInOut),
                 block.summary, block.clause);
}

}  // namespace

std::string library_xml(std::span<const stdlib::FunctionSpec* const> functions,
                        std::span<const stdlib::BundleSpec* const> bundles,
                        std::span<const stdlib::SpecialSpec* const> specials,
                        std::span<const stdlib::BlockSpec* const> blocks) {
  std::string pous;
  // Rows of one name are one POU: a project cannot have two.
  std::set<std::string_view> written;
  for (const stdlib::FunctionSpec* spec : functions) {
    if (!is_family(*spec) && written.insert(spec->name).second) pous += function_xml(*spec);
  }
  for (const stdlib::BundleSpec* bundle : bundles) pous += bundle_xml(*bundle);
  for (const stdlib::SpecialSpec* special : specials) {
    if (special->drawn_only) pous += special_xml(*special);
  }
  for (const stdlib::BlockSpec* block : blocks) pous += block_xml(*block);
  return project_xml("picard-library", {}, pous);
}

std::string library_xml() {
  std::vector<const stdlib::FunctionSpec*> functions;
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (!stdlib::is_standard(spec->clause) && !stdlib::is_bundle_output(*spec)) functions.push_back(spec);
  }
  const auto own = [](const auto& rows) {
    std::vector<decltype(&rows[0])> found;
    for (const auto& row : rows) {
      if (!stdlib::is_standard(row.clause)) found.push_back(&row);
    }
    return found;
  };
  return library_xml(functions, own(stdlib::bundles()), own(stdlib::specials()), own(stdlib::blocks()));
}

}  // namespace plc::tools
