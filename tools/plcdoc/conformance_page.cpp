// docs/reference/conformance.md: what of IEC 61131-3:2013 PICARD has, with what shows it, and what it makes of the
// parameters that the standard leaves to the implementer. Limits are the constants of the code that applies them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>

#include "bytecode/format.h"
#include "bytecode/image.h"
#include "bytecode/opcode.h"
#include "bytecode/rules.h"
#include "bytecode/type_map.h"
#include "core/types.h"
#include "frontend-st/ast.h"
#include "frontend-st/read.h"
#include "plcopen/reader.h"
#include "stdlib/library.h"
#include "tools/library_text.h"
#include "tools/plcdoc/pages.h"

namespace plc::tools {
namespace {

constexpr std::string_view answer_word(Answer answer) {
  switch (answer) {
    case Answer::kYes:
      return "yes";
    case Answer::kPartly:
      return "partly";
    case Answer::kNo:
      return "no";
  }
  return "";
}

/// "[a-case](..)", the page of the library, or nothing. Cases are shown by their project: its head gives the reason.
std::string evidence(const Feature& feature, const std::filesystem::path& cases) {
  constexpr std::string_view kCases = "../../tests/cases/";
  std::string text;
  for (const std::string& name : feature.cases) {
    const bool drawn = std::filesystem::exists(cases / name / "project.xml");
    text += fmt::format("{}[{}]({}{}/project.{})", text.empty() ? "" : ", ", name, kCases, name, drawn ? "xml" : "st");
  }
  if (text.empty() && !feature.group.empty()) text = fmt::format("[examples]({})", page_of_group(feature.group));
  return text;
}

/// A parameter of the implementer: what the standard leaves open, what PICARD does, where it is described.
struct Parameter {
  std::string_view what;
  std::string value;
  std::string_view page;  ///< link from docs/reference, or empty
};

std::string megabytes(std::size_t bytes) { return fmt::format("{} MiB", bytes >> 20); }

/// "T#..d..h" of a duration, as TIME_TO_STRING writes it.
std::string duration_literal(std::int64_t ns) {
  const std::int64_t seconds = ns / 1'000'000'000;
  return fmt::format("T#{}d{}h{}m{}s", seconds / 86400, seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
}

std::vector<Parameter> parameters() {
  constexpr std::int64_t kMostNs = std::numeric_limits<std::int64_t>::max();
  constexpr const char* kStatements = "../guides/statements.md";
  constexpr const char* kValues = "../guides/values.md";
  constexpr const char* kEvents = "../guides/events.md";
  constexpr const char* kText = "../guides/structured-text.md";
  constexpr const char* kOrder = "../guides/execution-order.md";
  return {
      // Text.
      {"length of identifiers",
       fmt::format("{} bytes; all are significant, the case of A to Z is not", plcopen::ReadLimits{}.max_name), ""},
      {"characters of identifiers", "letters of any script, digits, underscores", ""},
      {"nesting of comments", "any", kText},
      {"pragmas", "read and kept; none has a meaning for the program", kText},
      {"size of a text file", megabytes(st::kMaxFileBytes), ""},
      {"nesting of expressions and statements", fmt::format("{} levels", st::kMaxDepth), kStatements},
      // Types.
      {"range of TIME and LTIME",
       fmt::format("signed 64-bit nanoseconds: to {} and as far back", duration_literal(kMostNs)), kValues},
      {"precision of TIME and LTIME", "1 ns; timers measure in cycles", kValues},
      {"range of dates",
       fmt::format("signed 64-bit nanoseconds since 1970-01-01: about {} years each way",
                   kMostNs / 1'000'000'000 / 31'556'952),
       kValues},
      {"precision of times of day", "1 ns", kValues},
      {"REAL, LREAL", "IEEE 754 binary32 and binary64; + - * / and SQRT exactly rounded, other functions within 1 ulp",
       kValues},
      {"length of a STRING or WSTRING without one", fmt::format("{} characters", core::kDefaultStringCapacity),
       kValues},
      {"greatest length of a STRING or WSTRING", fmt::format("{} characters", core::kMaxStringCapacity), kValues},
      {"characters of STRING and WSTRING", "Windows-1252, one byte; units of UTF-16", kValues},
      {"elements of arrays and structures",
       fmt::format("as many as fit: {} bytes for the globals, for an instance, for the constants",
                   bytecode::kMaxTableBytes),
       "../problems/P5001.md"},
      {"bounds of arrays", "those of LINT", ""},
      {"nesting of types", fmt::format("{} levels, with the program and its variable", bytecode::kMaxTypeDepth), ""},
      {"values of an enumeration without a base",
       "INT where all fit, else the next larger type; counted from 0 where none is given", ""},
      {"initial values of variables",
       "0, FALSE, the empty string, the first value of an enumeration; those of the declaration otherwise", ""},
      // POUs.
      {"inputs of extensible functions", fmt::format("{}", stdlib::kMaxArguments), "library.md"},
      {"nesting of calls", fmt::format("{}, with task and program; recursion is refused", bytecode::kMaxCallDepth),
       kStatements},
      {"result of a function that EN skips", "what this call gave last", kStatements},
      {"inputs that a call does not give", "initial values for functions; as they were for function blocks",
       kStatements},
      {"blocks in the first scan",
       "as their text in the standard; F_TRIG fires when CLK is FALSE, a drawn falling edge does not",
       "../guides/first-scan.md"},
      {"CV of counters at the limits of its type", "stops there", "library/counters.md"},
      {"PT changed while a timer runs", "takes effect at once", "library/timers.md"},
      // Execution.
      {"order of operands",
       "from left to right; both sides of AND and OR are computed, AND_THEN and OR_ELSE stop early", kStatements},
      {"bounds of FOR", "computed once; after the loop the variable is one step past its last value", kStatements},
      {"length of loops",
       fmt::format("{} jumps back of all loops in one scan of a task, or --loop-budget; more is a fault",
                   bytecode::kDefaultLoopBudget),
       kStatements},
      {"order of networks and elements",
       "top to bottom as drawn, inside a network by data flow, variables with the block that writes or reads them; "
       "--order=document otherwise",
       kOrder},
      {"feedback in drawings", "the value of the previous scan", kOrder},
      {"tasks", fmt::format("{}", bytecode::kMaxTasks), "../problems/P5001.md"},
      {"priorities of tasks", fmt::format("0, the highest, to {}", std::numeric_limits<std::int32_t>::max()), ""},
      {"scheduling of tasks", "preemptive by priority, on a fixed grid; missed releases are counted", kEvents},
      {"globals that tasks share", "one consistent copy for each cycle, published at its end",
       "../adr/0012-one-snapshot-per-owner.md"},
      {"RETAIN at a warm restart", "kept, where plc-run has a folder for it", "../guides/retain.md"},
      // Errors.
      {"overflow of integers", "wraps, two's complement", kValues},
      {"overflow of REAL and LREAL", "an infinity", kValues},
      {"division of integers by zero", "0 and the event divide_by_zero; MOD gives 0", kEvents},
      {"conversion of a value that does not fit", "saturates from reals, low bits between integers",
       "../guides/conversions.md"},
      {"strings that do not fit", "are cut, with the event truncated", kEvents},
      {"values outside of a subrange", "the nearest limit, with the event out_of_range", kEvents},
      {"indices outside of an array", "read zeros, write nothing, with the event bad_index", kEvents},
      {"null references", "read zeros, write nothing, with the event null_reference", kEvents},
      {"CASE without a branch that fits", "nothing happens", kStatements},
      {"selector of MUX outside of its inputs", "the first or the last, with the event bad_index", kValues},
  };
}

struct Count {
  std::size_t yes = 0, partly = 0, no = 0;
};

Count count(const FeatureTables& features) {
  Count sum;
  for (const FeatureTable& table : features.tables) {
    for (const Feature& feature : table.features) {
      ++(feature.answer == Answer::kYes ? sum.yes : feature.answer == Answer::kPartly ? sum.partly : sum.no);
    }
  }
  return sum;
}

}  // namespace

Page conformance_page(const FeatureTables& features, const std::filesystem::path& cases) {
  const Count sum = count(features);
  std::ostringstream out;
  out << generated_from("tests/cases/tables.txt, the cases and stdlib/") << "# Conformance with IEC 61131-3:2013\n\n"
      << fmt::format(
             "This system complies with the requirements of IEC 61131-3:2013 for the features answered with yes: {} of "
             "them;\n"
             "{} partly, {} not. The texts are our own; numbers are those of the standard's tables where the features "
             "are the\n"
             "same. A case is a program with hand-made results that the tests run, examples are those of the library, "
             "which\n"
             "the tests run too. What the standard leaves open is [below](#parameters-of-the-implementer).\n",
             sum.yes, sum.partly, sum.no);
  for (const FeatureTable& table : features.tables) {
    out << "\n## Table " << table.title
        << "\n\n| feature | what | here | shown by | note |\n| --- | --- | --- | --- | --- |\n";
    for (const Feature& feature : table.features) {
      out << fmt::format("| {} | {} | {} | {} | {} |\n", feature.number, cell(feature.text),
                         answer_word(feature.answer), evidence(feature, cases), cell(feature.note));
    }
  }
  out << "\n## Parameters of the implementer\n\n| parameter | here | |\n| --- | --- | --- |\n";
  for (const Parameter& parameter : parameters()) {
    out << fmt::format("| {} | {} | {} |\n", parameter.what, cell(parameter.value),
                       parameter.page.empty() ? "" : fmt::format("[more]({})", parameter.page));
  }
  return {"conformance.md", out.str()};
}

}  // namespace plc::tools
