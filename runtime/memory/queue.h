// Queue: elements from several tasks to one, in the order in which each of them put them in; nobody waits (paper, 3.1).
//
// Each task that puts has a ring of its own, so every ring has one writer and one reader, who each move one counter
// that the other one only looks at. The reader takes one element of each ring in turn, so a busy writer keeps nobody
// out. An element is there for the reader as soon as it was put, not at the end of the writer's cycle.
//
// In: a queue of a verified image. Out: ends for the tasks (QueueEnd), which instructions and the queue ports of
// taskblocks use. Threads: every end belongs to one task; count() may be asked by any. Does not belong here: which task
// has which end (the image says so), values of globals (global_table.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/table.h"
#include "taskblocks/include/picard/abi.h"

namespace plc::runtime {

class Recorder;
class Replay;

/// One writer, one reader, a fixed number of elements.
class QueueRing {
 public:
  QueueRing(std::size_t element_bytes, std::uint32_t capacity);

  /// Copies the element in. False, and nothing happened, when the ring is full. The writer. RT.
  bool push(const void* element) noexcept;
  /// Copies the oldest element out. False, and nothing happened, when the ring is empty. The reader. RT.
  bool pop(void* element) noexcept;
  /// Elements there are: exact for the reader as what it can take, for others a moment's view. RT.
  [[nodiscard]] std::uint32_t count() const noexcept;
  /// Elements that fit. The writer. RT.
  [[nodiscard]] std::uint32_t space() const noexcept { return capacity_ - count(); }
  /// Empties the ring. Neither side runs.
  void clear() noexcept;

 private:
  /// What one side moves, on cache lines of its own.
  struct alignas(kTableAlign) Side {
    std::atomic<std::uint64_t> total{0};  ///< elements put or taken since the start
    std::uint64_t other = 0;              ///< `total` of the other side, as seen last
    std::uint32_t next = 0;               ///< place of the next element
  };
  void step(Side& side) noexcept;

  std::size_t element_bytes_;
  std::uint32_t capacity_;
  TableMemory elements_;
  Side writer_;
  Side reader_;
};

class Queue {
 public:
  Queue(const bytecode::Image& image, const bytecode::ImageQueue& queue);

  /// The ring of a task that puts, or null.
  [[nodiscard]] QueueRing* ring_of(std::uint32_t task) noexcept;
  [[nodiscard]] std::size_t element_bytes() const noexcept { return element_bytes_; }
  /// Whether this task takes the elements out.
  [[nodiscard]] bool taken_by(std::uint32_t task) const noexcept { return queue_.takes == task; }
  /// The next element, of one ring after the other. False, and nothing happened, when all are empty. The reader. RT.
  bool pop(void* element) noexcept;
  /// Elements in all rings. RT.
  [[nodiscard]] std::uint32_t count() const noexcept;
  /// Empties the queue. No task runs.
  void clear() noexcept;

 private:
  const bytecode::ImageQueue& queue_;
  std::size_t element_bytes_;
  std::deque<QueueRing> rings_;  ///< of the tasks in queue_.puts
  std::size_t turn_ = 0;         ///< the ring that is asked first
};

/// A queue as one task has it: what the instructions use, and what the port of a taskblock is given.
class QueueEnd : public picard_queue {
 public:
  QueueEnd(Queue& queue, std::uint32_t task);
  /// Of a replica: what the recorded task was told. `element_bytes` of the queue.
  QueueEnd(Replay& replay, std::size_t element_bytes);

  /// Who is told what instructions get; null (as at first) = nobody. Between cycles.
  void set_recorder(Recorder* recorder) noexcept { recorder_ = recorder; }

  // For instructions; all RT.
  /// False when the queue is full, or this task has no ring.
  bool put(const void* element) noexcept;
  /// False when the queue is empty, or another task takes its elements.
  bool take(void* element) noexcept;
  [[nodiscard]] std::uint32_t elements() noexcept;
  [[nodiscard]] std::uint32_t room() noexcept;

 private:
  // For ports of taskblocks, whose outputs are recorded, not what they do.
  bool put_in(const void* element) noexcept { return ring_ != nullptr && ring_->push(element); }
  bool take_out(void* element) noexcept { return takes_ && queue_->pop(element); }
  [[nodiscard]] std::uint32_t count() const noexcept { return queue_->count(); }
  [[nodiscard]] std::uint32_t space() const noexcept { return ring_ == nullptr ? 0 : ring_->space(); }

  Queue* queue_;
  QueueRing* ring_;  ///< null when the task does not put
  bool takes_;
  std::size_t element_bytes_;
  Recorder* recorder_ = nullptr;
  Replay* replay_ = nullptr;  ///< of a replica
};

}  // namespace plc::runtime
