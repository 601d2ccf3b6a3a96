// What every server tells of the plant itself, beside its variables: run and fault state, a pulse, time.
//
// In: SystemState of whoever runs the plant. Out: registers at fixed addresses; rows in system_points.def. Does not
// belong here: where the state comes from.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/types.h"

namespace plc::modbus {

enum class PlantState : std::uint16_t { kStarts, kRuns, kFaulted, kTaskStopped, kStops };

struct SystemState {
  PlantState state = PlantState::kStarts;
  std::uint16_t fault_code = 0;  ///< of the last fault, 1001 = R1001; 0 = none
  std::uint32_t faults = 0;
  std::uint32_t scans = 0;    ///< of the fastest task; wraps
  std::uint32_t seconds = 0;  ///< since the start
  std::uint16_t forced = 0;   ///< variables
};
/// Any thread.
using SystemSource = std::function<SystemState()>;

/// Behind the registers of %IL, before the automatic area.
inline constexpr std::uint16_t kSystemFirst = 8192;

struct SystemPoint {
  std::string_view name;
  core::TypeId type;
  std::uint16_t address;    ///< of the first input register
  std::uint16_t registers;  ///< 1 or 2
  std::string_view documentation;
  std::uint32_t (*value)(const SystemState&);
};
/// By address, without gaps.
std::span<const SystemPoint> system_points();
/// The first address behind them.
std::uint32_t system_end();

}  // namespace plc::modbus
