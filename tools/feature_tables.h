// Features of IEC 61131-3 by table, and what shows that PICARD has them: tests/cases/tables.txt lists them, `tables:`
// of each case.txt names those it proves, and names of the library answer for themselves.
//
// In: the folder of the cases. Out: tables of features with their answers, and what is wrong with the list. Does not
// belong here: Markdown (plcdoc), running cases.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plc::tools {

enum class Answer : std::uint8_t { kYes, kPartly, kNo };

struct Feature {
  std::string number;              ///< "72.4"
  std::string text;                ///< what it is; names of the library are in backquotes
  Answer answer = Answer::kYes;    ///< for names of the library: whether it has them
  std::string note;                ///< what is missing and why; never empty for kPartly and kNo
  std::vector<std::string> cases;  ///< folders that prove it: "st/case"
  bool of_library = false;         ///< names functions or blocks, whose examples are tests
  std::string_view group;          ///< of_library: title of the group of the first that is there
};

/// A table of the standard.
struct FeatureTable {
  std::string title;  ///< "72 Statements"
  std::vector<Feature> features;
};

struct FeatureTables {
  std::vector<FeatureTable> tables;
  /// Lines that cannot be read, features that are there twice, have no case, or a case beside a reason to have none;
  /// cases that name a feature that is not listed.
  std::vector<std::string> problems;
};

/// Reads tables.txt (its head describes the form) and every case.txt below `cases`.
FeatureTables read_feature_tables(const std::filesystem::path& cases);

}  // namespace plc::tools
