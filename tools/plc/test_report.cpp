#include "tools/plc/test_report.h"

#include <fmt/format.h>

#include "tools/command_line.h"

namespace plc::tools {
namespace {

using tests::Failure;
using tests::TestResult;

/// Texts in XML, and in its attributes: what XML 1.0 cannot hold becomes '?'.
std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default: {
        const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
        out += control ? '?' : c;
      }
    }
  }
  return out;
}

/// A text in single quotes as YAML has it.
std::string yaml(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c == '\n' ? ' ' : c);
  return out + "'";
}

/// What TAP reads as its own in a description.
std::string tap_name(const std::string& name) {
  std::string out;
  for (const char c : name) out += c == '#' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out;
}

std::string seconds(core::TimeNs ns) { return fmt::format("{:.6f}", static_cast<double>(ns) * 1e-9); }

std::string verdict(const Failure& failure) {
  if (failure.expected.empty()) return failure.what;
  return fmt::format("{}: expected {}, got {}", failure.what, failure.expected, failure.got);
}

std::string place(const Failure& failure) {
  if (failure.line == 0) return failure.file;
  return failure.column == 0 ? fmt::format("{}:{}", failure.file, failure.line)
                             : fmt::format("{}:{}:{}", failure.file, failure.line, failure.column);
}

/// How many failures are counted and not kept; nothing where all are.
std::string more_text(const TestResult& result) {
  if (result.failure_count <= result.failures.size()) return {};
  return fmt::format("and {} more", result.failure_count - result.failures.size());
}

}  // namespace

TestTotals totals_of(const std::vector<Suite>& suites) {
  TestTotals totals;
  for (const Suite& suite : suites) {
    totals.broken += suite.errors.empty() ? 0 : 1;
    totals.tests += suite.results.size();
    for (const TestResult& result : suite.results) {
      totals.failed += result.passed() ? 0 : 1;
      totals.checks += result.checks;
    }
  }
  return totals;
}

std::string failure_text(const Failure& failure) {
  std::string out = fmt::format("{}: {}, after {}, cycle {}", place(failure), verdict(failure),
                                duration_text(static_cast<double>(failure.at_ns)), failure.cycle);
  if (!failure.message.empty()) out += ": " + failure.message;
  return out;
}

void print_suite(const Suite& suite, std::ostream& out) {
  out << suite.name << '\n';
  for (const std::string& error : suite.errors) out << "  error: " << error << '\n';
  for (const TestResult& result : suite.results) {
    out << (result.passed() ? "  ok    " : "  FAIL  ") << result.name;
    if (result.cycles != 0)
      out << fmt::format(" ({}, {})", counted(result.cycles, "cycle"),
                         duration_text(static_cast<double>(result.virtual_ns)));
    out << '\n';
    for (const Failure& failure : result.failures) out << "        " << failure_text(failure) << '\n';
    if (const std::string more = more_text(result); !more.empty()) out << "        " << more << '\n';
  }
}

std::string totals_text(const TestTotals& totals) {
  std::string out =
      fmt::format("{}, {} failed, {}", counted(totals.tests, "test"), totals.failed, counted(totals.checks, "check"));
  if (totals.broken != 0) out += fmt::format("; {} could not run", counted(totals.broken, "project"));
  return out;
}

void print_tap(const std::vector<Suite>& suites, std::ostream& out) {
  const TestTotals totals = totals_of(suites);
  out << "TAP version 14\n1.." << totals.tests + totals.broken << '\n';
  std::size_t number = 0;
  for (const Suite& suite : suites) {
    if (!suite.errors.empty()) {
      out << fmt::format("not ok {} - {}: could not run\n  ---\n  message: {}\n  ...\n", ++number, tap_name(suite.name),
                         yaml(suite.errors.front()));
    }
    for (const TestResult& result : suite.results) {
      out << fmt::format("{} {} - {}: {}\n", result.passed() ? "ok" : "not ok", ++number, tap_name(suite.name),
                         tap_name(result.name));
      if (result.passed()) continue;
      out << "  ---\n  failures:\n";
      for (const Failure& failure : result.failures) {
        out << fmt::format("    - at: {}\n      message: {}\n      after: {}\n      cycle: {}\n", yaml(place(failure)),
                           yaml(verdict(failure)), yaml(duration_text(static_cast<double>(failure.at_ns))),
                           failure.cycle);
        if (!failure.message.empty()) out << fmt::format("      text: {}\n", yaml(failure.message));
        if (failure.expected.empty()) continue;
        out << fmt::format("      expected: {}\n      got: {}\n", yaml(failure.expected), yaml(failure.got));
      }
      if (const std::string more = more_text(result); !more.empty()) out << "  more: " << yaml(more) << '\n';
      out << "  ...\n";
    }
  }
}

std::string junit_xml(const std::vector<Suite>& suites) {
  const TestTotals totals = totals_of(suites);
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites tests=\"{}\" failures=\"{}\" errors=\"{}\">\n",
      totals.tests + totals.broken, totals.failed, totals.broken);
  for (const Suite& suite : suites) {
    const TestTotals own = totals_of({suite});
    core::TimeNs took = 0;
    for (const TestResult& result : suite.results) took += result.took_ns;
    out += fmt::format("<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{}\">\n",
                       xml(suite.name), own.tests + own.broken, own.failed, own.broken, seconds(took));
    if (!suite.errors.empty()) {
      out += fmt::format("<testcase name=\"compile\" classname=\"{}\"><error message=\"{}\"/></testcase>\n",
                         xml(suite.name), xml(suite.errors.front()));
    }
    for (const TestResult& result : suite.results) {
      out += fmt::format("<testcase name=\"{}\" classname=\"{}\" file=\"{}\" line=\"{}\" assertions=\"{}\" time=\"{}\"",
                         xml(result.name), xml(suite.name), xml(result.file), result.line, result.checks,
                         seconds(result.took_ns));
      if (result.passed()) {
        out += "/>\n";
        continue;
      }
      out += ">\n";
      for (const Failure& failure : result.failures) {
        out += fmt::format("<failure message=\"{}\">{}</failure>\n", xml(verdict(failure)), xml(failure_text(failure)));
      }
      if (const std::string more = more_text(result); !more.empty())
        out += fmt::format("<failure message=\"{0}\">{0}</failure>\n", more);
      out += "</testcase>\n";
    }
    out += "</testsuite>\n";
  }
  return out + "</testsuites>\n";
}

}  // namespace plc::tools
