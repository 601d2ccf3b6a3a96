// Processors and memory.
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "doctor/check.h"

namespace plc::doctor {
namespace {

const std::string kFolder = "/sys/devices/system/cpu/";

/// Those that the kernel runs; empty: not known.
std::vector<int> online(const Context& c) { return parse_list(c.system.line(kFolder + "online").value_or("")); }
std::vector<int> isolated(const Context& c) { return parse_list(c.system.line(kFolder + "isolated").value_or("")); }
std::string of_cpu(int cpu, const char* file) { return kFolder + "cpu" + std::to_string(cpu) + "/" + file; }

bool is_quota(const std::string& value) {
  return !value.empty() && std::isdigit(static_cast<unsigned char>(value[0])) != 0;
}
/// Without a limit, version 1 has a number near 2^63.
bool is_size(const std::string& value) { return to_number(value).value_or(UINT64_MAX) < std::uint64_t{1} << 50; }

/// An interrupt that a driver takes has a folder with the driver's name.
bool is_used(const Context& c, const std::string& folder) {
  const auto names = c.system.list(folder);
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    const auto facts = c.system.facts(folder + "/" + name);
    return facts && S_ISDIR(facts->mode);
  });
}

}  // namespace

Outcome check_processor_count(const Context& c) {
  const std::vector<int> cpus = online(c);
  if (cpus.empty()) return missing(kFolder + "online");
  if (cpus.size() > 1) return fine(list_text(cpus));
  return wrong("one processor: HMIs, logs and tasks share it", "fine for small projects; watch how late scans begin");
}

Outcome check_configured_processors(const Context& c) {
  const std::vector<int> allowed = c.process.processors();
  if (allowed.empty()) return unknown("the processors of the process are not known");
  std::set<std::uint32_t> wanted;
  const io::Configuration& configuration = c.subject.configuration;
  if (configuration.scheduler.cpu) wanted.insert(*configuration.scheduler.cpu);
  for (const io::TaskConfig& task : configuration.tasks) {
    if (task.cpu) wanted.insert(*task.cpu);
  }
  Outcome outcome = fine("process may use " + list_text(allowed));
  for (const std::uint32_t cpu : wanted) {
    if (std::find(allowed.begin(), allowed.end(), static_cast<int>(cpu)) != allowed.end()) continue;
    outcome.found.push_back(
        {fmt::format("plc.toml wants processor {}, the process may use {}", cpu, list_text(allowed)),
         "give one of these as `cpu`, or allow it: CPUAffinity= of the service, cpuset of the container",
         {},
         {}});
  }
  return outcome;
}

Outcome check_frequency(const Context& c) {
  std::vector<int> changing;
  std::string governor;
  for (const int cpu : online(c)) {
    const auto is = c.system.line(of_cpu(cpu, "cpufreq/scaling_governor"));
    if (!is || *is == "performance") continue;
    governor = *is;
    changing.push_back(cpu);
  }
  if (changing.empty()) return fine("constant, or not for Linux to choose");
  return wrong(
      fmt::format("governor {} on processor {}: scans take longer after idle times", governor, list_text(changing)),
      "`cpupower frequency-set -g performance`, at each start of the machine");
}

Outcome check_idle_states(const Context& c) {
  constexpr std::int64_t kDeep = 100;  // us
  std::int64_t worst = 0;
  for (const std::string& state : c.system.list(kFolder + "cpu0/cpuidle")) {
    const std::string folder = kFolder + "cpu0/cpuidle/" + state;
    if (c.system.number(folder + "/disable").value_or(0) != 0) continue;
    worst = std::max(worst, c.system.number(folder + "/latency").value_or(0));
  }
  if (worst <= kDeep) return fine(fmt::format("at most {} us to wake up", worst));
  const auto wish = c.system.facts("/dev/cpu_dma_latency");
  if (wish && c.process.may(2, *wish)) return fine("plc-run keeps processors awake while it runs");
  return wrong(
      fmt::format("an idle processor takes up to {} us to wake up, and plc-run may not keep it awake", worst),
      "let the process write /dev/cpu_dma_latency, or set intel_idle.max_cstate=1 or cpuidle.off=1 for the kernel");
}

Outcome check_shared_cores(const Context& c) {
  for (const int cpu : online(c)) {
    const auto siblings = parse_list(c.system.line(of_cpu(cpu, "topology/thread_siblings_list")).value_or(""));
    if (siblings.size() < 2) continue;
    return wrong(
        fmt::format("processors {} are one core: work on one slows the other down", list_text(siblings)),
        "switch hyper-threading off in the firmware (nosmt for the kernel), or leave the siblings of processors with "
        "tasks idle");
  }
  return fine("none");
}

Outcome check_isolated(const Context& c) {
  const std::vector<int> cpus = isolated(c);
  if (!cpus.empty()) return fine(list_text(cpus));
  const std::size_t count = online(c).size();
  if (count == 0) return missing(kFolder + "online");
  if (count == 1) return fine("none, there is one processor");
  return wrong(
      "no processor is isolated: other programs and the kernel use those of the tasks, too",
      fmt::format("where microseconds count: isolcpus={0} nohz_full={0} rcu_nocbs={0} for the kernel, and cpu = {0} "
                  "under [scheduler] in plc.toml",
                  count - 1));
}

Outcome check_interrupts(const Context& c) {
  const std::vector<int> cpus = isolated(c);
  if (cpus.empty()) return fine("no processor is isolated");
  std::vector<std::string> there;
  for (const std::string& number : c.system.list("/proc/irq")) {
    if (!to_number(number)) continue;
    const std::string folder = "/proc/irq/" + number;
    auto list = c.system.line(folder + "/effective_affinity_list");
    if (!list || list->empty()) list = c.system.line(folder + "/smp_affinity_list");
    const std::vector<int> at = parse_list(list.value_or(""));
    const bool hit = std::any_of(at.begin(), at.end(),
                                 [&](int cpu) { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); });
    if (hit && is_used(c, folder)) there.push_back(number);
  }
  if (there.empty()) return fine("none on processor " + list_text(cpus));
  if (there.size() > 8) there.resize(8), there.emplace_back("..");
  return wrong(
      fmt::format("isolated processors {} serve interrupts {}", list_text(cpus), joined(there)),
      "`echo 0 > /proc/irq/NUMBER/smp_affinity_list` moves one to processor 0; irqaffinity=0 for the kernel moves all");
}

Outcome check_processor_time(const Context& c) {
  auto quota = c.process.control("cpu", "cpu.max", is_quota);
  if (!quota) quota = c.process.control("cpu", "cpu.cfs_quota_us", is_quota);
  if (!quota) return fine("no limit");
  return wrong(
      fmt::format("the control group of the process has a quota, \"{}\" us: its threads stop when it is used up",
                  *quota),
      "run it without CPUQuota= (service) or --cpus (container)");
}

Outcome check_memory(const Context& c) {
  constexpr std::uint64_t kEnough = 128;  // MiB
  std::optional<std::uint64_t> available;
  const std::string text = c.system.read("/proc/meminfo").value_or("");
  for (const std::string_view line : lines_of(text)) {
    const auto words = words_of(line);
    if (words.size() >= 2 && words[0] == "MemAvailable:") available = to_number(words[1]);
  }
  if (!available) return missing("/proc/meminfo");
  std::uint64_t mib = *available / 1024;
  auto limit = c.process.control("memory", "memory.max", is_size);
  if (!limit) limit = c.process.control("memory", "memory.limit_in_bytes", is_size);
  if (limit) mib = std::min(mib, *to_number(*limit) >> 20);
  if (mib >= kEnough) return fine(fmt::format("{} MiB", mib));
  return wrong(
      fmt::format("{} MiB are available{}: plc-run locks all that it uses, 1 MiB of stack for each task with it", mib,
                  limit ? " in the control group" : ""),
      fmt::format("{} MiB are enough for most projects", kEnough));
}

Outcome check_swap(const Context& c) {
  const auto text = c.system.read("/proc/swaps");
  if (!text) return missing("/proc/swaps");
  const auto lines = lines_of(*text);
  const auto words = words_of(lines.size() < 2 ? std::string_view{} : lines[1]);
  if (words.empty()) return fine("off");
  return wrong(fmt::format("swap is on ({}): what is not locked comes back from the disk late", words[0]),
               "`swapoff -a` and no entry in /etc/fstab; where memory may be locked, tasks themselves are not swapped");
}

}  // namespace plc::doctor
