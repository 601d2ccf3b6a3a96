// What the machine has to spare, and its devices: calls of the subject "machine".
#include <sys/statvfs.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/device_book.h"
#include "engineering/subjects.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kDriverFields[] = {
    text("name", "As in plc.toml"),
    choice("state", "good|lost|simulated", "Quality: whether the device answers"),
    text("problem", "Why it is lost; or empty"),
    integer("inputs", "Variables that it reads"),
    integer("inputs_good", "Inputs whose values are those of the device"),
    number("oldest_ms", "Age of the input that was read the longest time ago"),
    boolean("outputs", "It has outputs"),
    integer("losses", "Times that the device went away"),
    integer("recoveries", "Times that it came back"),
    integer("exchanges", "Reads and writes that succeeded"),
};
constexpr Record kDriver = {"Driver", "A device and what its values are worth.", kDriverFields};

constexpr Field kModbusFields[] = {
    text("line", "TCP or serial"),
    integer("clients", "Connected now"),
    integer("requests", "Since the start"),
    integer("exceptions", "Requests that were refused with an exception"),
    integer("refused", "Connections that were too many"),
    integer("dropped", "Connections that were closed for what they sent; frames that were none"),
};
constexpr Record kModbus = {"ModbusServer", "A server for HMIs.", kModbusFields};

constexpr Field kMachineAnswer[] = {
    records("drivers", kDriver, "In the order of plc.toml"),
    records("modbus", kModbus, "Servers that are on"),
    integer("memory", "Bytes that plc-run has in memory"),
    integer("memory_all", "Bytes that the machine has"),
    integer("memory_free", "Bytes that programs could still have"),
    text("folder", "Of what is kept; empty: nothing is"),
    integer("disk_all", "Bytes of the disk with this folder, or with the working directory"),
    integer("disk_free", "Bytes that are free"),
};

/// "VmRSS:  1234 kB" of a file of /proc, in bytes; 0 when it is not there.
std::int64_t kilobytes_of(const char* file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(name + ":", 0) == 0) return std::strtoll(line.c_str() + name.size() + 1, nullptr, 10) * 1024;
  }
  return 0;
}

void machine(Context& context, const Caller&, const Json&, Answer& answer) {
  const Devices devices = context.devices == nullptr ? Devices{} : context.devices->get();
  Json& body = answer.body();
  Json& drivers = body["drivers"] = Json::array();
  for (const DeviceState& one : devices.drivers) {
    drivers.push_back({{"name", one.name},
                       {"state", one.state},
                       {"problem", one.problem},
                       {"inputs", one.inputs},
                       {"inputs_good", one.inputs_good},
                       {"oldest_ms", static_cast<double>(one.oldest_ns) / 1e6},
                       {"outputs", one.outputs},
                       {"losses", one.losses},
                       {"recoveries", one.recoveries},
                       {"exchanges", one.exchanges}});
  }
  Json& modbus = body["modbus"] = Json::array();
  for (const ModbusState& one : devices.modbus) {
    modbus.push_back({{"line", one.line},
                      {"clients", one.clients},
                      {"requests", one.requests},
                      {"exceptions", one.exceptions},
                      {"refused", one.refused},
                      {"dropped", one.dropped}});
  }
  body["memory"] = kilobytes_of("/proc/self/status", "VmRSS");
  body["memory_all"] = kilobytes_of("/proc/meminfo", "MemTotal");
  body["memory_free"] = kilobytes_of("/proc/meminfo", "MemAvailable");
  body["folder"] = context.folder;
  struct statvfs disk {};
  const bool known = ::statvfs(context.folder.empty() ? "." : context.folder.c_str(), &disk) == 0;
  body["disk_all"] = known ? disk.f_blocks * disk.f_frsize : 0;
  body["disk_free"] = known ? disk.f_bavail * disk.f_frsize : 0;
}

constexpr Call kCalls[] = {
    {.name = "machine",
     .path = "/api/machine",
     .doc = "Devices and what their values are worth, servers for HMIs, memory, disk.",
     .response = kMachineAnswer,
     .example = "{}",
     .run = machine,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> machine_calls() { return kCalls; }

}  // namespace plc::engineering
