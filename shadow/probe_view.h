// ProbeView: what somebody sees who looks at one POU on one instance in a replica: values and power flow by the keys of
// its drawing or text.
//
// In: a replica that looks at it (Replica::look_at()), keys (bytecode/drawings.h). Out: at each of them what happened
// since the last frame, and the last value. Threads: that of the replica, between scans. Does not belong here:
// drawings, pages.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "runtime/probes.h"
#include "runtime/program.h"
#include "runtime/value_text.h"

namespace plc::shadow {

/// An instance of a POU in the table of a task.
struct PouInstance {
  std::string path;  ///< "Main", "Main.Valves[2]", "GVL.Pump"; of a function its name
  runtime::ProbedPou view;
};
/// POUs that the task reaches, for instances_of() of many POUs.
std::vector<std::uint32_t> reached_by(const runtime::Program& program);
/// All instances of `pou` that the task has, at most `most`; nothing when it does not reach the POU. `reached`: what
/// reached_by() gave, or null.
std::vector<PouInstance> instances_of(const runtime::Program& program, std::uint32_t pou, std::size_t most = 10'000,
                                      const std::vector<std::uint32_t>* reached = nullptr);

/// What is to be seen at one place.
struct Shown {
  bool ran = false;      ///< control came here since the last frame; what follows is as it was before, else
  bool is_bool = false;  ///< power, a BOOL
  bool known = false;    ///< there is a value: not where nothing but the place itself is to be seen, or where the
                         ///< compiled code does not compute it
  bool on = false;       ///< BOOL: the last value
  bool was_on = false, was_off = false;  ///< BOOL: since the last frame
  bool was_unknown = false;              ///< ..: it also was what the code does not compute
};

class ProbeView {
 public:
  /// `program` looks at `view`, and outlives this as long as it does.
  ProbeView(runtime::Program& program, const runtime::ProbedPou& view)
      : map_(&program.image().probes[view.pou]),
        image_(&program.image()),
        values_(program.probes() == nullptr ? nullptr : program.probes()->find(view)) {}

  /// False: nothing is to be seen, since the image has no map of the POU or the task does not reach it.
  [[nodiscard]] bool any() const { return values_ != nullptr; }
  /// All places that have something, ascending.
  [[nodiscard]] std::span<const bytecode::ProbePoint> points() const { return map_->points; }
  /// Nothing when no probe is there. `key.pou` is not looked at.
  [[nodiscard]] std::optional<Shown> at(bytecode::DrawnKey key) const;
  [[nodiscard]] Shown at(const bytecode::ProbePoint& point) const;
  /// The last value as text, BOOL as TRUE and FALSE or 1 and 0; empty where none is known.
  [[nodiscard]] std::string text(const bytecode::ProbePoint& point,
                                 runtime::ValueStyle style = runtime::ValueStyle::kNames) const;
  [[nodiscard]] std::string text(bytecode::DrawnKey key, runtime::ValueStyle style = runtime::ValueStyle::kNames) const;
  /// The next frame begins.
  void clear() {
    if (values_ != nullptr) values_->clear();
  }

 private:
  [[nodiscard]] const bytecode::ProbePoint* find(bytecode::DrawnKey key) const;

  const bytecode::PouProbes* map_;
  const bytecode::Image* image_;
  runtime::ProbeValues* values_;
};

}  // namespace plc::shadow
