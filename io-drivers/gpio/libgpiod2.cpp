// libgpiod 2 (uAPI v2).
#include <fcntl.h>
#include <gpiod.h>

#include <array>
#include <cerrno>

#include "io-drivers/gpio/gpio_chip.h"

namespace plc::io {
namespace {

/// The kernel keeps this many events of a request of one line; one read takes them all.
constexpr std::size_t kEventsKept = 16;

template <auto kFree>
struct Free {
  template <class T>
  void operator()(T* thing) const {
    kFree(thing);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using Settings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using Events = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

gpiod_line_value value_of(std::uint8_t value) {
  return value != 0 ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

/// False with errno.
bool set(gpiod_line_settings* to, const LineSettings& from) {
  constexpr gpiod_line_bias kBias[] = {GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_DISABLED, GPIOD_LINE_BIAS_PULL_UP,
                                       GPIOD_LINE_BIAS_PULL_DOWN};
  constexpr gpiod_line_drive kDrive[] = {GPIOD_LINE_DRIVE_PUSH_PULL, GPIOD_LINE_DRIVE_OPEN_DRAIN,
                                         GPIOD_LINE_DRIVE_OPEN_SOURCE};
  constexpr gpiod_line_edge kEdge[] = {GPIOD_LINE_EDGE_NONE, GPIOD_LINE_EDGE_RISING, GPIOD_LINE_EDGE_FALLING};
  gpiod_line_settings_set_active_low(to, from.active_low);
  return gpiod_line_settings_set_direction(
             to, from.output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT) == 0 &&
         gpiod_line_settings_set_bias(to, kBias[static_cast<std::size_t>(from.bias)]) == 0 &&
         gpiod_line_settings_set_edge_detection(to, kEdge[static_cast<std::size_t>(from.edge)]) == 0 &&
         (!from.output || gpiod_line_settings_set_drive(to, kDrive[static_cast<std::size_t>(from.drive)]) == 0);
}

class Group final : public LineGroup {
 public:
  Group(Request request, Events events) : request_(std::move(request)), events_(std::move(events)) {}

  // RT:
  int read(std::span<std::uint8_t> values) noexcept override {
    std::array<gpiod_line_value, kMostLinesPerGroup> wide;
    if (gpiod_line_request_get_values(request_.get(), wide.data()) != 0) return errno;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = wide[i] == GPIOD_LINE_VALUE_ACTIVE ? 1 : 0;
    return 0;
  }
  // RT:
  int write(std::span<const std::uint8_t> values) noexcept override {
    std::array<gpiod_line_value, kMostLinesPerGroup> wide;
    for (std::size_t i = 0; i < values.size(); ++i) wide[i] = value_of(values[i]);
    return gpiod_line_request_set_values(request_.get(), wide.data()) == 0 ? 0 : errno;
  }
  // RT:
  core::TimeNs take_edges() noexcept override {
    const int count = gpiod_line_request_read_edge_events(request_.get(), events_.get(), kEventsKept);
    if (count <= 0) return count == 0 || errno == EAGAIN ? 0 : -errno;
    gpiod_edge_event* const newest =
        gpiod_edge_event_buffer_get_event(events_.get(), static_cast<unsigned long>(count) - 1);
    return static_cast<core::TimeNs>(gpiod_edge_event_get_timestamp_ns(newest));
  }

 private:
  Request request_;
  Events events_;  ///< with an edge
};

class Chip2 final : public GpioChip {
 public:
  Chip2(Chip chip, ChipInfo info) : chip_(std::move(chip)), info_(std::move(info)) {}
  [[nodiscard]] std::string name() const override { return gpiod_chip_info_get_name(info_.get()); }
  [[nodiscard]] std::string label() const override { return gpiod_chip_info_get_label(info_.get()); }
  [[nodiscard]] unsigned line_count() const override {
    return static_cast<unsigned>(gpiod_chip_info_get_num_lines(info_.get()));
  }
  [[nodiscard]] std::optional<LineFacts> facts(unsigned line) noexcept override {
    const LineInfo info(gpiod_chip_get_line_info(chip_.get(), line));
    if (info == nullptr) return std::nullopt;
    const auto text = [](const char* value) { return value == nullptr ? std::string() : std::string(value); };
    return LineFacts{text(gpiod_line_info_get_name(info.get())), text(gpiod_line_info_get_consumer(info.get())),
                     gpiod_line_info_is_used(info.get())};
  }
  std::unique_ptr<LineGroup> request(const LineSettings& settings, std::span<const unsigned> lines,
                                     std::span<const std::uint8_t> initial) override {
    const Settings all(gpiod_line_settings_new());
    const LineConfig config(gpiod_line_config_new());
    const RequestConfig user(gpiod_request_config_new());
    Events events(settings.edge == LineEdge::kNone ? nullptr : gpiod_edge_event_buffer_new(kEventsKept));
    if (all == nullptr || config == nullptr || user == nullptr || !set(all.get(), settings)) return nullptr;
    if (settings.edge != LineEdge::kNone && events == nullptr) return nullptr;
    gpiod_request_config_set_consumer(user.get(), kGpioConsumer);
    if (gpiod_line_config_add_line_settings(config.get(), lines.data(), lines.size(), all.get()) != 0) return nullptr;
    std::array<gpiod_line_value, kMostLinesPerGroup> values;
    for (std::size_t i = 0; i < lines.size(); ++i) values[i] = value_of(initial[i]);
    if (settings.output && gpiod_line_config_set_output_values(config.get(), values.data(), lines.size()) != 0) {
      return nullptr;
    }
    Request request(gpiod_chip_request_lines(chip_.get(), user.get(), config.get()));
    if (request == nullptr) return nullptr;
    if (settings.edge != LineEdge::kNone) {
      const int fd = gpiod_line_request_get_fd(request.get());
      const int flags = ::fcntl(fd, F_GETFL);
      if (flags < 0 || ::fcntl(fd, F_SETFL, flags | O_NONBLOCK) != 0) return nullptr;
    }
    return std::make_unique<Group>(std::move(request), std::move(events));
  }

 private:
  Chip chip_;
  ChipInfo info_;
};

}  // namespace

std::unique_ptr<GpioChip> open_gpio_chip(const std::string& path) {
  Chip chip(gpiod_chip_open(path.c_str()));
  if (chip == nullptr) return nullptr;
  ChipInfo info(gpiod_chip_get_info(chip.get()));
  if (info == nullptr) return nullptr;
  return std::make_unique<Chip2>(std::move(chip), std::move(info));
}

}  // namespace plc::io
