// Cases: a folder with a project, its inputs and the table of what its variables are then (tests/cases/README.md).
//
// In: a folder. Out: one TestResult for each run that its case.txt names; every cell of the table is a check, and so is
// every warning, event and fault that happens or is missing, and the order of drawings. Runs in the interpreter. Does
// not belong here: reading case.txt (case_file.h).
#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "taskblocks/registry.h"
#include "testing/runner.h"

namespace plc::tests {

struct CaseRequest {
  std::filesystem::path folder;
  std::string name;                        ///< of the results
  std::vector<std::string> libraries;      ///< beside those of case.txt
  const taskblocks::Registry* taskblocks;  ///< that the project may use
};

/// P7904 for a manifest or table that cannot be used, P72xx for a stimulus. A project that does not compile is a
/// failure of its results.
core::Result<std::vector<TestResult>> run_case(const CaseRequest& request);

}  // namespace plc::tests
