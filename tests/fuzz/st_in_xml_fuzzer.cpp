// Any text as the ST body of a program in PLCopen XML, and as its plain declaration: the whole way of it ends in a
// verified image or in messages.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "frontend-st/read.h"
#include "plcopen/reader.h"
#include "tests/fuzz/compile_project.h"

namespace {

constexpr const char* kHead = R"(<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><dataTypes>
<dataType name="Color"><baseType><enum><values><value name="Red"/><value name="Green"/></values></enum></baseType></dataType>
<dataType name="Point"><baseType><struct><variable name="x"><type><REAL/></type></variable><variable name="n"><type><string length="5"/></type></variable></struct></baseType></dataType>
</dataTypes><pous>
<pou name="f" pouType="function"><interface><returnType><INT/></returnType><inputVars><variable name="in"><type><INT/></type></variable></inputVars>
<inOutVars><variable name="io"><type><INT/></type></variable></inOutVars><outputVars><variable name="out"><type><INT/></type></variable></outputVars></interface>
<body><ST><xhtml>f := in + 1; out := in; io := io + 1;</xhtml></ST></body></pou>
<pou name="fb" pouType="functionBlock"><interface><inputVars><variable name="in"><type><BOOL/></type></variable></inputVars>
<outputVars><variable name="out"><type><BOOL/></type></variable></outputVars></interface><body><ST><xhtml>out := NOT in;</xhtml></ST></body></pou>
<pou name="p" pouType="program"><interface><localVars>
<variable name="a"><type><BOOL/></type></variable><variable name="i"><type><INT/></type></variable><variable name="d"><type><DINT/></type></variable>
<variable name="w"><type><WORD/></type></variable><variable name="r"><type><REAL/></type></variable><variable name="t"><type><TIME/></type></variable>
<variable name="s"><type><string length="9"/></type></variable><variable name="c"><type><derived name="Color"/></type></variable>
<variable name="q"><type><derived name="Point"/></type></variable><variable name="k"><type><derived name="TON"/></type></variable>
<variable name="b"><type><derived name="fb"/></type></variable><variable name="z"><type><pointer><baseType><INT/></baseType></pointer></type></variable>
<variable name="m"><type><array><dimension lower="0" upper="3"/><dimension lower="1" upper="2"/><baseType><INT/></baseType></array></type></variable>
</localVars></interface><body><ST><xhtml><![CDATA[)";
constexpr const char* kTail = R"(]]></xhtml></ST></body></pou></pous></types><instances><configurations>
<configuration name="c"><resource name="r"><task name="t" interval="T#1ms" priority="0"><pouInstance name="p" typeName="p"/></task></resource></configuration>
</configurations></instances></project>)";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  std::string text(reinterpret_cast<const char*>(data), size);
  // Reading of XML has a fuzzer of its own: here the text arrives as it is, but for what ends CDATA.
  for (std::size_t i = text.find("]]>"); i != std::string::npos; i = text.find("]]>", i)) text[i] = ' ';
  core::Diagnostics diagnostics;
  const auto project = plcopen::read_memory(kHead + text + kTail, "input.xml", diagnostics);
  if (project == nullptr) return 0;
  core::SourceRef at;
  at.line = at.column = 1;
  project->declarations.push_back({"f", false, text, at});
  core::Diagnostics ignored;
  const auto plain = plcopen::read_memory(std::string(kHead) + kTail, "plain.xml", ignored);
  if (plain == nullptr) std::abort();
  plain->pous.back().variables.clear();
  plain->declarations.push_back({"p", false, text, at});
  plain->declarations.push_back({"GVL", true, text, at});
  st::read_plain_declarations(*plain, ignored);
  st::read_plain_declarations(*project, diagnostics);
  test::compile_project(*plain, ignored);
  test::compile_project(*project, diagnostics);
  return 0;
}
