// The only header a driver needs that comes from outside of PICARD: write a class, name its keys, list it in
// PICARD_DRIVER_LIBRARY.
//
//   class Ramp final : public picard::Driver {
//    public:
//     static constexpr picard_key kKeys[] = {picard::integer("step", 1, 100, "1", "How far it goes each time.")};
//     static constexpr picard_key kChannelKeys[] = {picard::integer("channel", 0, 3, nullptr, "Number of the ramp.")};
//     static constexpr picard::DriverInfo info{.name = "ramp", .summary = "rising numbers.", .example = "ramp",
//                                              .driver_keys = kKeys, .channel_keys = kChannelKeys};
//     explicit Ramp(const picard::DriverConfig& config) : step_(config.settings[0].number) {}
//     void open() override {}                                  // throws picard::Failure when the device is not there
//     void read(std::span<double> inputs) override { for (double& input : inputs) input = value_ += step_; }
//     void close() noexcept override {}
//   ...
//   PICARD_DRIVER_LIBRARY("ramp", "1.0.0", Ramp)
//
// The runtime calls an object on a thread of its own, every `poll`: read(), then write() with the outputs of the newest
// complete scan. It converts numbers to the types of variables, holds or clears inputs of a lost device, opens it again
// every `retry`, and drives safe values. A function that throws picard::Failure, or anything else, has failed. In:
// nothing of PICARD but driver_abi.h and taskblock.h. Does not belong here: components that programs call
// (taskblock.h).
#pragma once

#include <cstdint>
#include <exception>
#include <span>
#include <string_view>

#include "picard/driver_abi.h"
#include "picard/taskblock.h"

namespace picard {

using DriverConfig = picard_driver_config;

struct DriverInfo {
  const char* name = "";     ///< what `kind` in plc.toml says
  const char* summary = "";  ///< one sentence
  const char* example = "";  ///< NAME of the driver that `plc config init` writes
  const char* device = "";   ///< the driver key that says which device, or none
  std::span<const picard_key> driver_keys{};
  std::span<const picard_key> channel_keys{};
};

/// Keys. `otherwise`: the value without the key, as TOML writes it ("\"fast\""); null: the key is required.
constexpr picard_key boolean(const char* name, const char* otherwise, const char* documentation,
                             std::uint32_t applies = PICARD_BOTH) {
  return {name, PICARD_KEY_BOOLEAN, applies, 0, 0, "", "", "", otherwise, "true", documentation};
}
constexpr picard_key integer(const char* name, std::int64_t lowest, std::int64_t highest, const char* otherwise,
                             const char* documentation, const char* example = "0",
                             std::uint32_t applies = PICARD_BOTH) {
  return {name, PICARD_KEY_INTEGER, applies, lowest, highest, "", "", "", otherwise, example, documentation};
}
constexpr picard_key text(const char* name, const char* otherwise, const char* documentation,
                          const char* example = "\"\"", std::uint32_t applies = PICARD_BOTH) {
  return {name, PICARD_KEY_TEXT, applies, 0, 0, "", "", "", otherwise, example, documentation};
}
constexpr picard_key choice(const char* name, const char* choices, const char* otherwise, const char* documentation,
                            const char* example = "", std::uint32_t applies = PICARD_BOTH) {
  return {name, PICARD_KEY_CHOICE, applies, 0, 0, choices, "", "", otherwise, example, documentation};
}
constexpr picard_key duration(const char* name, const char* shortest, const char* longest, const char* otherwise,
                              const char* documentation, const char* example = "\"1s\"",
                              std::uint32_t applies = PICARD_BOTH) {
  return {name, PICARD_KEY_DURATION, applies, 0, 0, "", shortest, longest, otherwise, example, documentation};
}

class Driver {
 public:
  Driver() = default;
  virtual ~Driver() = default;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Takes the device.
  virtual void open() = 0;
  /// All inputs, in the order of the configuration.
  virtual void read(std::span<double> /*inputs*/) {}
  /// All outputs.
  virtual void write(std::span<const double> /*outputs*/) {}
  /// Gives the device back, also after an open() that threw.
  virtual void close() noexcept = 0;
};

namespace detail {

/// An object and what the C side does not know of it.
template <class Kind>
struct DriverObject {
  explicit DriverObject(const DriverConfig& given) : config(given), driver(given) {}
  const DriverConfig& config;
  Kind driver;
};

template <class Kind>
constexpr picard_driver_kind driver_kind() {
  using Object = DriverObject<Kind>;
  const DriverInfo& info = Kind::info;
  return {info.name,
          info.summary,
          info.example,
          info.device,
          info.driver_keys.data(),
          static_cast<std::uint32_t>(info.driver_keys.size()),
          info.channel_keys.data(),
          static_cast<std::uint32_t>(info.channel_keys.size()),
          [](const picard_driver_config* config, picard_failure* failure) -> void* {
            Object* made = nullptr;
            contained(failure, [&] { made = new Object(*config); });
            return made;
          },
          [](void* object, picard_failure* failure) -> int {
            return contained(failure, [object] { static_cast<Object*>(object)->driver.open(); }) ? 1 : 0;
          },
          [](void* object, double* values, picard_failure* failure) -> int {
            auto& self = *static_cast<Object*>(object);
            return contained(failure, [&] { self.driver.read({values, self.config.input_count}); }) ? 1 : 0;
          },
          [](void* object, const double* values, picard_failure* failure) -> int {
            auto& self = *static_cast<Object*>(object);
            return contained(failure, [&] { self.driver.write({values, self.config.output_count}); }) ? 1 : 0;
          },
          [](void* object) { static_cast<Object*>(object)->driver.close(); },
          [](void* object) { delete static_cast<Object*>(object); }};
}

}  // namespace detail
}  // namespace picard

/// Once in a library, outside of namespaces: its name, its version, its classes.
#define PICARD_DRIVER_LIBRARY(library_name, library_version, ...)                                                 \
  extern "C" __attribute__((visibility("default"))) const picard_driver_library* picard_driver_library_v1(void) { \
    return picard::detail::driver_library<__VA_ARGS__>(library_name, library_version);                            \
  }

namespace picard::detail {

template <class... Kind>
PICARD_HIDDEN const picard_driver_library* driver_library(const char* name, const char* version) noexcept {
  static const picard_driver_kind kinds[] = {driver_kind<Kind>()...};
  static const picard_driver_library library{
      PICARD_DRIVER_ABI_VERSION, sizeof(picard_driver_kind), sizeof(picard_key), sizeof...(Kind), kinds, name, version};
  return &library;
}

}  // namespace picard::detail
