// Carrying values over from what a program kept to what the present one keeps, by names and types.
//
// In: two layouts, the stored values, the initial ones. Out: the initial values with what fits in place, and what does
// not, in sentences. A variable keeps its value when it has the same path and a type that can hold it: structures field
// by field, arrays by index, integers and reals where the value is in range, texts where there is room, enumerations by
// the name of the member. What is ImageField::internal goes with the same program only. Values are normalised, so what
// a file holds can be run. Does not belong here: where values come from and go to.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "retain/layout.h"

namespace plc::retain {

/// What happened to the stored variables.
struct Carried {
  std::size_t kept = 0;              ///< stored variables of which something was taken
  std::vector<std::string> misfits;  ///< "Main.Count: 70000 is outside of INT", in the order of the file
  bool same_program = false;
};

/// `from` has old.bytes, `to` now.bytes and holds initial values.
Carried carry_over(const Layout& old, std::span<const std::byte> from, const Layout& now, std::span<std::byte> to,
                   Start start);

/// The words for a type: "INT", "STRING[20]", "ARRAY [1..3] OF REAL", the name of a structure.
std::string type_text(const std::vector<bytecode::ImageType>& types, std::uint32_t index);

}  // namespace plc::retain
