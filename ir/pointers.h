// Pointers computed with: what converts to and from POINTER TO, and what + and - of them are. Typed helpers of the
// builder, as in convert.h.
//
// In: operands, one of which is a pointer. Out: values; P4206 and P4207 where nothing fits. Does not belong here: names
// and syntax (frontend-st/lower_pointer.cpp), what is checked while a program runs (runtime/pointers/).
#pragma once

#include <cstdint>
#include <optional>

#include "ir/convert.h"

namespace plc::ir {

/// Whether the operand is a value of a pointer type.
bool is_pointer(Builder& builder, const Operand& operand);

/// Builder::convert() where the operand, or `to`, is a pointer: pointers become pointers to anything and numbers of 64
/// bits; UDINT and DWORD hold the 32-bit address of a pointer, with a note.
std::optional<ValueId> convert_pointer(Builder& builder, const Operand& operand, TypeRef to, const What& what);

/// `pointer` moved by `bytes`, an integer of any type, or back by it.
std::optional<ValueId> move_pointer(Builder& builder, ValueId pointer, const Operand& bytes, bool back);
/// `pointer` moved by `index` times `size` bytes.
std::optional<ValueId> index_pointer(Builder& builder, ValueId pointer, const Operand& index, std::uint64_t size);
/// The bytes from `b` to `a`, pointers both: a LINT that goes where a DINT may go.
ValueId pointer_distance(Builder& builder, ValueId a, ValueId b);
/// `function` (EQ, NE, LT, LE, GT, GE) of two operands, one of which is a pointer: addresses are compared.
std::optional<ValueId> compare_pointers(Builder& builder, std::string_view function, const Operand& a,
                                        const Operand& b);

}  // namespace plc::ir
