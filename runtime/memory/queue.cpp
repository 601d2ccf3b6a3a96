#include "runtime/memory/queue.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "runtime/record/recorder.h"
#include "runtime/record/replay.h"

namespace plc::runtime {

QueueRing::QueueRing(std::size_t element_bytes, std::uint32_t capacity)
    : element_bytes_(element_bytes), capacity_(capacity), elements_(element_bytes * capacity) {}

// RT:
void QueueRing::step(Side& side) noexcept {
  side.next = side.next + 1 == capacity_ ? 0 : side.next + 1;
  // What was copied is there before the other side counts with it.
  side.total.store(side.total.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

// RT:
bool QueueRing::push(const void* element) noexcept {
  const std::uint64_t put = writer_.total.load(std::memory_order_relaxed);
  if (put - writer_.other == capacity_) {
    writer_.other = reader_.total.load(std::memory_order_acquire);
    if (put - writer_.other == capacity_) return false;
  }
  std::memcpy(elements_.data() + writer_.next * element_bytes_, element, element_bytes_);
  step(writer_);
  return true;
}

// RT:
bool QueueRing::pop(void* element) noexcept {
  const std::uint64_t taken = reader_.total.load(std::memory_order_relaxed);
  if (taken == reader_.other) {
    reader_.other = writer_.total.load(std::memory_order_acquire);
    if (taken == reader_.other) return false;
  }
  std::memcpy(element, elements_.data() + reader_.next * element_bytes_, element_bytes_);
  step(reader_);
  return true;
}

// RT:
std::uint32_t QueueRing::count() const noexcept {
  // What was taken first: what was put is no less then. Others may see more than fits, when both go on in between.
  const std::uint64_t taken = reader_.total.load(std::memory_order_acquire);
  const std::uint64_t put = writer_.total.load(std::memory_order_acquire);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(put - taken, capacity_));
}

void QueueRing::clear() noexcept {
  for (Side* side : {&writer_, &reader_}) {
    side->total.store(0, std::memory_order_relaxed);
    side->other = 0;
    side->next = 0;
  }
}

Queue::Queue(const bytecode::Image& image, const bytecode::ImageQueue& queue)
    : queue_(queue), element_bytes_(image.types[queue.type].size) {
  for (std::size_t i = 0; i < queue.puts.size(); ++i) rings_.emplace_back(element_bytes_, queue.capacity);
}

QueueRing* Queue::ring_of(std::uint32_t task) noexcept {
  const auto found = std::find(queue_.puts.begin(), queue_.puts.end(), task);
  return found == queue_.puts.end() ? nullptr : &rings_[static_cast<std::size_t>(found - queue_.puts.begin())];
}

// RT:
bool Queue::pop(void* element) noexcept {
  for (std::size_t i = 0; i < rings_.size(); ++i) {
    QueueRing& ring = rings_[turn_];
    turn_ = turn_ + 1 == rings_.size() ? 0 : turn_ + 1;
    if (ring.pop(element)) return true;
  }
  return false;
}

// RT:
std::uint32_t Queue::count() const noexcept {
  std::uint64_t sum = 0;
  for (const QueueRing& ring : rings_) sum += ring.count();
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(sum, std::numeric_limits<std::uint32_t>::max()));
}

void Queue::clear() noexcept {
  for (QueueRing& ring : rings_) ring.clear();
  turn_ = 0;
}

QueueEnd::QueueEnd(Queue& queue, std::uint32_t task)
    : picard_queue{
          [](picard_queue* self, const void* element) { return static_cast<QueueEnd*>(self)->put_in(element) ? 1 : 0; },
          [](picard_queue* self, void* element) { return static_cast<QueueEnd*>(self)->take_out(element) ? 1 : 0; },
          [](picard_queue* self) { return static_cast<QueueEnd*>(self)->count(); },
          [](picard_queue* self) { return static_cast<QueueEnd*>(self)->space(); }},
      queue_(&queue),
      ring_(queue.ring_of(task)),
      takes_(queue.taken_by(task)),
      element_bytes_(queue.element_bytes()) {}

// No taskblock runs in a replica.
QueueEnd::QueueEnd(Replay& replay, std::size_t element_bytes)
    : picard_queue{}, queue_(nullptr), ring_(nullptr), takes_(false), element_bytes_(element_bytes), replay_(&replay) {}

// RT:
bool QueueEnd::put(const void* element) noexcept {
  if (replay_ != nullptr) return replay_->queue(nullptr, 0);
  const bool done = put_in(element);
  if (recorder_ != nullptr) recorder_->queue(done, {});
  return done;
}

// RT:
bool QueueEnd::take(void* element) noexcept {
  if (replay_ != nullptr) return replay_->queue(element, element_bytes_);
  const bool done = take_out(element);
  if (recorder_ != nullptr)
    recorder_->queue(done, {static_cast<const std::byte*>(element), done ? element_bytes_ : std::size_t{0}});
  return done;
}

// RT:
std::uint32_t QueueEnd::elements() noexcept {
  const std::uint32_t answer = replay_ != nullptr ? replay_->number() : count();
  if (recorder_ != nullptr) recorder_->number(answer);
  return answer;
}

// RT:
std::uint32_t QueueEnd::room() noexcept {
  const std::uint32_t answer = replay_ != nullptr ? replay_->number() : space();
  if (recorder_ != nullptr) recorder_->number(answer);
  return answer;
}

}  // namespace plc::runtime
