// Tests of taskblocks without a PLC: make one, set its ports by name, fire it, look at what it gives.
//
//   picard::Instance filter(picard_library_v1(), "LOWPASS", std::chrono::milliseconds(1));
//   filter.port<double>("CUTOFF") = 10.0;
//   filter.ready();
//   filter.port<double>("IN") = 1.0;
//   filter.fire();
//   EXPECT_NEAR(filter.port<double>("OUT"), 0.06, 0.01);
#pragma once

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "picard/taskblock.h"

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

/// One block with ports of its own. Numbers and times have the initial values of their declaration; other initial
/// values are for the test to set.
class Instance {
 public:
  /// Throws std::invalid_argument when the library has no such block.
  Instance(const picard_library* library, std::string_view block, std::chrono::nanoseconds period) {
    for (std::uint32_t i = 0; i < library->block_count; ++i) {
      if (block == library->blocks[i].name) block_ = &library->blocks[i];
    }
    if (block_ == nullptr) throw std::invalid_argument("no taskblock " + std::string(block));
    context_.period_ns = period.count();
    for (std::uint32_t i = 0; i < block_->port_count; ++i) {
      const picard_port& port = block_->ports[i];
      memory_.emplace_back(port.type->size + 16);
      void* const at = align(memory_.back());
      give_capacities(*port.type, static_cast<std::byte*>(at));
      give_initial(port, at);
      if (port.direction == PICARD_QUEUE_READER || port.direction == PICARD_QUEUE_WRITER) {
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
  TestQueue& queue(std::string_view name) {
    return *static_cast<TestQueue*>(static_cast<picard_queue*>(places_[find(name)]));
  }
  [[nodiscard]] const picard_block& block() const { return *block_; }

 private:
  [[nodiscard]] std::uint32_t find(std::string_view name) const {
    for (std::uint32_t i = 0; i < block_->port_count; ++i) {
      if (name == block_->ports[i].name) return i;
    }
    throw std::invalid_argument("no port " + std::string(name));
  }
  /// WHY not by address: a shared library has descriptions of its own.
  static bool same(const picard_type& a, const picard_type& b) {
    if (a.kind != b.kind || a.size != b.size || a.capacity != b.capacity || a.field_count != b.field_count) return false;
    if (std::strcmp(a.name, b.name) != 0 || (a.kind == PICARD_ARRAY && !same(*a.element, *b.element))) return false;
    for (std::uint32_t i = 0; i < a.field_count; ++i) {
      if (a.fields[i].offset != b.fields[i].offset || !same(*a.fields[i].type, *b.fields[i].type)) return false;
    }
    return true;
  }
  static void* align(std::vector<std::byte>& memory) {
    const auto at = reinterpret_cast<std::uintptr_t>(memory.data());
    return memory.data() + (16 - at % 16) % 16;
  }
  static void give_capacities(const picard_type& type, std::byte* at) {
    if (type.kind == PICARD_STRING) {
      const auto capacity = static_cast<std::uint16_t>(type.capacity);
      std::memcpy(at, &capacity, sizeof capacity);
    }
    for (std::uint32_t i = 0; type.kind == PICARD_ARRAY && i < type.capacity; ++i) {
      give_capacities(*type.element, at + std::size_t{i} * type.element->size);
    }
    for (std::uint32_t i = 0; i < type.field_count; ++i)
      give_capacities(*type.fields[i].type, at + type.fields[i].offset);
  }
  template <class T>
  static bool give(const picard_port& port, void* at, T value) {
    if (!same(*port.type, *detail::type_of<T>())) return false;
    std::memcpy(at, &value, sizeof value);
    return true;
  }
  static void give_initial(const picard_port& port, void* at) {
    const std::string_view text = port.initial;
    if (text.empty()) return;
    if (give<bool>(port, at, text == "TRUE" || text == "1")) return;
    const std::size_t hash = text.find('#');
    const char* const number = port.initial + (hash == std::string_view::npos ? 0 : hash + 1);
    char* rest = nullptr;
    const double value = std::strtod(number, &rest);
    double unit = 1e9;
    if (std::string_view(rest) == "ms") unit = 1e6;
    if (std::string_view(rest) == "us") unit = 1e3;
    if (std::string_view(rest) == "ns") unit = 1;
    give<Time>(port, at, Time(static_cast<std::int64_t>(value * unit))) || give<double>(port, at, value) ||
        give<float>(port, at, static_cast<float>(value)) ||
        give<std::int16_t>(port, at, static_cast<std::int16_t>(value)) ||
        give<std::int32_t>(port, at, static_cast<std::int32_t>(value)) ||
        give<std::int64_t>(port, at, static_cast<std::int64_t>(value)) ||
        give<std::uint16_t>(port, at, static_cast<std::uint16_t>(value)) ||
        give<std::uint32_t>(port, at, static_cast<std::uint32_t>(value)) ||
        give<std::uint8_t>(port, at, static_cast<std::uint8_t>(value));
  }

  const picard_block* block_ = nullptr;
  picard_context context_{};
  std::deque<std::vector<std::byte>> memory_;
  std::deque<TestQueue> queues_;
  std::vector<void*> places_;
  void* object_ = nullptr;
};

}  // namespace picard
