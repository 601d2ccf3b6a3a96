// Device: one Modbus unit: what is asked when, what its inputs are worth, what is written to it.
//
// In: points with their codings, a link, the time. Out: inputs and status as snapshots in the global table, outputs at
// the device, sentences for the operator. Blocks of one period are a poll class; a block is due on its own grid.
// Threads: turn(), due() and write_safe() belong to the thread of the bus; what tasks tell is atomic; what people ask
// is behind a mutex that no task takes. Does not belong here: threads (bus.h), plc.toml (modbus_type.cpp).
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/driver.h"
#include "io-drivers/modbus-client/codec.h"
#include "io-drivers/modbus-client/link.h"
#include "io-drivers/modbus-client/plan.h"
#include "runtime/memory/global_ports.h"

namespace plc::modbus_client {

using core::TimeNs;

struct DeviceSettings {
  std::string name;   ///< of the driver
  std::string where;  ///< "192.168.1.20:502, unit 1"
  std::uint8_t unit = 1;
  TimeNs timeout_ns = 500'000'000;
  std::uint32_t retries = 2;        ///< of a request, before the device counts as lost
  TimeNs retry_ns = 1'000'000'000;  ///< from the loss to the first attempt; each further one waits twice as long
  TimeNs retry_max_ns = 30'000'000'000;
  TimeNs write_ns = 10'000'000;       ///< how often outputs are compared
  TimeNs rewrite_ns = 1'000'000'000;  ///< unchanged outputs are written again; 0 = never
  Limits read_limits;
  Limits write_limits;
  bool multiple = false;  ///< functions 15 and 16 for one cell, too
};

/// An input and where its value comes from.
struct ReadPoint {
  std::string_view variable;
  Want want;
  Coding coding;
  std::uint32_t offset = 0, type = 0;  ///< in the global table
  std::vector<std::byte> substitute;   ///< from the start and on loss; empty = the last value
  std::uint32_t bytes = 8;             ///< of the variable
};

enum class Status : std::uint8_t { kOk, kAge, kError };
/// A variable that tells about the device.
struct StatusPoint {
  Status what = Status::kOk;
  core::TypeId variable = core::TypeId::kBool;
  std::uint32_t offset = 0, type = 0;
};

struct WritePoint {
  Want want;
  Coding coding;
  std::uint32_t offset = 0, bytes = 0;
  std::vector<std::byte> safe, initial;
  std::vector<std::uint32_t> exporters;  ///< tasks that write it
};

class Device {
 public:
  /// Set-up only. `task`: the one after whose first scan outputs are the program's.
  Device(DeviceSettings settings, std::uint32_t task, std::vector<ReadPoint> reads, std::vector<StatusPoint> status,
         std::vector<WritePoint> writes, std::span<const std::uint32_t> claimed, runtime::GlobalTable& table);

  /// Substitutes into the table; ages count from here.
  void begin(TimeNs now_ns);
  /// When turn() has something to do.
  [[nodiscard]] TimeNs due() const;
  /// What is due, with one exchange at most.
  void turn(Link& link, const core::Clock& clock);
  /// Attempts to give every output its safe value, until the device is silent to all of them; whether all have it.
  bool write_safe(Link& link) const;

  /// Nobody answers. The bus thread, or where there is none.
  [[nodiscard]] bool lost() const { return lost_; }

  // RT: what the tasks tell.
  void scanned(std::uint32_t task) noexcept {
    if (task == task_) scanned_.store(true, std::memory_order_release);
  }
  void task_stopped(std::uint32_t task) noexcept;
  void hold_all() noexcept { held_.store(true, std::memory_order_relaxed); }

  // Any thread.
  [[nodiscard]] io::DriverStatus status() const;
  [[nodiscard]] std::vector<io::InputStatus> inputs(TimeNs now_ns) const;
  /// Sentences since the last call.
  std::vector<io::Sentence> take_said(TimeNs now_ns);
  [[nodiscard]] bool has_outputs() const { return !writes_.empty(); }
  [[nodiscard]] const DeviceSettings& settings() const { return settings_; }

 private:
  struct Part {  ///< a block and how it goes
    Block block;
    Error error = Error::kNeverRead;
    TimeNs due_ns = 0;
    TimeNs backoff_ns = 0;       ///< after an exception, or when this request alone has no good answer
    std::uint32_t failures = 0;  ///< in a row, of this request
    TimeNs read_at_ns = -1;      ///< reads; -1 = never
    Cells wanted, written;       ///< writes
    bool valid = false;          ///< writes: the device has `written`
    TimeNs rewrite_at_ns = 0;
  };

  void look(TimeNs now_ns);
  [[nodiscard]] Part* next_write(TimeNs now_ns);
  [[nodiscard]] Part* next_read(TimeNs now_ns);
  void exchange(Part& part, bool write, Link& link, const core::Clock& clock);
  void succeeded(Part& part, bool write, const Cells& cells, TimeNs now_ns);
  void refused(Part& part, bool write, Error error, TimeNs now_ns);
  void failed(Part& part, bool write, Error error, std::string_view reason, TimeNs now_ns);
  /// The values of this request alone are lost; it waits.
  void put_off(Part& part, bool write, Error error, TimeNs now_ns);
  void came_back(TimeNs now_ns);
  /// The time to the next attempt, after this one.
  [[nodiscard]] TimeNs longer(TimeNs backoff_ns) const;
  void substitute(const Part& part);
  bool split(const Part& part, TimeNs now_ns);
  void publish(TimeNs now_ns, bool changed);
  [[nodiscard]] Error error() const;
  [[nodiscard]] TimeNs age_ns(TimeNs now_ns) const;
  [[nodiscard]] std::byte const* value_of(const WritePoint& point, std::byte* buffer) const;
  [[nodiscard]] std::string cells_text(const Block& block) const;
  void say(TimeNs now_ns, std::string sentence, core::Severity severity = core::Severity::kWarning);

  DeviceSettings settings_;
  std::uint32_t task_;
  std::vector<ReadPoint> reads_;
  std::vector<StatusPoint> status_;
  std::vector<WritePoint> writes_;
  std::optional<runtime::GlobalInputs> to_table_;
  std::optional<runtime::GlobalReader> from_table_;

  std::atomic<bool> scanned_{false}, held_{false};
  std::atomic<std::uint64_t> stopped_tasks_{0};  ///< a bit each; the last one stands for all from 63 on

  // The bus thread's own.
  std::vector<std::byte> value_;  ///< room for any variable
  TimeNs look_at_ns_ = 0, status_at_ns_ = 0, retry_at_ns_ = 0, backoff_ns_ = 0;
  TimeNs began_ns_ = 0, answered_ns_ = -1;
  std::uint32_t failures_ = 0;
  bool write_next_ = true;  ///< reads and writes take turns

  mutable std::mutex mutex_;  ///< of all below, which the bus thread alone changes
  std::vector<Part> read_parts_, write_parts_;
  bool lost_ = false;
  Error lost_error_ = Error::kNone;
  TimeNs lost_since_ns_ = 0;
  std::uint64_t losses_ = 0, recoveries_ = 0, exchanges_ = 0;
  std::string problem_;
  std::vector<io::Sentence> said_;
  TimeNs said_since_ns_ = 0;
  std::uint32_t said_count_ = 0, unsaid_ = 0;
  Error published_ = Error::kNeverRead;
};

}  // namespace plc::modbus_client
