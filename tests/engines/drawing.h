// random_drawing: a PLCopen project with ladder and function block diagrams, made from a seed.
//
// In: a seed. Out: XML that the compiler accepts. Does not belong here: texts (tests/programs), what the drawing does.
#pragma once

#include <cstdint>
#include <string>

namespace plc::test {

std::string random_drawing(std::uint64_t seed);

}  // namespace plc::test
