// LiveView: values of chosen variables in the terminal while the plant runs.
//
// In: patterns, the running resource. Out: a block of lines that is redrawn on a terminal, below what others print
// there, or one line per change elsewhere. Globals are read from the table at any time; variables of tasks by the task
// itself after a scan, when the view has asked for them: a cycle formats at most what is watched, into memory it has
// already.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "runtime/access.h"
#include "runtime/sched/cycle_listener.h"
#include "tools/plc-run/output.h"

namespace plc::tools {

class LiveView final : public runtime::CycleListener {
 public:
  LiveView(const std::vector<std::string>& patterns, runtime::Resource& resource, Output& output);

  [[nodiscard]] bool empty() const { return items_.empty(); }
  /// Asks the tasks for values, waits for them (not longer than `patience_ns`) and prints. Not on a task's thread.
  void show(core::TimeNs since_start_ns, core::TimeNs patience_ns);

  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  /// RT: nothing unless asked; no allocation, the texts have their room.
  void after_scan(const runtime::ReleaseContext& context) noexcept override;
  void safe_state() noexcept override {}

 private:
  struct Item {
    std::string path;
    runtime::Place place;
    std::string text;  ///< written by the item's task while its request is kAsked, else by the view
    std::string shown;
  };
  enum class Request : std::uint8_t { kIdle, kAsked, kReady };

  void print_terminal(core::TimeNs since_start_ns);
  void print_lines(core::TimeNs since_start_ns);

  runtime::Access access_;
  std::vector<Item> items_;
  std::vector<std::unique_ptr<std::atomic<Request>>> requests_;  ///< per task
  Output& output_;
  std::size_t drawn_lines_ = 0;  ///< that are last on the terminal
  std::uint64_t texts_ = 0;      ///< of others, before these were drawn
  std::size_t path_width_ = 0;
};

}  // namespace plc::tools
