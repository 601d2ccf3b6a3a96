// A machine as a folder, for the doctor: as good as can be, until a test spoils it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "doctor/examine.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/machine/driver_types.h"
#include "tests/support/run_tool.h"

namespace plc::test {

/// A kind of driver whose device is what the test says.
inline constexpr io::KeyInfo kProbeKeys[] = {
    {"device", io::key::text(), io::key::required("\"/dev/ttyUSB0\""), "Node."}};
inline std::optional<core::Problem> probe_problem;
inline constexpr io::DriverType kProbeType = {
    .name = "probe",
    .summary = "a device of tests.",
    .example = "probe",
    .driver_keys = kProbeKeys,
    .device_key = "device",
    .check_device = [](const io::DriverConfig&, std::span<const io::ChannelConfig* const>,
                       std::span<const io::ChannelConfig* const>) { return probe_problem; },
};

class Machine {
 public:
  Machine() {
    write("proc/self/status",
          "Name:\tplc\nUid:\t4000\t4000\t4000\t4000\nGid:\t4000\t4000\t4000\t4000\nGroups:\t4000 4001\n"
          "CapEff:\t0000000000000000\nCpus_allowed_list:\t0-3\n");
    limits("1024", "unlimited", "95", "unlimited");
    write("proc/self/cgroup", "0::/system.slice/plc.service\n");
    write("proc/self/mounts", "/dev/sda1 / ext4 rw,relatime 0 0\n");
    write("proc/version", "Linux version 6.1.0-37-rt-amd64 (gcc-12) #1 SMP PREEMPT_RT Debian 6.1.140-1\n");
    write("proc/sys/kernel/osrelease", "6.1.0-37-rt-amd64\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("proc/meminfo", "MemTotal:  2000000 kB\nMemAvailable:    1500000 kB\n");
    write("proc/swaps", "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n");
    write("proc/locks", "");
    write("proc/irq/30/effective_affinity_list", "0\n");
    write("proc/irq/30/eth0/empty", "");
    write("proc/net/tcp", kTcpHeader);
    write("proc/net/fib_trie",
          "Local:\n  +-- 0.0.0.0/0 3 0 5\n     |-- 127.0.0.1\n        /32 host LOCAL\n"
          "     |-- 192.168.1.9\n        /32 host LOCAL\n     |-- 192.168.1.255\n        /32 link BROADCAST\n");
    write("sys/kernel/realtime", "1\n");
    write("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("sys/class/rtc/rtc0/name", "rtc_cmos\n");
    write("sys/devices/system/cpu/online", "0-3\n");
    write("sys/devices/system/cpu/isolated", "2-3\n");
    for (const char cpu : {'0', '1', '2', '3'}) {
      const std::string folder = std::string("sys/devices/system/cpu/cpu") + cpu;
      write(folder + "/cpufreq/scaling_governor", "performance\n");
      write(folder + "/topology/thread_siblings_list", std::string(1, cpu) + "\n");
    }
    write("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "2\n");
    write("etc/group", "root:x:0:\ndialout:x:20:\n");
    write("dev/ttyUSB0", "");
    mode("dev/ttyUSB0", 0666);
    std::filesystem::create_directories(path("var/lib/picard/plant"));
    mode("var/lib/picard/plant", 0777);
    subject.state = "/var/lib/picard/plant";
    configure("[modbus]\nlisten = \"127.0.0.1:1502\"\n[drivers.bus]\nkind = \"probe\"\ndevice = \"/dev/ttyUSB0\"\n");
    probe_problem.reset();
  }

  static constexpr const char* kTcpHeader =
      "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n";

  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.file(name); }
  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path(name);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
  }
  void remove(const std::string& name) const { std::filesystem::remove_all(path(name)); }
  void mode(const std::string& name, unsigned mode) const {
    std::filesystem::permissions(path(name), static_cast<std::filesystem::perms>(mode));
  }
  void limits(const std::string& files, const std::string& memory, const std::string& priority,
              const std::string& processes) const {
    write("proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units\n"
          "Max processes             " +
              processes + "   unlimited   processes\n" + "Max open files            " + files + "   1048576   files\n" +
              "Max locked memory         " + memory + "   unlimited   bytes\n" + "Max realtime priority     " +
              priority + "   99\n");
  }
  /// Replaces what plc.toml says.
  void configure(const std::string& text) {
    static const std::vector<const io::DriverType*> types = [] {
      std::vector<const io::DriverType*> known(io::driver_types().begin(), io::driver_types().end());
      known.push_back(&kProbeType);
      return known;
    }();
    subject.diagnostics = {};
    subject.configuration = {};
    auto read = io::read_configuration(text, "plc.toml", types, subject.diagnostics);
    subject.configuration_is_known = read.has_value();
    if (read) subject.configuration = std::move(*read);
  }
  /// Compiles it.
  void project(const std::string& text) {
    write("plant.st", text);
    compiler::Compilation compilation;
    subject.project_file = path("plant.st");
    compiler::compile({subject.project_file, {}, compiler::Goal::kRun}, compilation);
    ASSERT_TRUE(compilation.image) << text;
    auto loaded = runtime::Resource::load(std::move(*compilation.image), {});
    ASSERT_TRUE(loaded);
    resource_ = std::move(*loaded);
    subject.resource = resource_.get();
  }

  std::vector<doctor::Line> examine(const std::string& process = "self") const {
    const doctor::Calls calls{
        .clocks = [this] { return clocks; }, .space = [this](const std::string&) { return space; }, .devices = true};
    return doctor::examine(doctor::System(path(""), calls), process, subject);
  }
  /// "P7920 warning" for each line that is neither ok nor unknown.
  std::vector<std::string> found() const {
    std::vector<std::string> all;
    for (const doctor::Line& line : examine()) {
      if (line.state <= doctor::State::kUnknown) continue;
      all.push_back(std::string(core::info(line.code).name) + " " + std::string(doctor::state_word(line.state)));
      EXPECT_FALSE(line.seen.empty()) << all.back();
      EXPECT_FALSE(line.help.empty()) << all.back();
    }
    return all;
  }

  doctor::Clocks clocks{.synchronised = true, .time_of_day_s = 1'800'000'000, .resolution_ns = 1};
  std::optional<doctor::Space> space = doctor::Space{.free_bytes = 1u << 30, .free_files = 100'000, .read_only = false};
  doctor::Subject subject;

 private:
  ScratchFolder scratch_;
  std::unique_ptr<runtime::Resource> resource_;
};

}  // namespace plc::test
