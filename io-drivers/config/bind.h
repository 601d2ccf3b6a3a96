// bind(): a configuration against a loaded project: every variable becomes a place in the global table.
//
// In: Configuration, Resource. Out: per driver its channels with offsets, types and values as bytes; or diagnostics
// (P73xx) with the place in plc.toml: unknown variable, not a BOOL where the driver has lines, an input that a program
// writes, an output that nothing writes, unmapped %Q (warning), two keys for one variable. Nothing is opened here.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "io-drivers/config/configuration.h"
#include "runtime/resource.h"

namespace plc::io {

inline bool is_bool(const bytecode::ImageType& type) {
  return type.kind == bytecode::TypeKind::kScalar && type.elementary == core::TypeId::kBool;
}

/// One variable and its channel.
struct BoundChannel {
  const ChannelConfig* config = nullptr;  ///< null for BoundDriver::ok
  std::uint32_t field = 0;                ///< of Image::global_type
  std::uint32_t offset = 0;               ///< of the leaf, in the global table
  std::uint32_t type = 0;                 ///< of the leaf
  std::vector<std::byte> safe;  ///< outputs: as many bytes as the type has, as the program means them (before invert)
  std::vector<std::byte> initial;  ///< outputs
};

struct BoundDriver {
  const DriverConfig* config = nullptr;
  std::uint32_t task = 0;  ///< index into Image::tasks
  std::vector<BoundChannel> inputs;
  std::vector<BoundChannel> outputs;
  std::optional<BoundChannel> ok;  ///< DriverConfig::ok; also claimed as an input
};

/// Points into the configuration, which must outlive it.
struct Binding {
  std::vector<BoundDriver> drivers;         ///< in the order of the file; those without channels as well
  std::optional<BoundChannel> client_seen;  ///< ModbusConfig::client_seen; an input of the server (config is null)
};

/// The fields that the driver, or drivers and the server, own while they run, ascending: Modbus clients cannot write
/// them.
std::vector<std::uint32_t> claimed_fields(const BoundDriver& driver);
std::vector<std::uint32_t> claimed_fields(const Binding& binding);

/// The task that a driver serves when it names none: the one with the shortest interval.
std::uint32_t fastest_task(const bytecode::Image& image);

/// Changes nothing in the resource. `diagnostics` is the one the configuration was read with: places name its files.
std::optional<Binding> bind(const Configuration& configuration, runtime::Resource& resource,
                            core::Diagnostics& diagnostics);

}  // namespace plc::io
