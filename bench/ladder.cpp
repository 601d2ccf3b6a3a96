#include "bench/ladder.h"

#include <algorithm>
#include <random>
#include <utility>

namespace plc::bench {
namespace {

constexpr std::uint32_t kMaxContacts = 12;
constexpr int kMaxNesting = 3;

/// Draws from a seed; std::uniform_int_distribution may differ between libraries, a modulus does not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(engine_() % bound); }
  bool chance(std::uint32_t percent) { return below(100) < percent; }

 private:
  std::mt19937_64 engine_;
};

Net contact(Dice& dice, std::uint32_t variables) {
  Net net;
  net.variable = dice.below(variables);
  // WHY half: a ladder of plain contacts goes all FALSE after a few scans and would compare nothing.
  net.negated = dice.chance(50);
  return net;
}

/// `contacts` contacts in series or parallel; alternate levels nest as long as `nesting` allows.
Net random_net(Dice& dice, std::uint32_t contacts, bool parallel, int nesting, std::uint32_t variables) {
  if (contacts == 1) return contact(dice, variables);
  Net net;
  net.kind = parallel ? Net::Kind::kParallel : Net::Kind::kSeries;
  while (contacts > 0) {
    // WHY at most contacts - 1 in the first part: a net of one child would not be a branch.
    const std::uint32_t most = net.children.empty() ? contacts - 1 : contacts;
    const bool nest = nesting > 0 && most >= 2 && dice.chance(50);
    const std::uint32_t part = nest ? 2 + dice.below(most - 1) : 1;
    net.children.push_back(nest ? random_net(dice, part, !parallel, parallel ? nesting : nesting - 1, variables)
                                : contact(dice, variables));
    contacts -= part;
  }
  return net;
}

/// (a OR b) AND c AND d, any of them negated.
Net plain_net(Dice& dice, std::uint32_t variables) {
  Net branch;
  branch.kind = Net::Kind::kParallel;
  for (int i = 0; i < 2; ++i) branch.children.push_back(contact(dice, variables));
  Net net;
  net.kind = Net::Kind::kSeries;
  net.children.push_back(std::move(branch));
  for (int i = 0; i < 2; ++i) net.children.push_back(contact(dice, variables));
  return net;
}

// ---- drawing --------------------------------------------------------------------------------------------------------

struct Point {
  std::uint64_t id = 0;
  int x = 0, y = 0;  ///< of the connection point out
};

/// Writes the elements of one rung, left to right, and remembers where each wire starts.
class Drawing {
 public:
  explicit Drawing(std::ostream& out) : out_(out) {}

  void rung(const Rung& rung) {
    if (powered_.empty()) left_id_ = next_id_++;
    const int top = y_;
    const Point rail{left_id_, 70, top + 20};
    int bottom = top;
    int right = 160;
    std::vector<Point> power = net(rung.net, {rail}, 160, top + 10, right, bottom);
    if (rung.box != Box::kNone) {
      bottom = std::max(bottom, top + 120);
      power = {box(rung, power, right, top)};
      right += 180;
    }
    powered_.push_back(coil(rung, power, right, top + 10));
    y_ = std::max(bottom, top + 60) + 20;
    if (powered_.size() == kRungsPerRail) rails();
  }

  /// The pair of power rails of the rungs since the last pair.
  void rails() {
    if (powered_.empty()) return;
    const int top = powered_.front().y - 20;
    const int height = powered_.back().y - top + 20;
    out_ << "<leftPowerRail localId=\"" << left_id_ << "\" width=\"10\" height=\"" << height
         << "\"><position x=\"60\" y=\"" << top << "\"/>";
    for (const Point& coil : powered_) {
      out_ << "<connectionPointOut formalParameter=\"\"><relPosition x=\"10\" y=\"" << coil.y - top
           << "\"/></connectionPointOut>";
    }
    out_ << "</leftPowerRail>\n<rightPowerRail localId=\"" << next_id_++ << "\" width=\"10\" height=\"" << height
         << "\"><position x=\"" << kRightRail << "\" y=\"" << top << "\"/>";
    for (const Point& coil : powered_) {
      out_ << "<connectionPointIn><relPosition x=\"0\" y=\"" << coil.y - top << "\"/>";
      wire(coil, kRightRail, coil.y);
      out_ << "</connectionPointIn>";
    }
    out_ << "</rightPowerRail>\n";
    powered_.clear();
  }

 private:
  void wire(const Point& from, int x, int y, std::string_view pin = {}) {
    out_ << "<connection refLocalId=\"" << from.id << '"';
    if (!pin.empty()) out_ << " formalParameter=\"" << pin << '"';
    out_ << "><position x=\"" << x << "\" y=\"" << y << "\"/>";
    if (from.y != y) {
      const int bend = (from.x + x) / 20 * 10;
      out_ << "<position x=\"" << bend << "\" y=\"" << y << "\"/><position x=\"" << bend << "\" y=\"" << from.y
           << "\"/>";
    }
    out_ << "<position x=\"" << from.x << "\" y=\"" << from.y << "\"/></connection>";
  }
  void wires(const std::vector<Point>& from, int x, int y) {
    for (const Point& point : from) wire(point, x, y, point.id == box_id_ ? box_pin_ : std::string_view());
  }

  /// Draws from column `x`, row `y`; `right` is the first free column, `bottom` the last used row. Returns the wires out.
  std::vector<Point> net(const Net& drawn, const std::vector<Point>& power, int x, int y, int& right, int& bottom) {
    if (drawn.kind == Net::Kind::kContact) {
      const Point out{next_id_++, x + 21, y + 10};
      out_ << "<contact localId=\"" << out.id << "\" negated=\"" << (drawn.negated ? "true" : "false")
           << "\" width=\"21\" height=\"20\"><position x=\"" << x << "\" y=\"" << y
           << "\"/><connectionPointIn><relPosition x=\"0\" y=\"10\"/>";
      wires(power, x, y + 10);
      out_ << "</connectionPointIn><connectionPointOut><relPosition x=\"21\" y=\"10\"/></connectionPointOut><variable>"
           << variable_name(drawn.variable) << "</variable></contact>\n";
      right = std::max(right, x + 110);
      bottom = std::max(bottom, y + 20);
      return {out};
    }
    if (drawn.kind == Net::Kind::kSeries) {
      std::vector<Point> flow = power;
      for (const Net& child : drawn.children) {
        int end = x;
        flow = net(child, flow, x, y, end, bottom);
        x = end;
      }
      right = std::max(right, x);
      return flow;
    }
    std::vector<Point> joined;
    for (const Net& child : drawn.children) {
      int lowest = y;
      const std::vector<Point> flow = net(child, power, x, y, right, lowest);
      joined.insert(joined.end(), flow.begin(), flow.end());
      y = lowest + 20;
      bottom = std::max(bottom, lowest);
    }
    return joined;
  }

  Point constant(const std::string& text, int x, int y) {
    const Point out{next_id_++, x + 60, y + 10};
    out_ << "<inVariable localId=\"" << out.id << "\" height=\"20\" width=\"60\" negated=\"false\"><position x=\"" << x
         << "\" y=\"" << y << "\"/><connectionPointOut><relPosition x=\"60\" y=\"10\"/></connectionPointOut><expression>"
         << text << "</expression></inVariable>\n";
    return out;
  }

  void input(std::string_view name, const std::vector<Point>& from, int x, int y, int row) {
    out_ << "<variable formalParameter=\"" << name << "\"><connectionPointIn><relPosition x=\"0\" y=\"" << row << "\"/>";
    wires(from, x, y + row);
    out_ << "</connectionPointIn></variable>";
  }
  void output(std::string_view name, int row) {
    out_ << "<variable formalParameter=\"" << name << "\"><connectionPointOut><relPosition x=\"70\" y=\"" << row
         << "\"/></connectionPointOut></variable>";
  }

  Point box(const Rung& rung, const std::vector<Point>& power, int x, int y) {
    const char* type = rung.box == Box::kTon ? "TON" : rung.box == Box::kCtu ? "CTU" : "R_TRIG";
    std::vector<Point> preset, reset;
    if (rung.box == Box::kTon) preset = {constant("T#" + std::to_string(rung.preset) + "ms", x, y + 70)};
    if (rung.box == Box::kCtu) {
      reset = {constant(variable_name(rung.reset), x, y + 70)};
      preset = {constant(std::to_string(rung.preset), x, y + 100)};
    }
    box_id_ = next_id_++;
    box_pin_ = "Q";
    const int left = x + 80;
    out_ << "<block localId=\"" << box_id_ << "\" typeName=\"" << type << "\" instanceName=\"" << type << rung.instance
         << "\" height=\"110\" width=\"70\"><position x=\"" << left << "\" y=\"" << y - 10 << "\"/><inputVariables>";
    if (rung.box == Box::kTon) {
      input("IN", power, left, y - 10, 30);
      input("PT", preset, left, y - 10, 60);
    } else if (rung.box == Box::kCtu) {
      input("CU", power, left, y - 10, 30);
      input("R", reset, left, y - 10, 60);
      input("PV", preset, left, y - 10, 90);
    } else {
      input("CLK", power, left, y - 10, 30);
    }
    out_ << "</inputVariables><inOutVariables/><outputVariables>";
    output("Q", 30);
    if (rung.box == Box::kTon) output("ET", 60);
    if (rung.box == Box::kCtu) output("CV", 60);
    out_ << "</outputVariables></block>\n";
    return {box_id_, left + 70, y + 20};
  }

  Point coil(const Rung& rung, const std::vector<Point>& power, int x, int y) {
    const Point out{next_id_++, x + 21, y + 10};
    out_ << "<coil localId=\"" << out.id << "\" negated=\"" << (rung.coil == Coil::kNegated ? "true" : "false") << '"';
    if (rung.coil == Coil::kSet) out_ << " storage=\"set\"";
    if (rung.coil == Coil::kReset) out_ << " storage=\"reset\"";
    out_ << " width=\"21\" height=\"20\"><position x=\"" << x << "\" y=\"" << y
         << "\"/><connectionPointIn><relPosition x=\"0\" y=\"10\"/>";
    wires(power, x, y + 10);
    out_ << "</connectionPointIn><connectionPointOut><relPosition x=\"21\" y=\"10\"/></connectionPointOut><variable>"
         << variable_name(rung.target) << "</variable></coil>\n";
    box_id_ = 0;
    return out;
  }

  static constexpr std::size_t kRungsPerRail = 50;
  static constexpr int kRightRail = 2400;

  std::ostream& out_;
  std::uint64_t next_id_ = 1;
  std::uint64_t left_id_ = 0;
  std::vector<Point> powered_;  ///< coils that still need their right rail
  int y_ = 40;
  std::uint64_t box_id_ = 0;  ///< block whose wires must name a pin
  std::string_view box_pin_;
};

void declare(std::ostream& out, const std::string& name, std::string_view type, bool derived) {
  out << "<variable name=\"" << name << "\"><type>";
  if (derived) {
    out << "<derived name=\"" << type << "\"/>";
  } else {
    out << '<' << type << "/>";
  }
  out << "</type></variable>\n";
}

// ---- C --------------------------------------------------------------------------------------------------------------

void c_net(const Net& net, std::ostream& out) {
  if (net.kind == Net::Kind::kContact) {
    out << "v[" << net.variable << ']' << (net.negated ? "^1" : "");
    return;
  }
  for (std::size_t i = 0; i < net.children.size(); ++i) {
    if (i != 0) out << (net.kind == Net::Kind::kSeries ? " & " : " | ");
    out << '(';
    c_net(net.children[i], out);
    out << ')';
  }
}

void c_rung(const Rung& rung, std::ostream& out) {
  out << "  { unsigned char p = (unsigned char)(";
  c_net(rung.net, out);
  out << ");";
  if (rung.box == Box::kTon) {
    out << " p = ton_step(&ton[" << rung.instance << "], p, " << rung.preset << "000000LL, now);";
  } else if (rung.box == Box::kCtu) {
    out << " p = ctu_step(&ctu[" << rung.instance << "], p, v[" << rung.reset << "], " << rung.preset << ");";
  } else if (rung.box == Box::kRTrig) {
    out << " p = rtrig_step(&rtrig[" << rung.instance << "], p);";
  }
  const std::string target = "v[" + std::to_string(rung.target) + "]";
  switch (rung.coil) {
    case Coil::kNormal:
      out << ' ' << target << " = p;";
      break;
    case Coil::kNegated:
      out << ' ' << target << " = p ^ 1;";
      break;
    case Coil::kSet:
      out << ' ' << target << " |= p;";
      break;
    case Coil::kReset:
      out << ' ' << target << " &= p ^ 1;";
      break;
  }
  out << " } BARRIER\n";
}

constexpr const char* kCPrelude = R"(#ifndef BARRIER
#define BARRIER __asm__ volatile("" ::: "memory");
#endif
struct ton { long long start; unsigned char running; };
struct ctu { short count; unsigned char last; };
struct rtrig { unsigned char last; };
static inline unsigned char ton_step(struct ton *t, unsigned char in, long long pt, long long now) {
  if (!in) { t->running = 0; return 0; }
  if (!t->running) { t->running = 1; t->start = now; }
  return (unsigned char)(now - t->start >= pt);
}
static inline unsigned char ctu_step(struct ctu *c, unsigned char cu, unsigned char r, short pv) {
  if (r) c->count = 0;
  else if (cu && !c->last && c->count < 32767) ++c->count;
  c->last = cu;
  return (unsigned char)(c->count >= pv);
}
static inline unsigned char rtrig_step(struct rtrig *t, unsigned char clk) {
  unsigned char q = (unsigned char)(clk & (t->last ^ 1));
  t->last = clk;
  return q;
}
)";
constexpr std::size_t kRungsPerFunction = 500;

}  // namespace

std::string variable_name(std::uint32_t variable) { return "M" + std::to_string(variable); }

Ladder make_ladder(const Shape& shape) {
  Ladder ladder;
  ladder.shape = shape;
  Dice dice(shape.seed);
  // Plain: every coil has a variable of its own beside the inputs. Nested: half as many variables as rungs, some of them
  // latches that several rungs set and reset; the others have one normal or negated coil.
  ladder.variables = shape.nested ? std::max(16u, shape.rungs / 2) : shape.rungs + std::max(8u, shape.rungs / 8);
  ladder.inputs = shape.nested ? std::max(4u, ladder.variables / 16) : ladder.variables - shape.rungs;
  const std::uint32_t outputs = ladder.variables - ladder.inputs;
  const std::uint32_t latches = shape.nested ? std::max(2u, outputs / 6) : 0;
  const std::uint32_t normals = outputs - latches;
  std::uint32_t next_normal = 0;
  ladder.rungs.reserve(shape.rungs);
  for (std::uint32_t i = 0; i < shape.rungs; ++i) {
    Rung rung;
    if (!shape.nested) {
      rung.net = plain_net(dice, ladder.variables);
      rung.target = ladder.inputs + i;
    } else {
      rung.net = random_net(dice, 1 + dice.below(kMaxContacts), false, kMaxNesting, ladder.variables);
      const std::uint32_t kind = dice.below(100);
      if (kind < 40 && next_normal < normals) {
        rung.coil = dice.chance(20) ? Coil::kNegated : Coil::kNormal;
        rung.target = ladder.inputs + next_normal++;
      } else {
        rung.coil = kind < 70 ? Coil::kSet : Coil::kReset;
        rung.target = ladder.inputs + normals + dice.below(latches);
      }
      if (dice.chance(10)) {
        rung.box = static_cast<Box>(1 + dice.below(3));
        rung.instance = ladder.instances[static_cast<std::size_t>(rung.box)]++;
        rung.preset = rung.box == Box::kTon ? 20 * (1 + dice.below(50)) : 1 + dice.below(9);
        rung.reset = dice.below(ladder.variables);
      }
    }
    ladder.rungs.push_back(std::move(rung));
  }
  return ladder;
}

void write_plcopen(const Ladder& ladder, std::ostream& out) {
  out << "<?xml version='1.0' encoding='utf-8'?>\n"
         "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\" xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">\n"
         "<fileHeader companyName=\"PICARD\" productName=\"plc-bench\" productVersion=\"1\" "
         "creationDateTime=\"2024-01-01T00:00:00\"/>\n"
         "<contentHeader name=\"ladder\"><coordinateInfo><fbd><scaling x=\"10\" y=\"10\"/></fbd><ld><scaling x=\"10\" "
         "y=\"10\"/></ld><sfc><scaling x=\"10\" y=\"10\"/></sfc></coordinateInfo></contentHeader>\n"
         "<types><dataTypes/><pous><pou name=\"Ladder\" pouType=\"program\"><interface><localVars>\n";
  for (std::uint32_t i = 0; i < ladder.variables; ++i) declare(out, variable_name(i), "BOOL", false);
  constexpr std::pair<Box, const char*> kBoxes[] = {{Box::kTon, "TON"}, {Box::kCtu, "CTU"}, {Box::kRTrig, "R_TRIG"}};
  for (const auto& [box, name] : kBoxes) {
    for (std::uint32_t i = 0; i < ladder.instances[static_cast<std::size_t>(box)]; ++i) {
      declare(out, name + std::to_string(i), name, true);
    }
  }
  out << "</localVars></interface><body><LD>\n";
  Drawing drawing(out);
  for (const Rung& rung : ladder.rungs) drawing.rung(rung);
  drawing.rails();
  out << "</LD></body></pou></pous></types>\n"
         "<instances><configurations><configuration name=\"Config0\"><resource name=\"Res0\">"
         "<task name=\"task0\" priority=\"0\" interval=\"T#20ms\"><pouInstance name=\""
      << kInstanceName
      << "\" typeName=\"Ladder\"/></task></resource></configuration></configurations></instances>\n</project>\n";
}

void write_c(const Ladder& ladder, std::ostream& out) {
  out << kCPrelude << "static unsigned char v[" << ladder.variables << "];\n";
  constexpr std::pair<Box, const char*> kArrays[] = {{Box::kTon, "ton"}, {Box::kCtu, "ctu"}, {Box::kRTrig, "rtrig"}};
  for (const auto& [box, name] : kArrays) {
    const std::uint32_t count = ladder.instances[static_cast<std::size_t>(box)];
    if (count != 0) out << "static struct " << name << ' ' << name << '[' << count << "];\n";
  }
  std::size_t functions = 0;
  for (std::size_t i = 0; i < ladder.rungs.size(); ++i) {
    if (i % kRungsPerFunction == 0) {
      out << "static void __attribute__((noinline)) rungs_" << functions++ << "(long long now) {\n  (void)now;\n";
    }
    c_rung(ladder.rungs[i], out);
    if (i % kRungsPerFunction == kRungsPerFunction - 1 || i + 1 == ladder.rungs.size()) out << "}\n";
  }
  out << "unsigned char *plc_variables(void) { return v; }\nvoid plc_scan(long long now) {\n";
  for (std::size_t i = 0; i < functions; ++i) out << "  rungs_" << i << "(now);\n";
  out << "}\n";
}

}  // namespace plc::bench
