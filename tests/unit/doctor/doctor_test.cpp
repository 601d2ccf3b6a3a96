// Each fault that the doctor knows is planted in a machine that is good otherwise, and is all that it finds.
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cstddef>
#include <functional>
#include <set>

#include "engineering/certificate.h"
#include "retain/store.h"
#include "tests/unit/doctor/machine.h"

namespace plc::test {
namespace {

using doctor::Line;
using doctor::State;

const char* const kRetaining = R"(
VAR_GLOBAL Setpoint : INT; END_VAR
PROGRAM Main
VAR RETAIN Parts : DINT; END_VAR
  Parts := Parts + Setpoint;
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
)";

/// A file of retained values of this project.
void store(const Machine& m, const std::string& project) {
  retain::Layout layout;
  layout.project = project;
  bytecode::ImageType type;
  type.elementary = core::TypeId::kByte;
  type.size = 1;
  layout.types = {type};
  layout.roots = {{"main.a", 0, 0, false, false}};
  layout.bytes = 1;
  retain::Store store(m.path("var/lib/picard/plant"), layout);
  const std::byte value[1] = {};
  ASSERT_EQ(store.write(value, 0, 1'800'000'000'000'000'000), "");
  m.mode("var/lib/picard/plant/retain", 0666);
}

struct Plant {
  const char* name;
  const char* expected;  ///< all that is found
  std::function<void(Machine&)> spoil;
};
void PrintTo(const Plant& plant, std::ostream* out) { *out << plant.name; }

const std::string kCpu = "sys/devices/system/cpu/";

void listens_at_8061(Machine& m) {
  m.write("proc/net/tcp",
          std::string(Machine::kTcpHeader) +
              "   0: 0100007F:1F7D 00000000:0000 0A 00000000:00000000 00:00000000 00000000 0 0 77 1 0\n");
}

constexpr const char* kOwnCertificate =
    "[modbus]\nlisten = \"off\"\n[engineering]\nlisten = \"127.0.0.1:8061\"\n"
    "certificate = \"/etc/picard/certificate.pem\"\nkey = \"/etc/picard/key.pem\"\n";
/// Certificates of plc-run are valid for 3,650 days.
void certificate_of_age(Machine& m, std::int64_t days) {
  constexpr std::int64_t kDay = 86'400;
  const core::TimeNs then = (m.clocks.time_of_day_s - days * kDay) * 1'000'000'000;
  ASSERT_TRUE(engineering::own_certificate(m.path("etc/picard"), {"plant"}, then));
  m.configure(kOwnCertificate);
}

const std::vector<Plant>& plants() {
  static const std::vector<Plant> kPlants = {
      {"NoProc", "P7946 warning", [](Machine& m) { m.remove("proc/self"); }},
      {"NoSys", "P7946 warning", [](Machine& m) { m.remove("sys"); }},
      {"OldKernel", "P7929 warning", [](Machine& m) { m.write("proc/sys/kernel/osrelease", "4.19.0-27-amd64\n"); }},
      {"OrdinaryKernel", "P7920 warning",
       [](Machine& m) {
         m.remove("sys/kernel/realtime");
         m.write("proc/version", "Linux version 6.1.0-37-amd64 #1 SMP PREEMPT_DYNAMIC Debian\n");
       }},
      {"RealTimeShare", "P7921 warning",
       [](Machine& m) { m.write("proc/sys/kernel/sched_rt_runtime_us", "500000\n"); }},
      {"NoRealTimeShare", "P7921 warning", [](Machine& m) { m.write("proc/sys/kernel/sched_rt_runtime_us", "0\n"); }},
      {"Governor", "P7922 warning", [](Machine& m) { m.write(kCpu + "cpu2/cpufreq/scaling_governor", "powersave\n"); }},
      {"NotIsolated", "P7923 note", [](Machine& m) { m.write(kCpu + "isolated", "\n"); }},
      {"HyperThreads", "P7924 note", [](Machine& m) { m.write(kCpu + "cpu1/topology/thread_siblings_list", "1,3\n"); }},
      {"HugePages", "P7925 note",
       [](Machine& m) { m.write("sys/kernel/mm/transparent_hugepage/enabled", "[always] madvise never\n"); }},
      {"Swap", "P7926 note",
       [](Machine& m) { m.write("proc/swaps", "Filename Type\n/dev/sda5 partition 975868 0 -2\n"); }},
      {"Interrupts", "P7927 warning", [](Machine& m) { m.write("proc/irq/30/effective_affinity_list", "0-2\n"); }},
      {"InterruptsOfOldKernels", "P7927 warning",
       [](Machine& m) {
         m.remove("proc/irq/30/effective_affinity_list");
         m.write("proc/irq/30/smp_affinity_list", "3\n");
       }},
      {"IdleStates", "P7928 note", [](Machine& m) { m.write(kCpu + "cpu0/cpuidle/state1/latency", "890\n"); }},
      {"ClockSource", "P7930 warning",
       [](Machine& m) { m.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"); }},
      {"NotSynchronised", "P7931 warning", [](Machine& m) { m.clocks.synchronised = false; }},
      {"Year1970", "P7932 warning", [](Machine& m) { m.clocks.time_of_day_s = 600; }},
      {"NoBattery", "P7933 note", [](Machine& m) { m.remove("sys/class/rtc/rtc0"); }},
      {"CoarseTimers", "P7934 warning", [](Machine& m) { m.clocks.resolution_ns = 4'000'000; }},
      {"NoPriorities", "P7940 warning", [](Machine& m) { m.limits("1024", "unlimited", "0", "unlimited"); }},
      {"PriorityBelowTheWatchdog", "P7940 warning",
       [](Machine& m) { m.limits("1024", "unlimited", "80", "unlimited"); }},
      {"NoLockedMemory", "P7941 warning", [](Machine& m) { m.limits("1024", "8388608", "95", "unlimited"); }},
      {"NoBudget", "P7942 warning",
       [](Machine& m) {
         m.write("proc/self/cgroup", "4:cpu,cpuacct:/docker/1\n");
         m.write("sys/fs/cgroup/cpu,cpuacct/docker/1/cpu.rt_runtime_us", "0\n");
       }},
      {"OpenFiles", "P7943 warning", [](Machine& m) { m.limits("100", "unlimited", "95", "unlimited"); }},
      {"ManyClients", "P7943 warning",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"127.0.0.1:1502\"\nmax_clients = 1000\n"); }},
      {"Quota", "P7944 warning",
       [](Machine& m) { m.write("sys/fs/cgroup/system.slice/plc.service/cpu.max", "50000 100000\n"); }},
      {"QuotaOfTheGroupAround", "P7944 warning",
       [](Machine& m) { m.write("sys/fs/cgroup/cpu.max", "50000 100000\n"); }},
      {"QuotaOfVersion1", "P7944 warning",
       [](Machine& m) {
         m.write("proc/self/cgroup", "4:cpu,cpuacct:/docker/1\n");
         m.write("sys/fs/cgroup/cpu,cpuacct/docker/1/cpu.cfs_quota_us", "50000\n");
       }},
      {"Threads", "P7945 warning",
       [](Machine& m) { m.write("sys/fs/cgroup/system.slice/plc.service/pids.max", "4\n"); }},
      {"Processes", "P7945 warning", [](Machine& m) { m.limits("1024", "unlimited", "95", "10"); }},
      {"OneProcessor", "P7950 note",
       [](Machine& m) {
         m.write(kCpu + "online", "0\n");
         m.write(kCpu + "isolated", "\n");
       }},
      {"ProcessorOfPlcToml", "P7602 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"off\"\n[scheduler]\ncpu = 7\n"); }},
      {"Memory", "P7951 warning", [](Machine& m) { m.write("proc/meminfo", "MemAvailable: 64000 kB\n"); }},
      {"MemoryOfTheGroup", "P7951 warning",
       [](Machine& m) { m.write("sys/fs/cgroup/system.slice/memory.max", "67108864\n"); }},
      {"NoDevice", "P7955 problem", [](Machine& m) { m.remove("dev/ttyUSB0"); }},
      {"NoLineOfTheServer", "P7955 problem",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"127.0.0.1:1502\"\n[modbus.serial]\npath = \"/dev/ttyUSB7\"\n");
       }},
      {"DeviceOfOthers", "P7956 problem", [](Machine& m) { m.mode("dev/ttyUSB0", 0660); }},
      {"DriverIsRefused", "P7404 problem",
       [](Machine&) {
         probe_problem = core::Problem{core::Code::P7404, "line 17 is in use", "give another one"};
       }},
      {"OtherDevices", "P7957 note",
       [](Machine& m) {
         m.write("dev/gpiochip0", "");
         m.mode("dev/gpiochip0", 0600);
       }},
      {"PortIsTaken", "P7960 problem",
       [](Machine& m) {
         m.write("proc/net/tcp",
                 std::string(Machine::kTcpHeader) +
                     "   0: 0100007F:05DE 00000000:0000 0A 00000000:00000000 00:00000000 00000000 0 0 77 1 0\n");
         m.write("proc/812/comm", "mbusd\n");
         std::filesystem::create_directories(m.path("proc/812/fd"));
         std::filesystem::create_symlink("socket:[77]", m.path("proc/812/fd/3"));
       }},
      {"PortIsTakenOnAllAddresses", "P7960 problem",
       [](Machine& m) {
         m.write("proc/net/tcp6",
                 std::string(Machine::kTcpHeader) +
                     "   0: 00000000000000000000000000000000:05DE 00000000000000000000000000000000:0000 0A "
                     "00000000:00000000 00:00000000 00000000 0 0 77 1 0\n");
       }},
      {"PortNeedsARight", "P7961 problem", [](Machine& m) { m.configure("[modbus]\nlisten = \"127.0.0.1:502\"\n"); }},
      {"PortByDefaultNeedsARight", "P7961 warning", [](Machine& m) { m.configure(""); }},
      {"AddressIsNotHere", "P7962 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"192.168.1.10:1502\"\nread_only = true\n"); }},
      {"EngineeringPortIsTaken", "P7960 problem",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"off\"\n[engineering]\nlisten = \"127.0.0.1:8061\"\n");
         listens_at_8061(m);
       }},
      {"EngineeringPortByDefaultIsTaken", "P7960 warning",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"off\"\n");
         listens_at_8061(m);
       }},
      {"OnePortForBothServers", "P7960 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"127.0.0.1:8061\"\n"); }},
      {"EngineeringPortNeedsARight", "P7961 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"off\"\n[engineering]\nlisten = \"127.0.0.1:443\"\n"); }},
      {"EngineeringAddressIsNotHere", "P7962 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"off\"\n[engineering]\nlisten = \"192.168.1.10:8061\"\n"); }},
      {"NoCertificate", "P7703 problem",
       [](Machine& m) {
         m.configure(kOwnCertificate);
         m.remove("etc/picard/key.pem");
       }},
      {"CertificateWithoutKey", "P7306 problem",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"off\"\n[engineering]\ncertificate = \"/etc/picard/certificate.pem\"\n");
       }},
      {"CertificateEnds", "P7703 warning", [](Machine& m) { certificate_of_age(m, 3640); }},
      {"CertificateHasEnded", "P7703 problem", [](Machine& m) { certificate_of_age(m, 3651); }},
      {"Network", "P7963 note", [](Machine& m) { m.configure("[modbus]\nlisten = \"192.168.1.9:1502\"\n"); }},
      {"DiskNearlyFull", "P7965 warning", [](Machine& m) { m.space->free_bytes = 20u << 20; }},
      {"DiskFull", "P7965 problem", [](Machine& m) { m.space->free_bytes = 4096; }},
      {"NoMoreFiles", "P7965 warning", [](Machine& m) { m.space->free_files = 3; }},
      {"StateOfOthers", "P7966 problem", [](Machine& m) { m.mode("var/lib/picard/plant", 0755); }},
      {"StateIsReadOnly", "P7966 problem",
       [](Machine& m) { m.write("proc/self/mounts", "/dev/sda1 / ext4 ro 0 0\n"); }},
      {"StateIsAFile", "P7966 problem",
       [](Machine& m) {
         m.remove("var/lib/picard/plant");
         m.write("var/lib/picard/plant", "");
       }},
      {"OtherProject", "P7967 warning",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"off\"\n");
         m.project(kRetaining);
         store(m, "mixer");
       }},
      {"StateInUse", "P7968 note",
       [](Machine& m) {
         struct stat found {};
         ASSERT_EQ(::stat(m.path("var/lib/picard/plant").c_str(), &found), 0);
         char line[120];
         std::snprintf(line, sizeof line, "1: FLOCK  ADVISORY  WRITE 812 %02x:%02x:%llu 0 EOF\n", major(found.st_dev),
                       minor(found.st_dev), static_cast<unsigned long long>(found.st_ino));
         m.write("proc/locks", line);
       }},
      {"StateInMemory", "P7969 warning",
       [](Machine& m) {
         m.write("proc/self/mounts", "/dev/sda1 / ext4 rw 0 0\ntmpfs /var/lib/picard tmpfs rw 0 0\n");
       }},
      {"RetainDamaged", "P7611 problem",
       [](Machine& m) {
         m.write("var/lib/picard/plant/retain", "half a file");
         m.mode("var/lib/picard/plant/retain", 0666);
       }},
      {"RetainWithoutFolder", "P7610 warning",
       [](Machine& m) {
         m.configure("[modbus]\nlisten = \"off\"\n");
         m.project(kRetaining);
         m.subject.state.clear();
       }},
      {"NotFrozen", "P7970 warning", [](Machine& m) { m.project(kRetaining); }},
      {"LockFileDamaged", "P7501 problem",
       [](Machine& m) {
         m.project(kRetaining);
         m.write("plant.modbus.csv", "what is this?\n");
       }},
      {"OthersMayWrite", "P7971 warning",
       [](Machine& m) {
         m.write("plc.toml", "");
         m.mode("plc.toml", 0666);
         m.subject.configuration_file = m.path("plc.toml");
       }},
      {"WrongPlcToml", "P7303 problem", [](Machine& m) { m.configure("[modbus]\nlisten = \"off\"\nport = 5\n"); }},
      {"NoTaskblockLibrary", "P7801 problem",
       [](Machine& m) { m.configure("[modbus]\nlisten = \"off\"\n[taskblocks]\nlibraries = [\"/opt/pid.so\"]\n"); }},
  };
  return kPlants;
}

TEST(Doctor, FindsNothingOnAGoodMachine) {
  const Machine machine;
  EXPECT_EQ(machine.found(), std::vector<std::string>{});
  for (const Line& line : machine.examine()) {
    if (line.what == "frozen addresses" || line.what == "project") continue;  // no project is given
    EXPECT_EQ(line.state, State::kOk) << line.area << ": " << line.what << ": " << line.seen;
  }
}

class Planted : public ::testing::TestWithParam<Plant> {};

TEST_P(Planted, IsAllThatIsFound) {
  Machine machine;
  GetParam().spoil(machine);
  EXPECT_EQ(machine.found(), std::vector<std::string>{GetParam().expected});
}

INSTANTIATE_TEST_SUITE_P(Faults, Planted, ::testing::ValuesIn(plants()),
                         [](const auto& param) { return param.param.name; });

TEST(Doctor, EachOfItsCodesIsPlanted) {
  std::set<std::string> planted;
  for (const Plant& plant : plants()) planted.insert(std::string(plant.expected).substr(0, 5));
  std::size_t own = 0;
  for (const core::CodeInfo& code : core::all_codes()) {
    if (code.name < "P7920" || code.name > "P7979") continue;
    ++own;
    EXPECT_EQ(planted.count(std::string(code.name)), 1u) << code.name;
  }
  EXPECT_GE(own, 30u);
}

/// The line of something that is looked at.
Line line_of(const std::vector<Line>& lines, std::string_view area, std::string_view what) {
  for (const Line& line : lines) {
    if (line.area == area && line.what == what) return line;
  }
  ADD_FAILURE() << "nothing looks at " << area << ": " << what;
  return {};
}

TEST(Doctor, SaysWhoHasThePortAndWhichGroupGivesADevice) {
  Machine machine;
  for (const Plant& plant : plants()) {
    if (plant.name == std::string("PortIsTaken")) plant.spoil(machine);
  }
  EXPECT_NE(line_of(machine.examine(), "modbus", "port").seen.find("mbusd, process 812"), std::string::npos);
  machine.write("proc/812/comm", "plc-run\n");
  EXPECT_EQ(line_of(machine.examine(), "modbus", "port").state, State::kOk);
  // The group of planted files is that of this process.
  machine.write("etc/group", "dialout:x:" + std::to_string(::getegid()) + ":\n");
  machine.mode("dev/ttyUSB0", 0660);
  const Line rights = line_of(machine.examine(), "devices", "rights");
  if (::getegid() != 0) {
    EXPECT_NE(rights.help.find("usermod -aG dialout"), std::string::npos) << rights.help;
  } else {
    EXPECT_NE(rights.help.find("udev"), std::string::npos) << rights.help;
  }
}

TEST(Doctor, TakesCapabilitiesForLimits) {
  Machine machine;
  machine.limits("1024", "65536", "0", "unlimited");
  machine.configure(
      "[modbus]\nlisten = \"127.0.0.1:502\"\n[drivers.bus]\nkind = \"probe\"\ndevice = \"/dev/ttyUSB0\"\n");
  machine.mode("dev/ttyUSB0", 0600);
  EXPECT_EQ(machine.found(),
            (std::vector<std::string>{"P7941 warning", "P7940 warning", "P7956 problem", "P7961 problem"}));
  machine.write("proc/self/status", "Uid:\t4000\t4000\nCapEff:\t0000000000804402\nCpus_allowed_list:\t0-3\n");
  EXPECT_EQ(machine.found(), std::vector<std::string>{});
}

TEST(Doctor, TakesAPortThatSystemdOpened) {
  Machine machine;
  machine.configure("[modbus]\nlisten = \"127.0.0.1:502\"\nread_only = true\n");
  EXPECT_EQ(machine.found(), std::vector<std::string>{"P7961 problem"});
  machine.write("proc/net/tcp",
                std::string(Machine::kTcpHeader) +
                    "   0: 0100007F:01F6 00000000:0000 0A 00000000:00000000 00:00000000 00000000 0 0 77 1 0\n");
  machine.write("proc/1/comm", "systemd\n");
  std::filesystem::create_directories(machine.path("proc/1/fd"));
  std::filesystem::create_symlink("socket:[77]", machine.path("proc/1/fd/40"));
  EXPECT_EQ(machine.found(), std::vector<std::string>{});
}

TEST(System, FollowsLinksInsideOfItsRoot) {
  const ScratchFolder scratch;
  namespace fs = std::filesystem;
  const fs::path root = scratch.file("root"), outside = scratch.file("outside");
  for (const fs::path& folder : {root / "etc/picard", root / "data", outside}) fs::create_directories(folder);
  std::ofstream(outside / "name") << "outside";
  std::ofstream(root / "data/name") << "inside";
  const auto link = [&root](const fs::path& to, const char* from) { fs::create_symlink(to, root / from); };
  link("/data", "etc/picard/absolute");
  link("../../data", "etc/picard/relative");
  link("/data/name", "etc/file");
  link(outside, "etc/out");
  link("../../../../../../" + outside.string(), "etc/up");
  link("/etc/circle", "etc/circle");
  const doctor::System system(root.string());
  for (const char* path : {"/data/name", "/etc/picard/absolute/name", "/etc/picard/relative/name", "/etc/file",
                           "/etc/./picard/absolute/../data//name", "/../../data/name"}) {
    EXPECT_EQ(system.read(path), "inside") << path;
    EXPECT_TRUE(system.facts(path)) << path;
  }
  EXPECT_EQ(system.list("/etc/picard/absolute"), std::vector<std::string>{"name"});
  for (const char* path : {"/etc/out/name", "/etc/up/name", "/etc/circle", "/etc/circle/name"}) {
    EXPECT_FALSE(system.read(path)) << path;
    EXPECT_FALSE(system.facts(path)) << path;
  }
  EXPECT_TRUE(system.list("/etc/out").empty());
  EXPECT_EQ(system.link("/etc/file"), "/data/name") << "the link itself";
  EXPECT_EQ(system.read((outside / "name").string()), std::nullopt);
}

TEST(Doctor, LooksAtAnotherProcess) {
  const Machine machine;
  machine.write("proc/812/status", "Uid:\t4000\t4000\nCapEff:\t0\nCpus_allowed_list:\t1\n");
  machine.write("proc/812/limits", "Max realtime priority     0    0\n");
  EXPECT_EQ(line_of(machine.examine("812"), "rights", "priorities").state, State::kWarning);
  EXPECT_EQ(line_of(machine.examine("813"), "kernel", "/proc and /sys").state, State::kWarning);
}

TEST(Doctor, TakesTheStateFolderThatPlcRunTakes) {
  Machine machine;
  machine.subject.state.clear();
  EXPECT_EQ(line_of(machine.examine(), "retain", "state folder").seen, "no state folder");
  machine.write("proc/self/environ", std::string("HOME=/\0STATE_DIRECTORY=/var/lib/picard/plant:/other\0", 52));
  EXPECT_EQ(line_of(machine.examine(), "retain", "state folder").seen, "/var/lib/picard/plant");
  machine.configure("[retain]\nstate = \"/var/lib\"\n");
  EXPECT_EQ(line_of(machine.examine(), "retain", "asked for").seen, "/var/lib");
  machine.subject.state = "/var";
  EXPECT_EQ(line_of(machine.examine(), "retain", "asked for").seen, "/var");
}

TEST(Doctor, SaysWhatIsUnknownOfAnEmptyFolder) {
  const ScratchFolder scratch;
  const doctor::Subject subject;
  std::size_t unknown = 0;
  for (const Line& line : doctor::examine(doctor::System(scratch.file("")), "self", subject)) {
    EXPECT_TRUE(line.state <= State::kUnknown || line.code == core::Code::P7946) << line.area << ": " << line.what;
    if (line.state == State::kUnknown) ++unknown;
  }
  EXPECT_GT(unknown, 15u);
}

TEST(Doctor, DoesNotTouchFoldersOnNetworks) {
  Machine machine;
  machine.write("proc/self/mounts", "/dev/sda1 / ext4 rw 0 0\nserver:/x /var/lib/picard nfs4 rw 0 0\n");
  for (const char* const what : {"state folder", "disk", "in use", "stored values"}) {
    EXPECT_EQ(line_of(machine.examine(), "retain", what).state, State::kUnknown) << what;
  }
}

TEST(Doctor, ChangesNothing) {
  Machine machine;
  machine.remove("var/lib/picard/plant");
  machine.mode("var/lib/picard", 0777);
  EXPECT_EQ(machine.found(), std::vector<std::string>{});
  EXPECT_FALSE(std::filesystem::exists(machine.path("var/lib/picard/plant")));
}

TEST(Doctor, BearsWhateverFilesHold) {
  const Machine machine;
  for (const char* const text :
       {"", "\n", "-1", "0-999999999", "4294967296", "[::", ": : : : : : : : : : : :", "a:b:c"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(machine.path(""))) {
      if (entry.is_regular_file()) std::ofstream(entry.path(), std::ios::binary) << text;
    }
    EXPECT_FALSE(machine.examine().empty());
  }
}

}  // namespace
}  // namespace plc::test
