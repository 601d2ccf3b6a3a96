// Probes: what a replica has at the places of drawings and texts that somebody looks at (bytecode/probes.h), taken
// while it executes scans.
//
// In: the probe maps of an image, which POUs on which instances are looked at. Out: for each step its last value, and
// whether it was executed, was FALSE, was TRUE since its viewer has cleared that. Threads: those of its program;
// between scans. Does not belong here: which step is what in a drawing (shadow/probe_view.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/table.h"
#include "runtime/program.h"

namespace plc::runtime {

/// The steps of one POU on one instance.
class ProbeValues {
 public:
  // What happened to a step since clear().
  static constexpr std::uint8_t kRan = 1;
  static constexpr std::uint8_t kWasFalse = 2;  ///< of BOOLs
  static constexpr std::uint8_t kWasTrue = 4;
  static constexpr std::uint8_t kWasUnknown = 8;  ///< the code did not compute it

  [[nodiscard]] std::uint8_t bits(std::uint32_t step) const { return bits_[step]; }
  /// Type of the step's values in the image; bytecode::kNoProbeType: BOOL without a variable, or no value.
  [[nodiscard]] std::uint32_t type(std::uint32_t step) const { return (*steps_)[step].type; }
  /// The last value, as many bytes as its type has; of texts the first 80 bytes, with their length. Empty: the step has
  /// none, or it is not known.
  [[nodiscard]] std::span<const std::byte> value(std::uint32_t step) const;
  [[nodiscard]] bool is_bool(std::uint32_t step) const { return (*steps_)[step].is_bool; }
  /// The last value of a BOOL; false where there is none.
  [[nodiscard]] bool is_true(std::uint32_t step) const;
  void clear();

 private:
  friend class Probes;
  struct Step {
    bytecode::ProbeOp op = bytecode::ProbeOp::kReached;
    bool is_bool = false;
    std::uint16_t bytes = 0;
    std::uint16_t character = 0;             ///< bytes of one, of texts; else 0
    std::uint32_t at = 0;                    ///< of its value in values_
    std::uint32_t a = 0, b = 0;              ///< kCapture: a resolved operand; logic: places of values
    std::uint32_t when = bytecode::kNoStep;  ///< a place of a value
    std::uint32_t type = bytecode::kNoProbeType;
  };
  static constexpr std::byte kUnknown{2};  ///< a BOOL that the code does not compute

  std::uint32_t instance_ = 0;
  const std::vector<Step>* steps_ = nullptr;
  std::vector<std::byte> values_;
  std::vector<std::uint8_t> bits_;
};

class Probes {
 public:
  /// Views of POUs that the task body `body` does not reach, or that have no map, have nothing to see. `pous` as
  /// reached_pous() gives them. `image` outlives this.
  Probes(const bytecode::Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous,
         const TaskLayout& layout, std::span<const ProbedPou> views);

  static constexpr std::uint32_t kNobody = 0xffffffffu;
  /// The number of a POU that is looked at, or kNobody.
  [[nodiscard]] std::uint32_t number_of(std::uint32_t pou) const { return number_of_[pou]; }
  /// Null when nothing is to be seen.
  [[nodiscard]] ProbeValues* find(const ProbedPou& view);

  /// Steps `first` to `end` of POU number `number`, which runs on the instance at `instance`. RT, but for its length.
  void run(std::uint32_t number, std::uint32_t first, std::uint32_t end, std::byte* table,
           std::uint32_t instance) noexcept;

 private:
  struct Pou {
    std::uint32_t pou = 0;
    std::optional<std::uint32_t> only;  ///< the instance it runs on, when there is one alone
    std::vector<ProbeValues::Step> steps;
    std::uint32_t value_bytes = 0;
    std::vector<ProbeValues> seen;  ///< ascending instances
  };

  std::vector<std::unique_ptr<Pou>> pous_;
  std::vector<std::uint32_t> number_of_;  ///< by POU of the image
};

}  // namespace plc::runtime
