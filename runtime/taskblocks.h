// Taskblocks: the C++ objects that belong to the taskblock instances of one task (docs/adr/0007; paper, 3.1).
//
// In: a verified image, the task's table, the registry of this machine. Out: one object for each instance, made and
// ready before the first scan, and the step that RUNTB calls. The first field of an instance is the number of its
// object; an object runs on the ports it was made for and no others, whatever an image puts there. Threads: set-up on
// one thread before the task runs; step() on the task's thread; text(), running() on any. Does not belong here: which
// blocks there are (taskblocks/registry.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"
#include "core/result.h"
#include "runtime/memory/queue.h"
#include "runtime/memory/table.h"
#include "runtime/message_ring.h"
#include "runtime/record/record.h"
#include "stdlib/library.h"
#include "taskblocks/registry.h"

namespace plc::runtime {

struct ProgramOptions;
class Recorder;
class Replay;

class Taskblocks {
 public:
  /// Number of no object.
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// What running an object met.
  enum class Status : std::uint8_t {
    kFine,
    kOutOfRange,  ///< an output was outside its declared range, or no number, and is at the nearest limit now
    kFailed,      ///< fire() threw, or there is no object for these ports
    kLate,        ///< fire() took longer than its budget
  };

  /// Prepares an object for every instance that task `task` runs: those in its own instance, and, unless the options
  /// leave them out, the globals it exports. They run after restart(). `queues`: the task's ends of the image's. The
  /// clock of the options measures blocks that declare a budget. P7802 when a block is not in the registry or has other
  /// ports. Null when the image has none.
  static core::Result<std::unique_ptr<Taskblocks>> make(const bytecode::Image& image, std::uint32_t task,
                                                        const taskblocks::Registry& registry, TaskTable& table,
                                                        std::span<QueueEnd> queues, const ProgramOptions& options);
  /// The same instances of a replica: none has an object, and running one gives what the record says.
  static std::unique_ptr<Taskblocks> make_replica(const bytecode::Image& image, std::uint32_t task, TaskTable& table,
                                                  const ProgramOptions& options, Replay& replay);
  ~Taskblocks();
  Taskblocks(const Taskblocks&) = delete;
  Taskblocks& operator=(const Taskblocks&) = delete;

  /// Makes all objects (anew), for the initial values that the table has (again). P7803 when a constructor or ready()
  /// fails.
  std::optional<core::Problem> restart();

  /// Who is told what objects did; null (as at first) = nobody. Between scans.
  void set_recorder(Recorder* recorder) noexcept;

  /// What the objects are told of the cycle that begins. RT.
  void begin(core::TimeNs now_ns, core::TimeNs utc_ns) noexcept {
    set_now(now_ns, utc_ns);
    scans_.store(scans_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  /// The same for a cycle in which time goes on. RT.
  void set_now(core::TimeNs now_ns, core::TimeNs utc_ns) noexcept {
    context_.now_ns = now_ns;
    utc_ns_.store(utc_ns, std::memory_order_relaxed);
  }
  /// Runs the object of the ports. Inline, and with nothing in its way: RUNTB must cost hardly more than the call of
  /// fire() itself (bench/taskblocks.cpp). RT.
  Status run(void* ports) noexcept {
    std::uint32_t number;
    std::memcpy(&number, ports, sizeof number);
    if (number >= calls_.size() || calls_[number].ports != ports) [[unlikely]]
      return fail(kNone, Status::kFailed, {});
    const Call& call = calls_[number];
    running_.store(number, std::memory_order_relaxed);
    Status status = Status::kFine;
    if (call.fire == nullptr) {
      status = fire_checked(number);
    } else if (call.fire(call.object, &failure_) == 0) [[unlikely]] {
      status = fail(number, Status::kFailed, failure_);
    }
    running_.store(kNone, std::memory_order_relaxed);
    return status;
  }
  /// run() for those who know blocks by their step alone; `context.host` is this. RT.
  static void step(void* ports, const stdlib::StepContext& context) noexcept;
  /// What step() met since the last call. RT.
  Status take_status() noexcept {
    const Status status = status_;
    status_ = Status::kFine;
    return status;
  }
  /// The object that failed last. RT.
  [[nodiscard]] std::uint32_t failed() const noexcept { return failed_; }
  /// The object whose fire() is running, or kNone. RT.
  [[nodiscard]] std::uint32_t running() const noexcept { return running_.load(std::memory_order_relaxed); }

  /// "LOWPASS main.filter": an object's block and instance. RT, also for signal handlers.
  [[nodiscard]] const std::string& name(std::uint32_t object) const noexcept { return by_number_[object]->name; }
  /// The name of the object that this thread is making, or null. Also for signal handlers.
  static const char* making() noexcept;
  /// Says that this object's fire(), which is running, has allocated memory. RT.
  void count_allocation(std::uint32_t object) noexcept {
    by_number_[object]->allocations.fetch_add(1, std::memory_order_relaxed);
  }
  /// Allocations that were counted. An object that failed has none: throwing takes memory, and is allowed.
  [[nodiscard]] std::uint64_t allocations(std::uint32_t object) const noexcept;
  [[nodiscard]] std::uint32_t count() const noexcept { return static_cast<std::uint32_t>(by_number_.size()); }

  /// What objects have told since the last call. One thread at a time.
  [[nodiscard]] std::vector<TaskblockMessage> messages();
  [[nodiscard]] std::uint64_t lost_messages() noexcept { return messages_.take_lost(); }

  /// "LOWPASS main.filter", and why it failed first, if it did.
  [[nodiscard]] std::string text(std::uint32_t object) const;

 private:
  struct Range {
    std::byte* at = nullptr;
    core::TypeId type = core::TypeId::kLreal;
    double lowest = 0;
    double highest = 0;
  };
  /// All that run() looks at, packed: with many blocks the caches decide what a call costs.
  struct alignas(32) Call {
    const std::byte* ports = nullptr;
    int (*fire)(void* object, picard_failure* failure) = nullptr;  ///< null: fire_checked() runs it
    void* object = nullptr;
  };
  struct Object {
    const std::byte* ports = nullptr;
    void* object = nullptr;
    std::int64_t budget_ns = 0;
    std::vector<Range> ranges;
    std::vector<PortBytes> outputs;
    const picard_block* block = nullptr;
    std::string path;
    std::string name;  ///< block and path
    std::atomic<std::uint64_t> allocations{0};
    std::vector<void*> places;                 ///< by port
    std::vector<std::uint32_t> port_of_field;  ///< by field of the instance
    picard_failure failure{};
    std::atomic<bool> has_failed{false};  ///< failure is final
  };

  /// What the objects have as their picard_context.
  struct Context : picard_context {
    Taskblocks* owner = nullptr;
  };

  Taskblocks() = default;
  static void tell(const picard_context* context, std::uint32_t object, std::uint32_t severity, const char* text);
  /// An instance of the image: ports, names, outputs; neither block nor object yet.
  Object& add_instance(const bytecode::Image& image, const bytecode::ImageBlock& block, std::byte* ports,
                       std::string path);
  std::optional<core::Problem> add(const bytecode::Image& image, const bytecode::ImageBlock& block, std::byte* ports,
                                   std::string path, const taskblocks::Registry& registry);
  /// Lets wired inputs read the other ends of their wires, and gives queue ports their queues.
  void connect(const bytecode::Image& image, std::uint32_t type, std::byte* at, std::span<QueueEnd> queues);
  /// P7802 when a queue port has none.
  [[nodiscard]] std::optional<core::Problem> check_queues() const;
  /// The object that runs on these ports, or null.
  [[nodiscard]] Object* object_at(const std::byte* ports);
  std::optional<core::Problem> start(std::uint32_t number);
  std::optional<core::Problem> make_object(Object& object, std::uint32_t number);
  /// fire() of a block with a budget, with ranges, or that is recorded; in a replica what the record says.
  Status fire_checked(std::uint32_t number) noexcept;
  Status fire(std::uint32_t number) noexcept;
  /// How run() calls the object.
  void set_call(std::uint32_t number) noexcept;
  /// Notes the failure of an object, or of ports that have none (kNone). Gives `status`.
  Status fail(std::uint32_t number, Status status, const picard_failure& why) noexcept;

  std::deque<Object> objects_;
  std::vector<Object*> by_number_;
  std::vector<Call> calls_;   ///< parallel to by_number_
  picard_failure failure_{};  ///< filled in by a fire() that fails
  Context context_{};
  MessageRing messages_;
  std::atomic<core::TimeNs> utc_ns_{0};
  std::atomic<std::uint64_t> scans_{0};
  const core::Clock* clock_ = nullptr;
  Recorder* recorder_ = nullptr;
  Replay* replay_ = nullptr;  ///< of a replica
  Status status_ = Status::kFine;
  std::uint32_t failed_ = kNone;
  std::atomic<std::uint32_t> running_{kNone};
};

}  // namespace plc::runtime
