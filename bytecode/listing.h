// What the listing and the assembler share: words of the text form, names of places, default values.
//
// The text form is line by line; ';' starts a comment outside quotes (docs/reference/assembler.md). Internal to
// bytecode/disassemble.cpp and bytecode/assemble.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "bytecode/image.h"

namespace plc::bytecode::listing {

inline constexpr std::array<std::string_view, 9> kRoles = {"member", "input",  "output", "inout", "local",
                                                           "temp",   "return", "hidden", "state"};
inline constexpr std::array<std::string_view, 4> kPouKinds = {"program", "block", "function", "task"};
/// First letters of operands, by Space: globals, instance, frame, constants.
inline constexpr std::array<char, 4> kSpaces = {'g', 'i', 'f', 'c'};

/// Paths inside structures, exact in letter case: "motor.speed", "line[2].count" (array indices from 0). Only names of
/// letters, digits, '_' and '#' that are the first of their structure appear in paths; other places go by offset.
class Names {
 public:
  explicit Names(const Image& image) : image_(image) {}
  /// Path to the leaf, or to the value of type `wanted` if that comes first, at `offset` of structure `type`.
  std::optional<std::string> path(std::uint32_t type, std::uint32_t offset, std::uint32_t wanted);
  struct Place {
    std::uint32_t offset = 0;
    std::uint32_t type = 0;
  };
  std::optional<Place> find(std::uint32_t type, std::string_view path);

 private:
  using Index = std::unordered_map<std::string_view, std::uint32_t>;
  const Index& index_of(std::uint32_t type);
  const Image& image_;
  std::unordered_map<std::uint32_t, Index> indices_;
};

/// Zeros with the capacities of strings in place; nothing when the type does not make sense.
std::optional<std::vector<std::byte>> default_bytes(const Image& image, std::uint32_t type);

/// Text in double quotes; quotes, backslashes and control characters as \xx.
std::string quoted(std::string_view text);
/// The text inside the quotes of quoted(); nothing when it is no such text.
std::optional<std::string> unquoted(std::string_view text);

}  // namespace plc::bytecode::listing
