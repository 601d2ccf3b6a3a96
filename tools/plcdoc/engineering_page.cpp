// engineering.md: the calls of the engineering server, with an example each that a test runs.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "engineering/call.h"
#include "tools/plcdoc/pages.h"

namespace plc::tools {
namespace {

using engineering::Call;
using engineering::Field;
using engineering::FieldType;
using engineering::Form;
using engineering::Json;
using engineering::Method;
using engineering::Right;

std::string type_of(const Field& field) {
  switch (field.type) {
    case FieldType::kText: {
      if (field.choices.empty())
        return field.high != 0 ? fmt::format("text of {} to {} bytes", field.low, field.high) : "text";
      std::string text;
      for (const char c : field.choices) text += c == '|' ? std::string("`, `") : std::string(1, c);
      return "`" + text + "`";
    }
    case FieldType::kInteger:
      if (field.high == INT64_MAX && field.low == INT64_MIN) return "whole number";
      return field.high == INT64_MAX ? fmt::format("whole number from {} on", field.low)
                                     : fmt::format("whole number from {} to {}", field.low, field.high);
    case FieldType::kNumber:
      return "number";
    case FieldType::kBoolean:
      return "true or false";
    case FieldType::kValue:
      return "[value](#values-as-json)";
    case FieldType::kRecord:
      return fmt::format("[{}](#records)", field.record->name);
    case FieldType::kFile:
      return "bytes, the body of the request";
    case FieldType::kTexts:
      return field.high != 0 ? fmt::format("list of at most {} texts", field.high) : "list of texts";
    case FieldType::kNumbers:
      return field.high != 0 ? fmt::format("list of at most {} whole numbers", field.high) : "list of whole numbers";
    case FieldType::kRecords:
      return fmt::format("list of [{}](#records)", field.record->name);
  }
  return "";
}

std::string fields_table(std::span<const Field> fields) {
  std::vector<std::vector<std::string>> rows;
  for (const Field& field : fields) {
    rows.push_back(
        {as_code(field.name), type_of(field) + (field.required ? "" : ", optional"), std::string(field.doc)});
  }
  return table({"field", "type", ""}, rows);
}

/// As one would type it; $URL and $TOKEN are set.
std::string curl_of(const Call& call) {
  const Json example = Json::parse(call.example);
  const std::string to = call.form == Form::kFile ? " -o " + std::string(call.name) : "";
  std::string command = "curl -s";
  if (call.right != Right::kAnybody) command += " -H \"Authorization: Bearer $TOKEN\"";
  if (const Field* const file = engineering::file_field(call)) {
    std::string query;
    for (const auto& [name, value] : example.items()) {
      if (name != file->name) query += (query.empty() ? "?" : "&") + name + "=" + value.get<std::string>();
    }
    return command + fmt::format(" \\\n  -H 'Content-Type: application/octet-stream' --data-binary @{} $URL{}{}",
                                 example[std::string(file->name)].get<std::string>(), call.path, query);
  }
  if (call.method == Method::kPost) {
    return command + fmt::format(" \\\n  -H 'Content-Type: application/json' -d '{}' $URL{}", call.example, call.path) +
           to;
  }
  std::string query;
  for (const auto& [name, value] : example.items()) {
    command += query.empty() ? " -G" : "";
    query += fmt::format(" \\\n  --data-urlencode {}={}", name,
                         value.is_string() ? fmt::format("'{}'", value.get<std::string>()) : value.dump());
  }
  return command + fmt::format(" $URL{}", call.path) + query + to;
}

}  // namespace

Page engineering_page() {
  std::string text = generated_from("engineering/calls_*.cpp") +
                     "# Calls of the engineering server\n\n"
                     "What clients can ask of a running `plc-run`. The [guide](../guides/engineering.md) says how to "
                     "begin; `GET /api/openapi.json` gives "
                     "the same as an OpenAPI 3.1\ndocument. Each call is also a method of the Python module `picard`, "
                     "and a name for `plc remote URL NAME FIELD=VALUE`.\n\n"
                     "A call is made with GET, its fields in the query, or with POST, its fields as a JSON object; a "
                     "call that takes a "
                     "file has that as its body, and its other fields in the query. Who "
                     "calls is a header "
                     "`Authorization: Bearer SECRET`, or a cookie.\n"
                     "A refusal has a status from 400 on and an object with `code` ([what it means](problems.md)), "
                     "`text`, and, where they are known, `field`, "
                     "`help` and `retry_after_ms`.\n\n"
                     "In the examples `URL=http://127.0.0.1:8061`, and `TOKEN` is what `login` or `tokens.add` has "
                     "given. They are for "
                     "[the mixing station](../../examples/tank/README.md).\n\n"
                     "## Overview\n\n";
  std::vector<std::vector<std::string>> rows;
  const auto anchor = [](const Call& call) {
    std::string name;
    for (const char c : call.name) name += c == '.' ? "" : std::string(1, c);
    return name;
  };
  for (const Call& call : engineering::calls()) {
    rows.push_back({fmt::format("[{}](#{})", call.name, anchor(call)),
                    as_code(fmt::format("{} {}", call.method == Method::kGet ? "GET" : "POST", call.path)),
                    std::string(engineering::right_text(call.right)),
                    std::string(call.doc.substr(0, call.doc.find(". ")))});
    if (!rows.back().back().ends_with('.')) rows.back().back() += '.';
  }
  text += table({"call", "request", "right", "what it does"}, rows);
  for (const Call& call : engineering::calls()) {
    text +=
        fmt::format("\n## {}\n\n`{} {}`, right: {}\n\n{}\n", call.name, call.method == Method::kGet ? "GET" : "POST",
                    call.path, engineering::right_text(call.right), call.doc);
    if (!call.request.empty()) text += "\n" + fields_table(call.request);
    if (!call.response.empty()) text += "\nAnswer:\n\n" + fields_table(call.response);
    if (!call.example.empty()) text += fmt::format("\n```sh\n{}\n```\n", curl_of(call));
  }
  text +=
      "\n## Values as JSON\n\n"
      "| type | JSON |\n| --- | --- |\n"
      "| BOOL | `true`, `false` |\n"
      "| numbers and bit strings of up to 32 bits | number |\n"
      "| LINT, ULINT, LWORD | text with the number: JavaScript has no such numbers |\n"
      "| REAL, LREAL | number; `\"NaN\"`, `\"Infinity\"`, `\"-Infinity\"` |\n"
      "| STRING, WSTRING, CHAR, WCHAR | text |\n"
      "| enumerations | text with the name of the member |\n"
      "| TIME, DATE and their like | text with the literal, `\"T#1s500ms\"` |\n"
      "| arrays | list of all elements |\n"
      "| structures, function blocks | object; a write may name some of the fields |\n"
      "| references | `null` |\n"
      "\n## Records\n";
  for (const engineering::Record* record : engineering::records()) {
    text += fmt::format("\n### {}\n\n{}\n\n", record->name, record->doc) + fields_table(record->fields);
  }
  return {"engineering.md", text};
}

}  // namespace plc::tools
