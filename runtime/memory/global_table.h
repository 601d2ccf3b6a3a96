// GlobalTable: the global variable table (GVT) of a resource: who owns which variable, and how the others see it
// (paper, 3.2.2; docs/adr/0012).
//
// Every global has one way to change:
//
// - Owned by a task: it alone exports the variable, and publishes all it owns as one snapshot at the end of a cycle.
//   Writes from outside wait in its journal and are applied at its next start.
// - Owned by a driver: an input that the driver claimed. It publishes all its inputs as one snapshot.
// - Owned by the outside: nobody else writes it. A batch of outside writes is published at once, as one snapshot.
// - Shared: several tasks export it. Each publishes the values it changed, stamped; the newest stamp counts.
// - Overlapping: its address shares bits with another one under --profile=overlay. Single values of at most 8 bytes,
//   each read and written whole; ProcessImage brings them into agreement.
//
// Readers take the newest complete snapshot of each owner; nobody waits for anybody and nothing tears.
// Threads: set-up (constructor, GlobalReader, GlobalInputs) before tasks run, on one thread. read(), write(), copy():
// any thread that is not a task's; they exclude each other by a mutex no task takes. Tasks come through Exchange.
#pragma once

#include <pthread.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/arena.h"
#include "runtime/memory/journal.h"
#include "runtime/memory/queue.h"
#include "runtime/memory/snapshot.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class Exchange;

/// Where the bits of a located variable are, when it shares some with another one (process_image.h).
struct FieldBits {
  std::uint32_t field = 0;  ///< of Image::global_type
  char area = 'I';
  std::uint64_t first_bit = 0;  ///< from the start of the area
  std::uint32_t bits = 1;
};

/// One value to be written from outside the tasks: a scalar or a whole string.
struct GlobalWrite {
  std::uint32_t offset = 0;          ///< of a leaf in the global table
  std::uint32_t type = 0;            ///< of that leaf, index into Image::types
  const std::byte* value = nullptr;  ///< as many bytes as the type has
  const std::byte* mask = nullptr;   ///< bits to take from value, same size; null = all (scalars only)
};

enum class WriteResult : std::uint8_t {
  kDone,     ///< published, or in the journal of the task that exports it
  kBusy,     ///< the task that exports it has stopped, or not started for long; nothing was written
  kRefused,  ///< a constant, an input of a driver, or forced; nothing was written
};

/// Brings a value into the form every reader may rely on: BOOL 0 or 1, the one NaN, string length within its capacity.
/// False, and unchanged, when it is outside the limits of a subrange or enumeration. RT.
bool normalise(const bytecode::ImageType& type, std::byte* value) noexcept;

class GlobalTable {
 public:
  /// `priorities` of the tasks decide the ceilings under --coherence=priority-ceiling; empty = as the image declares.
  explicit GlobalTable(const bytecode::Image& image, std::span<const std::int32_t> priorities = {});
  ~GlobalTable();
  GlobalTable(const GlobalTable&) = delete;
  GlobalTable& operator=(const GlobalTable&) = delete;

  /// Bytes of the table; offsets are below it.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const bytecode::Image& image() const { return image_; }

  /// The newest published value of one leaf (or a whole field, whose leaves may then be of different owners only when
  /// it is shared). Not for tasks.
  void read(std::uint32_t offset, std::uint32_t bytes, std::byte* to) const;
  /// The whole table as published now: of each owner one snapshot. `to` has size() bytes. Not for tasks.
  void copy(std::byte* to) const;
  /// Writes all or nothing. Values are normalised; one that cannot be is left out (the caller checks limits first when
  /// it wants to say so). Allocates. Not for tasks.
  WriteResult write(std::span<const GlobalWrite> batch);
  /// From now on write() refuses these leaves, by their offsets: they are forced (force_list.h). Not for tasks.
  void set_forced(std::vector<std::uint32_t> offsets);
  [[nodiscard]] bool is_forced(std::uint32_t offset) const;
  /// Whether write() would ever accept `field` (of Image::global_type).
  [[nodiscard]] bool writable(std::uint32_t field) const;
  /// Whether a driver may claim `field` as its input: no task exports it, no other driver has it.
  [[nodiscard]] bool claimable(std::uint32_t field) const;
  /// The field that `offset` lies in.
  [[nodiscard]] std::uint32_t field_of(std::uint32_t offset) const noexcept {
    return static_cast<std::uint32_t>(&field_at(offset) - fields_.data());
  }
  /// Tasks that export `field`, ascending.
  [[nodiscard]] std::vector<std::uint32_t> exporters(std::uint32_t field) const;

  /// Priority of `task`; 0 is the most urgent.
  [[nodiscard]] std::int32_t priority(std::uint32_t task) const { return priorities_[task]; }
  /// Priority of the most urgent task that imports or exports `field`, and nothing when no task does.
  [[nodiscard]] std::optional<std::int32_t> ceiling(std::uint32_t field) const { return fields_[field].ceiling; }

  /// Queue `index` of the image (queue.h): beside the variables, also shared by tasks.
  [[nodiscard]] Queue& queue(std::uint32_t index) { return queues_[index]; }

  /// `task` will not start again: writes to what it exports are answered kBusy from now on. Any thread; RT.
  void task_stopped(std::uint32_t task) noexcept;
  /// Whether it was said of `task`: its safe values are published by then. Any thread.
  [[nodiscard]] bool has_stopped(std::uint32_t task) const noexcept {
    return owners_[task].stopped->load(std::memory_order_relaxed);
  }
  /// Cold start: initial values, empty journals and queues. Not while tasks run.
  void reset();
  /// The same with other values, of the whole table: size() bytes, typed as the verifier demands of initial values.
  void reset(std::span<const std::byte> values);
  /// The task that alone exports `field`: its copy is the newest. Nothing when several do, or none.
  [[nodiscard]] std::optional<std::uint32_t> owning_task(std::uint32_t field) const;

 private:
  friend class WaitFreeExchange;
  friend class CommonTableExchange;
  friend class CeilingExchange;
  friend class GlobalReader;
  friend class GlobalInputs;
  friend class ProcessImage;

  enum class Kind : std::uint8_t { kConstant, kOwned, kShared, kOverlapping };
  /// A field of the table and how it changes.
  struct Field {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    Kind kind = Kind::kOwned;
    std::uint32_t owner = 0;         ///< kOwned, and kOverlapping when a driver claimed it or what shares its bits
    std::size_t at = 0;              ///< kOwned: where it is in its owner's snapshot
    std::uint32_t first_leaves = 0;  ///< into leaves_
    std::uint32_t last_leaves = 0;   ///< kOwned and kConstant: none
    std::vector<std::uint32_t> exporters;
    std::optional<std::int32_t> ceiling;
  };
  /// `count` leaves of `bytes` each side by side: parts of a shared or overlapping field.
  struct Leaves {
    std::uint32_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint32_t count = 0;
    std::uint32_t first_copy = 0;  ///< into copies_; shared only
    std::uint32_t last_copy = 0;
    std::uint32_t end() const { return offset + bytes * count; }
  };
  /// One owner's values and stamps of shared leaves, as places in its snapshot.
  struct Copy {
    std::uint32_t owner = 0;
    std::size_t values = 0;
    std::size_t stamps = 0;  ///< 8 bytes a leaf; 0 = never written. Before them the highest of them
  };
  /// Who publishes: the tasks by index, the outside, then drivers.
  struct Owner {
    std::size_t shared_at = 0;   ///< where its copies of shared leaves start in the snapshot; before them what it owns
    std::size_t image_from = 0;  ///< where `image` starts in the snapshot: tasks keep what they own in their local copy
    std::byte* image = nullptr;  ///< the next snapshot, from image_from on
    Snapshot* snapshot = nullptr;
    Journal* journal = nullptr;                  ///< tasks only
    std::unique_ptr<std::atomic<bool>> stopped;  ///< tasks only: it will not start again
    /// What place `at` of the next snapshot has.
    [[nodiscard]] std::byte* next(std::size_t at) const { return image + (at - image_from); }
  };
  /// By owner: the snapshot that one reader holds.
  using Held = std::span<const std::byte* const>;
  /// A reader beside the tasks.
  struct View {
    std::vector<Snapshot::Reader> readers;  ///< by owner
    std::vector<const std::byte*> held;
  };

  [[nodiscard]] std::uint32_t outside() const { return task_count_; }
  /// The field that `offset` lies in.
  [[nodiscard]] const Field& field_at(std::uint32_t offset) const noexcept;
  /// The leaves of `field` that `offset` lies in.
  [[nodiscard]] const Leaves& leaves_at(const Field& field, std::uint32_t offset) const noexcept;
  void add_leaves(std::uint32_t type, std::uint32_t offset);
  void place_owned(std::vector<std::size_t>& bytes);
  void place_shared(std::vector<std::size_t>& bytes);
  /// Calls visit(field) for the other fields that share bits with `field`.
  template <class Visit>
  void for_each_overlapping(std::uint32_t field, Visit visit) const;
  /// Snapshots and images anew, with these values of the whole table; tells the exchanges.
  void rebuild(std::span<const std::byte> values);
  /// The view is kept as long as there are owners, until it is removed.
  void add_view(View& view);
  void remove_view(View& view) { std::erase(views_, &view); }
  /// Who publishes the variable that releases an event task; none for others.
  [[nodiscard]] std::vector<std::uint32_t> owners_of_trigger(std::uint32_t task) const;
  std::uint32_t claim(std::span<const std::uint32_t> fields);
  void attach(Exchange& exchange) { exchanges_.push_back(&exchange); }
  void detach(Exchange& exchange) { std::erase(exchanges_, &exchange); }

  /// Takes the newest snapshot of every owner. RT.
  static void hold(View& view) noexcept;
  /// Copies what [offset, offset + bytes) is in the snapshots held. RT.
  void read_held(Held held, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const noexcept;
  /// Copies the newest of leaf `index` of `leaves`. RT.
  void read_shared(Held held, const Leaves& leaves, std::uint32_t index, std::byte* to) const noexcept;
  /// Where leaf `index` of `leaves` is in the image of `owner`, which has a copy of it. RT.
  struct Stamped {
    std::byte* value;
    std::byte* stamp;
    std::byte* newest;  ///< highest stamp of all leaves of the copy
  };
  [[nodiscard]] Stamped stamped(std::uint32_t owner, const Leaves& leaves, std::uint32_t index) noexcept;
  void publish_image(std::uint32_t owner) noexcept;
  /// Puts a value, where `mask` has bits, into place; false when the result is outside its limits. RT.
  bool merge(std::byte* place, std::uint32_t type, const std::byte* value, const std::byte* mask) const noexcept;
  void write_overlapping(const GlobalWrite& write) noexcept;
  /// Another number whenever a copy of `leaves` in the snapshots held is another one. RT.
  [[nodiscard]] std::uint64_t version(Held held, const Leaves& leaves) const noexcept;
  [[nodiscard]] std::uint64_t next_stamp() noexcept { return stamp_.fetch_add(1, std::memory_order_relaxed) + 1; }

  const bytecode::Image& image_;
  std::size_t size_;
  std::uint32_t task_count_;
  std::vector<std::int32_t> priorities_;     ///< of the tasks
  std::vector<FieldBits> overlapping_bits_;  ///< of every kOverlapping field
  std::vector<Field> fields_;                ///< parallel to those of Image::global_type
  std::vector<Leaves> leaves_;
  std::vector<Copy> copies_;
  std::vector<Owner> owners_;
  std::vector<Exchange*> exchanges_;
  TableMemory overlapping_;  ///< values of overlapping leaves, at their offsets
  TableMemory common_;       ///< what tasks alone export, at its offset, under the protocols with a common table
  std::atomic<std::uint64_t> common_copies_{0};  ///< of common_, under priority ceilings: orders them for the compiler
  mutable pthread_mutex_t common_mutex_;         ///< of common_, under the global lock; waiters lend their priority
  std::atomic<std::uint64_t> stamp_{0};
  mutable std::mutex outside_mutex_;
  std::vector<std::uint32_t> forced_;  ///< offsets of leaves that outside writes are refused of; ascending
  mutable View outside_view_;
  std::vector<View*> views_;  ///< of GlobalReaders
  std::deque<Queue> queues_;
  std::unique_ptr<Arena> arena_;  ///< snapshots, journals, and what exchanges look at in every cycle
};

}  // namespace plc::runtime
