// Drawn elements of TC6 bodies: every attribute that means something arrives.
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

TEST(Body, ContactWithModifiersPositionAndWires) {
  const auto r = read_clean(ladder(R"(
<leftPowerRail localId="1"><position x="4" y="5"/><connectionPointOut formalParameter="none"/><connectionPointOut formalParameter=""/></leftPowerRail>
<contact localId="2" negated="true" edge="rising" storage="none" width="21" height="20.6" executionOrderId="7" globalId="x"><position x="-10" y="12.5"/>
  <connectionPointIn><relPosition x="0" y="8"/><connection refLocalId="1"/><connection refLocalId="9" formalParameter="Q"/></connectionPointIn>
  <connectionPointOut><relPosition x="21" y="8"/></connectionPointOut><variable> A AND GVL.x </variable></contact>)"));
  const Body& body = body_of(r);
  ASSERT_EQ(body.elements.size(), 2u);
  EXPECT_EQ(body.language, Language::kLd);
  EXPECT_EQ(body.drawn_elements, 2u);
  const Element& rail = body.elements[0];
  EXPECT_EQ(rail.kind, ElementKind::kLeftRail);
  ASSERT_EQ(rail.outputs.size(), 2u);
  EXPECT_EQ(rail.outputs[0].name, "none");
  EXPECT_TRUE(rail.outputs[1].has_point_out);
  const Element& contact = body.elements[1];
  EXPECT_EQ(contact.kind, ElementKind::kContact);
  EXPECT_EQ(contact.at.local_id, 2);
  EXPECT_EQ(contact.at.kind, ElementKind::kContact);
  EXPECT_TRUE(contact.negated);
  EXPECT_EQ(contact.edge, Edge::kRising);
  EXPECT_EQ(contact.storage, Storage::kNone);
  EXPECT_EQ(contact.execution_order, 7u);
  EXPECT_TRUE(contact.has_position);
  EXPECT_EQ(contact.x, -10);
  EXPECT_EQ(contact.y, 13);
  EXPECT_EQ(contact.width, 21);
  EXPECT_EQ(contact.height, 21);
  EXPECT_EQ(contact.text, "A AND GVL.x");
  ASSERT_EQ(contact.inputs.size(), 1u);
  ASSERT_EQ(contact.inputs[0].connections.size(), 2u);
  EXPECT_EQ(contact.inputs[0].connections[0].ref_local_id, 1);
  EXPECT_EQ(contact.inputs[0].connections[1].ref_local_id, 9);
  EXPECT_EQ(contact.inputs[0].connections[1].formal_parameter, "Q");
  EXPECT_EQ(contact.inputs[0].connections[1].at.local_id, 2);
  ASSERT_EQ(contact.outputs.size(), 1u);
}

TEST(Body, BlockWithAllPinLists) {
  const auto r =
      read_clean(program(R"(<FBD><block localId="14" typeName="MyFb" instanceName="fb[1]" width="1" height="2">
<inputVariables><variable formalParameter="IN" negated="true" edge="falling" storage="set" hidden="true"><connectionPointIn>
<expression> a + 1 </expression></connectionPointIn></variable><variable formalParameter="PT"/></inputVariables>
<inOutVariables><variable formalParameter="IO"><connectionPointIn><connection refLocalId="3"/></connectionPointIn><connectionPointOut/></variable></inOutVariables>
<outputVariables><variable formalParameter="Q" negated="1"><connectionPointOut/></variable></outputVariables></block></FBD>)"));
  const Element& block = body_of(r).elements.at(0);
  EXPECT_EQ(block.text, "MyFb");
  EXPECT_EQ(block.instance_name, "fb[1]");
  ASSERT_EQ(block.inputs.size(), 2u);
  EXPECT_EQ(block.inputs[0].name, "IN");
  EXPECT_TRUE(block.inputs[0].negated);
  EXPECT_EQ(block.inputs[0].edge, Edge::kFalling);
  EXPECT_EQ(block.inputs[0].storage, Storage::kSet);
  EXPECT_TRUE(block.inputs[0].hidden);
  EXPECT_TRUE(block.inputs[0].has_point_in);
  EXPECT_EQ(block.inputs[0].expression, "a + 1");
  EXPECT_FALSE(block.inputs[1].has_point_in);
  ASSERT_EQ(block.in_outs.size(), 1u);
  EXPECT_TRUE(block.in_outs[0].has_point_in && block.in_outs[0].has_point_out);
  ASSERT_EQ(block.outputs.size(), 1u);
  EXPECT_TRUE(block.outputs[0].negated);
  EXPECT_TRUE(block.outputs[0].has_point_out);
}

TEST(Body, VariablesAtOutputPoints) {
  const auto r = read_clean(program(R"(<FBD><block localId="1" typeName="F" instanceName="???"><inputVariables>
<variable formalParameter="A"><connectionPointIn><expression> ? ?? </expression></connectionPointIn></variable></inputVariables>
<inOutVariables><variable formalParameter="IO"><connectionPointIn><expression>Left</expression></connectionPointIn>
<connectionPointOut><expression>Right</expression></connectionPointOut></variable></inOutVariables>
<outputVariables><variable formalParameter="Q"><connectionPointOut><expression> a[1].b </expression></connectionPointOut></variable>
<variable formalParameter="ET"><connectionPointOut><expression>???</expression></connectionPointOut></variable></outputVariables></block>
<inVariable localId="2"><connectionPointOut/><expression>??</expression></inVariable></FBD>)"));
  const Element& block = body_of(r).elements.at(0);
  EXPECT_EQ(block.instance_name, "");
  EXPECT_EQ(block.inputs.at(0).expression, "");
  EXPECT_EQ(block.in_outs.at(0).expression, "Left");
  EXPECT_EQ(block.in_outs.at(0).target, "Right");
  EXPECT_EQ(block.outputs.at(0).target, "a[1].b");
  EXPECT_EQ(block.outputs.at(0).expression, "");
  EXPECT_EQ(block.outputs.at(0).target_at.local_id, 1);
  EXPECT_NE(block.outputs.at(0).target_at.line, block.at.line);
  EXPECT_EQ(block.outputs.at(1).target, "");
  EXPECT_EQ(body_of(r).elements.at(1).text, "");
}

TEST(Body, ClosedBranchesOfCodesys) {
  const std::string mark = R"(<vendorElement localId="9"><alternativeText/><addData>
<data name="http://www.3s-software.com/plcopenxml/ldparallelbranch" handleUnknown="implementation">
<ParallelBranch mode="SCE"><BranchInput><connectionPointIn><connection refLocalId="3"/></connectionPointIn></BranchInput>
<BranchTrees><Tree><connectionPointIn><connection refLocalId="4" formalParameter="Q"/><connection refLocalId="5"/></connectionPointIn></Tree>
<Tree/></BranchTrees></ParallelBranch></data></addData></vendorElement>)";
  const auto r = read_clean(ladder(mark));
  const Body& body = body_of(r);
  EXPECT_TRUE(body.elements.empty());
  ASSERT_EQ(body.closed_branches.size(), 1u);
  const ClosedBranch& branch = body.closed_branches[0];
  EXPECT_EQ(branch.local_id, 9);
  EXPECT_TRUE(branch.short_circuit);
  ASSERT_EQ(branch.input.connections.size(), 1u);
  EXPECT_EQ(branch.input.connections[0].ref_local_id, 3);
  ASSERT_EQ(branch.lines.size(), 2u);
  ASSERT_EQ(branch.lines[0].connections.size(), 2u);
  EXPECT_EQ(branch.lines[0].connections[0].formal_parameter, "Q");
  EXPECT_EQ(branch.lines[0].connections[0].at.local_id, 9);
  EXPECT_TRUE(branch.lines[1].connections.empty());
}

TEST(Body, ClosedBranchesOfOtherModesAreOr) {
  const auto of_mode = [](const std::string& mode) {
    return read_text(ladder("<vendorElement localId=\"9\"><addData><data name=\"x/ldparallelbranch\"><ParallelBranch " +
                            mode + "/></data></addData></vendorElement>"));
  };
  EXPECT_EQ(of_mode("").codes(), "");
  EXPECT_EQ(of_mode("mode=\"or\"").codes(), "");
  const auto r = of_mode("mode=\"xor\"");
  EXPECT_EQ(r.codes(), "P3030");
  EXPECT_FALSE(body_of(r).closed_branches.at(0).short_circuit);
}

TEST(Body, ClosedBranchOutsideOfABody) {
  const auto r =
      read_text(tc6("", "", R"(<addData><data name="x/ldparallelbranch"><ParallelBranch mode="sce"><BranchInput>
<connectionPointIn><connection refLocalId="3"/></connectionPointIn></BranchInput></ParallelBranch></data></addData>)"));
  EXPECT_EQ(r.codes(), "");
}

TEST(Body, VariablesJumpsLabelsReturnsAndConnectors) {
  const auto r = read_clean(program(R"(<FBD>
<inVariable localId="1" negated="true" edge="rising" storage="reset"><connectionPointOut/><expression>T#500ms</expression></inVariable>
<outVariable localId="2" storage="set"><connectionPointIn/><expression>b</expression></outVariable>
<inOutVariable localId="3" negatedIn="true" edgeIn="falling" storageIn="set" negatedOut="true" edgeOut="rising" storageOut="reset">
<connectionPointIn/><connectionPointOut/><expression>c</expression></inOutVariable>
<connector localId="4" name="C1"><connectionPointIn/></connector><continuation localId="5" name="C1"><connectionPointOut/></continuation>
<label localId="6" label="Again"/><jump localId="7" label="Again"><connectionPointIn/></jump><return localId="8"><connectionPointIn/></return></FBD>)"));
  const std::vector<Element>& e = body_of(r).elements;
  ASSERT_EQ(e.size(), 8u);
  EXPECT_TRUE(e[0].negated && e[0].edge == Edge::kRising && e[0].storage == Storage::kReset);
  EXPECT_EQ(e[0].text, "T#500ms");
  EXPECT_EQ(e[1].storage, Storage::kSet);
  EXPECT_TRUE(e[2].negated && e[2].negated_out);
  EXPECT_TRUE(e[2].edge == Edge::kFalling && e[2].edge_out == Edge::kRising);
  EXPECT_TRUE(e[2].storage == Storage::kSet && e[2].storage_out == Storage::kReset);
  EXPECT_TRUE(e[2].inputs.size() == 1 && e[2].outputs.size() == 1);
  EXPECT_EQ(e[3].text, "C1");
  EXPECT_EQ(e[4].kind, ElementKind::kContinuation);
  EXPECT_EQ(e[5].text, "Again");
  EXPECT_EQ(e[6].kind, ElementKind::kJump);
  EXPECT_EQ(e[7].kind, ElementKind::kReturn);
}

TEST(Body, CoilsKeepEdgeAndStorage) {
  const auto r = read_clean(ladder(R"(<coil localId="1" storage="set"><connectionPointIn/><variable>a</variable></coil>
<coil localId="2" edge="falling" negated="false"><connectionPointIn/><variable>b</variable></coil>
<rightPowerRail localId="3"><connectionPointIn/><connectionPointIn/></rightPowerRail>)"));
  const std::vector<Element>& e = body_of(r).elements;
  EXPECT_EQ(e.at(0).storage, Storage::kSet);
  EXPECT_EQ(e.at(1).edge, Edge::kFalling);
  EXPECT_EQ(e.at(2).inputs.size(), 2u);
}

TEST(Body, ActionBlockInALadder) {
  const auto r = read_clean(ladder(R"(<actionBlock localId="5"><connectionPointIn/>
<action localId="6" qualifier="L" duration="T#2s" indicator="done"><reference name="Motor"/></action>
<action localId="7" qualifier="N"><inline><ST><xhtml:p>x := 1;</xhtml:p></ST></inline></action></actionBlock>)"));
  const Element& e = body_of(r).elements.at(0);
  EXPECT_EQ(e.kind, ElementKind::kActionBlock);
  ASSERT_EQ(e.actions.size(), 2u);
  EXPECT_EQ(e.actions[0].qualifier, "L");
  EXPECT_EQ(e.actions[0].duration, "T#2s");
  EXPECT_EQ(e.actions[0].indicator, "done");
  EXPECT_EQ(e.actions[0].name, "Motor");
  EXPECT_EQ(e.actions[0].local_id, 6);
  EXPECT_EQ(e.actions[0].at.local_id, 5);
  EXPECT_EQ(e.actions[1].text, "x := 1;");
  EXPECT_EQ(e.actions[1].text_at.local_id, 5);
  EXPECT_EQ(e.actions[1].text_at.line, e.actions[1].at.line);
  EXPECT_EQ(e.text, "Motor");
}

TEST(Body, AnActionDrawnInItsBlockIsOneOfThePou) {
  const auto r = read_clean(tc6(R"(<pous><pou name="P" pouType="program"><interface/>
<actions><action name="a"><body><ST>x := 1;</ST></body></action></actions><body><LD>
<actionBlock localId="5"><connectionPointIn/>
<action localId="6"><inline><LD><leftPowerRail localId="1"/></LD></inline></action>
<action localId="7"><inline><IL><xhtml:p>LD x</xhtml:p></IL></inline></action>
<action localId="8"><reference name="Fill"/><inline><FBD><label localId="1" label="l"/></FBD></inline></action>
<action localId="9"><inline><SFC><step localId="1" name="s"/></SFC></inline></action></actionBlock>
</LD></body></pou></pous>)"));
  const Pou& pou = r.project->pous.at(0);
  const Element& e = body_of(r).elements.at(0);
  ASSERT_EQ(pou.actions.size(), 5u);
  ASSERT_EQ(e.actions.size(), 4u);
  const Language expected[] = {Language::kLd, Language::kIl, Language::kFbd, Language::kSfc};
  for (std::size_t i = 0; i < e.actions.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(pou.actions[i + 1].name, e.actions[i].name);
    EXPECT_EQ(pou.actions[i + 1].bodies.at(0).language, expected[i]);
    EXPECT_EQ(e.actions[i].text, "");
  }
  EXPECT_EQ(e.text, "drawn_action_2, drawn_action_3, Fill, drawn_action_5");
  EXPECT_EQ(pou.actions[2].bodies[0].text, "LD x");
}

TEST(Body, ADrawnActionTakesANameThatIsFree) {
  const auto r = read_clean(tc6(R"(<pous><pou name="P" pouType="program"><interface><localVars>
<variable name="Drawn_Action_1"><type><BOOL/></type></variable></localVars></interface><body><LD>
<actionBlock localId="5"><connectionPointIn/><action localId="6"><inline><IL>LD x</IL></inline></action></actionBlock>
</LD></body></pou></pous>)"));
  EXPECT_EQ(r.project->pous.at(0).actions.at(0).name, "drawn_action_2");
}

TEST(Body, AnActionIsOfOneReference) {
  const auto r = read_text(ladder(R"(<actionBlock localId="5"><connectionPointIn/>
<action localId="6"><inline><IL>LD x</IL></inline><reference name="Motor"/></action></actionBlock>)"));
  EXPECT_EQ(r.codes(), "P1007");
  EXPECT_NE(r.diagnostics.all()[0].message.find("\"Motor\", and is \"drawn_action_1\" already"), std::string::npos);
}

TEST(Body, ActionBlockNamesItsVariables) {
  const auto r = read_clean(ladder(R"(<actionBlock localId="5" negated="true"><connectionPointIn/>
<action localId="6" qualifier="S"><reference name="Motor"/></action>
<action localId="7"><reference name=" Lamp "/></action></actionBlock>)"));
  const Element& e = body_of(r).elements.at(0);
  EXPECT_TRUE(e.negated);
  EXPECT_EQ(e.text, "Motor, Lamp");
  EXPECT_EQ(e.actions.at(1).qualifier, "");
}

TEST(Body, CommentsAreKeptAndAreNoElements) {
  const auto r = read_clean(ladder(
      R"(<comment localId="1" height="12" width="80"><position x="5" y="7.5"/><content><xhtml:p>hello</xhtml:p></content></comment>
<comment localId="2" height="0" width="0"><position x="0" y="0"/><content><xhtml:p> </xhtml:p></content></comment>)"));
  EXPECT_EQ(body_of(r).drawn_elements, 0u);
  EXPECT_TRUE(body_of(r).elements.empty());
  ASSERT_NE(r.row("body/LD/comment"), nullptr);
  EXPECT_EQ(r.row("body/LD/comment")->fate, Fate::kPreserved);
  ASSERT_EQ(body_of(r).comments.size(), 1u) << "an empty one says nothing";
  const DrawnComment& comment = body_of(r).comments[0];
  EXPECT_EQ(comment.text, "hello");
  EXPECT_EQ(comment.place.x, 5);
  EXPECT_EQ(comment.place.y, 8);
  EXPECT_EQ(comment.width, 80);
  EXPECT_EQ(comment.height, 12);
}

TEST(Body, LinesAndPinsAreKeptAsDrawn) {
  const auto r = read_clean(ladder(R"(<contact localId="2"><connectionPointIn><relPosition x="0" y="8"/>
<connection refLocalId="1"><position x="40" y="18"/><position x="20" y="18"/><position x="20" y="60"/></connection>
<connection refLocalId="3"/></connectionPointIn>
<connectionPointOut><relPosition x="far" y="8"/></connectionPointOut><variable>A</variable></contact>)"));
  const Element& contact = body_of(r).elements.at(0);
  EXPECT_TRUE(contact.inputs.at(0).has_place);
  EXPECT_EQ(contact.inputs[0].place.y, 8);
  ASSERT_EQ(contact.inputs[0].connections.at(0).points.size(), 3u);
  EXPECT_EQ(contact.inputs[0].connections[0].points[2].y, 60);
  EXPECT_TRUE(contact.inputs[0].connections.at(1).points.empty());
  EXPECT_EQ(contact.outputs.at(0).place.x, 0) << "a picture is no reason to refuse a file";
}

TEST(Body, TitlesAndCommentsBelongToTheNetworkBelow) {
  const std::string title =
      R"(<vendorElement localId="3"><position x="0" y="0"/><alternativeText><xhtml:p>Filling</xhtml:p></alternativeText>
<addData><data name="http://www.3s-software.com/plcopenxml/fbdelementtype" handleUnknown="implementation"><ElementType xmlns="">networktitle</ElementType></data></addData></vendorElement>)";
  const auto r = read_clean(ladder(
      R"(<comment localId="1" height="0" width="0"><position x="0" y="0"/><content><xhtml:p>first</xhtml:p></content></comment>)" +
      title + R"(<contact localId="4"><variable>A</variable></contact>)" + title));
  const std::vector<DrawnComment>& comments = body_of(r).comments;
  ASSERT_EQ(comments.size(), 3u);
  EXPECT_EQ(comments[0].text, "first");
  EXPECT_EQ(comments[0].network, 1u);
  EXPECT_EQ(comments[1].text, "Filling");
  EXPECT_EQ(comments[1].network, 1u);
  EXPECT_EQ(comments[2].network, 2u);
}

TEST(Body, UnknownDrawnElementIsAnErrorAndCounts) {
  const auto r = read_text(ladder(R"(<spinner localId="3"/>)"));
  EXPECT_EQ(r.codes(), "P1017");
  ASSERT_NE(r.project, nullptr);
  EXPECT_EQ(body_of(r).drawn_elements, 1u);
  EXPECT_EQ(r.row("body/LD/spinner")->fate, Fate::kRefused);
}

TEST(Body, VendorElementWithPinsIsAnError) {
  const auto r = read_text(ladder(
      R"(<vendorElement localId="3"><alternativeText/><inputVariables><variable formalParameter="a"/></inputVariables></vendorElement>)"));
  EXPECT_EQ(r.codes(), "P1017");
  EXPECT_EQ(body_of(r).drawn_elements, 1u);
}

TEST(Body, DuplicateLocalIdNamesBothPlaces) {
  const std::string xml = ladder(
      "\n<contact localId=\"4\"><variable>a</variable></contact>\n<coil localId=\"5\"><variable>b</variable></coil>\n"
      "  <coil localId=\"4\"><variable>c</variable></coil>");
  const auto r = read_text(xml);
  ASSERT_EQ(r.codes(), "P1008");
  const core::Diagnostic& d = r.diagnostics.all()[0];
  EXPECT_EQ(place(d.at), place_of(xml, "<coil localId=\"4\""));
  const std::string first = place_of(xml, "<contact localId=\"4\"");
  EXPECT_NE(d.message.find("line " + first.substr(0, first.find(':')) + " column 1"), std::string::npos) << d.message;
  EXPECT_EQ(d.pou, "Main");
}

TEST(Body, ChartsAreReadAsElements) {
  const auto r = read_clean(
      program(R"(<SFC><step localId="1" name="s" initialStep="true"/><transition localId="2"><condition><inline name="">
<ST><xhtml:p>TRUE</xhtml:p></ST></inline></condition></transition><comment localId="9" width="1" height="1"/></SFC>)"));
  EXPECT_EQ(body_of(r).language, Language::kSfc);
  ASSERT_EQ(body_of(r).elements.size(), 2u);
  EXPECT_EQ(body_of(r).elements[0].kind, ElementKind::kStep);
  EXPECT_EQ(body_of(r).elements[0].text, "s");
  ASSERT_NE(body_of(r).elements[0].chart, nullptr);
  EXPECT_TRUE(body_of(r).elements[0].chart->initial);
  EXPECT_EQ(body_of(r).elements[1].kind, ElementKind::kTransition);
  ASSERT_NE(body_of(r).elements[1].chart, nullptr);
  EXPECT_EQ(body_of(r).elements[1].chart->text, "TRUE");
  EXPECT_EQ(r.row("body/SFC/step")->fate, Fate::kUsed);
}

TEST(Body, ActionsBelongToTheirPou) {
  const auto r = read_clean(tc6(R"(<pous><pou name="P" pouType="program"><interface/>
<actions><action name="a"><body><ST>x := 1;</ST></body></action>
<action name="b"><body><FBD><label localId="1" label="l"/></FBD></body><documentation>why</documentation></action></actions>
<body><ST/></body></pou></pous>)"));
  const Pou& pou = r.project->pous.at(0);
  EXPECT_FALSE(pou.has_chart);
  ASSERT_EQ(pou.bodies.size(), 1u);
  ASSERT_EQ(pou.actions.size(), 2u);
  EXPECT_EQ(pou.actions[0].name, "a");
  EXPECT_EQ(pou.actions[0].bodies.at(0).text, "x := 1;");
  EXPECT_EQ(pou.actions[1].bodies.at(0).elements.size(), 1u);
  EXPECT_EQ(pou.actions[1].documentation, "why");
}

TEST(Body, ChartsInActionsAndTransitionsOfAPou) {
  const auto r = read_clean(tc6(R"(<pous><pou name="P" pouType="program"><interface/>
<actions><action name="a"><body><SFC/></body></action><action name="b"><body><SFC/></body></action></actions>
<transitions><transition name="t"><body><ST>:= x;</ST></body></transition></transitions><body><ST/></body></pou></pous>)"));
  const Pou& pou = r.project->pous.at(0);
  ASSERT_EQ(pou.actions.size(), 2u);
  EXPECT_EQ(pou.actions[0].bodies.at(0).language, Language::kSfc);
  ASSERT_EQ(pou.transitions.size(), 1u);
  EXPECT_EQ(pou.transitions[0].name, "t");
  EXPECT_EQ(pou.transitions[0].bodies.at(0).text, ":= x;");
}

TEST(Body, WhatCodesysKeepsOfStepsAndFlags) {
  const auto r = read_clean(program(R"(<SFC><step localId="1" name="s"><addData>
<data name="http://www.3s-software.com/plcopenxml/sfc/element"><attributes xmlns="">
<attribute guid="700a583f-b4d4">Main
</attribute><attribute guid="a6b08bd8-5a9b">In</attribute><attribute guid="a2621e18-7de3">Out</attribute>
<attribute guid="cacf1a68-0000">T#1s</attribute><attribute guid="b693554c-0000">T#2s</attribute>
<attribute guid="01580b27-6378">TRUE</attribute></attributes></data></addData></step>
<actionBlock localId="2"><action localId="3"><reference name="a"/><addData>
<data name="http://www.3s-software.com/plcopenxml/sfc/element"><attributes xmlns="">
<attribute guid="01580b27-6378">TRUE</attribute></attributes></data></addData></action></actionBlock>
<addData><data name="http://www.3s-software.com/plcopenxml/sfcsettings"><SFCSettings><LibTitle>x</LibTitle>
<Flags><Init Declare="true" Use="false"/><Reset Declare="true" Use="true"/></Flags></SFCSettings></data></addData></SFC>)"));
  const ChartPart& step = *body_of(r).elements.at(0).chart;
  EXPECT_EQ(step.main, "Main");
  EXPECT_EQ(step.entry, "In");
  EXPECT_EQ(step.exit, "Out");
  EXPECT_EQ(step.min_time, "T#1s");
  EXPECT_EQ(step.max_time, "T#2s");
  EXPECT_TRUE(step.excluded);
  EXPECT_EQ(body_of(r).flags, std::vector<std::string>{"SFCReset"});
  EXPECT_TRUE(r.project->has_3s_charts);
}

TEST(Body, ActionsInVendorDataFindTheirPou) {
  const auto data = [](const std::string& in) {
    return R"(<addData><data name="http://www.3s-software.com/plcopenxml/action">)" + in + "</data></addData>";
  };
  const std::string path = data(R"(<action name="b"><body><ST>y</ST></body><addData>
<data name="http://www.3s-software.com/plcopenxml/pathstructure"><pathStructure name="App"><pathStructure name="p">
<pathStructure name="b"/></pathStructure></pathStructure></data></addData></action>)");
  const std::string inside = data(R"(<Action name="a"><body><ST>x</ST></body></Action>)");
  const std::string pou = R"(<types><dataTypes/><pous><pou name="P" pouType="program"><interface/><body><ST/></body>)" +
                          inside + "</pou></pous></types>";
  const auto r = read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0200\">" + pou + path + "</project>");
  EXPECT_EQ(r.codes(), "");
  ASSERT_EQ(r.project->pous.at(0).actions.size(), 2u);
  EXPECT_EQ(r.project->pous[0].actions[0].name, "a");
  EXPECT_EQ(r.project->pous[0].actions[1].name, "b");
  const auto loose = read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0200\">" + pou +
                               data(R"(<action name="c"><body><ST>x</ST></body></action>)") + "</project>");
  EXPECT_EQ(loose.codes(), "P1018");
}

TEST(Body, TwoLanguagesInOneBodyAreTwoBodies) {
  const auto r = read_clean(program("<ST>a := 1;</ST><FBD><label localId=\"1\" label=\"x\"/></FBD>"));
  ASSERT_EQ(r.project->pous.at(0).bodies.size(), 2u);
  EXPECT_EQ(r.project->pous[0].bodies[0].language, Language::kSt);
  EXPECT_EQ(r.project->pous[0].bodies[1].elements.size(), 1u);
}

TEST(Body, EmptyBodyHasNoLanguage) {
  const auto r = read_clean(program(""));
  EXPECT_EQ(body_of(r).language, Language::kNone);
  EXPECT_EQ(r.project->pous.at(0).unread, "");
}

TEST(Body, InVendorDataAloneIsNotRead) {
  const std::string data = R"(<addData><data name="http://vendor/cfc" handleUnknown="discard"><CFC/></data></addData>)";
  EXPECT_EQ(read_clean(program(data)).project->pous.at(0).unread, "has a body in \"cfc\", which is not read");
  EXPECT_EQ(read_clean(program("<ST>a := 1;</ST>" + data)).project->pous.at(0).unread, "");
  const std::string known =
      R"(<addData><data name="http://www.3s-software.com/plcopenxml/objectid"><ObjectId>1</ObjectId></data></addData>)";
  EXPECT_EQ(read_clean(program(known)).project->pous.at(0).unread, "");
  EXPECT_EQ(read_text(program("<CFC/>")).project->pous.at(0).unread, "has a body in \"CFC\", which is not read");
}

TEST(Body, JumpsAndConditionsMayBeNegated) {
  const auto jump = read_clean(program(R"(<FBD><jump localId="1" label="x" negated="true"/></FBD>)"));
  EXPECT_TRUE(body_of(jump).elements.at(0).negated);
  const auto chart = read_clean(program(R"(<SFC><transition localId="1"><condition negated="true">
<connectionPointIn><connection refLocalId="3"/></connectionPointIn></condition></transition>
<transition localId="2"><condition><reference name="c"/></condition></transition></SFC>)"));
  ASSERT_EQ(body_of(chart).elements.size(), 2u);
  EXPECT_TRUE(body_of(chart).elements[0].chart->negated);
  EXPECT_TRUE(body_of(chart).elements[0].chart->condition.negated);
  EXPECT_FALSE(body_of(chart).elements[1].chart->negated);
}

}  // namespace
}  // namespace plc::plcopen
