// ValueSource: where the values come from that clients see. Never a table that a task works on.
//
// Threads: one at a time. Does not belong here: names, JSON.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/access.h"
#include "runtime/memory/global_ports.h"

namespace plc::engineering {

class ValueSource {
 public:
  virtual ~ValueSource() = default;
  /// Takes the newest values; read() gives those until the next call.
  virtual void take() = 0;
  /// Whether values of this table are known: that of a task, or the global one (Place::kGlobal).
  [[nodiscard]] virtual bool knows(std::uint32_t task) const = 0;
  /// Copies so many bytes of a table that is known.
  virtual void read(std::uint32_t task, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const = 0;
};

/// Globals, as their owners have published them.
class GlobalValues final : public ValueSource {
 public:
  /// Before tasks run.
  explicit GlobalValues(runtime::GlobalTable& globals) : reader_(globals) { reader_.take(); }
  void take() override { reader_.take(); }
  [[nodiscard]] bool knows(std::uint32_t task) const override { return task == runtime::Place::kGlobal; }
  void read(std::uint32_t /*task*/, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const override {
    reader_.read(offset, bytes, to);
  }

 private:
  runtime::GlobalReader reader_;
};

}  // namespace plc::engineering
