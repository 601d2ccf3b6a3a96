// Every function block as users reach it: an instance called in ST, and a drawn block. Its examples hold, and on random
// inputs it does what its step does on a port struct of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/library/project.h"
#include "tests/library/values.h"

namespace plc::test {
namespace {

using stdlib::BlockExample;
using stdlib::BlockSpec;
using stdlib::Direction;
using stdlib::Field;

std::vector<const Field*> fields_of(const BlockSpec& block, Direction direction) {
  std::vector<const Field*> out;
  for (const Field& field : block.fields) {
    if (field.direction == direction) out.push_back(&field);
  }
  return out;
}

// ---- scripts: inputs and expected outputs, scan by scan ---------------------------------------------------------

struct Scan {
  core::TimeNs now_ns = 0;
  std::vector<std::optional<Value>> inputs{};  ///< in the order of the fields; nothing leaves an input as it is
  std::vector<std::optional<Value>> outputs{};
};
struct Script {
  std::string title;
  std::vector<Scan> scans{};
};

/// Equal, or reals within what an example's text can say.
bool close(const Value& got, const Value& expected, bool as_text) {
  if (got == expected) return true;
  if (!as_text || !core::in_category(expected.type, core::kAnyReal)) return false;
  return std::fabs(real_of(got) - real_of(expected)) <= 1e-6 * std::max(1.0, std::fabs(real_of(expected)));
}

std::vector<std::vector<std::string>> cells_of(std::string_view table) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines{std::string(table)};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t bar = line.find('|');
    if (bar != std::string::npos) line.replace(bar, 1, " | ");
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; words >> word;) row.push_back(word);
    if (!row.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

/// Literals of the examples, read by the compiler as initial values of variables.
class Literals {
 public:
  /// The place of a literal among those of value().
  std::size_t add(const std::string& literal, TypeId type) {
    const bool is_nan = literal == "NaN";  // which no literal of ST says
    program_.variables.push_back(
        {fmt::format("c{}", types_.size()), std::string(core::name_of(type)), is_nan ? "" : literal});
    types_.push_back(type);
    if (is_nan) not_numbers_.insert(types_.size() - 1);
    return types_.size() - 1;
  }
  [[nodiscard]] std::string read() {
    project_.emplace("literals.st", structured_text({program_}));
    return project_->problem();
  }
  Value value(std::size_t i) {
    if (not_numbers_.count(i) != 0) return real_value(types_[i], std::nan(""));
    return project_->read(fmt::format("p0.c{}", i), types_[i]);
  }

 private:
  ProgramText program_;
  std::vector<TypeId> types_;
  std::set<std::size_t> not_numbers_;
  std::optional<Project> project_;
};

/// One example, literals read later.
struct Reading {
  struct Cell {
    std::size_t scan;
    bool is_output;
    std::size_t field;
    std::size_t literal;
  };
  Script script;
  std::vector<Cell> cells;
  std::vector<std::size_t> times;
};

Reading read_example(const BlockSpec& block, const BlockExample& example, Literals& literals) {
  Reading out{{std::string(block.name) + ": " + std::string(example.title)}, {}, {}};
  const auto inputs = fields_of(block, Direction::kInput), outputs = fields_of(block, Direction::kOutput);
  const auto rows = cells_of(example.table);
  if (rows.size() < 2 || rows[0][0] != "at") {
    ADD_FAILURE() << out.script.title << ": a table begins with \"at\" and has a line for each scan";
    return out;
  }
  const std::vector<std::string>& head = rows[0];
  const auto bar = static_cast<std::size_t>(std::find(head.begin(), head.end(), "|") - head.begin());
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != head.size() || bar >= head.size() || rows[r][bar] != "|") {
      ADD_FAILURE() << out.script.title << ": line " << r << " has other columns than the first line";
      return out;
    }
    out.times.push_back(literals.add(rows[r][0], TypeId::kTime));
    out.script.scans.push_back(
        {0, std::vector<std::optional<Value>>(inputs.size()), std::vector<std::optional<Value>>(outputs.size())});
    for (std::size_t c = 1; c < head.size(); ++c) {
      if (c == bar || rows[r][c] == ".") continue;
      const auto& fields = c < bar ? inputs : outputs;
      const Field* const named = stdlib::field_named(block, head[c]);
      const auto at = static_cast<std::size_t>(std::find(fields.begin(), fields.end(), named) - fields.begin());
      if (at == fields.size()) {
        ADD_FAILURE() << out.script.title << ": there is no " << (c < bar ? "input " : "output ") << head[c];
        return out;
      }
      out.cells.push_back({r - 1, c > bar, at, literals.add(rows[r][c], named->type)});
    }
  }
  return out;
}

/// A value that a block can make something of: small numbers and short times mostly, any sample now and then.
Value random_input(TypeId type, Sequence& sequence) {
  const auto samples = samples_of(type);
  if (sequence.below(20) == 0 || is_string(type)) return samples[sequence.below(samples.size())].value;
  const auto small = static_cast<std::int64_t>(sequence.below(6));
  if (type == TypeId::kBool) return {type, sequence.below(2), {}};
  if (core::in_category(type, core::kAnyReal)) return real_value(type, static_cast<double>(small) - 2.5);
  const std::int64_t unit = core::in_category(type, core::kAnyDuration | core::kAnyDate) ? 20'000'000 : 1;
  return {type, static_cast<std::uint64_t>(small * unit), {}};
}

/// Random inputs, and what the step of the block makes of them.
Script random_script(const BlockSpec& block) {
  Script script{std::string(block.name) + " on random inputs", {}};
  Sequence sequence(block.name);
  const auto inputs = fields_of(block, Direction::kInput), outputs = fields_of(block, Direction::kOutput);
  std::vector<std::uint64_t> memory((block.size + 7) / 8);
  auto* const ports = reinterpret_cast<std::byte*>(memory.data());
  std::memcpy(ports, block.initial, block.size);
  core::TimeNs now = 0;
  for (int i = 0; i < 300; ++i) {
    Scan scan{now, {}, {}};
    for (const Field* field : inputs) {
      const bool stays = sequence.below(3) != 0;
      scan.inputs.push_back(stays ? std::nullopt : std::optional(random_input(field->type, sequence)));
      if (!stays) Cell::write(ports + field->offset, *scan.inputs.back());
    }
    block.step(ports, {.now_ns = now, .utc_ns = now});
    for (const Field* field : outputs) scan.outputs.emplace_back(Cell::read(ports + field->offset, field->type));
    script.scans.push_back(std::move(scan));
    now += static_cast<core::TimeNs>(1 + sequence.below(30)) * 1'000'000;
  }
  return script;
}

// ---- programs ---------------------------------------------------------------------------------------------------

enum class Written : std::uint8_t { kText, kDrawn };

std::string input_of(std::size_t block, std::size_t i) { return fmt::format("i{}_{}", block, i); }
std::string output_of(std::size_t block, std::size_t i) { return fmt::format("o{}_{}", block, i); }
std::string instance_of(std::size_t block) { return fmt::format("b{}", block); }

/// One instance of every block, with a variable at each input and output.
std::string program_with_all_blocks(Written how) {
  ProgramText program;
  const auto blocks = stdlib::blocks();
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    DrawnBlock drawn{std::string(blocks[k].name), instance_of(k), {}, {}};
    const auto add = [&](const Field& field, const std::string& variable, std::vector<DrawnBlock::Pin>& pins) {
      program.variables.push_back({variable, std::string(core::name_of(field.type))});
      pins.push_back({std::string(field.name), variable});
    };
    const auto inputs = fields_of(blocks[k], Direction::kInput), outputs = fields_of(blocks[k], Direction::kOutput);
    for (std::size_t i = 0; i < inputs.size(); ++i) add(*inputs[i], input_of(k, i), drawn.inputs);
    for (std::size_t i = 0; i < outputs.size(); ++i) add(*outputs[i], output_of(k, i), drawn.outputs);
    program.variables.push_back({instance_of(k), std::string(blocks[k].name)});
    std::string call = instance_of(k) + "(";
    for (const auto& pin : drawn.inputs) call += (call.ends_with('(') ? "" : ", ") + pin.name + " := " + pin.variable;
    for (const auto& pin : drawn.outputs) call += (call.ends_with('(') ? "" : ", ") + pin.name + " => " + pin.variable;
    program.statements.push_back(call + ");");
    program.blocks.push_back(std::move(drawn));
  }
  return how == Written::kText ? structured_text({program}) : plcopen_xml({program});
}

/// Runs the script on block `k`. The inputs begin as a fresh instance has them.
void run(Project& project, std::size_t k, const Script& script, bool as_text) {
  const BlockSpec& block = stdlib::blocks()[k];
  const auto inputs = fields_of(block, Direction::kInput), outputs = fields_of(block, Direction::kOutput);
  project.restart();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto* const fresh = static_cast<const std::byte*>(block.initial) + inputs[i]->offset;
    project.write("p0." + input_of(k, i), Cell::read(fresh, inputs[i]->type));
  }
  for (std::size_t s = 0; s < script.scans.size(); ++s) {
    const Scan& scan = script.scans[s];
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (scan.inputs[i]) project.write("p0." + input_of(k, i), *scan.inputs[i]);
    }
    ASSERT_EQ(project.scan(scan.now_ns), "") << script.title;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (!scan.outputs[i]) continue;
      const Value got = project.read("p0." + output_of(k, i), outputs[i]->type);
      ASSERT_TRUE(close(got, *scan.outputs[i], as_text))
          << script.title << ", scan " << s << " at " << scan.now_ns << " ns: " << outputs[i]->name << " is "
          << shown(got) << ", expected " << shown(*scan.outputs[i]);
    }
  }
}

class Blocks : public ::testing::TestWithParam<Written> {
 protected:
  Blocks() : project_(GetParam() == Written::kText ? "blocks.st" : "blocks.xml", program_with_all_blocks(GetParam())) {}
  void SetUp() override { ASSERT_EQ(project_.problem(), ""); }
  Project project_;
};

TEST_P(Blocks, DoWhatTheirStepDoes) {
  std::cout << fmt::format("{} blocks in each of {} engines\n", stdlib::blocks().size(), project_.engines());
  for (std::size_t k = 0; k < stdlib::blocks().size(); ++k) {
    run(project_, k, random_script(stdlib::blocks()[k]), false);
  }
}

TEST_P(Blocks, DoWhatTheirExamplesSay) {
  Literals literals;
  std::vector<std::pair<std::size_t, Reading>> readings;
  for (std::size_t k = 0; k < stdlib::blocks().size(); ++k) {
    const BlockSpec& block = stdlib::blocks()[k];
    for (const BlockExample& example : block.examples) {
      readings.emplace_back(k, read_example(block, example, literals));
    }
  }
  if (readings.empty()) return;
  ASSERT_EQ(literals.read(), "");
  for (auto& [k, reading] : readings) {
    for (std::size_t s = 0; s < reading.times.size(); ++s) {
      reading.script.scans[s].now_ns = static_cast<core::TimeNs>(literals.value(reading.times[s]).bits);
    }
    for (const Reading::Cell& cell : reading.cells) {
      Scan& scan = reading.script.scans[cell.scan];
      (cell.is_output ? scan.outputs : scan.inputs)[cell.field] = literals.value(cell.literal);
    }
    run(project_, k, reading.script, true);
  }
}

INSTANTIATE_TEST_SUITE_P(Library, Blocks, ::testing::Values(Written::kText, Written::kDrawn),
                         [](const auto& how) { return how.param == Written::kText ? "InText" : "Drawn"; });

// What the programs above pass over would be untested without a word.
TEST(BlockSpecs, HaveInputsAndOutputsOnly) {
  for (const BlockSpec& block : stdlib::blocks()) {
    EXPECT_TRUE(fields_of(block, Direction::kInOut).empty()) << block.name << " needs a variable at its in-out";
  }
}

}  // namespace
}  // namespace plc::test
