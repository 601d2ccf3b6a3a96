#include "runtime/memory/exchange.h"

#include <atomic>

#include "runtime/memory/ceiling_exchange.h"
#include "runtime/memory/lock_exchange.h"
#include "runtime/memory/wait_free_exchange.h"

namespace plc::runtime {
namespace {

/// Of a project without globals: nothing goes in or out, and revoking a task that has just ended its cycle ends
/// the next one.
class NoExchange final : public Exchange {
 public:
  std::uint32_t add_range(std::uint32_t, std::uint32_t, Use) override { return 0; }
  void prepare() override {}
  void reset() override { revoked_.store(false, std::memory_order_relaxed); }
  void expect(std::size_t) noexcept override {}
  void begin() noexcept override {}
  void import(std::uint32_t) noexcept override {}
  void export_range(std::uint32_t) noexcept override {}
  bool end() noexcept override { return !revoked_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool read_bool(std::uint32_t) noexcept override { return false; }
  bool revoke() noexcept override { return !revoked_.exchange(true, std::memory_order_acquire); }
  void publish_safe(std::span<const GlobalWrite>) noexcept override {}

 private:
  std::atomic<bool> revoked_{false};
};

}  // namespace

std::unique_ptr<Exchange> make_exchange(core::Coherence coherence, GlobalTable& globals, std::uint32_t task,
                                        std::byte* local) {
  if (globals.size() == 0) return std::make_unique<NoExchange>();
  switch (coherence) {
    case core::Coherence::kPriorityCeiling:
      return std::make_unique<CeilingExchange>(globals, task, local);
    case core::Coherence::kGlobalLock:
      return std::make_unique<LockExchange>(globals, task, local);
    case core::Coherence::kWaitFree:
      break;
  }
  return std::make_unique<WaitFreeExchange>(globals, task, local);
}

}  // namespace plc::runtime
