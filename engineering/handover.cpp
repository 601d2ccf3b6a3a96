#include "engineering/handover.h"

#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "engineering/call.h"

namespace plc::engineering {
namespace {

/// Of the log: what people look at first.
constexpr std::size_t kMostRecords = 1000;

Json json_of(const std::string& hash, const Session& session) {
  return {{"hash", hash},
          {"number", session.number},
          {"user", session.user},
          {"role", right_text(session.role)},
          {"address", session.address},
          {"begin_ns", session.begin_ns},
          {"last_ns", session.last_ns}};
}

Json json_of(const log::Record& record) {
  Json json = {{"severity", static_cast<int>(record.severity)},
               {"text", record.text},
               {"source", record.source},
               {"code", record.code},
               {"task", record.task},
               {"block", record.block},
               {"details", record.details},
               {"utc_ns", record.utc_ns}};
  if (record.scan) json["scan"] = *record.scan;
  return json;
}

log::Record record_of(const Json& json) {
  log::Record record;
  const int severity = json.at("severity").get<int>();
  if (severity >= 0 && severity <= static_cast<int>(core::Severity::kError))
    record.severity = static_cast<core::Severity>(severity);
  record.text = json.at("text").get<std::string>();
  record.source = json.at("source").get<std::string>();
  record.code = json.at("code").get<std::string>();
  record.task = json.at("task").get<std::string>();
  record.block = json.at("block").get<std::string>();
  record.details = json.at("details").get<std::string>();
  record.utc_ns = json.at("utc_ns").get<core::TimeNs>();
  if (json.contains("scan")) record.scan = json.at("scan").get<std::uint64_t>();
  return record;
}

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string handover_text(const Sessions& sessions, std::uint16_t port) {
  Json json = {{"port", port}, {"sessions", Json::array()}};
  for (const auto& [hash, session] : sessions.kept()) json["sessions"].push_back(json_of(hash, session));
  return dump(json);
}

std::string handover_text(const LogBook& log) {
  Json json = {{"last", log.last_number()}, {"records", Json::array()}};
  for (const LogBook::Entry& entry : log.latest(core::Severity::kNote, kMostRecords))
    json["records"].push_back(json_of(entry.record));
  return dump(json);
}

void take_over(std::string_view text, Sessions& sessions, std::uint16_t& port) {
  const Json json = Json::parse(text, nullptr, false);
  try {
    for (const Json& one : json.at("sessions")) {
      Session session;
      session.number = one.at("number").get<std::uint64_t>();
      session.user = one.at("user").get<std::string>();
      session.role = role_named(one.at("role").get<std::string>());
      session.address = one.at("address").get<std::string>();
      session.begin_ns = one.at("begin_ns").get<core::TimeNs>();
      session.last_ns = one.at("last_ns").get<core::TimeNs>();
      sessions.take_over(one.at("hash").get<std::string>(), std::move(session));
    }
    port = json.at("port").get<std::uint16_t>();
  } catch (const std::exception&) {
  }
}

void take_over(std::string_view text, LogBook& log) {
  const Json json = Json::parse(text, nullptr, false);
  try {
    std::deque<log::Record> records;
    for (const Json& one : json.at("records")) records.push_back(record_of(one));
    log.take_over(json.at("last").get<std::uint64_t>(), records);
  } catch (const std::exception&) {
  }
}

}  // namespace plc::engineering
