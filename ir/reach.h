// What a task reaches: POUs called or run, and globals read and written by each of them.
//
// In: a Module. Out: read by ir::check (several writers) and by code generation (import and export lists).
// Conservative: a global of which a handle is made counts as read and written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "ir/ir.h"

namespace plc::ir {

/// The place that `place` is part of: a global, a variable, or what a reference points at.
const Place& root_of(const Body& body, PlaceId place);

/// The same, where a member of a union counts as part of the union, whose address leads to it.
const Place& reached_root(const Body& body, PlaceId place);

/// Where the body first reads or writes a global that is an array, or makes a handle of it.
std::optional<SourceRef> first_access(const Body& body, std::uint32_t global);

/// The POU that the instruction calls or runs.
std::optional<std::uint32_t> callee_of(const Module& module, const Body& body, const Inst& inst);

/// POUs that executing `pou` may call or run directly; each once, in order of appearance.
std::vector<std::uint32_t> callees(const Module& module, std::uint32_t pou);

/// POUs reached from the programs of `task`, callees before callers. Ends on recursive modules too.
std::vector<std::uint32_t> reached_pous(const Module& module, const Task& task);

struct GlobalUse {
  explicit GlobalUse(std::size_t globals) : read(globals), written(globals), written_at(globals) {}
  /// Notes that `global` is written, at first here.
  void write(std::uint32_t global, const SourceRef& at);

  std::vector<bool> read;             ///< by global index
  std::vector<bool> written;          ///< by global index
  std::vector<SourceRef> written_at;  ///< by global index: a place that writes it, the first of those found
};
/// What references in globals, where every task finds them, may refer to.
struct SharedReferences {
  /// By type: every global of which, or of a part of which, a reference of this type is made anywhere; handles that are
  /// passed as VAR_IN_OUT count where a reference is made from them. Empty for types to which no global holds a
  /// reference or in-out; without any such type the list itself is empty.
  std::vector<std::vector<std::uint32_t>> globals;
  /// Every global whose address is taken anywhere, where a global holds a pointer; else empty. Pointers lead to
  /// anything.
  std::vector<std::uint32_t> pointed;
};
SharedReferences shared_references(const Module& module);
/// The globals used by everything that `task` reaches, by name or through references, which may refer to any global
/// that `shared` has for their type.
GlobalUse global_use(const Module& module, const Task& task, const SharedReferences& shared);

}  // namespace plc::ir
