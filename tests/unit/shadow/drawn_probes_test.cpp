// Drawings and probes are made by different steps of the compiler: each place of one is a place of the other. And what
// a drawing shows where EN is FALSE, worked out by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/drawings.h"
#include "tests/support/golden.h"
#include "tests/unit/shadow/looked.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using bytecode::DrawnBody;
using bytecode::DrawnElement;
using bytecode::DrawnKey;
using bytecode::DrawnSide;
using core::ElementKind;

/// As drawings have it of a pin without a key.
constexpr std::uint16_t kNoPin = 0xffff;
/// More pins than any block of the library and the cases has.
constexpr std::uint16_t kMostAdded = 64;

std::set<DrawnKey> places_of(const DrawnBody& body) {
  std::set<DrawnKey> places;
  for (const DrawnElement& e : body.elements) {
    for (const DrawnSide side : {DrawnSide::kWhole, DrawnSide::kInput, DrawnSide::kOutput}) {
      DrawnKey key = bytecode::key_of(0, e);
      key.side = side;
      places.insert(key);
    }
    for (const bytecode::DrawnPin& pin : e.pins) places.insert(bytecode::key_of(0, e, pin));
    // Pins that the compiler adds to a block follow those that are drawn.
    for (const DrawnSide side : {DrawnSide::kInput, DrawnSide::kOutput}) {
      if (e.kind != ElementKind::kBlock) break;
      DrawnKey key = bytecode::key_of(0, e);
      key.side = side;
      for (const bytecode::DrawnPin& pin : e.pins) {
        const bool counts = pin.output == (side == DrawnSide::kOutput) && pin.pin != kNoPin;
        if (counts) key.pin = std::max<std::uint16_t>(key.pin, static_cast<std::uint16_t>(pin.pin + 1));
      }
      for (const std::uint16_t end = key.pin + kMostAdded; key.pin < end; ++key.pin) places.insert(key);
    }
    for (std::size_t a = 0; a < e.actions.size(); ++a) places.insert(bytecode::key_of(0, e, a));
  }
  for (const bytecode::DrawnStatement& statement : body.statements) places.insert(bytecode::key_of(0, statement));
  return places;
}

/// Elements that always show something: a step is active or not, a transition fires or not, a contact conducts or not.
/// To a coil and a contact a wire has to lead.
bool shows_itself(const DrawnBody& body, std::uint32_t element) {
  const ElementKind kind = body.elements[element].kind;
  if (kind != ElementKind::kContact && kind != ElementKind::kCoil)
    return kind == ElementKind::kStep || kind == ElementKind::kTransition;
  return std::any_of(body.wires.begin(), body.wires.end(),
                     [element](const bytecode::DrawnWire& wire) { return wire.to == element; });
}

struct Joined {
  std::size_t probes = 0, of_texts = 0, elements = 0;
  std::vector<std::string> lost;
};

std::string place_text(const std::string& file, const std::string& pou, const DrawnKey& key) {
  return file + ": " + pou + " " + std::to_string(key.line) + ":" + std::to_string(key.column) + " localId " +
         std::to_string(key.local_id) + " pin " + std::to_string(key.pin) + " side " +
         std::to_string(static_cast<int>(key.side));
}

void join(const fs::path& path, Joined& joined) {
  compiler::Compilation compilation;
  compiler::Request request{path.string(), {}, compiler::Goal::kRun};
  request.drawings = true;
  compiler::compile(request, compilation);
  if (!compilation.image) return;  // a case of an error
  const bytecode::Image& image = compilation.image->image();
  auto drawings = bytecode::unpack(image.drawings);
  ASSERT_TRUE(drawings) << path;
  std::map<std::string, std::vector<const DrawnBody*>> bodies;
  for (const DrawnBody& body : drawings->bodies) bodies[body.name].push_back(&body);
  for (std::size_t p = 0; p < image.probes.size(); ++p) {
    const auto of_pou = bodies.find(image.pous[p].name);
    if (of_pou == bodies.end()) continue;  // a block of the library
    std::set<DrawnKey> places;
    bool is_st = true;
    for (const DrawnBody* const body : of_pou->second) {
      places.merge(places_of(*body));
      is_st = is_st && body->language == bytecode::DrawnLanguage::kSt;
    }
    std::set<DrawnKey> probed;
    for (const bytecode::ProbePoint& point : image.probes[p].points) {
      ++joined.probes;
      probed.insert(point.key);
      // Names and expressions in texts, also those at pins and in EXECUTE boxes, are places by themselves; so are the
      // statements of such a box, and those that an instruction of IL becomes. Of ST each statement is listed.
      if (point.key.local_id == -1 && (point.key.side == DrawnSide::kOutput || !is_st)) {
        ++joined.of_texts;
      } else if (places.count(point.key) == 0) {
        joined.lost.push_back(place_text(path.string(), image.pous[p].name, point.key));
      }
    }
    if (probed.empty()) continue;  // nothing calls it
    for (const DrawnBody* const body : of_pou->second) {
      for (std::uint32_t e = 0; e < body->elements.size(); ++e) {
        if (!shows_itself(*body, e)) continue;
        ++joined.elements;
        const DrawnKey key = bytecode::key_of(0, body->elements[e]);
        if (probed.count(key) == 0) joined.lost.push_back("no probe: " + place_text(path.string(), body->name, key));
      }
    }
  }
}

void expect_joined(const Joined& joined) {
  std::printf("%zu probes, %zu of them in texts; %zu steps, transitions, contacts and coils\n", joined.probes,
              joined.of_texts, joined.elements);
  EXPECT_TRUE(joined.lost.empty()) << joined.lost.size();
  for (std::size_t i = 0; i < std::min<std::size_t>(joined.lost.size(), 20); ++i) ADD_FAILURE() << joined.lost[i];
}

TEST(DrawnProbes, EachIsAPlaceOfItsDrawing) {
  std::set<fs::path> paths;
  for (const char* const folder : {"examples", "tests/cases"}) {
    for (const auto& entry : fs::recursive_directory_iterator(source_root() / folder)) {
      if (entry.path().extension() == ".xml" || entry.path().extension() == ".st") paths.insert(entry.path());
    }
  }
  Joined joined;
  for (const fs::path& path : paths) join(path, joined);
  expect_joined(joined);
  EXPECT_GT(joined.probes, 5'000u);
  EXPECT_GT(joined.elements, 1'000u);
}

TEST(DrawnProbes, EachIsAPlaceInRealProjects) {
  const fs::path folder = source_root() / "../shared/corpus";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no real projects at " << folder;
  Joined joined;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".xml") join(entry.path(), joined);
  }
  expect_joined(joined);
}

/// The pin of an element of the drawn program "Logic".
std::string shown(const Looked& looked, const shadow::ProbeView& view, std::int64_t local_id, DrawnSide side,
                  const std::string& pin = "") {
  auto drawings = bytecode::unpack(looked.image->image().drawings);
  if (!drawings) return "no drawings";
  for (const DrawnBody& body : drawings->bodies) {
    if (body.name != "Logic") continue;
    for (const DrawnElement& e : body.elements) {
      if (e.local_id != local_id) continue;
      DrawnKey key = bytecode::key_of(0, e);
      key.side = side;
      for (const bytecode::DrawnPin& one : e.pins) {
        if (!pin.empty() && one.name == pin) key = bytecode::key_of(0, e, one);
      }
      const auto at = view.at(key);
      if (!at) return "no probe";
      return !at->ran ? "not run" : at->known ? view.text(key) : "ran";
    }
  }
  return "no element";
}

// tests/cases/fbd/a-function-under-en-gives-its-default: Go and N (1, 2) feed GT (4) with EN, whose output goes to
// Kept (5) and to OR (7), which gives Alarm (8).
TEST(DrawnProbes, BehindEnThatIsFalseNothingRan) {
  Looked looked(ProjectFile{source_root() / "tests/cases/fbd/a-function-under-en-gives-its-default/project.xml"});
  shadow::ProbeView view = looked.look_at("Logic");
  ASSERT_TRUE(view.any());
  looked.set("main.N", "7");
  looked.set("main.Go", "1");
  looked.scan();
  EXPECT_EQ(shown(looked, view, 4, DrawnSide::kInput, "EN"), "TRUE");
  EXPECT_EQ(shown(looked, view, 4, DrawnSide::kInput, "IN1"), "7");
  EXPECT_EQ(shown(looked, view, 4, DrawnSide::kOutput, "OUT"), "TRUE");
  EXPECT_EQ(shown(looked, view, 5, DrawnSide::kWhole), "TRUE");
  EXPECT_EQ(shown(looked, view, 8, DrawnSide::kWhole), "TRUE");
  looked.set("main.Go", "0");
  view.clear();
  looked.scan();
  EXPECT_EQ(shown(looked, view, 4, DrawnSide::kInput, "EN"), "FALSE");
  // What the function puts on its wires is the default of the type, which OR works with. Kept is not written.
  EXPECT_EQ(shown(looked, view, 7, DrawnSide::kInput, "IN1"), "FALSE");
  EXPECT_EQ(shown(looked, view, 8, DrawnSide::kWhole), "FALSE");
  EXPECT_EQ(shown(looked, view, 5, DrawnSide::kInput), "FALSE");
  EXPECT_EQ(shown(looked, view, 5, DrawnSide::kWhole), "TRUE") << "what the variable has";
}

}  // namespace
}  // namespace plc::test
