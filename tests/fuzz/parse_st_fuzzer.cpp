// Any text is lowered or refused, as statements, expression and place: no crash, no hang, and a refusal is reported.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string_view>

#include "declare/declare.h"
#include "frontend-st/text.h"

namespace {

using plc::plcopen::Section;
using plc::plcopen::TypeSpec;

TypeSpec named(const char* name) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kNamed;
  spec.name = name;
  return spec;
}

TypeSpec array_of(const char* name) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kArray;
  spec.base = std::make_shared<TypeSpec>(named(name));
  spec.dimensions = {{"0", "3"}, {"1", "2"}};
  return spec;
}

plc::plcopen::Variable variable(const char* name, TypeSpec type, Section section = Section::kLocal) {
  plc::plcopen::Variable v;
  v.name = name;
  v.type = std::move(type);
  v.section = section;
  return v;
}

plc::plcopen::Project small_project() {
  plc::plcopen::Project project;
  plc::plcopen::Pou function;
  function.name = "f";
  function.kind = plc::plcopen::PouKind::kFunction;
  function.return_type = named("INT");
  function.variables = {variable("in", named("INT"), Section::kInput), variable("io", named("INT"), Section::kInOut),
                        variable("out", named("INT"), Section::kOutput)};
  plc::plcopen::Pou program;
  program.name = "p";
  program.variables = {variable("a", named("BOOL")), variable("b", named("BOOL")),
                       variable("i", named("INT")),  variable("r", named("REAL")),
                       variable("t", named("TIME")), variable("m", array_of("INT")),
                       variable("k", named("TON")),  variable("c", named("INT"), Section::kInput)};
  project.pous = {function, program};
  return project;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const plc::plcopen::Project project = small_project();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  plc::core::SourceRef at;
  at.line = 1;
  at.column = 1;
  plc::core::Diagnostics declared;
  const auto module = plc::st::declare(project, {}, declared);
  plc::core::Diagnostics diagnostics;
  plc::ir::Builder builder(*module, 1, diagnostics);
  if (!plc::st::lower_statements(text, at, builder) && !diagnostics.has_errors()) std::abort();
  const std::size_t before = diagnostics.error_count();
  if (!plc::st::lower_expression(text, at, builder) && diagnostics.error_count() == before) std::abort();
  const std::size_t after = diagnostics.error_count();
  if (!plc::st::lower_place(text, at, builder, true) && diagnostics.error_count() == after) std::abort();
  (void)plc::st::is_variable_text(text);
  return 0;
}
