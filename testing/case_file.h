// The manifest of a case, case.txt: how it is run and what it must do besides its table.
//
// In: folder of a case. Out: CaseFile, with the lines that are not understood. The form is described in
// tests/cases/README.md. Does not belong here: running anything (case_run.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plc::tests {

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

/// How far values of some variables may be from the table.
struct Tolerance {
  std::string pattern;  ///< of paths: "main.level", "*.speed"
  double most = 0;
};

struct CaseFile {
  std::vector<CaseRun> runs;
  std::vector<std::string> order;  ///< localIds as `plc explain` must list them, whatever is between
  std::vector<ExpectedWarning> warnings;
  std::map<std::string, std::uint64_t> events;  ///< kind -> how often in all; what is not named must not happen
  std::vector<ExpectedFault> faults;
  std::string start;                   ///< folder of the values to begin with; empty = initial values
  std::vector<std::string> libraries;  ///< files of the folder that are compiled with the project
  std::vector<std::string> tables;     ///< "72.4": table and feature of IEC 61131-3:2013
  std::vector<Tolerance> tolerances;   ///< the last that matches a path counts; others are compared exactly
  std::vector<std::string> wrong;      ///< lines that are not understood, "case.txt:3: .."
  std::string only;                    ///< not empty: who runs the case, and why nobody else can be asked to
};

/// How far values of the variable `path` may be from the table.
double tolerance_of(const CaseFile& the_case, const std::string& path);

/// Words of a line, separated by blanks.
std::vector<std::string> words(const std::string& line);

/// Whether `ids` are in `order` one after the other, whatever is between.
bool in_sequence(const std::vector<std::string>& ids, const std::vector<std::string>& order);

CaseFile read_case(const std::filesystem::path& folder);

/// project.st, or project.xml.
std::filesystem::path project_of(const std::filesystem::path& folder);

/// True for a folder with a project and its table.
bool is_case(const std::filesystem::path& folder);

/// Every folder below `root` with a project, as `<area>/<case>`, sorted.
std::vector<std::string> case_names(const std::filesystem::path& root);

}  // namespace plc::tests
