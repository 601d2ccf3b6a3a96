// Projects that call the library as users do: text with calls in ST and PLCopen XML with drawn blocks, compiled by the
// whole pipeline and run cycle by cycle in every engine.
//
// In: declarations, statements, blocks to draw. Out: a running resource whose variables are read and written by path.
// Does not belong here: which functions are called, what they should give.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/library/values.h"
#include "tests/support/engines.h"

namespace plc::test {

struct Declaration {
  std::string name;
  std::string type;       ///< as ST writes it: "DINT", "STRING", "TON"
  std::string initial{};  ///< constant expression, or empty
};

/// A drawn block with a variable at each pin.
struct DrawnBlock {
  struct Pin {
    std::string name;
    std::string variable;
  };
  std::string type;        ///< "ADD", "TON"
  std::string instance{};  ///< of a function block
  std::vector<Pin> inputs{};
  std::vector<Pin> outputs{};
};

/// One PROGRAM, in text or drawn.
struct ProgramText {
  std::vector<Declaration> variables{};
  std::vector<std::string> statements{};  ///< ST
  std::vector<DrawnBlock> blocks{};       ///< FBD; order of execution as they are here
};

/// Programs P0, P1, .. of one task, instances "p0", "p1", ..
std::string structured_text(const std::vector<ProgramText>& programs);
std::string plcopen_xml(const std::vector<ProgramText>& programs);

/// A project compiled and ready to run in every engine.
class Project {
 public:
  /// `file_name` tells the language: "calls.st", "calls.xml".
  Project(const std::string& file_name, const std::string& text);
  /// Why it did not compile; empty when it did.
  [[nodiscard]] const std::string& problem() const { return problem_; }

  [[nodiscard]] Value read(const std::string& path, TypeId type);
  void write(const std::string& path, const Value& value);
  /// One cycle. What differs between engines then, or that it ended with a fault; else nothing.
  [[nodiscard]] std::string scan(core::TimeNs now_ns);
  void restart();
  [[nodiscard]] std::size_t engines() const { return engines_->size(); }

 private:
  /// Where the variable is in the task's table.
  std::uint32_t offset(const std::string& path);

  std::string problem_;
  std::unique_ptr<Engines> engines_;
  std::map<std::string, std::uint32_t> offsets_;
};

}  // namespace plc::test
