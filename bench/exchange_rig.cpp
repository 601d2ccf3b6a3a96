#include "bench/exchange_rig.h"

#include <fmt/format.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/scratch.h"
#include "compiler/compile.h"
#include "runtime/link/link.h"
#include "runtime/memory/common_table_exchange.h"
#include "runtime/sched/thread_settings.h"

namespace plc::bench {
namespace {

using core::Coherence;

/// Fast and Slow exchange `common` DINTs in both directions; Slow and Slowest exchange `others` that Fast does not use.
std::string source(std::uint32_t common, std::uint32_t others) {
  std::string text = "VAR_GLOBAL\n";
  const auto list = [&text](char letter, std::uint32_t count, std::string_view format) {
    for (std::uint32_t i = 0; i < count; ++i) text += fmt::format(fmt::runtime(format), letter, i);
  };
  for (const char letter : {'a', 'b'}) list(letter, common, "  {}{} : DINT;\n");
  for (const char letter : {'c', 'd'}) list(letter, others, "  {}{} : DINT;\n");
  text += "END_VAR\n";
  const auto program = [&](std::string_view name, std::string_view pairs, std::uint32_t first_count,
                           std::uint32_t second_count) {
    text += fmt::format("PROGRAM {}\nVAR_EXTERNAL\n", name);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      list(pairs[i], i < 2 ? first_count : second_count, "  {}{} : DINT;\n");
    text += "END_VAR\n";
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
      const std::uint32_t count = i < 2 ? first_count : second_count;
      for (std::uint32_t v = 0; v < count; ++v) text += fmt::format("  {0}{2} := {1}{2};\n", pairs[i], pairs[i + 1], v);
    }
    text += "END_PROGRAM\n";
  };
  program("Fast", "ba", common, 0);
  program("Slow", "abcd", common, others);
  program("Slowest", "dc", others, 0);
  text += "CONFIGURATION C\n  RESOURCE R ON PLC\n";
  text += "    TASK TFast(INTERVAL := T#1ms, PRIORITY := 0);\n    TASK TSlow(INTERVAL := T#10ms, PRIORITY := 1);\n";
  text += "    TASK TSlowest(INTERVAL := T#20ms, PRIORITY := 2);\n    PROGRAM fast WITH TFast : Fast;\n";
  text += "    PROGRAM slow WITH TSlow : Slow;\n    PROGRAM slowest WITH TSlowest : Slowest;\n";
  return text + "  END_RESOURCE\nEND_CONFIGURATION\n";
}

/// The copies of a common table without anything that keeps others off.
class UnprotectedExchange final : public runtime::CommonTableExchange {
 public:
  using CommonTableExchange::CommonTableExchange;
  void import(std::uint32_t range) noexcept override { copy_in(range); }
  void export_range(std::uint32_t range) noexcept override {
    if (may_publish()) copy_out(range);
  }
};

}  // namespace

ExchangingTask::ExchangingTask(runtime::GlobalTable& globals, std::uint32_t task, bool protected_copies)
    : protocol_(globals.image().options.coherence), local_(globals.size()) {
  if (protected_copies) {
    exchange_ = runtime::make_exchange(protocol_, globals, task, local_.data());
  } else {
    exchange_ = std::make_unique<UnprotectedExchange>(globals, task, local_.data());
  }
  const bytecode::Image& image = globals.image();
  for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[task].body)) {
    using Use = runtime::Exchange::Use;
    bool urgent = false;
    for (std::uint32_t f = range.first; f < range.first + range.count; ++f) urgent = urgent || globals.ceiling(f) == 0;
    (range.exported ? exports_ : imports_)
        .push_back({exchange_->add_range(range.first, range.count, Use::kRaise),
                    exchange_->add_range(range.first, range.count, range.exported ? Use::kExport : Use::kImport),
                    urgent});
  }
  exchange_->prepare();
  exchange_->set_priority_change(runtime::set_own_priority);
}

ExchangeRig::ExchangeRig(Coherence protocol, std::uint32_t common, std::uint32_t others, bool protected_copies)
    : protocol_(protocol), common_(common), others_(others) {
  const Scratch scratch;
  std::ofstream(scratch.file("exchange.st")) << source(common, others);
  compiler::Compilation compilation;
  core::CompileOptions options;
  options.coherence = protocol;
  compiler::compile({scratch.file("exchange.st"), options, compiler::Goal::kRun}, compilation);
  if (!compilation.image) throw std::runtime_error("the project of the coherence benchmark does not compile");
  image_ = std::move(*compilation.image);
  const bytecode::Image& image = image_->image();
  globals_ = std::make_unique<runtime::GlobalTable>(image);
  for (std::uint32_t task = 0; task < 3; ++task)
    tasks_[task] = std::make_unique<ExchangingTask>(*globals_, task, protected_copies);
  for (const bytecode::ImageField& field : image.types[image.global_type].fields) {
    if (field.name.size() == 2 && field.name[1] == '0')
      at_[static_cast<std::size_t>(field.name[0] - 'a')] = field.offset;
  }
}

}  // namespace plc::bench
