#include "runtime/memory/lock_exchange.h"

namespace plc::runtime {

// RT:
void LockExchange::lock() noexcept {
  if (!locked_) pthread_mutex_lock(&mutex());
  locked_ = true;
}

// RT:
void LockExchange::unlock() noexcept {
  if (locked_) pthread_mutex_unlock(&mutex());
  locked_ = false;
}

// RT: code that takes no lock is wrong, and must not tear values all the same.
void LockExchange::import(std::uint32_t range) noexcept {
  const bool alone = locked_;
  lock();
  copy_in(range);
  if (!alone) unlock();
}

// RT:
void LockExchange::export_range(std::uint32_t range) noexcept {
  if (!may_publish()) return;
  const bool alone = locked_;
  lock();
  copy_out(range);
  if (!alone) unlock();
}

// RT:
bool LockExchange::end() noexcept {
  unlock();
  return CommonTableExchange::end();
}

// RT: by the thread that revoked the task, so locked_ is not ours to look at.
void LockExchange::publish_safe(std::span<const GlobalWrite> values) noexcept {
  pthread_mutex_lock(&mutex());
  put_safe(values);
  pthread_mutex_unlock(&mutex());
  CommonTableExchange::publish_safe(values);
}

}  // namespace plc::runtime
