// kind = "ads1115": four analog inputs of an ADS1115 on an I2C bus, as many hats have it.
//
// In: a bus (/dev/i2c-1), the address of the chip. Out: volts. Each read() converts the channels that are used, one
// after the other, at 860 samples a second: 1.3 ms for each. Chip: Texas Instruments SBAS444.
#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "picard/driver.h"

namespace {

constexpr picard_key kDriverKeys[] = {
    picard::text("bus", nullptr, "Device file of the I2C bus.", "\"/dev/i2c-1\""),
    picard::integer("address", 0x48, 0x4b, "72", "Address of the chip: 72 (16#48) to 75, as its pin ADDR is wired."),
    picard::choice("range", "6.144|4.096|2.048|1.024|0.512|0.256", "\"4.096\"",
                   "Greatest voltage between input and ground; no input may have more than the supply."),
};
enum DriverKey { kBus, kAddress, kRange };
constexpr picard_key kChannelKeys[] = {
    picard::integer("channel", 0, 3, nullptr, "Input AIN0 to AIN3, against ground.", "0", PICARD_INPUTS),
};

class Ads1115 final : public picard::Driver {
 public:
  static constexpr picard::DriverInfo info{.name = "ads1115",
                                           .summary = "four analog inputs of an ADS1115 on an I2C bus, in volts.",
                                           .example = "analog",
                                           .device = "bus",
                                           .driver_keys = kDriverKeys,
                                           .channel_keys = kChannelKeys};

  explicit Ads1115(const picard::DriverConfig& config)
      : bus_(config.settings[kBus].text),
        address_(static_cast<std::uint16_t>(config.settings[kAddress].number)),
        range_(static_cast<unsigned>(config.settings[kRange].number)) {
    if (config.output_count != 0) throw picard::Failure("an ADS1115 has inputs alone");
    for (std::uint32_t i = 0; i < config.input_count; ++i)
      channels_.push_back(static_cast<unsigned>(config.inputs[i].settings[0].number));
  }

  void open() override {
    fd_ = ::open(bus_.c_str(), O_RDWR | O_CLOEXEC);
    if (fd_ < 0) throw picard::Failure::format("%s: %s", bus_.c_str(), std::strerror(errno));
    static_cast<void>(get(kConfig));  // a chip that is not there does not acknowledge
  }

  void read(std::span<double> inputs) override {
    constexpr double kVolts[] = {6.144, 4.096, 2.048, 1.024, 0.512, 0.256};
    for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i] = convert(channels_[i]) * kVolts[range_] / 32768.0;
  }

  void close() noexcept override {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  enum Register : std::uint8_t { kConversion = 0, kConfig = 1 };

  /// One conversion of an input against ground, signed, of 16 bits.
  [[nodiscard]] std::int16_t convert(unsigned channel) const {
    constexpr unsigned kReady = 0x8000, kSingle = 0x0100, kFastest = 0x00e0, kNoAlert = 0x0003;
    put(kConfig,
        static_cast<std::uint16_t>(kReady | (4 + channel) << 12 | range_ << 9 | kSingle | kFastest | kNoAlert));
    for (int tries = 0; tries < 10; ++tries) {
      std::this_thread::sleep_for(std::chrono::microseconds(1300));
      if ((get(kConfig) & kReady) != 0) return static_cast<std::int16_t>(get(kConversion));
    }
    throw picard::Failure("the conversion comes to no end");
  }

  void transfer(i2c_msg* messages, std::uint32_t count) const {
    i2c_rdwr_ioctl_data data{messages, count};
    if (::ioctl(fd_, I2C_RDWR, &data) < 0)
      throw picard::Failure::format("%s, address %d: %s", bus_.c_str(), address_, std::strerror(errno));
  }
  void put(Register at, std::uint16_t value) const {
    std::uint8_t bytes[] = {at, static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
    i2c_msg message{address_, 0, sizeof bytes, bytes};
    transfer(&message, 1);
  }
  [[nodiscard]] std::uint16_t get(Register at) const {
    std::uint8_t pointer[] = {at};
    std::uint8_t bytes[2]{};
    i2c_msg messages[] = {{address_, 0, sizeof pointer, pointer}, {address_, I2C_M_RD, sizeof bytes, bytes}};
    transfer(messages, 2);
    return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
  }

  std::string bus_;
  std::uint16_t address_;
  unsigned range_;  ///< position in the choices, which is that of the chip, too
  std::vector<unsigned> channels_;
  int fd_ = -1;
};

}  // namespace

PICARD_DRIVER_LIBRARY("ads1115", "1.0.0", Ads1115)
