// GlobalTable: the global variable table (GVT) of a resource: who owns which variable, and how the others see it (paper,
// 3.2.2; docs/adr/0012).
//
// Every global has one way to change:
//   owned by a task       it alone exports the variable. It publishes all it owns as one snapshot at the end of a cycle.
//                         Writes from outside wait in its journal and are applied at its next start.
//   owned by a driver     an input the driver claimed. It publishes all its inputs as one snapshot.
//   owned by the outside  nobody else writes it. A batch of outside writes is published at once, as one snapshot.
//   shared                several tasks export it. Each publishes the values it changed, stamped; the newest stamp counts.
//   overlapping           its address shares bits with another one under --profile=overlay: single values of at most
//                         8 bytes, each read and written whole; ProcessImage brings them into agreement.
// Readers take the newest complete snapshot of each owner; nobody waits for anybody and nothing tears.
// Threads: set-up (constructor, GlobalReader, GlobalInputs) before tasks run, on one thread. read(), write(), copy():
// any thread that is not a task's; they exclude each other by a mutex no task takes. Tasks come through Exchange.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/journal.h"
#include "runtime/memory/snapshot.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class Exchange;

/// One value that somebody outside the tasks wants written: a scalar or a whole string.
struct GlobalWrite {
  std::uint32_t offset = 0;           ///< of a leaf in the global table
  std::uint32_t type = 0;             ///< of that leaf, index into Image::types
  const std::byte* value = nullptr;   ///< as many bytes as the type has
  const std::byte* mask = nullptr;    ///< bits to take from value, same size; null = all (scalars only)
};

enum class WriteResult : std::uint8_t {
  kDone,     ///< published, or in the journal of the task that exports it
  kBusy,     ///< a journal is full: the task has not started for long; nothing was written
  kRefused,  ///< a constant, or an input of a driver; nothing was written
};

/// Brings a value into the form every reader may rely on: BOOL 0 or 1, the one NaN, string length within its capacity.
/// False, and unchanged, when it is outside the limits of a subrange or enumeration. RT.
bool normalise(const bytecode::ImageType& type, std::byte* value) noexcept;

class GlobalTable {
 public:
  explicit GlobalTable(const bytecode::Image& image);
  GlobalTable(const GlobalTable&) = delete;
  GlobalTable& operator=(const GlobalTable&) = delete;

  /// Bytes of the table; offsets are below it.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const bytecode::Image& image() const { return image_; }

  /// The newest published value of one leaf (or a whole field, whose leaves may then be of different owners only when it
  /// is shared). Not for tasks.
  void read(std::uint32_t offset, std::uint32_t bytes, std::byte* to) const;
  /// The whole table as published now: of each owner one snapshot. `to` has size() bytes. Not for tasks.
  void copy(std::byte* to) const;
  /// Writes all or nothing. Values are normalised; one that cannot be is left out (the caller checks limits first when it
  /// wants to say so). Not for tasks.
  WriteResult write(std::span<const GlobalWrite> batch);
  /// Whether write() would ever accept `field` (of Image::global_type).
  [[nodiscard]] bool writable(std::uint32_t field) const;
  /// Whether a driver may claim `field` as its input: no task exports it, no other driver has it.
  [[nodiscard]] bool claimable(std::uint32_t field) const;
  /// Tasks that export `field`, ascending.
  [[nodiscard]] std::vector<std::uint32_t> exporters(std::uint32_t field) const;

  /// Cold start: initial values, empty journals. Not while tasks run.
  void reset();

 private:
  friend class Exchange;
  friend class GlobalReader;
  friend class GlobalInputs;
  friend class ProcessImage;
};
}  // namespace plc::runtime
