// Looked: a project that runs, is recorded and has a replica that somebody looks at.
//
// In: a text in ST, or a project file. Out: live scans, each executed again, and the view of a POU. Does not belong
// here: what is to be seen.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "shadow/probe_view.h"
#include "tests/support/replayed.h"
#include "tests/support/run_tool.h"

namespace plc::test {

struct ProjectFile {
  std::filesystem::path path;
};

struct Looked {
  /// A text in ST.
  explicit Looked(const std::string& text, const Engine& engine = interpreter()) {
    const ScratchFolder scratch;
    const std::string path = scratch.file("program.st");
    std::ofstream(path) << text;
    load(path, engine);
  }
  explicit Looked(const ProjectFile& project, const Engine& engine = interpreter()) { load(project.path, engine); }

  void load(const std::filesystem::path& project, const Engine& engine) {
    compiler::Compilation compilation;
    compiler::Request request{project.string(), {}, compiler::Goal::kRun};
    request.drawings = true;
    compiler::compile(request, compilation);
    std::ostringstream problems;
    compilation.diagnostics.render(problems);
    EXPECT_TRUE(compilation.image) << problems.str();
    image = std::move(compilation.image);
    live = std::move(*runtime::Resource::load(bytecode::VerifiedImage(*image)));
    std::string problem;
    replayed = Replayed::make(*image, *live, {}, engine, problem);
    EXPECT_NE(replayed, nullptr) << problem;
  }
  std::uint32_t pou(const std::string& name) const {
    std::uint32_t p = 0;
    while (image->image().pous[p].name != name) ++p;
    return p;
  }
  runtime::Program& replica() { return replayed->replica(0); }
  /// Looks at a POU on its instance `path`, or its first.
  shadow::ProbeView look_at(const std::string& name, const std::string& path = "") {
    for (const shadow::PouInstance& one : shadow::instances_of(replica(), pou(name))) {
      if (!path.empty() && one.path != path) continue;
      views.push_back(one.view);
      EXPECT_FALSE(replica().look_at(views));
      return {replica(), one.view};
    }
    ADD_FAILURE() << "no instance " << path << " of " << name;
    return {replica(), {}};
  }
  void set(const std::string& path, const std::string& value) {
    runtime::Access access(*live);
    const auto place = access.find(path);
    ASSERT_TRUE(place) << path;
    ASSERT_FALSE(access.write(*place, value));
    // As a stimulus does it: what is written to a task's variable is recorded.
    if (place->task == runtime::Place::kGlobal) return;
    const std::byte* const at = live->program(0).table().data() + place->offset;
    live->program(0).write_local(place->offset, {at, image->image().types[place->type].size});
  }
  void scan() {
    live->program(0).execute({now_ns, 0, now_ns});
    now_ns += 10'000'000;
    EXPECT_EQ(replayed->check(0), "");
  }

  std::optional<bytecode::VerifiedImage> image;
  std::unique_ptr<runtime::Resource> live;
  std::unique_ptr<Replayed> replayed;
  std::vector<runtime::ProbedPou> views;
  core::TimeNs now_ns = 0;
};

}  // namespace plc::test
