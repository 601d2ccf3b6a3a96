// Findings: the problems of one plc.toml, collected in any order and reported from top to bottom.
//
// In: problems (TOML's tables come sorted by name). Out: diagnostics in file order. Does not belong here: what is
// wrong.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"

namespace plc::io {

/// Order of places in one file.
bool before(const core::SourceRef& a, const core::SourceRef& b);

class Findings {
 public:
  void add(core::Code code, const core::SourceRef& at, std::string message, std::string help = {});
  [[nodiscard]] std::size_t size() const { return found_.size(); }
  void report(core::Diagnostics& diagnostics);

 private:
  struct Finding {
    core::Code code;
    core::SourceRef at;
    std::string message;
    std::string help;
  };
  std::vector<Finding> found_;
};

/// Variables with two entries, in any letter case; channels with two users, and what else the kinds of drivers check.
void check_channels(const Configuration& configuration, Findings& findings);

}  // namespace plc::io
