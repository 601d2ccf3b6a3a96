#include "io-drivers/driver.h"

#include <pthread.h>

#include <algorithm>
#include <csignal>
#include <exception>
#include <thread>

namespace plc::io {

std::string_view quality_word(Quality quality) {
  switch (quality) {
    case Quality::kNever:
      return "never";
    case Quality::kGood:
      return "good";
    case Quality::kLost:
      break;
  }
  return "lost";
}

InputStatus input_status(std::string_view variable, core::TimeNs read_at_ns, bool connected, core::TimeNs now_ns) {
  if (read_at_ns < 0) return {variable, Quality::kNever, 0};
  // It may have been read after `now_ns` was taken.
  return {variable, connected ? Quality::kGood : Quality::kLost, std::max<core::TimeNs>(now_ns - read_at_ns, 0)};
}

void for_all_at_once(std::span<Driver* const> drivers, const std::function<void(Driver&)>& what) {
  for (Driver* const driver : drivers) {
    if (driver->timing() != Timing::kThreaded) what(*driver);
  }
  // WHY not OrdinaryThread: the guardian does this with the priority that it has.
  std::vector<std::thread> threads;
  std::vector<Driver*> rest;  // no thread is to be had for them
  threads.reserve(drivers.size());
  rest.reserve(drivers.size());
  for (Driver* const driver : drivers) {
    if (driver->timing() != Timing::kThreaded) continue;
    try {
      threads.emplace_back([driver, &what] {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, nullptr);  // signals are for the main thread
        what(*driver);
      });
    } catch (const std::exception&) {
      rest.push_back(driver);
    }
  }
  for (Driver* const driver : rest) what(*driver);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace plc::io
