// Replica: a task that executes scans that were recorded, from a checkpoint on.
//
// In: a program that was linked as a replica, the table before a scan, records. Out: the table after each of them, and
// whether the record agrees. Threads: one. Does not belong here: where records come from.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "runtime/program.h"
#include "runtime/record/replay.h"

namespace plc::shadow {

class Replica {
 public:
  /// `program` was linked by Program::link_replica() with `replay`. Both outlive it.
  Replica(runtime::Program& program, runtime::Replay& replay) : program_(&program), replay_(&replay) {}

  /// The table before the scan that comes next. False when it is of another size, and nothing happened, or has what no
  /// table of this program has.
  bool load(std::span<const std::byte> table);
  [[nodiscard]] std::size_t table_bytes() const;

  struct Outcome {
    bool ran = false;     ///< false: its loops were cut from outside, the table is not known any more
    bool equal = true;    ///< table (as far as the record has a check), events and fault are those of the record
    std::string differs;  ///< what does not, in words
    std::optional<std::uint32_t> slice;  ///< which part of the table does not: kSliceBytes from slice * kSliceBytes on
    std::uint32_t events = 0;            ///< raised
    runtime::Fault fault;
  };
  /// One scan.
  Outcome run(std::span<const std::byte> record);

  /// From the next scan on what these POUs have at their probes is taken; nothing: the replica runs as it was made. The
  /// table stays. P9001 when that cannot be.
  std::optional<core::Problem> look_at(std::span<const runtime::ProbedPou> views) { return program_->look_at(views); }
  /// Null when nobody looks. Whoever looks takes the values, and clears what happened.
  [[nodiscard]] runtime::Probes* probes() const { return program_->probes(); }

  [[nodiscard]] runtime::Program& program() const { return *program_; }
  /// Of the record that was executed last.
  [[nodiscard]] const runtime::RecordHead& head() const { return replay_->head(); }

 private:
  runtime::Program* program_;
  runtime::Replay* replay_;
};

}  // namespace plc::shadow
