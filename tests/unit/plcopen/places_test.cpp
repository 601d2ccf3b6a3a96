// Lines and columns, encodings, line ends.
#include <chrono>

#include "plcopen/input_text.h"
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

TEST(Places, StartOfTheTagEvenOverSeveralLines) {
  const std::string xml = ladder(
      "\n\n   <contact\n localId=\"2\"\n negated=\"false\"  >\n <connectionPointIn ><connection\n "
      "refLocalId=\"1\"/></connectionPointIn><variable>\n\n   Start  </variable></contact>");
  const auto r = read_clean(xml);
  const Element& e = body_of(r).elements.at(0);
  EXPECT_EQ(place(e.at), place_of(xml, "<contact"));
  EXPECT_EQ(place(e.text_at), place_of(xml, "Start"));
  EXPECT_EQ(place(e.inputs.at(0).at), place_of(xml, "<connectionPointIn"));
  EXPECT_EQ(place(e.inputs.at(0).connections.at(0).at), place_of(xml, "<connection\n"));
}

TEST(Places, GreaterThanInsideAttributesDoesNotConfuse) {
  const std::string xml = program("<ST/>",
                                  "<localVars><variable  name=\"a\" address=\"x>y\"><initialValue><simpleValue "
                                  "value=\"a > b\"/></initialValue></variable>\n<variable name=\"b\"/></localVars>");
  const auto r = read_clean(xml);
  EXPECT_EQ(place(r.project->pous.at(0).variables.at(0).at), place_of(xml, "<variable  name"));
  EXPECT_EQ(place(r.project->pous[0].variables.at(1).at), place_of(xml, "<variable name=\"b\""));
}

TEST(Places, BeyondLine65535) {
  const std::string xml = ladder(std::string(70'000, '\n') + "  <coil localId=\"1\"><variable>a</variable></coil>");
  const auto r = read_clean(xml);
  EXPECT_EQ(place(body_of(r).elements.at(0).at), place_of(xml, "<coil"));
  EXPECT_GT(body_of(r).elements[0].at.line, 70'000u);
}

TEST(Places, OneLineFileTakesLinearTime) {
  std::string elements;
  for (int i = 0; i < 30'000; ++i)
    elements += "<coil localId=\"" + std::to_string(i) + "\"><variable>a</variable></coil>";
  const std::string xml = ladder(elements);
  const auto r = read_clean(xml);
  const std::vector<Element>& e = body_of(r).elements;
  ASSERT_EQ(e.size(), 30'000u);
  EXPECT_EQ(place(e[29'999].at), place_of(xml, "<coil localId=\"29999\""));
}

TEST(Places, TextInsideCdataAndParagraphs) {
  const std::string xml = program("<ST>\n<!-- c -->\n <xhtml:p><![CDATA[\n\n  first;\n second;]]></xhtml:p></ST>");
  const auto r = read_clean(xml);
  EXPECT_EQ(body_of(r).text, "first;\n second;");
  EXPECT_EQ(place(body_of(r).text_at), place_of(xml, "first;"));
}

TEST(Places, LinesOfSeveralParagraphsStayTheLinesOfTheFile) {
  const std::string xml =
      program("<ST><xhtml:p>one;</xhtml:p>\n<xhtml:p>two;</xhtml:p>\n\n<xhtml:p>three;</xhtml:p></ST>");
  const auto r = read_clean(xml);
  EXPECT_EQ(body_of(r).text, "one;\ntwo;\n\nthree;");
}

TEST(Places, ParagraphsAndBreaksAreLinesWhereTheFileHasNone) {
  const auto text = [](const std::string& st) { return body_of(read_clean(program("<ST>" + st + "</ST>"))).text; };
  EXPECT_EQ(text("<xhtml:p>a; // one</xhtml:p><xhtml:p>b;</xhtml:p>"), "a; // one\nb;");
  EXPECT_EQ(text("<xhtml:p>a; // one<xhtml:br/>b;<xhtml:br/>\nc;</xhtml:p>"), "a; // one\nb;\nc;");
  EXPECT_EQ(text("<xhtml:div>a;</xhtml:div> <xhtml:div> b;</xhtml:div>"), "a;\n  b;");
  EXPECT_EQ(text("<xhtml:p><xhtml:b>a</xhtml:b> <xhtml:i>:=</xhtml:i> 1;</xhtml:p>"), "a := 1;");
  EXPECT_EQ(text("<xhtml:p/><xhtml:p>a;</xhtml:p><xhtml:p/>"), "a;");
}

TEST(Places, BreaksBetweenBlanksTakeLinearTime) {
  std::string text = "a;";
  for (int i = 0; i < 200'000; ++i) text += "<xhtml:br/> ";
  const auto begin = std::chrono::steady_clock::now();
  const auto r = read_clean(program("<ST><xhtml:p>" + text + "b;</xhtml:p></ST>"));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(body_of(r).text, "a;\n" + std::string(200'000, ' ') + "b;");
  EXPECT_LT(took.count(), 10.0);
}

TEST(Places, CarriageReturnsAndByteOrderMark) {
  std::string xml = ladder(
      "\n  <coil localId=\"1\"><variable>a</variable></coil>\n<coil localId=\"2\"><variable>b</variable></coil>");
  std::string crlf = "\xEF\xBB\xBF";
  for (const char c : xml) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const auto plain = read_clean(xml);
  const auto other = read_clean(crlf);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(place(body_of(plain).elements.at(i).at), place(body_of(other).elements.at(i).at));
}

TEST(Places, DoubledCarriageReturnsAreOneLineEnd) {
  const std::string xml = program("<ST>\r\r\n a;\r\r\n\r\r\n b;\r\r\n</ST>");
  const auto r = read_clean(xml);
  EXPECT_EQ(body_of(r).text, "a; \n \n b;");
  EXPECT_EQ(place(body_of(r).text_at), place_of(xml, "a;"));
  EXPECT_TRUE(r.diagnostics.text_jumps(r.project->file)->all().empty());
}

/// "1:4>1:8": what is at column 4 is followed by what is at column 8.
std::string jumps_of(const ReadResult& r) {
  std::string out;
  for (const core::TextJumps::Jump& jump : r.diagnostics.text_jumps(r.project->file)->all()) {
    out += (out.empty() ? "" : " ") + std::to_string(jump.at.line) + ':' + std::to_string(jump.at.column) + '>' +
           std::to_string(jump.next.line) + ':' + std::to_string(jump.next.column);
  }
  return out;
}

TEST(Places, TextsJumpAfterEntitiesSectionsAndLoneReturns) {
  const auto jumps = [](const std::string& text) { return jumps_of(read_clean(program("<ST>\n" + text + "</ST>"))); };
  EXPECT_EQ(jumps("a\n\xC3\xA4 b"), "");
  EXPECT_EQ(jumps("a&lt;b"), "5:2>5:6");
  EXPECT_EQ(jumps("a&#60;&#x3c;b;"), "5:2>5:7 5:7>5:13");
  EXPECT_EQ(jumps("a<![CDATA[b&]]>c"), "5:1>5:11 5:12>5:16");
  EXPECT_EQ(jumps("<![CDATA[a]]><![CDATA[b]]>"), "5:10>5:23");
  EXPECT_EQ(jumps("a<!-- x\n -->b"), "5:1>6:5");
  EXPECT_EQ(jumps("a\rb"), "5:2>5:3");
  EXPECT_EQ(jumps("a<xhtml:b>c</xhtml:b>"), "5:1>5:11");
  EXPECT_EQ(jumps("a<xhtml:br/>b"), "5:1>5:12 5:12>5:13");
}

TEST(Places, ValuesOfAttributesHavePlacesOfTheirOwn) {
  const std::string xml =
      program("<ST/>",
              "<localVars><variable name=\"a\"><type><array><dimension upper=\"N - 1\"\n lower='2'/><baseType><INT/>"
              "</baseType></array></type><initialValue><simpleValue\n value = ' 3 &amp; x'/></initialValue>"
              "</variable></localVars>");
  const auto r = read_clean(xml);
  const Variable& a = r.project->pous.at(0).variables.at(0);
  EXPECT_EQ(place(a.type.dimensions.at(0).upper_at), place_of(xml, "N - 1"));
  EXPECT_EQ(place(a.type.dimensions.at(0).lower_at), place_of(xml, "2'"));
  EXPECT_EQ(a.initial.text, "3 & x");
  EXPECT_EQ(place(a.initial.at), place_of(xml, "3 &amp;"));
}

TEST(Places, ColumnsCountCharacters) {
  const auto r = read_clean(
      ladder("\n<comment localId=\"9\" width=\"1\" height=\"1\"><content>\xC3\xA4\xE2\x82\xAC</content></comment><coil "
             "localId=\"1\"><variable>\xC3\xA4</variable></coil>"));
  // 9 + 58 characters come before the coil: both umlaut and euro sign count once.
  EXPECT_EQ(
      body_of(r).elements.at(0).at.column,
      std::string_view("<comment localId=\"9\" width=\"1\" height=\"1\"><content>xx</content></comment>").size() + 1);
  EXPECT_EQ(body_of(r).elements[0].text, "\xC3\xA4");
}

std::string utf16(std::string_view ascii, bool big, bool mark) {
  std::string out;
  const auto put = [&](unsigned unit) {
    out += static_cast<char>(big ? unit >> 8 : unit & 0xFF);
    out += static_cast<char>(big ? unit & 0xFF : unit >> 8);
  };
  if (mark) put(0xFEFF);
  for (const char c : ascii) put(c == '?' ? 0xE4u : static_cast<unsigned char>(c));
  return out;
}

TEST(Encoding, Utf16InBothOrdersWithAndWithoutMark) {
  const std::string xml = ladder("\n <coil localId=\"1\"><variable>?a</variable></coil>");
  for (const bool big : {false, true}) {
    for (const bool mark : {false, true}) {
      const auto r = read_clean(utf16("<!-- encoding=\"utf-16\" -->" + xml, big, mark));
      EXPECT_EQ(body_of(r).elements.at(0).text,
                "\xC3\xA4"
                "a");
      EXPECT_EQ(place(body_of(r).elements[0].at), place_of(xml, "<coil"));
    }
  }
}

TEST(Encoding, Latin1AndWindows1252) {
  const std::string xml = ladder("<coil localId=\"1\"><variable>\xE4</variable></coil>");
  EXPECT_EQ(body_of(read_clean("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + xml)).elements.at(0).text,
            "\xC3\xA4");
  const std::string euro = ladder("<coil localId=\"1\"><variable>\x80</variable></coil>");
  EXPECT_EQ(body_of(read_clean("<?xml version='1.0' encoding='windows-1252'?>" + euro)).elements.at(0).text,
            "\xE2\x82\xAC");
}

TEST(Encoding, DeclaredUtf16ThatIsUtf8IsRead) {
  EXPECT_EQ(read_clean("<?xml version=\"1.0\" encoding=\"utf-16\"?>" + tc6("")).project->name, "demo");
}

TEST(Encoding, UnknownAndBrokenOnesAreRefused) {
  EXPECT_EQ(read_text("<?xml version=\"1.0\" encoding=\"EBCDIC-CP-US\"?><project/>").codes(), "P1014");
  const auto r = read_text(ladder("<coil localId=\"1\"><variable>\xE4\xE4</variable></coil>"));
  EXPECT_EQ(r.codes(), "P1002");
  EXPECT_EQ(r.project, nullptr);
}

TEST(PlaceFinder, AscendingAndBackwards) {
  PlaceFinder finder("ab\ncd\r\n\xC3\xA4x");
  EXPECT_EQ(finder.at(4).line, 2u);
  EXPECT_EQ(finder.at(4).column, 2u);
  EXPECT_EQ(finder.at(9).line, 3u);
  EXPECT_EQ(finder.at(9).column, 2u);
  EXPECT_EQ(finder.at(1).column, 2u);
  EXPECT_EQ(finder.at(1000).column, 3u);
}

}  // namespace
}  // namespace plc::plcopen
