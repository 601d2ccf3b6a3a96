// Registry: the taskblocks that a project may use, from all libraries of this program and this machine (paper, 3.2).
//
// In: libraries, linked in (set.h) or loaded (shared_library.h). Out: blocks by name, their declaration as text for the
// compiler and for editors. Filled before anything is compiled or linked; read from any thread afterwards.
// Does not belong here: instances and their objects (runtime/taskblocks.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "picard/abi.h"

namespace plc::taskblocks {

class Registry {
 public:
  struct Entry {
    const picard_library* library = nullptr;
    const picard_block* block = nullptr;
    std::string source;  ///< path of the shared object; empty for what is linked in
  };

  /// The set that comes with PICARD.
  static const Registry& built_in();

  /// Adds all blocks of a library, or none: P7801 when it is of another ABI, cannot describe its blocks, or describes
  /// them wrongly (names that cannot be spelled, or are taken, types that do not exist). `source` names it in messages.
  std::optional<core::Problem> add(const picard_library* library, const std::string& source = {});

  /// In the order of libraries and their lists.
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  /// The block called `name` (any letter case) or null.
  [[nodiscard]] const Entry* find(std::string_view name) const;

 private:
  std::vector<Entry> entries_;
};

/// Hash of the block's name and the names, types and directions of its ports: an image made for another declaration is
/// refused. Never 0.
std::uint64_t layout_hash(const picard_block& block);

/// How a type is spelled: "LREAL", "STRING[20]", "ARRAY [0..5] OF MOVE".
std::string type_text(const picard_type& type);

/// The block as FUNCTION_BLOCK without statements, after the data types its ports need, in the language ST.
/// Configuration ports are constant inputs.
std::string declaration(const picard_block& block);
/// The structures and enumerations that the ports of `block` need, each after those it needs itself.
std::vector<const picard_type*> data_types_of(const picard_block& block);
/// One of them as TYPE .. END_TYPE.
std::string declaration(const picard_type& type);
/// The block without the data types.
std::string block_declaration(const picard_block& block);

}  // namespace plc::taskblocks
