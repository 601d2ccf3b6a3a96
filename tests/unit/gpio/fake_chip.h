// FakeChip: a GPIO chip in memory, behind the same GpioAccess as the kernel's.
//
// In: levels and edges set by a test, errors it plants. Out: what a driver asked for and wrote. Lines belong to the
// chip as it was plugged in when they were requested: replug() makes them dead for good.
#pragma once

#include <atomic>
#include <cerrno>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "io-drivers/gpio/gpio_lines.h"

namespace plc::test {

struct FakeChip {
  std::map<std::string, bool> level;  ///< of inputs, as the kernel reports them
  std::set<std::string> edges;        ///< inputs whose edge happened since the last read
  std::map<std::string, bool> out;    ///< of outputs
  std::set<std::string> busy;
  bool present = true;
  int plugged = 0;                   ///< how often
  std::atomic<int> error{0};         ///< of reads and writes, while present
  std::atomic<int> errors_left{-1};  ///< so many reads and writes fail with `error`; -1 = all
  int busy_for = 0;                  ///< so many requests find the first output in use
  std::vector<io::LinesRequest> opened;
  int tries = 0, reads = 0, writes = 0;
  int handles = 0;  ///< requests not given back
  std::atomic<bool> in_use{false};
  std::atomic<bool> clashed{false};  ///< two threads used the lines at once

  void replug() {
    ++plugged;
    present = true;
  }
  io::GpioAccess access();
  std::optional<core::Problem> problem_with(const io::LinesRequest& request) {
    if (!present) return core::Problem{core::Code::P7401, "GPIO chip \"" + request.chip + "\" cannot be opened", {}};
    for (const auto* side : {&request.inputs, &request.outputs}) {
      for (const io::LineSpec& spec : *side) {
        if (busy.count(spec.line) != 0) return core::Problem{core::Code::P7404, spec.variable + ": in use", {}};
      }
    }
    return std::nullopt;
  }
};

class FakeLines final : public io::GpioLines {
 public:
  FakeLines(FakeChip& chip, io::LinesRequest request)
      : chip_(chip), request_(std::move(request)), plugged_(chip.plugged) {
    ++chip_.handles;
    for (const io::LineSpec& spec : request_.outputs) chip_.out[spec.line] = spec.initial;
  }
  ~FakeLines() override { --chip_.handles; }

  int read(std::span<io::LineInput> inputs) noexcept override {
    const Use use(chip_);
    ++chip_.reads;
    if (const int error = failure(); error != 0) return error;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const io::LineSpec& spec = request_.inputs[i];
      const auto level = chip_.level.find(spec.line);
      const bool edge = spec.edge != io::LineEdge::kNone && chip_.edges.erase(spec.line) != 0;
      inputs[i] = {level != chip_.level.end() && level->second ? std::uint8_t{1} : std::uint8_t{0}, edge};
    }
    return 0;
  }
  int write(std::span<const std::uint8_t> outputs) noexcept override {
    const Use use(chip_);
    ++chip_.writes;
    if (const int error = failure(); error != 0) return error;
    for (std::size_t i = 0; i < outputs.size(); ++i) chip_.out.find(request_.outputs[i].line)->second = outputs[i] != 0;
    return 0;
  }
  bool gone() noexcept override { return !chip_.present || plugged_ != chip_.plugged; }

 private:
  struct Use {
    explicit Use(FakeChip& chip) : chip_(chip) {
      if (chip_.in_use.exchange(true)) chip_.clashed = true;
    }
    ~Use() { chip_.in_use = false; }
    FakeChip& chip_;
  };
  [[nodiscard]] int failure() const {
    if (!chip_.present || plugged_ != chip_.plugged) return ENODEV;
    if (chip_.error != 0 && chip_.errors_left > 0 && --chip_.errors_left == 0) return chip_.error.exchange(0);
    return chip_.error;
  }
  FakeChip& chip_;
  io::LinesRequest request_;
  int plugged_;
};

inline io::GpioAccess FakeChip::access() {
  return {[this](const io::LinesRequest& request) { return problem_with(request); },
          [this](const io::LinesRequest& request) -> core::Result<std::unique_ptr<io::GpioLines>> {
            ++tries;
            if (auto problem = problem_with(request)) return std::move(*problem);
            if (busy_for > 0) {
              --busy_for;
              return core::Problem{core::Code::P7404, "in use", {}};
            }
            opened.push_back(request);
            return std::unique_ptr<io::GpioLines>(std::make_unique<FakeLines>(*this, request));
          }};
}

}  // namespace plc::test
