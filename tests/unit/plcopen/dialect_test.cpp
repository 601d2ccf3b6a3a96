// What tools write beyond the schema: TwinCAT, CODESYS, OpenPLC v4, PLCopen Editor 1.01.
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

constexpr std::string_view kNs = "http://www.3s-software.com/plcopenxml/";

std::string data(std::string_view kind, std::string_view content) {
  return "<addData><data name=\"" + std::string(kNs) + std::string(kind) + "\" handleUnknown=\"implementation\">" +
         std::string(content) + "</data></addData>";
}

TEST(Dialect, EverythingInAddDataOfTheProject) {
  const std::string pou = data("pou",
                               "<pou name=\"Main\" pouType=\"program\"><interface/><body><ST><xhtml "
                               "xmlns=\"http://www.w3.org/1999/xhtml\">a := 1;</xhtml></ST></body></pou>");
  const std::string type = data("datatype", "<dataType name=\"T\"><baseType><INT/></baseType></dataType>");
  const auto r = read_clean(tc6(
      "<dataTypes/><pous/>", "",
      data(
          "application",
          R"(<resource name="App">
<task name="T1" interval="PT0S" priority="20"><pouInstance name="Main" typeName=""/>)" +
              data(
                  "tasksettings",
                  R"(<TaskSettings KindOfTask="Cyclic" Interval="10000" IntervalUnit="us"><Watchdog Enabled="false"/></TaskSettings>)") +
              "</task><globalVars name=\"GVL\"><variable name=\"g\"><type><BOOL/></type></variable>" +
              data("interfaceasplaintext",
                   "<InterfaceAsPlainText><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">VAR_GLOBAL g: BOOL; "
                   "END_VAR</xhtml></InterfaceAsPlainText>") +
              "</globalVars>" + pou + type + "</resource>")));
  ASSERT_EQ(r.project->pous.size(), 1u);
  EXPECT_EQ(r.project->pous[0].bodies.at(0).text, "a := 1;");
  EXPECT_EQ(r.project->data_types.size(), 1u);
  ASSERT_EQ(r.project->configurations.size(), 1u);
  EXPECT_EQ(r.project->configurations[0].name, "");
  const Resource& resource = r.project->configurations[0].resources.at(0);
  EXPECT_EQ(resource.name, "App");
  ASSERT_EQ(resource.tasks.size(), 1u);
  EXPECT_EQ(resource.tasks[0].interval, "10000");
  EXPECT_EQ(resource.tasks[0].interval_unit, "us");
  EXPECT_EQ(resource.tasks[0].kind, "Cyclic");
  EXPECT_EQ(resource.tasks[0].instances.at(0).type_name, "");
  EXPECT_EQ(resource.globals.at(0).list, "GVL");
  ASSERT_EQ(r.project->declarations.size(), 1u);
  EXPECT_EQ(r.project->declarations[0].owner, "GVL");
  EXPECT_EQ(r.project->declarations[0].text, "VAR_GLOBAL g: BOOL; END_VAR");
}

TEST(Dialect, PousAndListsDirectlyInAddData) {
  const auto r =
      read_clean(tc6("<pous/>", "",
                     data("pou", "<pou name=\"A\" pouType=\"program\"><interface/><body><ST/></body></pou>") +
                         data("globalvars", "<globalVars name=\"L\"><variable name=\"x\"/></globalVars>")));
  EXPECT_EQ(r.project->pous.size(), 1u);
  ASSERT_EQ(r.project->configurations.size(), 1u);
  EXPECT_EQ(r.project->configurations[0].globals.at(0).list, "L");
}

TEST(Dialect, PouDeepInsideUnknownVendorData) {
  const auto r = read_clean(tc6("<pous/>", "", R"(<addData><data name="urn:x"><Folder><Sub><addData><data name="urn:y">
<pou name="Deep" pouType="functionBlock"><interface/><body><ST/></body></pou></data></addData></Sub></Folder></data></addData>)"));
  ASSERT_EQ(r.project->pous.size(), 1u);
  EXPECT_EQ(r.project->pous[0].name, "Deep");
}

TEST(Dialect, PouInsideAnotherPouKeepsBothWhole) {
  const auto r = read_clean(tc6(R"(<pous><pou name="Outer" pouType="program"><interface><localVars><variable name="o1">
<addData><data name="x/pou"><pou name="Inner" pouType="functionBlock"><interface><localVars><variable name="i1"/></localVars></interface>
<body><ST>i1;</ST></body></pou></data></addData><type><INT/></type></variable><variable name="o2"/></localVars></interface><body><ST>o1;</ST></body></pou></pous>)"));
  ASSERT_EQ(r.project->pous.size(), 2u);
  EXPECT_EQ(r.project->pous[0].name, "Inner");
  ASSERT_EQ(r.project->pous[1].variables.size(), 2u);
  EXPECT_EQ(r.project->pous[1].variables[0].type.name, "INT");
  EXPECT_EQ(r.project->pous[1].bodies.at(0).text, "o1;");
}

TEST(Dialect, TaskSettingsWithUnitInTheInterval) {
  const auto r = read_clean(
      tc6("<pous/>",
          "<configuration name=\"c\"><resource name=\"r\"><task name=\"t\" priority=\"0\" interval=\"PT0.02S\">" +
              data("tasksettings", R"(<TaskSettings KindOfTask="Cyclic" Interval="t#20ms" IntervalUnit="ms"/>)") +
              "</task></resource></configuration>"));
  const Task& task = r.project->configurations.at(0).resources.at(0).tasks.at(0);
  EXPECT_EQ(task.interval, "t#20ms");
  EXPECT_EQ(task.interval_unit, "");
}

TEST(Dialect, ExecuteBoxCarriesItsCode) {
  const std::string xml =
      ladder("<block localId=\"3\" typeName=\"EXECUTE\"><inputVariables/><inOutVariables/><outputVariables/>" +
             data("stcode", "<STCode xmlns=\"\">\n  A := B &lt; C;\n</STCode>") + "</block>" +
             "<block localId=\"4\" typeName=\"EXECUTE\">" + data("stcode", "<STCode/>") + "</block>");
  const auto r = read_clean(xml);
  const Element& box = body_of(r).elements.at(0);
  EXPECT_TRUE(box.has_code);
  EXPECT_EQ(box.code, "A := B < C;");
  EXPECT_EQ(place(box.code_at), place_of(xml, "A := B"));
  EXPECT_EQ(box.code_at.local_id, 3);
  EXPECT_TRUE(body_of(r).elements.at(1).has_code);
  EXPECT_EQ(body_of(r).elements.at(1).code, "");
}

TEST(Dialect, NetworkTitlesOpenNetworks) {
  const std::string title = data("fbdelementtype", "<ElementType xmlns=\"\">networktitle</ElementType>");
  const auto r = read_clean(
      ladder("<leftPowerRail localId=\"0\"/><vendorElement localId=\"1\"><alternativeText/>" + title +
             "</vendorElement><coil localId=\"2\"><variable>a</variable></coil><vendorElement localId=\"3\">" + title +
             "</vendorElement><coil localId=\"4\"><variable>b</variable></coil>"));
  const std::vector<Element>& e = body_of(r).elements;
  ASSERT_EQ(e.size(), 3u);
  EXPECT_EQ(e[0].network, 0u);
  EXPECT_EQ(e[1].network, 1u);
  EXPECT_EQ(e[2].network, 2u);
  EXPECT_EQ(body_of(r).drawn_elements, 3u);
}

TEST(Dialect, FbdIdsCarryTheNetwork) {
  const auto r = read_clean(program(R"(<FBD><inVariable localId="20000000001"><expression>a</expression></inVariable>
<inVariable localId="10000000002"><expression>b</expression></inVariable><inVariable localId="9"><expression>c</expression></inVariable></FBD>)"));
  const std::vector<Element>& e = body_of(r).elements;
  EXPECT_EQ(e.at(0).at.local_id, 20000000001);
  EXPECT_EQ(e.at(0).network, 2u);
  EXPECT_EQ(e.at(1).network, 1u);
  EXPECT_EQ(e.at(2).network, 0u);
}

TEST(Dialect, Version1FilesAndInstancesBesideTheTask) {
  const auto r = read_clean(
      R"(<project xmlns="http://www.plcopen.org/xml/tc6.xsd"><fileHeader productName="old"/><contentHeader name="n"/>
<types><dataTypes/><pous/></types><instances><configurations><configuration name="C"><resource name="R">
<task name="t" interval="00:00:00.100000" priority="0"/><pouInstance type="P" name="i"/></resource></configuration></configurations></instances></project>)");
  EXPECT_EQ(r.project->version, Version::kTc6v101);
  const Resource& resource = r.project->configurations.at(0).resources.at(0);
  EXPECT_EQ(resource.tasks.at(0).interval, "00:00:00.100000");
  ASSERT_EQ(resource.instances.size(), 1u);
  EXPECT_EQ(resource.instances[0].type_name, "P");
}

TEST(Dialect, TextAsParagraphXhtmlOrBare) {
  for (const std::string_view body :
       {"<ST><xhtml:p><![CDATA[a := b < 1;]]></xhtml:p></ST>",
        "<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">a := b &lt; 1;</xhtml></ST>",
        "<ST>\n  a := b &lt; 1;\n</ST>", "<ST><![CDATA[]]><!-- note --><![CDATA[ a := b < 1; ]]></ST>"}) {
    const auto r = read_clean(program(body));
    EXPECT_EQ(body_of(r).text, "a := b < 1;") << body;
    EXPECT_EQ(body_of(r).language, Language::kSt);
  }
}

TEST(Dialect, PrefixedElementsReadByLocalName) {
  const auto r = read_clean(
      R"(<p:project xmlns:p="http://www.plcopen.org/xml/tc6_0200"><p:types><p:pous><p:pou name="A" pouType="program">
<p:interface/><p:body><p:ST>x;</p:ST></p:body></p:pou></p:pous></p:types></p:project>)");
  EXPECT_EQ(r.project->version, Version::kTc6v200);
  EXPECT_EQ(r.project->pous.size(), 1u);
}

TEST(Dialect, InOutPinsInBothListsStayAsWritten) {
  const auto r = read_clean(
      program(R"(<FBD><block localId="1" typeName="F"><inputVariables><variable formalParameter="X"/></inputVariables>
<inOutVariables/><outputVariables><variable formalParameter="X"/></outputVariables></block></FBD>)"));
  const Element& e = body_of(r).elements.at(0);
  EXPECT_TRUE(e.inputs.size() == 1 && e.outputs.size() == 1 && e.in_outs.empty());
}

TEST(Dialect, ObjectOrientedPartsAreRefusedWithACode) {
  const auto r =
      read_text(tc6("<pous><pou name=\"A\" pouType=\"functionBlock\"><interface/><body><ST/></body>" +
                    data("method", "<Method name=\"m\"><interface/><body><ST/></body></Method>") + "</pou></pous>"));
  EXPECT_EQ(r.codes(), "P1015");
  EXPECT_EQ(r.project->pous.at(0).bodies.size(), 1u);
}

TEST(Dialect, AttributesOfDrawnElementsInOtherCapitalsAreNamedOnce) {
  const auto r = read_text(program(R"(<LD><contact localId="1" Negated="true"/><contact localId="2" Negated="true"/>
<coil localId="3" novelty="1" Storage="set"/></LD>)"));
  EXPECT_EQ(r.codes(), "P1013 P1013");
  EXPECT_NE(r.shown().find("attribute \"Negated\" of element \"contact\" is not known and is ignored"),
            std::string::npos)
      << r.shown();
  EXPECT_NE(r.shown().find("PLCopen XML has \"storage\""), std::string::npos) << r.shown();
}

TEST(Dialect, WhatAToolCouldNotWriteIsNamedWithItsText) {
  const auto r = read_text(program(R"(<FBD><error localId="1" width="9" height="9"><position x="0" y="0"/>
<content><xhtml:p>no such box</xhtml:p></content></error></FBD>)"));
  EXPECT_EQ(r.codes(), "P1013");
  EXPECT_NE(r.shown().find("could not write: \"no such box\""), std::string::npos) << r.shown();
  EXPECT_TRUE(body_of(r).elements.empty());
}

TEST(Dialect, PinsOfAnElementAreLimited) {
  const auto block = [](std::size_t pins) {
    std::string text = "<FBD><block localId=\"1\" typeName=\"F\" instanceName=\"f\"><inputVariables>";
    for (std::size_t i = 0; i < pins; ++i) text += "<variable formalParameter=\"a\"><connectionPointIn/></variable>";
    return program(text + "</inputVariables></block></FBD>");
  };
  EXPECT_EQ(read_text(block(4096)).codes(), "");
  EXPECT_EQ(read_text(block(4097)).codes(), "P1006");
  EXPECT_EQ(read_text(block(70000)).codes(), "P1006");
}

TEST(Dialect, APositionHasBothCoordinates) {
  const auto r = read_text(program(R"(<LD><coil localId="1"><position x="5"/></coil>
<coil localId="2"><position y="5"/></coil></LD>)"));
  EXPECT_EQ(r.codes(), "P1009 P1009");
}

TEST(Dialect, JumpsAreNegatedInDataOfTheToolToo) {
  const auto r = read_clean(
      program("<FBD><jump localId=\"1\" label=\"L\">" +
              data("www.bachmann.at/plc/plcopenxml", "<negated value=\"true\"/>") + "</jump><return localId=\"2\">" +
              data("www.bachmann.at/plc/plcopenxml", "<negated value=\"false\"/>") + "</return></FBD>"));
  EXPECT_TRUE(body_of(r).elements.at(0).negated);
  EXPECT_FALSE(body_of(r).elements.at(1).negated);
}

TEST(Dialect, UnknownElementsAreReportedOncePerName) {
  const auto r = read_text(tc6("<pous/><novelty/><novelty><inside/></novelty>"));
  EXPECT_EQ(r.codes(), "P1013");
  ASSERT_NE(r.row("types/novelty"), nullptr);
  EXPECT_EQ(r.row("types/novelty")->count, 2u);
  EXPECT_EQ(r.row("types/novelty")->fate, Fate::kIgnored);
  EXPECT_EQ(r.row("types/novelty/inside")->count, 1u);
}

}  // namespace
}  // namespace plc::plcopen
