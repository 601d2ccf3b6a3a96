// Names of places: "Motor.speed", "line[3].count", "GVL.start", and back.
//
// In: an image, verified or not. Out: offset and type of a named place. Names compare without letter case. For
// configuration, drivers, the debugger and the listing. Does not belong here: what may be done at the place.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "bytecode/image.h"

namespace plc::bytecode {

struct NamedPlace {
  std::uint32_t offset = 0;
  std::uint32_t type = 0;
};
/// The value at `path` inside structure `type`; array indices as declared.
std::optional<NamedPlace> find_path(const Image& image, std::uint32_t type, std::string_view path);
/// The value at `path` of the global table; the first name may be qualified by its list ("GVL.x"). An unqualified name
/// that several lists have is the first of them.
std::optional<NamedPlace> find_global(const Image& image, std::string_view path);

}  // namespace plc::bytecode
