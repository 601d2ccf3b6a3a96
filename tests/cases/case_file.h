// The manifest of a case, case.txt: how it is run and what it must print besides its trace.
//
// In: folder of a case. Out: CaseFile; lines that cannot be read fail the running test. The form is described in
// README.md beside this file. Does not belong here: running anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plc::test {

/// One simulation of the project: the options it takes and the table its trace must equal.
struct CaseRun {
  std::string expected;
  std::vector<std::string> options;
};

/// A warning that must be printed: its code ("?" = any) and texts that must be in the same message.
struct ExpectedWarning {
  std::string code;
  std::vector<std::string> texts;
};

/// A task that ends a scan with a fault.
struct ExpectedFault {
  std::string code;
  std::string task;
  std::string cycle;
};

struct CaseFile {
  std::vector<CaseRun> runs;
  std::vector<std::string> order;  ///< localIds as `plc explain` must list them, whatever is between
  std::vector<ExpectedWarning> warnings;
  std::map<std::string, std::uint64_t> events;  ///< kind -> how often in all; what is not named must not happen
  std::vector<ExpectedFault> faults;
  std::vector<std::string> libraries;  ///< files of the folder that are compiled with the project
  std::vector<std::string> tables;     ///< "72.4": table and feature of IEC 61131-3:2013
  std::string only;                    ///< not empty: who runs the case, and why nobody else can be asked to
};

/// Words of a line, separated by blanks.
std::vector<std::string> words(const std::string& line);

CaseFile read_case(const std::filesystem::path& folder);

/// project.st, or project.xml.
std::filesystem::path project_of(const std::filesystem::path& folder);

/// Every folder below `root` with a project, as `<area>/<case>`, sorted.
std::vector<std::string> case_names(const std::filesystem::path& root);

}  // namespace plc::test
