// STRING and WSTRING in registers.
#include <gtest/gtest.h>

#include "tests/unit/modbus/map_support.h"
#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

using Words = std::vector<std::uint16_t>;

/// Recipe (7 characters, the outside's), Title (a task's), Wide, Fixed, and numbers before and behind.
Image texts() {
  ImageBuilder b;
  const auto outside = [](std::string address = {}) {
    return ImageBuilder::GlobalOptions{false, true, {}, std::move(address)};
  };
  b.global("Recipe", b.string(7), {}, outside());
  b.global("Number", b.type(TypeId::kDint), {}, outside());
  b.global("Wide", b.string(3, TypeId::kWstring), {}, outside());
  b.global("Names", b.array(b.string(4), 3), {}, outside());
  const Word title = b.global("Title", b.string(6));
  const Word hello = b.text("hi!");
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.op(Opcode::kMoveStr, {title, hello});
  b.task("Fast", 1'000'000, {main.finish()});
  return b.build();
}

struct TextPdu : PlantPdu {
  TextPdu() : PlantPdu({}, texts()) {}
  std::uint32_t at(const std::string& path) const { return plant.address(path); }
  Words words(const std::string& path, std::uint32_t count) { return holding(at(path), count); }
  int write(std::uint32_t address, Words values) { return exception(write_registers(address, values)); }
  [[nodiscard]] std::string value(const std::string& path) const {
    const runtime::Access access(*plant.resource);
    return access.read(*access.find(path));
  }
};

TEST(ModbusText, ComesAfterNumbersAndInOnePiece) {
  const TextPdu pdu;
  EXPECT_EQ(pdu.at("Number"), 16384u);
  EXPECT_GE(pdu.at("Recipe"), 16386u);
  EXPECT_EQ(pdu.at("Names[1]"), pdu.at("Names[0]") + 2);
  EXPECT_EQ(pdu.at("Names[2]"), pdu.at("Names[0]") + 4);
  for (const modbus::Point& point : pdu.plant.map.points()) {
    if (point.path == "Recipe") {
      EXPECT_EQ(point.registers, 4);
    } else if (point.path == "Wide") {
      EXPECT_EQ(point.registers, 3);
    }
  }
}

TEST(ModbusText, IsReadTwoCharactersARegister) {
  TextPdu pdu;
  pdu.plant.scan();
  EXPECT_EQ(pdu.words("Title", 3), (Words{'h' << 8 | 'i', '!' << 8, 0}));
  EXPECT_EQ(pdu.holding(pdu.at("Title") + 1, 1), Words{'!' << 8}) << "any part of it";
}

TEST(ModbusText, IsWrittenFromItsBeginning) {
  TextPdu pdu;
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {'a' << 8 | 'b', 'c' << 8 | 'd', 'e' << 8, 0}), 0);
  EXPECT_EQ(pdu.value("Recipe"), "'abcde'");
  EXPECT_EQ(pdu.words("Recipe", 4), (Words{'a' << 8 | 'b', 'c' << 8 | 'd', 'e' << 8, 0}));
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {'x' << 8 | 'y'}), 0) << "its first registers alone: that is all of the text";
  EXPECT_EQ(pdu.value("Recipe"), "'xy'");
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {'a' << 8 | 'b', 'c' << 8 | 'd', 'e' << 8 | 'f', 'g' << 8}), 0);
  EXPECT_EQ(pdu.value("Recipe"), "'abcdefg'");
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {'a' << 8, 'z' << 8 | 'z'}), 0);
  EXPECT_EQ(pdu.value("Recipe"), "'a'") << "it ends at the first 0";
}

TEST(ModbusText, RefusesWhatIsNoText) {
  TextPdu pdu;
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {'o' << 8 | 'k'}), 0);
  EXPECT_EQ(pdu.write(pdu.at("Recipe"), {0x6161, 0x6161, 0x6161, 0x6161}), 3) << "eight characters of seven";
  EXPECT_EQ(pdu.write(pdu.at("Recipe") + 1, {'x' << 8}), 2) << "not from its beginning";
  EXPECT_EQ(pdu.exception(pdu_of(22, {pdu.at("Recipe"), 0xff00, 0x41})), 2) << "half a register";
  EXPECT_EQ(pdu.value("Recipe"), "'ok'") << "all or nothing";
}

TEST(ModbusText, SeveralOfThemAndNumbersInOneRequest) {
  TextPdu pdu;
  EXPECT_EQ(pdu.write(pdu.at("Names[0]"), {'a' << 8, 0, 'b' << 8 | 'c', 'd' << 8 | 'e', 'f' << 8, 0}), 0);
  EXPECT_EQ(pdu.value("Names[0]") + pdu.value("Names[1]") + pdu.value("Names[2]"), "'a''bcde''f'");
  EXPECT_EQ(pdu.write(pdu.at("Wide"), {0x20ac, 'u'}), 0);
  EXPECT_EQ(pdu.words("Wide", 3), (Words{0x20ac, 'u', 0}));
}

TEST(ModbusText, OfATaskWaitsForItsScan) {
  TextPdu pdu;
  EXPECT_EQ(pdu.write(pdu.at("Title"), {'n' << 8 | 'o'}), 0);
  EXPECT_EQ(pdu.value("Title"), "''");
  pdu.plant.scan();
  EXPECT_EQ(pdu.value("Title"), "'hi!'") << "the program writes it in each scan";
}

TEST(ModbusText, AtAnAddressIsWrittenAndSharesNoBits) {
  for (const auto profile : {core::AddressProfile::kSeparate, core::AddressProfile::kOverlay}) {
    ImageBuilder b;
    const auto at = [](std::string address) {
      return ImageBuilder::GlobalOptions{false, true, {}, std::move(address)};
    };
    b.global("Note", b.string(20), {}, at("%MW0"));
    b.global("Word", b.type(TypeId::kWord), {}, at("%MW0"));
    b.global("Byte", b.type(TypeId::kByte), {}, at("%MB1"));
    b.task("Fast", 1'000'000, {b.pou("Main", PouKind::kProgram).finish()});
    Image image = b.build();
    image.options.profile = profile;
    PlantPdu pdu({}, std::move(image));
    const std::uint32_t note = pdu.plant.address("Note");
    EXPECT_GE(note, 16384u);
    const std::vector<std::uint16_t> ten(10, 'a' << 8 | 'b');
    EXPECT_EQ(pdu.exception(write_registers(note, ten)), 0);
    EXPECT_EQ(pdu.exception(write_registers(pdu.plant.address("Word"), {0x1234})), 0);
    EXPECT_EQ(pdu.holding(note, 10), ten);
    EXPECT_EQ(pdu.plant.value<std::uint16_t>("Word"), 0x1234);
    // The overlapping values, as a driver or a fault writes them.
    const runtime::Access access(*pdu.plant.resource);
    const runtime::Place place = *access.find("Note");
    std::vector<std::byte> value(pdu.plant.resource->image().types[place.type].size, std::byte{'x'});
    const runtime::GlobalWrite write{place.offset, place.type, value.data(), nullptr};
    EXPECT_EQ(pdu.plant.resource->globals().write(std::span(&write, 1)), runtime::WriteResult::kDone);
    EXPECT_EQ(pdu.plant.value<std::uint16_t>("Word"), 0x1234);
    EXPECT_EQ(access.read(place), "'xxxxxxxxxxxxxxxxxxxx'");
  }
}

TEST(ModbusText, KeepsItsFrozenAddress) {
  MapFixture f;
  f.b.global("Recipe", f.b.string(7), {}, {.input = true});
  f.b.global("Speed", f.b.type(TypeId::kInt), {}, {.input = true});
  f.build();
  ASSERT_TRUE(f.map) << f.said();
  const std::string text = modbus::frozen_text(f.frozen);
  EXPECT_NE(text.find("Recipe,holding-registers,16385,STRING[7]\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace plc::test
