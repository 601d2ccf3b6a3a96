// Comparison: one program through the compiler and the runtime, and through the system's C compiler, scan by scan.
//
// In: a Program. Out: what differed, if anything. Does not belong here: making programs smaller (main.cpp).
#pragma once

#include <cstdint>
#include <string>

#include "tests/programs/model.h"

namespace plc::programs {

struct Outcome {
  enum class Kind {
    kSame,
    kRefused,       ///< the compiler refused the ST
    kUntranslated,  ///< the C compiler refused the C: a mistake of the generator
    kFault,
    kDifferent,
  } kind = Kind::kSame;
  std::string text;              ///< diagnostics, or the variable and both values
  std::uint64_t statements = 0;  ///< executed by the C
};

struct ComparisonPlan {
  std::string folder;  ///< for the files of this program
  std::string prelude;
  std::uint32_t scans = 20;
};

Outcome compare(const Program& program, const ComparisonPlan& plan);

}  // namespace plc::programs
