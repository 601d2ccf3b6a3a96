#include "bench/drawn_text.h"

#include <fmt/format.h>

#include <variant>

namespace plc::bench {
namespace {

/// Children that are nets are in parentheses; NOT binds more than AND, that more than OR.
void write_net(const Net& net, std::string& out) {
  if (net.kind == Net::Kind::kContact) {
    out += (net.negated ? "NOT " : "") + variable_name(Type::kBool, net.variable);
    return;
  }
  for (std::size_t i = 0; i < net.children.size(); ++i) {
    if (i != 0) out += net.kind == Net::Kind::kSeries ? " AND " : " OR ";
    const bool nested = net.children[i].kind != Net::Kind::kContact;
    if (nested) out += '(';
    write_net(net.children[i], out);
    if (nested) out += ')';
  }
}

/// The call of the block; what it gives.
std::string write_box(const Rung& rung, const std::string& power, std::string& out) {
  const std::string name = instance_name(rung.box, rung.instance);
  if (is_timer(rung.box)) {
    out += fmt::format("{}(IN := {}, PT := T#{}ms);\n", name, power, rung.preset);
  } else if (is_counter(rung.box)) {
    const bool up = rung.box == Box::kCtu;
    out += fmt::format("{}({} := {}, {} := {}, PV := {});\n", name, up ? "CU" : "CD", power, up ? "R" : "LD",
                       variable_name(Type::kBool, rung.reset), rung.preset);
  } else {
    out += fmt::format("{}(CLK := {});\n", name, power);
  }
  return name + ".Q";
}

void write(const Rung& rung, std::string& out) {
  std::string power;
  write_net(rung.net, power);
  if (rung.box != Box::kNone) power = write_box(rung, power, out);
  const std::string target = variable_name(Type::kBool, rung.target);
  switch (rung.coil) {
    case Coil::kNormal:
      out += fmt::format("{} := {};\n", target, power);
      break;
    case Coil::kNegated:
      out += fmt::format("{} := NOT ({});\n", target, power);
      break;
    case Coil::kSet:
    case Coil::kReset:
      out += fmt::format("IF {} THEN {} := {}; END_IF;\n", power, target, rung.coil == Coil::kSet ? "TRUE" : "FALSE");
  }
}

void write(const Chain& chain, std::string& out) {
  const auto text = [&](const Operand& operand) {
    return operand.constant.empty() ? variable_name(chain.type, operand.variable) : operand.constant;
  };
  std::string value = text(chain.start);
  for (std::size_t i = 0; i < chain.links.size(); ++i) {
    const Link& link = chain.links[i];
    const std::string second = text(link.operand);
    switch (link.function) {
      case Function::kAdd:
        value = fmt::format("({} + {})", value, second);
        break;
      case Function::kSub:
        value = fmt::format("({} - {})", value, second);
        break;
      case Function::kMul:
        value = fmt::format("({} * {})", value, second);
        break;
      case Function::kMin:
        value = fmt::format("MIN({}, {})", value, second);
        break;
      case Function::kMax:
        value = fmt::format("MAX({}, {})", value, second);
        break;
      case Function::kLimit:
        value = fmt::format("LIMIT({}, {}, {})", second, value, text(link.maximum));
        break;
      case Function::kSel:
        value = fmt::format("SEL({}, {}, {})", variable_name(Type::kBool, link.gate), value, second);
    }
    if (i != chain.kept_at) continue;
    const std::string kept = variable_name(chain.type, chain.kept);
    out += fmt::format("{} := {};\n", kept, value);
    value = kept;
  }
  out += fmt::format("{} := {};\n", variable_name(chain.type, chain.target), value);
}

}  // namespace

std::string write_st(const Program& program) {
  std::string out = "PROGRAM Drawn\nVAR\n";
  constexpr const char* kTypeNames[kTypes] = {"BOOL", "DINT", "REAL"};
  for (std::size_t t = 0; t < kTypes; ++t) {
    for (std::uint32_t i = 0; i < program.variables[t].count; ++i)
      out += fmt::format("  {} : {};\n", variable_name(static_cast<Type>(t), i), kTypeNames[t]);
  }
  for (std::size_t b = 1; b < kBoxes; ++b) {
    for (std::uint32_t i = 0; i < program.instances[b]; ++i)
      out += fmt::format("  {} : {};\n", instance_name(static_cast<Box>(b), i), kBoxNames[b]);
  }
  out += "END_VAR\n";
  for (const auto& rung : program.rungs) std::visit([&](const auto& drawn) { write(drawn, out); }, rung);
  return out + fmt::format(
                   "END_PROGRAM\n\nCONFIGURATION Config0\n  RESOURCE Res0 ON PLC\n"
                   "    TASK task0(INTERVAL := T#20ms, PRIORITY := 0);\n    PROGRAM {} WITH task0 : Drawn;\n"
                   "  END_RESOURCE\nEND_CONFIGURATION\n",
                   kInstanceName);
}

}  // namespace plc::bench
