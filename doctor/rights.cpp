// Rights and limits of the process.
#include <fmt/format.h>

#include "doctor/check.h"
#include "runtime/sched/priority.h"

namespace plc::doctor {
namespace {

bool is_number(const std::string& value) { return to_number(value).has_value(); }
bool is_zero(const std::string& value) { return value == "0"; }

}  // namespace

Outcome check_locked_memory(const Context& c) {
  if (c.process.has(Capability::kIpcLock)) return fine("any (CAP_IPC_LOCK)");
  const auto limit = c.process.limit("Max locked memory");
  if (!limit) return unknown("the limits of the process are not known");
  if (*limit == kUnlimited) return fine("any");
  return wrong(fmt::format("at most {} KiB of memory may be locked: scans wait for the disk when memory is short",
                           *limit / 1024),
               "LimitMEMLOCK=infinity in the service, or `memlock unlimited` in /etc/security/limits.d");
}

Outcome check_priorities(const Context& c) {
  if (c.process.has(Capability::kSysNice)) return fine("any (CAP_SYS_NICE)");
  const auto limit = c.process.limit("Max realtime priority");
  if (!limit) return unknown("the limits of the process are not known");
  const std::uint64_t needed = runtime::kWatchdogPriority;
  if (*limit >= needed) return fine(fmt::format("up to {}", *limit));
  return wrong(
      fmt::format("real-time priorities are allowed up to {}, {} is needed: tasks are as urgent as any program", *limit,
                  needed),
      "LimitRTPRIO=99 in the service, or `rtprio 99` in /etc/security/limits.d, or CAP_SYS_NICE for a container");
}

Outcome check_realtime_budget(const Context& c) {
  if (!c.process.control("cpu", "cpu.rt_runtime_us", is_zero)) return fine("no limit of the control group");
  return wrong("the control group has cpu.rt_runtime_us = 0: no thread in it may have a real-time priority",
               "give the group a budget (docker: --cpu-rt-runtime), or use control groups of version 2");
}

Outcome check_open_files(const Context& c) {
  const auto limit = c.process.limit("Max open files");
  if (!limit) return unknown("the limits of the process are not known");
  constexpr std::uint64_t kOthers = 64;  // devices, logs, timers
  const io::ModbusConfig& modbus = c.subject.configuration.modbus;
  const std::uint64_t needed = kOthers + (modbus.enabled ? modbus.max_clients : 0);
  if (*limit >= needed) return fine(*limit == kUnlimited ? "any number" : fmt::format("{}", *limit));
  return wrong(fmt::format("{} files may be open, {} are needed{}", *limit, needed,
                           modbus.enabled ? fmt::format(": {} for Modbus clients", modbus.max_clients) : ""),
               fmt::format("LimitNOFILE={} in the service, or a smaller max_clients under [modbus]", needed));
}

Outcome check_threads(const Context& c) {
  constexpr std::uint64_t kOthers = 16;
  const std::size_t tasks = c.subject.resource == nullptr ? 4 : c.subject.resource->image().tasks.size();
  const std::uint64_t needed = kOthers + tasks;
  std::uint64_t allowed = c.process.limit("Max processes").value_or(kUnlimited);
  std::string by = "its limit of processes";
  const auto group = c.process.control("pids", "pids.max", is_number);
  if (group && *to_number(*group) < allowed) allowed = *to_number(*group), by = "its control group";
  if (allowed >= needed) return fine(allowed == kUnlimited ? "any number" : fmt::format("{}", allowed));
  return wrong(fmt::format("{} allows {} threads, up to {} are needed for tasks, drivers, Modbus and the guardian", by,
                           allowed, needed),
               fmt::format("TasksMax={0} or more in the service, --pids-limit={0} for a container", needed));
}

}  // namespace plc::doctor
