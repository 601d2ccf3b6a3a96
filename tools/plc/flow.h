// The data flow between the tasks of a project: who owns each global variable, who writes and who reads it.
//
// In: a verified image, so an image file will do. Out: DataFlow, as tables or as a drawing (SVG). What devices and HMIs
// do is known from addresses alone. Does not belong here: files, command lines, execution times.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"

namespace plc::tools {

enum class FlowOwner : std::uint8_t {
  kTask,     ///< one task exports it
  kShared,   ///< several tasks do: the last change wins
  kDevices,  ///< an input (%I) that no task writes
  kOutside,  ///< no task writes it: HMIs, stimuli, or nobody
  kConstant,
  kQueue,  ///< of all who put elements in; each has a ring of its own
};

/// A global variable or queue and the tasks that exchange it; tasks by their index in the image, ascending.
struct FlowGlobal {
  std::string name;  ///< "GVL.Level"
  std::string type;
  std::string address;      ///< "%QX0.0", or empty
  std::uint32_t bytes = 0;  ///< of a queue: an element
  FlowOwner owner = FlowOwner::kOutside;
  std::vector<std::uint32_t> writers;
  std::vector<std::uint32_t> readers;  ///< tasks that use values of others; not the only writer
  /// Of a variable that one task writes: priority of the most urgent task that exchanges it (paper, 3.2.3).
  std::optional<std::int32_t> ceiling;
};

/// Where values come from or go to.
struct FlowEnd {
  enum class Kind : std::uint8_t { kDevices, kTask, kOutside } kind = Kind::kTask;
  std::uint32_t task = 0;  ///< kTask
  friend auto operator<=>(const FlowEnd&, const FlowEnd&) = default;
};

/// All that goes from one end to another.
struct Flow {
  FlowEnd from, to;
  std::vector<std::uint32_t> globals;  ///< into DataFlow::globals
  std::uint64_t bytes = 0;
  /// At most from the release of the scan that computes a value to the release of the first scan that uses it, when
  /// both tasks meet their deadlines: the sum of their intervals; devices count nothing. Nothing for tasks without
  /// interval.
  std::optional<core::TimeNs> age_ns;
};

struct DataFlow {
  std::vector<FlowGlobal>
      globals;              ///< owners in the order of the tasks, then shared ones, devices, outside, constants, queues
  std::vector<Flow> flows;  ///< by their ends
};

DataFlow data_flow(const bytecode::Image& image);

/// "every 20ms", "on Start", "freewheeling"
std::string release_text(const bytecode::ImageTask& task);
/// "Fast", "devices", "outside"
std::string end_text(const bytecode::Image& image, const FlowEnd& end);

/// Three tables: tasks, globals, flows.
std::string flow_tables(const bytecode::Image& image, const DataFlow& flow);
/// A drawing of tasks and flows, for browsers and print: no scripts, light and dark.
std::string flow_svg(const bytecode::Image& image, const DataFlow& flow);

}  // namespace plc::tools
