// What holds of every drawing, whoever laid it out.
//
// In: bodies of bytecode::Drawings. Out: what is wrong, as text; empty when nothing is. Does not belong here:
// particular drawings.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/drawings.h"

namespace plc::test {

using namespace bytecode;

inline std::string named(const DrawnBody& body, const DrawnElement& e) {
  return fmt::format("{} {} {} \"{}\" at {},{} {}x{}", body.name, core::element_word(e.kind), e.local_id, e.text, e.x,
                     e.y, e.width, e.height);
}

inline bool overlap(const DrawnElement& a, const DrawnElement& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

inline bool on_border(const DrawnElement& e, DrawnPoint at) {
  const bool inside = at.x >= e.x && at.x <= e.x + e.width && at.y >= e.y && at.y <= e.y + e.height;
  return inside && (at.x == e.x || at.x == e.x + e.width || at.y == e.y || at.y == e.y + e.height);
}

/// No two elements overlap, every wire begins and ends at its pins, which lie on their elements, nothing is left of or
/// above the paper.
inline std::string wrong_with(const DrawnBody& body) {
  for (std::size_t i = 0; i < body.elements.size(); ++i) {
    const DrawnElement& e = body.elements[i];
    if (e.x < 0 || e.y < 0 || e.width <= 0 || e.height <= 0) return named(body, e) + " lies outside, or has no size";
    for (std::size_t j = 0; j < i; ++j) {
      if (overlap(e, body.elements[j])) return named(body, e) + " covers " + named(body, body.elements[j]);
    }
  }
  for (const DrawnWire& wire : body.wires) {
    const DrawnElement& from = body.elements.at(wire.from);
    const DrawnElement& to = body.elements.at(wire.to);
    const std::string which = "wire from " + named(body, from) + " to " + named(body, to);
    const DrawnPoint begin = from.pins.at(wire.from_pin).at, end = to.pins.at(wire.to_pin).at;
    if (!from.pins[wire.from_pin].output || to.pins[wire.to_pin].output) return which + " joins the wrong pins";
    if (wire.points.size() < 2) return which + " has no line";
    if (!(wire.points.front() == begin) || !(wire.points.back() == end)) return which + " does not end at its pins";
    if (!on_border(from, begin)) return which + fmt::format(" begins off the border, at {},{}", begin.x, begin.y);
    if (!on_border(to, end)) return which + fmt::format(" ends off the border, at {},{}", end.x, end.y);
  }
  return {};
}

/// A piece of a line crosses the inside of an element.
inline bool crosses(DrawnPoint a, DrawnPoint b, const DrawnElement& e) {
  return std::min(a.x, b.x) < e.x + e.width && std::max(a.x, b.x) > e.x && std::min(a.y, b.y) < e.y + e.height &&
         std::max(a.y, b.y) > e.y;
}

/// Of what is laid out by rule, besides: lines are level or upright, and none crosses an element.
inline std::string wrong_with_lines(const DrawnBody& body) {
  for (const DrawnWire& wire : body.wires) {
    const std::string which =
        "wire from " + named(body, body.elements[wire.from]) + " to " + named(body, body.elements[wire.to]);
    for (std::size_t i = 1; i < wire.points.size(); ++i) {
      const DrawnPoint a = wire.points[i - 1], b = wire.points[i];
      if (a.x != b.x && a.y != b.y) return which + fmt::format(" is aslant at {},{}", a.x, a.y);
      for (const DrawnElement& e : body.elements) {
        if (crosses(a, b, e)) return which + " crosses " + named(body, e);
      }
    }
  }
  return {};
}

/// Lines of different outputs lie on each other for some way.
inline std::string wires_on_each_other(const DrawnBody& body) {
  struct Piece {
    std::int32_t at, from, to;
    std::pair<std::uint32_t, std::uint16_t> source;
    std::uint32_t target;
  };
  std::map<std::pair<std::uint32_t, std::uint16_t>, std::set<std::pair<std::uint32_t, std::uint32_t>>> targets;
  for (const DrawnWire& wire : body.wires) {
    targets[{wire.from, body.elements[wire.from].pins[wire.from_pin].pin}].insert({wire.to, wire.to_pin});
  }
  /// Outputs that meet at an input, as an OR.
  const auto meet = [&](const Piece& a, const Piece& b) {
    const auto& others = targets[b.source];
    return std::any_of(targets[a.source].begin(), targets[a.source].end(),
                       [&](const auto& target) { return others.contains(target); });
  };
  std::map<bool, std::vector<Piece>> pieces;
  for (const DrawnWire& wire : body.wires) {
    const DrawnElement& e = body.elements[wire.from];
    for (std::size_t i = 1; i < wire.points.size(); ++i) {
      const DrawnPoint a = wire.points[i - 1], b = wire.points[i];
      const bool level = a.y == b.y;
      pieces[level].push_back({level ? a.y : a.x,
                               level ? std::min(a.x, b.x) : std::min(a.y, b.y),
                               level ? std::max(a.x, b.x) : std::max(a.y, b.y),
                               {wire.from, e.pins[wire.from_pin].pin},
                               wire.to});
    }
  }
  for (auto& [level, all] : pieces) {
    std::sort(all.begin(), all.end(),
              [](const Piece& a, const Piece& b) { return std::pair(a.at, a.from) < std::pair(b.at, b.from); });
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t j = i + 1; j < all.size() && all[j].at == all[i].at && all[j].from < all[i].to; ++j) {
        if (all[i].source == all[j].source || meet(all[i], all[j])) continue;
        return fmt::format("{}: wires to {} and {} lie on each other at {}", body.name,
                           named(body, body.elements[all[i].target]), named(body, body.elements[all[j].target]),
                           all[i].at);
      }
    }
  }
  return {};
}

}  // namespace plc::test
