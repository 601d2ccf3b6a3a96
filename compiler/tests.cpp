#include "compiler/tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bytecode/codegen/generate.h"
#include "compiler/libraries.h"
#include "core/text.h"
#include "frontend-st/lexer.h"
#include "ir/builder.h"

namespace plc::compiler {
namespace {

constexpr std::string_view kBefore = "TEST '";

/// The POU of a test: its name can be spelled nowhere, and it has the component that talks to the runner.
plcopen::Pou as_pou(plcopen::Pou test) {
  test.name = fmt::format("{}{}'", kBefore, test.name);
  plcopen::Variable host;
  host.name = ir::kTestHostName;
  host.section = plcopen::Section::kLocal;
  host.type.kind = plcopen::TypeSpec::Kind::kNamed;
  host.type.name = ir::kTestHostType;
  host.at = test.at;
  test.variables.insert(test.variables.begin(), std::move(host));
  return test;
}

std::string name_of(const ir::Pou& test) {
  return test.name.substr(kBefore.size(), test.name.size() - kBefore.size() - 1);
}

/// Names of a path: "Main", "pump", "Running".
using Path = std::vector<std::string_view>;

/// The paths that the texts of a test mock: MOCK(Main.pump.Running, ..).
std::vector<Path> mocked_paths(const plcopen::Pou& test) {
  std::vector<Path> paths;
  for (const plcopen::Body& body : test.bodies) {
    const std::string_view text = body.text;
    st::Lexer lexer(text);
    const auto text_of = [&](const st::Token& token) { return text.substr(token.begin, token.end - token.begin); };
    st::Token token = lexer.next();
    const auto ended = [&] {
      return token.kind == st::TokenKind::kEnd || token.kind == st::TokenKind::kUnterminatedComment;
    };
    while (!ended()) {
      const bool mock = token.kind == st::TokenKind::kIdentifier && core::iequals(text_of(token), "MOCK");
      token = lexer.next();
      if (!mock || token.kind != st::TokenKind::kLeftParen) continue;
      Path path;
      for (token = lexer.next(); token.kind == st::TokenKind::kIdentifier; token = lexer.next()) {
        path.push_back(text_of(token));
        token = lexer.next();
        if (token.kind != st::TokenKind::kDot) break;
      }
      if (path.size() > 1) paths.push_back(std::move(path));
    }
  }
  return paths;
}

class Preparation {
 public:
  Preparation(const plcopen::Project& project, ir::Module& module, core::Diagnostics& diagnostics)
      : project_(project), module_(module), diagnostics_(diagnostics) {}

  void run() {
    module_.bench.emplace();
    for (ir::Task& task : module_.tasks) {
      for (const ir::ProgramInstance& program : task.programs) add_program(program);
    }
    for (std::uint32_t i = 0; i < project_.pous.size(); ++i) {
      if (!project_.pous[i].test) continue;
      for (const Path& path : mocked_paths(project_.pous[i])) add_mock(i, path);
    }
  }

 private:
  void add_program(const ir::ProgramInstance& program) {
    ir::TestBench& bench = *module_.bench;
    bench.runs_tasks = true;
    std::uint32_t index = program.global;
    if (index == ir::Pou::kDeclared) {
      index = static_cast<std::uint32_t>(module_.globals.size());
      ir::Global mirror;
      mirror.mirror = true;
      mirror.variable.name = program.name;
      mirror.variable.type = module_.pous[program.pou].instance_type;
      mirror.variable.at = program.at;
      mirror.variable.initial = program.initial;
      module_.globals.push_back(std::move(mirror));
    }
    bench.programs.try_emplace(program.name, index);
    std::size_t instances = 0;
    for (const ir::Task& task : module_.tasks) {
      for (const ir::ProgramInstance& other : task.programs) instances += other.pou == program.pou ? 1 : 0;
    }
    if (instances == 1) bench.programs.try_emplace(module_.pous[program.pou].name, index);
  }

  /// Makes the hidden variables of a mocked output. A path that leads to none is reported where MOCK is lowered.
  void add_mock(std::uint32_t test, const Path& path) {
    std::uint32_t owner = test;
    std::size_t next = 0;
    if (module_.pous[test].find(path[0]) == nullptr) {
      const auto type = type_of_root(path[0]);
      if (!type || module_.types[*type].kind != ir::TypeKind::kPou) return;
      owner = module_.types[*type].pou;
      next = 1;
    }
    for (; next < path.size(); ++next) {
      const auto found = module_.pous[owner].by_name.find(path[next]);
      if (found == module_.pous[owner].by_name.end()) return;
      const ir::TypeRef type = module_.pous[owner].variables[found->second].type;
      const ir::Type& block = module_.types[type];
      const bool is_pou = block.kind == ir::TypeKind::kPou;
      if (next + 2 == path.size()) {
        const auto output = output_of(type, path[next + 1]);
        if (output) declare_mock(owner, found->second, *output);
        return;
      }
      if (!is_pou) return;
      owner = block.pou;
    }
  }

  std::optional<ir::TypeRef> type_of_root(std::string_view name) {
    const auto global = module_.global_by_name.find(name);
    if (global != module_.global_by_name.end()) return module_.globals[global->second].variable.type;
    const auto program = module_.bench->programs.find(name);
    if (program == module_.bench->programs.end()) return std::nullopt;
    return module_.globals[program->second].variable.type;
  }

  struct Output {
    std::uint32_t field;
    ir::TypeRef type;
  };
  std::optional<Output> output_of(ir::TypeRef type, std::string_view name) {
    const ir::Type& block = module_.types[type];
    if (block.kind == ir::TypeKind::kBlock) {
      for (std::uint32_t i = 0; i < block.block->fields.size(); ++i) {
        const stdlib::Field& field = block.block->fields[i];
        if (field.direction == stdlib::Direction::kOutput && core::iequals(field.name, name))
          return Output{i, ir::ref_of(field.type)};
      }
    }
    if (block.kind != ir::TypeKind::kPou) return std::nullopt;
    const ir::Pou& pou = module_.pous[block.pou];
    const auto found = pou.by_name.find(name);
    if (found == pou.by_name.end() || pou.variables[found->second].role != ir::Role::kOutput) return std::nullopt;
    return Output{found->second, pou.variables[found->second].type};
  }

  void declare_mock(std::uint32_t owner, std::uint32_t variable, const Output& output) {
    std::vector<ir::Mock>& mocks = module_.pous[owner].mocks;
    const bool known = std::any_of(mocks.begin(), mocks.end(), [&](const ir::Mock& one) {
      return one.variable == variable && one.output == output.field;
    });
    if (known) return;
    ir::Builder builder(module_, owner, diagnostics_);
    const std::uint32_t value = builder.hidden("mock", output.type);
    const std::uint32_t active = builder.hidden("mocked", ir::kBoolType);
    module_.pous[owner].mocks.push_back({variable, output.field, value, active});
  }

  const plcopen::Project& project_;
  ir::Module& module_;
  core::Diagnostics& diagnostics_;
};

/// The program that runs the test with the number in `which`.
std::uint32_t add_program_of_tests(ir::Module& module, const std::vector<TestInfo>& tests,
                                   core::Diagnostics& diagnostics) {
  const auto index = static_cast<std::uint32_t>(module.pous.size());
  ir::Pou program;
  program.name = kTestsName;
  program.kind = ir::PouKind::kProgram;
  program.compiled = true;
  program.test = true;
  program.instance_type = module.types.pou(index, kTestsName);
  const auto add = [&](const std::string& name, ir::TypeRef type) {
    ir::Variable variable;
    variable.name = name;
    variable.type = type;
    program.by_name.emplace(name, static_cast<std::uint32_t>(program.variables.size()));
    program.variables.push_back(std::move(variable));
  };
  const ir::TypeRef number = ir::ref_of(core::TypeId::kUdint);
  add(kWhichTest, number);
  add(ir::kTestHostName, *module.types.find(ir::kTestHostType));
  for (const TestInfo& test : tests) add(test.instance, module.pous[test.pou].instance_type);
  module.pous.push_back(std::move(program));

  ir::Builder builder(module, index, diagnostics);
  const ir::PlaceId host = builder.variable(1);
  const auto begins = static_cast<std::uint64_t>(ir::TestCall::kTestBegins);
  builder.store(*builder.member(host, ir::kTestHostCall), builder.constant({number, begins, {}}));
  builder.run(host);
  for (std::uint32_t i = 0; i < tests.size(); ++i) {
    builder.set_source(tests[i].at);
    const ir::Operand both[] = {ir::Operand::of(builder.load(builder.variable(0))),
                                ir::Operand::of(builder.constant({number, i, {}}))};
    const auto chosen = builder.call("EQ", both, tests[i].at);
    const ir::LabelId next = builder.new_label();
    builder.jump_if_not(*chosen, next);
    builder.run(builder.variable(i + 2));
    builder.ret();
    builder.bind(next);
  }
  return index;
}

/// Tests run the project's tasks and programs: those of a file of tests are passed over.
void warn_of_configurations(const plcopen::Project& file, core::Diagnostics& diagnostics) {
  for (const plcopen::Configuration& configuration : file.configurations) {
    for (const plcopen::Resource& resource : configuration.resources) {
      if (resource.tasks.empty() && resource.instances.empty()) continue;
      diagnostics.report(core::Code::P4030, configuration.at.line != 0 ? configuration.at : resource.at, {},
                         "a configuration in a file of tests does nothing: tests run the tasks of the project",
                         "declare tasks and program instances in the project");
      break;
    }
  }
}

}  // namespace

void add_tests(plcopen::Project& project, std::vector<plcopen::Project> more, core::Diagnostics& diagnostics) {
  std::vector<plcopen::Pou> tests = std::move(project.tests);
  project.tests.clear();
  for (plcopen::Project& file : more) {
    std::move(file.tests.begin(), file.tests.end(), std::back_inserter(tests));
    file.tests.clear();
    warn_of_configurations(file, diagnostics);
    std::move(file.pragmas.begin(), file.pragmas.end(), std::back_inserter(project.pragmas));
    add_library(project, std::move(file), diagnostics);
  }
  for (plcopen::Pou& test : tests) project.pous.push_back(as_pou(std::move(test)));
}

void prepare_tests(const plcopen::Project& project, ir::Module& module, core::Diagnostics& diagnostics) {
  Preparation(project, module, diagnostics).run();
}

std::optional<TestImage> generate_tests(ir::Module& module, core::Diagnostics& diagnostics) {
  std::vector<TestInfo> tests;
  for (std::uint32_t i = 0; i < module.pous.size(); ++i) {
    if (module.pous[i].test)
      tests.push_back({name_of(module.pous[i]), fmt::format("#t{}", tests.size()), i, module.pous[i].at});
  }
  std::vector<std::string> programs;
  for (const ir::Global& global : module.globals) {
    if (global.mirror) programs.push_back(global.variable.name);
  }
  std::vector<ir::Assertion> assertions = std::move(module.bench->assertions);
  ir::Task task;
  task.name = kTestsName;
  task.programs.push_back({kTestsName, add_program_of_tests(module, tests, diagnostics), {}});
  module.tasks.clear();
  module.tasks.push_back(std::move(task));
  module.located.clear();
  module.tests_run = true;
  std::optional<bytecode::Image> image = bytecode::generate(module, diagnostics);
  if (!image) return std::nullopt;
  auto verified = bytecode::verify(std::move(*image), diagnostics);
  if (!verified) return std::nullopt;
  return TestImage{std::move(*verified), std::move(tests), std::move(assertions), std::move(programs), {}};
}

}  // namespace plc::compiler
