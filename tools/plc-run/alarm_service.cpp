#include "tools/plc-run/alarm_service.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <sstream>
#include <utility>

#include "io-drivers/config/read_alarms.h"
#include "io-drivers/config/table_file.h"

namespace plc::tools {

AlarmService::AlarmService(const std::string& file, runtime::Resource& resource, bool recorded) {
  core::Diagnostics diagnostics;
  std::vector<alarms::Definition> definitions;
  if (const auto text = io::table_file_text(file, diagnostics)) definitions = io::read_alarms(*text, file, diagnostics);
  alarms_ = std::make_unique<alarms::Alarms>(resource, std::move(definitions), recorded, diagnostics);
  if (alarms_->count() == 0) alarms_.reset();
  if (diagnostics.all().empty()) return;
  std::ostringstream lines;
  diagnostics.render(lines);
  wrong_ = "alarms: " + lines.str();
  while (wrong_.ends_with('\n')) wrong_.pop_back();
}

void AlarmService::open(const std::string& folder, shadow::Shadow* shadow, std::vector<engineering::Said>& said) {
  // WHY no end of the start: nothing but control decides whether control starts.
  if (!wrong_.empty()) said.push_back({core::Severity::kError, wrong_});
  if (!alarms_) return;
  if (shadow == nullptr && alarms_->needs_scans()) {
    const std::vector<std::string> left_out = alarms_->do_without_scans();
    if (!left_out.empty()) {
      said.push_back(
          {core::Severity::kWarning, fmt::format("alarms: {}: left out, since scans are not recorded: {}",
                                                 core::info(core::Code::P7720).name, fmt::join(left_out, ", "))});
    }
    if (alarms_->count() == 0) return alarms_.reset();
  }
  std::error_code refused;
  if (!folder.empty()) std::filesystem::create_directories(folder, refused);  // what is wrong with it the store says
  std::vector<std::string> trouble;
  store_ = std::make_unique<alarms::AlarmStore>(folder, trouble);
  for (std::string& one : trouble) said.push_back({core::Severity::kWarning, std::move(one)});
  alarms_->restore(store_->states(), store_->last_number());
  if (shadow != nullptr && alarms_->needs_scans()) shadow->observe(*alarms_);
  store_->start();
  said.push_back({core::Severity::kNote, "alarms: " + std::to_string(alarms_->count())});
}

void AlarmService::keep() {
  std::vector<alarms::Event> events;
  std::vector<alarms::Kept> states;
  alarms_->take(events, states);
  store_->add(std::move(events), std::move(states));
}

void AlarmService::service(core::TimeNs now_ns, core::TimeNs utc_ns, bool settled,
                           std::vector<engineering::Said>& said) {
  if (!alarms_) return;
  alarms_->service(now_ns, utc_ns);
  if (settled) keep();
  if (std::string sentence = store_->take_said(); !sentence.empty()) {
    const bool good = sentence.find("again") != std::string::npos;
    said.push_back({good ? core::Severity::kNote : core::Severity::kWarning, std::move(sentence)});
  }
}

void AlarmService::stop(bool settled) {
  if (!alarms_) return;
  if (settled) keep();
  store_->stop();
}

}  // namespace plc::tools
