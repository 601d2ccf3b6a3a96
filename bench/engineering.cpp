// The engineering server: what clients get, what that costs, and what a task of 1 ms notices of it.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bench/engineering_server.h"
#include "bench/measurements.h"
#include "bench/scratch.h"

namespace plc::bench {
namespace {

using Clock = std::chrono::steady_clock;
using test::HttpClient;

constexpr double kFramesPerSecond = 60;
constexpr int kCalls = 5000;
/// One scan of ten is a pulse.
constexpr int kPulseScans = 10;
constexpr int kWrongPerSecond = 1000;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// A task of 1 ms. Of its variables the first `changing` change in every scan.
std::string project_text(unsigned variables, unsigned changing) {
  return fmt::format(
      "VAR_GLOBAL Values : ARRAY [1..{0}] OF DINT; Pulse : BOOL; END_VAR\n"
      "PROGRAM Main\nVAR n, i : DINT; END_VAR\nVAR_EXTERNAL Values : ARRAY [1..{0}] OF DINT; Pulse : BOOL; END_VAR\n"
      "n := n + 1;\nPulse := n MOD {2} = 0;\nFOR i := 1 TO {1} DO Values[i] := Values[i] + i; END_FOR;\nEND_PROGRAM\n"
      "CONFIGURATION C\nRESOURCE R ON Plc\n  TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n  PROGRAM main WITH T : Main;\n"
      "END_RESOURCE\nEND_CONFIGURATION\n",
      variables, changing, kPulseScans);
}

/// Clients that have subscribed to all values and read what comes.
class Viewers {
 public:
  Viewers(const EngineeringServer& server, unsigned clients) {
    for (unsigned i = 0; i < clients; ++i) {
      HttpClient& client = clients_.emplace_back(server.connect());
      const auto answer = client.ask(server.upgrade(fmt::format("/api/values/stream?period_ms={}", 1000 / 60)));
      if (answer.status != 101) throw std::runtime_error(fmt::format("a stream is answered {}", answer.status));
      client.send_frame(1, R"({"subscribe": ["Values"]})");
      if (client.receive_frame().opcode != 1) throw std::runtime_error("a subscription is not answered");
    }
    frames_.resize(clients);
    bytes_.resize(clients);
  }

  void read_for(double seconds) {
    const auto begin = Clock::now();
    std::vector<pollfd> waits;
    for (const HttpClient& client : clients_) waits.push_back({client.descriptor(), POLLIN, 0});
    double left = seconds;
    while (left > 0) {
      ::poll(waits.data(), waits.size(), static_cast<int>(left * 1000) + 1);
      for (std::size_t i = 0; i < waits.size(); ++i) {
        if (waits[i].revents == 0) continue;
        const test::WebFrame frame = clients_[i].receive_frame();
        if (frame.opcode == 9) continue;
        if (frame.opcode != 2) throw std::runtime_error("a stream has ended");
        ++frames_[i];
        bytes_[i] += frame.bytes.size();
      }
      left = seconds - seconds_since(begin);
    }
    seconds_ += seconds_since(begin);
  }
  /// Of the client that got the fewest.
  [[nodiscard]] double frames_per_second() const {
    return static_cast<double>(*std::min_element(frames_.begin(), frames_.end())) / seconds_;
  }
  [[nodiscard]] double megabytes_per_second() const {
    double all = 0;
    for (const std::uint64_t bytes : bytes_) all += static_cast<double>(bytes);
    return all / 1e6 / seconds_;
  }

 private:
  std::vector<HttpClient> clients_;
  std::vector<std::uint64_t> frames_, bytes_;
  double seconds_ = 0;
};

struct Row {
  double server = 0, frames = 0, megabytes = 0;
  EngineeringServer::TaskTimes times;
};

Row watch(const std::string& project, const EngineeringPlan& plan) {
  const EngineeringServer server(project);
  Viewers viewers(server, plan.clients);
  viewers.read_for(1);  // whole frames first
  const double before = server.server_seconds();
  const auto begin = Clock::now();
  viewers.read_for(plan.seconds);
  Row row;
  row.server = (server.server_seconds() - before) / seconds_since(begin);
  row.frames = viewers.frames_per_second();
  row.megabytes = viewers.megabytes_per_second();
  row.times = server.task_times();
  return row;
}

struct Idle {
  double p50_ms = 0, p99_ms = 0;
  std::uint64_t pulses = 0, expected = 0;
  EngineeringServer::TaskTimes times;
};

/// Nobody looks but one: first at the times of `seconds`, then with calls, then at a recorded trace.
Idle look(const std::string& project, const EngineeringPlan& plan) {
  const EngineeringServer server(project);
  std::this_thread::sleep_for(std::chrono::duration<double>(plan.seconds + 1));
  Idle idle;
  idle.times = server.task_times();
  HttpClient client = server.connect();
  const std::string request = server.request("GET", "/api/tasks");
  std::vector<double> times;
  for (int i = 0; i < kCalls; ++i) {
    const auto begin = Clock::now();
    if (client.ask(request).status != 200) throw std::runtime_error("a call is refused");
    times.push_back(seconds_since(begin) * 1000);
    // 2000 of one address a second are taken.
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  std::sort(times.begin(), times.end());
  idle.p50_ms = times[times.size() / 2];
  idle.p99_ms = times[times.size() * 99 / 100];
  std::istringstream lines(server.ask(
      "POST", "/api/trace", fmt::format(R"({{"paths": ["Pulse"], "seconds": {:.0f}}})", std::min(plan.seconds, 10.0))));
  std::string line;
  std::getline(lines, line);
  std::uint64_t scans = 0;
  for (bool before = true; std::getline(lines, line); ++scans) {
    const bool now = !line.ends_with(",0") && !line.ends_with("FALSE");
    idle.pulses += now && !before ? 1 : 0;
    before = now;
  }
  idle.expected = scans / kPulseScans;
  return idle;
}

struct Guessing {
  double per_second = 0, login_s = 0;
  EngineeringServer::TaskTimes times;
};

/// Wrong passwords from many connections, and a right one in between.
Guessing guess(const std::string& project, const EngineeringPlan& plan) {
  const EngineeringServer server(project);
  constexpr unsigned kThreads = 8;
  const std::string body = nlohmann::json{{"user", "somebody"}, {"password", "a wrong password"}}.dump();
  const std::string request = server.request("POST", "/api/login", body);
  std::atomic<std::uint64_t> tried{0};
  std::atomic<bool> ends{false};
  std::vector<std::thread> threads;
  const auto begin = Clock::now();
  for (unsigned t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      auto client = std::make_unique<HttpClient>(server.connect());
      auto next = begin;
      while (!ends) {
        const int status = client->ask(request).status;
        if (status == 0) client = std::make_unique<HttpClient>(server.connect());
        ++tried;
        next += std::chrono::microseconds(1'000'000 * kThreads / kWrongPerSecond);
        std::this_thread::sleep_until(next);
      }
    });
  }
  Guessing guessing;
  std::this_thread::sleep_for(std::chrono::duration<double>(plan.seconds / 2));
  const std::string right =
      nlohmann::json{{"user", EngineeringServer::kUser}, {"password", EngineeringServer::kPassword}}.dump();
  const auto asked = Clock::now();
  HttpClient client = server.connect();
  int status = 0;
  // As a person does who is told to wait.
  while (seconds_since(asked) < 30 && (status = client.ask(server.request("POST", "/api/login", right)).status) != 200)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  guessing.login_s = status == 200 ? seconds_since(asked) : 1e9;
  std::this_thread::sleep_for(std::chrono::duration<double>(plan.seconds / 2));
  guessing.per_second = static_cast<double>(tried) / seconds_since(begin);
  ends = true;
  for (std::thread& thread : threads) thread.join();
  guessing.times = server.task_times();
  return guessing;
}

}  // namespace

Verdict measure_engineering(const EngineeringPlan& plan) {
  Verdict verdict;
  const Scratch scratch;
  const std::string few = scratch.file("few.st"), all = scratch.file("all.st");
  std::ofstream(few) << project_text(plan.variables, plan.variables / 10);
  std::ofstream(all) << project_text(plan.variables, plan.variables);
  std::cout << fmt::format(
      "Engineering server beside a task of 1 ms: {} clients that see {} variables at {} Hz, wrong passwords, calls; {} "
      "times "
      "{:.0f} s of each, in turns\n",
      plan.clients, plan.variables, kFramesPerSecond, plan.rounds, plan.seconds);
  std::vector<double> p50, p99, server_few, server_all, frames, megabytes, login;
  std::vector<double> alone, watched, guessed, scan_alone, scan_watched;
  double guesses = 1e9;
  std::uint64_t pulses = 0, expected = 0;
  for (unsigned round = 0; round < plan.rounds; ++round) {
    const Idle idle = look(few, plan);
    p50.push_back(idle.p50_ms);
    p99.push_back(idle.p99_ms);
    pulses += idle.pulses;
    expected += idle.expected;
    alone.push_back(idle.times.latency_us);
    scan_alone.push_back(idle.times.scan_us);
    const Row some = watch(few, plan);
    watched.push_back(some.times.latency_us);
    scan_watched.push_back(some.times.scan_us);
    server_few.push_back(some.server * 100);
    frames.push_back(some.frames);
    const Row whole = watch(all, plan);
    server_all.push_back(whole.server * 100);
    frames.push_back(whole.frames);
    megabytes.push_back(whole.megabytes);
    const Guessing guessing = guess(few, plan);
    guessed.push_back(guessing.times.latency_us);
    login.push_back(guessing.login_s);
    guesses = std::min(guesses, guessing.per_second);
  }
  const auto row = [&](const std::string& what, const std::string& value, const std::string& verdict_text) {
    std::cout << fmt::format("  {:<66} {:>14}  {}\n", what, value, verdict_text);
  };
  row("one-scan pulses in a recorded trace", fmt::format("{} of {}", pulses, expected),
      pulses + plan.rounds >= expected ? "all" : "MISSED");
  // A trace begins and ends anywhere in a pulse.
  if (pulses + plan.rounds < expected) verdict.correct = false;
  row("call on loopback, p50", fmt::format("{:.2f} ms", median(p50)), "");
  row("call on loopback, p99", fmt::format("{:.2f} ms", median(p99)), limit_text(median(p99), limit::kCall, verdict));
  const double fewest = *std::min_element(frames.begin(), frames.end());
  row("frames of the client that got the fewest", fmt::format("{:.1f} Hz", fewest),
      limit_text(kFramesPerSecond / fewest, limit::kFrames, verdict));
  row("server, a tenth of the variables changes in each scan", fmt::format("{:.1f} %", median(server_few)),
      limit_text(median(server_few), limit::kServer, verdict));
  row(fmt::format("server, all of them change: {:.0f} MB/s", median(megabytes)),
      fmt::format("{:.1f} %", median(server_all)), "");
  row("wrong passwords", fmt::format("{:.0f} a second", guesses), "");
  const double slowest = *std::max_element(login.begin(), login.end());
  row("a right login meanwhile, the slowest", fmt::format("{:.2f} s", slowest),
      limit_text(slowest, limit::kLogin, verdict));
  row("wake-up p99.9: alone", fmt::format("{:.1f} us", median(alone)), "");
  const double beside = median(watched) / median(alone), under = median(guessed) / median(alone);
  row("..with these clients", fmt::format("{:.1f} us", median(watched)),
      limit_text(beside, limit::kWakeUpWatched, verdict));
  row("..under wrong passwords", fmt::format("{:.1f} us", median(guessed)),
      limit_text(under, limit::kWakeUpWatched, verdict));
  row("scan p99.9: alone", fmt::format("{:.1f} us", median(scan_alone)), "");
  row("..with these clients", fmt::format("{:.1f} us", median(scan_watched)),
      fmt::format("{:.2f} times", median(scan_watched) / median(scan_alone)));
  return verdict;
}

}  // namespace plc::bench
