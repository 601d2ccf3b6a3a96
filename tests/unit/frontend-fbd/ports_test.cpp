// Ports: which declared pin a drawn one means, and what a block stands for by its name.
#include "frontend-fbd/ports.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using stdlib::Direction;
using test::Diagram;
using test::Sketch;

constexpr const char* kOthers =
    "FUNCTION_BLOCK Own VAR_INPUT EN : BOOL; x, y : INT; END_VAR VAR_OUTPUT ENO : BOOL; q : INT; END_VAR "
    "VAR_IN_OUT io : REAL; END_VAR VAR inner : INT; END_VAR END_FUNCTION_BLOCK\n"
    "ACTION Own.Go x := 1; END_ACTION\n"
    "FUNCTION F : REAL VAR_INPUT a : INT; END_VAR VAR_OUTPUT more : INT; END_VAR END_FUNCTION\n"
    "FUNCTION_BLOCK Number VAR_INPUT EN : INT; END_VAR END_FUNCTION_BLOCK\n";

struct Ports : testing::Test {
  Diagram d{"t : TON; own : Own; f : F_TRIG;", Sketch(), kOthers};
  ir::Builder b = builder();

  ir::Builder builder() {
    d.pou();
    return ir::Builder(*d.module, 0, d.diagnostics);
  }
  static plcopen::Element block(const std::string& type, const std::string& inputs = "",
                                const std::string& outputs = "") {
    Sketch s;
    return s.block(1, type, inputs, outputs);
  }
  /// "in x, out q, io io": names and directions; of the result "= F".
  static std::string shown(const std::optional<std::vector<fbd::Port>>& ports) {
    if (!ports) return "unknown";
    std::string text;
    for (const fbd::Port& port : *ports) {
      text += text.empty() ? "" : ", ";
      text += port.result                            ? "= "
              : port.direction == Direction::kInput  ? "in "
              : port.direction == Direction::kOutput ? "out "
                                                     : "io ";
      text += std::string(port.name);
    }
    return text;
  }
  std::vector<fbd::Port> own() { return *fbd::ports_of_block(b, block("Own own")); }
};

TEST_F(Ports, OfWhateverABlockStandsFor) {
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("TON t"))), "in IN, in PT, out Q, out ET");
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("t"))), "unknown") << "a variable is no type";
  EXPECT_EQ(shown(own()), "in EN, in x, in y, out ENO, out q, io io") << "locals are none";
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("F"))), "= F, in a, out more");
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("own.Go"))), shown(own()));
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("Go own"))), shown(own()));
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("SPLIT_DATE"))), "in IN, out YEAR, out MONTH, out DAY");
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("ADD"))), "unknown") << "its types are open";
  EXPECT_EQ(shown(fbd::ports_of_block(b, block("Nothing"))), "unknown");
}

TEST_F(Ports, OnTheRightSideOfABlock) {
  EXPECT_EQ(shown(fbd::outputs_of(b, block("Own own"))), "out ENO, out q, io io");
  EXPECT_EQ(shown(fbd::outputs_of(b, block("ADD"))), "= ADD");
  EXPECT_EQ(shown(fbd::outputs_of(b, block("DELAY"))), "= DELAY");
  EXPECT_EQ(shown(fbd::outputs_of(b, block("UPPER_BOUND"))), "= UPPER_BOUND");
  EXPECT_EQ(shown(fbd::outputs_of(b, block("QUEUE_GET"))), "= QUEUE_GET, out OUT");
  EXPECT_EQ(shown(fbd::outputs_of(b, block("Nothing"))), "unknown");
}

TEST_F(Ports, AreFoundByNameElseByPlace) {
  const auto ports = own();
  const auto found = [&](Direction direction, const char* pin, std::size_t position) {
    const fbd::Port* port = fbd::find_port(ports, direction, pin, position);
    return port == nullptr ? std::string("none") : std::string(port->name);
  };
  EXPECT_EQ(found(Direction::kInput, "Y", 0), "y");
  EXPECT_EQ(found(Direction::kInput, "", 0), "x") << "EN has no place";
  EXPECT_EQ(found(Direction::kInput, "strange", 1), "y");
  EXPECT_EQ(found(Direction::kInput, "", 2), "none");
  EXPECT_EQ(found(Direction::kOutput, "", 0), "q") << "nor has ENO";
  EXPECT_EQ(found(Direction::kInput, "q", 5), "none") << "of the other side";
}

TEST_F(Ports, OutIsTheResultOfAFunctionWhereverItIsDrawn) {
  fbd::Port result{"Split", {}, Direction::kOutput, 0, {}};
  result.result = true;
  const std::vector<fbd::Port> ports{result, {"high", {}, Direction::kOutput, 1, {}}};
  EXPECT_EQ(fbd::find_port(ports, Direction::kOutput, "out", 1)->name, "Split");
  EXPECT_EQ(fbd::find_port(ports, Direction::kOutput, "strange", 1)->name, "high");
}

TEST_F(Ports, EnAndEnoAreDeclaredAsBool) {
  const auto ports = own();
  ASSERT_NE(fbd::declared_enable(ports), nullptr);
  EXPECT_EQ(fbd::declared_enable(ports)->name, "EN");
  ASSERT_NE(fbd::declared_eno(ports), nullptr);
  EXPECT_EQ(fbd::declared_eno(ports)->name, "ENO");
  const auto number = *fbd::ports_of_block(b, block("Number"));
  EXPECT_EQ(fbd::declared_enable(number), nullptr);
  EXPECT_EQ(fbd::find_port(number, Direction::kInput, "", 0)->name, "EN") << "a number of that name is an input";
}

TEST_F(Ports, PositionsPassOverEnAndEno) {
  const plcopen::Element e = block("X", "IN1=1 EN=2 IN2=3", "OUT1 eno OUT2");
  EXPECT_EQ(fbd::input_position(e, e.inputs[0]), 0u);
  EXPECT_EQ(fbd::input_position(e, e.inputs[2]), 1u);
  EXPECT_EQ(fbd::output_position(e, 0), 0u);
  EXPECT_EQ(fbd::output_position(e, 2), 1u);
}

TEST_F(Ports, HaveTypesWhereTheyAreDeclared) {
  const plcopen::Element e = block("Own own", "strange=1 y=2 EN=3", "q");
  EXPECT_EQ(fbd::type_of_pin(b, e, e.inputs[0]), ir::ref_of(core::TypeId::kInt));
  EXPECT_EQ(fbd::type_of_pin(b, e, e.inputs[2]), ir::kBoolType);
  const plcopen::Element add = block("ADD", "IN1=1");
  EXPECT_FALSE(fbd::type_of_pin(b, add, add.inputs[0]).has_value());
  EXPECT_TRUE(fbd::instance_output(b, e, 0).has_value());
  EXPECT_FALSE(fbd::instance_output(b, block("TON missing", "", "Q"), 0).has_value());
  EXPECT_FALSE(fbd::instance_output(b, block("Own own", "", "q r s"), 2).has_value()) << "beyond the last";
}

TEST_F(Ports, NamespacesAreDroppedBeforeTypesOnly) {
  EXPECT_EQ(fbd::type_name(b, "Standard.TON"), "TON");
  EXPECT_EQ(fbd::type_name(b, "A.B.ADD"), "ADD");
  EXPECT_EQ(fbd::type_name(b, "TON"), "TON");
  EXPECT_EQ(fbd::type_name(b, "Lib.Unknown"), "Lib.Unknown");
  EXPECT_EQ(fbd::type_name(b, "own.F"), "own.F") << "what belongs to a variable is an action";
}

TEST_F(Ports, AliasesAreNames) {
  fbd::Port port{"R", "RESET", Direction::kInput, 0, {}};
  EXPECT_TRUE(fbd::is_named(port, "r"));
  EXPECT_TRUE(fbd::is_named(port, "Reset"));
  EXPECT_FALSE(fbd::is_named(port, ""));
  port.alias = {};
  EXPECT_FALSE(fbd::is_named(port, ""));
}

}  // namespace
}  // namespace plc
