#include "bench/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <ctime>

#include "core/clock.h"

namespace plc::bench {

Cost run(const std::vector<std::string>& arguments, bool quiet) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) return {};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_addclose(&actions, pipe[0]);
  ::posix_spawn_file_actions_addclose(&actions, pipe[1]);
  if (quiet) ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  pid_t child = 0;
  const int spawned = ::posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[1]);
  Cost cost;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; spawned == 0 && (got = ::read(pipe[0], buffer.data(), buffer.size())) > 0;) {
    cost.output.append(buffer.data(), static_cast<std::size_t>(got));
  }
  ::close(pipe[0]);
  if (spawned != 0) return cost;
  int status = 0;
  struct rusage usage {};
  ::wait4(child, &status, 0, &usage);
  cost.wall_ms = static_cast<double>(clock.now_ns() - begin) / 1e6;
  const auto ms = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_usec) / 1e3;
  };
  cost.cpu_ms = ms(usage.ru_utime) + ms(usage.ru_stime);
  cost.peak_mb = static_cast<double>(usage.ru_maxrss) / 1024;
  if (WIFEXITED(status)) cost.exit_code = WEXITSTATUS(status);
  cost.ok = cost.exit_code == 0;
  return cost;
}

core::TimeNs own_time_ns() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec * core::TimeNs{1'000'000'000} + time.tv_nsec;
}

}  // namespace plc::bench
