// Direct addresses: "%IX0.0", "%I0.0", "%MW3", "%IW0.0.1.0", "%I*" -> parts and one normal spelling.
//
// In: text as written. Out: Address. Does not belong here: which variable has the address, where the byte lies.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"

namespace plc::st {

struct Address {
  char area = 'I';                  ///< 'I', 'Q' or 'M'
  char size = 'X';                  ///< 'X', 'B', 'W', 'D' or 'L'; 'X' when no letter is written
  bool unlocated = false;           ///< "%I*": the machine's configuration binds it by name
  std::vector<std::uint32_t> path;  ///< at least one number unless unlocated

  /// "%IX0.0": upper case, size letter present, no leading zeros. Equal addresses have equal texts.
  [[nodiscard]] std::string text() const;
  /// Bits of one location of this size: 1, 8, 16, 32 or 64.
  [[nodiscard]] std::uint32_t bits() const;
  /// The type a location has when only its address is written: BOOL, BYTE, WORD, DWORD or LWORD.
  [[nodiscard]] core::TypeId type() const;
};

/// Nothing, and why in `problem`, when the text is no address.
std::optional<Address> parse_address(std::string_view text, std::string& problem);

}  // namespace plc::st
