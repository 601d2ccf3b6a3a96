#include "engineering/worker.h"

#include <exception>
#include <utility>

namespace plc::engineering {

void Worker::start(const char* name) {
  stopping_ = false;
  thread_.start(name, [this] { run(); });
}

void Worker::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Worker::drop() {
  const std::lock_guard lock(mutex_);
  waiting_.clear();
}

bool Worker::post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || waiting_.size() >= most_) return false;
    waiting_.push_back(std::move(work));
  }
  wake_.notify_one();
  return true;
}

void Worker::run() {
  for (;;) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      work = std::move(waiting_.front());
      waiting_.pop_front();
    }
    // WHY: an exception that nobody takes ends the process that runs the plant.
    try {
      work();
    } catch (const std::exception&) {
      // No memory, most likely: this work is lost, what waits goes on.
    }
  }
}

}  // namespace plc::engineering
