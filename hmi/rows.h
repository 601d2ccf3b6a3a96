// Rows of the HMI pages: kinds of elements and keys of their tables, each declared here and nowhere else.
//
// In: nothing. Out: what the reader and the writer of pages.toml take (document.h), the calls tell, the editor of the
// pages offers, and the reference lists. Does not belong here: how an element looks (web/src/hmi).
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>

namespace plc::hmi {

/// What an element does with its variable.
enum class Use : std::uint8_t {
  kNone,    ///< has none that it needs
  kShows,   ///< shows it
  kWrites,  ///< lets operators write it
};

struct KindRow {
  std::string_view name;  ///< "lamp"
  std::uint8_t width;     ///< cells of a new one
  std::uint8_t height;
  Use use;
  std::string_view doc;  ///< a sentence without a full stop
};

enum class Kind : std::uint8_t {
  kLamp,
  kSwitch,
  kButton,
  kSlider,
  kNumber,
  kGauge,
  kBar,
  kTank,
  kValve,
  kMotor,
  kPipe,
  kPlot,
  kAlarms,
  kText,
  kPicture,
  kLink,
};

/// By Kind.
inline constexpr KindRow kKinds[] = {
    {"lamp", 3, 2, Use::kShows, "A BOOL as a lamp"},
    {"switch", 3, 2, Use::kWrites, "A BOOL that is switched on and off"},
    {"button", 3, 2, Use::kWrites,
     "A BOOL that is TRUE while the button is held, for one scan at least; with value: writes that value"},
    {"slider", 6, 2, Use::kWrites, "A number from low to high"},
    {"number", 4, 2, Use::kShows, "A number or any other value as text; with entered it can be entered, too"},
    {"gauge", 4, 4, Use::kShows, "A number as a needle, from low to high"},
    {"bar", 2, 6, Use::kShows, "A number as a bar, from low to high; lying when it is wider than high"},
    {"tank", 4, 6, Use::kShows, "A number as a level, from low to high"},
    {"valve", 2, 2, Use::kShows, "A BOOL, or a number above zero, as an open valve"},
    {"motor", 2, 2, Use::kShows, "A BOOL, or a number other than zero, as a running motor"},
    {"pipe", 4, 1, Use::kNone, "A pipe; with a variable: filled while that is TRUE or not zero"},
    {"plot", 8, 5, Use::kShows, "The courses of numbers and BOOLs"},
    {"alarms", 10, 5, Use::kNone, "Alarms that are not in their normal state, and buttons to acknowledge them"},
    {"text", 5, 1, Use::kNone, "A text; with a variable: its value after the text"},
    {"picture", 6, 4, Use::kNone, "A picture from the folder of the project"},
    {"link", 4, 2, Use::kNone, "Goes to another page"},
};
constexpr const KindRow& row_of(Kind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

enum class KeyType : std::uint8_t {
  kText,
  kInteger,
  kNumber,
  kBoolean,
  kValue,  ///< true, false, a number or a text
  kTexts,
};

constexpr std::uint32_t bit(Kind kind) { return 1u << static_cast<unsigned>(kind); }
template <class... Kinds>
constexpr std::uint32_t bits(Kinds... kinds) {
  return (bit(kinds) | ...);
}

struct KeyRow {
  std::string_view name;
  KeyType type;
  std::uint32_t kinds;     ///< bits of those that have it
  std::uint32_t required;  ///< ..and of those that need it
  std::string_view doc;    ///< a sentence without a full stop
  std::string_view choices = {};
};

inline constexpr std::uint32_t kStates = bits(Kind::kLamp, Kind::kSwitch, Kind::kValve, Kind::kMotor);
inline constexpr std::uint32_t kScaled = bits(Kind::kSlider, Kind::kNumber, Kind::kGauge, Kind::kBar, Kind::kTank);
inline constexpr std::uint32_t kBound = kStates | kScaled | bit(Kind::kButton);

/// In the order in which they are written.
inline constexpr KeyRow kKeys[] = {
    {"label", KeyType::kText, kBound | bits(Kind::kPlot, Kind::kAlarms, Kind::kPicture, Kind::kLink),
     bit(Kind::kPicture), "What it is called; without: the last part of the variable's path"},
    {"text", KeyType::kText, bit(Kind::kText), 0, "What it says"},
    {"variable", KeyType::kText, kBound | bits(Kind::kPipe, Kind::kText), kBound,
     "Path of the variable: \"Level\", \"GVL.Setpoint\", \"%IX0.0\""},
    {"variables", KeyType::kTexts, bit(Kind::kPlot), bit(Kind::kPlot), "Paths of up to eight variables"},
    {"format", KeyType::kText, kScaled | bit(Kind::kText), 0,
     "How numbers are written: \"0\", \"0.0\", \"0.00\" with so many places; \"16#\", \"2#\", \"8#\" for bits"},
    {"unit", KeyType::kText, kScaled | bit(Kind::kText), 0, "Written after the number"},
    {"low", KeyType::kNumber, kScaled | bit(Kind::kPlot), 0,
     "Least value of the scale, and least one that may be written; without: 0, of a number none"},
    {"high", KeyType::kNumber, kScaled | bit(Kind::kPlot), 0,
     "Greatest value of the scale, and greatest one that may be written; without: 100, of a number none"},
    {"step", KeyType::kNumber, bits(Kind::kSlider, Kind::kNumber), 0, "From one value to the next"},
    {"entered", KeyType::kBoolean, bit(Kind::kNumber), 0, "Operators may enter a value"},
    {"value", KeyType::kValue, bit(Kind::kButton), 0, "What the button writes; without: TRUE while it is held"},
    {"on", KeyType::kText, kStates, 0, "Word for TRUE"},
    {"off", KeyType::kText, kStates, 0, "Word for FALSE"},
    {"colour", KeyType::kText, bits(Kind::kLamp, Kind::kBar, Kind::kTank, Kind::kPipe), 0,
     "Colour when it is on or full", "green|blue|yellow|red|grey"},
    {"seconds", KeyType::kNumber, bit(Kind::kPlot), 0, "How much is shown; without: 60"},
    {"class", KeyType::kText, bit(Kind::kAlarms), 0, "Alarms of this class alone; without: all"},
    {"file", KeyType::kText, bit(Kind::kPicture), bit(Kind::kPicture),
     "Name of a file beside pages.toml: .png, .jpg, .gif, .webp or .svg"},
    {"page", KeyType::kText, bit(Kind::kLink), bit(Kind::kLink), "Name of the page it goes to"},
};
inline constexpr std::size_t kKeyCount = std::size(kKeys);

/// Position in kKeys; at compile time.
consteval std::size_t key(std::string_view name) {
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    if (kKeys[i].name == name) return i;
  }
  throw "there is no such key";
}

/// What a file may have at most.
inline constexpr std::size_t kMostPages = 50;
inline constexpr std::size_t kMostElements = 500;  ///< of a page
inline constexpr std::size_t kMostText = 500;      ///< bytes of one text
inline constexpr std::size_t kMostPlotted = 8;
inline constexpr std::int64_t kMostCells = 200;  ///< of a page, in each direction
inline constexpr std::int64_t kColumns = 24;     ///< of a page that does not say how many
inline constexpr std::int64_t kRows = 14;
/// Of a scale that does not say its ends.
inline constexpr double kLow = 0, kHigh = 100;

}  // namespace plc::hmi
