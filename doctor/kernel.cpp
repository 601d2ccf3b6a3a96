// Kernel and clocks.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include "doctor/check.h"

namespace plc::doctor {

Outcome check_pseudo_files(const Context& c) {
  std::vector<std::string> absent;
  if (!c.process.known()) absent.emplace_back("/proc");
  if (c.system.list("/sys/devices/system").empty()) absent.emplace_back("/sys");
  if (absent.empty()) return fine("both there");
  return wrong(joined(absent) + (absent.size() == 1 ? " is" : " are") + " not there: much cannot be looked at",
               "mount it: `mount -t proc proc /proc`, `mount -t sysfs sysfs /sys`, or let the container have it");
}

Outcome check_kernel_version(const Context& c) {
  const char* const file = "/proc/sys/kernel/osrelease";
  const auto release = c.system.line(file);
  if (!release) return missing(file);
  const std::size_t dot = release->find('.');
  const auto major = to_number(release->substr(0, dot));
  const std::string rest = dot == std::string::npos ? "" : release->substr(dot + 1);
  const auto minor = to_number(rest.substr(0, rest.find_first_not_of("0123456789")));
  if (!major || !minor) return unknown("Linux \"" + *release + "\"");
  if (*major > 5 || (*major == 5 && *minor >= 10)) return fine("Linux " + *release);
  return wrong("Linux " + *release + " is older than 5.10: GPIO lines need its character devices",
               "install a newer kernel, such as that of Debian 12");
}

Outcome check_preemption(const Context& c) {
  const auto flag = c.system.line("/sys/kernel/realtime");
  const auto version = c.system.line("/proc/version");
  if (!flag && !version) return missing("/proc/version");
  const bool named =
      version && (version->find("PREEMPT_RT") != std::string::npos || version->find("PREEMPT RT") != std::string::npos);
  if (flag == "1" || named) return fine("PREEMPT_RT");
  return wrong(
      "the kernel has no PREEMPT_RT: tasks may begin milliseconds late while others use the machine",
      "Debian: `apt install linux-image-rt-amd64` (arm64: linux-image-rt-arm64) and restart; without it, check "
      "with plc-run how late scans begin");
}

Outcome check_realtime_share(const Context& c) {
  const char* const file = "/proc/sys/kernel/sched_rt_runtime_us";
  const auto runtime = c.system.number(file);
  const auto period = c.system.number("/proc/sys/kernel/sched_rt_period_us").value_or(1'000'000);
  if (!runtime) return missing(file);
  if (*runtime < 0) return fine("all of the time");
  const std::int64_t percent = period <= 0 ? 0 : *runtime * 100 / period;
  if (percent >= 95) return fine(fmt::format("{} % of the time", percent));
  return wrong(
      fmt::format("tasks with real-time priority get {} % of the time: {} of {} us", percent, *runtime, period),
      "`sysctl kernel.sched_rt_runtime_us=950000` is the default of Linux; a file in /etc/sysctl.d keeps it");
}

Outcome check_huge_pages(const Context& c) {
  const char* const file = "/sys/kernel/mm/transparent_hugepage/enabled";
  const auto text = c.system.line(file);
  if (!text) return fine("the kernel has none");
  if (text->find("[always]") == std::string::npos) return fine(*text);
  return wrong(
      "transparent huge pages are always made: the kernel moves memory while tasks run",
      "`echo madvise > /sys/kernel/mm/transparent_hugepage/enabled`, or transparent_hugepage=madvise on the command "
      "line of the kernel");
}

Outcome check_clock_source(const Context& c) {
  const std::string folder = "/sys/devices/system/clocksource/clocksource0/";
  const auto source = c.system.line(folder + "current_clocksource");
  if (!source) return missing(folder + "current_clocksource");
  for (const char* const slow : {"hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"}) {
    if (*source != slow) continue;
    return wrong(
        fmt::format("clock source {} (available: {}): to ask for the time takes a microsecond, or it is coarse", slow,
                    c.system.line(folder + "available_clocksource").value_or("?")),
        "look into `dmesg` why tsc was dropped; where it is sound, tsc=reliable on the command line of the kernel");
  }
  return fine(*source);
}

Outcome check_timers(const Context& c) {
  if (!c.system.calls().clocks) return unknown("needs the machine itself");
  const std::int64_t resolution = c.system.calls().clocks().resolution_ns;
  if (resolution <= 1000) return fine(fmt::format("{} ns", resolution));
  return wrong(
      fmt::format("timers have steps of {} us: tasks begin that much late", resolution / 1000),
      "use a kernel with high-resolution timers (CONFIG_HIGH_RES_TIMERS), and no highres=off on its command line");
}

Outcome check_synchronised(const Context& c) {
  if (!c.system.calls().clocks) return unknown("needs the machine itself");
  if (c.system.calls().clocks().synchronised) return fine("yes");
  return wrong("no time server keeps the clock right: times in logs and on HMIs drift",
               "`systemctl enable --now systemd-timesyncd`, or chrony; in a container the host's clock counts");
}

Outcome check_time_of_day(const Context& c) {
  if (!c.system.calls().clocks) return unknown("needs the machine itself");
  constexpr std::int64_t kEarliest = 1'735'689'600;  // 2025-01-01
  const std::int64_t now = c.system.calls().clocks().time_of_day_s;
  const std::string text = fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(now)));
  if (now >= kEarliest) return fine(text);
  return wrong(
      text + " has passed long ago: what is logged until the clock is set has wrong times",
      "set it (`date -s`), let a time server do it before plc-run starts (After=time-sync.target), or fit a battery");
}

Outcome check_battery_clock(const Context& c) {
  if (c.system.list("/sys/class").empty()) return missing("/sys/class");
  const auto clocks = c.system.list("/sys/class/rtc");
  if (!clocks.empty()) return fine(joined(clocks));
  return wrong("no real-time clock: after power-on it is 1970, or when the machine was last on",
               "needs a time server at each start, or a clock module");
}

}  // namespace plc::doctor
