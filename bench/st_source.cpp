#include "bench/st_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <random>

namespace plc::bench {
namespace {

using Engine = std::mt19937_64;

std::size_t below(Engine& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

/// A function block: an axis with limits, a state machine, a filter, alarms.
std::string block(std::uint32_t index, Engine& random) {
  const auto number = [&](std::size_t n) { return below(random, n); };
  std::string out = fmt::format(
      "FUNCTION_BLOCK FB_Axis{}\nVAR_INPUT\n  Enable, Reset : BOOL;\n  Setpoint : REAL := {}.5;\n"
      "  Mode : E_Mode;\n  Limits : ST_Limits;\nEND_VAR\nVAR_OUTPUT\n  Busy, Alarm : BOOL;\n"
      "  Position : REAL;\n  Code : WORD;\nEND_VAR\nVAR\n  state, count, i : INT;\n"
      "  history : ARRAY[0..15] OF REAL;\n  sum, error, gain : REAL := 1.0;\n"
      "  delay : TON;\n  edge : R_TRIG;\n",
      index, number(100));
  if (index >= 8) out += fmt::format("  slave : FB_Axis{};\n", index % 8);
  out +=
      "END_VAR\n(* follows the setpoint within its limits *)\nedge(CLK := Enable);\n"
      "IF Reset OR edge.Q THEN\n  state := 0;\n  count := 0;\n  Code := 16#0000;\nEND_IF;\nCASE state OF\n";
  const std::size_t states = 4 + number(4);
  for (std::size_t s = 0; s < states; ++s) {
    out += fmt::format("  {}:\n    error := (Setpoint - Position) * gain + {}.25;\n", s, number(50));
    switch (number(4)) {
      case 0:
        out += fmt::format(
            "    IF error > Limits.High AND NOT Reset THEN\n      state := {};\n"
            "    ELSIF ABS(error) < 0.5 THEN\n      count := count + 1;\n    ELSE\n"
            "      Position := Position + F_Clamp(error / {}.0, Limits.Low, Limits.High);\n    END_IF;\n",
            (s + 1) % states, 2 + number(9));
        break;
      case 1:
        out += fmt::format(
            "    delay(IN := error <= Limits.Low, PT := T#{}ms);\n    IF delay.Q THEN\n      state := {};\n"
            "      Code := Code OR SHL(WORD#16#0001, {});\n    END_IF;\n",
            10 + number(900), (s + 1) % states, number(16));
        break;
      case 2:
        out += fmt::format(
            "    FOR i := 0 TO 14 DO\n      history[i] := history[i + 1];\n      sum := sum + history[i] * {}.5;\n"
            "    END_FOR;\n    history[15] := Position;\n    state := {};\n",
            number(9), (s + 1) % states);
        break;
      default:
        out += fmt::format(
            "    Position := F_Clamp(IN := sum / 16.0 + REAL#{}.0, LOW := Limits.Low, HIGH := Limits.High);\n"
            "    IF count MOD {} = 0 OR Mode = E_Mode#Manual THEN\n      state := {};\n      count := count + 1;\n"
            "    END_IF;\n",
            number(90), 2 + number(20), (s + 1) % states);
    }
  }
  out += "ELSE\n  state := 0;\nEND_CASE;\n";
  if (index >= 8) {
    out +=
        "slave(Enable := Busy AND NOT Alarm, Setpoint := Position / 2.0, Mode := Mode, Limits := Limits);\n"
        "WHILE slave.Position > 100.0 AND count < 10 DO\n  count := count + 1;\nEND_WHILE;\n";
  }
  return out +
         "Alarm := Position > Limits.High * 2.0 OR Code <> 0;\nBusy := Enable AND state <> 0;\nEND_FUNCTION_BLOCK\n\n";
}

std::string repeated(std::string_view piece, std::size_t bytes) {
  std::string out;
  out.reserve(bytes + piece.size());
  while (out.size() < bytes) out += piece;
  out.resize(bytes);
  return out;
}

}  // namespace

std::string make_project(std::uint32_t lines, std::uint64_t seed) {
  Engine random(seed);
  std::string out =
      "TYPE\n  E_Mode : (Automatic, Manual, Service);\n  ST_Limits : STRUCT\n    Low : REAL := -100.0;\n"
      "    High : REAL := 100.0;\n    Name : STRING[20];\n  END_STRUCT;\nEND_TYPE\n\nFUNCTION F_Clamp : "
      "REAL\nVAR_INPUT\n"
      "  In, Low, High : REAL;\nEND_VAR\nIF In < Low THEN\n  F_Clamp := Low;\nELSIF In > High THEN\n  F_Clamp := "
      "High;\n"
      "ELSE\n  F_Clamp := In;\nEND_IF;\nEND_FUNCTION\n\n";
  auto written = static_cast<std::uint32_t>(std::count(out.begin(), out.end(), '\n'));
  std::string instances, calls;
  for (std::uint32_t index = 0; written < lines; ++index) {
    const std::string text = block(index, random);
    instances += fmt::format("  axis{} : FB_Axis{};\n", index, index);
    calls += fmt::format(
        "axis{}(Enable := run, Reset := FALSE, Setpoint := {}.0, Limits := limits, Position => position);\n"
        "total := total + position;\n",
        index, below(random, 1000));
    // Three lines of the program for each block.
    written += static_cast<std::uint32_t>(std::count(text.begin(), text.end(), '\n')) + 3;
    out += text;
  }
  return out +
         "PROGRAM Main\nVAR\n  run : BOOL := TRUE;\n  limits : ST_Limits := (Low := -50.0, High := 50.0);\n"
         "  position, total : REAL;\n" +
         instances + "END_VAR\n" + calls +
         "END_PROGRAM\n\nCONFIGURATION Plant\nRESOURCE Cpu ON Plc\n  TASK Cycle(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "  PROGRAM P WITH Cycle : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n";
}

std::string make_statements(std::size_t bytes, std::uint64_t seed) {
  Engine random(seed);
  std::string out =
      "PROGRAM Main\nVAR\n  a, b, c : DINT;\n  r, s : REAL;\n  f : BOOL;\n  list : ARRAY[0..9] OF INT;\n"
      "  delay : TON;\nEND_VAR\n";
  // '?' stands for a digit.
  static constexpr std::string_view kStatements[] = {
      "a := b * ? + c MOD 7;\n",
      "r := s * ?.5 - r / 3.0;\n",
      "IF a > ? AND NOT f THEN b := b + 1; END_IF;\n",
      "list[?] := list[c MOD 10] + 1;\n",
      "delay(IN := f, PT := T#?ms); f := delay.Q OR f;\n",
      "c := SEL(f, a, MAX(b, ?));\n",
      "FOR a := 0 TO ? DO c := c + a; END_FOR;\n",
      "s := DINT_TO_REAL(a) + r;\n",
  };
  while (out.size() < bytes) {
    std::string statement(kStatements[below(random, std::size(kStatements))]);
    for (char& c : statement) {
      if (c == '?') c = static_cast<char>('0' + below(random, 10));
    }
    out += statement;
  }
  return out +
         "END_PROGRAM\n\nCONFIGURATION Plant\n  TASK Cycle(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "  PROGRAM P WITH Cycle : Main;\nEND_CONFIGURATION\n";
}

std::string garbage_name(Garbage kind) {
  static constexpr const char* kNames[kGarbageCount] = {
      "random bytes",          "random tokens", "a project with wrong characters", "parentheses", "nested IF",
      "a comment without end", "one statement", "an error in every line"};
  return kNames[static_cast<int>(kind)];
}

std::string make_garbage(Garbage kind, std::size_t bytes, std::uint64_t seed) {
  Engine random(seed);
  const std::string_view head = "PROGRAM Main\nVAR x : INT; END_VAR\n";
  std::string out;
  switch (kind) {
    case Garbage::kBytes:
      while (out.size() < bytes) out += static_cast<char>(random());
      return out;
    case Garbage::kTokens: {
      static constexpr const char* kTokens[] = {
          "IF ",     "THEN ",         "x ",       ":= ",       "; ",       "( ",      ") ",
          "END_IF ", "VAR ",          "END_VAR ", "16#FF ",    "'a' ",     "+ ",      "[ ",
          "] ",      "CASE ",         "OF ",      "FUNCTION ", "PROGRAM ", "T#1s ",   ".. ",
          "=> ",     "END_PROGRAM\n", "(* ",      "*) ",       "TYPE ",    "STRUCT\n"};
      while (out.size() < bytes) out += kTokens[below(random, std::size(kTokens))];
      break;
    }
    case Garbage::kMutated:
      // About twenty-five bytes a line.
      out = make_project(static_cast<std::uint32_t>(bytes / 25), seed);
      for (std::size_t i = 0; i < out.size() / 200; ++i)
        out[below(random, out.size())] = static_cast<char>(' ' + random() % 95);
      break;
    case Garbage::kParentheses:
      return fmt::format("{}x := {}", head, repeated("(", bytes));
    case Garbage::kNestedIf:
      return fmt::format("{}{}", head, repeated("IF TRUE THEN\n", bytes));
    case Garbage::kOpenComment:
      return fmt::format("{}(* {}", head, repeated("text (* ", bytes));
    case Garbage::kOneLine:
      return fmt::format("{}x := 1{}", head, repeated(" + y", bytes));
    case Garbage::kErrors:
      return fmt::format("{}{}", head, repeated("x := := unknown 1;\n", bytes));
  }
  out.resize(std::min(out.size(), bytes));
  return out;
}

}  // namespace plc::bench
