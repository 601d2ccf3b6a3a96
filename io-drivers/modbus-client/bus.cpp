#include "io-drivers/modbus-client/bus.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <system_error>
#include <utility>

namespace plc::modbus_client {
namespace {

/// WHY not std::thread: plc-run locks its memory, and the usual 8 MB for each of many buses would all be there.
constexpr std::size_t kStackBytes = 524'288;
/// WHY less than the five seconds after which the guardian kills a runtime that does not end: what comes after the
/// devices, such as the last retained values, needs some of them.
constexpr core::TimeNs kEndNs = 3'000'000'000;
/// The guardian's own; systemd gives both together 15 seconds.
constexpr core::TimeNs kGuardianEndNs = 8'000'000'000;
/// WHY more than that where there are many: one that answers must have the time for it, whoever is silent before it.
constexpr core::TimeNs kGuardianPartNs = 1'000'000'000;

}  // namespace

std::shared_ptr<Bus> Bus::of(const void* resource, const BusAddress& address) {
  // WHY a list of the process: drivers are made one by one, and know nothing of each other.
  static std::mutex mutex;
  static std::map<std::pair<const void*, std::string>, std::weak_ptr<Bus>> buses;
  const std::scoped_lock lock(mutex);
  std::erase_if(buses, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<Bus>& known = buses[{resource, bus_name(address)}];
  auto bus = known.lock();
  if (bus == nullptr) known = bus = std::make_shared<Bus>(address);
  return bus;
}

Bus::~Bus() {
  while (!members_.empty()) leave(*members_.back().device);
}

void Bus::add(Device& device) { members_.push_back({&device}); }

void Bus::start() {
  if (running_ || members_.empty()) return;
  link_ = make_link(address_);
  // Signals are for the main thread.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  const auto body = [](void* bus) -> void* {
    static_cast<Bus*>(bus)->run();
    return nullptr;
  };
  const int error = pthread_create(&thread_, &attributes, body, this);
  running_ = error == 0;
  pthread_attr_destroy(&attributes);
  if (error != 0)
    throw std::system_error(error, std::generic_category(), "no thread for the bus " + bus_name(address_));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Bus::leave(Device& device) noexcept {
  const auto is_it = [&](const Member& member) { return member.device == &device; };
  {
    std::unique_lock lock(mutex_);
    const auto member = std::ranges::find_if(members_, is_it);
    if (member == members_.end()) return;
    if (!running_) {
      members_.erase(member);
      return;
    }
    member->leaves = true;
    // Half for what is asked just now: who is silent there must not take the time of the others.
    if (std::ranges::all_of(members_, &Member::leaves)) link_->end_by(core::MonotonicClock().now_ns() + kEndNs / 2);
    changed_.notify_all();
    changed_.wait(lock, [&] { return std::ranges::none_of(members_, is_it); });
    // Several may leave at once; one of them joins the thread.
    if (!members_.empty() || !std::exchange(running_, false)) return;
  }
  pthread_join(thread_, nullptr);
  link_.reset();
}

bool Bus::write_safe(const Device& device) {
  const std::scoped_lock lock(mutex_);
  if (link_ == nullptr) link_ = make_link(address_);
  // A part for each: nobody knows which of them are silent.
  const auto members = static_cast<core::TimeNs>(std::max<std::size_t>(members_.size(), 1));
  link_->end_by(core::MonotonicClock().now_ns() + std::max(kGuardianEndNs / members, kGuardianPartNs));
  return device.write_safe(*link_);
}

void Bus::run() {
  pthread_setname_np(pthread_self(), "plc-modbus");
  core::MonotonicClock clock;
  std::unique_lock lock(mutex_);
  for (const Member& member : members_) member.device->begin(clock.now_ns());
  while (!members_.empty()) serve(*link_, lock);
}

void Bus::serve(Link& link, std::unique_lock<std::mutex>& lock) {
  core::MonotonicClock clock;
  // Devices that are lost leave last: they may take all the time there is.
  const auto leaving = std::ranges::min_element(members_, {}, [](const Member& member) {
    return !member.leaves ? 2 : member.device->lost() ? 1 : 0;
  });
  if (leaving->leaves) {
    if (std::ranges::all_of(members_, &Member::leaves) && !std::exchange(ends_, true)) {
      link.end_by(clock.now_ns() + kEndNs / 2);
    }
    Device& device = *leaving->device;
    lock.unlock();
    device.hold_all();
    device.write_safe(link);
    lock.lock();
    std::erase_if(members_, [&](const Member& member) { return member.device == &device; });
    changed_.notify_all();
    return;
  }
  const auto first = std::ranges::min_element(members_, {}, [](const Member& member) { return member.device->due(); });
  const TimeNs now = clock.now_ns();
  const TimeNs due = first->device->due();
  if (due > now) {
    // Not for ever: a duration of a device that is never due cannot be added to the time.
    changed_.wait_for(lock, std::chrono::nanoseconds(std::min<TimeNs>(due - now, 1'000'000'000)));
    return;
  }
  Device& device = *first->device;
  lock.unlock();
  device.turn(link, clock);
  lock.lock();
}

}  // namespace plc::modbus_client
