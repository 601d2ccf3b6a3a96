// CommonTableExchange: tasks pass on what they export through one table that all of them copy from and to.
//
// What keeps those copies apart is the derived class's business (lock_exchange.h, ceiling_exchange.h). It covers what
// one task alone exports, which is all the paper has (3.2.2). Inputs, outside writes and variables of several writers
// go as they go wait-free, and so do snapshots for devices, servers and tools, which are made after the critical
// section.
#pragma once

#include "runtime/memory/wait_free_exchange.h"

namespace plc::runtime {

class CommonTableExchange : public WaitFreeExchange {
 public:
  using WaitFreeExchange::WaitFreeExchange;
  void prepare() override;
  /// The common table is not looked at outside of critical sections: snapshots only.
  void expect(std::size_t bytes) noexcept override;
  bool end() noexcept override;

 protected:
  /// Local copy := common table and snapshots. Inside the critical section. RT.
  void copy_in(std::uint32_t range) noexcept;
  /// Common table := local copy. Inside the critical section. RT.
  void copy_out(std::uint32_t range) noexcept;
  /// Puts values of fields that this task alone exports into the common table. Inside the critical section. RT.
  void put_safe(std::span<const GlobalWrite> values) noexcept;

 private:
  std::vector<std::uint8_t> exported_;  ///< by range: in this cycle
};

}  // namespace plc::runtime
