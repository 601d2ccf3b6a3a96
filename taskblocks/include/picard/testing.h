// Tests of taskblocks without a PLC: make one, set its ports by name, fire it, look at what it gives.
//
//   picard::Instance filter(picard_library_v1(), "LOWPASS", std::chrono::milliseconds(1));
//   filter.port<double>("CUTOFF") = 10.0;
//   filter.ready();
//   filter.port<double>("IN") = 1.0;
//   filter.fire();
//   EXPECT_NEAR(filter.port<double>("OUT"), 0.06, 0.01);
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "picard/taskblock.h"
#include "picard/value_reader.h"

namespace picard {

/// A queue of any length in place of the runtime's.
class TestQueue : public picard_queue {
 public:
  TestQueue(std::size_t element_bytes, std::uint32_t capacity) : bytes_(element_bytes), capacity_(capacity) {
    push = [](picard_queue* queue, const void* element) {
      auto& self = *static_cast<TestQueue*>(queue);
      if (self.elements.size() >= self.capacity_) return 0;
      const auto* const from = static_cast<const std::byte*>(element);
      self.elements.emplace_back(from, from + self.bytes_);
      return 1;
    };
    pop = [](picard_queue* queue, void* element) {
      auto& self = *static_cast<TestQueue*>(queue);
      if (self.elements.empty()) return 0;
      std::memcpy(element, self.elements.front().data(), self.bytes_);
      self.elements.pop_front();
      return 1;
    };
    count = [](picard_queue* queue) {
      return static_cast<std::uint32_t>(static_cast<TestQueue*>(queue)->elements.size());
    };
    space = [](picard_queue* queue) {
      auto& self = *static_cast<TestQueue*>(queue);
      return self.capacity_ - static_cast<std::uint32_t>(self.elements.size());
    };
  }
  std::deque<std::vector<std::byte>> elements;

 private:
  std::size_t bytes_;
  std::uint32_t capacity_;
};

/// What a block has told the operator.
struct Told {
  Severity severity = Severity::Note;
  std::string text;
};

/// One block with ports of its own, which have the initial values of their declaration.
class Instance {
 public:
  /// Throws std::invalid_argument when the library has no such block, or an initial value is none of its port's type.
  Instance(const picard_library* library, std::string_view block, std::chrono::nanoseconds period) {
    for (std::uint32_t i = 0; i < library->block_count; ++i) {
      if (block == library->blocks[i].name) block_ = &library->blocks[i];
    }
    if (block_ == nullptr) throw std::invalid_argument("no taskblock " + std::string(block));
    context_.period_ns = period.count();
    context_.owner = this;
    context_.tell = [](const picard_context* context, std::uint32_t, std::uint32_t severity, const char* text) {
      Instance& self = *static_cast<const Context*>(context)->owner;
      const std::lock_guard lock(self.mutex_);
      if (self.told_.size() == kMostTold) return;
      picard_failure& place = self.told_.emplace_back(static_cast<Severity>(severity), picard_failure{}).second;
      std::strncpy(place.text, text, PICARD_TEXT_BYTES - 1);
    };
    told_.reserve(kMostTold);
    for (std::uint32_t i = 0; i < block_->port_count; ++i) {
      const picard_port& port = block_->ports[i];
      memory_.emplace_back(port.type->size + 16);
      std::byte* const at = align(memory_.back());
      detail::begin_value(*port.type, at);
      if (port.initial[0] != '\0') detail::ValueReader(port.initial).read(*port.type, at);
      if (is_queue(port)) {
        queues_.emplace_back(port.type->size, 64);
        places_.push_back(static_cast<picard_queue*>(&queues_.back()));
      } else {
        places_.push_back(at);
      }
    }
  }
  ~Instance() {
    if (object_ != nullptr) block_->destroy(object_);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  /// Makes the object, anew if there is one, and calls its ready(). Throws std::runtime_error when that fails.
  void ready() {
    picard_failure failure{};
    if (object_ != nullptr) block_->destroy(object_);
    object_ = block_->create(places_.data(), &context_, &failure);
    if (object_ == nullptr || block_->ready(object_, &failure) == 0) throw std::runtime_error(failure.text);
  }
  /// One cycle; time goes on by a period. Throws std::runtime_error when fire() failed.
  void fire() {
    if (object_ == nullptr) ready();
    picard_failure failure{};
    const int done = block_->fire(object_, &failure);
    context_.now_ns += context_.period_ns;
    if (done == 0) throw std::runtime_error(failure.text);
  }
  /// The value of a port; throws std::invalid_argument for a wrong name or type.
  template <class T>
  T& port(std::string_view name) {
    const std::uint32_t i = find(name);
    if (!same(*block_->ports[i].type, *detail::type_of<T>())) throw std::invalid_argument("port of another type");
    return *static_cast<T*>(places_[i]);
  }
  /// Gives a port of any type a value as a project spells it: set("X", "[0.0, 2(10.0)]"), set("MODE", "Manual"). What
  /// the value leaves out stays as it is. Throws std::invalid_argument for a wrong name or value.
  void set(std::string_view name, std::string_view value) {
    const std::uint32_t i = find(name);
    if (is_queue(block_->ports[i])) throw std::invalid_argument("a queue has no value");
    detail::ValueReader(value).read(*block_->ports[i].type, static_cast<std::byte*>(places_[i]));
  }
  TestQueue& queue(std::string_view name) {
    return *static_cast<TestQueue*>(static_cast<picard_queue*>(places_[find(name)]));
  }
  [[nodiscard]] const picard_block& block() const { return *block_; }
  /// The first kMostTold messages to the operator. Telling one takes no memory, as in a PLC.
  [[nodiscard]] std::vector<Told> told() const {
    const std::lock_guard lock(mutex_);
    std::vector<Told> all;
    for (const auto& [severity, said] : told_) all.push_back({severity, said.text});
    return all;
  }
  static constexpr std::size_t kMostTold = 256;

 private:
  struct Context : picard_context {
    Instance* owner = nullptr;
  };
  [[nodiscard]] std::uint32_t find(std::string_view name) const {
    for (std::uint32_t i = 0; i < block_->port_count; ++i) {
      if (name == block_->ports[i].name) return i;
    }
    throw std::invalid_argument("no port " + std::string(name));
  }
  static bool is_queue(const picard_port& port) {
    return port.direction == PICARD_QUEUE_READER || port.direction == PICARD_QUEUE_WRITER;
  }
  /// WHY not by address: a shared library has descriptions of its own.
  static bool same(const picard_type& a, const picard_type& b) {
    if (a.kind != b.kind || a.size != b.size || a.capacity != b.capacity || a.field_count != b.field_count)
      return false;
    if (std::strcmp(a.name, b.name) != 0 || (a.element != nullptr && !same(*a.element, *b.element))) return false;
    for (std::uint32_t i = 0; i < a.field_count; ++i) {
      if (a.fields[i].offset != b.fields[i].offset || !same(*a.fields[i].type, *b.fields[i].type)) return false;
    }
    return true;
  }
  static std::byte* align(std::vector<std::byte>& memory) {
    const auto at = reinterpret_cast<std::uintptr_t>(memory.data());
    return memory.data() + (16 - at % 16) % 16;
  }
  const picard_block* block_ = nullptr;
  Context context_{};
  mutable std::mutex mutex_;  ///< of told_: components have threads
  std::vector<std::pair<Severity, picard_failure>> told_;
  std::deque<std::vector<std::byte>> memory_;
  std::deque<TestQueue> queues_;
  std::vector<void*> places_;
  void* object_ = nullptr;
};

}  // namespace picard
