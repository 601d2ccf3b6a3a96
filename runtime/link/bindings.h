// Bindings: which instances each POU of a task runs on, and so which operands are known addresses before it runs.
//
// In: a verified image, the layout of a task's table. Out: for each operand word its place in the table, or its
// distance from the current instance. Does not belong here: code (link.h), what it costs (sched/estimate.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class Bindings {
 public:
  /// `pous` are those that the task body `body` reaches, callers before callees; `layout` must outlive this.
  Bindings(const bytecode::Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous,
           const TaskLayout& layout);

  /// Fixed when the task has one instance of the POU at most.
  [[nodiscard]] Addressing addressing(std::uint32_t pou) const;
  /// Offset in the table of what `operand` of a body of `pou` names; nothing when it depends on the instance.
  [[nodiscard]] std::optional<std::uint32_t> absolute(std::uint32_t pou, std::uint32_t operand) const;
  /// The same as resolved code has it: with kRelativeBit a distance from the instance.
  [[nodiscard]] std::uint32_t resolve(std::uint32_t pou, std::uint32_t operand) const;

 private:
  struct Instances {
    enum class Number : std::uint8_t { kNone, kOne, kMany } number = Number::kNone;
    std::uint32_t at = 0;  ///< kOne: its offset in the table
  };
  void join(std::uint32_t callee, std::optional<std::uint32_t> instance);

  const TaskLayout& layout_;
  std::vector<Instances> instances_;  ///< by POU of the image
};

}  // namespace plc::runtime
