#include "bench/libmodbus_server.h"

#ifdef PLC_HAVE_LIBMODBUS
#include <modbus.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#endif

namespace plc::bench {

#ifdef PLC_HAVE_LIBMODBUS
namespace {

constexpr int kRegisters = 8192;

/// As the examples of libmodbus do it: one thread, select(), receive and reply.
[[noreturn]] void serve(int tell) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  modbus_t* const context = modbus_new_tcp("127.0.0.1", 0);
  modbus_mapping_t* const mapping = modbus_mapping_new(kRegisters, kRegisters, kRegisters, kRegisters);
  const int listener = modbus_tcp_listen(context, 128);
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (mapping == nullptr || listener < 0 ||
      ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    ::_exit(1);
  }
  const std::uint16_t port = ntohs(address.sin_port);
  if (::write(tell, &port, sizeof port) != sizeof port) ::_exit(1);
  fd_set all;
  FD_ZERO(&all);
  FD_SET(listener, &all);
  int most = listener;
  for (;;) {
    fd_set ready = all;
    if (::select(most + 1, &ready, nullptr, nullptr, nullptr) < 0) ::_exit(1);
    for (int fd = 0; fd <= most; ++fd) {
      if (!FD_ISSET(fd, &ready)) continue;
      if (fd == listener) {
        const int client = ::accept(listener, nullptr, nullptr);
        if (client < 0) continue;
        FD_SET(client, &all);
        most = std::max(most, client);
        continue;
      }
      std::uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
      modbus_set_socket(context, fd);
      const int bytes = modbus_receive(context, query);
      if (bytes > 0) {
        modbus_reply(context, query, bytes, mapping);
      } else if (bytes < 0) {
        ::close(fd);
        FD_CLR(fd, &all);
      }
    }
  }
}

}  // namespace

LibmodbusServer::LibmodbusServer() {
  int ends[2];
  if (::pipe(ends) != 0) return;
  process_ = ::fork();
  if (process_ == 0) serve(ends[1]);
  ::close(ends[1]);
  if (::read(ends[0], &port_, sizeof port_) != sizeof port_) port_ = 0;
  ::close(ends[0]);
}

LibmodbusServer::~LibmodbusServer() {
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

#else
LibmodbusServer::LibmodbusServer() = default;
LibmodbusServer::~LibmodbusServer() = default;
#endif

}  // namespace plc::bench
