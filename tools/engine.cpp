#include "tools/engine.h"

#include <fmt/format.h>
#include <malloc.h>

#include <iostream>
#include <utility>

#include "native/compile.h"
#include "tools/command_line.h"

namespace plc::tools {

void add_engine_option(Command command, Engine& engine) {
  command.choice("--engine=NAME", engine,
                 {{"auto", Engine::kAuto}, {"interp", Engine::kInterpreter}, {"native", Engine::kNative}},
                 "what runs the tasks: native (machine code, made before the first scan), interp (the interpreter) or "
                 "auto (native where this machine allows it, the default)");
}

std::string engine_name(const runtime::Program& program) { return program.is_compiled() ? "native" : "interpreter"; }

std::optional<core::Problem> prepare_engine(runtime::Resource& resource, Engine engine, const char* command) {
  if (engine == Engine::kInterpreter) return std::nullopt;
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    runtime::Program& program = resource.program(task);
    auto compiled = native::compile(program);
    if (compiled) {
      program.install(std::move(*compiled));
    } else if (engine == Engine::kNative) {
      return compiled.error();
    } else {
      std::cerr << fmt::format("{}: task {} stays with the interpreter: {}\n", command, program.task().name,
                               compiled.error().message);
    }
  }
  ::malloc_trim(0);
  return std::nullopt;
}

}  // namespace plc::tools
