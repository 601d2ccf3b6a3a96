// Bus: the thread that asks the devices of one connection or one serial line, one after the other.
//
// In: devices, a link. Out: their turns, the earliest that is due first. Drivers with the same address share a bus.
// Life: of() -> add() -> start() -> leave(), all on one thread, for each device. Does not belong here: what a device
// asks.
#pragma once

#include <pthread.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "io-drivers/modbus-client/device.h"

namespace plc::modbus_client {

class Bus {
 public:
  explicit Bus(BusAddress address) : address_(std::move(address)) {}
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// The bus at this address of the drivers of one resource; made when there is none.
  static std::shared_ptr<Bus> of(const void* resource, const BusAddress& address);

  /// Before start(). The device must leave before it ends.
  void add(Device& device);
  /// Makes the thread, once.
  void start();
  /// Waits until the safe values of the device were written, or could not be; the last one ends the thread. Nothing is
  /// written where start() was not called: the device was not touched. Once all devices leave, silent ones are waited
  /// for no longer than three seconds in all; those that answer may take longer.
  void leave(Device& device) noexcept;
  /// In a copy of the process that has no thread: writes the safe values of the device. False: not all of them. A
  /// silent one is waited for until its part of eight seconds, or a second, is over.
  bool write_safe(const Device& device);
  [[nodiscard]] const BusAddress& address() const { return address_; }
  /// The process has the thread: false in a copy that fork() made before start().
  [[nodiscard]] bool runs() const { return running_; }

 private:
  struct Member {
    Device* device;
    bool leaves = false;
  };
  void run();
  /// Locked before and after.
  void serve(Link& link, std::unique_lock<std::mutex>& lock);

  BusAddress address_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Member> members_;
  std::unique_ptr<Link> link_;  ///< from start(), or the first write_safe(), on
  pthread_t thread_ = {};
  bool running_ = false;  ///< thread_ is to be joined
  bool ends_ = false;     ///< all devices leave, and none is asked for anything but its safe values
};

}  // namespace plc::modbus_client
