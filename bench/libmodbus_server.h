// LibmodbusServer: a plain server of libmodbus in a process of its own, to be compared with.
//
// In: nothing; it must be made while this process has one thread. Out: a port of 127.0.0.1 with 8192 registers, until
// the object goes. Does not belong here: clients.
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace plc::bench {

class LibmodbusServer {
 public:
  LibmodbusServer();
  ~LibmodbusServer();
  LibmodbusServer(const LibmodbusServer&) = delete;
  LibmodbusServer& operator=(const LibmodbusServer&) = delete;

  /// 0 when there is none: libmodbus was not there when this was built, or the server did not start.
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  pid_t process_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace plc::bench
