#include "engineering/shadow_values.h"

#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

namespace plc::engineering {
namespace {

/// So many values are taken without anybody asking for variables of tasks before replicas stop to follow.
constexpr unsigned kMostIdle = 200;
/// Who asks first waits at most so long until the replicas are made and follow.
constexpr std::chrono::milliseconds kFirstLook{500}, kPoll{2};

}  // namespace

void ShadowValues::detach() {
  viewer_.reset();
  shadow_ = nullptr;
  tables_.clear();
}

bool ShadowValues::knows(std::uint32_t task) const { return task == runtime::Place::kGlobal || shadow_ != nullptr; }

void ShadowValues::look() const {
  const auto copy = [this](shadow::Follower& follower) {
    shadow::ReplicaSet& replicas = follower.replicas();
    tables_.resize(replicas.task_count());
    for (std::uint32_t task = 0; task < tables_.size(); ++task) {
      const runtime::TaskTable& table = replicas.replica(task).program().table();
      tables_[task].assign(table.data(), table.data() + table.layout().total);
    }
  };
  if (viewer_) {
    viewer_->read(copy);
    return;
  }
  viewer_ = std::make_unique<shadow::Shadow::Viewer>(*shadow_);
  const auto until = std::chrono::steady_clock::now() + kFirstLook;
  while (!viewer_->read(copy) && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(kPoll);
}

void ShadowValues::take() {
  globals_.take();
  idle_ = asked_ ? 0 : idle_ + 1;
  asked_ = false;
  if (idle_ <= kMostIdle) return;
  viewer_.reset();
  idle_ = kMostIdle;
}

void ShadowValues::read(std::uint32_t task, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const {
  if (task == runtime::Place::kGlobal) return globals_.read(task, offset, bytes, to);
  if (!std::exchange(asked_, true) && shadow_ != nullptr) look();
  const bool there = task < tables_.size() && std::size_t{offset} + bytes <= tables_[task].size();
  // As at the first start, until scans were followed.
  if (there) {
    std::memcpy(to, &tables_[task][offset], bytes);
  } else {
    std::memset(to, 0, bytes);
  }
}

}  // namespace plc::engineering
