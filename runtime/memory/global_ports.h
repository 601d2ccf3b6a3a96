// GlobalReader and GlobalInputs: how one thread beside the tasks takes part in the exchange: a driver, a server.
//
// In: the global table, before tasks run. Out: consistent reads, and inputs published as one snapshot. Both are
// wait-free and belong to one thread at a time, which may be a task's (bounded drivers) or any other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/memory/global_table.h"

namespace plc::runtime {

/// Reads the table. Between two take() every value of one owner is of the same publication.
class GlobalReader {
 public:
  /// Set-up only: not while tasks run.
  explicit GlobalReader(GlobalTable& table);
  ~GlobalReader();
  GlobalReader(const GlobalReader&) = delete;
  GlobalReader& operator=(const GlobalReader&) = delete;

  /// Takes the newest snapshot of every owner, for read(). RT: wait-free, at most some 20 ns an owner.
  void take() noexcept;
  /// Copies the leaf, or the run of leaves, at `offset`. After take(). RT.
  void read(std::uint32_t offset, std::uint32_t bytes, std::byte* to) const noexcept;

 private:
  GlobalTable& table_;
  GlobalTable::View view_;
};

/// Globals that a driver owns: its inputs. Nobody else writes them from then on.
class GlobalInputs {
 public:
  /// Set-up only. Each field (of Image::global_type) must be claimable().
  GlobalInputs(GlobalTable& table, std::span<const std::uint32_t> fields);
  GlobalInputs(const GlobalInputs&) = delete;
  GlobalInputs& operator=(const GlobalInputs&) = delete;

  /// Sets one leaf of a claimed field in the private image; normalised, and the nearest value of a subrange. RT.
  void set(std::uint32_t offset, std::uint32_t type, const std::byte* value) noexcept;
  /// Lets everybody see the private image, as one snapshot. RT: wait-free.
  void publish() noexcept;

 private:
  GlobalTable& table_;
  std::uint32_t owner_;
};

}  // namespace plc::runtime
