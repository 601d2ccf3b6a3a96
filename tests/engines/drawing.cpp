#include "tests/engines/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "stdlib/library.h"
#include "tests/support/random_values.h"

namespace plc::test {
namespace {

using core::TypeId;

/// Where a wire comes from: an element, and the pin of a block.
struct Source {
  int id = 0;
  std::string pin{};
};
struct Declared {
  std::string name;
  std::string type;     ///< as XML
  std::string address;  ///< "%IX0.0", or empty
};
/// A block of the drawing's own, with pins of the same names in each project.
constexpr std::string_view kOwnBlock = "OWN";
constexpr TypeId kOwnTypes[] = {TypeId::kBool, TypeId::kDint, TypeId::kReal};

std::string xml_type(TypeId type) {
  if (type == TypeId::kString) return "<string length=\"10\"/>";
  if (type == TypeId::kWstring) return "<wstring length=\"10\"/>";
  return fmt::format("<{}/>", core::name_of(type));
}

/// The body of one POU, element by element, and the variables that it came to need.
class Body {
 public:
  Body(Random& random, bool ladder, bool own_block) : random_(random), ladder_(ladder), own_block_(own_block) {
    if (ladder_)
      out_ += fmt::format("<leftPowerRail localId=\"{}\">{}<connectionPointOut/></leftPowerRail>\n", ++id_, at(10));
  }

  void row() {
    ++row_;
    if (ladder_ && random_.once_in(8)) labels();
    if (ladder_ && !random_.once_in(4)) return rung();
    block(random_.once_in(3) ? std::vector<Source>{any_wire(TypeId::kBool)} : std::vector<Source>{});
  }
  std::string finish() {
    ++row_;
    out_variable(any_wire(TypeId::kBool), target(TypeId::kBool));  // a body without effect is an error
    for (const int label : labels_) draw_label(label);
    if (ladder_) {
      out_ += fmt::format("<rightPowerRail localId=\"{}\">{}{}</rightPowerRail>\n", ++id_, at(900), point(ends_));
    }
    close_feedback();
    return fmt::format("<body><{0}>\n{1}</{0}></body>\n", ladder_ ? "LD" : "FBD", out_);
  }
  [[nodiscard]] std::string declarations() const {
    std::string text;
    for (const Declared& v : declared_) {
      text += fmt::format("<variable name=\"{}\"{}><type>{}</type></variable>\n", v.name,
                          v.address.empty() ? "" : fmt::format(" address=\"{}\"", v.address), v.type);
    }
    return text;
  }
  /// Inputs and outputs of the block of its own are variables as well.
  void add_variable(TypeId type, std::string name) { variables_[number(type)].push_back(std::move(name)); }

 private:
  static std::size_t number(TypeId type) { return static_cast<std::size_t>(type); }
  [[nodiscard]] std::string at(int x) const { return fmt::format("<position x=\"{}\" y=\"{}\"/>", x, 100 * row_ + 10); }
  [[nodiscard]] std::string below() { return ++row_, at(10); }

  static std::string point(const std::vector<Source>& sources) {
    std::string text = "<connectionPointIn>";
    for (const Source& s : sources) {
      if (s.id == kLater) {
        text += "<connection " + s.pin + "/>";
        continue;
      }
      text += fmt::format("<connection refLocalId=\"{}\"{}/>", s.id,
                          s.pin.empty() ? "" : fmt::format(" formalParameter=\"{}\"", s.pin));
    }
    return text + "</connectionPointIn>";
  }

  std::string declare(std::string type, std::string address = {}) {
    declared_.push_back({fmt::format("v{}", declared_.size()), std::move(type), std::move(address)});
    return declared_.back().name;
  }
  std::string variable(TypeId type) {
    std::vector<std::string>& known = variables_[number(type)];
    if (known.size() < 4 && (known.empty() || random_.once_in(3))) {
      std::string address;
      if (!own_block_ && type == TypeId::kBool && random_.once_in(3)) {
        address = fmt::format("%{}X{}.{}", random_.once_in(2) ? 'I' : 'M', addresses_ / 8, addresses_ % 8);
        ++addresses_;
      }
      known.push_back(declare(xml_type(type), address));
    }
    return random_.one_of(known);
  }
  /// One that may be written.
  std::string target(TypeId type) {
    for (;;) {
      const std::string name = variable(type);
      const bool input = std::any_of(declared_.begin(), declared_.end(),
                                     [&](const Declared& d) { return d.name == name && d.address.starts_with("%I"); });
      if (!input && !name.starts_with('I')) return name;
      variables_[number(type)].push_back(declare(xml_type(type)));
    }
  }

  Source in_variable(const std::string& expression, bool negated = false) {
    out_ +=
        fmt::format("<inVariable localId=\"{}\"{}>{}<connectionPointOut/><expression>{}</expression></inVariable>\n",
                    ++id_, negated ? " negated=\"true\"" : "", at(20), expression);
    return {id_};
  }
  void out_variable(const Source& from, const std::string& name, std::string_view attributes = {}) {
    out_ += fmt::format("<outVariable localId=\"{}\"{}>{}{}<expression>{}</expression></outVariable>\n", ++id_,
                        attributes, at(400), point({from}), name);
  }
  /// A wire from something further down: which is known at the end.
  static constexpr int kLater = -1;
  Source feedback() {
    open_.push_back(fmt::format("@{}@", open_.size()));
    return {kLater, open_.back()};
  }
  void close_feedback() {
    for (const std::string& mark : open_) {
      const Source from = powered_.empty() ? in_variable(variable(TypeId::kBool)) : random_.one_of(powered_);
      const std::string text = fmt::format("refLocalId=\"{}\"{}", from.id,
                                           from.pin.empty() ? "" : fmt::format(" formalParameter=\"{}\"", from.pin));
      for (std::size_t at = out_.find(mark); at != std::string::npos; at = out_.find(mark, at)) {
        out_.replace(at, mark.size(), text);
      }
    }
  }

  /// A value of this type: what a block above gave, or a variable.
  Source any_wire(TypeId type) {
    const auto& wires = wires_[number(type)];
    if (type == TypeId::kBool && !wires.empty() && random_.once_in(16)) return feedback();
    if (!wires.empty() && random_.once_in(3)) return random_.one_of(wires);
    return in_variable(variable(type), type == TypeId::kBool && random_.once_in(5));
  }

  // ---- ladder

  void rung() {
    std::vector<Source> power = {{1}};
    for (std::size_t n = 1 + random_.below(4); n > 0; --n) {
      power = random_.once_in(5) ? std::vector<Source>{block(power)} : contacts(power);
    }
    if (random_.once_in(12)) {
      const bool back = !back_.empty() && random_.once_in(3);
      const int label = back ? random_.one_of(back_) : row_;
      if (!back) labels_.push_back(label);
      out_ += fmt::format("<jump localId=\"{}\" label=\"L{}\">{}{}</jump>\n", ++id_, label, at(700), point(power));
      return;
    }
    if (random_.once_in(40)) {
      out_ += fmt::format("<return localId=\"{}\">{}{}</return>\n", ++id_, at(700), point(power));
      return;
    }
    for (std::size_t n = 1 + random_.below(2); n > 0; --n) {
      static constexpr std::string_view kKinds[] = {"",
                                                    "",
                                                    "",
                                                    " negated=\"true\"",
                                                    " storage=\"set\"",
                                                    " storage=\"reset\"",
                                                    " edge=\"rising\"",
                                                    " edge=\"falling\""};
      out_ += fmt::format("<coil localId=\"{}\"{}>{}{}<connectionPointOut/><variable>{}</variable></coil>\n", ++id_,
                          random_.one_of(kKinds), at(800), point(power), target(TypeId::kBool));
      ends_.push_back({id_});
      if (random_.once_in(3)) power = {{id_}};
    }
  }
  /// Labels one below the other: of jumps above, and sometimes one that rungs below jump back to.
  void labels() {
    while (!labels_.empty() && !random_.once_in(3)) {
      draw_label(labels_.back());
      labels_.pop_back();
    }
    if (!random_.once_in(4)) return;
    back_.push_back(1000 + row_);
    draw_label(back_.back());
  }
  void draw_label(int label) {
    out_ += fmt::format("<label localId=\"{}\" label=\"L{}\">{}</label>\n", ++id_, label, below());
  }
  std::vector<Source> contacts(const std::vector<Source>& power) {
    std::vector<Source> made;
    for (std::size_t n = 1 + random_.below(random_.once_in(2) ? 3 : 1); n > 0; --n) {
      static constexpr std::string_view kKinds[] = {
          "", "", "", " negated=\"true\"", " negated=\"true\"", " edge=\"rising\"", " edge=\"falling\""};
      out_ += fmt::format("<contact localId=\"{}\"{}>{}{}<connectionPointOut/><variable>{}</variable></contact>\n",
                          ++id_, random_.one_of(kKinds), at(100), point(power), variable(TypeId::kBool));
      made.push_back({id_});
    }
    return made;
  }

  // ---- blocks

  /// A block with `power` at EN or its first BOOL; returns what goes on from there.
  Source block(const std::vector<Source>& power) {
    if (own_block_ && random_.once_in(5)) return own_block(power);
    if (random_.once_in(3)) return instance(power);
    return function(power);
  }
  struct Pin {
    std::string name;
    std::vector<Source> from;
    bool negated = false;
  };
  /// Draws a block and gives its number.
  int draw(std::string_view type, const std::string& instance, const std::vector<Pin>& inputs,
           const std::vector<std::string>& outputs) {
    const int id = ++id_;
    out_ += fmt::format("<block localId=\"{}\" typeName=\"{}\"{}>{}<inputVariables>\n", id, type,
                        instance.empty() ? "" : fmt::format(" instanceName=\"{}\"", instance), at(200));
    for (const Pin& pin : inputs) {
      out_ += fmt::format("<variable formalParameter=\"{}\"{}>{}</variable>\n", pin.name,
                          pin.negated ? " negated=\"true\"" : "", point(pin.from));
    }
    out_ += "</inputVariables><inOutVariables/><outputVariables>\n";
    for (const std::string& name : outputs) {
      out_ += fmt::format("<variable formalParameter=\"{}\"><connectionPointOut/></variable>\n", name);
    }
    out_ += "</outputVariables></block>\n";
    return id;
  }
  Pin pin(std::string name, TypeId type) {
    return {std::move(name), {any_wire(type)}, type == TypeId::kBool && random_.once_in(5)};
  }
  void give(int id, const std::string& name, TypeId type) {
    wires_[number(type)].push_back({id, name});
    if (!random_.once_in(4)) out_variable({id, name}, target(type));
  }

  Source function(const std::vector<Source>& power) {
    // Most overloads are conversions; most of what people draw is not.
    static constexpr std::string_view kCommon[] = {"ADD", "SUB",   "MUL", "DIV", "MOD", "AND", "OR",   "XOR",
                                                   "NOT", "GT",    "GE",  "EQ",  "NE",  "LE",  "LT",   "SEL",
                                                   "MUX", "LIMIT", "MIN", "MAX", "ABS", "SHL", "MOVE", "ROR"};
    const stdlib::Overload* overload = nullptr;
    do {
      const auto overloads =
          random_.once_in(3) ? stdlib::overloads() : stdlib::overloads_named(random_.one_of(kCommon));
      overload = &overloads[random_.below(overloads.size())];
    } while (stdlib::is_bundle_output(*overload->spec));
    std::vector<Pin> inputs;
    if (!power.empty()) inputs.push_back({"EN", power});
    const std::size_t count = overload->spec->param_count + (overload->spec->extensible ? random_.below(3) : 0);
    for (std::size_t i = 0; i < count; ++i) {
      inputs.push_back(pin(stdlib::pin_name(*overload->spec, i), overload->param_type(i)));
    }
    const int id = draw(overload->name, {}, inputs, {"OUT", "ENO"});
    give(id, "OUT", overload->result_type());
    if (random_.once_in(2)) {
      give(id, "ENO", TypeId::kBool);
      powered_.push_back({id, "ENO"});
    }
    return {id, "ENO"};
  }
  /// Where an instance is: a variable, or an element of an array, perhaps one that the running program finds.
  std::string place_of(std::string_view type) {
    const std::string one = fmt::format("<derived name=\"{}\"/>", type);
    if (!random_.once_in(6)) return declare(one);
    const std::string index = random_.once_in(2) ? std::string("1") : variable(TypeId::kDint);
    return fmt::format(
        "{}[{}]",
        declare(fmt::format("<array><dimension lower=\"0\" upper=\"2\"/><baseType>{}</baseType></array>", one)), index);
  }
  Source instance(const std::vector<Source>& power) {
    static constexpr std::string_view kCommon[] = {"TON", "TOF", "TP",     "CTU",    "CTD", "CTUD",
                                                   "SR",  "RS",  "R_TRIG", "F_TRIG", "TON", "R_TRIG"};
    const stdlib::BlockSpec& spec = random_.once_in(4) ? stdlib::blocks()[random_.below(stdlib::blocks().size())]
                                                       : *stdlib::block_named(random_.one_of(kCommon));
    std::vector<Pin> inputs;
    std::vector<std::string> outputs;
    Source next;
    for (const stdlib::Field& field : spec.fields) {
      if (field.direction == stdlib::Direction::kOutput) outputs.emplace_back(field.name);
      if (field.direction != stdlib::Direction::kInput) continue;
      const bool first = inputs.empty() && field.type == TypeId::kBool && !power.empty();
      if (first) inputs.push_back({std::string(field.name), power});
      if (!first && !random_.once_in(8)) inputs.push_back(pin(std::string(field.name), field.type));
    }
    const bool en = random_.once_in(8);
    if (en) {
      inputs.insert(inputs.begin(), {"EN", {any_wire(TypeId::kBool)}});
      outputs.emplace_back("ENO");
    }
    const int id = draw(spec.name, place_of(spec.name), inputs, outputs);
    for (const stdlib::Field& field : spec.fields) {
      if (field.direction != stdlib::Direction::kOutput) continue;
      give(id, std::string(field.name), field.type);
      if (field.type == TypeId::kBool) powered_.push_back({id, std::string(field.name)});
      if (next.id == 0 && field.type == TypeId::kBool) next = {id, std::string(field.name)};
    }
    return next.id != 0 ? next : in_variable(variable(TypeId::kBool));
  }
  /// The project's block, or a taskblock.
  Source own_block(const std::vector<Source>& power) {
    if (random_.once_in(4)) {
      const int id = draw("LOWPASS", declare("<derived name=\"LOWPASS\"/>"),
                          {pin("IN", TypeId::kLreal), pin("CUTOFF", TypeId::kLreal)}, {"OUT"});
      give(id, "OUT", TypeId::kLreal);
      return in_variable(variable(TypeId::kBool));
    }
    std::vector<Pin> inputs;
    std::vector<std::string> outputs;
    for (const TypeId type : kOwnTypes) {
      inputs.push_back(pin(fmt::format("I{}", core::name_of(type)), type));
      outputs.push_back(fmt::format("O{}", core::name_of(type)));
    }
    if (!power.empty()) inputs[0] = {inputs[0].name, power};
    const int id = draw(kOwnBlock, declare(fmt::format("<derived name=\"{}\"/>", kOwnBlock)), inputs, outputs);
    for (std::size_t n = 0; n < std::size(kOwnTypes); ++n) give(id, outputs[n], kOwnTypes[n]);
    return {id, outputs[0]};
  }

  Random& random_;
  bool ladder_;
  bool own_block_;  ///< the project has one
  std::string out_;
  int id_ = 0, row_ = 0, addresses_ = 0;
  std::vector<int> labels_;        ///< of jumps that wait for them
  std::vector<int> back_;          ///< that are drawn already
  std::vector<std::string> open_;  ///< marks of feedback wires
  std::vector<Source> powered_;    ///< outputs that are BOOL whatever is wired to their block
  std::vector<Source> ends_;
  std::vector<Declared> declared_;
  std::array<std::vector<std::string>, core::kTypeCount> variables_;
  std::array<std::vector<Source>, core::kTypeCount> wires_;
};

std::string pou(std::string_view name, std::string_view kind, const std::string& parameters, Body& body) {
  const std::string drawn = body.finish();
  return fmt::format("<pou name=\"{}\" pouType=\"{}\"><interface>{}<localVars>\n{}</localVars></interface>{}</pou>\n",
                     name, kind, parameters, body.declarations(), drawn);
}

}  // namespace

std::string random_drawing(std::uint64_t seed) {
  Random random(seed);
  std::string pous;
  Body own(random, random.once_in(2), false);
  std::string inputs, outputs;
  for (const TypeId type : kOwnTypes) {
    const std::string name(core::name_of(type));
    own.add_variable(type, "I" + name);
    own.add_variable(type, "O" + name);
    inputs += fmt::format("<variable name=\"I{}\"><type>{}</type></variable>", name, xml_type(type));
    outputs += fmt::format("<variable name=\"O{}\"><type>{}</type></variable>", name, xml_type(type));
  }
  for (std::size_t n = 1 + random.below(5); n > 0; --n) own.row();
  pous += pou(kOwnBlock, "functionBlock",
              fmt::format("<inputVars>{}</inputVars><outputVars>{}</outputVars>", inputs, outputs), own);
  Body main(random, !random.once_in(3), true);
  for (std::size_t n = 2 + random.below(10); n > 0; --n) main.row();
  pous += pou("MAIN", "program", {}, main);
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">\n"
      "<fileHeader companyName=\"PICARD\" productName=\"test\" productVersion=\"1\" "
      "creationDateTime=\"2024-01-01T00:00:00\"/>\n<contentHeader name=\"drawing\"><coordinateInfo>"
      "<fbd><scaling x=\"1\" y=\"1\"/></fbd><ld><scaling x=\"1\" y=\"1\"/></ld><sfc><scaling x=\"1\" y=\"1\"/></sfc>"
      "</coordinateInfo></contentHeader>\n<types><dataTypes/><pous>\n{}</pous></types>\n<instances><configurations>"
      "<configuration name=\"c\"><resource name=\"r\"><task name=\"t\" interval=\"T#10ms\" priority=\"0\">"
      "<pouInstance name=\"main\" typeName=\"MAIN\"/></task></resource></configuration></configurations></instances>\n"
      "</project>\n",
      pous);
}

}  // namespace plc::test
