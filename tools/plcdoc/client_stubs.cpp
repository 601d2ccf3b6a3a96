#include "tools/plcdoc/client_stubs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "engineering/call.h"

namespace plc::tools {
namespace {

using engineering::Call;
using engineering::calls;
using engineering::Field;
using engineering::FieldType;
using engineering::Form;
using engineering::Method;

const char* method_of(const Call& call) { return call.method == Method::kGet ? "GET" : "POST"; }

std::string with_underscores(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '.', '_');
  return text;
}

/// "from" is a word of Python.
std::string python_name(std::string_view field) {
  static constexpr std::array<std::string_view, 8> kWords = {"from", "in", "is", "class", "def", "pass", "for", "with"};
  return std::string(field) + (std::find(kWords.begin(), kWords.end(), field) != kWords.end() ? "_" : "");
}

/// Lines of at most 116 characters.
std::string wrapped(std::string_view text, const std::string& indent, const std::string& first = {}) {
  constexpr std::size_t kMost = 116;
  std::string out = indent + first, line = out;
  out.clear();
  while (!text.empty()) {
    const std::size_t blank = text.find(' ');
    const std::string_view word = text.substr(0, blank);
    text = blank == std::string_view::npos ? std::string_view{} : text.substr(blank + 1);
    if (line.size() + word.size() + 1 > kMost) {
      out += line + '\n';
      line = indent + (first.empty() ? "" : "    ");
    }
    line += (line.empty() || line.back() == ' ' ? "" : " ") + std::string(word);
  }
  return out + line + '\n';
}

std::string python_type(const Field& field) {
  switch (field.type) {
    case FieldType::kText:
      return "str";
    case FieldType::kInteger:
      return "int";
    case FieldType::kNumber:
      return "float";
    case FieldType::kBoolean:
      return "bool";
    case FieldType::kValue:
      return "value";
    case FieldType::kRecord:
      return std::string(field.record->name);
    case FieldType::kFile:
      return "bytes";
    case FieldType::kTexts:
      return "list of str";
    case FieldType::kNumbers:
      return "list of int";
    case FieldType::kRecords:
      return fmt::format("list of {}", field.record->name);
  }
  return "";
}

std::string python_fields(std::span<const Field> fields, const std::string& indent) {
  std::string text;
  for (const Field& field : fields) {
    std::string doc(field.doc);
    if (!field.choices.empty()) doc += fmt::format(" ({})", field.choices);
    text += wrapped(
        doc, indent,
        fmt::format("{} ({}{}):", python_name(field.name), python_type(field), field.required ? "" : ", optional"));
  }
  return text;
}

std::string python_method(const Call& call) {
  std::string parameters, fields;
  for (const bool required : {true, false}) {
    for (const Field& field : call.request) {
      if (field.required == required)
        parameters += fmt::format(", {}{}", python_name(field.name), required ? "" : "=None");
    }
  }
  std::string file = call.form == Form::kFile ? ", file=True" : "";
  for (const Field& field : call.request) {
    if (field.type == FieldType::kFile) {
      file += ", body=" + python_name(field.name);
    } else {
      fields += fmt::format("{}\"{}\": {}", fields.empty() ? "" : ", ", field.name, python_name(field.name));
    }
  }
  std::string text = fmt::format("\n    def {}(self{}):\n", with_underscores(call.name), parameters);
  text += wrapped(fmt::format("\"\"\"{} Right: {}.", call.doc, engineering::right_text(call.right)), "        ");
  if (!call.request.empty()) text += "\n" + python_fields(call.request, "        ");
  if (!call.response.empty()) text += "\n        Answer, a dict:\n" + python_fields(call.response, "          ");
  text += "        \"\"\"\n";
  return text +
         fmt::format("        return self.call(\"{}\", \"{}\", {{{}}}{})\n", method_of(call), call.path, fields, file);
}

std::string typescript_type(const Field& field) {
  switch (field.type) {
    case FieldType::kText: {
      if (field.choices.empty()) return "string";
      std::string text;
      for (std::string_view rest = field.choices; !rest.empty();) {
        const std::size_t bar = rest.find('|');
        text += fmt::format("{}\"{}\"", text.empty() ? "" : " | ", rest.substr(0, bar));
        rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
      }
      return text;
    }
    case FieldType::kInteger:
    case FieldType::kNumber:
      return "number";
    case FieldType::kBoolean:
      return "boolean";
    case FieldType::kValue:
      return "AnyValue";
    case FieldType::kRecord:
      return std::string(field.record->name);
    case FieldType::kFile:
      return "Blob";
    case FieldType::kTexts:
      return "string[]";
    case FieldType::kNumbers:
      return "number[]";
    case FieldType::kRecords:
      return std::string(field.record->name) + "[]";
  }
  return "";
}

std::string typescript_fields(std::span<const Field> fields) {
  std::string text;
  for (const Field& field : fields) {
    text += fmt::format("  /** {}. */\n  {}{}: {};\n", field.doc, field.name, field.required ? "" : "?",
                        typescript_type(field));
  }
  return text;
}

/// "valuesRead", "ValuesRead".
std::string camel(std::string_view name, bool upper) {
  std::string text;
  for (const char c : name) {
    if (c == '.' || c == '_') {
      upper = true;
    } else {
      text += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      upper = false;
    }
  }
  return text;
}

std::string typescript_method(const Call& call) {
  const std::string type = camel(call.name, true);
  const bool needed = std::any_of(call.request.begin(), call.request.end(), [](const Field& f) { return f.required; });
  const std::string parameter =
      call.request.empty() ? "" : fmt::format("fields: {}Request{}", type, needed ? "" : " = {}");
  const std::string fields = call.request.empty() ? "{}" : "fields";
  std::string text = fmt::format("\n  /** {} Right: {}. */\n", call.doc, engineering::right_text(call.right));
  if (const Field* const file = engineering::file_field(call)) {
    return text + fmt::format(
                      "  {0}(fields: {1}Request): Promise<{1}Answer> {{\n    const {{ {2}, ...others }} = fields;\n"
                      "    return this.call(\"POST\", \"{3}\", others, {2});\n  }}\n",
                      camel(call.name, false), type, file->name, call.path);
  }
  switch (call.form) {
    case Form::kJson:
      return text + fmt::format("  {}({}): Promise<{}> {{\n    return this.call(\"{}\", \"{}\", {});\n  }}\n",
                                camel(call.name, false), parameter, call.response.empty() ? "object" : type + "Answer",
                                method_of(call), call.path, fields);
    case Form::kFile:
      return text + fmt::format("  {}(): Promise<Blob> {{\n    return this.file(\"{}\");\n  }}\n",
                                camel(call.name, false), call.path);
    case Form::kStream:
      break;
  }
  return text + fmt::format("  {}({}): WebSocket {{\n    return this.socket(\"{}\" + query(fields));\n  }}\n",
                            camel(call.name, false), parameter, call.path);
}

}  // namespace

std::string python_calls() {
  std::string text =
      "\"\"\"The calls of an engineering server, one method each. Made by plcdoc from "
      "engineering/calls_*.cpp.\"\"\"\n\n"
      "from picard.connection import Connection\n\n\n"
      "class Calls(Connection):\n"
      "    \"\"\"Each method asks the server once, and raises PicardError when it refuses. Records are dicts:\n";
  for (const engineering::Record* record : engineering::records()) {
    text += "\n" + wrapped(record->doc, "    ", std::string(record->name) + ":") +
            python_fields(record->fields, "        ");
  }
  text += "    \"\"\"\n";
  for (const Call& call : calls()) {
    if (call.form != Form::kStream) text += python_method(call);
  }
  return text;
}

std::string typescript_calls() {
  std::string text =
      "// The calls of an engineering server, one method each. Made by plcdoc from engineering/calls_*.cpp.\n\n"
      "import { Connection, type Value as AnyValue } from \"./connection\";\n";
  for (const engineering::Record* record : engineering::records()) {
    text += fmt::format("\n/** {} */\nexport interface {} {{\n{}}}\n", record->doc, record->name,
                        typescript_fields(record->fields));
  }
  for (const Call& call : calls()) {
    const std::string type = camel(call.name, true);
    if (!call.request.empty())
      text += fmt::format("\nexport interface {}Request {{\n{}}}\n", type, typescript_fields(call.request));
    if (!call.response.empty())
      text += fmt::format("\nexport interface {}Answer {{\n{}}}\n", type, typescript_fields(call.response));
  }
  text +=
      "\nfunction query(fields: object): string {\n"
      "  const all = new URLSearchParams();\n"
      "  for (const [name, value] of Object.entries(fields)) {\n"
      "    if (value !== undefined) all.append(name, String(value));\n"
      "  }\n"
      "  const text = all.toString();\n"
      "  return text === \"\" ? \"\" : `?${text}`;\n"
      "}\n\n"
      "/** The least role that may make a call. */\n"
      "export const rights = {\n";
  for (const Call& call : calls())
    text += fmt::format("  \"{}\": \"{}\",\n", call.name, engineering::right_text(call.right));
  text +=
      "} as const;\n\n"
      "/** A running PLC. */\n"
      "export class Plc extends Connection {";
  std::string methods;
  for (const Call& call : calls()) methods += typescript_method(call);
  return text + methods + "}\n";
}

}  // namespace plc::tools
