// Compile options: everything that changes what a program means. Stored in the image and printed at start, so that
// simulation and plant cannot differ (docs/adr/0004). One row each: flags, the image, its listing and what is printed
// at start follow from the rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace plc::core {

/// Which rule orders networks and elements (docs/guides/execution-order.md).
enum class Order : std::uint8_t { kDrawing, kDocument };
/// Whose semantics to reproduce where tools disagree.
enum class Compat : std::uint8_t { kNone, kBeremiz };
/// How direct addresses relate: kSeparate = %IX, %IB, %IW .. are independent (OpenPLC); kOverlay = %IW0 contains
/// %IX0.0..%IX1.7.
enum class AddressProfile : std::uint8_t { kSeparate, kOverlay };
/// How tasks exchange globals at the ends of their cycles (docs/guides/coherence.md).
enum class Coherence : std::uint8_t {
  kWaitFree,         ///< one snapshot per writing task, nobody waits
  kPriorityCeiling,  ///< groups of globals copied at raised priority (paper, 3.2.3); all tasks on one processor
  kGlobalLock,       ///< one lock around every copy (Chimera)
};

/// Whether the body of an action runs once more when it ends (IEC 61131-3:2013, 6.7.4.5 leaves both open). kAuto: with
/// charts of CODESYS and tools derived from it, not with others; what is compiled has kOn or kOff.
enum class FinalScan : std::uint8_t { kAuto, kOn, kOff };

struct CompileOptions {
  Order order = Order::kDrawing;
  Compat compat = Compat::kNone;
  AddressProfile profile = AddressProfile::kSeparate;
  Coherence coherence = Coherence::kWaitFree;
  bool stub_missing = false;
  bool strict = false;
  bool show_all = false;  ///< every warning and note is printed, not 20 of one code. Not in the image
  FinalScan sfc_final_scan = FinalScan::kAuto;
  std::string pou;  ///< --pou: instantiate this program or function block alone in a 20 ms task; empty = the file's
                    ///< configuration
  std::vector<std::string> defines = {};  ///< --define: what {IF defined (X)} asks for, each "NAME" or "NAME=text"
  friend bool operator==(const CompileOptions&, const CompileOptions&) = default;
};

/// An option that is one of a few words.
template <class E>
struct Choice {
  using Value = E;
  std::string_view name;                    ///< of the flag without its dashes, and where options are listed
  E CompileOptions::*value;                 ///< where it is kept
  std::span<const std::string_view> words;  ///< by value, from 0; the first is the default
  std::string_view help;                    ///< what --help says
};

/// An option that is given or not.
struct Switch {
  std::string_view name;
  bool CompileOptions::*value;
  bool stored;  ///< in the image; others change no meaning of what compiles
  std::string_view help;
};

/// An option that may be given several times, each time with one text.
struct Texts {
  std::string_view name;
  std::string_view value_name;  ///< what --help calls a text
  std::vector<std::string> CompileOptions::*value;
  std::string (*wrong)(const std::string& text);  ///< what is wrong with a text; empty when nothing is
  std::string_view help;
};

/// "NAME" or "NAME=text", as --define takes it: what is wrong with it, or empty.
std::string wrong_define(const std::string& text);

inline constexpr std::array<std::string_view, 2> kOrderWords = {"drawing", "document"};
inline constexpr std::array<std::string_view, 2> kCompatWords = {"none", "beremiz"};
inline constexpr std::array<std::string_view, 2> kProfileWords = {"separate", "overlay"};
inline constexpr std::array<std::string_view, 3> kCoherenceWords = {"wait-free", "priority-ceiling", "global-lock"};
inline constexpr std::array<std::string_view, 3> kFinalScanWords = {"auto", "on", "off"};

/// In the order in which the image has them.
inline constexpr std::tuple kChoices = {
    Choice<Order>{"order", &CompileOptions::order, kOrderWords,
                  "drawing: top to bottom as drawn (default). document: as the file lists the elements"},
    Choice<Compat>{"compat", &CompileOptions::compat, kCompatWords,
                   "none: one value per wire (default). beremiz: contacts are read again for every coil, and edges are "
                   "its own"},
    Choice<AddressProfile>{"profile", &CompileOptions::profile, kProfileWords,
                           "separate: %IX, %IB, %IW are independent (default). overlay: %IW0 contains %IX0.0 to "
                           "%IX1.7"},
    Choice<Coherence>{"coherence", &CompileOptions::coherence, kCoherenceWords,
                      "how tasks exchange globals. wait-free: nobody waits (default). priority-ceiling: group by group "
                      "at raised priority, all tasks on one processor. global-lock: one lock around every exchange"},
    Choice<FinalScan>{"sfc-final-scan", &CompileOptions::sfc_final_scan, kFinalScanWords,
                      "bodies of actions of charts run once more when they end. auto: in charts of CODESYS and TwinCAT "
                      "(default). on, off: in all, in none"},
};
inline constexpr std::array<Switch, 2> kSwitches = {{
    {"stub-missing", &CompileOptions::stub_missing, true,
     "POUs, blocks and types that cannot be compiled become stubs that do nothing; each is named"},
    {"strict", &CompileOptions::strict, false,
     "idioms that other tools take and the standard does not know are errors (plc check names them in notes)"},
}};

/// Stored in the image, in their order.
inline constexpr std::array<Texts, 1> kTexts = {{
    {"define", "NAME[=TEXT]", &CompileOptions::defines, wrong_define,
     "a name that pragmas ask for: {IF defined (NAME)}, or with its text {IF hasvalue (NAME, 'TEXT')}; may be "
     "repeated"},
}};

/// Calls visit(row) with each Choice.
template <class Visit>
constexpr void for_each_choice(Visit visit) {
  std::apply([&visit](const auto&... row) { (visit(row), ...); }, kChoices);
}

/// The word that stands for a value of this option.
template <class E>
constexpr std::string_view word_of(const Choice<E>& choice, const CompileOptions& options) {
  return choice.words[static_cast<std::size_t>(options.*choice.value)];
}

/// "wait-free", "priority-ceiling", "global-lock".
constexpr std::string_view coherence_name(Coherence coherence) {
  return kCoherenceWords[static_cast<std::size_t>(coherence)];
}

}  // namespace plc::core
