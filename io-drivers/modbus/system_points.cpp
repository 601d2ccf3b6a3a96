#include "io-drivers/modbus/system_points.h"

#include <array>

namespace plc::modbus {
namespace {

constexpr SystemPoint kRows[] = {
#define PLC_MODBUS_SYSTEM(name, type, member, documentation) \
  {name, core::TypeId::type, 0,                              \
   0,    documentation,      [](const SystemState& s) { return static_cast<std::uint32_t>(s.member); }},
#include "io-drivers/modbus/system_points.def"
};

constexpr auto kPoints = [] {
  std::array<SystemPoint, std::size(kRows)> points{};
  std::uint16_t next = kSystemFirst;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = kRows[i];
    points[i].address = next;
    points[i].registers = points[i].type == core::TypeId::kUdint ? 2 : 1;
    next = static_cast<std::uint16_t>(next + points[i].registers);
  }
  return points;
}();

}  // namespace

std::span<const SystemPoint> system_points() { return kPoints; }

std::uint32_t system_end() { return kPoints.back().address + std::uint32_t{kPoints.back().registers}; }

}  // namespace plc::modbus
