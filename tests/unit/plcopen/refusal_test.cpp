// Bad input: every problem has its code and place, nothing crashes, nothing takes long.
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

TEST(Refusal, FilesThatCannotBeRead) {
  core::Diagnostics diagnostics;
  EXPECT_EQ(read("no/such/file.xml", diagnostics), nullptr);
  EXPECT_EQ(read("/", diagnostics), nullptr);
  ASSERT_EQ(diagnostics.all().size(), 2u);
  for (const core::Diagnostic& d : diagnostics.all()) EXPECT_EQ(d.code, core::Code::P1001);
}

TEST(Refusal, FileIsReadLikeMemory) {
  const std::string path = testing::TempDir() + "plc_reader_" + std::to_string(::getpid()) + ".xml";
  std::ofstream(path) << ladder("<coil localId=\"1\"><variable>a</variable></coil>");
  core::Diagnostics diagnostics;
  const auto project = read(path, diagnostics);
  ReadLimits small;
  small.max_bytes = 10;
  EXPECT_EQ(read(path, diagnostics, small), nullptr);
  std::remove(path.c_str());
  ASSERT_NE(project, nullptr);
  EXPECT_EQ(project->path, path);
  EXPECT_EQ(project->pous.at(0).bodies.at(0).elements.size(), 1u);
  EXPECT_EQ(diagnostics.all().at(0).code, core::Code::P1006);
}

TEST(Refusal, NotXmlOrNotAProject) {
  EXPECT_EQ(read_text("").codes(), "P1002");
  EXPECT_EQ(read_text("   \n").codes(), "P1002");
  EXPECT_EQ(read_text("PK\x03\x04").codes(), "P1002");
  EXPECT_EQ(read_text(std::string_view("<project>\0</project>", 20)).codes(), "P1002");
  EXPECT_EQ(read_text("<html/>").codes(), "P1003");
  EXPECT_EQ(read_text("<").codes(), "P1002");
  const auto unclosed = read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">\n<types>");
  EXPECT_EQ(unclosed.codes(), "P1002");
  EXPECT_EQ(unclosed.project, nullptr);
}

TEST(Refusal, MismatchedTagNamesThePlace) {
  const auto r = read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">\n<types>\n</pous></project>");
  ASSERT_GE(r.diagnostics.all().size(), 1u);
  EXPECT_EQ(r.diagnostics.all()[0].code, core::Code::P1002);
  EXPECT_EQ(r.diagnostics.all()[0].at.line, 3u);
  EXPECT_EQ(r.project, nullptr);
}

TEST(Refusal, UnknownNamespaceIsAWarning) {
  const auto r = read_text("<project xmlns=\"urn:none\"><types><pous/></types></project>");
  EXPECT_EQ(r.codes(), "P1004");
  ASSERT_NE(r.project, nullptr);
  EXPECT_EQ(r.project->version, Version::kUnknown);
  EXPECT_EQ(read_text("<project/>").codes(), "P1004");
}

TEST(Refusal, UndeclaredPrefixIsAWarning) {
  const auto r = read_text(
      "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><pous><pou name=\"A\" "
      "pouType=\"program\"><interface/><body>"
      "<ST><xhtml:p>x;</xhtml:p></ST></body></pou></pous></types></project>");
  EXPECT_EQ(r.codes(), "P1004");
  EXPECT_EQ(body_of(r).text, "x;");
}

TEST(Refusal, EntitiesAndDeclarations) {
  const std::string root =
      "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><contentHeader name=\"&a;\"/></project>";
  for (const std::string_view subset :
       {"<!ENTITY a \"b\">", "<!ENTITY a SYSTEM \"file:///etc/passwd\">",
        "<!ENTITY % p SYSTEM \"http://127.0.0.1:1/\"> %p;", "<!ATTLIST project x CDATA \"d\">", ""}) {
    const auto r = read_text("<!DOCTYPE project [" + std::string(subset) + "]>" + root);
    EXPECT_EQ(r.codes(), "P1005") << subset;
    EXPECT_EQ(r.project, nullptr);
  }
  // A quoted comment start must not hide the declarations.
  EXPECT_EQ(read_text("<!DOCTYPE project SYSTEM \"<!--\" [<!ENTITY a \"b\">]>" + root).codes(), "P1005");
  EXPECT_EQ(read_text(root).codes(), "P1002");
}

TEST(Refusal, ExternalDoctypeIsNeverLoaded) {
  const auto r = read_clean("<!DOCTYPE project SYSTEM \"file:///etc/passwd\">" + tc6("<pous/>"));
  EXPECT_EQ(r.project->name, "demo");
}

TEST(Limits, DepthElementsAttributesNamespacesTextAndSize) {
  ReadLimits limits;
  limits.max_depth = 10;
  std::string deep;
  for (int i = 0; i < 20; ++i) deep += "<a>";
  EXPECT_NE(read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">" + deep, limits).codes().find("P1006"),
            std::string::npos);

  limits = {};
  limits.max_elements = 5;
  EXPECT_EQ(read_text(tc6("<pous/>"), limits).codes(), "P1006");

  limits = {};
  limits.max_bytes = 100;
  EXPECT_EQ(read_text(tc6("<pous/>"), limits).codes(), "P1006");

  std::string attributes;
  for (int i = 0; i < 2000; ++i) attributes += " a" + std::to_string(i) + "=\"\"";
  EXPECT_EQ(read_text(tc6("<pous" + attributes + "/>")).codes(), "P1006");

  std::string spaces;
  for (int k = 0; k < 3; ++k) {
    spaces += "<types";
    for (int i = 0; i < 400; ++i) spaces += " xmlns:n" + std::to_string(k * 400 + i) + "=\"u\"";
    spaces += ">";
  }
  EXPECT_NE(read_text("<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">" + spaces).codes().find("P1006"),
            std::string::npos);

  limits = {};
  limits.max_text = 50;
  EXPECT_EQ(read_text(program("<ST>" + std::string(60, 'x') + "</ST>"), limits).codes(), "P1006");
  EXPECT_EQ(read_text(program("<ST>" + std::string(40, 'x') + "</ST>"), limits).codes(), "");
}

TEST(Limits, ManyKindsOfElementsStayBounded) {
  std::string xml;
  for (int i = 0; i < 20'000; ++i) xml += "<n" + std::to_string(i) + "/><data name=\"d" + std::to_string(i) + "\"/>";
  const auto r = read_text(
      tc6("<pous/>" + xml + R"(<pous><pou name="A" pouType="program"><interface/><body><ST/></body></pou></pous>)"));
  ASSERT_NE(r.project, nullptr);
  EXPECT_LT(r.project->report.size(), 5'000u);
  EXPECT_EQ(r.project->pous.size(), 1u);
  std::size_t sum = 0;
  for (const ReportRow& row : r.project->report) sum += row.count;
  EXPECT_EQ(sum, 40'000u + 12u);
}

TEST(Names, TooLongControlCharactersAndPathSeparators) {
  const auto named = [](std::string_view name) {
    return read_text(tc6("<pous><pou name=\"" + std::string(name) +
                         "\" pouType=\"program\"><interface/><body><ST/></body></pou></pous>"));
  };
  EXPECT_EQ(named(std::string(10'000, 'n')).codes(), "P1007");
  EXPECT_EQ(named("a/b").codes(), "P1007");
  EXPECT_EQ(named("..\\b").codes(), "P1007");
  EXPECT_EQ(named("a&#9;b").codes(), "P1007");
  EXPECT_EQ(named("\xC3\x84ndern").codes(), "");
}

TEST(Attributes, MissingOnesAreNamed) {
  EXPECT_EQ(read_text(ladder("<contact><variable>a</variable></contact>")).codes(), "P1009");
  EXPECT_EQ(read_text(ladder("<block localId=\"1\"/>")).codes(), "P1009");
  EXPECT_EQ(read_text(ladder("<jump localId=\"1\"/>")).codes(), "P1009");
  EXPECT_EQ(
      read_text(ladder("<coil localId=\"1\"><connectionPointIn><connection/></connectionPointIn></coil>")).codes(),
      "P1009");
  EXPECT_EQ(read_text(program("<ST/>", "<localVars><variable/></localVars>")).codes(), "P1009");
  EXPECT_EQ(read_text(tc6("<pous><pou pouType=\"program\"><body><ST/></body></pou></pous>")).codes(), "P1009");
  EXPECT_EQ(read_text(tc6("<pous><pou name=\"a\"><body><ST/></body></pou></pous>")).codes(), "P1009");
  EXPECT_EQ(
      read_text(
          tc6("", "<configuration name=\"c\"><resource name=\"r\"><task priority=\"1\"/></resource></configuration>"))
          .codes(),
      "P1009");
}

TEST(Attributes, BadValuesAreNamed) {
  for (const std::string_view attribute :
       {"localId=\"x\"", "localId=\"-4\"", "localId=\"99999999999999999999\"", "localId=\"1\" negated=\"maybe\"",
        "localId=\"1\" edge=\"up\"", "localId=\"1\" storage=\"keep\"", "localId=\"1\" executionOrderId=\"1.5\"",
        "localId=\"1\" width=\"wide\""}) {
    EXPECT_EQ(read_text(ladder("<coil " + std::string(attribute) + "><variable>a</variable></coil>")).codes(), "P1010")
        << attribute;
  }
  EXPECT_EQ(read_text(ladder("<coil localId=\"1\"><position x=\"1e99\" y=\"0\"/></coil>")).codes(), "P1010");
  EXPECT_EQ(read_text(tc6("<pous><pou name=\"a\" pouType=\"class\"><body><ST/></body></pou></pous>")).codes(), "P1010");
}

TEST(Pous, WithoutBodyAndTwice) {
  EXPECT_EQ(read_text(tc6("<pous><pou name=\"a\" pouType=\"program\"><interface/></pou></pous>")).codes(), "P1011");
  const auto r =
      read_text(tc6("<pous><pou name=\"a\" pouType=\"program\"><body><ST/></body></pou>\n<pou name=\"A\" "
                    "pouType=\"function\"><body><ST/></body></pou></pous>"));
  EXPECT_EQ(r.codes(), "P1012");
  EXPECT_EQ(r.project->pous.size(), 2u);
}

TEST(Problems, AllOfOneRunAreReported) {
  const auto r =
      read_text(tc6("<pous><pou name=\"a/b\" pouType=\"x\"><interface/><body><LD><coil/><contact localId=\"y\" "
                    "edge=\"z\"/></LD></body></pou><pou/></pous><odd/>"));
  EXPECT_EQ(r.codes(), "P1007 P1010 P1009 P1010 P1010 P1009 P1009 P1011 P1013");
  EXPECT_NE(r.project, nullptr);
}

}  // namespace
}  // namespace plc::plcopen
