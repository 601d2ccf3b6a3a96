// A text that was read, and the places of its messages.
#pragma once

#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "frontend-st/read.h"
#include "plcopen/project.h"

namespace plc::st {

struct Reading {
  core::Diagnostics diagnostics;
  std::unique_ptr<plcopen::Project> project;

  explicit Reading(std::string_view text) : project(read_memory(text, "test.st", diagnostics)) {}
  [[nodiscard]] std::string rendered() const {
    std::ostringstream out;
    diagnostics.render(out);
    return out.str();
  }
  /// "12:3 P4040" for every message.
  [[nodiscard]] std::vector<std::string> places() const {
    std::vector<std::string> out;
    for (const core::Diagnostic& d : diagnostics.all()) {
      out.push_back(std::to_string(d.at.line) + ":" + std::to_string(d.at.column) + " " +
                    std::string(core::info(d.code).name));
    }
    return out;
  }
};

using Places = std::vector<std::string>;

}  // namespace plc::st
