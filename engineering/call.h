// Call: one thing that a client can ask of a running PLC, as a row: name, way, right, fields, documentation, function.
//
// In: nothing. Out: rows (calls_*.cpp), from which the dispatcher, the OpenAPI document, the clients and the reference
// page follow (docs/adr/0057). Does not belong here: HTTP, sockets, what a call does.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

namespace plc::engineering {

using Json = nlohmann::ordered_json;

class Answer;
struct Caller;
struct Context;

/// Who may call. A role has the rights of those before it.
enum class Right : std::uint8_t {
  kAnybody,   ///< without login
  kViewer,    ///< sees everything of the plant
  kOperator,  ///< writes values
  kEngineer,  ///< changes the program
  kAdmin,     ///< decides who may do what
};
/// "viewer", .., and "anybody".
std::string_view right_text(Right right);
/// The role of this name; kAnybody when there is none.
Right role_named(std::string_view name);

enum class Method : std::uint8_t {
  kGet,   ///< fields are in the query of the path
  kPost,  ///< fields are a JSON object
};

enum class FieldType : std::uint8_t {
  kText,     ///< `low` to `high` bytes of UTF-8
  kInteger,  ///< `low` to `high`
  kNumber,
  kBoolean,
  kValue,    ///< of a variable: boolean, number, text, array or object
  kTexts,    ///< at most `high` of them
  kNumbers,  ///< whole numbers from 0 on, at most `high` of them
  kRecord,   ///< an object with the fields of `record`
  kRecords,  ///< at most `high` of them
  kFile,     ///< bytes: the body of the request, whose other fields are in the query. A row has at most one
};

struct Record;

struct Field {
  std::string_view name;
  FieldType type = FieldType::kText;
  std::string_view doc = {};  ///< a sentence without a full stop
  bool required = true;       ///< in answers: always there
  std::int64_t low = 0;
  std::int64_t high = 0;  ///< 0 = as large as a request may be
  const Record* record = nullptr;
  std::string_view choices = {};  ///< of a text: separated by '|'; empty = any
};

struct Record {
  std::string_view name;  ///< "Variable"
  std::string_view doc;
  std::span<const Field> fields;
};

/// What comes back.
enum class Form : std::uint8_t {
  kJson,    ///< an object with the fields of `response`
  kFile,    ///< bytes
  kStream,  ///< the connection becomes a WebSocket (streams.h)
};

/// Which thread runs it.
enum class Thread : std::uint8_t {
  kIo,       ///< that of all connections: nothing that waits
  kFiles,    ///< reads and writes files
  kUpload,   ///< has an image looked at, which takes up to a minute
  kSecrets,  ///< computes with passwords, which takes long
  kPast,     ///< executes recorded scans again, which takes long
};

struct Call {
  std::string_view name;  ///< "values.read": the name in clients
  Method method = Method::kGet;
  std::string_view path;  ///< "/api/values/read"
  Right right = Right::kViewer;
  std::string_view doc;  ///< sentences
  std::span<const Field> request = {};
  std::span<const Field> response = {};
  std::string_view example = {};  ///< a request as JSON, for the reference page; run by a test with examples/tank
  void (*run)(Context& context, const Caller& caller, const Json& request, Answer& answer) = nullptr;
  Form form = Form::kJson;
  Thread thread = Thread::kIo;
};

/// All rows, subject by subject.
std::span<const Call> calls();
/// Its field of the type kFile; null when there is none.
const Field* file_field(const Call& call);
/// The row of this path, whatever its method; null when there is none.
const Call* find_call(std::string_view path);
/// All records that fields of the rows name, each once, those that others need first.
std::span<const Record* const> records();

/// The columns of a row.
namespace field {
constexpr Field text(std::string_view name, std::string_view doc, std::int64_t low = 0, std::int64_t high = 0) {
  return {.name = name, .type = FieldType::kText, .doc = doc, .low = low, .high = high};
}
constexpr Field choice(std::string_view name, std::string_view choices, std::string_view doc) {
  return {.name = name, .type = FieldType::kText, .doc = doc, .choices = choices};
}
constexpr Field integer(std::string_view name, std::string_view doc, std::int64_t low = INT64_MIN,
                        std::int64_t high = INT64_MAX) {
  return {.name = name, .type = FieldType::kInteger, .doc = doc, .low = low, .high = high};
}
constexpr Field number(std::string_view name, std::string_view doc) {
  return {.name = name, .type = FieldType::kNumber, .doc = doc};
}
constexpr Field boolean(std::string_view name, std::string_view doc) {
  return {.name = name, .type = FieldType::kBoolean, .doc = doc};
}
constexpr Field value(std::string_view name, std::string_view doc) {
  return {.name = name, .type = FieldType::kValue, .doc = doc};
}
/// The body of a request. Its call is a POST.
constexpr Field file(std::string_view name, std::string_view doc) {
  return {.name = name, .type = FieldType::kFile, .doc = doc};
}
constexpr Field texts(std::string_view name, std::string_view doc, std::int64_t most = 0) {
  return {.name = name, .type = FieldType::kTexts, .doc = doc, .high = most};
}
constexpr Field numbers(std::string_view name, std::string_view doc, std::int64_t most = 0) {
  return {.name = name, .type = FieldType::kNumbers, .doc = doc, .high = most};
}
constexpr Field record(std::string_view name, const Record& record, std::string_view doc) {
  return {.name = name, .type = FieldType::kRecord, .doc = doc, .record = &record};
}
constexpr Field records(std::string_view name, const Record& record, std::string_view doc, std::int64_t most = 0) {
  return {.name = name, .type = FieldType::kRecords, .doc = doc, .high = most, .record = &record};
}
/// The same field, which need not be there.
constexpr Field optional(Field field) {
  field.required = false;
  return field;
}
}  // namespace field

}  // namespace plc::engineering
