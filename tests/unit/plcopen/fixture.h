// Small projects for the reader's tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "plcopen/reader.h"

namespace plc::plcopen {

struct ReadResult {
  core::Diagnostics diagnostics;
  std::unique_ptr<Project> project;

  [[nodiscard]] std::string shown() const {
    std::ostringstream out;
    diagnostics.render(out);
    return out.str();
  }
  /// Codes reported, in order: "P1008 P1013".
  [[nodiscard]] std::string codes() const {
    std::string out;
    for (const core::Diagnostic& d : diagnostics.all()) {
      if (!out.empty()) out += ' ';
      out += core::info(d.code).name;
    }
    return out;
  }
  [[nodiscard]] const ReportRow* row(std::string_view element) const {
    for (const ReportRow& r : project->report) {
      if (r.element == element) return &r;
    }
    return nullptr;
  }
};

inline ReadResult read_text(std::string_view xml, const ReadLimits& limits = {}) {
  ReadResult result;
  result.project = read_memory(xml, "test.xml", result.diagnostics, limits);
  return result;
}

/// The text must give a project without any diagnostic.
inline ReadResult read_clean(std::string_view xml) {
  ReadResult result = read_text(xml);
  EXPECT_EQ(result.shown(), "");
  EXPECT_NE(result.project, nullptr);
  if (result.project == nullptr) result.project = std::make_unique<Project>();
  return result;
}

inline std::string tc6(std::string_view types, std::string_view instances = "", std::string_view after = "") {
  return "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\" xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">\n"
         "<fileHeader companyName=\"c\" productName=\"tool\" productVersion=\"1\" "
         "creationDateTime=\"2024-01-01T00:00:00\"/>\n"
         "<contentHeader name=\"demo\"/>\n<types>" +
         std::string(types) + "</types>\n<instances><configurations>" + std::string(instances) +
         "</configurations></instances>" + std::string(after) + "</project>\n";
}

/// A project with one program of that interface and body.
inline std::string program(std::string_view body, std::string_view interface = "") {
  return tc6("<dataTypes/><pous><pou name=\"Main\" pouType=\"program\"><interface>" + std::string(interface) +
             "</interface><body>" + std::string(body) + "</body></pou></pous>");
}

inline std::string ladder(std::string_view elements) { return program("<LD>" + std::string(elements) + "</LD>"); }

inline const Body& body_of(const ReadResult& result) {
  static const Body kNone;
  if (result.project == nullptr || result.project->pous.empty() || result.project->pous[0].bodies.empty()) {
    ADD_FAILURE() << "no body\n" << result.shown();
    return kNone;
  }
  return result.project->pous[0].bodies[0];
}

/// "line:column" of the first occurrence of `needle`, columns in characters (ASCII texts only).
inline std::string place_of(std::string_view text, std::string_view needle) {
  const std::size_t at = text.find(needle);
  if (at == std::string_view::npos) return "absent";
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
  const std::size_t start = text.rfind('\n', at);
  const std::size_t column = start == std::string_view::npos ? at + 1 : at - start;
  return std::to_string(line) + ':' + std::to_string(column);
}
inline std::string place(const SourceRef& at) { return std::to_string(at.line) + ':' + std::to_string(at.column); }

}  // namespace plc::plcopen
