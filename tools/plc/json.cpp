#include "tools/plc/json.h"

#include <nlohmann/json.hpp>

namespace plc::tools {
namespace {

using nlohmann::ordered_json;

const char* severity_word(core::Severity severity) {
  switch (severity) {
    case core::Severity::kNote:
      return "note";
    case core::Severity::kWarning:
      return "warning";
    case core::Severity::kError:
      return "error";
  }
  return "";
}

ordered_json to_json(const core::Diagnostics& diagnostics, const core::Diagnostic& diagnostic) {
  const core::SourceRef& at = diagnostic.at;
  ordered_json row;
  row["file"] = diagnostics.file_name(at.file);
  row["line"] = at.line;
  row["column"] = at.column;
  row["code"] = core::info(diagnostic.code).name;
  row["severity"] = severity_word(diagnostic.severity);
  row["pou"] = diagnostic.pou;
  row["element"] = core::element_word(at.kind);
  row["localId"] = at.local_id < 0 ? ordered_json() : ordered_json(at.local_id);
  row["message"] = diagnostic.message;
  row["help"] = diagnostic.help;
  return row;
}

}  // namespace

std::string diagnostics_json(const std::vector<CheckedFile>& files) {
  ordered_json document;
  document["files"] = ordered_json::array();
  document["diagnostics"] = ordered_json::array();
  for (const CheckedFile& file : files) {
    document["files"].push_back({{"file", file.file},
                                 {"ok", file.ok},
                                 {"errors", file.diagnostics.error_count()},
                                 {"warnings", file.diagnostics.warning_count()},
                                 {"notes", file.diagnostics.note_count()}});
    for (const core::Diagnostic& diagnostic : file.diagnostics.all()) {
      document["diagnostics"].push_back(to_json(file.diagnostics, diagnostic));
    }
  }
  // WHY replace: a broken file may put bytes into a message that are no UTF-8; the document stays valid JSON.
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace plc::tools
