#include "runtime/memory/exchange.h"

#include "runtime/memory/ceiling_exchange.h"
#include "runtime/memory/lock_exchange.h"
#include "runtime/memory/wait_free_exchange.h"

namespace plc::runtime {

std::unique_ptr<Exchange> make_exchange(core::Coherence coherence, GlobalTable& globals, std::uint32_t task,
                                        std::byte* local) {
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
