// Sheets: parts of a drawing have what touches them, in a bounded number of bounded pieces, and pages end between
// rungs.
#include "pictures/sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "bytecode/drawings.h"

namespace plc::test {
namespace {

using namespace bytecode;
using pictures::Look;
using pictures::Marks;
using pictures::Sheet;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

/// Rungs of a contact and a coil below each other, 100 pixels apart.
DrawnBody ladder(int rungs) {
  DrawnBody body;
  body.name = "Main";
  body.sheets = {"Main"};
  for (int i = 0; i < rungs; ++i) {
    const auto y = static_cast<std::int32_t>(i * 100);
    for (const auto& [kind, x] :
         {std::pair(core::ElementKind::kContact, 60), std::pair(core::ElementKind::kCoil, 160)}) {
      DrawnElement e;
      e.kind = kind;
      e.local_id = static_cast<std::int64_t>(body.elements.size());
      e.network = static_cast<std::uint32_t>(i + 1);
      e.x = x;
      e.y = y + 20;
      e.width = 20;
      e.height = 20;
      e.text = (kind == core::ElementKind::kCoil ? "Out" : "In") + std::to_string(i);
      e.pins = {{"", "", false, 0, {}, {x, y + 30}}, {"", "", true, 0, {}, {x + 20, y + 30}}};
      body.elements.push_back(e);
    }
    const auto first = static_cast<std::uint32_t>(2 * i);
    body.wires.push_back({first, 1, first + 1, 0, {{80, y + 30}, {160, y + 30}}});
  }
  return body;
}

Marks numbered(const DrawnBody& body) {
  Marks marks;
  std::int64_t id = 0;
  for (const DrawnElement& e : body.elements) {
    marks[key_of(0, e)].id = id++;
    marks[key_of(0, e, e.pins[1])].id = id++;
  }
  return marks;
}

TEST(Sheet, PartsHaveWhatTouchesThem) {
  const DrawnBody body = ladder(100);
  const pictures::PicturedBody one{&body, "", 0};
  const Sheet sheet({&one, 1}, numbered(body));
  EXPECT_GE(sheet.height(), 9940);
  const Sheet::Part part = sheet.draw(0, 5000, 400, 90, 1000);
  EXPECT_EQ(part.left_out, 0u);
  EXPECT_NE(part.svg.find("data-name=\"In50\""), std::string::npos) << part.svg;
  EXPECT_NE(part.svg.find("data-e=\"0.100\""), std::string::npos) << "its number";
  EXPECT_EQ(part.svg.find("In52"), std::string::npos);
  EXPECT_EQ(part.svg.find("In48"), std::string::npos);
  EXPECT_EQ(part.svg.find("<style"), std::string::npos);
  // A contact, its value, and the wire behind it can be found.
  EXPECT_EQ(count(part.svg, "data-k=\"200\""), 2u) << part.svg;
  EXPECT_NE(part.svg.find("<polyline class=\"wire\" data-k=\"201\""), std::string::npos) << part.svg;
  const auto place = sheet.place_of(0, 100);
  ASSERT_TRUE(place);
  EXPECT_LE(place->y, 5020);
  EXPECT_GE(place->y + place->height, 5040);
  EXPECT_FALSE(sheet.place_of(0, 200));
  EXPECT_FALSE(sheet.place_of(1, 0));
}

TEST(Sheet, ATileIsBoundedWhateverIsDrawn) {
  DrawnBody body = ladder(1);
  body.elements.resize(2);
  // 10^5 elements at one place, and wires that pass it.
  for (int i = 0; i < 100'000; ++i) {
    body.elements.push_back(body.elements[0]);
    body.wires.push_back({0, 1, 1, 0, {{80, -100'000}, {80, 100'000}}});
  }
  body.elements[0].text = std::string(10'000'000, 'x');
  body.comments.push_back({std::string(1'000'000, '\n'), 0, 0, 0, 10, 10});
  const pictures::PicturedBody one{&body, "", 0};
  const Sheet sheet({&one, 1}, {});
  const Sheet::Part part = sheet.draw(0, 0, 400, 100, 1000);
  EXPECT_GT(part.left_out, 198'000u);
  EXPECT_LT(part.svg.size(), 1'000'000u);
  EXPECT_GT(count(part.svg, "<g class=\"contact\""), 900u) << "long wires go first";
  EXPECT_EQ(count(part.svg, "<g "), count(part.svg, "</g>"));
}

TEST(Sheet, PagesEndBetweenRungs) {
  const DrawnBody body = ladder(50);
  const pictures::PicturedBody one{&body, "", 0};
  const Sheet sheet({&one, 1}, {});
  const auto breaks = sheet.breaks();
  ASSERT_EQ(breaks.size(), 49u);
  EXPECT_TRUE(std::is_sorted(breaks.begin(), breaks.end()));
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    EXPECT_GT(breaks[i], static_cast<int>(i) * 100 + 40);
    EXPECT_LT(breaks[i], static_cast<int>(i + 1) * 100 + 20);
  }
}

TEST(Sheet, PagesDoNotEndBelowAComment) {
  DrawnBody body = ladder(2);
  for (DrawnElement& e : body.elements) {
    if (e.network != 2) continue;
    e.y += 200;
    for (auto& pin : e.pins) pin.at.y += 200;
  }
  for (auto& point : body.wires[1].points) point.y += 200;
  body.comments.push_back({});
  body.comments[0].y = 120;
  body.comments[0].width = 200;
  body.comments[0].height = 20;
  body.comments[0].text = "the second rung";
  const pictures::PicturedBody one{&body, "", 0};
  const auto breaks = Sheet({&one, 1}, {}).breaks();
  ASSERT_EQ(breaks.size(), 1u);
  EXPECT_LT(breaks[0], 120 + 50) << "above the comment";
}

TEST(Sheet, TextsHaveNamesAndPlacesForValues) {
  DrawnBody body;
  body.name = "Calc";
  body.language = DrawnLanguage::kSt;
  body.text = "a := <b>;\nc := d;";
  body.text_line = 9;
  body.text_column = 1;
  body.statements = {{9, 1, 9, 10}, {10, 1, 10, 8}};
  Marks marks;
  marks[key_of(0, body.statements[1])].id = 7;
  marks[{0, -1, 10, 6, 0, DrawnSide::kOutput}].id = 8;
  const pictures::PicturedBody one{&body, "", 0};
  const Sheet sheet({&one, 1}, marks);
  const std::string svg = sheet.draw(0, 0, 1000, 1000, 100).svg;
  EXPECT_NE(svg.find("a := &lt;b&gt;;"), std::string::npos) << svg;
  EXPECT_EQ(count(svg, "data-k=\"7\""), 2u) << "bar and line";
  EXPECT_NE(svg.find("data-name=\"d\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("<tspan data-k=\"8\" data-words=\"1\"></tspan>"), std::string::npos) << svg;
  ASSERT_TRUE(sheet.place_of(0, 1));
  EXPECT_GT(sheet.place_of(0, 1)->y, sheet.place_of(0, 0)->y);
}

}  // namespace
}  // namespace plc::test
