#include "tools/plc-run/history_service.h"

#include <filesystem>
#include <sstream>
#include <utility>

#include "io-drivers/config/read_historian.h"
#include "io-drivers/config/table_file.h"

namespace plc::tools {
namespace {

void report(const core::Diagnostics& diagnostics, std::vector<engineering::Said>& said) {
  if (diagnostics.all().empty()) return;
  std::ostringstream lines;
  diagnostics.render(lines);
  std::string text = "historian: " + lines.str();
  while (text.ends_with('\n')) text.pop_back();
  said.push_back({core::Severity::kError, std::move(text)});
}

}  // namespace

HistoryService::HistoryService(std::string file, runtime::Resource& resource) : file_(std::move(file)) {
  std::error_code ignored;
  if (std::filesystem::exists(file_, ignored))
    values_ = std::make_unique<engineering::ShadowValues>(resource.globals());
}

void HistoryService::open(const std::string& state, runtime::Resource& resource, shadow::Shadow* shadow,
                          const core::Calendar& calendar, std::vector<engineering::Said>& said) {
  if (values_ == nullptr) return;
  core::Diagnostics diagnostics;
  const auto text = io::table_file_text(file_, diagnostics);
  const auto settings = text ? io::read_historian(*text, file_, diagnostics) : std::nullopt;
  if (!settings) {
    report(diagnostics, said);
    return;
  }
  const std::string folder =
      settings->folder.empty() ? state : (std::filesystem::path(file_).parent_path() / settings->folder).string();
  if (folder.empty()) {
    said.push_back({core::Severity::kNote,
                    "historian: nothing is kept, since there is no folder: --state DIR, or folder in historian.toml"});
    report(diagnostics, said);
    return;
  }
  std::error_code refused;
  std::filesystem::create_directories(folder, refused);  // what is wrong with it the file says
  if (shadow != nullptr) values_->attach(*shadow);
  historian::Source source;
  source.take = [values = values_.get()] { values->take(); };
  source.read = [values = values_.get()](const runtime::Place& place, std::uint32_t bytes, std::byte* to) {
    values->read(place.task, place.offset, bytes, to);
  };
  historian_ = std::make_unique<historian::Historian>(*settings, folder, resource, shadow != nullptr, std::move(source),
                                                      calendar, diagnostics);
  report(diagnostics, said);
  historian_->start();
  said.push_back({core::Severity::kNote, "historian: " + std::to_string(historian_->tags().size()) + " variables in " +
                                             folder + "/history.db"});
}

void HistoryService::service(std::vector<engineering::Said>& said) {
  if (!historian_) return;
  std::string sentence = historian_->take_said();
  if (sentence.empty()) return;
  const bool good = sentence.find("again") != std::string::npos;
  said.push_back({good ? core::Severity::kNote : core::Severity::kWarning, std::move(sentence)});
}

void HistoryService::stop() {
  if (!historian_) return;
  historian_->stop();
  values_->detach();
}

}  // namespace plc::tools
