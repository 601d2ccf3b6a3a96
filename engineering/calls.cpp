#include <algorithm>
#include <array>
#include <string>
#include <unordered_map>
#include <vector>

#include "engineering/call.h"
#include "engineering/subjects.h"

namespace plc::engineering {
namespace {

constexpr std::array<std::string_view, 5> kRights = {"anybody", "viewer", "operator", "engineer", "admin"};

void add_records(std::span<const Field> fields, std::vector<const Record*>& all) {
  for (const Field& field : fields) {
    if (field.record == nullptr || std::find(all.begin(), all.end(), field.record) != all.end()) continue;
    add_records(field.record->fields, all);
    all.push_back(field.record);
  }
}

}  // namespace

std::string_view right_text(Right right) { return kRights[static_cast<std::size_t>(right)]; }

Right role_named(std::string_view name) {
  const auto found = std::find(kRights.begin(), kRights.end(), name);
  return found == kRights.end() ? Right::kAnybody : static_cast<Right>(found - kRights.begin());
}

std::span<const Call> calls() {
  static const std::vector<Call> all = [] {
    std::vector<Call> rows;
    for (const auto subject :
         {target_calls(), login_calls(), machine_calls(), task_calls(), variable_calls(), force_calls(), alarm_calls(),
          history_calls(), recording_calls(), diagram_calls(), past_calls(), page_calls(), log_calls(), program_calls(),
          upload_calls(), user_calls()}) {
      rows.insert(rows.end(), subject.begin(), subject.end());
    }
    return rows;
  }();
  return all;
}

const Field* file_field(const Call& call) {
  const auto found = std::find_if(call.request.begin(), call.request.end(),
                                  [](const Field& field) { return field.type == FieldType::kFile; });
  return found == call.request.end() ? nullptr : &*found;
}

const Call* find_call(std::string_view path) {
  static const std::unordered_map<std::string_view, const Call*> by_path = [] {
    std::unordered_map<std::string_view, const Call*> map;
    for (const Call& call : calls()) map.emplace(call.path, &call);
    return map;
  }();
  const auto found = by_path.find(path);
  return found == by_path.end() ? nullptr : found->second;
}

std::span<const Record* const> records() {
  static const std::vector<const Record*> all = [] {
    std::vector<const Record*> found;
    for (const Call& call : calls()) {
      add_records(call.request, found);
      add_records(call.response, found);
    }
    return found;
  }();
  return all;
}

}  // namespace plc::engineering
