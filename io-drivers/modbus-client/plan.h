// plan(): which requests read or write the cells of a device: the fewest.
//
// In: where values lie, and how often each is wanted. Out: blocks, one request each; cells of different periods are in
// different blocks. Pure. Does not belong here: when a block is due (device.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/clock.h"
#include "io-drivers/modbus-client/frame.h"

namespace plc::modbus_client {

/// Cells of one value: they are never split.
struct Want {
  ModbusTable table = ModbusTable::kHoldingRegisters;
  std::uint16_t first = 0;
  std::uint16_t count = 1;
  core::TimeNs period_ns = 0;
};

struct Block {
  ModbusTable table = ModbusTable::kHoldingRegisters;
  std::uint16_t first = 0;
  std::uint16_t count = 0;
  core::TimeNs period_ns = 0;
  std::vector<std::uint32_t> wants;  ///< indices, by address
  bool gaps = false;                 ///< cells between those of wants are read too
};

struct Limits {
  std::uint16_t registers = kMaxReadRegisters;  ///< in one request
  std::uint16_t bits = kMaxReadBits;
  std::uint16_t gap = 0;  ///< registers between two values that are read along; of bits 16 times as many
};

/// Blocks by table, period and address. A value that is longer than the limit has a block of its own.
std::vector<Block> plan(std::span<const Want> wants, const Limits& limits);

}  // namespace plc::modbus_client
