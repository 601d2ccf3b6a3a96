#include "ir/check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/module_builder.h"

namespace plc {
namespace {

using core::Code;
using test::ModuleBuilder;

bool has(const ModuleBuilder& m, Code code, const std::string& part) {
  return std::any_of(m.diagnostics.all().begin(), m.diagnostics.all().end(), [&](const core::Diagnostic& d) {
    return d.code == code && d.message.find(part) != std::string::npos;
  });
}

TEST(Check, RecursionIsReportedWithItsPath) {
  ModuleBuilder m;
  const auto f = m.pou("F", ir::PouKind::kFunction);
  const auto g = m.pou("G", ir::PouKind::kFunction);
  m.body(f).call_pou(g, {});
  m.body(g).call_pou(f, {});
  EXPECT_FALSE(ir::check(m.module, m.diagnostics));
  EXPECT_TRUE(has(m, Code::P4201, "F -> G -> F"));
  EXPECT_EQ(m.diagnostics.error_count(), 1u);
}

TEST(Check, BlockInsideItselfIsOneError) {
  ModuleBuilder m;
  const auto a = m.pou("A", ir::PouKind::kFunctionBlock);
  const auto c = m.pou("C", ir::PouKind::kFunctionBlock);
  const auto inner = m.variable(a, "c", m.module.types.array(m.module.pous[c].instance_type, 0, 1));
  m.variable(c, "a", m.module.pous[a].instance_type);
  auto b = m.body(a);
  b.run(b.element(b.variable(inner), 0));
  EXPECT_FALSE(ir::check(m.module, m.diagnostics));
  EXPECT_TRUE(has(m, Code::P4202, "A -> C -> A"));
  EXPECT_EQ(m.diagnostics.error_count(), 1u);
}

TEST(Check, CallsOfOneFunctionFromManyPlacesAreFine) {
  ModuleBuilder m;
  const auto f = m.pou("F", ir::PouKind::kFunction);
  const auto g = m.pou("G", ir::PouKind::kFunction);
  const auto main = m.pou("Main");
  m.body(g).call_pou(f, {});
  m.body(main).call_pou(f, {});
  m.body(main).call_pou(g, {});
  EXPECT_TRUE(ir::check(m.module, m.diagnostics));
}

TEST(Check, UnboundLabelIsReported) {
  ModuleBuilder m;
  auto b = m.body(m.pou("Main"));
  b.jump(b.new_label());
  EXPECT_FALSE(ir::check(m.module, m.diagnostics));
  EXPECT_TRUE(has(m, Code::P9001, "label"));
}

TEST(Check, WritingTasksAreNamedInAWarningWithThePlaces) {
  ModuleBuilder m;
  m.diagnostics.add_file("plant.st");
  const auto x = m.global("X", ir::kBoolType);
  core::SourceRef at;
  at.line = 10;
  for (const char* name : {"Fast", "Slow", "Lazy"}) {
    const auto p = m.pou(std::string("P") + name);
    auto b = m.body(p);
    for (int store = 0; store < 2; ++store) {
      b.set_source(at);
      b.store(b.global(x), b.constant_bool(true));
      ++at.line;
    }
    m.task(name, p, name);
  }
  EXPECT_TRUE(ir::check(m.module, m.diagnostics));
  EXPECT_TRUE(has(m, Code::P4204,
                  "variable X is written by tasks Fast (plant.st:10), Slow (plant.st:12) and Lazy (plant.st:14)"));
}

TEST(Check, APlaceWithoutALineIsLeftOut) {
  ModuleBuilder m;
  const auto x = m.global("X", ir::kBoolType);
  for (const char* name : {"Fast", "Slow"}) {
    const auto p = m.pou(std::string("P") + name);
    auto b = m.body(p);
    b.store(b.global(x), b.constant_bool(true));
    m.task(name, p, name);
  }
  EXPECT_TRUE(ir::check(m.module, m.diagnostics));
  EXPECT_TRUE(has(m, Code::P4204, "variable X is written by tasks Fast and Slow"));
}

TEST(Print, ShowsDeclarationsAndInstructionsWithTheirElements) {
  ModuleBuilder m;
  const auto main = m.pou("Main");
  const auto x = m.variable(main, "x", ir::kBoolType, ir::Role::kInput);
  const auto q = m.variable(main, "q", ir::kBoolType, ir::Role::kOutput);
  auto b = m.body(main);
  core::SourceRef contact;
  contact.kind = core::ElementKind::kContact;
  contact.local_id = 3;
  b.set_source(contact);
  const auto v = b.not_(b.load(b.variable(x)));
  contact.kind = core::ElementKind::kCoil;
  contact.local_id = 4;
  b.set_source(contact);
  b.store(b.variable(q), v);
  m.task("T", main, "Main");
  EXPECT_EQ(ir::print(m.module),
            "TASK T interval 20000000 ns priority 0\n"
            "  PROGRAM Main : Main\n"
            "PROGRAM Main\n"
            "  VAR_INPUT x : BOOL\n"
            "  VAR_OUTPUT q : BOOL\n"
            "  %0 := load x                                       ; contact 3\n"
            "  %1 := not %0                                       ; contact 3\n"
            "  store q := %1                                      ; coil 4\n");
}

}  // namespace
}  // namespace plc
