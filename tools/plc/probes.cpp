#include "tools/plc/probes.h"

#include <fmt/format.h>

#include <functional>
#include <string_view>

#include "stdlib/library.h"

namespace plc::tools {
namespace {

using runtime::CostKind;

/// Copies of a statement in one program: so many that the rest of a scan is small beside them.
constexpr int kCopies = 400;

/// A project of one program, in one task or beside another one.
struct Text {
  std::string types{};      ///< and other POUs
  std::string globals{};    ///< of a VAR_GLOBAL
  std::string externals{};  ///< the same, as the program declares them
  std::string variables{};
  std::string statements{};
  std::string partner{};  ///< statements of a second program on the same globals

  [[nodiscard]] std::string project() const {
    std::string text = types;
    const auto program = [&](std::string_view name, const std::string& own, const std::string& body) {
      text += fmt::format("PROGRAM {}\n", name);
      if (!externals.empty()) text += fmt::format("VAR_EXTERNAL {} END_VAR\n", externals);
      if (!own.empty()) text += fmt::format("VAR\n{}END_VAR\n", own);
      text += fmt::format("{};\nEND_PROGRAM\n", body);
    };
    program("Main", variables, statements);
    if (!partner.empty()) program("Partner", variables, partner);
    text += "CONFIGURATION C\n";
    if (!globals.empty()) text += fmt::format("VAR_GLOBAL {} END_VAR\n", globals);
    text += "RESOURCE R ON PLC\nTASK T(INTERVAL := T#10ms, PRIORITY := 0);\n";
    if (!partner.empty()) text += "TASK U(INTERVAL := T#10ms, PRIORITY := 1);\n";
    text += "PROGRAM main WITH T : Main;\n";
    if (!partner.empty()) text += "PROGRAM other WITH U : Partner;\n";
    return text + "END_RESOURCE\nEND_CONFIGURATION\n";
  }
};

/// `count` times what `make` gives for 0, 1, ..
std::string repeat(int count, const std::function<std::string(int)>& make) {
  std::string text;
  for (int i = 0; i < count; ++i) text += make(i) + '\n';
  return text;
}
/// Variables v0, v1, .. of a type.
std::string variables(std::string_view name, std::string_view type, int count = kCopies) {
  return repeat(count, [&](int i) { return fmt::format("{}{} : {};", name, i, type); });
}
/// The same statement kCopies times, each time on its own variables: # stands for the number.
std::string statements(std::string_view pattern, int count = kCopies) {
  return repeat(count, [&](int i) {
    std::string one;
    for (const char c : pattern) one += c == '#' ? std::to_string(i) : std::string(1, c);
    return one;
  });
}

std::string move() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT"), .statements = statements("v# := w#;")}
      .project();
}
std::string compute() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT") + variables("x", "DINT"),
              .statements = statements("v# := w# + x#;")}
      .project();
}
std::string divide() {
  return Text{
      .variables = variables("v", "LINT") + variables("w", "LINT := 123456789012345") + variables("x", "LINT := 789"),
      .statements = statements("v# := w# / x#;")}
      .project();
}
std::string branch() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT") + variables("b", "BOOL := TRUE"),
              .statements = statements("IF b# THEN v# := w#; END_IF;")}
      .project();
}
std::string jump() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT") + variables("b", "BOOL := TRUE"),
              .statements = statements("IF b# THEN v# := w#; ELSE w# := v#; END_IF;")}
      .project();
}
std::string test() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT") + variables("x", "DINT := 5"),
              .statements = statements("IF x# > w# THEN v# := x#; END_IF;")}
      .project();
}
std::string record() {
  return Text{.variables = variables("o", "BOOL", 2000) + variables("a", "BOOL", 2000) + variables("b", "BOOL", 2000),
              .statements = statements("o# := a# AND NOT b#;", 2000)}
      .project();
}
std::string wide_record() {
  return Text{
      .variables = "a : ARRAY[0..99999] OF BOOL;\nb : ARRAY[0..99999] OF BOOL;\n",
      .statements = repeat(
          2000, [](int i) { return fmt::format("a[{}] := b[{}] AND NOT b[{}];", i * 40, 99999 - i * 7, i * 40); })}
      .project();
}
std::string run() {
  return Text{
      .variables = variables("o", "BOOL") + variables("a", "BOOL") + variables("v", "DINT") + variables("w", "DINT"),
      .statements = statements("o# := NOT a#; v# := w#;")}
      .project();
}
std::string byte() {
  return Text{.types = "TYPE Block : ARRAY[0..999] OF BYTE; END_TYPE\n",
              .variables = variables("v", "Block", 50) + variables("w", "Block", 50),
              .statements = statements("v# := w#;", 50)}
      .project();
}
std::string copy() {
  return Text{.types = "TYPE Pair : STRUCT a : INT; b : INT; END_STRUCT; END_TYPE\n",
              .variables = variables("v", "Pair") + variables("w", "Pair"),
              .statements = statements("v# := w#;")}
      .project();
}
std::string access() {
  return Text{.variables = variables("v", "DINT") + variables("w", "DINT") + variables("r", "REF_TO DINT"),
              .statements = statements("r# := REF(w#);") + statements("v# := r#^;") + statements("r#^ := v#;")}
      .project();
}
std::string element() {
  return Text{.variables = "a : ARRAY[1..100] OF DINT;\n" + variables("v", "DINT") + variables("i", "INT := 3"),
              .statements = statements("v# := a[i#];")}
      .project();
}
std::string index() {
  return Text{.variables = "a : ARRAY[1..8, 1..8] OF DINT;\n" + variables("v", "DINT") + variables("i", "INT := 3") +
                           variables("k", "INT := 5"),
              .statements = statements("v# := a[i#, k#];")}
      .project();
}
std::string call() {
  return Text{.types = "FUNCTION_BLOCK Part\nVAR n : DINT; m : DINT; END_VAR\nn := m;\nEND_FUNCTION_BLOCK\n",
              .variables = variables("p", "Part"),
              .statements = statements("p#();")}
      .project();
}
std::string function() {
  return Text{.types = "FUNCTION Nothing : DINT\nVAR m : DINT; END_VAR\nNothing := m;\nEND_FUNCTION\n",
              .statements = statements("Nothing();")}
      .project();
}
std::string argument() {
  return Text{.types =
                  "FUNCTION First : DINT\nVAR_INPUT a : DINT; b : DINT; c : DINT; d : DINT; e : DINT; END_VAR\n"
                  "First := a;\nEND_FUNCTION\n",
              .variables = variables("v", "DINT") + variables("w", "DINT"),
              .statements = statements("v# := First(w#, w#, w#, w#, w#);")}
      .project();
}
std::string block() { return Text{.variables = variables("b", "TON"), .statements = statements("b#();")}.project(); }
std::string standard() {
  return Text{.variables = variables("v", "REAL") + variables("w", "REAL"), .statements = statements("v# := ABS(w#);")}
      .project();
}
/// As many different functions as there are of one number.
std::string fetch() {
  std::string declared, calls;
  int number = 0;
  for (const stdlib::Overload& overload : stdlib::overloads()) {
    const bool plain = overload.spec->param_count == 1 && !stdlib::is_bundle_output(*overload.spec) &&
                       core::in_category(overload.param_type(0), core::kAnyNum) &&
                       core::in_category(overload.result_type(), core::kAnyNum);
    if (!plain || stdlib::result_is_open(*overload.spec)) continue;
    declared += fmt::format("v{0} : {1};\nw{0} : {2};\n", number, core::name_of(overload.result_type()),
                            core::name_of(overload.param_type(0)));
    calls += fmt::format("v{0} := {1}(w{0});\n", number, overload.name);
    if (++number == kCopies) break;
  }
  return Text{.variables = declared, .statements = calls}.project();
}

std::string read_one() {
  return Text{.globals = "g : DINT;",
              .externals = "g : DINT;",
              .variables = "v : DINT;\n",
              .statements = "v := g;",
              .partner = "g := g + 1"}
      .project();
}
constexpr std::string_view kManyGlobals = "g : ARRAY[0..9999] OF DINT;";
std::string read_many() {
  return Text{.globals = std::string(kManyGlobals),
              .externals = std::string(kManyGlobals),
              .variables = "v : DINT;\n",
              .statements = "v := g[1];",
              .partner = "g[2] := g[2] + 1"}
      .project();
}
std::string write_one() {
  return Text{.globals = "g : DINT;", .externals = "g : DINT;", .variables = "v : DINT;\n", .statements = "g := v;"}
      .project();
}
std::string write_many() {
  return Text{.globals = std::string(kManyGlobals),
              .externals = std::string(kManyGlobals),
              .variables = "v : DINT;\n",
              .statements = "g[1] := v;"}
      .project();
}
/// Each finds all values changed by the other one, and changes them all.
std::string shared() {
  return Text{.types = "TYPE Many : ARRAY[0..999] OF DINT; END_TYPE\n",
              .globals = "g : Many;",
              .externals = "g : Many;",
              .variables = "ones : Many := [1000(1)];\ntwos : Many := [1000(2)];\n",
              .statements = "g := ones;",
              .partner = "g := twos"}
      .project();
}

}  // namespace

std::vector<Probe> probes() {
  return {
      {CostKind::kScan, Text{}.project()},
      {CostKind::kMove, move()},
      {CostKind::kCompute, compute()},
      {CostKind::kDivide, divide()},
      {CostKind::kBranch, branch()},
      {CostKind::kJump, jump()},
      {CostKind::kTest, test()},
      {CostKind::kRecord, record()},
      {CostKind::kWideRecord, wide_record()},
      {CostKind::kRun, run()},
      {CostKind::kByte, byte()},
      {CostKind::kCopy, copy()},
      {CostKind::kElement, element()},
      {CostKind::kAccess, access()},
      {CostKind::kIndex, index()},
      {CostKind::kCall, call()},
      {CostKind::kFunction, function()},
      {CostKind::kArgument, argument()},
      {CostKind::kBlock, block()},
      {CostKind::kStandard, standard()},
      {CostKind::kFetch, fetch()},
      {CostKind::kImport, read_one(), true},
      {CostKind::kImportByte, read_many(), true},
      {CostKind::kExport, write_one()},
      {CostKind::kExportByte, write_many()},
      {CostKind::kShared, shared(), true},
  };
}

std::vector<Sample> samples() {
  return {
      {"logic, 300 rungs with timers",
       Text{.variables = variables("i", "BOOL", 301) + variables("o", "BOOL", 300) + variables("t", "TON", 100),
            .statements = repeat(300,
                                 [](int n) {
                                   std::string rung = fmt::format("o{0} := (i{0} OR o{0}) AND NOT i{1};", n, n + 1);
                                   if (n % 3 == 0) {
                                     rung += fmt::format(" t{0}(IN := o{1}, PT := T#1s); o{1} := t{0}.Q;", n / 3, n);
                                   }
                                   return rung;
                                 })}
           .project()},
      {"arithmetic, 200 scalings",
       Text{.variables =
                variables("raw", "INT := 1234", 200) + variables("v", "REAL", 200) + variables("f", "REAL", 200),
            .statements =
                statements("v# := INT_TO_REAL(raw#) * 0.25 - 100.0; f# := f# + (LIMIT(0.0, v#, 250.0) - f#) / 8.0;"
                           " IF f# > 200.0 THEN f# := SQRT(f#); END_IF;",
                           200)}
           .project()},
      {"loops, sums over 1,000 elements",
       Text{.variables = "a : ARRAY[0..999] OF DINT; i, k : INT; sum, most : DINT;\n",
            .statements = "FOR i := 0 TO 999 DO a[i] := a[i] + 3; sum := sum + a[i]; END_FOR;\n"
                          "FOR i := 0 TO 99 DO FOR k := 0 TO 9 DO IF a[10 * i + k] > most THEN most := a[10 * i + k];"
                          " END_IF; END_FOR; END_FOR"}
           .project()},
      {"texts, 50 messages",
       Text{.variables = variables("s", "STRING", 50) + variables("n", "DINT := 4711", 50),
            .statements =
                statements("s# := CONCAT('level ', DINT_TO_STRING(n#), ' mm'); n# := LEN(s#) + FIND(s#, 'mm');", 50)}
           .project()},
      {"blocks of blocks, 60 motors",
       Text{.types = "FUNCTION_BLOCK Motor\nVAR_INPUT start, stop : BOOL; speed : REAL; END_VAR\n"
                     "VAR_OUTPUT run : BOOL; out : REAL; END_VAR\nVAR delay : TON; starts : CTU; END_VAR\n"
                     "run := (start OR run) AND NOT stop;\ndelay(IN := run, PT := T#2s);\n"
                     "starts(CU := delay.Q, R := FALSE, PV := 100);\n"
                     "IF delay.Q THEN out := speed * 0.9; ELSE out := 0.0; END_IF;\nEND_FUNCTION_BLOCK\n",
            .variables = variables("m", "Motor", 60),
            .statements = statements("m#(start := TRUE, stop := FALSE, speed := 10.0);", 60)}
           .project()},
  };
}

}  // namespace plc::tools
