// Values of variables as JSON and back.
//
// BOOL: true, false. Numbers of up to 32 bits and reals: numbers; of 64 bits: texts, since JavaScript has no such
// numbers. REAL and LREAL without a number: "NaN", "Infinity", "-Infinity". STRING, WSTRING, CHAR, WCHAR: texts.
// Enumerations: the name of the member. Times and dates: literals of IEC 61131-3, "T#1s500ms". Arrays and structures:
// arrays and objects. References: null. Does not belong here: where values live (value_source.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/result.h"
#include "engineering/call.h"

namespace plc::engineering {

/// "BOOL", "STRING[20]", "ARRAY [1..3] OF INT", or the name of a declared type.
std::string type_name(const bytecode::Image& image, std::uint32_t type);
/// Scalars and strings in a value of this type.
std::uint64_t leaf_count(const bytecode::Image& image, std::uint32_t type);

/// The value of type.size bytes at `bytes`.
Json value_json(const bytecode::Image& image, std::uint32_t type, const std::byte* bytes);

/// One scalar or string of a value.
struct LeafValue {
  std::uint32_t offset = 0;  ///< from the start of the value
  std::uint32_t type = 0;
  std::vector<std::byte> bytes;
};
/// The leaves that `value` names: all of an array, those fields of a structure that are there. P7102 when the form is
/// another, P7103 to P7105 when a leaf cannot have the value; `field` is where in `value`, ".x[2]".
std::optional<core::Problem> leaves_of(const bytecode::Image& image, std::uint32_t type, const Json& value,
                                       std::uint32_t offset, std::vector<LeafValue>& leaves, std::string& field);

}  // namespace plc::engineering
