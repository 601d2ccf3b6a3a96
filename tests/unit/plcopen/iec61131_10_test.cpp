// The spelling of IEC 61131-10.
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

std::string project(std::string_view pous, std::string_view instances = "") {
  return "<Project xmlns=\"www.iec.ch/public/TC65SC65BWG7TF10\" "
         "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
         "xmlns:ext=\"urn:vendor\" schemaVersion=\"1\"><FileHeader productName=\"tool\"/><ContentHeader "
         "name=\"demo\"/><Types><GlobalNamespace>" +
         std::string(pous) + "</GlobalNamespace></Types><Instances>" + std::string(instances) +
         "</Instances></Project>";
}
std::string with_body(std::string_view contents) {
  return project("<Program name=\"Main\"><MainBody>" + std::string(contents) + "</MainBody></Program>");
}

TEST(Iec10, LadderWiresNameOutputPointsPerRung) {
  const auto r = read_clean(with_body(R"(<BodyContent xsi:type="ext:LdSection" name="S1" evaluationOrder="1">
<Rung evaluationOrder="1"><CommonObject xsi:type="Comment"><Content xsi:type="SimpleText">start</Content></CommonObject>
<LdObject xsi:type="LeftPowerRail"><ConnectionPointOut connectionPointOutId="1"/><ConnectionPointOut connectionPointOutId="2"/></LdObject>
<LdObject xsi:type="Contact" operand="a" negated="true" edge="rising"><RelPosition x="3" y="4"/><ConnectionPointIn><Connection refConnectionPointOutId="1"/></ConnectionPointIn><ConnectionPointOut connectionPointOutId="3"/></LdObject>
<LdObject xsi:type="CompareContact" operand1="x" operand2="y+1" compareOperator="&gt;="><ConnectionPointIn><Connection refConnectionPointOutId="2"/></ConnectionPointIn><ConnectionPointOut connectionPointOutId="4"/></LdObject>
<LdObject xsi:type="Coil" operand="q" latch="set"><ConnectionPointIn><Connection refConnectionPointOutId="3"/><Connection refConnectionPointOutId="4"/></ConnectionPointIn><ConnectionPointOut connectionPointOutId="5"/></LdObject>
<LdObject xsi:type="RightPowerRail"><ConnectionPointIn><Connection refConnectionPointOutId="5"/></ConnectionPointIn></LdObject></Rung>
<Rung evaluationOrder="2"><LdObject xsi:type="LeftPowerRail"><ConnectionPointOut connectionPointOutId="1"/></LdObject>
<LdObject xsi:type="Coil" operand="p"><ConnectionPointIn><Connection refConnectionPointOutId="1"/><Connection refConnectionPointOutId="77"/></ConnectionPointIn></LdObject></Rung></BodyContent>)"));
  EXPECT_EQ(r.project->version, Version::kIec61131_10);
  EXPECT_EQ(r.project->name, "demo");
  const Body& body = body_of(r);
  EXPECT_EQ(body.language, Language::kLd);
  EXPECT_EQ(body.name, "S1");
  const std::vector<Element>& e = body.elements;
  ASSERT_EQ(e.size(), 7u);
  EXPECT_EQ(e[0].kind, ElementKind::kLeftRail);
  EXPECT_EQ(e[0].at.local_id, 1);
  EXPECT_TRUE(e[1].negated && e[1].edge == Edge::kRising && e[1].text == "a" && e[1].x == 3 && e[1].y == 4);
  EXPECT_EQ(e[1].inputs.at(0).connections.at(0).ref_local_id, 1);
  EXPECT_EQ(e[1].inputs[0].connections[0].formal_parameter, "");
  EXPECT_EQ(e[2].kind, ElementKind::kContact);
  EXPECT_EQ(e[2].text, "(x) >= (y+1)");
  EXPECT_EQ(e[3].storage, Storage::kSet);
  EXPECT_EQ(e[3].inputs.at(0).connections.at(1).ref_local_id, 3);
  EXPECT_EQ(e[4].inputs.at(0).connections.at(0).ref_local_id, 4);
  EXPECT_EQ(e[4].network, 1u);
  EXPECT_EQ(e[6].network, 2u);
  EXPECT_EQ(e[6].inputs.at(0).connections.at(0).ref_local_id, 6);
  EXPECT_EQ(e[6].inputs[0].connections.at(1).ref_local_id, -1);
}

TEST(Iec10, DiagramWithBlocksJumpsAndInlineCode) {
  const auto r = read_clean(with_body(R"(<BodyContent xsi:type="FBD"><Network>
<FbdObject xsi:type="DataSource" identifier="x + 5"><ConnectionPointOut connectionPointOutId="10"/></FbdObject>
<FbdObject xsi:type="Block" typeName="Lib\TON" instanceName="t"><AddData><Data name="urn:x"><EvaluationPriority priorityInNetwork="3"/></Data></AddData>
<InOutVariables><InOutVariable parameterName="IO"><ConnectionPointIn/><ConnectionPointOut connectionPointOutId="13"/></InOutVariable></InOutVariables>
<InputVariables><InputVariable parameterName="IN" negated="true"><ConnectionPointIn><Connection refConnectionPointOutId="10"/></ConnectionPointIn></InputVariable></InputVariables>
<OutputVariables><OutputVariable parameterName="Q"><ConnectionPointOut connectionPointOutId="11"/></OutputVariable><OutputVariable parameterName="ET"><ConnectionPointOut connectionPointOutId="12"/></OutputVariable></OutputVariables></FbdObject>
<FbdObject xsi:type="DataSink" identifier="y"><ConnectionPointIn><Connection refConnectionPointOutId="12"/></ConnectionPointIn></FbdObject>
<FbdObject xsi:type="DataSink" identifier="z"><ConnectionPointIn><Connection refConnectionPointOutId="13"/></ConnectionPointIn></FbdObject>
<FbdObject xsi:type="ext:CfcJump" targetLabel="L"><ext:ConnectionPointIn><Connection refConnectionPointOutId="11"/></ext:ConnectionPointIn></FbdObject>
<FbdObject xsi:type="ext:CfcLabel" label="L"/><CommonObject xsi:type="Connector" label="c"><ConnectionPointIn/></CommonObject>
<LdObject xsi:type="ext:InlineST"><ext:ConnectionPointIn><Connection refConnectionPointOutId="11"/></ext:ConnectionPointIn><ext:ConnectionPointOut connectionPointOutId="20"/><ext:ST><ST>a := 1;</ST></ext:ST></LdObject>
</Network></BodyContent>)"));
  const std::vector<Element>& e = body_of(r).elements;
  ASSERT_EQ(e.size(), 8u);
  EXPECT_EQ(body_of(r).language, Language::kFbd);
  EXPECT_EQ(e[0].kind, ElementKind::kInVariable);
  EXPECT_EQ(e[0].text, "x + 5");
  EXPECT_EQ(e[1].text, "TON");
  EXPECT_EQ(e[1].execution_order, 4u);
  EXPECT_TRUE(e[1].inputs.at(0).negated);
  EXPECT_EQ(e[1].inputs[0].connections.at(0).ref_local_id, 1);
  EXPECT_EQ(e[2].inputs.at(0).connections.at(0).ref_local_id, 2);
  EXPECT_EQ(e[2].inputs[0].connections[0].formal_parameter, "ET");
  EXPECT_EQ(e[3].inputs.at(0).connections.at(0).formal_parameter, "IO");
  EXPECT_TRUE(e[4].kind == ElementKind::kJump && e[4].text == "L");
  EXPECT_TRUE(e[5].kind == ElementKind::kLabel && e[5].text == "L");
  EXPECT_TRUE(e[6].kind == ElementKind::kConnector && e[6].text == "c");
  EXPECT_TRUE(e[7].has_code);
  EXPECT_EQ(e[7].code, "a := 1;");
  EXPECT_EQ(e[7].inputs.at(0).name, "EN");
  EXPECT_EQ(e[7].inputs[0].connections.at(0).formal_parameter, "Q");
}

TEST(Iec10, EvaluationOrderSortsNetworksAndBodies) {
  const auto r = read_clean(with_body(R"(<BodyContent xsi:type="ST" evaluationOrder="2"><ST>late;</ST></BodyContent>
<BodyContent xsi:type="LD" evaluationOrder="1"><Rung evaluationOrder="2"><LdObject xsi:type="Coil" operand="second"/></Rung>
<Rung evaluationOrder="1"><LdObject xsi:type="Coil" operand="first"/></Rung></BodyContent>)"));
  const std::vector<Body>& bodies = r.project->pous.at(0).bodies;
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[0].elements.at(0).text, "first");
  EXPECT_EQ(bodies[0].elements.at(0).network, 1u);
  EXPECT_EQ(bodies[0].elements.at(1).network, 2u);
  EXPECT_EQ(bodies[1].text, "late;");
}

TEST(Iec10, UnknownObjectAndDuplicatePoint) {
  EXPECT_EQ(
      read_text(with_body("<BodyContent xsi:type=\"LD\"><Rung><LdObject xsi:type=\"Wheel\"/></Rung></BodyContent>"))
          .codes(),
      "P1017");
  EXPECT_EQ(
      read_text(
          with_body(
              R"(<BodyContent xsi:type="LD"><Rung><LdObject xsi:type="LeftPowerRail"><ConnectionPointOut connectionPointOutId="1"/>
<ConnectionPointOut connectionPointOutId="1"/></LdObject></Rung></BodyContent>)"))
          .codes(),
      "P1008");
}

TEST(Iec10, InterfaceAndTypes) {
  const auto r = read_clean(project(
      R"(<NamespaceDecl name="N"><DataTypeDecl name="Rec"><UserDefinedTypeSpec xsi:type="StructTypeSpec"><Member name="m"><Type><TypeName>REAL</TypeName></Type></Member></UserDefinedTypeSpec></DataTypeDecl>
<DataTypeDecl name="E"><UserDefinedTypeSpec xsi:type="EnumTypeWithNamedValueSpec"><Enumerator name="A" value="1"/><BaseType><TypeName>INT</TypeName></BaseType></UserDefinedTypeSpec></DataTypeDecl>
<DataTypeDecl name="Alias"><UserDefinedTypeSpec xsi:type="DirectlyDerivedTypeSpec"><BaseType><TypeName>DINT</TypeName></BaseType></UserDefinedTypeSpec></DataTypeDecl></NamespaceDecl>
<Function name="F"><Documentation xsi:type="SimpleText">note</Documentation><ResultType><TypeName>LREAL</TypeName></ResultType>
<Parameters><InputVars><Variable name="i" orderWithinParamSet="0"><Type><InstantlyDefinedType xsi:type="ArrayTypeSpec"><BaseType><TypeName>INT</TypeName></BaseType>
<DimensionSpec dimensionNumber="1"><IndexRange lower="0" upper="3"/></DimensionSpec></InstantlyDefinedType></Type></Variable></InputVars>
<OutputVars><Variable name="o"><Type><TypeName>Common\Servo</TypeName></Type></Variable></OutputVars><InoutVars><Variable name="io"><Type><TypeName>ARRAY[0..9, 1..2] OF STRING[20]</TypeName></Type></Variable></InoutVars></Parameters>
<ExternalVars constant="true"><Variable name="x"/></ExternalVars><Vars accessSpecifier="private"><Variable name="v"><Type><TypeName>STRING</TypeName></Type><InitialValue><SimpleValue value="'a'"/></InitialValue><Address address="%QX0.1"/></Variable></Vars>
<TempVars><Variable name="t"><Type><TypeName>REF_TO INT</TypeName></Type></Variable></TempVars>
<MainBody><BodyContent xsi:type="ST"><ST>F := 1.0;</ST></BodyContent></MainBody></Function>)"));
  ASSERT_EQ(r.project->data_types.size(), 3u);
  EXPECT_EQ(r.project->data_types[0].type.members.at(0).type.name, "REAL");
  EXPECT_EQ(r.project->data_types[1].type.values.at(0).value, "1");
  EXPECT_EQ(r.project->data_types[1].type.base->name, "INT");
  EXPECT_EQ(r.project->data_types[2].type.kind, TypeSpec::Kind::kNamed);
  EXPECT_EQ(r.project->data_types[2].type.name, "DINT");
  const Pou& f = r.project->pous.at(0);
  EXPECT_EQ(f.kind, PouKind::kFunction);
  EXPECT_EQ(f.return_type.name, "LREAL");
  EXPECT_EQ(f.documentation, "note");
  ASSERT_EQ(f.variables.size(), 6u);
  EXPECT_EQ(f.variables[0].type.kind, TypeSpec::Kind::kArray);
  EXPECT_EQ(f.variables[0].type.dimensions.at(0).upper, "3");
  EXPECT_EQ(f.variables[0].type.base->name, "INT");
  EXPECT_EQ(f.variables[1].type.name, "Servo");
  const TypeSpec& text_array = f.variables[2].type;
  ASSERT_EQ(text_array.kind, TypeSpec::Kind::kArray);
  ASSERT_EQ(text_array.dimensions.size(), 2u);
  EXPECT_EQ(text_array.dimensions[1].lower, "1");
  EXPECT_EQ(text_array.base->kind, TypeSpec::Kind::kString);
  EXPECT_EQ(text_array.base->length, "20");
  EXPECT_TRUE(f.variables[3].constant && f.variables[3].section == Section::kExternal);
  EXPECT_EQ(f.variables[4].address, "%QX0.1");
  EXPECT_EQ(f.variables[4].initial.text, "'a'");
  EXPECT_EQ(f.variables[5].type.kind, TypeSpec::Kind::kReference);
  EXPECT_EQ(f.bodies.at(0).text, "F := 1.0;");
}

TEST(Iec10, MemberOutsideAStructure) {
  const auto r = read_clean(project(
      "<DataTypeDecl name=\"T\"><UserDefinedTypeSpec><Member name=\"m\"/></UserDefinedTypeSpec></DataTypeDecl>"));
  EXPECT_EQ(r.project->data_types.at(0).type.kind, TypeSpec::Kind::kStruct);
  EXPECT_EQ(r.project->data_types[0].type.members.size(), 1u);
}

TEST(Iec10, ConfigurationJoinsInstancesToTheirTasks) {
  const auto r = read_clean(project(
      "",
      R"(<Configuration name="C"><Resource name="R" resourceTypeName=""><GlobalVars retain="true"><Variable name="g"><Type><TypeName>BOOL</TypeName></Type></Variable></GlobalVars>
<ProgramInstance name="i" typeName="Main" associatedTaskName="T"/><Task name="T" interval="T#10ms" priority="1"/><ProgramInstance name="free" typeName="Main"/></Resource></Configuration>)"));
  const Resource& resource = r.project->configurations.at(0).resources.at(0);
  EXPECT_TRUE(resource.globals.at(0).retain);
  ASSERT_EQ(resource.tasks.size(), 1u);
  EXPECT_EQ(resource.tasks[0].interval, "T#10ms");
  EXPECT_EQ(resource.tasks[0].instances.at(0).name, "i");
  ASSERT_EQ(resource.instances.size(), 1u);
  EXPECT_EQ(resource.instances[0].name, "free");
}

}  // namespace
}  // namespace plc::plcopen
