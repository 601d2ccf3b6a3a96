// libgpiod 1.6 (uAPI v1).
#include <fcntl.h>
#include <gpiod.h>

#include <array>
#include <cerrno>

#include "io-drivers/gpio/gpio_chip.h"

namespace plc::io {
namespace {

/// The kernel keeps this many events of a line (uAPI v1); one read takes them all.
constexpr std::size_t kEventsKept = 16;

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
/// The lines of a group are the chip's: it stays open as long as they are used.
using Chip = std::shared_ptr<gpiod_chip>;

int flags_of(const LineSettings& settings) {
  int flags = settings.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  switch (settings.bias) {
    case Bias::kAsIs:
      break;
    case Bias::kDisabled:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
      break;
    case Bias::kPullUp:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
      break;
    case Bias::kPullDown:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
      break;
  }
  if (settings.output && settings.drive == Drive::kOpenDrain) flags |= GPIOD_LINE_REQUEST_FLAG_OPEN_DRAIN;
  if (settings.output && settings.drive == Drive::kOpenSource) flags |= GPIOD_LINE_REQUEST_FLAG_OPEN_SOURCE;
  return flags;
}

/// WHY always as a whole, in request order: version 1 takes the values of a part as those of the first lines of the
/// request.
class Group final : public LineGroup {
 public:
  Group(Chip chip, const gpiod_line_bulk& lines, int event_fd)
      : chip_(std::move(chip)), lines_(lines), event_fd_(event_fd) {}
  ~Group() override { gpiod_line_release_bulk(&lines_); }
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;

  // RT:
  int read(std::span<std::uint8_t> values) noexcept override {
    std::array<int, kMostLinesPerGroup> wide;
    if (gpiod_line_get_value_bulk(&lines_, wide.data()) != 0) return errno;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint8_t>(wide[i]);
    return 0;
  }
  // RT:
  int write(std::span<const std::uint8_t> values) noexcept override {
    std::array<int, kMostLinesPerGroup> wide;
    for (std::size_t i = 0; i < values.size(); ++i) wide[i] = values[i];
    return gpiod_line_set_value_bulk(&lines_, wide.data()) == 0 ? 0 : errno;
  }
  // RT:
  core::TimeNs take_edges() noexcept override {
    std::array<gpiod_line_event, kEventsKept> events;
    const int count = gpiod_line_event_read_fd_multiple(event_fd_, events.data(), kEventsKept);
    if (count <= 0) return count == 0 || errno == EAGAIN ? 0 : -errno;
    const timespec& newest = events[static_cast<std::size_t>(count) - 1].ts;
    return newest.tv_sec * 1'000'000'000 + newest.tv_nsec;
  }

 private:
  Chip chip_;
  gpiod_line_bulk lines_;
  int event_fd_;  ///< with an edge
};

class Chip1 final : public GpioChip {
 public:
  explicit Chip1(Chip chip) : chip_(std::move(chip)) {}
  [[nodiscard]] std::string name() const override { return gpiod_chip_name(chip_.get()); }
  [[nodiscard]] std::string label() const override { return gpiod_chip_label(chip_.get()); }
  [[nodiscard]] unsigned line_count() const override { return gpiod_chip_num_lines(chip_.get()); }
  [[nodiscard]] std::optional<LineFacts> facts(unsigned offset) noexcept override {
    gpiod_line* const line = gpiod_chip_get_line(chip_.get(), offset);
    if (line == nullptr || gpiod_line_update(line) != 0) return std::nullopt;
    const auto text = [](const char* value) { return value == nullptr ? std::string() : std::string(value); };
    return LineFacts{text(gpiod_line_name(line)), text(gpiod_line_consumer(line)), gpiod_line_is_used(line)};
  }
  std::unique_ptr<LineGroup> request(const LineSettings& settings, std::span<const unsigned> lines,
                                     std::span<const std::uint8_t> initial) override {
    gpiod_line_bulk bulk = GPIOD_LINE_BULK_INITIALIZER;
    std::array<int, kMostLinesPerGroup> values = {};
    for (std::size_t i = 0; i < lines.size(); ++i) {
      gpiod_line* const line = gpiod_chip_get_line(chip_.get(), lines[i]);
      if (line == nullptr) return nullptr;
      gpiod_line_bulk_add(&bulk, line);
      values[i] = initial[i];
    }
    const int type = settings.output                       ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT
                     : settings.edge == LineEdge::kRising  ? GPIOD_LINE_REQUEST_EVENT_RISING_EDGE
                     : settings.edge == LineEdge::kFalling ? GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE
                                                           : GPIOD_LINE_REQUEST_DIRECTION_INPUT;
    const gpiod_line_request_config config{kGpioConsumer, type, flags_of(settings)};
    if (gpiod_line_request_bulk(&bulk, &config, values.data()) != 0) return nullptr;
    const int fd = settings.edge == LineEdge::kNone ? -1 : gpiod_line_event_get_fd(bulk.lines[0]);
    auto group = std::make_unique<Group>(chip_, bulk, fd);
    if (fd < 0) return group;
    const int flags = ::fcntl(fd, F_GETFL);
    if (flags >= 0 && ::fcntl(fd, F_SETFL, flags | O_NONBLOCK) == 0) return group;
    const int error = errno;
    group.reset();
    errno = error;
    return nullptr;
  }

 private:
  Chip chip_;
};

}  // namespace

std::unique_ptr<GpioChip> open_gpio_chip(const std::string& path) {
  gpiod_chip* const chip = gpiod_chip_open(path.c_str());
  if (chip == nullptr) return nullptr;
  return std::make_unique<Chip1>(Chip(chip, CloseChip()));
}

}  // namespace plc::io
