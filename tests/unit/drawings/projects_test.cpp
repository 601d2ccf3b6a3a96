// Drawings of whole projects: the cases and examples of this repository, and real projects beside it. Properties hold
// of places as the files have them, and of the same drawings laid out by rule.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "drawings/make.h"
#include "tests/support/golden.h"
#include "tests/unit/drawings/properties.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;

void forget_places(plcopen::Body& body) {
  for (plcopen::Element& e : body.elements) {
    e.has_position = false;
    e.x = e.y = 0;
    if (e.chart && e.chart->macro) forget_places(*e.chart->macro);
  }
}

/// Sources feed readers to their right; in charts, readers below them. Wires that lead back are those of loops.
std::size_t forward_wires(const DrawnBody& body) {
  std::size_t count = 0;
  for (const DrawnWire& wire : body.wires) {
    const DrawnElement& from = body.elements[wire.from];
    const DrawnElement& to = body.elements[wire.to];
    const bool down = body.language == DrawnLanguage::kSfc && to.kind != core::ElementKind::kActionBlock;
    count += down ? from.y + from.height <= to.y : from.x + from.width <= to.x;
  }
  return count;
}

struct Sum {
  std::size_t bodies = 0, elements = 0, wires = 0, forward = 0, as_drawn = 0, drawn = 0, statements = 0;
};

void check_project(const fs::path& path, Sum& sum) {
  core::Diagnostics diagnostics;
  std::unique_ptr<plcopen::Project> project = compiler::read_project(path.string(), diagnostics);
  if (!project) return;
  const Drawings drawings = drawings::make(*project, diagnostics);
  EXPECT_EQ(drawings::make(*project, diagnostics), drawings) << "equal inputs, equal drawings";
  const auto again = unpack(pack(drawings));
  ASSERT_TRUE(again) << path;
  EXPECT_EQ(*again, drawings) << path;
  for (plcopen::Pou& pou : project->pous) {
    for (plcopen::Body& body : pou.bodies) forget_places(body);
    for (auto* parts : {&pou.actions, &pou.transitions}) {
      for (plcopen::Pou& part : *parts) {
        for (plcopen::Body& body : part.bodies) forget_places(body);
      }
    }
  }
  const Drawings by_rule = drawings::make(*project, diagnostics);
  ASSERT_EQ(by_rule.bodies.size(), drawings.bodies.size());
  for (std::size_t i = 0; i < drawings.bodies.size(); ++i) {
    const DrawnBody& body = drawings.bodies[i];
    const DrawnBody& ruled = by_rule.bodies[i];
    EXPECT_EQ(wrong_with(body), "") << path;
    EXPECT_EQ(wrong_with(ruled), "") << path << ", by rule";
    EXPECT_EQ(wrong_with_lines(ruled), "") << path << ", by rule";
    EXPECT_EQ(wires_on_each_other(ruled), "") << path << ", by rule";
    ++sum.bodies;
    sum.elements += body.elements.size();
    sum.wires += ruled.wires.size();
    sum.forward += forward_wires(ruled);
    sum.statements += body.statements.size();
    if (!body.elements.empty()) {
      ++sum.drawn;
      sum.as_drawn += body == ruled ? 0 : 1;
    }
  }
}

void report(const char* name, const Sum& sum) {
  std::printf(
      "%s: %zu bodies, %zu elements, %zu wires (%zu forward), %zu of %zu drawings as the file has them, %zu "
      "statements\n",
      name, sum.bodies, sum.elements, sum.wires, sum.forward, sum.as_drawn, sum.drawn, sum.statements);
}

TEST(Projects, OfThisRepositoryAreDrawnWell) {
  std::set<fs::path> paths;
  for (const char* folder : {"examples", "tests/cases", "taskblocks"}) {
    for (const auto& entry : fs::recursive_directory_iterator(source_root() / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".xml" || extension == ".st" || extension == ".TcPOU") paths.insert(entry.path());
    }
  }
  Sum sum;
  for (const fs::path& path : paths) check_project(path, sum);
  report("repository", sum);
  EXPECT_GT(sum.bodies, 500u);
  EXPECT_GT(sum.elements, 3000u);
  EXPECT_GT(sum.statements, 2000u);
  EXPECT_GT(sum.forward, sum.wires * 95 / 100) << "what leads back are loops alone";
}

TEST(Corpus, IsDrawnWell) {
  const fs::path folder = source_root() / "../shared/corpus";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no real projects at " << folder;
  Sum sum;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".xml") check_project(entry.path(), sum);
  }
  report("corpus", sum);
  EXPECT_GT(sum.elements, 600u);
  EXPECT_GT(sum.forward, sum.wires * 95 / 100);
}

}  // namespace
}  // namespace plc::test
