#include "ir/probes.h"

#include "ir/builder.h"

namespace plc::ir {

void Builder::probe(const ProbeKey& key, ValueId value) {
  if (!notes_probes() || !value.valid()) return;
  body().probes.push_back({key, value, {}, static_cast<std::uint32_t>(body().insts.size()), {}});
}

void Builder::probe(const ProbeKey& key, const Operand& operand) {
  if (operand.kind == Operand::Kind::kValue) probe(key, operand.value);
}

void Builder::probe(const ProbeKey& key, PlaceId place) {
  if (!notes_probes()) return;
  body().probes.push_back({key, {}, place, static_cast<std::uint32_t>(body().insts.size()), {}});
}

void Builder::probe_reached(const ProbeKey& key) {
  if (!notes_probes()) return;
  body().probes.push_back({key, {}, {}, static_cast<std::uint32_t>(body().insts.size()), {}});
}

}  // namespace plc::ir
