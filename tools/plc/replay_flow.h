// The power flow of one scan, as text or as a picture: what a POU had at its pins, contacts, coils and statements, for
// plc replay
// --flow.
//
// In: a player, "POU" or "POU:INSTANCE". Out: one line for each place that has something to see. Does not belong here:
// drawings, which scan it is.
#pragma once

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <utility>

#include "runtime/resource.h"
#include "shadow/player.h"
#include "shadow/probe_view.h"

namespace plc::tools {

class ReplayFlow {
 public:
  /// Complains and returns nothing when there is no such POU, it has no map, or several instances and none is said.
  static std::optional<ReplayFlow> find(runtime::Resource& resource, const std::string& wanted);

  [[nodiscard]] std::uint32_t task() const { return task_; }
  /// What the scan of task() had that was executed last: executes it again and looks. False, after a complaint, when
  /// that cannot be.
  bool show(shadow::Player& player, runtime::ValueStyle style, std::ostream& out) const;
  /// The same as a picture of the POU, into a file; "-" is `out`.
  bool draw(shadow::Player& player, runtime::ValueStyle style, const std::string& svg, std::ostream& out) const;

 private:
  ReplayFlow(std::uint32_t task, shadow::PouInstance instance) : task_(task), instance_(std::move(instance)) {}

  /// Executes the scan again that was executed last, and looks. Nothing, after a complaint, when that cannot be.
  std::optional<shadow::ProbeView> look(shadow::Player& player) const;
  /// "Main in scan 7 of task "Fast", 140ms after the first recorded one".
  [[nodiscard]] std::string caption(shadow::Player& player) const;

  std::uint32_t task_;
  shadow::PouInstance instance_;
};

}  // namespace plc::tools
