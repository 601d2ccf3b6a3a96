// DriverType: a kind of driver, `kind` in plc.toml, as one row. Its folder has the row; a list names the rows
// (machine/driver_types.h), and nothing else knows which kinds there are.
//
// In: nothing but constants and functions of the kind's folder. Out: what the reader of plc.toml, bind(), `plc config`,
// the reference page and Machine ask. Does not belong here: what a driver does while it runs (driver.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "core/result.h"
#include "io-drivers/config/bind.h"
#include "io-drivers/config/keys.h"
#include "io-drivers/driver.h"

namespace plc::io {

class Findings;

/// All functions run before tasks do; they may allocate, and touch no device. Those that are null have nothing to say.
struct DriverType {
  std::string_view name;     ///< what `kind` says: "gpio"
  std::string_view summary;  ///< what it is, after "gpio: "; a sentence
  std::string_view example;  ///< NAME of the driver of this kind that `plc config init` writes
  bool real = true;          ///< there is a device: not with --simulate-io

  /// The keys it has beside those of every kind. "channel" is one of channel_keys, if its channels have names.
  std::span<const KeyInfo> driver_keys = {};
  std::span<const KeyInfo> channel_keys = {};
  std::string_view device_key = {};  ///< the one of driver_keys that says which device: problems are reported there
  /// Those of its problems that another start may not find, though nobody changes the configuration: a device that is
  /// missing or in use.
  std::span<const core::Code> device_problems = {};

  /// What does not go together in plc.toml: for each driver of the kind, with its channels in the order of the file.
  void (*check)(const DriverConfig& driver, std::span<const ChannelConfig* const> channels,
                Findings& findings) = nullptr;
  /// "line 17 of gpiochip0": the same for all that mean the same; two channels with one name are P7310. Empty: while
  /// what it consists of is missing.
  std::string (*channel_name)(const DriverConfig& driver, const ChannelConfig& channel) = nullptr;
  /// Why a variable of this type cannot be on such a channel ("a GPIO line is a BOOL"), which is P7322; empty if it
  /// can.
  std::string_view (*refuses)(const KeyValues& channel, const bytecode::ImageType& type) = nullptr;
  /// Problems of files that plc.toml names, for `plc config check`; Driver::check() finds them again.
  std::optional<core::Problem> (*check_files)(const BoundDriver& bound, const Configuration& configuration,
                                              runtime::Resource& resource) = nullptr;
  /// Whether the device is there and gives this process what its channels need, as far as one can tell without touching
  /// it: for `plc doctor`, which may know no project. Driver::check() finds the same again.
  std::optional<core::Problem> (*check_device)(const DriverConfig& driver, std::span<const ChannelConfig* const> inputs,
                                               std::span<const ChannelConfig* const> outputs) = nullptr;
  /// The keys of a channel for a variable of this type, which the kind does not refuse, in the file of `plc config
  /// init`: "channel = 17". `next` is 0 at first, and the kind's to count with. Nothing: there are no more channels.
  /// Null: channels need no keys.
  std::optional<std::string> (*example_channel)(const bytecode::ImageType& type, std::uint32_t& next) = nullptr;
  /// Never null. The driver may keep what it is given; it claims its inputs in the resource's global table.
  std::unique_ptr<Driver> (*make)(const BoundDriver& bound, const Configuration& configuration,
                                  runtime::Resource& resource) = nullptr;
};

}  // namespace plc::io
