// EngineeringServer: a plc-run with its engineering server, as clients find it; for measurements and their load.
//
// In: a project. Out: a process, its port, a token of its admin, times of its threads and of its first task. Does not
// belong here: what is measured.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

#include "bench/scratch.h"
#include "tests/unit/engineering/http_client.h"

namespace plc::bench {

class EngineeringServer {
 public:
  /// Throws std::runtime_error when it does not come up.
  explicit EngineeringServer(const std::string& project);
  /// Ends it.
  ~EngineeringServer();
  EngineeringServer(const EngineeringServer&) = delete;
  EngineeringServer& operator=(const EngineeringServer&) = delete;

  [[nodiscard]] test::HttpClient connect() const { return test::HttpClient(port_); }
  /// A request of the admin.
  [[nodiscard]] std::string request(const std::string& method, const std::string& target,
                                    const std::string& body = {}) const;
  /// A request to open a WebSocket.
  [[nodiscard]] std::string upgrade(const std::string& target) const;
  /// What it answers; throws when that is no 200.
  [[nodiscard]] std::string ask(const std::string& method, const std::string& target,
                                const std::string& body = {}) const;
  /// Processor time of the thread that serves connections, in seconds.
  [[nodiscard]] double server_seconds() const;
  /// How late the first task woke and how long its scans took since the start, p99.9 in us.
  struct TaskTimes {
    double latency_us = 0, scan_us = 0;
  };
  [[nodiscard]] TaskTimes task_times() const;

  static constexpr const char* kUser = "bench";
  static constexpr const char* kPassword = "a password for the bench";

 private:
  Scratch scratch_;
  pid_t process_ = -1;
  std::uint16_t port_ = 0;
  std::string token_;
};

}  // namespace plc::bench
