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
#include <vector>

#include "io-drivers/modbus-client/device.h"

namespace plc::modbus_client {

class Bus {
 public:
  explicit Bus(const BusAddress& address) : address_(address) {}
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
  /// written where start() was not called: the device was not touched.
  void leave(Device& device) noexcept;
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
  pthread_t thread_ = {};
  bool running_ = false;  ///< thread_ is to be joined
};

}  // namespace plc::modbus_client
