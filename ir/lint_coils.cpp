// Lint of coils that POUs share: one global variable on normal coils of several bodies that one task runs. Several
// coils inside one drawing are found by the ladder itself, under the same code.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "ir/lint_findings.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

/// True for place := power flow; false for set and reset coils, which begin with what the place had.
bool is_normal_coil(const Body& body, const Inst& store) {
  if (store.op != Op::kStore || body.sources[store.source].kind != core::ElementKind::kCoil) return false;
  const Inst& value = body.insts[store.b];
  if (value.op != Op::kOr && value.op != Op::kAnd) return true;
  const Inst& first = body.insts[value.a];
  return first.op != Op::kLoad || first.a != store.a || first.source != store.source;
}

struct Coil {
  std::uint32_t pou;
  SourceRef at;
};

}  // namespace

void lint_coils(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kDoubleCoil)) return;
  std::unordered_map<std::uint32_t, std::vector<Coil>> coils;  // by global; one per body
  std::vector<std::uint32_t> order;
  for (std::uint32_t p = 0; p < module.pous.size(); ++p) {
    const Body& body = module.pous[p].body;
    if (!findings.is_linted(module.pous[p])) continue;
    for (const Inst& inst : body.insts) {
      if (!is_normal_coil(body, inst)) continue;
      const Place& place = body.places[inst.a];
      if (place.kind != Place::Kind::kGlobal) continue;
      std::vector<Coil>& seen = coils[place.index];
      if (seen.empty()) order.push_back(place.index);
      if (seen.empty() || seen.back().pou != p) seen.push_back({p, body.sources[inst.source]});
    }
  }
  std::erase_if(order, [&](std::uint32_t g) { return coils[g].size() < 2; });
  if (order.empty()) return;

  for (const Task& task : module.tasks) {
    std::vector<bool> reached(module.pous.size());
    for (const std::uint32_t pou : reached_pous(module, task)) reached[pou] = true;
    std::erase_if(order, [&](std::uint32_t g) {
      std::vector<const Coil*> here;
      for (const Coil& coil : coils[g]) {
        if (reached[coil.pou]) here.push_back(&coil);
      }
      if (here.size() < 2) return false;
      const Variable& v = module.globals[g].variable;
      std::string list;
      for (const Coil* coil : here) {
        list += fmt::format("{}{} (line {})", list.empty() ? "" : ", ", module.pous[coil->pou].name, coil->at.line);
      }
      findings.add(Lint::kDoubleCoil, here.back()->at, module.pous[here.back()->pou].name,
                   fmt::format("coils of several POUs drive {}: {}", quoted(v.name.empty() ? v.address : v.name), list),
                   "the last one to run wins; give the variable one writer");
      return true;
    });
  }
}

}  // namespace plc::ir
