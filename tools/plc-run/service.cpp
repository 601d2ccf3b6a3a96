#include "tools/plc-run/service.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace plc::tools {
namespace {

/// Not sd_watchdog_enabled(): it asks for the main process, which is the guardian where there is one.
core::TimeNs watchdog_time() {
  const char* const text = std::getenv("WATCHDOG_USEC");
  if (text == nullptr) return 0;
  constexpr std::int64_t kLongestUs = std::int64_t{24} * 3600 * 1'000'000;
  const std::string_view digits = text;
  std::int64_t us = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), us);
  if (error != std::errc{} || end != digits.data() + digits.size() || us <= 0) return 0;
  return std::min(us, kLongestUs) * 1000;
}

constexpr core::TimeNs kAgainNs = 1'000'000'000;
/// How often the watchdog is fed within its time.
constexpr core::TimeNs kTimes = 4;

/// False when it was not heard within kPatience.
// WHY not sd_notify(): it waits for a service manager that does not listen, and outputs are to go to their safe state.
bool notify(const std::string& text) {
  constexpr timeval kPatience{0, 50'000};
  const char* const path = std::getenv("NOTIFY_SOCKET");
  if (path == nullptr) return true;
  sockaddr_un address{};
  const std::size_t length = std::strlen(path);
  if ((path[0] != '/' && path[0] != '@') || length >= sizeof address.sun_path) return ::sd_notify(0, text.c_str()) > 0;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path, length);
  if (path[0] == '@') address.sun_path[0] = '\0';
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (manager < 0) return false;
  ::setsockopt(manager, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  const ssize_t sent =
      ::sendto(manager, text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), size);
  const bool full = sent < 0 && (errno == EAGAIN || errno == EINTR);
  ::close(manager);
  return !full;  // one that is not there is not there a second later
}

/// What a socket of TCP is bound to.
io::ListenText bound_to(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  char text[INET6_ADDRSTRLEN] = {};
  if (address.ss_family == AF_INET6) {
    const auto& six = reinterpret_cast<const sockaddr_in6&>(address);
    ::inet_ntop(AF_INET6, &six.sin6_addr, text, sizeof text);
    return {text, ntohs(six.sin6_port)};
  }
  const auto& four = reinterpret_cast<const sockaddr_in&>(address);
  ::inet_ntop(AF_INET, &four.sin_addr, text, sizeof text);
  return {text, ntohs(four.sin_port)};
}

}  // namespace

PassedSockets take_passed_sockets() {
  PassedSockets passed;
  const int count = ::sd_listen_fds(/*unset_environment=*/1);
  passed.count = std::max(count, 0);
  for (int fd = SD_LISTEN_FDS_START; fd < SD_LISTEN_FDS_START + count; ++fd) {
    if (::sd_is_socket_inet(fd, AF_UNSPEC, SOCK_STREAM, /*listening=*/1, /*port=*/0) <= 0) {
      passed.unused.push_back(fmt::format("descriptor {} that systemd passed is no TCP socket that listens", fd));
    } else if (passed.modbus) {
      passed.unused.push_back(fmt::format("the socket {} that systemd passed is not served: one is, {}",
                                          io::listen_text(bound_to(fd)), io::listen_text(passed.modbus->at)));
    } else {
      passed.modbus = {fd, bound_to(fd)};
    }
  }
  return passed;
}

Service::Service(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, core::TimeNs now_ns)
    : scheduler_(scheduler), watchdog_ns_(watchdog_time()), next_ns_(now_ns) {
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    const core::TimeNs period_ns = image.tasks[task].period_ns;
    if (period_ns > 0) tasks_.push_back({task, std::max(watchdog_ns_, 2 * period_ns), 0, now_ns});
  }
}

void Service::ready(const std::string& status) {
  unheard_ = "READY=1\nSTATUS=" + status;
  if (notify(unheard_)) unheard_.clear();
}

void Service::stopping() { notify("STOPPING=1\nSTATUS=outputs go to their safe state"); }

void Service::alive() { notify("WATCHDOG=1"); }

std::chrono::milliseconds Service::alive_every() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::nanoseconds(watchdog_time() / kTimes));
}

void Service::service(core::TimeNs now_ns) {
  if (!unheard_.empty() && now_ns >= tell_ns_) {
    tell_ns_ = now_ns + kAgainNs;
    if (notify(unheard_)) unheard_.clear();
  }
  if (watchdog_ns_ == 0 || now_ns < next_ns_) return;
  next_ns_ = now_ns + watchdog_ns_ / kTimes;
  if (tasks_run(now_ns)) notify("WATCHDOG=1");
}

void Service::rests(core::TimeNs now_ns) {
  if (watchdog_ns_ == 0 || now_ns < next_ns_) return;
  next_ns_ = now_ns + watchdog_ns_ / kTimes;
  notify("STATUS=stopped by a call\nWATCHDOG=1");
}

bool Service::tasks_run(core::TimeNs now_ns) {
  bool all = true;
  for (Seen& seen : tasks_) {
    const runtime::TaskStatistics& statistics = scheduler_.statistics(seen.task);
    const std::uint64_t scans = statistics.scans.load(std::memory_order_relaxed);
    if (scans != seen.scans) {
      seen.scans = scans;
      seen.at_ns = now_ns;
    }
    const bool stopped = statistics.faults.load(std::memory_order_relaxed) != 0 &&
                         scheduler_.plan(seen.task).on_fault != runtime::FaultPolicy::kContinue;
    all = all && (stopped || now_ns - seen.at_ns <= seen.patience_ns);
  }
  return all;
}

}  // namespace plc::tools
