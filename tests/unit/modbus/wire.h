// What tests of the server on a socket share: waiting, descriptors, configurations, floods.
#pragma once

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "runtime/sched/realtime.h"
#include "runtime/sched/thread_settings.h"
#include "tests/support/modbus_oracle.h"
#include "tests/unit/modbus/plant.h"

namespace plc::test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

inline const Pdu kRead = pdu_of(3, {kWords, 1});

/// Waits until `done`, at most `limit`.
template <class Done>
bool eventually(Done done, std::chrono::milliseconds limit = 15'000ms) {
  const auto end = Clock::now() + limit;
  while (!done()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

inline std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

/// Lets this process have `count` descriptors; false when it may not.
inline bool allow_descriptors(rlim_t count) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= count) return true;
  limit.rlim_cur = count;
  limit.rlim_max = std::max(limit.rlim_max, count);
  return ::setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

inline io::ModbusConfig clients(std::uint32_t most) {
  io::ModbusConfig config;
  config.max_clients = most;
  return config;
}

inline io::ModbusConfig timeouts(core::TimeNs frame_ns, core::TimeNs idle_ns = 0) {
  io::ModbusConfig config;
  config.frame_timeout_ns = frame_ns;
  config.idle_timeout_ns = idle_ns;
  return config;
}

/// Sends on a connection of its own until told to stop; counts what comes back.
class Flood {
 public:
  Flood(const PlantServer& plant, const Pdu& pdu, unsigned pipelined)
      : thread_([this, &plant, pdu, pipelined] {
          Pdu burst;
          for (unsigned i = 0; i < pipelined; ++i) {
            const Pdu frame = frame_of(pdu, i);
            burst.insert(burst.end(), frame.begin(), frame.end());
          }
          while (!stop_) {
            ModbusClient client = plant.client();
            while (!stop_ && client.send(burst)) {
              unsigned answered = 0;
              while (answered < pipelined && client.receive(1000).kind == Answer::Kind::kFrame) ++answered;
              answers_ += answered;
              if (answered < pipelined) break;
            }
          }
        }) {}
  ~Flood() {
    stop_ = true;
    thread_.join();
  }
  [[nodiscard]] std::uint64_t answers() const { return answers_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> answers_{0};
  std::thread thread_;
};

}  // namespace plc::test
