#include "io-drivers/machine/plant.h"

#include <algorithm>
#include <utility>

namespace plc::io {
namespace {
constexpr core::TimeNs kPollNs = 20'000'000;
constexpr core::TimeNs kServiceNs = 100'000'000;
}  // namespace

Plant::Plant(runtime::Resource& resource, std::unique_ptr<Machine> machine, runtime::RealtimeOptions realtime)
    : resource_(resource), machine_(std::move(machine)), options_(std::move(realtime)) {}

Plant::~Plant() {
  // The server asks the scheduler how the plant runs.
  if (!scheduler_) return;
  scheduler_->request_stop();
  scheduler_->join();
  machine_->stop();
}

std::optional<core::Problem> Plant::prepare(const std::function<void()>& in_child, std::vector<Sentence>& notes) {
  if (auto problem = machine_->open()) return problem;
  in_child();
  if (auto problem = resource_.start_taskblocks()) return problem;
  options_.safe_values = machine_->safe_values();
  scheduler_.emplace(resource_, std::move(options_));
  machine_->start(*scheduler_, notes);
  return std::nullopt;
}

std::optional<core::Problem> Plant::start() {
  begin_ns_ = clock_.now_ns();
  const runtime::RealtimeReport& report = scheduler_->start();
  if (!report.problem) return std::nullopt;
  machine_->stopping();
  machine_->stop();
  return report.problem;
}

void Plant::run(core::TimeNs duration_ns, const std::function<void(core::TimeNs)>& often,
                const std::function<void(const Sentence&)>& say) {
  core::TimeNs next_service = begin_ns_;
  while (!scheduler_->stop_requested()) {
    const core::TimeNs now = clock_.now_ns();
    if (now >= next_service) {
      for (const Sentence& sentence : machine_->service(now)) say(sentence);
      next_service = now + kServiceNs;
    }
    if (duration_ns != 0 && now - begin_ns_ >= duration_ns) break;
    often(now);
    const core::TimeNs next = now + kPollNs;
    clock_.sleep_until_ns(duration_ns == 0 ? next : std::min(next, begin_ns_ + duration_ns));
  }
}

std::vector<std::uint32_t> Plant::stop() {
  machine_->stopping();
  scheduler_->request_stop();
  std::vector<std::uint32_t> stuck = scheduler_->join();
  machine_->stop();
  return stuck;
}

}  // namespace plc::io
