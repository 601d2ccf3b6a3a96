// Tasks without code, and a table made by the test: what the tests of exchanges begin with.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "runtime/link/link.h"
#include "runtime/memory/exchange.h"
#include "runtime/memory/global_ports.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {

using runtime::Exchange;
using runtime::GlobalInputs;
using runtime::GlobalReader;
using runtime::GlobalTable;
using runtime::GlobalWrite;
using runtime::WriteResult;

/// A task without code: its local copy of the table is in the hands of the test.
class HandTask {
 public:
  HandTask(GlobalTable& globals, std::uint32_t task, runtime::SetPriority set = nullptr)
      : memory_(globals.size() + 64),
        exchange_(runtime::make_exchange(globals.image().options.coherence, globals, task, memory_.data())) {
    const bytecode::Image& image = globals.image();
    std::memcpy(memory_.data(), image.global_initial.data(), globals.size());
    const auto all = static_cast<std::uint32_t>(image.globals.size());
    in_ = exchange_->add_range(0, all, Exchange::Use::kImport);
    all_ = exchange_->add_range(0, all, Exchange::Use::kRaise);
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[task].body)) {
      if (range.exported) out_.push_back(exchange_->add_range(range.first, range.count, Exchange::Use::kExport));
    }
    exchange_->prepare();
    exchange_->set_priority_change(set);
  }
  void begin() {
    exchange_->begin();
    hold_others_off();
    exchange_->import(in_);
    let_others_on();
  }
  void end() {
    export_only();
    finish();
  }
  /// The two halves of end().
  void export_only() {
    hold_others_off();
    for (const std::uint32_t range : out_) exchange_->export_range(range);
    let_others_on();
  }
  bool finish() { return exchange_->end(); }
  Exchange& exchange() { return *exchange_; }
  template <class T>
  T get(std::uint32_t offset) const {
    T value;
    std::memcpy(&value, memory_.data() + offset, sizeof value);
    return value;
  }
  template <class T>
  void put(std::uint32_t offset, T value) {
    std::memcpy(memory_.data() + offset, &value, sizeof value);
  }

 private:
  runtime::TableMemory memory_;
  void hold_others_off() {
    exchange_->lock();
    exchange_->raise(all_);
  }
  void let_others_on() {
    exchange_->unlock();
    exchange_->reschedule();
  }

  std::unique_ptr<Exchange> exchange_;
  std::uint32_t in_ = 0;
  std::uint32_t all_ = 0;
  std::vector<std::uint32_t> out_;
};

/// Two tasks without code and a table made by the test.
struct Tables {
  ImageBuilder b;
  std::optional<bytecode::VerifiedImage> verified;
  std::unique_ptr<GlobalTable> globals;

  std::uint32_t global(const std::string& name, std::uint32_t type, ImageBuilder::GlobalOptions options = {}) {
    return bytecode::offset_of(b.global(name, type, {}, std::move(options)));
  }
  /// Task 0 is the most urgent.
  GlobalTable& build(std::size_t tasks = 2) {
    for (std::size_t i = 0; i < tasks; ++i) {
      PouBuilder program = b.pou("P" + std::to_string(i), PouKind::kProgram);
      b.task("T" + std::to_string(i), 1'000'000, {program.finish()}, static_cast<std::int32_t>(i));
    }
    core::Diagnostics diagnostics;
    verified = bytecode::verify(b.build(), diagnostics);
    std::ostringstream text;
    diagnostics.render(text);
    EXPECT_TRUE(verified.has_value()) << text.str();
    globals = std::make_unique<GlobalTable>(verified->image());
    return *globals;
  }
  template <class T>
  T read(std::uint32_t offset) const {
    T value;
    globals->read(offset, sizeof value, reinterpret_cast<std::byte*>(&value));
    return value;
  }
  template <class T>
  WriteResult write(std::uint32_t offset, std::uint32_t type, T value, std::optional<T> mask = {}) {
    const GlobalWrite write{offset, type, reinterpret_cast<const std::byte*>(&value),
                            mask ? reinterpret_cast<const std::byte*>(&*mask) : nullptr};
    return globals->write({&write, 1});
  }
};

}  // namespace plc::test
