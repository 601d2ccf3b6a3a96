// Small projects for the command-line tests, written where the test needs them.
#pragma once

#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "tests/support/run_tool.h"

namespace plc::test {

inline std::string tank() { return PLC_EXAMPLES "/tank/tank.xml"; }
inline std::string tank_stimulus() { return PLC_EXAMPLES "/tank/stimulus.csv"; }

inline void write_text(const std::string& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}
inline std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A ladder program "Main" with one rung, In to Out, run as instance "main" every 10 ms; `instance` false leaves the
/// configuration empty. `body` replaces the rung.
inline std::string small_project(bool instance = true, std::string_view body = {}) {
  constexpr std::string_view kRung = R"(<LD>
<leftPowerRail localId="1"><position x="0" y="0"/><connectionPointOut formalParameter=""/></leftPowerRail>
<contact localId="2"><position x="50" y="0"/><connectionPointIn><connection refLocalId="1"/></connectionPointIn><connectionPointOut/><variable>In</variable></contact>
<coil localId="3"><position x="100" y="0"/><connectionPointIn><connection refLocalId="2"/></connectionPointIn><connectionPointOut/><variable>Out</variable></coil>
</LD>)";
  std::string text = R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="" productName="test" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="small"><coordinateInfo><fbd><scaling x="0" y="0"/></fbd><ld><scaling x="0" y="0"/></ld><sfc><scaling x="0" y="0"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="Main" pouType="program"><interface><localVars>
<variable name="In"><type><BOOL/></type></variable>
<variable name="Out"><type><BOOL/></type></variable>
</localVars></interface><body>
)";
  text += body.empty() ? kRung : body;
  text += "\n</body></pou></pous></types>\n<instances><configurations>";
  if (instance) {
    text +=
        R"(<configuration name="C"><resource name="R"><task name="T" priority="0" interval="T#10ms"><pouInstance name="main" typeName="Main"/></task></resource></configuration>)";
  }
  return text + "</configurations></instances>\n</project>\n";
}

/// A rung whose contact names a variable that is not declared.
constexpr std::string_view kUnknownVariableBody = R"(<LD>
<leftPowerRail localId="1"><position x="0" y="0"/><connectionPointOut formalParameter=""/></leftPowerRail>
<contact localId="2"><position x="50" y="0"/><connectionPointIn><connection refLocalId="1"/></connectionPointIn><connectionPointOut/><variable>Nowhere</variable></contact>
<coil localId="3"><position x="100" y="0"/><connectionPointIn><connection refLocalId="2"/></connectionPointIn><connectionPointOut/><variable>Out</variable></coil>
</LD>)";

}  // namespace plc::test
