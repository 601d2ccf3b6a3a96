#include "io-drivers/modbus/address_map.h"

#include "runtime/memory/global_ports.h"
#include "tests/unit/modbus/map_support.h"

namespace plc::test {
namespace {

constexpr Table kCoils = Table::kCoils;
constexpr Table kDiscrete = Table::kDiscreteInputs;
constexpr Table kInput = Table::kInputRegisters;
constexpr Table kHolding = Table::kHoldingRegisters;

TEST(AddressMap, LocatedVariablesAreWhereOpenPlcHasThem) {
  struct Row {
    const char* address;
    TypeId type;
    const char* place;
    std::uint16_t registers;
  };
  const Row rows[] = {
      {"%QX0.0", TypeId::kBool, "coils 0", 0},
      {"%QX2.5", TypeId::kBool, "coils 21", 0},
      {"%QX1023.7", TypeId::kBool, "coils 8191", 0},
      {"%MX0.0", TypeId::kBool, "coils 8192", 0},
      {"%MX3.1", TypeId::kBool, "coils 8217", 0},
      {"%IX1.3", TypeId::kBool, "discrete-inputs 11", 0},
      {"%IX9", TypeId::kBool, "discrete-inputs 9", 0},
      {"%IW0", TypeId::kInt, "input-registers 0", 1},
      {"%IW1023", TypeId::kUint, "input-registers 1023", 1},
      {"%ID3", TypeId::kReal, "input-registers 2054", 2},
      {"%IL2", TypeId::kLreal, "input-registers 4104", 4},
      {"%QW7", TypeId::kWord, "holding-registers 7", 1},
      {"%MW0", TypeId::kInt, "holding-registers 1024", 1},
      {"%MW1023", TypeId::kInt, "holding-registers 2047", 1},
      {"%MD0", TypeId::kReal, "holding-registers 2048", 2},
      {"%MD1023", TypeId::kDint, "holding-registers 4094", 2},
      {"%ML0", TypeId::kLint, "holding-registers 4096", 4},
      {"%ML1023", TypeId::kTime, "holding-registers 8188", 4},
  };
  MapFixture f;
  for (const Row& row : rows) f.variable(std::string("v") + (row.address + 1), row.type, row.address);
  for (auto& field : f.b.image.globals) ASSERT_FALSE(field.address.empty());
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  for (const Point& p : f.map->points()) {
    const Row* const row =
        std::find_if(std::begin(rows), std::end(rows), [&](const Row& r) { return p.iec_address == r.address; });
    ASSERT_NE(row, std::end(rows)) << p.iec_address;
    EXPECT_EQ(std::string(io::modbus_table_text(p.table)) + " " + std::to_string(p.address), row->place)
        << row->address;
    EXPECT_EQ(p.registers, row->registers) << row->address;
    EXPECT_EQ(p.writable, row->address[1] != 'I') << row->address;
    EXPECT_FALSE(p.automatic);
  }
  EXPECT_EQ(f.map->points().size(), std::size(rows));
  EXPECT_TRUE(f.frozen.entries.empty());
}

TEST(AddressMap, AddressesWithoutAPlaceThereAreAutomatic) {
  MapFixture f;
  f.variable("qb", TypeId::kByte, "%QB0");
  f.variable("qd", TypeId::kReal, "%QD0");
  f.variable("ql", TypeId::kLreal, "%QL0");
  f.variable("ib", TypeId::kByte, "%IB0");
  f.variable("far", TypeId::kWord, "%MW1024");
  f.variable("deep", TypeId::kWord, "%MW0.0.1");
  f.variable("anywhere", TypeId::kBool, "%I*");
  f.variable("past", TypeId::kBool, "%QX1024.0");
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_EQ(f.place("qb"), "holding-registers 16384*");
  EXPECT_EQ(f.place("qd"), "holding-registers 16386*");
  EXPECT_EQ(f.place("ql"), "holding-registers 16388*");
  EXPECT_EQ(f.place("ib"), "input-registers 16384*");
  EXPECT_EQ(f.place("far"), "holding-registers 16385*");
  EXPECT_EQ(f.place("deep"), "holding-registers 16392*");
  EXPECT_EQ(f.place("anywhere"), "discrete-inputs 16384*");
  EXPECT_EQ(f.place("past"), "coils 16384*");
  EXPECT_EQ(f.point("qb")->iec_address, "%QB0");
  EXPECT_FALSE(f.point("ib")->writable);
}

TEST(AddressMap, ElementsOfLocatedArraysFollowEachOther) {
  MapFixture f;
  f.array("words", TypeId::kWord, 10, "%MW5");
  f.array("reals", TypeId::kReal, 3, "%MD10");
  f.array("bits", TypeId::kBool, 10, "%QX0.6");
  f.b.global("matrix", f.b.array(f.b.array(f.b.type(TypeId::kInt), 3, 1), 2), {}, {.address = "%QW20"});
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_EQ(f.place("words[0]"), "holding-registers 1029");
  EXPECT_EQ(f.place("words[9]"), "holding-registers 1038");
  EXPECT_EQ(f.point("words[9]")->iec_address, "%MW14");
  EXPECT_EQ(f.place("reals[2]"), "holding-registers 2072");
  EXPECT_EQ(f.point("reals[2]")->iec_address, "%MD12");
  EXPECT_EQ(f.place("bits[9]"), "coils 15");
  EXPECT_EQ(f.point("bits[2]")->iec_address, "%QX1.0");
  EXPECT_EQ(f.place("matrix[1][1]"), "holding-registers 23");
}

TEST(AddressMap, AnArrayThatWouldRunIntoTheNextAreaIsAutomatic) {
  MapFixture f;
  f.array("fits", TypeId::kWord, 4, "%MW1020");
  f.array("runs_out", TypeId::kWord, 5, "%MW1019");
  f.build();
  EXPECT_EQ(f.place("fits[3]"), "holding-registers 2047");
  EXPECT_EQ(f.place("runs_out[0]"), "holding-registers 16384*");
  EXPECT_EQ(f.place("runs_out[4]"), "holding-registers 16388*");
  EXPECT_EQ(f.point("runs_out[4]")->iec_address, "%MW1023");
}

TEST(AddressMap, AWidthThatDisagreesStaysAtItsAddress) {
  MapFixture f;
  f.variable("wide", TypeId::kReal, "%MW10");
  f.variable("narrow", TypeId::kInt, "%MD10");
  f.variable("bit_in_word", TypeId::kBool, "%MW20");
  f.build();
  EXPECT_EQ(f.place("wide"), "holding-registers 1034");
  EXPECT_EQ(f.point("wide")->registers, 2);
  EXPECT_EQ(f.place("narrow"), "holding-registers 2068");
  EXPECT_EQ(f.cells(kHolding, 2069), "");
  EXPECT_EQ(f.place("bit_in_word"), "coils 16384*") << "a register is no place for a BOOL";
}

TEST(AddressMap, TheSecondAtOneAddressIsAutomatic) {
  MapFixture f;
  f.variable("a", TypeId::kInt, "%IW0");
  f.variable("b", TypeId::kWord, "%IW0");
  f.build();
  EXPECT_EQ(f.place("a"), "input-registers 0");
  EXPECT_EQ(f.place("b"), "input-registers 16384*");
}

TEST(AddressMap, AutomaticAddressesByDeclarationAlignedToTheirSize) {
  MapFixture f;
  f.variable("Word1", TypeId::kWord);
  f.variable("Real1", TypeId::kReal);
  f.variable("Byte1", TypeId::kUsint);
  f.variable("Long1", TypeId::kLreal);
  f.variable("Flag1", TypeId::kBool);
  f.variable("Flag2", TypeId::kBool);
  f.variable("Span", TypeId::kTime);
  f.b.global("Text", f.b.string(10));
  f.b.global("Limit", f.b.type(TypeId::kInt), {}, {.constant = true});
  f.b.global("Always", f.b.boolean(), {}, {.constant = true});
  f.b.global("Listed", f.b.type(TypeId::kInt), {}, {.list = "GVL"});
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_EQ(f.place("Word1"), "holding-registers 16384*");
  EXPECT_EQ(f.place("Real1"), "holding-registers 16386*");
  EXPECT_EQ(f.place("Byte1"), "holding-registers 16385*") << "fills the gap";
  EXPECT_EQ(f.place("Long1"), "holding-registers 16388*");
  EXPECT_EQ(f.place("Span"), "holding-registers 16392*");
  EXPECT_EQ(f.place("GVL.Listed"), "holding-registers 16396*");
  EXPECT_EQ(f.place("Flag1"), "coils 16384*");
  EXPECT_EQ(f.place("Flag2"), "coils 16385*");
  EXPECT_EQ(f.place("Text"), "holding-registers 16397*") << "texts come last";
  EXPECT_EQ(f.place("Limit"), "input-registers 16384*");
  EXPECT_EQ(f.place("Always"), "discrete-inputs 16384*");
  EXPECT_FALSE(f.point("Limit")->writable);
  EXPECT_TRUE(f.point("Span")->writable);
  EXPECT_EQ(f.point("Span")->registers, 4);
  EXPECT_TRUE(f.frozen.changed);
  EXPECT_EQ(f.frozen.entries.size(), 11u);
}

TEST(AddressMap, ArraysLieInSequenceAndMembersOfStructuresAreThere) {
  MapFixture f;
  const std::uint32_t recipe = f.b.structure("Recipe", {{"Time", f.b.type(TypeId::kDint)}, {"On", f.b.boolean()}});
  f.variable("First", TypeId::kInt);
  f.array("Curve", TypeId::kReal, 4);
  f.variable("Gap", TypeId::kInt);
  f.array("Pair", TypeId::kInt, 2);
  f.b.global("Recipes", f.b.array(recipe, 2, 1));
  f.build();
  EXPECT_EQ(f.place("Curve[0]"), "holding-registers 16386*");
  EXPECT_EQ(f.place("Curve[3]"), "holding-registers 16392*");
  EXPECT_EQ(f.place("Gap"), "holding-registers 16385*");
  EXPECT_EQ(f.place("Pair[0]"), "holding-registers 16394*");
  EXPECT_EQ(f.place("Pair[1]"), "holding-registers 16395*");
  EXPECT_EQ(f.place("Recipes[1].Time"), "holding-registers 16396*");
  EXPECT_EQ(f.place("Recipes[2].Time"), "holding-registers 16398*");
  EXPECT_EQ(f.place("Recipes[2].On"), "coils 16385*");
}

TEST(AddressMap, OnlyExportedVariablesGetAutomaticAddresses) {
  MapFixture f;
  f.variable("Recipe", TypeId::kInt);
  f.variable("Secret", TypeId::kInt);
  f.variable("Located", TypeId::kInt, "%MW0");
  f.config.exported = {{"rec*", {}}};
  f.build();
  EXPECT_EQ(f.place("Recipe"), "holding-registers 16384*");
  EXPECT_EQ(f.place("Secret"), "none");
  EXPECT_EQ(f.place("Located"), "holding-registers 1024");
}

TEST(AddressMap, PatternsThatMatchNothingAreNamed) {
  MapFixture f;
  f.variable("Recipe", TypeId::kInt);
  f.config.exported = {{"Recipe", {}}, {"Recipie*", {3, 11}}};
  f.config.writable = {{"Nothing", {4, 12}}};
  f.build();
  EXPECT_TRUE(f.map);
  EXPECT_NE(f.said().find("plc.toml:3:11: warning P7503: pattern \"Recipie*\""), std::string::npos) << f.said();
  EXPECT_NE(f.said().find("plc.toml:4:12: warning P7503: pattern \"Nothing\""), std::string::npos) << f.said();
  EXPECT_EQ(f.diagnostics.all().size(), 2u);
}

TEST(AddressMap, APatternThatMissesTheElementsSaysWhatWouldMatch) {
  for (const char* pattern : {"Recipe", "Recipe.*"}) {
    MapFixture f;
    f.array("Recipe", TypeId::kInt, 3);
    f.config.writable = {{pattern, {3, 11}}};
    f.build();
    EXPECT_NE(f.said().find("\"Recipe*\" would match"), std::string::npos) << pattern << ": " << f.said();
    EXPECT_NE(f.said().find("'?' for one"), std::string::npos) << f.said();
  }
  for (const char* pattern : {"Recipe[*]", "Recipe*", "recipe[?]"}) {
    MapFixture f;
    f.array("Recipe", TypeId::kInt, 3);
    f.config.writable = {{pattern, {3, 11}}};
    f.build();
    EXPECT_EQ(f.said(), "") << pattern;
    EXPECT_TRUE(f.point("Recipe[1]")->writable) << pattern;
  }
}

TEST(AddressMap, ARangeThatSplitsAValueIsAnError) {
  const auto said = [](std::uint16_t first, std::uint16_t last, bool rights) {
    MapFixture f;
    f.variable("Before", TypeId::kInt, "%MW1023");
    f.variable("Level", TypeId::kReal, "%MD0");
    f.variable("Next", TypeId::kReal, "%MD1");
    f.variable("Total", TypeId::kLint);
    io::ModbusRange range;
    range.at = {7, 1};
    range.first = first;
    range.last = last;
    if (rights) {
      range.writable = false;
    } else {
      range.word_order = WordOrder::kCdab;
    }
    f.config.ranges = {range};
    f.build();
    EXPECT_EQ(f.map.has_value(), f.said().find("error") == std::string::npos);
    return f.said();
  };
  for (const bool rights : {true, false}) {
    EXPECT_EQ(said(2048, 2049, rights), "");
    EXPECT_EQ(said(2047, 2051, rights), "");
    EXPECT_EQ(said(2052, 4095, rights).find("P7505"), std::string::npos) << "a gap";
    const std::string text = said(2049, 2049, rights);
    EXPECT_NE(text.find("plc.toml:7:1: error P7505: range splits \"Level\" (2048..2049)"), std::string::npos) << text;
    EXPECT_NE(text.find("first = 2048, last = 2049"), std::string::npos) << text;
    EXPECT_NE(said(0, 2048, rights).find("splits \"Level\" (2048..2049)"), std::string::npos);
    EXPECT_NE(said(2049, 2050, rights).find("splits \"Level\" (2048..2049) and 1 more"), std::string::npos);
    EXPECT_NE(said(16385, 16386, rights).find("splits \"Total\" (16384..16387)"), std::string::npos);
  }
}

TEST(AddressMap, RangesWithoutEffectAreTold) {
  const auto said = [](io::ModbusRange range) {
    MapFixture f;
    f.variable("Set", TypeId::kInt, "%MW0");
    f.variable("Valve", TypeId::kBool, "%QX0.0");
    range.at.line = 7;
    f.config.ranges = {range};
    f.build();
    EXPECT_TRUE(f.map) << "a warning";
    return f.said();
  };
  io::ModbusRange range;
  range.first = 1024;
  range.last = 1030;
  EXPECT_NE(said(range).find("warning P7506: the range holding-registers 1024..1030 says nothing"), std::string::npos);
  range.writable = false;
  EXPECT_EQ(said(range), "");
  range.first = 41025;
  range.last = 41034;
  std::string text = said(range);
  EXPECT_NE(text.find("warning P7506: no variable is at holding-registers 41025..41034"), std::string::npos) << text;
  EXPECT_NE(text.find("first = 1024, last = 1033"), std::string::npos) << text;
  range.first = 500;
  range.last = 600;
  text = said(range);
  EXPECT_NE(text.find("P7506"), std::string::npos) << text;
  EXPECT_NE(text.find("plc map shows"), std::string::npos) << text;
  io::ModbusRange coils;
  coils.table = kCoils;
  coils.last = 3;
  coils.latch = true;
  EXPECT_EQ(said(coils), "");
  io::ModbusRange plant;
  plant.table = io::ModbusTable::kInputRegisters;
  plant.first = 8194;
  plant.last = 8199;
  plant.word_order = io::WordOrder::kCdab;
  EXPECT_EQ(said(plant), "") << "its own registers";
}

TEST(AddressMap, RightsByPatternThenByRange) {
  MapFixture f;
  f.variable("SetA", TypeId::kInt, "%MW0");
  f.variable("SetB", TypeId::kInt, "%MW1");
  f.variable("Valve", TypeId::kBool, "%QX0.0");
  f.variable("Sensor", TypeId::kInt, "%IW0");
  f.b.global("Fixed", f.b.type(TypeId::kInt), {}, {.constant = true, .address = "%MW2"});
  f.config.writable = {{"set*", {}}, {"%IW0", {}}, {"Fixed", {}}};
  io::ModbusRange none;
  none.first = 1025;
  none.last = 1030;
  none.writable = false;
  io::ModbusRange valves;
  valves.table = kCoils;
  valves.last = 7;
  valves.writable = true;
  f.config.ranges = {none, valves};
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_TRUE(f.point("SetA")->writable);
  EXPECT_FALSE(f.point("SetB")->writable) << "its range says no";
  EXPECT_TRUE(f.point("Valve")->writable) << "its range says yes";
  EXPECT_FALSE(f.point("Sensor")->writable) << "an input, whatever is configured";
  EXPECT_FALSE(f.point("Fixed")->writable) << "a constant, whatever is configured";
  f.config.ranges[0].writable = true;
  io::ModbusRange later = none;
  f.config.ranges.push_back(later);
  f.build();
  EXPECT_FALSE(f.point("SetB")->writable) << "later ranges count before earlier ones";
  f.config.read_only = true;
  f.build();
  for (const Point& p : f.map->points()) EXPECT_FALSE(p.writable) << p.path;
}

TEST(AddressMap, InputsThatADriverClaimedAreReadOnly) {
  MapFixture f;
  f.b.global("FromDevice", f.b.type(TypeId::kInt), {}, {.input = true});
  f.b.global("LineFromDevice", f.b.boolean(), {}, {.input = true});
  f.b.global("FromOutside", f.b.type(TypeId::kInt), {}, {.input = true});
  f.load();
  const std::uint32_t claimed[] = {0, 1};
  const runtime::GlobalInputs driver(f.resource->globals(), claimed);
  f.build();
  EXPECT_EQ(f.place("FromDevice"), "input-registers 16384*");
  EXPECT_EQ(f.place("LineFromDevice"), "discrete-inputs 16384*");
  EXPECT_EQ(f.place("FromOutside"), "holding-registers 16384*");
  EXPECT_FALSE(f.point("FromDevice")->writable);
  EXPECT_TRUE(f.point("FromOutside")->writable);
}

TEST(AddressMap, RightsDoNotMoveAddresses) {
  MapFixture f;
  f.variable("A", TypeId::kInt);
  f.config.read_only = true;
  f.build();
  EXPECT_EQ(f.place("A"), "holding-registers 16384*");
}

TEST(Cells, WordOrders) {
  const auto shown = [](WordOrder order) {
    MapFixture f;
    f.variable("R", TypeId::kReal, "%MD0");
    f.variable("L", TypeId::kLreal, "%ML0");
    f.variable("W", TypeId::kWord, "%MW0");
    f.config.word_order = order;
    f.build();
    EXPECT_EQ(f.cells(kHolding, 1024), "W:0+16@0") << "one register has no order";
    return f.cells(kHolding, 2048) + " | " + f.cells(kHolding, 2049) + " | " + f.cells(kHolding, 4096) + " | " +
           f.cells(kHolding, 4099);
  };
  EXPECT_EQ(shown(WordOrder::kAbcd), "R:16+16@0 | R:0+16@0 | L:48+16@0 | L:0+16@0");
  EXPECT_EQ(shown(WordOrder::kCdab), "R:0+16@0 | R:16+16@0 | L:0+16@0 | L:48+16@0");
  EXPECT_EQ(shown(WordOrder::kBadc), "R:24+8@0 R:16+8@8 | R:8+8@0 R:0+8@8 | L:56+8@0 L:48+8@8 | L:8+8@0 L:0+8@8");
  EXPECT_EQ(shown(WordOrder::kDcba), "R:8+8@0 R:0+8@8 | R:24+8@0 R:16+8@8 | L:8+8@0 L:0+8@8 | L:56+8@0 L:48+8@8");
}

TEST(Cells, WordOrderPerRange) {
  MapFixture f;
  f.variable("A", TypeId::kReal, "%MD0");
  f.variable("B", TypeId::kReal, "%MD1");
  io::ModbusRange range;
  range.first = 2050;
  range.last = 2051;
  range.word_order = WordOrder::kCdab;
  f.config.ranges = {range};
  f.build();
  EXPECT_EQ(f.cells(kHolding, 2048), "A:16+16@0");
  EXPECT_EQ(f.cells(kHolding, 2050), "B:0+16@0");
  EXPECT_EQ(f.point("B")->word_order, WordOrder::kCdab);
}

TEST(Cells, EveryAddressOfEveryTableCanBeAsked) {
  MapFixture f;
  f.variable("C", TypeId::kBool, "%QX0.1");
  f.variable("D", TypeId::kBool, "%IX0.0");
  f.variable("S", TypeId::kSint, "%MB0");
  f.build();
  EXPECT_EQ(f.cells(kCoils, 0), "");
  EXPECT_EQ(f.cells(kCoils, 1), "C:0+1@0");
  EXPECT_EQ(f.cells(kCoils, 2), "");
  EXPECT_EQ(f.cells(kDiscrete, 0), "D:0+1@0");
  EXPECT_EQ(f.cells(kHolding, 16384), "S:0+16@0") << "an 8-bit value has a register to itself";
  EXPECT_EQ(f.cells(kHolding, 65535), "");
  EXPECT_EQ(f.cells(kInput, 0), "");
}

TEST(Gaps, ReadAsZeroInsideTheMapOnly) {
  MapFixture f;
  f.variable("A", TypeId::kReal);
  f.variable("B", TypeId::kLreal);
  f.build();
  EXPECT_TRUE(f.map->contains(kCoils, 16383));
  EXPECT_FALSE(f.map->contains(kCoils, 16384)) << "no automatic coil";
  EXPECT_TRUE(f.map->contains(kDiscrete, 8191));
  EXPECT_FALSE(f.map->contains(kDiscrete, 8192));
  EXPECT_TRUE(f.map->contains(kInput, 1023));
  EXPECT_FALSE(f.map->contains(kInput, 1024));
  EXPECT_FALSE(f.map->contains(kInput, 2048)) << "no %ID";
  EXPECT_TRUE(f.map->contains(kHolding, 8191));
  EXPECT_FALSE(f.map->contains(kHolding, 8192));
  EXPECT_TRUE(f.map->contains(kHolding, 16386)) << "between A and B";
  EXPECT_TRUE(f.map->contains(kHolding, 16391));
  EXPECT_FALSE(f.map->contains(kHolding, 16392));
  EXPECT_FALSE(f.map->contains(kHolding, 65535));
}

TEST(Gaps, DoubleInputsOpenTheirArea) {
  MapFixture f;
  f.variable("A", TypeId::kReal, "%ID5");
  f.build();
  EXPECT_TRUE(f.map->contains(kInput, 2048));
  EXPECT_TRUE(f.map->contains(kInput, 4095));
  EXPECT_FALSE(f.map->contains(kInput, 4096));
}

TEST(Gaps, StrictlyOnlyVariables) {
  MapFixture f;
  f.variable("A", TypeId::kReal, "%MD1");
  f.config.strict_gaps = true;
  f.build();
  EXPECT_FALSE(f.map->contains(kHolding, 2049));
  EXPECT_TRUE(f.map->contains(kHolding, 2050));
  EXPECT_TRUE(f.map->contains(kHolding, 2051));
  EXPECT_FALSE(f.map->contains(kHolding, 2052));
}

TEST(Overlay, ARegisterShowsTheVariablesThatShareItsBits) {
  MapFixture f;
  f.b.image.options.profile = core::AddressProfile::kOverlay;
  f.variable("Word", TypeId::kWord, "%QW0");
  f.variable("Bit3", TypeId::kBool, "%QX0.3");
  f.variable("Byte3", TypeId::kByte, "%QB3");
  f.variable("Double", TypeId::kDword, "%QD2");
  f.variable("Bit33", TypeId::kBool, "%QX6.1");
  f.variable("Merker", TypeId::kReal, "%MD0");
  f.variable("MerkerBit", TypeId::kBool, "%MX8.0");
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_EQ(f.cells(kHolding, 0), "Word:0+16@0") << "its own address";
  EXPECT_EQ(f.cells(kHolding, 1), "Byte3:0+8@8");
  EXPECT_EQ(f.cells(kHolding, 3), "Bit33:0+1@1");
  EXPECT_EQ(f.cells(kHolding, 4), "Double:0+16@0") << "%QD2 is %QW4 and %QW5";
  EXPECT_EQ(f.cells(kHolding, 5), "Double:16+16@0");
  EXPECT_EQ(f.cells(kCoils, 3), "Bit3:0+1@0");
  EXPECT_EQ(f.cells(kCoils, 4), "Word:4+1@0");
  EXPECT_EQ(f.cells(kCoils, 24), "Byte3:0+1@0");
  EXPECT_EQ(f.cells(kCoils, 16), "");
  EXPECT_EQ(f.cells(kCoils, 64), "Double:0+1@0");
  EXPECT_EQ(f.cells(kHolding, 1024), "Merker:0+16@0") << "%MW0 is the low half of %MD0";
  EXPECT_EQ(f.cells(kHolding, 1025), "Merker:16+16@0");
  EXPECT_EQ(f.cells(kHolding, 2048), "Merker:16+16@0") << "%MD0 itself is ABCD";
  EXPECT_EQ(f.cells(kHolding, 2052), "");
  EXPECT_EQ(f.cells(kHolding, 2053), "MerkerBit:0+1@0") << "%MD2, low half";
  EXPECT_EQ(f.cells(kHolding, 4096), "");
  EXPECT_EQ(f.cells(kHolding, 4098), "Merker:16+16@0") << "%ML0, low double word";
  EXPECT_EQ(f.cells(kCoils, 8192 + 31), "Merker:31+1@0");
  EXPECT_EQ(f.place("Byte3"), "holding-registers 16384*") << "a byte has an address of its own as well";
}

TEST(Overlay, SixteenBitsMakeARegister) {
  MapFixture f;
  f.b.image.options.profile = core::AddressProfile::kOverlay;
  for (int i = 0; i < 16; ++i) {
    f.variable("x" + std::to_string(i), TypeId::kBool, "%IX" + std::to_string(i / 8) + "." + std::to_string(i % 8));
  }
  f.build();
  EXPECT_EQ(f.map->at(kInput, 0).size(), 16u);
  EXPECT_EQ(f.cells(kInput, 0).substr(0, 17), "x0:0+1@0 x1:0+1@1");
}

TEST(Separate, AddressesOfDifferentSizesShareNothing) {
  MapFixture f;
  f.variable("Word", TypeId::kWord, "%QW0");
  f.variable("Bit3", TypeId::kBool, "%QX0.3");
  f.build();
  EXPECT_EQ(f.cells(kCoils, 4), "");
  EXPECT_EQ(f.cells(kHolding, 0), "Word:0+16@0");
}

TEST(Full, WhatDoesNotFitIsLeftOutAndSaid) {
  MapFixture f;
  f.array("Big", TypeId::kReal, 20'000);
  f.array("Huge", TypeId::kReal, 10'000);
  f.variable("Small", TypeId::kInt);
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  EXPECT_EQ(f.place("Big[19999]"), "holding-registers 56382*");
  EXPECT_EQ(f.place("Huge[0]"), "none");
  EXPECT_EQ(f.place("Small"), "holding-registers 56384*");
  EXPECT_NE(f.said().find("warning P7504"), std::string::npos) << f.said();
  EXPECT_NE(f.said().find("10000 variables, the first is \"Huge[0]\""), std::string::npos) << f.said();
}

TEST(Full, TheLastAddressIsUsed) {
  MapFixture f;
  f.array("All", TypeId::kInt, 65536 - 16384);
  f.build();
  EXPECT_EQ(f.place("All[49151]"), "holding-registers 65535*");
  EXPECT_TRUE(f.map->contains(kHolding, 65535));
  EXPECT_EQ(f.cells(kHolding, 65535), "All[49151]:0+16@0");
}

}  // namespace
}  // namespace plc::test
