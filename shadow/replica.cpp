#include "shadow/replica.h"

#include <fmt/format.h>

#include <cstring>

namespace plc::shadow {
namespace {

bool same_check(std::uint64_t check, const runtime::RecordHead& head) {
  return ((check ^ head.check) & ((head.flags & runtime::kShortCheck) != 0 ? 0xffffu : ~std::uint64_t{0})) == 0;
}

}  // namespace

std::size_t Replica::table_bytes() const { return program_->table().layout().total; }

bool Replica::load(std::span<const std::byte> table) {
  if (table.size() != table_bytes()) return false;
  return replay_->load(table);
}

Replica::Outcome Replica::run(std::span<const std::byte> record) {
  Outcome outcome;
  replay_->begin(record);
  const runtime::RecordHead& head = replay_->head();
  if ((head.flags & runtime::kCut) != 0) return outcome;
  outcome.ran = true;
  const std::uint64_t events = program_->event_total();
  outcome.fault = program_->execute({head.now_ns, head.start_ns, head.utc_ns});
  outcome.events = static_cast<std::uint32_t>(program_->event_total() - events);
  const runtime::Fault& fault = outcome.fault;
  runtime::RecordedFault found;
  if (fault) found = {static_cast<std::uint32_t>(fault.kind), fault.pou, fault.word, fault.taskblock};
  const runtime::RecordedFault recorded = replay_->fault();
  const std::span<const std::byte> table(program_->table().data(), table_bytes());
  // Where a scan was when it lost the right to publish, the other thread saw only roughly.
  const bool same_fault = (head.flags & runtime::kRevoked) != 0 ? found.kind == recorded.kind : found == recorded;
  if (!same_fault) {
    outcome.differs = "the fault";
  } else if (!replay_->finished()) {
    outcome.differs = "what the scan asks for";
  } else if (outcome.events != head.events) {
    outcome.differs = "the number of events";
  } else if (!same_check(runtime::check_of_slice(table, head.slice), head)) {
    outcome.slice = head.slice;
    outcome.differs = fmt::format("the table, bytes {} to {}", head.slice * runtime::kSliceBytes,
                                  (head.slice + 1) * runtime::kSliceBytes - 1);
  }
  outcome.equal = outcome.differs.empty();
  return outcome;
}

}  // namespace plc::shadow
