// pages.toml read and written again: the same bytes, comments where they were, and mistakes with their places.
#include "hmi/document.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "core/toml_limits.h"

namespace plc::hmi {
namespace {

constexpr const char* kStation = R"(# Pages of the mixing station.
# Keep in step with the panel.

# What operators see first.
[[page]]
name = "station"
title = "Mixing \"station\"\tA"
columns = 24
rows = 14

# Level in percent.
[[page.element]]
kind = "tank"
x = 2
y = 1
width = 4
height = 6
label = "Tank ä"
variable = "Level"
format = "0.0"
unit = "%"
low = -0.5
high = 100

[[page.element]]
kind = "button"
x = 10
y = 1
width = 3
height = 2
variable = "Start"

[[page.element]]
kind = "button"
x = 14
y = 1
width = 3
height = 2
variable = "Mode"
value = "Automatic"

[[page.element]]
kind = "number"
x = 10
y = 4
width = 4
height = 2
variable = "Setpoint"
step = 0.1
entered = true

[[page.element]]
kind = "plot"
x = 0
y = 8
width = 8
height = 5
variables = ["Level", "Temperature"]
seconds = 120

[[page.element]]
kind = "alarms"
x = 10
y = 8
width = 10
height = 5
label = "Mixing"
class = "process"

[[page.element]]
kind = "link"
x = 20
y = 0
width = 4
height = 2
page = "second"

[[page]]
name = "second"
columns = 10
rows = 10

[[page.element]]
kind = "picture"
x = 0
y = 0
width = 6
height = 4
label = "Plant"
file = "plant.svg"
)";

/// What the reader says, a line for each; empty when it takes the text.
std::string problems(const std::string& text) {
  core::Diagnostics diagnostics;
  const auto document = read_document(text, "pages.toml", diagnostics);
  EXPECT_EQ(document.has_value(), !diagnostics.has_errors());
  std::ostringstream out;
  diagnostics.render(out);
  return out.str();
}

Document read(const std::string& text) {
  core::Diagnostics diagnostics;
  auto document = read_document(text, "pages.toml", diagnostics);
  std::ostringstream out;
  diagnostics.render(out);
  EXPECT_TRUE(document) << out.str();
  return document ? std::move(*document) : Document();
}

/// A page with this text in its only element.
std::string on_page(const std::string& element) { return "[[page]]\nname = \"a\"\n[[page.element]]\n" + element; }

TEST(Document, IsWrittenAsItWasRead) { EXPECT_EQ(write_document(read(kStation)), kStation); }

TEST(Document, HasWhatTheTextSays) {
  const Document document = read(kStation);
  ASSERT_EQ(document.pages.size(), 2u);
  const Page& page = document.pages[0];
  EXPECT_EQ(page.title, "Mixing \"station\"\tA");
  ASSERT_EQ(page.elements.size(), 7u);
  EXPECT_EQ(page.elements[0].kind, Kind::kTank);
  EXPECT_EQ(page.elements[0].number(key("low")), -0.5);
  EXPECT_EQ(page.elements[0].text(key("label")), "Tank ä");
  EXPECT_EQ(page.elements[0].at.line, 12u);
  EXPECT_EQ(page.elements[0].comment, std::vector<std::string>{" Level in percent."});
  EXPECT_EQ(page.comment, std::vector<std::string>{" What operators see first."});
  EXPECT_EQ(document.comment.size(), 2u);
  EXPECT_TRUE(page.elements[3].is_true(key("entered")));
  EXPECT_EQ(std::get<std::vector<std::string>>(page.elements[4].values[key("variables")]).size(), 2u);
}

TEST(Document, OfAnotherFormBecomesOneOfThisForm) {
  const Document document = read(
      "page = [\n  { name = \"a\", element = [ { kind = 'lamp', variable = 'Lamp', y = 0x1, x = 1_0 } ] }, # at the "
      "end\n"
      "]\n# after all\n");
  const std::string text = write_document(document);
  EXPECT_EQ(text,
            "[[page]]\nname = \"a\"\ncolumns = 24\nrows = 14\n\n# at the end\n# after all\n[[page.element]]\nkind = "
            "\"lamp\"\nx = 10\ny = 1\nwidth = 3\nheight = 2\nvariable = \"Lamp\"\n");
  EXPECT_EQ(write_document(read(text)), text);
}

TEST(Document, KeepsCommentsWithTheirTable) {
  const std::string text = "# head\n\n[[page]] # of the page\nname = \"a#b\" # no name\n";
  EXPECT_NE(problems(text).find("pages.toml:4:8: error P7772"), std::string::npos) << problems(text);
  const Document document = read(
      "# head\n\n[[page]] # of the page\nname = \"a\"\ntitle = \"a # in a text\"\n# before a lamp\n\n[[page.element]]\n"
      "kind = \"lamp\"\n# inside of it\nx = 0\ny = 0\nvariable = \"\"\"\n# no comment\"\"\" # behind\n");
  EXPECT_EQ(document.comment, std::vector<std::string>{" head"});
  EXPECT_EQ(document.pages[0].comment, std::vector<std::string>{" of the page"});
  EXPECT_EQ(document.pages[0].elements[0].comment,
            (std::vector<std::string>{" before a lamp", " inside of it", " behind"}));
  const std::string written = write_document(document);
  EXPECT_EQ(write_document(read(written)), written);
}

TEST(Document, MayBeEmpty) {
  EXPECT_TRUE(read("").pages.empty());
  EXPECT_EQ(write_document(Document()), "");
}

struct Mistake {
  const char* text;
  const char* said;
};

TEST(Document, SaysWhatIsWrongWhere) {
  const Mistake mistakes[] = {
      {"[[page]\nname = 1\n", "pages.toml:1:8: error P7770"},
      {"[[page]]\nname = \"a\"\nname = \"b\"\n", "pages.toml:3:"},
      {"[[pages]]\nname = \"a\"\n", "pages.toml:1:1: error P7771: \"pages\" is no key here"},
      {"page = 1\n", "pages.toml:1:8: error P7772: page is a whole number"},
      {"[[page]]\n", "pages.toml:1:1: error P7773: name is missing"},
      {"[[page]]\nname = \"a b\"\n", "pages.toml:2:8: error P7772: \"a b\" is no name of a page"},
      {"[[page]]\nname = \"a\"\ncolumns = 0\n", "pages.toml:3:11: error P7774: columns is 0"},
      {"[[page]]\nname = \"a\"\ntile = \"A\"\n", "did you mean \"title\"?"},
      {"[[page]]\nname = \"a\"\n[[page]]\nname = \"a\"\n", "pages.toml:3:1: error P7775: there are two pages \"a\""},
  };
  for (const Mistake& one : mistakes)
    EXPECT_NE(problems(one.text).find(one.said), std::string::npos) << problems(one.text);
  const Mistake in_elements[] = {
      {"kind = \"lamp\"\nx = 0\ny = 0\n", "pages.toml:3:1: error P7773: variable of the lamp is missing"},
      {"kind = \"lmap\"\nx = 0\ny = 0\n", "did you mean \"lamp\"?"},
      {"kind = \"lamp\"\nvariable = \"A\"\n", "error P7773: x is missing"},
      {"kind = \"lamp\"\nx = 22\ny = 0\nvariable = \"A\"\n", "error P7774: the lamp ends at column 25"},
      {"kind = \"lamp\"\nx = -1\ny = 0\nvariable = \"A\"\n", "pages.toml:5:5: error P7774: x is -1"},
      {"kind = \"lamp\"\nx = 0\ny = 0\nvariable = 1\n", "pages.toml:7:12: error P7772: variable is a whole number"},
      {"kind = \"lamp\"\nx = 0\ny = 0\nvariable = \"A\"\nunit = \"m\"\n",
       "pages.toml:8:8: error P7771: \"unit\" is no key of a lamp"},
      {"kind = \"lamp\"\nx = 0\ny = 0\nvariable = \"A\"\ncolour = \"pink\"\n", "one of green|blue|yellow|red|grey"},
      {"kind = \"slider\"\nx = 0\ny = 0\nvariable = \"A\"\nlow = 100\n",
       "pages.toml:8:7: error P7772: high is 100, and should be more than low, 100"},
      {"kind = \"slider\"\nx = 0\ny = 0\nvariable = \"A\"\nlow = 100\nhigh = 50\n",
       "pages.toml:9:8: error P7772: high is 50, and should be more than low, 100"},
      {"kind = \"gauge\"\nx = 0\ny = 0\nvariable = \"A\"\nlow = nan\n", "low is no number of use"},
      {"kind = \"number\"\nx = 0\ny = 0\nvariable = \"A\"\nformat = \"%d\"\n", "\"%d\" is no format"},
      {"kind = \"number\"\nx = 0\ny = 0\nvariable = \"A\"\nstep = 0\n", "step is 0, and should be more than 0"},
      {"kind = \"plot\"\nx = 0\ny = 0\nvariables = []\n", "variables has 0 entries"},
      {"kind = \"plot\"\nx = 0\ny = 0\nvariables = [1]\n", "variables is a whole number, and should be texts"},
      {"kind = \"picture\"\nx = 0\ny = 0\nlabel = \"P\"\nfile = \"../../etc/shadow.png\"\n", "is no name of a picture"},
      {"kind = \"picture\"\nx = 0\ny = 0\nlabel = \"P\"\nfile = \"plc.toml\"\n", "is no name of a picture"},
      {"kind = \"link\"\nx = 0\ny = 0\npage = \"b\"\n", "pages.toml:7:8: error P7775: there is no page \"b\""},
  };
  for (const Mistake& one : in_elements) {
    EXPECT_NE(problems(on_page(one.text)).find(one.said), std::string::npos) << problems(on_page(one.text));
  }
}

TEST(Document, KeysHaveTheirPlaces) {
  const Document document = read(
      "[[page]]\nname = \"a\"\n[[page.element]]\nkind = \"plot\"\nx = 0\ny = 0\n"
      "variables = [\n  \"A\",\n]\n");
  const Element& element = document.pages.at(0).elements.at(0);
  EXPECT_EQ(element.place(key("variables")).line, 7u);
  EXPECT_EQ(element.place(key("variables")).column, 13u);
  EXPECT_EQ(element.place(key("label")), element.at) << "it is not there";
  EXPECT_EQ(element.at.line, 3u);
}

TEST(Document, LinesThatAreWrittenAreFieldsOfACall) {
  // Every line of the text, by what it is of.
  const std::string text = write_document(read(kStation));
  std::istringstream lines(text);
  std::uint32_t number = 0;
  std::string fields;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line == "[[page]]" || line == "[[page.element]]" || line.starts_with("variable") || line.starts_with("name"))
      fields += line.substr(0, line.find(' ')) + " " + field_of_line(text, number) + "\n";
  }
  const std::string begin =
      "[[page]] pages[0]\nname pages[0].name\n"
      "[[page.element]] pages[0].elements[0]\nvariable pages[0].elements[0].variable\n"
      "[[page.element]] pages[0].elements[1]\nvariable pages[0].elements[1].variable\n";
  EXPECT_EQ(fields.substr(0, begin.size()), begin);
  EXPECT_EQ(field_of_line(text, 0), "");
  EXPECT_EQ(field_of_line(text, 1), "") << "a comment of the file";
  EXPECT_EQ(field_of_line(text, number + 1), "");
  EXPECT_EQ(field_of_line("[[page]]\nname = \"a\"\n\n[[page]]\nname = \"[[page.element]]\"\n", 5), "pages[1].name");
}

TEST(Document, HasLimits) {
  EXPECT_NE(problems(std::string(core::kMaxTomlBytes + 1, '\n')).find("P7770"), std::string::npos);
  std::string deep = "a = ";
  EXPECT_NE(problems(deep + std::string(50, '[')).find("nested more than"), std::string::npos);
  std::string pages;
  for (std::size_t i = 0; i <= kMostPages; ++i) pages += "[[page]]\nname = \"p" + std::to_string(i) + "\"\n";
  EXPECT_NE(problems(pages).find("P7774"), std::string::npos);
  EXPECT_NE(problems("[[page]]\nname = \"a\"\ntitle = \"" + std::string(501, 'x') + "\"\n").find("more than 500"),
            std::string::npos);
}

TEST(Offers, AreWhatElementsWrite) {
  const std::vector<Offer> offers = offers_of(read(kStation));
  ASSERT_EQ(offers.size(), 3u);
  EXPECT_EQ(offers[0].way, Offer::Way::kPress);
  EXPECT_EQ(offers[0].path, "Start");
  EXPECT_EQ(offers[1].way, Offer::Way::kValue);
  EXPECT_EQ(std::get<std::string>(offers[1].value), "Automatic");
  EXPECT_EQ(offers[2].way, Offer::Way::kRange);
  EXPECT_FALSE(offers[2].low || offers[2].high);
  const std::vector<Offer> slider =
      offers_of(read(on_page("kind = \"slider\"\nx = 0\ny = 0\nvariable = \"A\"\nhigh = 7\n")));
  ASSERT_EQ(slider.size(), 1u);
  EXPECT_EQ(slider[0].low, 0.0);
  EXPECT_EQ(slider[0].high, 7.0);
  EXPECT_TRUE(offers_of(read(on_page("kind = \"number\"\nx = 0\ny = 0\nvariable = \"A\"\n"))).empty());
}

}  // namespace
}  // namespace plc::hmi
