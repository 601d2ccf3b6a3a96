// The kit that components are written with: what testing.h and taskblock.h promise, without a PLC.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "picard/testing.h"
#include "tests/support/count_allocations.h"

namespace plc::test {

enum class Colour : std::uint16_t { Red = 7, Green = 8, Blue = 300 };
struct Dot {
  float x = 0;
  Colour colour{};
  picard::Text<4> name;
};

}  // namespace plc::test

PICARD_ENUM(plc::test::Colour, "COLOUR", Red, Green, Blue)
PICARD_STRUCT(plc::test::Dot, "DOT", x, colour, name)

namespace plc::test {
namespace {

using std::chrono::milliseconds;

class Painter final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "PAINTER", .group = "Test", .summary = "Paints."};
  picard::Input<Colour> colour{this, "COLOUR_IN", "", {.initial = "Blue"}};
  picard::Input<picard::Time> time{this, "TIME_IN", "", {.initial = "T#1m2s_500ms"}};
  picard::Config<std::array<Dot, 3>> dots{
      this, "DOTS", "", {.initial = "[2((x := 1.5, colour := COLOUR#Green)), (name := '$41$'b')]"}};
  picard::Input<picard::Text<10>> text{this, "TEXT", "", {.initial = "'a$$b$N'"}};
  picard::Output<picard::Text<4>> out{this, "OUT", ""};
  picard::QueueReader<std::int16_t> orders{this, "ORDERS", ""};
  void fire() override {
    switch (colour.get()) {
      case Colour::Red:
        out = "a literal";
        break;
      case Colour::Green:
        out = text->view();
        break;
      case Colour::Blue:
        out = out->view().substr(1);
        break;
      default:
        throw picard::Failure::format("colour %d", static_cast<int>(colour.get()));
    }
  }
};

class Teller final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "TELLER", .group = "Test", .summary = "Tells the operator."};
  picard::Input<std::int16_t> sensor{this, "SENSOR", "", {.initial = "3"}};
  void ready() override { tell(picard::Severity::Note, "ready with %d", 7); }
  void fire() override {
    tell(picard::Severity::Warning, "sensor %d is at %g, not %d", sensor.get(), 1.5, 2);
    tell(picard::Severity::Error, "%500d", 1);
  }
};

class Everything final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "EVERYTHING", .group = "Test", .summary = "Has a port of each type."};
  picard::Input<bool> flag{this, "FLAG", ""};
  picard::Input<std::int8_t> small{this, "SMALL", ""};
  picard::Input<std::uint64_t> large{this, "LARGE", ""};
  picard::Input<picard::Word> word{this, "WORD_IN", ""};
  picard::Input<float> real{this, "REAL_IN", ""};
  picard::Input<double> lreal{this, "LREAL_IN", ""};
  picard::Input<picard::Ltime> ltime{this, "LTIME_IN", ""};
  picard::Input<picard::Date> date{this, "DATE_IN", ""};
  picard::Input<picard::TimeOfDay> tod{this, "TOD_IN", ""};
  picard::Input<picard::DateAndTime> dt{this, "DT_IN", ""};
  picard::Input<char> letter{this, "CHAR_IN", ""};
  picard::Input<char16_t> wide_letter{this, "WCHAR_IN", ""};
  picard::Input<picard::Text<4, char16_t>> wide{this, "WIDE", ""};
  picard::Input<std::array<std::int16_t, 3>> row{this, "ROW", ""};
  void fire() override {}
};

class Ranged final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "RANGED", .group = "Test", .summary = "Has ranges."};
  picard::Config<std::int16_t> size{this, "SIZE", "", {.lowest = 1, .highest = 8, .initial = "1"}};
  picard::Config<double> weight{this, "WEIGHT", "", {.lowest = 0}};
  picard::Config<float> any{this, "ANY", ""};
  void fire() override {}
};

class Misspelt final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "MISSPELT", .group = "Test", .summary = "Has no such value."};
  picard::Input<Colour> colour{this, "COLOUR_IN", "", {.initial = "Purple"}};
  void fire() override {}
};

PICARD_LINKED_LIBRARY(sdk_library, "sdk", "1.0.0", Painter, Everything, Ranged, Misspelt, Teller)

TEST(Instance, HasTheInitialValuesOfTheDeclaration) {
  picard::Instance painter(sdk_library(), "PAINTER", milliseconds(1));
  EXPECT_EQ(painter.port<Colour>("COLOUR_IN"), Colour::Blue);
  EXPECT_EQ(painter.port<picard::Time>("TIME_IN"), milliseconds(62'500));
  EXPECT_EQ(painter.port<picard::Text<10>>("TEXT").view(), "a$b\n");
  const auto& dots = painter.port<std::array<Dot, 3>>("DOTS");
  EXPECT_EQ(dots[1].x, 1.5f);
  EXPECT_EQ(dots[1].colour, Colour::Green);
  EXPECT_EQ(dots[2].colour, Colour::Red) << "the first value, which is not 0";
  EXPECT_EQ(dots[2].name.view(), "A'b");
  EXPECT_THROW(picard::Instance(sdk_library(), "MISSPELT", milliseconds(1)), std::invalid_argument);
}

TEST(Instance, TakesValuesAsProjectsSpellThem) {
  picard::Instance all(sdk_library(), "EVERYTHING", milliseconds(1));
  const auto as = [&all]<class T>(const char* port, const char* value, T expected) {
    all.set(port, value);
    EXPECT_EQ(all.port<T>(port), expected) << value;
  };
  as("FLAG", "TRUE", true);
  as("FLAG", "BOOL#0", false);
  as("SMALL", "-128", std::int8_t{-128});
  as("SMALL", "SINT#16#7f", std::int8_t{127});
  as("LARGE", "18_446_744_073_709_551_615", ~std::uint64_t{0});
  as("WORD_IN", "2#1010_1010", picard::Word(0xaa));
  as("REAL_IN", "-2.5E-1", -0.25f);
  as("LREAL_IN", "LREAL#1_000.5", 1000.5);
  as("LTIME_IN", "LTIME#-1h30m", picard::Ltime(-5'400'000'000'000));
  as("DATE_IN", "D#1970-01-03", picard::Date(2 * 86'400'000'000'000));
  as("TOD_IN", "TOD#01:02:03.5", picard::TimeOfDay(3'723'500'000'000));
  as("DT_IN", "DT#1970-01-02-00:00:01", picard::DateAndTime(86'401'000'000'000));
  as("CHAR_IN", "'$27'", '\'');
  as("WCHAR_IN", "\"$20AC\"", u'\u20ac');
  as("ROW", "[ 1, 2(-3) ]", std::array<std::int16_t, 3>{1, -3, -3});
  as("ROW", "[5]", std::array<std::int16_t, 3>{5, -3, -3});
  all.set("WIDE", "\"ab$20ACdef\"");
  EXPECT_EQ((all.port<picard::Text<4, char16_t>>("WIDE").view()), u"ab\u20acd") << "cut";
}

TEST(Instance, RefusesWhatIsNoValueOfThePort) {
  picard::Instance all(sdk_library(), "EVERYTHING", milliseconds(1));
  for (const char* const value : {"", "x", "1.5", "1 2", "16#", "3#1"})
    EXPECT_THROW(all.set("LARGE", value), std::invalid_argument) << value;
  for (const char* const value : {"2", "maybe"}) EXPECT_THROW(all.set("FLAG", value), std::invalid_argument) << value;
  for (const char* const value : {"[1, 2, 3, 4]", "[4(1)]", "[1", "1", "[]", "[2(1]", "[0(1)]"})
    EXPECT_THROW(all.set("ROW", value), std::invalid_argument) << value;
  for (const char* const value : {"T#1", "T#s", "T#1x"})
    EXPECT_THROW(all.set("LTIME_IN", value), std::invalid_argument) << value;
  for (const char* const value : {"D#1970-01", "TOD#12"})
    EXPECT_THROW(all.set("DATE_IN", value), std::invalid_argument) << value;
  for (const char* const value : {"'ab", "ab", "'$'"})
    EXPECT_THROW(all.set("CHAR_IN", value), std::invalid_argument) << value;
  picard::Instance painter(sdk_library(), "PAINTER", milliseconds(1));
  for (const char* const value : {"Purple", "SHADE#Red", "7"})
    EXPECT_THROW(painter.set("COLOUR_IN", value), std::invalid_argument) << value;
  for (const char* const value : {"[(y := 1.0)]", "[(x 1.0)]", "[x := 1.0]"})
    EXPECT_THROW(painter.set("DOTS", value), std::invalid_argument) << value;
  EXPECT_THROW(painter.set("ORDERS", "1"), std::invalid_argument);
  EXPECT_THROW(painter.set("NONE", "1"), std::invalid_argument);
}

TEST(Config, OutsideOfItsRangeIsRefused) {
  const auto complaint = [](const char* port, const char* value) -> std::string {
    picard::Instance ranged(sdk_library(), "RANGED", milliseconds(1));
    if (value == std::string("NaN")) {
      ranged.port<double>("WEIGHT") = std::nan("");
      ranged.port<float>("ANY") = std::nanf("");
    } else {
      ranged.set(port, value);
    }
    try {
      ranged.ready();
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(complaint("SIZE", "1"), "");
  EXPECT_EQ(complaint("SIZE", "8"), "");
  EXPECT_EQ(complaint("SIZE", "0"), "SIZE is 0, its range is 1 .. 8");
  EXPECT_EQ(complaint("SIZE", "9"), "SIZE is 9, its range is 1 .. 8");
  EXPECT_EQ(complaint("WEIGHT", "1E300"), "");
  EXPECT_EQ(complaint("WEIGHT", "-0.5"), "WEIGHT is -0.5, its range is 0 .. inf");
  EXPECT_EQ(complaint("WEIGHT", "NaN"), "WEIGHT is nan, its range is 0 .. inf");
}

TEST(Output, OfTextTakesAnyTextAndCutsIt) {
  picard::Instance painter(sdk_library(), "PAINTER", milliseconds(1));
  const auto out = [&](const char* colour) {
    painter.set("COLOUR_IN", colour);
    painter.fire();
    return std::string(painter.port<picard::Text<4>>("OUT").view());
  };
  EXPECT_EQ(out("Red"), "a li");
  EXPECT_EQ(out("Blue"), " li") << "a part of itself";
  painter.set("TEXT", "'xy'");
  EXPECT_EQ(out("Green"), "xy");
  EXPECT_EQ(allocations_of([&] { painter.fire(); }), 0u);
}

TEST(Tell, ReachesWhoTestsItAndTakesNoMemory) {
  picard::Instance teller(sdk_library(), "TELLER", milliseconds(1));
  teller.ready();
  EXPECT_EQ(allocations_of([&] { teller.fire(); }), 0u);
  const auto told = teller.told();
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].severity, picard::Severity::Note);
  EXPECT_EQ(told[0].text, "ready with 7");
  EXPECT_EQ(told[1].severity, picard::Severity::Warning);
  EXPECT_EQ(told[1].text, "sensor 3 is at 1.5, not 2");
  EXPECT_EQ(told[2].severity, picard::Severity::Error);
  EXPECT_EQ(told[2].text, std::string(PICARD_TEXT_BYTES - 1, ' '));
}

TEST(Failure, HoldsItsText) {
  const picard::Failure literal("100 % of it");
  EXPECT_STREQ(literal.what(), "100 % of it");
  std::string made = "made ";
  made += "here";
  const picard::Failure kept(made);
  made.assign(made.size(), '-');
  EXPECT_STREQ(kept.what(), "made here");
  EXPECT_EQ(std::strlen(picard::Failure(std::string(500, 'x')).what()), PICARD_TEXT_BYTES - 1u);
  EXPECT_EQ(std::strlen(picard::Failure::format("%500d", 1).what()), PICARD_TEXT_BYTES - 1u);
  picard::Instance painter(sdk_library(), "PAINTER", milliseconds(1));
  painter.port<Colour>("COLOUR_IN") = static_cast<Colour>(9);
  try {
    painter.fire();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "colour 9");
  }
  EXPECT_EQ(allocations_of([] { static_cast<void>(picard::Failure::format("%s %g", "at", 1e300)); }), 0u);
}

}  // namespace
}  // namespace plc::test
