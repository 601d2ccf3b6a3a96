#include "path_plot.h"

#include <pthread.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <utility>

namespace cnc {

namespace {

constexpr std::chrono::milliseconds kPause{20};

}  // namespace

PathPlot::PathPlot(Options options) : options_(std::move(options)), ring_(options_.samples) {
  // WHY no signals: they are for the main thread of the PLC.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    thread_ = std::thread([this] { run(); });
  } catch (...) {
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw;
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(thread_.native_handle(), "path-plot");
}

PathPlot::~PathPlot() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_one();
  thread_.join();
}

// RT:
bool PathPlot::push(const PathSample& sample) noexcept {
  const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
  if (at - taken_.load(std::memory_order_acquire) >= ring_.size()) return false;
  ring_[at % ring_.size()] = sample;
  pushed_.store(at + 1, std::memory_order_release);
  return true;
}

void PathPlot::run() {
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    last = stop_.wait_for(lock, kPause, [this] { return stopping_; });
    lock.unlock();
    drain();
    lock.lock();
  }
  finish();
}

void PathPlot::drain() {
  const std::uint64_t end = pushed_.load(std::memory_order_acquire);
  for (std::uint64_t at = taken_.load(std::memory_order_relaxed); at != end; ++at) {
    const PathSample sample = ring_[at % ring_.size()];
    taken_.store(at + 1, std::memory_order_release);
    if (sample.last) {
      finish();
    } else {
      if (!drawing_) drawing_.emplace(options_.program, sample.set, options_.tool);
      drawing_->add(sample);
    }
  }
}

void PathPlot::finish() {
  if (!drawing_) return;
  const int error = write(drawing_->svg(options_.title));
  error_.store(error, std::memory_order_relaxed);
  deviation_.store(drawing_->deviation(), std::memory_order_relaxed);
  following_error_.store(drawing_->following_error(), std::memory_order_relaxed);
  if (error == 0) pictures_.fetch_add(1, std::memory_order_release);
  drawing_.reset();
}

// Beside its place first: who looks at the picture never sees half of one.
int PathPlot::write(const std::string& text) const {
  const std::string beside = options_.file + ".new";
  std::FILE* const file = std::fopen(beside.c_str(), "wb");
  if (file == nullptr) return errno;
  errno = 0;
  const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const int problem = errno;
  const bool closed = std::fclose(file) == 0;
  if (whole && closed && std::rename(beside.c_str(), options_.file.c_str()) == 0) return 0;
  const int error = whole ? errno : problem;
  std::remove(beside.c_str());
  return error != 0 ? error : EIO;
}

}  // namespace cnc
