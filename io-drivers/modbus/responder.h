// Responder: what all servers of a project share: one process image, one handler of PDUs, the coils that are latched,
// whether a client is there.
//
// In: PDUs of requests from any server. Out: PDUs of answers. Threads: any; a lock orders the servers, and no task
// takes it. Does not belong here: sockets (server.h), lines (serial_server.h), unit ids.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>

#include "core/clock.h"
#include "io-drivers/modbus/pdu.h"
#include "runtime/memory/global_ports.h"
#include "runtime/resource.h"

namespace plc::modbus {

/// A BOOL that the servers set while clients are answered ([modbus] client_seen); claimed before the map is built, so
/// that clients cannot write it.
struct SeenFlag {
  runtime::GlobalInputs* owner = nullptr;
  std::uint32_t offset = 0;  ///< in the global table
  std::uint32_t type = 0;
};

class Responder {
 public:
  /// Set-up only (it registers as a reader of the table). Map, resource and the owner of `seen` must outlive it.
  Responder(runtime::Resource& resource, const AddressMap& map, const io::ModbusConfig& config,
            const std::optional<SeenFlag>& seen = std::nullopt);
  Responder(const Responder&) = delete;
  Responder& operator=(const Responder&) = delete;

  /// What the system's registers tell (system_points.h). Before the first request.
  void set_system(SystemSource source) { data_.set_system(std::move(source)); }
  /// How many scans tasks have made, for coils that are latched. Before the first request.
  void set_scans(ScanSource source) { data_.set_scans(std::move(source)); }

  /// As PduHandler::handle(). An answer that is no exception counts for client_seen unless `unanswered`.
  std::size_t answer(std::span<const std::uint8_t> request, std::span<std::uint8_t, kMaxPdu> response,
                     bool unanswered = false);
  /// Whether coils wait to be reset. As long as they do, release_coils() is to be called every kCoilPause.
  [[nodiscard]] bool coils_wait() const { return coils_wait_.load(std::memory_order_relaxed); }
  void release_coils();
  static constexpr core::TimeNs kCoilPause = 1'000'000;

  /// Looks whether clients are still there; about every 100 ms, by any server. On core::MonotonicClock.
  void sweep(core::TimeNs now_ns);
  /// A server has stopped: its clients are gone.
  void stopped();

 private:
  void publish_seen(bool seen);

  std::mutex mutex_;
  ProcessData data_;
  PduHandler handler_;
  std::atomic<bool> coils_wait_{false};
  std::optional<SeenFlag> seen_flag_;
  core::TimeNs seen_timeout_ns_;
  core::TimeNs seen_at_ns_ = 0;
  bool seen_ = false;
};

}  // namespace plc::modbus
