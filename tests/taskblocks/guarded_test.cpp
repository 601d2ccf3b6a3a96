// Components in a runtime with a guardian: what kills the process ends in safe values, and what starts threads does
// that in the process that runs it.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "runtime/sched/realtime.h"
#include "taskblocks/shared_library.h"
#include "tests/support/guardian_fixture.h"
#include "tests/taskblocks/libraries.h"
#include "tools/plc-run/component_faults.h"

namespace plc::io {
namespace {

class Guarded : public GuardianTest {
 protected:
  Guarded() { options.hang_timeout_ns = 0; }

  /// As plc-run does it: load, split, make ready, run. `end` is asked every 10 ms, and says when it is enough.
  void start_with(const std::string& library, std::function<bool(runtime::Resource&)> end) {
    test::installed(scratch, library);
    test::write_text(scratch.file("plant.st"), test::faulty_project());
    // Before the split: nothing of a component may run there but its static objects.
    ASSERT_FALSE(taskblocks::load_shared_library(scratch.file(library + ".so"), registry));
    compiler::compile({scratch.file("plant.st"), {}, compiler::Goal::kRun, {}, {}, &registry}, compilation);
    ASSERT_TRUE(compilation.image);
    runtime::ProgramOptions program;
    program.taskblocks = &registry;
    program.start_taskblocks = false;
    auto loaded = runtime::Resource::load(std::move(*compilation.image), program);
    ASSERT_TRUE(loaded);
    resource = std::move(*loaded);
    start([this, end](Pulse& pulse) {
      tools::name_crashes(*resource);
      if (resource->start_taskblocks()) return 98;
      runtime::RealtimeOptions realtime;
      realtime.on_thread_start = tools::watch_task_thread;
      runtime::RealtimeScheduler scheduler(*resource, realtime);
      scheduler.add_listener(pulse);
      scheduler.start();
      for (int i = 0; i < 1000 && !end(*resource); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const bool enough = end(*resource);
      pulse.stopping();
      scheduler.request_stop();
      scheduler.join();
      pulse.finished();
      return enough ? 0 : 97;
    });
  }

  test::ScratchFolder scratch;
  taskblocks::Registry registry;
  compiler::Compilation compilation;
  std::unique_ptr<runtime::Resource> resource;
};

TEST_F(Guarded, AWildPointerEndsInSafeValues) {
  start_with("crashes", [](runtime::Resource&) { return false; });
  expect_guardian_acted("was killed by signal 11");
  EXPECT_NE(said.find("plc-run: crashed in taskblock FAULTY faulty.component (task Bad)\n"), std::string::npos) << said;
}

TEST_F(Guarded, ThreadsOfComponentsAreThere) {
  start_with("starts_a_thread", [](runtime::Resource& running) {
    const auto place = runtime::Access(running).find_leaf("faulty.component.OUT");
    double rounds = 0;
    std::memcpy(&rounds, running.program(place->task).table().data() + place->offset, sizeof rounds);
    return rounds > 20;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

}  // namespace
}  // namespace plc::io
