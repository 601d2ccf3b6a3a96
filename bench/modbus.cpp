// The Modbus server under load: against libmodbus, and what the scan notices of it.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "bench/libmodbus_server.h"
#include "bench/measurements.h"
#include "bench/modbus_load.h"
#include "bench/scratch.h"
#include "compiler/compile.h"
#include "io-drivers/modbus/server.h"
#include "runtime/sched/realtime.h"

namespace plc::bench {
namespace {

// The program moves values that belong together: DINTs from %MD0 on and LREALs from %ML0 on, all equal but for those
// with an odd number, which are the DINT's complement.
constexpr unsigned kDints = 63;
constexpr unsigned kLreals = 32;
constexpr std::uint16_t kFirstDint = 2048;
constexpr std::uint16_t kFirstLreal = 4096;
constexpr RegisterRead kReads[] = {{kFirstDint, 125}, {kFirstLreal, 125}};

std::string project_text() {
  std::string externals, globals, body;
  unsigned id = 0;
  const auto declare = [&](const std::string& name, const char* type, const std::string& address) {
    externals += fmt::format("<variable name=\"{}\"><type><{}/></type></variable>\n", name, type);
    globals += fmt::format("<variable name=\"{}\" address=\"{}\"><type><{}/></type></variable>\n", name, address, type);
  };
  const auto assign = [&](const std::string& name, const std::string& expression) {
    body += fmt::format(
        "<inVariable localId=\"{0}\"><position x=\"10\" y=\"{0}\"/><connectionPointOut/><expression>{1}</expression>"
        "</inVariable>\n<outVariable localId=\"{2}\" executionOrderId=\"{2}\"><position x=\"90\" y=\"{0}\"/>"
        "<connectionPointIn><connection refLocalId=\"{0}\"/></connectionPointIn><expression>{3}</expression>"
        "</outVariable>\n",
        id + 1, expression, id + 2, name);
    id += 2;
  };
  for (unsigned i = 0; i < kDints; ++i) {
    const std::string name = fmt::format("D{}", i);
    declare(name, "DINT", fmt::format("%MD{}", i));
    assign(name, i == 0 ? "D0 + 65537" : i % 2 == 0 ? "D0" : "-1 - D0");
  }
  for (unsigned i = 0; i < kLreals; ++i) {
    const std::string name = fmt::format("L{}", i);
    declare(name, "LREAL", fmt::format("%ML{}", i));
    assign(name, i == 0 ? "L0 * 1.0000001 + 0.7" : "L0");
  }
  return fmt::format(
      R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="PICARD" productName="bench" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="Load"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd><ld><scaling x="1" y="1"/></ld>
<sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="Mover" pouType="program"><interface><externalVars>
{}</externalVars></interface><body><FBD>
{}</FBD></body></pou></pous></types>
<instances><configurations><configuration name="c"><resource name="r">
<task name="Fast" interval="T#1ms" priority="0"><pouInstance name="main" typeName="Mover"/></task>
<globalVars>
{}</globalVars></resource></configuration></configurations></instances>
</project>
)",
      externals, body, globals);
}

/// Both patterns repeat after 8 bytes: a DINT and its complement, or an LREAL.
bool moved_together(const RegisterRead& read, std::span<const std::uint8_t> bytes) {
  if (std::memcmp(bytes.data(), bytes.data() + 8, bytes.size() - 8) != 0) return false;
  if (read.first != kFirstDint) return true;
  std::uint32_t value = 0, complement = 0;
  std::memcpy(&value, bytes.data(), sizeof value);
  std::memcpy(&complement, bytes.data() + sizeof value, sizeof complement);
  return value == ~complement;
}

/// Resident memory of this process in kB.
std::uint64_t resident_kb() {
  std::ifstream in("/proc/self/statm");
  std::uint64_t total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / 1024;
}

/// Processor time in us that a thread has had; `task` is its folder in /proc.
double busy_us(const std::filesystem::path& task) {
  std::ifstream in(task / "schedstat");
  double ns = 0;
  in >> ns;
  return ns / 1e3;
}

/// The folder in /proc of the server's thread.
std::filesystem::path server_thread() {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream in(task.path() / "comm");
    std::string name;
    in >> name;
    if (name == "plc-modbus") return task.path();
  }
  return {};
}

/// The project, running, with its server.
class Plant {
 public:
  explicit Plant(const Scratch& scratch) {
    const std::string path = scratch.file("load.xml");
    std::ofstream(path, std::ios::binary) << project_text();
    compiler::Compilation compilation;
    compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
    if (!compilation.ok()) {
      compilation.diagnostics.render(std::cerr);
      throw std::runtime_error("the project does not compile");
    }
    auto loaded = runtime::Resource::load(std::move(*compilation.image));
    if (!loaded) throw std::runtime_error(loaded.error().message);
    resource_ = std::move(*loaded);
    config_.port = 0;
    config_.max_clients = 256;
    core::Diagnostics diagnostics;
    modbus::FrozenAddresses frozen;
    auto map = modbus::AddressMap::build(*resource_, config_, frozen, diagnostics);
    if (!map) throw std::runtime_error("no address map");
    map_ = std::move(*map);
    responder_.emplace(*resource_, map_, config_);
    server_ = std::make_unique<modbus::Server>(*responder_, config_);
    scheduler_ = std::make_unique<runtime::RealtimeScheduler>(*resource_, runtime::RealtimeOptions{});
    const auto problem = server_->start();
    if (problem) throw std::runtime_error(problem->message);
    for (const std::string& refused : scheduler_->start().refused) std::cout << "  real time: " << refused << '\n';
  }
  ~Plant() {
    scheduler_->request_stop();
    scheduler_->join();
    server_->stop();
  }
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  [[nodiscard]] std::uint16_t port() const { return server_->port(); }
  /// Forgets what was measured, runs `work`, and returns what the task needed meanwhile.
  template <class Work>
  std::string scan_during(const Work& work) {
    auto& statistics = const_cast<runtime::TaskStatistics&>(scheduler_->statistics(0));
    statistics.clear();
    work();
    p999_us_ = static_cast<double>(statistics.scan_time.percentile_ns(0.999)) / 1e3;
    return fmt::format("scan p50 {:.1f} us, p99.9 {:.1f} us, release latency p99.9 {:.0f} us, {} scans, {} missed",
                       static_cast<double>(statistics.scan_time.percentile_ns(0.5)) / 1e3, p999_us_,
                       static_cast<double>(statistics.latency.percentile_ns(0.999)) / 1e3, statistics.scans.load(),
                       statistics.missed.load());
  }
  [[nodiscard]] double p999_us() const { return p999_us_; }

 private:
  io::ModbusConfig config_;
  std::unique_ptr<runtime::Resource> resource_;
  modbus::AddressMap map_;
  std::optional<modbus::Responder> responder_;
  std::unique_ptr<modbus::Server> server_;
  std::unique_ptr<runtime::RealtimeScheduler> scheduler_;
  double p999_us_ = 0;
};

/// Runs the torture tool, which is not part of this project, for `seconds`. Its exit code.
int torture(const std::string& tool, std::uint16_t port, double seconds) {
  const int status = std::system(
      fmt::format("python3 {} --port {} --seconds {:.0f} --no-write >/dev/null", tool, port, seconds).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Load on one server, and what that server's thread had to do for it.
LoadResult measure(const char* name, std::uint16_t port, const std::filesystem::path& thread, const ModbusPlan& plan,
                   double seconds, const RegisterCheck& check) {
  const double before_us = busy_us(thread);
  LoadResult result = modbus_load(port, plan.connections, seconds, kReads, check);
  const double each_us =
      (busy_us(thread) - before_us) / static_cast<double>(std::max<std::uint64_t>(result.answers, 1));
  std::cout << fmt::format(
      "  {:<17} {:>7.0f} requests/s, {:.1f} us of processor each, {} answers, {} errors, {} torn\n", name,
      result.rate(), each_us, result.answers, result.errors, result.mismatches);
  if (!result.problem.empty()) std::cout << "    " << result.problem << '\n';
  return result;
}

}  // namespace

Verdict measure_modbus(const ModbusPlan& plan) {
  Verdict verdict;
  std::cout << fmt::format(
      "Modbus: {} connections poll 125 registers as fast as they can, a task of 1 ms writes them\n", plan.connections);
  const LibmodbusServer libmodbus;  // a child: before there are threads
  const Scratch scratch;
  Plant plant(scratch);
  const RegisterCheck any = [](const RegisterRead&, std::span<const std::uint8_t>) { return true; };
  const RegisterCheck together = moved_together;
  const double side = std::max(1.0, plan.seconds / 6);

  const auto judge = [&](const LoadResult& result) {
    verdict.correct = verdict.correct && result.errors == 0 && result.mismatches == 0 && result.answers != 0;
  };
  const auto compared = [&](double& best) {
    if (libmodbus.port() == 0) return;
    const std::filesystem::path process = fmt::format("/proc/{}", libmodbus.process());
    best = std::max(best, measure("libmodbus, select", libmodbus.port(), process, plan, side, any).rate());
  };

  std::string scan = plant.scan_during([&] { std::this_thread::sleep_for(std::chrono::duration<double>(side)); });
  const double quiet_us = plant.p999_us();
  std::cout << "  without clients: " << scan << '\n';
  double theirs = 0;
  compared(theirs);
  judge(modbus_load(plant.port(), plan.connections, side / 4, kReads, together));  // buffers reach their size
  const std::uint64_t before_kb = resident_kb();
  LoadResult ours;
  scan =
      plant.scan_during([&] { ours = measure("PICARD", plant.port(), server_thread(), plan, plan.seconds, together); });
  const double loaded_us = plant.p999_us();
  const std::uint64_t after_kb = resident_kb();
  judge(ours);
  compared(theirs);
  std::cout << "  during that: " << scan << '\n';
  std::cout << fmt::format("  scan p99.9, loaded / without: {:.2f}  {}\n", loaded_us / quiet_us,
                           limit_text(loaded_us / quiet_us, limit::kScanBesideClients, verdict));
  if (libmodbus.port() == 0) {
    std::cout << "  no comparison: libmodbus was not there when this was built\n";
  } else {
    std::cout << fmt::format("  libmodbus / PICARD: {:.2f}  {}\n", theirs / ours.rate(),
                             limit_text(theirs / ours.rate(), limit::kRequests, verdict));
  }
  const double growth_kb = static_cast<double>(after_kb) - static_cast<double>(before_kb);
  std::cout << fmt::format("  resident memory: {} kB before, {} kB after  {}\n", before_kb, after_kb,
                           limit_text(growth_kb, limit::kGrowth, verdict));
  if (!std::filesystem::exists(plan.torture)) {
    std::cout << "  no hostile clients: there is no " << plan.torture << '\n';
    return verdict;
  }
  int code = 0;
  scan = plant.scan_during([&] { code = torture(plan.torture, plant.port(), std::max(10.0, side)); });
  std::cout << "  during hostile clients: " << scan << '\n';
  std::cout << fmt::format("  scan p99.9, hostile / without: {:.2f}  {}\n", plant.p999_us() / quiet_us,
                           limit_text(plant.p999_us() / quiet_us, limit::kScanBesideClients, verdict));
  if (code != 0) {
    std::cout << "  hostile clients broke something, exit code " << code << '\n';
    verdict.correct = false;
  }
  return verdict;
}

}  // namespace plc::bench
