#include "tools/library_xml.h"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "core/text.h"
#include "tools/library_text.h"

namespace plc::tools {
namespace {

using core::TypeId;
using stdlib::Direction;

constexpr std::string_view kHead = R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201" xmlns:xhtml="http://www.w3.org/1999/xhtml">
  <fileHeader companyName="PICARD" productName="PICARD" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
  <contentHeader name="picard-library">
    <coordinateInfo>
      <fbd><scaling x="1" y="1"/></fbd>
      <ld><scaling x="1" y="1"/></ld>
      <sfc><scaling x="1" y="1"/></sfc>
    </coordinateInfo>
  </contentHeader>
  <types>
    <dataTypes/>
    <pous>
)";
constexpr std::string_view kTail = R"(    </pous>
  </types>
  <instances>
    <configurations/>
  </instances>
</project>
)";

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string documentation(std::string_view text) {
  return fmt::format("<documentation><xhtml:p>{}</xhtml:p></documentation>", escaped(text));
}

/// The schema has elements for the types of the second edition; those of the third are types by name.
std::string type_xml(TypeId type) {
  switch (type) {
    case TypeId::kString:
      return "<string/>";
    case TypeId::kWstring:
      return "<wstring/>";
    case TypeId::kLtime:
    case TypeId::kLdate:
    case TypeId::kLtod:
    case TypeId::kLdt:
    case TypeId::kChar:
    case TypeId::kWchar:
      return fmt::format("<derived name=\"{}\"/>", core::name_of(type));
    case TypeId::kTod:
    case TypeId::kDt:
      return fmt::format("<{}/>", core::info(type).alias);
    default:
      return fmt::format("<{}/>", core::name_of(type));
  }
}

/// A type variable is the smallest generic type of the schema that holds all its types.
std::string type_xml(const stdlib::FunctionSpec& spec, stdlib::ParamType type) {
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

std::string variable_xml(std::string_view name, const std::string& type, std::string_view summary) {
  return fmt::format("            <variable name=\"{}\"><type>{}</type>{}</variable>\n", name, type,
                     summary.empty() ? "" : documentation(summary));
}

/// The variables of one direction inside their element, or nothing.
std::string section_xml(std::string_view element, const std::string& variables) {
  if (variables.empty()) return {};
  return fmt::format("          <{0}>\n{1}          </{0}>\n", element, variables);
}

std::string pou_xml(std::string_view name, std::string_view kind, const std::string& interface,
                    std::string_view summary, std::string_view clause) {
  return fmt::format(
      "      <pou name=\"{0}\" pouType=\"{1}\">\n        <interface>\n{2}        </interface>\n"
      "        <body><ST><xhtml:p>(* The runtime has the body: plc lib {0} *)</xhtml:p></ST></body>\n"
      "        {3}\n      </pou>\n",
      name, kind, interface, documentation(fmt::format("{} ({})", summary, clause)));
}

std::string function_xml(const stdlib::FunctionSpec& spec) {
  std::string inputs;
  for (std::size_t i = 0; i < spec.param_count; ++i) {
    inputs += variable_xml(spec.params[i].name, type_xml(spec, spec.params[i].type), {});
  }
  return pou_xml(spec.name, "function",
                 fmt::format("          <returnType>{}</returnType>\n", type_xml(spec, spec.result)) +
                     section_xml("inputVars", inputs),
                 spec.summary, spec.clause);
}

std::string block_xml(const stdlib::BlockSpec& block) {
  const auto section = [&block](std::string_view element, Direction direction) {
    std::string variables;
    for (const stdlib::Field& field : block.fields) {
      if (field.direction == direction) variables += variable_xml(field.name, type_xml(field.type), field.summary);
    }
    return section_xml(element, variables);
  };
  return pou_xml(block.name, "functionBlock",
                 section("inputVars", Direction::kInput) + section("outputVars", Direction::kOutput) +
                     section("inOutVars", Direction::kInOut),
                 block.summary, block.clause);
}

}  // namespace

std::string library_xml(std::span<const stdlib::FunctionSpec* const> functions,
                        std::span<const stdlib::BlockSpec* const> blocks) {
  std::string text(kHead);
  // Rows of one name are one POU: a project cannot have two.
  std::set<std::string_view> written;
  for (const stdlib::FunctionSpec* spec : functions) {
    if (!is_family(*spec) && written.insert(spec->name).second) text += function_xml(*spec);
  }
  for (const stdlib::BlockSpec* block : blocks) text += block_xml(*block);
  text += kTail;
  return text;
}

std::string library_xml() {
  std::vector<const stdlib::FunctionSpec*> functions;
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (!stdlib::is_standard(spec->clause) && !stdlib::is_bundle_output(*spec)) functions.push_back(spec);
  }
  std::vector<const stdlib::BlockSpec*> blocks;
  for (const stdlib::BlockSpec& block : stdlib::blocks()) {
    if (!stdlib::is_standard(block.clause)) blocks.push_back(&block);
  }
  return library_xml(functions, blocks);
}

}  // namespace plc::tools
