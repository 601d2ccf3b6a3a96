// DrawnPlace: an element or a line of a drawing, as clients are told where it is.
//
// Threads: any. Does not belong here: pixels.
#pragma once

#include <cstdint>
#include <string>

#include "engineering/call.h"
#include "engineering/diagrams.h"

namespace plc::engineering {

extern const Record kDrawnPlace;

inline constexpr std::uint32_t kNoElement = 0xffffffffu;
/// `element`: kNoElement of a text, where `line` counts; `text`: what stands there.
Json place_json(const DrawnPou& pou, std::size_t body, std::uint32_t element, std::uint32_t line,
                const std::string& text);

}  // namespace plc::engineering
