// Layout of one network of LD or FBD by rule.
//
// In: its elements, with sizes, and the wires that touch them. Out: places of the elements and lines of the wires. Does
// not belong here: rails, comments, the order of networks (lay_out_networks.cpp).
#pragma once

#include <cstdint>
#include <vector>

#include "drawings/sheet.h"

namespace plc::drawings {

/// Between vertical pieces of wires.
inline constexpr std::int32_t kTrack = 8;

struct PlacedNetwork {
  DrawnPoint corner;                ///< right lower one
  std::vector<std::uint32_t> open;  ///< wires that leave the network: their lines end in the last column
};

/// Lays the network out at `left`, `top`. Wires that come from outside, from a rail, begin at `left`.
PlacedNetwork lay_out_network(Sheet& sheet, std::vector<std::uint32_t> elements, std::vector<std::uint32_t> wires,
                              std::int32_t left, std::int32_t top);

/// Places the comments of a network below `top`; returns where what follows begins.
std::int32_t place_comments(Sheet& sheet, std::uint32_t network, std::int32_t top);

}  // namespace plc::drawings
