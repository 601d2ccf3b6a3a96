// SerialServer: Modbus RTU on one serial line, as one unit among others, on a thread of its own.
//
// In: Responder, [modbus.serial]. Out: answers to requests for its unit, effects of those for all units, sentences for
// the operator. A line that is not there yet, or is pulled out, is tried again every second. Threads: start(), stop()
// and take_said() belong to one owner thread; counters any thread. Does not belong here: where frames begin and end
// (modbus-rtu/request_stream.h).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "io-drivers/driver.h"
#include "io-drivers/modbus/responder.h"

namespace plc::modbus {

struct SerialStatistics {
  std::uint64_t requests = 0;    ///< for its unit, or for all
  std::uint64_t exceptions = 0;  ///< requests answered with one
  std::uint64_t others = 0;      ///< frames of other units
  std::uint64_t damaged = 0;     ///< times that something was dropped that was no frame
};

class SerialServer {
 public:
  /// Both must outlive it. `config` was found good.
  SerialServer(Responder& responder, const io::ModbusSerialConfig& config);
  ~SerialServer();
  SerialServer(const SerialServer&) = delete;
  SerialServer& operator=(const SerialServer&) = delete;

  /// Makes the thread, which opens the line. Once.
  void start();
  /// Gives the line back and joins.
  void stop();
  /// What changed since the last call: the line is served, cannot be had (P7510), is gone.
  std::vector<io::Sentence> take_said();
  [[nodiscard]] SerialStatistics statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plc::modbus
