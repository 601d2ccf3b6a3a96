// Ladders and chains of functions made from a seed.
//
// In: Shape (kind, rungs, seed). Out: Program, to be written as a drawing (drawing.h), as ST (drawn_text.h) and as C
// (c_source.h). Equal shapes give equal programs. Does not belong here: which sizes are measured (workload.h),
// measuring (load.cpp, scan.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace plc::bench {

enum class Kind : std::uint8_t {
  kPlain,   ///< ladder: four contacts with one OR branch and a coil of its own
  kNested,  ///< ladder: 1 to 12 contacts nested up to three deep, rungs/2 variables, set and reset coils, some blocks
  kBlocks,  ///< ladder: one to three contacts, a timer, counter or edge, a coil of its own
  kArithmetic,  ///< FBD: chains of four to eight functions, half of them DINT, half REAL
  kMixed,       ///< ladder: of 100 rungs 60 as kPlain, 20 as kBlocks, 20 as kArithmetic
  kRewritten,   ///< ladder: four contacts over rungs/2 variables, each coil in two to six rungs, some set or reset
  kTimers,      ///< ladder: as kBlocks, but timers of a few to some hundred scans that run and elapse
  kMixed2,      ///< ladder: of 100 rungs 60 as kRewritten, 20 as kTimers, 20 as kArithmetic
};

struct Shape {
  Kind kind = Kind::kPlain;
  std::uint32_t rungs = 1000;  ///< a chain is a rung, too
  std::uint64_t seed = 1;
};

/// A net of contacts: one contact, or children in series or in parallel.
struct Net {
  enum class Kind : std::uint8_t { kContact, kSeries, kParallel } kind = Kind::kContact;
  std::uint32_t variable = 0;
  bool negated = false;
  std::vector<Net> children;
};

enum class Coil : std::uint8_t { kNormal, kNegated, kSet, kReset };
/// Block between the net and the coil.
enum class Box : std::uint8_t { kNone, kTon, kTof, kTp, kCtu, kCtd, kRTrig };
inline constexpr std::size_t kBoxes = 7;
inline constexpr const char* kBoxNames[kBoxes] = {"", "TON", "TOF", "TP", "CTU", "CTD", "R_TRIG"};
constexpr bool is_timer(Box box) { return box == Box::kTon || box == Box::kTof || box == Box::kTp; }
constexpr bool is_counter(Box box) { return box == Box::kCtu || box == Box::kCtd; }

struct Rung {
  Net net;
  Box box = Box::kNone;
  std::uint32_t instance = 0;  ///< of the box, counted per kind
  std::uint32_t preset = 0;    ///< timers: milliseconds; counters: count
  std::uint32_t reset = 0;     ///< counters: variable at R or LD
  Coil coil = Coil::kNormal;
  std::uint32_t target = 0;  ///< variable of the coil
};

enum class Type : std::uint8_t { kBool, kDint, kReal };
inline constexpr std::size_t kTypes = 3;

/// What a wire or variable feeds into a function.
struct Operand {
  std::string constant;  ///< a literal of ST, or empty: the variable
  std::uint32_t variable = 0;
};

enum class Function : std::uint8_t { kAdd, kSub, kMul, kMin, kMax, kLimit, kSel };

/// A function of a chain; what comes along the chain is its first input, of LIMIT IN, of SEL IN0.
struct Link {
  Function function = Function::kAdd;
  std::uint32_t gate = 0;  ///< kSel: BOOL at G
  Operand operand;         ///< the second input; of LIMIT MN
  Operand maximum;         ///< kLimit: MX
};

/// Functions in a row: the first feeds the second, and so on. An inOutVariable on the way keeps what passes it.
struct Chain {
  Type type = Type::kDint;  ///< not kBool
  Operand start;
  std::vector<Link> links;
  std::size_t kept_at = 0;   ///< the inOutVariable follows this link
  std::uint32_t kept = 0;    ///< its variable
  std::uint32_t target = 0;  ///< what the last link gives
};

/// Variables of one type; [0, inputs) are written by no rung.
struct Variables {
  std::uint32_t count = 0;
  std::uint32_t inputs = 0;
};

struct Program {
  Shape shape;
  Variables variables[kTypes];           ///< by Type
  std::uint32_t instances[kBoxes] = {};  ///< by Box
  std::vector<std::variant<Rung, Chain>> rungs;
};

Program make_program(const Shape& shape);

/// Name of a variable in the drawing: "M7" is the BOOL 7, "D7" the DINT, "R7" the REAL.
std::string variable_name(Type type, std::uint32_t variable);
/// Name of an instance of a block: "TON7".
std::string instance_name(Box box, std::uint32_t instance);
/// The program instance that holds them all.
inline constexpr const char* kInstanceName = "Main";

}  // namespace plc::bench
