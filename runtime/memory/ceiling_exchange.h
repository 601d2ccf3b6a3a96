// CeilingExchange: the protocol of the paper (docs/references.md, 3.2.3) for tasks of one processor. A task copies at
// the priority ceiling of what it copies: that of the most urgent task that uses it. No task that uses it can run
// meanwhile, and a more urgent task that uses none of it is not held up at all.
//
// The code raises the priority group by group, less urgent ceilings first, and gives it back at the end
// (RAISE_PRIORITY, RESCHEDULE). Between the two it only rises, so that all that a reader takes from one writer is of
// one cycle. Without set_priority_change() (simulation: one thread) no priority changes. RT: a system call for each
// group.
#pragma once

#include "runtime/memory/common_table_exchange.h"

namespace plc::runtime {

class CeilingExchange final : public CommonTableExchange {
 public:
  using CommonTableExchange::CommonTableExchange;
  void prepare() override;
  void set_priority_change(SetPriority set) override { set_ = set; }
  void import(std::uint32_t range) noexcept override;
  void export_range(std::uint32_t range) noexcept override;
  bool end() noexcept override;
  void raise(std::uint32_t range) noexcept override;
  void reschedule() noexcept override;
  /// Begins at the task's own priority, as its own export would: a copy that another task has begun is completed first.
  /// Leaves the thread at that priority. On the tasks' processor only.
  void publish_safe(std::span<const GlobalWrite> values) noexcept override;

 private:
  template <class Copy>
  void in_turn(Copy copy) noexcept;
  void rise_to(std::int32_t priority) noexcept;

  SetPriority set_ = nullptr;
  std::int32_t own_ = 0;                ///< priority of the task, 0 the most urgent
  std::int32_t level_ = 0;              ///< priority that its thread has now
  std::vector<std::int32_t> ceilings_;  ///< by range
};

}  // namespace plc::runtime
