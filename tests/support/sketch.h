// Sketch: drawn bodies in few words, for tests that look at what a drawing does.
//
// In: one call per element; modifiers stand in front of its text or the names of its pins: ! negated, ^ rising,
// ~ falling edge, (S) and (R) storage. Wires are localIds: "2", several that meet "2|5", of an output "2.Q". Out: a
// Body, elements one below the other unless they are moved. Does not belong here: declarations (drawn.h).
#pragma once

#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/body_builder.h"

namespace plc::test {

class Sketch {
 public:
  using Kind = core::ElementKind;
  using Element = plcopen::Element;

  explicit Sketch(plcopen::Language language = plcopen::Language::kFbd) : builder_(language) {}

  Element& rail(std::int64_t id) { return add(Kind::kLeftRail, id, ""); }
  Element& right_rail(std::int64_t id, const std::string& from) { return add(Kind::kRightRail, id, "", from); }
  Element& contact(std::int64_t id, const std::string& text, const std::string& from) {
    return add(Kind::kContact, id, text, from);
  }
  Element& coil(std::int64_t id, const std::string& text, const std::string& from) {
    return add(Kind::kCoil, id, text, from);
  }
  Element& in(std::int64_t id, const std::string& text) { return add(Kind::kInVariable, id, text); }
  Element& out(std::int64_t id, const std::string& text, const std::string& from) {
    return add(Kind::kOutVariable, id, text, from);
  }
  Element& in_out(std::int64_t id, const std::string& text, const std::string& from = "") {
    return add(Kind::kInOutVariable, id, text, from);
  }
  Element& connector(std::int64_t id, const std::string& name, const std::string& from) {
    return add(Kind::kConnector, id, name, from);
  }
  Element& continuation(std::int64_t id, const std::string& name) { return add(Kind::kContinuation, id, name); }
  Element& label(std::int64_t id, const std::string& name) { return add(Kind::kLabel, id, name); }
  Element& jump(std::int64_t id, const std::string& name, const std::string& from = "") {
    return add(Kind::kJump, id, name, from);
  }
  Element& ret(std::int64_t id, const std::string& from = "") { return add(Kind::kReturn, id, "", from); }

  /// `type` is "TON" or "TON timer"; pins stand between blanks: inputs "!IN=2 PT:=T#1s", outputs "Q ET=>elapsed".
  Element& block(std::int64_t id, const std::string& type, const std::string& inputs, const std::string& outputs,
                 const std::string& in_outs = "") {
    Element& e = add(Kind::kBlock, id, "");
    std::istringstream words(type);
    words >> e.text >> e.instance_name;
    for (const std::string& word : split(inputs)) e.inputs.push_back(pin(e, word));
    for (const std::string& word : split(outputs)) e.outputs.push_back(pin(e, word));
    for (const std::string& word : split(in_outs)) e.in_outs.push_back(pin(e, word));
    return e;
  }
  /// An EXECUTE box.
  Element& execute(std::int64_t id, const std::string& code, const std::string& inputs, const std::string& outputs) {
    Element& e = block(id, "EXECUTE", inputs, outputs);
    e.has_code = true;
    e.code = code;
    e.code_at = e.at;
    return e;
  }
  /// Actions are "N Motor" or "L Lamp T#2s"; one without a name begins with its ST in braces: "P {n := n + 1;}".
  Element& actions(std::int64_t id, const std::string& from, const std::vector<std::string>& actions) {
    Element& e = add(Kind::kActionBlock, id, "", from);
    for (const std::string& text : actions) {
      plcopen::ActionLink action;
      action.at = action.text_at = e.at;
      const std::size_t begin = text.find('{');
      std::istringstream words(text.substr(0, begin));
      words >> action.qualifier >> action.name >> action.duration;
      if (begin != std::string::npos) {
        action.text = text.substr(begin + 1, text.rfind('}') - begin - 1);
        if (action.name.rfind("T#", 0) == 0) std::swap(action.name, action.duration);
      }
      if (action.qualifier == "-") action.qualifier.clear();
      if (action.name == "-") action.name.clear();
      e.actions.push_back(std::move(action));
    }
    return e;
  }

  /// The mark of a closed branch: where its lines leave, and the end of each.
  plcopen::ClosedBranch& close(std::int64_t id, bool short_circuit, const std::string& input,
                               const std::vector<std::string>& lines) {
    plcopen::ClosedBranch& branch = closed_branches_.emplace_back();
    branch.local_id = id;
    branch.short_circuit = short_circuit;
    wire(branch.input, input);
    for (const std::string& line : lines) wire(branch.lines.emplace_back(), line);
    return branch;
  }

  [[nodiscard]] plcopen::Body body() const {
    plcopen::Body body = builder_.body();
    body.closed_branches = closed_branches_;
    return body;
  }

 private:
  static std::vector<std::string> split(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
  }

  /// Takes the modifiers from the front of `text`.
  template <class Modified>
  static std::string modify(std::string_view text, Modified& what) {
    for (;; text.remove_prefix(1)) {
      const bool storage = text.rfind("(S)", 0) == 0 || text.rfind("(R)", 0) == 0;
      if (text.rfind('!', 0) == 0) {
        what.negated = true;
      } else if (text.rfind('^', 0) == 0) {
        what.edge = plcopen::Edge::kRising;
      } else if (text.rfind('~', 0) == 0) {
        what.edge = plcopen::Edge::kFalling;
      } else if (storage) {
        what.storage = text[1] == 'S' ? plcopen::Storage::kSet : plcopen::Storage::kReset;
        text.remove_prefix(2);
      } else {
        return std::string(text);
      }
    }
  }

  static void wire(plcopen::Pin& pin, const std::string& from) {
    std::istringstream in(from);
    for (std::string one; std::getline(in, one, '|');) {
      const std::size_t dot = one.find('.');
      plcopen::Connection& c = pin.connections.emplace_back();
      c.ref_local_id = std::stoll(one);
      if (dot != std::string::npos) c.formal_parameter = one.substr(dot + 1);
      c.at = pin.at;
    }
  }

  static plcopen::Pin pin(const Element& e, const std::string& word) {
    plcopen::Pin p;
    p.at = p.target_at = e.at;
    const std::size_t target = word.find("=>");
    const std::size_t text = word.find(":=");
    const std::size_t wires = word.find('=');
    if (target != std::string::npos) {
      p.target = word.substr(target + 2);
      p.name = word.substr(0, target);
    } else if (text != std::string::npos) {
      p.expression = word.substr(text + 2);
      p.name = word.substr(0, text);
    } else {
      p.name = word.substr(0, wires);
      if (wires != std::string::npos) wire(p, word.substr(wires + 1));
    }
    p.name = modify(p.name, p);
    return p;
  }

  Element& add(Kind kind, std::int64_t id, const std::string& text, const std::string& from = "") {
    Element& e = builder_.add(kind, id, "", 0, ++row_ * 10);
    e.text = modify(text, e);
    if (!from.empty()) wire(BodyBuilder::pin(e, "", {}), from);
    return e;
  }

  BodyBuilder builder_;
  std::vector<plcopen::ClosedBranch> closed_branches_;
  std::int32_t row_ = 0;
};

}  // namespace plc::test
