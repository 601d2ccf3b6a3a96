// Tasks that exchange globals under one protocol and do nothing else, and memcpy of the same bytes, for
// `plc-bench coherence`.
//
// In: a protocol, how many variables. Out: one half of an exchange at a time. What is timed is in this header: a
// call more would be measured with it. Does not belong here: threads and figures (coherence.cpp).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"
#include "runtime/memory/exchange.h"

namespace plc::bench {

constexpr core::TimeNs kLeadNs = 10'000;  ///< a tenth of the fast task's period

inline core::TimeNs now() { return core::MonotonicClock().now_ns(); }

/// Part of an exchange in which the fast task is held off.
struct Section {
  core::TimeNs begin = 0;
  core::TimeNs end = 0;
};

/// One task without code: its exchange as its body has it, and its local copy.
class alignas(runtime::kTableAlign) ExchangingTask {
 public:
  /// Without `protected_copies` nothing keeps others off: what the protocols add is what they cost.
  ExchangingTask(runtime::GlobalTable& globals, std::uint32_t task, bool protected_copies);
  /// What a task does ahead of its release: as many bytes as the lead has nanoseconds (runtime/sched/realtime.cpp).
  void expect() { exchange_->expect(std::size_t{kLeadNs}); }
  void take() {
    exchange_->begin();
    critical(imports_, [this](std::uint32_t range) { exchange_->import(range); });
  }
  void give() {
    critical(exports_, [this](std::uint32_t range) { exchange_->export_range(range); });
    if (protocol_ == core::Coherence::kWaitFree) exchange_->end();
  }
  /// Under the protocols with a common table the snapshot for devices and servers is made here, which is not theirs.
  void finish() {
    if (protocol_ != core::Coherence::kWaitFree) exchange_->end();
  }
  /// Notes from now on when it holds the fast task off.
  void note_sections(std::vector<Section>& sections) { sections_ = &sections; }
  [[nodiscard]] std::int32_t* values(std::uint32_t offset) {
    return reinterpret_cast<std::int32_t*>(local_.data() + offset);
  }

 private:
  struct Part {
    std::uint32_t raise;
    std::uint32_t copy;
    bool urgent;  ///< the fast task uses it
  };
  template <class Copy>
  void critical(const std::vector<Part>& parts, Copy copy) {
    core::TimeNs begin = 0;
    if (protocol_ == core::Coherence::kGlobalLock) {
      exchange_->lock();
      if (sections_ != nullptr) begin = now();
    }
    for (const Part& part : parts) {
      if (sections_ != nullptr && part.urgent && begin == 0) begin = now();
      if (protocol_ == core::Coherence::kPriorityCeiling) exchange_->raise(part.raise);
      copy(part.copy);
    }
    // Before the fast task can run again.
    if (begin != 0) sections_->push_back({begin, now()});
    if (protocol_ == core::Coherence::kGlobalLock) exchange_->unlock();
    if (protocol_ == core::Coherence::kPriorityCeiling) exchange_->reschedule();
  }

  core::Coherence protocol_;
  runtime::TableMemory local_;
  std::unique_ptr<runtime::Exchange> exchange_;
  std::vector<Part> imports_, exports_;
  std::vector<Section>* sections_ = nullptr;
};

/// One protocol with its tasks.
class alignas(runtime::kTableAlign) ExchangeRig {
 public:
  /// Fast and Slow exchange `common` DINTs in both directions; Slow and Slowest exchange `others` that Fast does not
  /// use. Throws where that does not compile.
  ExchangeRig(core::Coherence protocol, std::uint32_t common, std::uint32_t others, bool protected_copies = true);
  ExchangingTask& task(std::uint32_t task) { return *tasks_[task]; }
  /// Variables of a letter lie side by side: one task writes them, and the same ones read them.
  std::int32_t* values(std::uint32_t task, char letter) {
    return tasks_[task]->values(at_[static_cast<std::size_t>(letter - 'a')]);
  }
  [[nodiscard]] std::uint32_t count(char letter) const { return letter < 'c' ? common_ : others_; }

  [[nodiscard]] core::Coherence protocol() const { return protocol_; }

 private:
  core::Coherence protocol_;
  std::uint32_t common_, others_;
  std::optional<bytecode::VerifiedImage> image_;
  std::unique_ptr<runtime::GlobalTable> globals_;
  std::array<std::unique_ptr<ExchangingTask>, 3> tasks_;
  std::array<std::uint32_t, 4> at_{};
};

/// One exchange of a slow task: takes, checks, fills what it exports with the number of its round, gives. What it took
/// is mixed when not all values of a letter are of one round of the other side.
class alignas(runtime::kTableAlign) SlowTask {
 public:
  SlowTask(ExchangeRig& rig, std::uint32_t task, std::string_view in, std::string_view out)
      : rig_(rig), task_(task), in_(in), out_(out) {}
  void exchange() {
    ++rounds_;
    ExchangingTask& side = rig_.task(task_);
    side.take();
    for (const char letter : in_) mixed_ += is_mixed(rig_, task_, letter) ? 1 : 0;
    for (const char letter : out_)
      std::fill_n(rig_.values(task_, letter), rig_.count(letter), static_cast<std::int32_t>(rounds_));
    side.give();
    side.finish();
  }
  static bool is_mixed(ExchangeRig& rig, std::uint32_t task, char letter) {
    const std::int32_t* const v = rig.values(task, letter);
    return std::any_of(v, v + rig.count(letter), [&](std::int32_t one) { return one != v[0]; });
  }
  [[nodiscard]] std::uint64_t rounds() const { return rounds_; }
  [[nodiscard]] std::uint64_t mixed() const { return mixed_; }

 private:
  ExchangeRig& rig_;
  std::uint32_t task_;
  std::string_view in_, out_;
  std::uint64_t rounds_ = 0, mixed_ = 0;
};

/// Bytes that another processor has just written, and bytes that it reads, for memcpy.
class alignas(runtime::kTableAlign) Mailbox {
 public:
  explicit Mailbox(std::uint32_t count)
      : in_(kBuffers, std::vector<std::int32_t>(count)), out_(in_), local_(count), slow_(count) {}
  /// The copy of what comes in, once more and ahead.
  void expect() { copy_in(); }
  /// Nanoseconds that two memcpy take, with the words that say where the bytes are.
  core::TimeNs copy() {
    const core::TimeNs t0 = now();
    copy_in();
    const core::TimeNs t1 = now();
    std::fill(local_.begin(), local_.end(), static_cast<std::int32_t>(++round_));
    const core::TimeNs t2 = now();
    std::memcpy(out_[round_ % kBuffers].data(), local_.data(), local_.size() * sizeof(std::int32_t));
    taken_.store(round_, std::memory_order_release);
    const core::TimeNs t3 = now();
    return t1 - t0 + t3 - t2;
  }
  /// The other side.
  void exchange() {
    const std::vector<std::int32_t>& from = out_[taken_.load(std::memory_order_acquire) % kBuffers];
    std::memcpy(slow_.data(), from.data(), from.size() * sizeof(std::int32_t));
    std::fill(slow_.begin(), slow_.end(), static_cast<std::int32_t>(++slow_round_));
    std::memcpy(in_[slow_round_ % kBuffers].data(), slow_.data(), slow_.size() * sizeof(std::int32_t));
    written_.store(slow_round_, std::memory_order_release);
  }

 private:
  [[gnu::noinline]] void copy_in() {
    const std::vector<std::int32_t>& from = in_[written_.load(std::memory_order_acquire) % kBuffers];
    std::memcpy(local_.data(), from.data(), from.size() * sizeof(std::int32_t));
  }

  /// As many as a snapshot of one reader has: as long as nobody is held up, none is written while it is read.
  static constexpr std::uint64_t kBuffers = 3;
  std::vector<std::vector<std::int32_t>> in_, out_;
  std::vector<std::int32_t> local_, slow_;
  std::uint64_t round_ = 0, slow_round_ = 0;
  alignas(runtime::kTableAlign) std::atomic<std::uint64_t> written_{0};
  alignas(runtime::kTableAlign) std::atomic<std::uint64_t> taken_{0};
};

}  // namespace plc::bench
