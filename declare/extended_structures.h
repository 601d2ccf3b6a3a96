// Structures that extend others (CODESYS, TwinCAT): `TYPE Pump EXTENDS Device : STRUCT ..` gets the members of Device
// before its own.
//
// In: a Project as it was read, libraries joined; a structure names in TypeSpec::base what it extends. Out: the same
// with all members in each structure. Does not belong here: types of members, inheritance of function blocks.
#pragma once

#include <cstddef>

#include "plcopen/project.h"

namespace plc::st {

/// Members and values that all structures together may get: a chain of thousands would have members by the square of
/// its length.
inline constexpr std::size_t kMaxJoined = 1'000'000;

/// Gives each structure the members of the one that it extends. Where that is no structure, is not there, or extends
/// the first one in turn, or where all structures together would get more than `limit` members and values in this way,
/// TypeSpec::base stays, which st::declare reports. Members of members count, and long texts as several.
void join_extended_structures(plcopen::Project& project, std::size_t limit = kMaxJoined);

}  // namespace plc::st
