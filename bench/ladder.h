// Ladders made from a seed, for benchmarks: the same logic as a PLCopen drawing and as C on plain arrays.
//
// In: Shape (rungs, plain or nested, seed). Out: Ladder, written by write_plcopen and write_c. Equal shapes give equal
// bytes. Does not belong here: measuring (load.cpp, scan.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

namespace plc::bench {

struct Shape {
  std::uint32_t rungs = 1000;
  /// false: four contacts with one OR branch and a coil of its own. true: 1 to 12 contacts nested up to three deep, rungs/2
  /// variables, set and reset coils, some TON, CTU and R_TRIG.
  bool nested = false;
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
enum class Box : std::uint8_t { kNone, kTon, kCtu, kRTrig };

struct Rung {
  Net net;
  Box box = Box::kNone;
  std::uint32_t instance = 0;  ///< of the box, counted per kind
  std::uint32_t preset = 0;    ///< kTon: milliseconds; kCtu: count
  std::uint32_t reset = 0;     ///< kCtu: variable at R
  Coil coil = Coil::kNormal;
  std::uint32_t target = 0;  ///< variable of the coil
};

struct Ladder {
  Shape shape;
  std::uint32_t variables = 0;
  std::uint32_t inputs = 0;  ///< variables [0, inputs) are written by no rung
  std::uint32_t instances[4] = {};  ///< per Box
  std::vector<Rung> rungs;
};

Ladder make_ladder(const Shape& shape);

/// Name of a variable in the drawing, and of the program instance that holds it.
std::string variable_name(std::uint32_t variable);
inline constexpr const char* kInstanceName = "Main";

/// One element a line, positions and rails as OpenPLC Editor writes them, about 2 kB a plain rung.
void write_plcopen(const Ladder& ladder, std::ostream& out);

/// `unsigned char *plc_variables(void)` and `void plc_scan(long long now_ns)`; functions of 500 rungs, a compiler barrier
/// after each rung, so that the compiler may not carry values from rung to rung; -DBARRIER= leaves it out.
void write_c(const Ladder& ladder, std::ostream& out);

}  // namespace plc::bench
