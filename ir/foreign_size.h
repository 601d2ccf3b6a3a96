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

}  // namespace plc::ir
