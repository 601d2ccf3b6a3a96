#include "bench/drawing.h"

#include <algorithm>
#include <initializer_list>
#include <ostream>
#include <string_view>
#include <utility>

namespace plc::bench {
namespace {

struct Point {
  std::uint64_t id = 0;
  int x = 0, y = 0;           ///< of the connection point out
  std::string_view pin = {};  ///< of blocks
};
/// An input of a block and what it is wired to.
using Wired = std::pair<const char*, std::vector<Point>>;

/// Names of the inputs of a block; those of a kind are wired alike.
struct Pins {
  const char* power;   ///< what the net leads to
  const char* reset;   ///< counters
  const char* preset;  ///< timers and counters
  const char* value;   ///< second output, which is not wired
};
constexpr Pins kPins[kBoxes] = {{},
                                {"IN", nullptr, "PT", "ET"},
                                {"IN", nullptr, "PT", "ET"},
                                {"IN", nullptr, "PT", "ET"},
                                {"CU", "R", "PV", "CV"},
                                {"CD", "LD", "PV", "CV"},
                                {"CLK", nullptr, nullptr, nullptr}};

constexpr const char* kFunctions[] = {"ADD", "SUB", "MUL", "MIN", "MAX", "LIMIT", "SEL"};
constexpr int kTopOfPins = 30, kPinPitch = 30;  ///< of blocks, pixels

/// Writes the elements of one rung, left to right, and remembers where each wire starts.
class Drawing {
 public:
  explicit Drawing(std::ostream& out) : out_(out) {}

  void draw(const Rung& rung) {
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

  /// First value and second inputs are above and below the row of functions.
  void draw(const Chain& chain) {
    const int top = y_;
    Point value = in_variable(text(chain.type, chain.start), 60, top + 20);
    int x = 160;
    for (std::size_t i = 0; i < chain.links.size(); ++i) {
      value = function(chain.type, chain.links[i], value, x, top);
      x += 180;
      if (i == chain.kept_at) {
        value = variable("inOutVariable", variable_name(chain.type, chain.kept), value, x, top + 20);
        x += 90;
      }
    }
    variable("outVariable", variable_name(chain.type, chain.target), value, x, top + 20);
    y_ = top + 150;
  }

  /// The pair of power rails of the rungs since the last pair.
  void rails() {
    if (powered_.empty()) return;
    const int top = powered_.front().y - 20;
    const int height = powered_.back().y - top + 20;
    out_ << "<leftPowerRail localId=\"" << left_id_ << R"(" width="10" height=")" << height
         << R"("><position x="60" y=")" << top << "\"/>";
    for (const Point& coil : powered_) {
      out_ << R"(<connectionPointOut formalParameter=""><relPosition x="10" y=")" << coil.y - top
           << "\"/></connectionPointOut>";
    }
    out_ << "</leftPowerRail>\n<rightPowerRail localId=\"" << next_id_++ << R"(" width="10" height=")" << height
         << "\"><position x=\"" << kRightRail << "\" y=\"" << top << "\"/>";
    for (const Point& coil : powered_) {
      out_ << R"(<connectionPointIn><relPosition x="0" y=")" << coil.y - top << "\"/>";
      wire(coil, kRightRail, coil.y);
      out_ << "</connectionPointIn>";
    }
    out_ << "</rightPowerRail>\n";
    powered_.clear();
  }

 private:
  void wire(const Point& from, int x, int y) {
    out_ << "<connection refLocalId=\"" << from.id << '"';
    if (!from.pin.empty()) out_ << " formalParameter=\"" << from.pin << '"';
    out_ << "><position x=\"" << x << "\" y=\"" << y << "\"/>";
    if (from.y != y) {
      const int bend = (from.x + x) / 20 * 10;
      out_ << "<position x=\"" << bend << "\" y=\"" << y << "\"/><position x=\"" << bend << "\" y=\"" << from.y
           << "\"/>";
    }
    out_ << "<position x=\"" << from.x << "\" y=\"" << from.y << "\"/></connection>";
  }
  void wires(const std::vector<Point>& from, int x, int y) {
    for (const Point& point : from) wire(point, x, y);
  }

  /// Draws from column `x`, row `y`; `right` is the first free column, `bottom` the last used row. Returns the wires
  /// out.
  std::vector<Point> net(const Net& drawn, const std::vector<Point>& power, int x, int y, int& right, int& bottom) {
    if (drawn.kind == Net::Kind::kContact) {
      const Point out{next_id_++, x + 21, y + 10};
      out_ << "<contact localId=\"" << out.id << "\" negated=\"" << (drawn.negated ? "true" : "false")
           << R"(" width="21" height="20"><position x=")" << x << "\" y=\"" << y
           << R"("/><connectionPointIn><relPosition x="0" y="10"/>)";
      wires(power, x, y + 10);
      out_ << R"(</connectionPointIn><connectionPointOut><relPosition x="21" y="10"/></connectionPointOut><variable>)"
           << variable_name(Type::kBool, drawn.variable) << "</variable></contact>\n";
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

  static std::string text(Type type, const Operand& operand) {
    return operand.constant.empty() ? variable_name(type, operand.variable) : operand.constant;
  }

  Point in_variable(const std::string& text, int x, int y) {
    const Point out{next_id_++, x + 60, y + 10};
    out_ << "<inVariable localId=\"" << out.id << R"(" height="20" width="60" negated="false"><position x=")" << x
         << "\" y=\"" << y << R"("/><connectionPointOut><relPosition x="60" y="10"/></connectionPointOut><expression>)"
         << text << "</expression></inVariable>\n";
    return out;
  }
  /// An outVariable or inOutVariable.
  Point variable(const char* element, const std::string& name, const Point& from, int x, int y) {
    const Point out{next_id_++, x + 60, y + 10};
    out_ << '<' << element << " localId=\"" << out.id << R"(" height="20" width="60"><position x=")" << x << "\" y=\""
         << y << R"("/><connectionPointIn><relPosition x="0" y="10"/>)";
    wires({from}, x, y + 10);
    out_ << "</connectionPointIn>";
    if (std::string_view(element) == "inOutVariable") {
      out_ << R"(<connectionPointOut><relPosition x="60" y="10"/></connectionPointOut>)";
    }
    out_ << "<expression>" << name << "</expression></" << element << ">\n";
    return out;
  }

  /// A block with all its inputs wired; the wires to it lead from above or from the left. What its first output gives.
  Point block(std::string_view type, const std::string& instance, const std::vector<Wired>& inputs,
              std::initializer_list<const char*> outputs, int x, int y) {
    const Point out{next_id_++, x + 70, y + kTopOfPins, *outputs.begin()};
    out_ << "<block localId=\"" << out.id << "\" typeName=\"" << type << '"';
    if (!instance.empty()) out_ << " instanceName=\"" << instance << '"';
    out_ << " height=\"" << kTopOfPins - 10 + static_cast<int>(inputs.size()) * kPinPitch
         << R"(" width="70"><position x=")" << x << "\" y=\"" << y << "\"/><inputVariables>";
    int row = kTopOfPins;
    for (const auto& [pin, from] : inputs) {
      out_ << "<variable formalParameter=\"" << pin << R"("><connectionPointIn><relPosition x="0" y=")" << row
           << "\"/>";
      wires(from, x, y + row);
      out_ << "</connectionPointIn></variable>";
      row += kPinPitch;
    }
    out_ << "</inputVariables><inOutVariables/><outputVariables>";
    row = kTopOfPins;
    for (const char* pin : outputs) {
      if (pin == nullptr) continue;
      out_ << "<variable formalParameter=\"" << pin << R"("><connectionPointOut><relPosition x="70" y=")" << row
           << "\"/></connectionPointOut></variable>";
      row += kPinPitch;
    }
    out_ << "</outputVariables></block>\n";
    return out;
  }

  Point box(const Rung& rung, const std::vector<Point>& power, int x, int y) {
    const auto kind = static_cast<std::size_t>(rung.box);
    const Pins& pins = kPins[kind];
    std::vector<Wired> inputs = {{pins.power, power}};
    const auto constant = [&](const char* pin, const std::string& value) {
      const int row = kTopOfPins + static_cast<int>(inputs.size()) * kPinPitch;
      inputs.emplace_back(pin, std::vector{in_variable(value, x, y - 20 + row)});
    };
    if (pins.reset != nullptr) constant(pins.reset, variable_name(Type::kBool, rung.reset));
    if (is_timer(rung.box)) constant(pins.preset, "T#" + std::to_string(rung.preset) + "ms");
    if (is_counter(rung.box)) constant(pins.preset, std::to_string(rung.preset));
    return block(kBoxNames[kind], instance_name(rung.box, rung.instance), inputs, {"Q", pins.value}, x + 80, y - 10);
  }

  Point function(Type type, const Link& link, const Point& value, int x, int y) {
    const auto operand = [&](const std::string& name, int pin) {
      return std::vector{in_variable(name, x, y + kTopOfPins + pin * kPinPitch - 10)};
    };
    const char* name = kFunctions[static_cast<std::size_t>(link.function)];
    const std::string second = text(type, link.operand);
    std::vector<Wired> inputs;
    if (link.function == Function::kLimit) {
      inputs = {{"MN", operand(second, 0)}, {"IN", {value}}, {"MX", operand(text(type, link.maximum), 2)}};
    } else if (link.function == Function::kSel) {
      inputs = {
          {"G", operand(variable_name(Type::kBool, link.gate), 0)}, {"IN0", {value}}, {"IN1", operand(second, 2)}};
    } else {
      inputs = {{"IN1", {value}}, {"IN2", operand(second, 1)}};
    }
    return block(name, {}, inputs, {"OUT"}, x + 80, y);
  }

  Point coil(const Rung& rung, const std::vector<Point>& power, int x, int y) {
    const Point out{next_id_++, x + 21, y + 10};
    out_ << "<coil localId=\"" << out.id << "\" negated=\"" << (rung.coil == Coil::kNegated ? "true" : "false") << '"';
    if (rung.coil == Coil::kSet) out_ << " storage=\"set\"";
    if (rung.coil == Coil::kReset) out_ << " storage=\"reset\"";
    out_ << R"( width="21" height="20"><position x=")" << x << "\" y=\"" << y
         << R"("/><connectionPointIn><relPosition x="0" y="10"/>)";
    wires(power, x, y + 10);
    out_ << R"(</connectionPointIn><connectionPointOut><relPosition x="21" y="10"/></connectionPointOut><variable>)"
         << variable_name(Type::kBool, rung.target) << "</variable></coil>\n";
    return out;
  }

  static constexpr std::size_t kRungsPerRail = 50;
  static constexpr int kRightRail = 2400;

  std::ostream& out_;
  std::uint64_t next_id_ = 1;
  std::uint64_t left_id_ = 0;
  std::vector<Point> powered_;  ///< coils that still need their right rail
  int y_ = 40;
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

}  // namespace

void write_plcopen(const Program& program, std::ostream& out) {
  out << "<?xml version='1.0' encoding='utf-8'?>\n"
         "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\" xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">\n"
         "<fileHeader companyName=\"PICARD\" productName=\"plc-bench\" productVersion=\"1\" "
         "creationDateTime=\"2024-01-01T00:00:00\"/>\n"
         "<contentHeader name=\"bench\"><coordinateInfo><fbd><scaling x=\"10\" y=\"10\"/></fbd><ld><scaling x=\"10\" "
         "y=\"10\"/></ld><sfc><scaling x=\"10\" y=\"10\"/></sfc></coordinateInfo></contentHeader>\n"
         "<types><dataTypes/><pous><pou name=\"Drawn\" pouType=\"program\"><interface><localVars>\n";
  constexpr const char* kTypeNames[kTypes] = {"BOOL", "DINT", "REAL"};
  for (std::size_t t = 0; t < kTypes; ++t) {
    for (std::uint32_t i = 0; i < program.variables[t].count; ++i) {
      declare(out, variable_name(static_cast<Type>(t), i), kTypeNames[t], false);
    }
  }
  for (std::size_t b = 1; b < kBoxes; ++b) {
    for (std::uint32_t i = 0; i < program.instances[b]; ++i) {
      declare(out, instance_name(static_cast<Box>(b), i), kBoxNames[b], true);
    }
  }
  const char* language = program.shape.kind == Kind::kArithmetic ? "FBD" : "LD";
  out << "</localVars></interface><body><" << language << ">\n";
  Drawing drawing(out);
  for (const auto& rung : program.rungs) std::visit([&](const auto& drawn) { drawing.draw(drawn); }, rung);
  drawing.rails();
  out << "</" << language
      << "></body></pou></pous></types>\n"
         "<instances><configurations><configuration name=\"Config0\"><resource name=\"Res0\">"
         "<task name=\"task0\" priority=\"0\" interval=\"T#20ms\"><pouInstance name=\""
      << kInstanceName
      << "\" typeName=\"Drawn\"/></task></resource></configuration></configurations></instances>\n</project>\n";
}

}  // namespace plc::bench
