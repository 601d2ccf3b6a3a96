#include "ir/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "ir/queues.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

using core::Code;

/// Depth-first search over POUs; reports every edge that closes a cycle, with the path. `next` lists a POU's
/// successors.
template <class Next>
class CycleSearch {
 public:
  CycleSearch(const Module& module, core::Diagnostics& diagnostics, Code code, std::string_view what, Next next)
      : module_(module), diagnostics_(diagnostics), code_(code), what_(what), next_(std::move(next)) {}

  /// POUs that lie on a reported cycle.
  std::vector<bool> run() {
    state_.assign(module_.pous.size(), State::kNew);
    on_cycle_.assign(module_.pous.size(), false);
    for (std::uint32_t pou = 0; pou < module_.pous.size(); ++pou) {
      const bool unused = module_.pous[pou].from_library && !module_.pous[pou].compiled;
      if (state_[pou] == State::kNew && !unused) visit(pou);
    }
    return on_cycle_;
  }

 private:
  enum class State : std::uint8_t { kNew, kOpen, kDone };
  struct Frame {
    std::uint32_t pou;
    std::vector<std::uint32_t> next;
    std::size_t at = 0;
  };

  void visit(std::uint32_t start) {
    std::vector<Frame> stack;
    const auto open = [&](std::uint32_t pou) {
      state_[pou] = State::kOpen;
      stack.push_back({pou, next_(pou)});
    };
    open(start);
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (top.at == top.next.size()) {
        state_[top.pou] = State::kDone;
        stack.pop_back();
        continue;
      }
      const std::uint32_t to = top.next[top.at++];
      if (state_[to] == State::kNew)
        open(to);
      else if (state_[to] == State::kOpen)
        close(stack, to);
    }
  }

  void close(const std::vector<Frame>& stack, std::uint32_t to) {
    const auto first = std::find_if(stack.begin(), stack.end(), [&](const Frame& f) { return f.pou == to; });
    std::string path;
    for (auto it = first; it != stack.end(); ++it) {
      path += module_.pous[it->pou].name + " -> ";
      on_cycle_[it->pou] = true;
    }
    path += module_.pous[to].name;
    diagnostics_.report(code_, module_.pous[to].at, module_.pous[to].name, fmt::format("{}: {}", what_, path),
                        code_ == Code::P4201 ? "recursion is not allowed (IEC 61131-3, 6.6.2); use a loop"
                                             : "pass the other instance as VAR_IN_OUT");
  }

  const Module& module_;
  core::Diagnostics& diagnostics_;
  Code code_;
  std::string_view what_;
  Next next_;
  std::vector<State> state_;
  std::vector<bool> on_cycle_;
};

template <class Next>
std::vector<bool> find_cycles(const Module& module, core::Diagnostics& diagnostics, Code code, std::string_view what,
                              Next next) {
  return CycleSearch<Next>(module, diagnostics, code, what, std::move(next)).run();
}

/// POUs whose instances are part of a value of `ref`. Types in `seen` are done: two members of one type each, nested
/// sixty deep, have 2^60 leaves.
void add_contained(const TypeTable& types, TypeRef ref, std::unordered_set<std::uint32_t>& seen,
                   std::vector<std::uint32_t>& out) {
  if (!ref.valid()) return;
  const Type& type = types[ref];
  const bool has_parts = type.kind == TypeKind::kArray || type.kind == TypeKind::kStruct || type.kind == TypeKind::kPou;
  if (!has_parts || !seen.insert(ref.index).second) return;
  if (type.kind == TypeKind::kArray) add_contained(types, type.element, seen, out);
  if (type.kind == TypeKind::kStruct) {
    for (const TypeField& field : type.fields) add_contained(types, field.type, seen, out);
  }
  if (type.kind == TypeKind::kPou) out.push_back(type.pou);
}

std::vector<std::uint32_t> contained(const Module& module, std::uint32_t pou) {
  std::vector<std::uint32_t> out;
  std::unordered_set<std::uint32_t> seen;
  for (const Variable& v : module.pous[pou].variables) {
    if (v.role != Role::kExternal) add_contained(module.types, v.type, seen, out);
  }
  return out;
}

void check_labels(const Pou& pou, core::Diagnostics& diagnostics) {
  std::vector<bool> bound(pou.body.label_count);
  for (const Inst& inst : pou.body.insts) {
    if (inst.op == Op::kLabel) bound[inst.a] = true;
  }
  for (const Inst& inst : pou.body.insts) {
    const bool jumps = inst.op == Op::kJump || inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot;
    if (!jumps || bound[inst.a]) continue;
    diagnostics.report(Code::P9001, pou.body.sources[inst.source], pou.name,
                       "a front end let pass a jump to a label that this body does not have");
  }
}

/// A task that writes a global, and where.
struct Writer {
  std::uint32_t task = 0;
  SourceRef at;
};

/// "Fast (plant.st:12) and Slow (plant.st:40)"
std::string names_of(const Module& module, const std::vector<Writer>& writers, const core::Diagnostics& diagnostics) {
  std::string names;
  for (std::size_t i = 0; i < writers.size(); ++i) {
    names += i == 0 ? "" : i + 1 == writers.size() ? " and " : ", ";
    names += module.tasks[writers[i].task].name;
    const SourceRef& at = writers[i].at;
    if (at.line == 0 || at.file >= diagnostics.file_count()) continue;
    names += fmt::format(" ({}:{})", diagnostics.file_name(at.file), at.line);
  }
  return names;
}

void check_writers(const Module& module, core::Diagnostics& diagnostics) {
  if (module.tasks.size() < 2) return;
  const SharedReferences shared = shared_references(module);
  std::vector<std::vector<Writer>> writers(module.globals.size());
  for (std::uint32_t t = 0; t < module.tasks.size(); ++t) {
    const GlobalUse use = global_use(module, module.tasks[t], shared);
    for (std::size_t g = 0; g < use.written.size(); ++g) {
      if (use.written[g]) writers[g].push_back({t, use.written_at[g]});
    }
  }
  for (std::size_t g = 0; g < writers.size(); ++g) {
    if (writers[g].size() < 2) continue;
    const Variable& v = module.globals[g].variable;
    if (v.name.starts_with('#')) continue;  // notes of coverage: every task only adds to them
    diagnostics.report(Code::P4204, v.at, "",
                       fmt::format("{} {} is written by tasks {}", module.globals[g].program ? "program" : "variable",
                                   v.name.empty() ? v.address : v.name, names_of(module, writers[g], diagnostics)),
                       "each task publishes only what it changed, the last one wins; give the variable one writer");
  }
}

}  // namespace

bool check(const Module& module, core::Diagnostics& diagnostics) {
  const std::size_t before = diagnostics.error_count();
  const std::vector<bool> self_contained =
      find_cycles(module, diagnostics, Code::P4202, "function block contains itself",
                  [&](std::uint32_t pou) { return contained(module, pou); });
  // Running a block that contains itself is one mistake, not two.
  find_cycles(module, diagnostics, Code::P4201, "recursive call", [&](std::uint32_t pou) {
    std::vector<std::uint32_t> next = callees(module, pou);
    if (self_contained[pou]) std::erase_if(next, [&](std::uint32_t to) { return self_contained[to]; });
    return next;
  });
  // A body with errors was given up somewhere.
  if (!diagnostics.has_errors()) {
    for (const Pou& pou : module.pous) check_labels(pou, diagnostics);
  }
  if (diagnostics.error_count() == before) check_queues(module, diagnostics);
  if (diagnostics.error_count() == before) check_writers(module, diagnostics);
  return diagnostics.error_count() == before;
}

}  // namespace plc::ir
