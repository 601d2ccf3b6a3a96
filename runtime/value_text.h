// Values of leaves as text and back. Text is what runtime/access.h describes.
//
// In: a leaf type and bytes of its size, or text. Out: text, or normalised bytes. Does not belong here: where values
// live.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "bytecode/image.h"
#include "core/result.h"

namespace plc::runtime {

/// What numbers with a meaning of their own are written as.
enum class ValueStyle : std::uint8_t {
  kNumbers,  ///< for programs: enumerations as their number, durations and dates in ns
  kNames,    ///< for people: Filling, T#1s500ms, D#2024-02-29
};

/// Appends the value at `bytes` (of type.size bytes) of a scalar, string or reference.
void append_value(const bytecode::ImageType& type, const std::byte* bytes, std::string& out,
                  ValueStyle style = ValueStyle::kNumbers);
/// For lists and messages that people read: as in ValueStyle::kNames, and BOOL as TRUE and FALSE.
std::string shown_value(const bytecode::ImageType& type, const std::byte* bytes);

/// Stores the value that `text` stands for into `to` (type.size bytes): what append_value() writes in either style, and
/// numbers with a base (16#1F). P7103, P7104 or P7105 when there is none.
std::optional<core::Problem> parse_value(const bytecode::ImageType& type, std::string_view text,
                                         std::span<std::byte> to);

}  // namespace plc::runtime
