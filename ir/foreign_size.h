// How many bytes a type has in CODESYS on a 64-bit machine, which is what SIZEOF means to the author. Values lie
// otherwise here (bytecode/codegen/layout).
//
// In: a type. Out: bytes. Does not belong here: SIZEOF itself (frontend-st).
#pragma once

#include <cstdint>
#include <optional>

#include "ir/types.h"

namespace plc::ir {

/// Bytes of a value of `type`; nothing for what holds function block instances, stubs and arrays without bounds.
std::optional<std::uint64_t> foreign_size(const TypeTable& types, TypeRef type);
/// What such a value is aligned to, in bytes: 1, 2, 4 or 8.
std::optional<std::uint64_t> foreign_align(const TypeTable& types, TypeRef type);

/// Where a field of a structure, a member of a union or an element of an array, counted from 0, begins in `whole`.
std::optional<std::uint64_t> foreign_offset(const TypeTable& types, TypeRef whole, std::uint32_t part);

}  // namespace plc::ir
