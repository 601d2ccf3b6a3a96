// Access: variables by path and as text, for tools, traces and stimuli. Never in a cycle.
//
// In: a resource and paths in any letter case: "Main.Motor.Run", "Conveyor.Timer.Q" (program instance, then fields),
// "Level", "GVL.Level" (global), "Arr[3]", "Matrix[1,2]", "%IX0.0" (global at that address), "Task.Main.Motor" (when
// two tasks have instances of one name). Located and external variables of a POU have paths below its instances too:
// "Main.Sensor" is the global, and so is what is written there. Out: typed places, values as text. Writing normalises:
// BOOL is 0 or 1, ranges and subranges are checked, strings fit their capacity. Threads: globals any thread; task
// variables only between cycles of that task. Text: BOOL 0/1, integers and enumerations decimal, REAL/LREAL shortest
// form that reads back the same, durations and dates in ns, strings in single quotes with $-escapes (IEC
// 61131-3, 6.3.3), CHAR as a string of one; in ValueStyle::kNames enumerations by name and times as literals.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "runtime/resource.h"
#include "runtime/value_text.h"

namespace plc::runtime {

/// A place of a resource: a variable, or any part of one.
struct Place {
  static constexpr std::uint32_t kGlobal = 0xffffffffu;
  std::uint32_t task = kGlobal;  ///< whose table, or kGlobal: the global table
  std::uint32_t offset = 0;      ///< bytes from the start of that table
  std::uint32_t type = 0;        ///< index into Image::types
  bool constant = false;         ///< declared CONSTANT: not written
};

/// A variable that a pattern matched.
struct Listed {
  std::string path;
  Place place;
};

class Access {
 public:
  explicit Access(Resource& resource) : resource_(resource) {}

  /// The place called `path`, or P7101 with the nearest known name as help. Where an instance and a global share a
  /// name, the instance counts.
  [[nodiscard]] core::Result<Place> find(std::string_view path) const;
  /// As find(), but passes over what is not a scalar or a string, and refuses (P7102) when nothing else is called so.
  [[nodiscard]] core::Result<Place> find_leaf(std::string_view path) const;
  /// Paths of scalars and strings that match `pattern`, each once, instances before globals, in declaration order: '*'
  /// any characters, '?' one, letter case ignored; hidden ones only when the pattern has a '#'. At most `limit`. "*"
  /// lists every variable under one path: a global that was declared as one under its own, a located variable of a POU
  /// under the first instance that has it. Other patterns list every path that matches, addresses too when they begin
  /// with '%'. find_leaf() finds what is listed.
  [[nodiscard]] std::vector<std::string> list(std::string_view pattern = "*", std::size_t limit = 1'000'000) const;
  /// The same, with the place that each path has.
  [[nodiscard]] std::vector<Listed> list_places(std::string_view pattern = "*", std::size_t limit = 1'000'000) const;

  /// What people look at: as list(), but a variable that has several names, because declarations give it the address of
  /// another, is listed under each of them, and every name has one path: "*" lists all names, and a pattern that also
  /// matches other paths of the same name lists the first.
  [[nodiscard]] std::vector<std::string> list_names(std::string_view pattern = "*",
                                                    std::size_t limit = 1'000'000) const;

  /// Value of a leaf as text; arrays and structures come out as "[a, b]" and "(x := a, y := b)".
  [[nodiscard]] std::string read(const Place& place, ValueStyle style = ValueStyle::kNumbers) const;
  /// Appends to `out` instead: no allocation once `out` is large enough.
  void read_to(const Place& place, std::string& out, ValueStyle style = ValueStyle::kNumbers) const;
  /// Value of a scalar as an integer (BOOL 0/1); nothing for reals and strings.
  [[nodiscard]] std::optional<std::int64_t> read_integer(const Place& place) const;

  /// Writes a leaf from text. Besides what read() gives: TRUE/FALSE, 16#..., 2#..., 8#..., '_' between digits,
  /// enumeration members (Filling, Step#Filling), T#1s500ms, strings without quotes. Returns nothing, or the problem
  /// (P7103 not a value of the type, P7104 out of range, P7105 too long, P7106 cannot be written, P7107 busy). A global
  /// that a task exports changes at that task's next scan (memory/global_table.h).
  std::optional<core::Problem> write(const Place& place, std::string_view text);

  [[nodiscard]] Resource& resource() const { return resource_; }

 private:
  Resource& resource_;
};

}  // namespace plc::runtime
