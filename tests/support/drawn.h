// Drawn: a project from ST whose bodies are drawings or instruction lists, from declarations to values that a scan
// leaves.
//
// In: declarations, a Sketch or a text per body, what lowers them. Out: codes of what is reported, the IR, and after
// each scan the values of variables of the instance Main. Does not belong here: any engine but the interpreter.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytecode/codegen/generate.h"
#include "bytecode/image.h"
#include "core/text.h"
#include "declare/declare.h"
#include "frontend-st/read.h"
#include "frontend-st/text.h"
#include "ir/check.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/sketch.h"

namespace plc::test {

class Drawn {
 public:
  using Lower = bool (*)(const plcopen::Pou&, ir::Module&, std::uint32_t, core::Diagnostics&);

  core::CompileOptions options;
  core::Diagnostics diagnostics;
  std::unique_ptr<ir::Module> module;

  /// A program Main with these variables and this body; `others` are declarations beside it.
  Drawn(Lower lowering, const std::string& variables, const Sketch& body, const std::string& others = "")
      : lower_(lowering),
        project_(st::read_memory("PROGRAM Main VAR\n" + variables + "\nEND_VAR END_PROGRAM\n" + others, "test.st",
                                 diagnostics)) {
    EXPECT_EQ(diagnostics.error_count(), 0u) << rendered();
    options.pou = "Main";
    draw("Main", body);
  }

  /// A program Main whose body is a text, in IL perhaps.
  Drawn(Lower lowering, const std::string& variables, const std::string& body, const std::string& others = "")
      : lower_(lowering),
        project_(st::read_memory("PROGRAM Main VAR\n" + variables + "\nEND_VAR\n" + body + "\nEND_PROGRAM\n" + others,
                                 "test.st", diagnostics)) {
    options.pou = "Main";
  }

  /// Draws the body of another POU.
  Drawn& draw(std::string_view pou, const Sketch& body) {
    const auto it = std::find_if(project_->pous.begin(), project_->pous.end(),
                                 [&](const plcopen::Pou& p) { return core::iequals(p.name, pou); });
    if (it == project_->pous.end()) {
      ADD_FAILURE() << "no POU " << pou;
    } else {
      it->bodies = {body.body()};
    }
    return *this;
  }

  /// Everything that is reported, "P2001 P3014".
  std::string codes() {
    lower();
    std::string codes;
    for (const core::Diagnostic& d : diagnostics.all()) {
      codes += (codes.empty() ? "" : " ") + std::string(core::info(d.code).name);
    }
    return codes;
  }
  /// The first message, with its help after " | "; or nothing.
  std::string message() {
    lower();
    if (diagnostics.all().empty()) return {};
    const core::Diagnostic& first = diagnostics.all().front();
    return first.message + (first.help.empty() ? "" : " | " + first.help);
  }

  const ir::Pou& pou(std::string_view name = "Main") {
    lower();
    return module->pous[module->pou_by_name.find(name)->second];
  }
  std::size_t count(ir::Op op) {
    const auto& insts = pou().body.insts;
    return static_cast<std::size_t>(
        std::count_if(insts.begin(), insts.end(), [&](const ir::Inst& inst) { return inst.op == op; }));
  }
  /// Names of the hidden variables of Main, between blanks.
  std::string hidden() {
    std::string names;
    for (const ir::Variable& v : pou().variables) {
      if (v.role == ir::Role::kHidden) names += (names.empty() ? "" : " ") + v.name;
    }
    return names;
  }
  /// The instructions of Main as a listing has them, a line each.
  std::string listing() {
    lower();
    std::istringstream lines(ir::print(*module));
    std::string text;
    bool inside = false;
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("  ", 0) != 0) {
        inside = line == "PROGRAM Main";
        continue;
      }
      const bool declares = line.rfind("  VAR", 0) == 0 || line.rfind("  HIDDEN", 0) == 0;
      if (!inside || declares) continue;
      line = line.substr(2, line.find(" ; ") - 2);
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
  }

  /// One scan, 10 ms after the last one: first writes "A=1 B=0", then reads "Y Z" as "1 0".
  std::string scan(const std::string& inputs, const std::string& outputs) {
    if (resource() == nullptr) return "does not run";
    std::istringstream writes(inputs);
    for (std::string one; writes >> one;) {
      const std::size_t equals = one.find('=');
      const auto place = access_->find("Main." + one.substr(0, equals));
      if (!place || access_->write(*place, one.substr(equals + 1))) ADD_FAILURE() << "cannot write " << one;
    }
    EXPECT_FALSE(resource_->program(0).execute({now_}));
    now_ += 10'000'000;
    return read(outputs);
  }
  std::string read(const std::string& outputs) {
    if (resource() == nullptr) return "does not run";
    std::istringstream names(outputs);
    std::string values;
    for (std::string name; names >> name;) {
      const auto place = access_->find("Main." + name);
      values += (values.empty() ? "" : " ") + (place ? access_->read(*place) : "no " + name);
    }
    return values;
  }
  /// Scans with one input after the other, "0 1 1": what `output` was after each of them.
  std::string over(const std::string& input, const std::string& values, const std::string& output) {
    std::istringstream in(values);
    std::string seen;
    for (std::string value; in >> value;) {
      seen += (seen.empty() ? "" : " ") + scan(input + "=" + value, output);
    }
    return seen;
  }

 private:
  [[nodiscard]] std::string rendered() const {
    std::ostringstream out;
    diagnostics.render(out);
    return out.str();
  }

  void lower() {
    if (module != nullptr) return;
    module = st::declare(*project_, options, diagnostics);
    for (std::uint32_t i = 0; i < project_->pous.size(); ++i) {
      const plcopen::Pou& p = project_->pous[i];
      const bool drawn = !p.bodies.empty() && p.bodies.front().language != plcopen::Language::kSt;
      drawn ? lower_(p, *module, i, diagnostics) : st::lower_body(p, *module, i, diagnostics);
      for (const plcopen::Pou& action : p.actions) {
        const bool list = action.bodies.front().language == plcopen::Language::kIl;
        const Lower one = list ? lower_ : st::lower_body;
        one(action, *module, module->pous[i].actions.find(action.name)->second, diagnostics);
      }
    }
  }

  runtime::Resource* resource() {
    lower();
    if (resource_ != nullptr || tried_) return resource_.get();
    tried_ = true;
    const bool good = diagnostics.error_count() == 0 && ir::check(*module, diagnostics);
    auto image = good ? bytecode::generate(*module, diagnostics) : std::nullopt;
    auto verified = image ? bytecode::verify(std::move(*image), diagnostics) : std::nullopt;
    if (!verified) {
      ADD_FAILURE() << rendered();
      return nullptr;
    }
    auto loaded = runtime::Resource::load(std::move(*verified));
    if (!loaded) {
      ADD_FAILURE() << loaded.error().message;
      return nullptr;
    }
    resource_ = std::move(*loaded);
    access_ = std::make_unique<runtime::Access>(*resource_);
    return resource_.get();
  }

  Lower lower_;
  std::unique_ptr<plcopen::Project> project_;
  std::unique_ptr<runtime::Resource> resource_;
  std::unique_ptr<runtime::Access> access_;
  bool tried_ = false;
  core::TimeNs now_ = 0;
};

}  // namespace plc::test
