#include "engineering/openapi.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace plc::engineering {
namespace {

Json schema_of(const Field& field);

/// An object with these fields and no others.
Json object_schema(std::span<const Field> fields) {
  Json schema;
  schema["type"] = "object";
  Json& properties = schema["properties"] = Json::object();
  Json required = Json::array();
  for (const Field& field : fields) {
    properties[std::string(field.name)] = schema_of(field);
    if (field.required) required.push_back(field.name);
  }
  if (!required.empty()) schema["required"] = std::move(required);
  return schema;
}

Json reference(const Record& record) { return {{"$ref", "#/components/schemas/" + std::string(record.name)}}; }

Json choices_of(std::string_view choices) {
  Json all = Json::array();
  for (std::string_view rest = choices; !rest.empty();) {
    const std::size_t bar = rest.find('|');
    all.push_back(rest.substr(0, bar));
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
  return all;
}

Json schema_of(const Field& field) {
  Json schema = Json::object();
  switch (field.type) {
    case FieldType::kText:
      schema["type"] = "string";
      if (field.low != 0) schema["minLength"] = field.low;
      if (field.high != 0) schema["maxLength"] = field.high;
      if (!field.choices.empty()) schema["enum"] = choices_of(field.choices);
      break;
    case FieldType::kInteger:
      schema["type"] = "integer";
      if (field.low != INT64_MIN) schema["minimum"] = field.low;
      if (field.high != INT64_MAX) schema["maximum"] = field.high;
      break;
    case FieldType::kNumber:
      schema["type"] = "number";
      break;
    case FieldType::kBoolean:
      schema["type"] = "boolean";
      break;
    case FieldType::kValue:
      schema["type"] = {"boolean", "number", "string", "array", "object", "null"};
      break;
    case FieldType::kRecord:
      schema = reference(*field.record);
      break;
    case FieldType::kFile:
      break;  // a body of its own
    case FieldType::kTexts:
    case FieldType::kNumbers:
    case FieldType::kRecords:
      schema["type"] = "array";
      schema["items"] = field.type == FieldType::kTexts     ? Json{{"type", "string"}}
                        : field.type == FieldType::kNumbers ? Json{{"type", "integer"}, {"minimum", 0}}
                                                            : reference(*field.record);
      if (field.high != 0) schema["maxItems"] = field.high;
      break;
  }
  schema["description"] = std::string(field.doc) + ".";
  return schema;
}

Json refusal_schema() {
  return {{"type", "object"},
          {"description", "Why a call did nothing."},
          {"properties",
           {{"code", {{"type", "string"}, {"description", "Code of the problem, with a page of its own."}}},
            {"text", {{"type", "string"}, {"description", "What is wrong."}}},
            {"field", {{"type", "string"}, {"description", "Which field of the request."}}},
            {"help", {{"type", "string"}, {"description", "What to do."}}},
            {"retry_after_ms", {{"type", "integer"}, {"description", "It may succeed then."}}}}},
          {"required", {"code", "text"}}};
}

Json operation_of(const Call& call) {
  Json operation;
  operation["operationId"] = call.name;
  const std::string_view subject = call.path.substr(5, call.path.find('/', 5) - 5);
  operation["tags"] = {subject.substr(0, subject.find('.'))};
  operation["summary"] = call.doc.substr(
      0, call.doc.find(". ") == std::string_view::npos ? call.doc.find_last_of('.') : call.doc.find(". "));
  operation["description"] = std::string(call.doc) + " Right: " + std::string(right_text(call.right)) + ".";
  if (call.right == Right::kAnybody) {
    operation["security"] = Json::array();
  }
  const Field* const file = file_field(call);
  const bool in_query =
      call.method == Method::kGet ? !call.request.empty() : file != nullptr && call.request.size() > 1;
  if (in_query) {
    Json& parameters = operation["parameters"] = Json::array();
    for (const Field& field : call.request) {
      if (field.type == FieldType::kFile) continue;
      Json schema = schema_of(field);
      schema.erase("description");
      parameters.push_back({{"name", field.name},
                            {"in", "query"},
                            {"required", field.required},
                            {"description", std::string(field.doc) + "."},
                            {"schema", std::move(schema)}});
    }
  }
  if (file != nullptr) {
    operation["requestBody"] = {{"required", true},
                                {"description", std::string(file->doc) + "."},
                                {"content", {{"application/octet-stream", {{"schema", Json::object()}}}}}};
  } else if (call.method == Method::kPost) {
    operation["requestBody"] = {{"required", true},
                                {"content", {{"application/json", {{"schema", object_schema(call.request)}}}}}};
  }
  Json& responses = operation["responses"] = Json::object();
  switch (call.form) {
    case Form::kJson:
      responses["200"] = {{"description", "Done."},
                          {"content", {{"application/json", {{"schema", object_schema(call.response)}}}}}};
      break;
    case Form::kFile:
      responses["200"] = {{"description", "The file."},
                          {"content", {{"application/octet-stream", {{"schema", Json::object()}}}}}};
      break;
    case Form::kStream:
      responses["101"] = {{"description", "The connection is a WebSocket."}};
      break;
  }
  responses["default"] = {
      {"description", "Nothing was done."},
      {"content", {{"application/json", {{"schema", {{"$ref", "#/components/schemas/Refusal"}}}}}}}};
  return operation;
}

Json make_document() {
  Json document;
  document["openapi"] = "3.1.0";
  document["info"] = {{"title", "PICARD"},
                      {"version", std::to_string(kApiVersion)},
                      {"description", "What clients can ask of a running PLC."},
                      {"license", {{"name", "Apache 2.0"}, {"identifier", "Apache-2.0"}}}};
  document["security"] = {{{"token", Json::array()}}, {{"session", Json::array()}}};
  Json& paths = document["paths"] = Json::object();
  for (const Call& call : calls()) {
    paths[std::string(call.path)][call.method == Method::kGet ? "get" : "post"] = operation_of(call);
  }
  Json& components = document["components"];
  Json& schemas = components["schemas"] = Json::object();
  for (const Record* record : records()) {
    Json schema = object_schema(record->fields);
    schema["description"] = record->doc;
    schemas[std::string(record->name)] = std::move(schema);
  }
  schemas["Refusal"] = refusal_schema();
  components["securitySchemes"] = {{"token", {{"type", "http"}, {"scheme", "bearer"}}},
                                   {"session", {{"type", "apiKey"}, {"in", "cookie"}, {"name", "__Host-picard"}}}};
  return document;
}

}  // namespace

const Json& openapi_document() {
  static const Json document = make_document();
  return document;
}

const std::string& openapi_text() {
  static const std::string text = openapi_document().dump() + "\n";
  return text;
}

}  // namespace plc::engineering
