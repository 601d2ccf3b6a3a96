// LockExchange: one lock around every copy between a task and the common table, as Chimera has it (Stewart, Volpe,
// Khosla 1997, which the paper cites as [8]): the simplest protocol, and the one in which every task waits for every
// other.
//
// The lock is a mutex with priority inheritance, so that a task that holds it cannot be held up by tasks in between.
// RT but for the wait: bounded by the longest copy of every other task.
#pragma once

#include "runtime/memory/common_table_exchange.h"

namespace plc::runtime {

class LockExchange final : public CommonTableExchange {
 public:
  using CommonTableExchange::CommonTableExchange;
  void import(std::uint32_t range) noexcept override;
  void export_range(std::uint32_t range) noexcept override;
  bool end() noexcept override;
  void lock() noexcept override;
  void unlock() noexcept override;
  void publish_safe(std::span<const GlobalWrite> values) noexcept override;

 private:
  bool locked_ = false;
};

}  // namespace plc::runtime
