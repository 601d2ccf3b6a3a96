// TwoEngines: one image in the interpreter and as native code, scan by scan; whatever differs is a fault of the latter.
//
// In: an image. Out: after each scan what differs between task tables, global tables, events and faults, in words.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "native/compile.h"
#include "runtime/resource.h"

namespace plc::test {

class TwoEngines {
 public:
  /// Verifies and loads the image twice. Null when verifier or linker refuse it; `problem` says what.
  static std::unique_ptr<TwoEngines> load(const bytecode::Image& image, std::string& problem,
                                          const runtime::ProgramOptions& options = {},
                                          const native::CompileOptions& compile = {}) {
    auto engines = std::make_unique<TwoEngines>();
    for (std::unique_ptr<runtime::Resource>* resource : {&engines->interpreted_, &engines->native_}) {
      core::Diagnostics diagnostics;
      auto verified = bytecode::verify(bytecode::Image(image), diagnostics);
      if (!verified) {
        problem = diagnostics.all().empty() ? "refused" : diagnostics.all().front().message;
        return nullptr;
      }
      auto loaded = runtime::Resource::load(std::move(*verified), options);
      if (!loaded) {
        problem = loaded.error().message;
        return nullptr;
      }
      *resource = std::move(*loaded);
    }
    for (std::size_t task = 0; task < engines->tasks(); ++task) {
      auto compiled = native::compile(engines->native_->program(task), compile);
      if (!compiled) {
        problem = compiled.error().message;
        return nullptr;
      }
      engines->reports_.push_back((*compiled)->report());
      engines->native_->program(task).install(std::move(*compiled));
    }
    return engines;
  }

  [[nodiscard]] std::size_t tasks() const { return interpreted_->task_count(); }
  [[nodiscard]] const native::CompileReport& report(std::size_t task) const { return reports_[task]; }
  runtime::Resource& interpreted() { return *interpreted_; }
  runtime::Resource& native() { return *native_; }

  /// One scan of every task in both. What differs then, or an empty text.
  std::string scan(core::TimeNs now_ns) {
    for (std::size_t task = 0; task < tasks(); ++task) {
      const runtime::Fault left = interpreted_->program(task).execute({now_ns});
      const runtime::Fault right = native_->program(task).execute({now_ns});
      if (std::tie(left.kind, left.pou, left.word, left.taskblock) !=
          std::tie(right.kind, right.pou, right.word, right.taskblock)) {
        return "faults differ: " + text(left) + " and " + text(right);
      }
      if (std::string difference = compare(task); !difference.empty()) return difference;
    }
    std::vector<std::byte> left(interpreted_->globals().size());
    std::vector<std::byte> right(left.size());
    interpreted_->globals().copy(left.data());
    native_->globals().copy(right.data());
    return left == right ? std::string() : "global tables differ";
  }

 private:
  static std::string text(const runtime::Fault& fault) {
    return std::to_string(static_cast<int>(fault.kind)) + " at word " + std::to_string(fault.word) + " of POU " +
           std::to_string(fault.pou);
  }
  std::string compare(std::size_t task) {
    runtime::Program& left = interpreted_->program(task);
    runtime::Program& right = native_->program(task);
    const std::byte* const x = left.table().data();
    const std::byte* const y = right.table().data();
    const std::size_t size = left.table().layout().total;
    const auto [at, other] = std::mismatch(x, x + size, y);
    if (at != x + size) {
      return "byte " + std::to_string(at - x) + " of the table is " + std::to_string(static_cast<int>(*at)) +
             ", in native code " + std::to_string(static_cast<int>(*other));
    }
    return events(left) == events(right) ? std::string() : "events differ";
  }
  static std::vector<std::tuple<std::uint32_t, std::uint32_t, int, std::uint64_t>> events(
      const runtime::Program& program) {
    std::vector<std::tuple<std::uint32_t, std::uint32_t, int, std::uint64_t>> all;
    for (const runtime::EventCount& e : program.events()) {
      all.emplace_back(e.pou, e.word, static_cast<int>(e.last), e.count);
    }
    all.emplace_back(~0u, ~0u, 0, program.other_events());
    return all;
  }

  std::unique_ptr<runtime::Resource> interpreted_;
  std::unique_ptr<runtime::Resource> native_;
  std::vector<native::CompileReport> reports_;
};

}  // namespace plc::test
