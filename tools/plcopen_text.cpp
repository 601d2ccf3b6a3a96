#include "tools/plcopen_text.h"

#include <fmt/format.h>

namespace plc::tools {

using core::TypeId;

std::string xml_escaped(std::string_view text) {
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
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string documentation_xml(std::string_view text) {
  return fmt::format("<documentation><xhtml:p>{}</xhtml:p></documentation>", xml_escaped(text));
}

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

std::string variable_xml(std::string_view name, const std::string& type, std::string_view summary,
                         std::string_view initial) {
  return fmt::format(
      "            <variable name=\"{}\"><type>{}</type>{}{}</variable>\n", name, type,
      initial.empty() ? ""
                      : fmt::format("<initialValue><simpleValue value=\"{}\"/></initialValue>", xml_escaped(initial)),
      summary.empty() ? "" : documentation_xml(summary));
}

std::string section_xml(std::string_view element, const std::string& variables) {
  if (variables.empty()) return {};
  return fmt::format("          <{}>\n{}          </{}>\n", element, variables, element.substr(0, element.find(' ')));
}

std::string pou_xml(std::string_view name, std::string_view kind, const std::string& interface,
                    std::string_view documentation, std::string_view body_comment) {
  return fmt::format(
      "      <pou name=\"{}\" pouType=\"{}\">\n        <interface>\n{}        </interface>\n"
      "        <body><ST><xhtml:p>(* {} *)</xhtml:p></ST></body>\n        {}\n      </pou>\n",
      name, kind, interface, body_comment, documentation_xml(documentation));
}

std::string project_xml(std::string_view name, const std::string& data_types, const std::string& pous) {
  return fmt::format(
      R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201" xmlns:xhtml="http://www.w3.org/1999/xhtml">
  <fileHeader companyName="PICARD" productName="PICARD" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
  <contentHeader name="{}">
    <coordinateInfo>
      <fbd><scaling x="1" y="1"/></fbd>
      <ld><scaling x="1" y="1"/></ld>
      <sfc><scaling x="1" y="1"/></sfc>
    </coordinateInfo>
  </contentHeader>
  <types>
{}    <pous>
{}    </pous>
  </types>
  <instances>
    <configurations/>
  </instances>
</project>
)",
      xml_escaped(name),
      data_types.empty() ? "    <dataTypes/>\n" : fmt::format("    <dataTypes>\n{}    </dataTypes>\n", data_types),
      pous);
}

}  // namespace plc::tools
