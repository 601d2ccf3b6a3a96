// libgpiod 1.6 (uAPI v1). With version 2 this file alone changes.
#include "io-drivers/gpio/gpio_lines.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <map>
#include <tuple>

#include "core/clock.h"

namespace plc::io {
namespace {

using core::Code;
using core::Problem;

constexpr const char* kConsumer = "plc-run";
/// The kernel keeps this many events of a line (uAPI v1); one read takes them all.
constexpr std::size_t kEventsKept = 16;
/// Lines listed in a help text.
constexpr std::size_t kMostListed = 40;

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

std::string error_text(int error) {
  constexpr int kNotSupported = 524;  // the kernel's ENOTSUPP, which strerror() does not know
  return error == kNotSupported ? "the chip does not support these settings" : std::strerror(error);
}

/// Names of the chips of this machine, in order: "gpiochip0".
std::vector<std::string> chip_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    std::string name = entry.path().filename().string();
    if (name.rfind("gpiochip", 0) == 0) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);  // gpiochip2 before gpiochip10
  });
  return names;
}

std::string chips_help() {
  std::string list;
  for (const std::string& name : chip_names()) {
    const Chip chip(gpiod_chip_open_by_name(name.c_str()));
    list += list.empty() ? name : ", " + name;
    if (chip != nullptr)
      list += fmt::format(" [{}] ({} lines)", gpiod_chip_label(chip.get()), gpiod_chip_num_lines(chip.get()));
  }
  return list.empty()
             ? "this machine has no GPIO chips (/dev/gpiochip*): is the kernel's driver loaded? plc-run --simulate-io "
               "runs without"
             : "chips of this machine: " + list;
}

bool is_denied(int error) { return error == EACCES || error == EPERM; }

constexpr const char* kRightsHelp =
    "run as root, or as a member of the group the device belongs to (docs/guides/gpio.md, \"Permissions\")";

Problem no_chip(const std::string& name, int error) {
  return {Code::P7401, fmt::format("GPIO chip \"{}\" cannot be opened: {}", name, error_text(error)),
          is_denied(error) ? kRightsHelp : chips_help()};
}

core::Result<Chip> open_chip(const std::string& name) {
  if (name.empty()) return Problem{Code::P7401, "the driver names no GPIO chip", chips_help()};
  if (name.front() == '/') {
    Chip chip(gpiod_chip_open(name.c_str()));
    if (chip == nullptr) return no_chip(name, errno);
    return chip;
  }
  // A name counts before a label; a label before the reason why there is nothing of that name.
  Chip found(gpiod_chip_open_by_name(name.c_str()));
  if (found != nullptr) return found;
  const int error = errno;
  std::string denied;  // chips whose label cannot be asked for
  int why_denied = 0;
  for (const std::string& candidate : chip_names()) {
    Chip chip(gpiod_chip_open_by_name(candidate.c_str()));
    if (chip == nullptr && is_denied(errno)) {
      why_denied = errno;
      denied += (denied.empty() ? "" : ", ") + candidate;
    }
    if (chip == nullptr || name != gpiod_chip_label(chip.get())) continue;
    if (found != nullptr) {
      return Problem{Code::P7401,
                     fmt::format("GPIO chips \"{}\" and \"{}\" are both labelled \"{}\"", gpiod_chip_name(found.get()),
                                 gpiod_chip_name(chip.get()), name),
                     "name the chip, or the path of a udev link to it"};
    }
    found = std::move(chip);
  }
  if (found != nullptr) return found;
  if (is_denied(error) || denied.empty()) return no_chip(name, error);
  return Problem{Code::P7401,
                 fmt::format("GPIO chip \"{}\" is none that may be opened; of {} the label cannot be asked for: {}",
                             name, denied, error_text(why_denied)),
                 kRightsHelp};
}

struct Line {
  unsigned offset = 0;
  std::string name, consumer;
  bool used = false;
};

std::string lines_help(gpiod_chip* chip, const std::vector<Line>& lines) {
  std::string named;
  std::size_t count = 0;
  for (const Line& line : lines) {
    if (line.name.empty() || ++count > kMostListed) continue;
    named += fmt::format("{}{} ({})", named.empty() ? "" : ", ", line.name, line.offset);
  }
  if (count > kMostListed) named += fmt::format(" and {} more", count - kMostListed);
  return fmt::format("{} [{}] has the lines 0 to {}{}", gpiod_chip_name(chip), gpiod_chip_label(chip),
                     lines.empty() ? 0 : lines.size() - 1,
                     named.empty() ? ", none with a name" : ", by name: " + named);
}

core::Result<std::vector<Line>> lines_of(gpiod_chip* chip) {
  std::vector<Line> lines;
  for (unsigned offset = 0; offset < gpiod_chip_num_lines(chip); ++offset) {
    gpiod_line* const line = gpiod_chip_get_line(chip, offset);
    if (line == nullptr) {
      return Problem{Code::P7401,
                     fmt::format("line {} of {} cannot be asked: {}", offset, gpiod_chip_name(chip), error_text(errno)),
                     {}};
    }
    const auto text = [](const char* value) { return value == nullptr ? std::string() : std::string(value); };
    lines.push_back({offset, text(gpiod_line_name(line)), text(gpiod_line_consumer(line)), gpiod_line_is_used(line)});
  }
  return lines;
}

core::Result<unsigned> offset_of(const LineSpec& spec, gpiod_chip* chip, const std::vector<Line>& lines) {
  unsigned offset = 0;
  const char* const end = spec.line.data() + spec.line.size();
  const auto [rest, error] = std::from_chars(spec.line.data(), end, offset);
  if (error == std::errc() && rest == end && offset < lines.size()) return offset;
  const Line* found = nullptr;
  for (const Line& line : lines) {
    if (spec.line.empty() || line.name != spec.line) continue;
    if (found != nullptr) {
      return Problem{Code::P7403,
                     fmt::format("{}: lines {} and {} of {} are both named \"{}\"", spec.variable, found->offset,
                                 line.offset, gpiod_chip_name(chip), spec.line),
                     "give the offset instead of the name"};
    }
    found = &line;
  }
  if (found != nullptr) return found->offset;
  return Problem{Code::P7402, fmt::format("{}: {} has no line \"{}\"", spec.variable, gpiod_chip_name(chip), spec.line),
                 lines_help(chip, lines)};
}

Problem busy(const std::string& variable, unsigned offset, gpiod_chip* chip, const std::string& consumer) {
  return {Code::P7404,
          fmt::format("{}: line {} of {} is in use{}", variable, offset, gpiod_chip_name(chip),
                      consumer.empty() ? std::string(" by the kernel") : " by \"" + consumer + "\""),
          "gpioinfo lists the lines and who uses them; end that program, or choose another line"};
}

/// A chip and the offsets of a request, inputs before outputs, all of them free.
struct Plan {
  Chip chip;
  std::vector<unsigned> inputs, outputs;
};

core::Result<Plan> plan(const LinesRequest& request) {
  auto chip = open_chip(request.chip);
  if (!chip) return chip.error();
  Plan result{std::move(*chip), {}, {}};
  const auto lines = lines_of(result.chip.get());
  if (!lines) return lines.error();
  std::map<unsigned, const LineSpec*> bound;
  const auto resolve = [&](const std::vector<LineSpec>& specs,
                           std::vector<unsigned>& offsets) -> std::optional<Problem> {
    for (const LineSpec& spec : specs) {
      const auto offset = offset_of(spec, result.chip.get(), *lines);
      if (!offset) return offset.error();
      const auto [first, fresh] = bound.emplace(*offset, &spec);
      if (!fresh) {
        return Problem{Code::P7405,
                       fmt::format("{} and {} are both line {} of {}", first->second->variable, spec.variable, *offset,
                                   gpiod_chip_name(result.chip.get())),
                       "bind one variable to the line and use it in both places"};
      }
      const Line& line = (*lines)[*offset];
      if (line.used) return busy(spec.variable, *offset, result.chip.get(), line.consumer);
      offsets.push_back(*offset);
    }
    return std::nullopt;
  };
  if (auto problem = resolve(request.inputs, result.inputs)) return std::move(*problem);
  if (auto problem = resolve(request.outputs, result.outputs)) return std::move(*problem);
  return result;
}

int flags_of(const LineSpec& spec, bool output) {
  int flags = spec.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  switch (spec.bias) {
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
  if (output && spec.drive == Drive::kOpenDrain) flags |= GPIOD_LINE_REQUEST_FLAG_OPEN_DRAIN;
  if (output && spec.drive == Drive::kOpenSource) flags |= GPIOD_LINE_REQUEST_FLAG_OPEN_SOURCE;
  return flags;
}

class KernelLines final : public GpioLines {
 public:
  explicit KernelLines(Chip chip) : chip_(std::move(chip)) {}

  std::optional<Problem> request(const LinesRequest& request, const std::vector<unsigned>& inputs,
                                 const std::vector<unsigned>& outputs) {
    for (std::uint32_t i = 0; i < request.inputs.size(); ++i) {
      if (request.inputs[i].edge == LineEdge::kNone) continue;
      if (auto problem = request_edge(request.inputs[i], inputs[i], i)) return problem;
    }
    if (auto problem = request_groups(request.inputs, inputs, false, inputs_)) return problem;
    return request_groups(request.outputs, outputs, true, outputs_);
  }

  // RT:
  int read(std::span<LineInput> inputs) noexcept override {
    std::array<int, kMostLinesPerGroup> values;
    for (Group& group : inputs_) {
      if (gpiod_line_get_value_bulk(&group.lines, values.data()) != 0) return errno;
      for (std::size_t i = 0; i < group.members.size(); ++i) {
        inputs[group.members[i]] = {static_cast<std::uint8_t>(values[i]), false};
      }
    }
    for (EdgeLine& line : edges_) {
      // WHY value before events: an edge between the two shows now, and not once more in the next cycle.
      const int value = gpiod_line_get_value(line.line);
      if (value < 0) return errno;
      const core::TimeNs seen_before = line.seen_ns;
      if (value == line.level) line.seen_ns = core::MonotonicClock().now_ns();
      std::array<gpiod_line_event, kEventsKept> events;
      const int count = gpiod_line_event_read_fd_multiple(line.fd, events.data(), kEventsKept);
      if (count < 0 && errno != EAGAIN) return errno;
      // WHY times: the kernel hands out events from a thread of its own, so the level can be seen before its event.
      // That event, arriving when the level has gone again, would be a second pulse.
      const bool fresh = count > 0 && time_of(events[static_cast<std::size_t>(count) - 1]) > seen_before;
      inputs[line.member] = {static_cast<std::uint8_t>(value), fresh};
    }
    return 0;
  }

  // RT:
  int write(std::span<const std::uint8_t> outputs) noexcept override {
    int first_error = 0;
    std::array<int, kMostLinesPerGroup> values;
    for (Group& group : outputs_) {
      for (std::size_t i = 0; i < group.members.size(); ++i) values[i] = outputs[group.members[i]];
      if (gpiod_line_set_value_bulk(&group.lines, values.data()) != 0 && first_error == 0) first_error = errno;
    }
    return first_error;
  }

  bool gone() noexcept override {
    gpiod_line* line = nullptr;
    if (!edges_.empty()) line = edges_.front().line;
    for (const std::vector<Group>* side : {&inputs_, &outputs_}) {
      if (!side->empty()) line = side->front().lines.lines[0];
    }
    // Asks the chip's own handle for the line's description: nothing moves on the line or a bus.
    return line != nullptr && gpiod_line_update(line) != 0 && errno == ENODEV;
  }

 private:
  /// Lines with equal settings. WHY always as a whole, in request order: version 1 takes the values of a part as those
  /// of the first lines of the request.
  struct Group {
    gpiod_line_bulk lines = GPIOD_LINE_BULK_INITIALIZER;
    std::vector<std::uint32_t> members;  ///< places in the caller's order
  };
  struct EdgeLine {
    gpiod_line* line = nullptr;
    int fd = -1;
    std::uint32_t member = 0;
    int level = 1;             ///< after the edge asked for
    core::TimeNs seen_ns = 0;  ///< when this level was last read
  };
  /// When the kernel saw the edge, CLOCK_MONOTONIC.
  static core::TimeNs time_of(const gpiod_line_event& event) noexcept {
    return event.ts.tv_sec * 1'000'000'000 + event.ts.tv_nsec;
  }

  Problem refused(const std::string& variables, const std::string& lines, int error) const {
    return {Code::P7406,
            fmt::format("{}: line {} of {} is refused: {}", variables, lines, gpiod_chip_name(chip_.get()),
                        error_text(error)),
            is_denied(error) ? "run as root, or as a member of the group the device belongs to"
                             : "not every chip has bias, edges and every drive: leave them out and see"};
  }

  std::optional<Problem> request_edge(const LineSpec& spec, unsigned offset, std::uint32_t member) {
    gpiod_line* const line = gpiod_chip_get_line(chip_.get(), offset);
    const gpiod_line_request_config config{
        kConsumer,
        spec.edge == LineEdge::kRising ? GPIOD_LINE_REQUEST_EVENT_RISING_EDGE : GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE,
        flags_of(spec, false)};
    if (line == nullptr || gpiod_line_request(line, &config, 0) != 0) {
      return refused(spec.variable, std::to_string(offset), errno);
    }
    const int fd = gpiod_line_event_get_fd(line);
    const int flags = ::fcntl(fd, F_GETFL);
    if (flags < 0 || ::fcntl(fd, F_SETFL, flags | O_NONBLOCK) != 0) {
      return refused(spec.variable, std::to_string(offset), errno);
    }
    edges_.push_back({line, fd, member, spec.edge == LineEdge::kRising ? 1 : 0});
    return std::nullopt;
  }

  std::optional<Problem> request_groups(const std::vector<LineSpec>& specs, const std::vector<unsigned>& offsets,
                                        bool output, std::vector<Group>& groups) {
    std::map<int, std::vector<std::uint32_t>> by_flags;
    for (std::uint32_t i = 0; i < specs.size(); ++i) {
      if (output || specs[i].edge == LineEdge::kNone) by_flags[flags_of(specs[i], output)].push_back(i);
    }
    for (const auto& [flags, members] : by_flags) {
      for (std::size_t begin = 0; begin < members.size(); begin += kMostLinesPerGroup) {
        Group group;
        std::array<int, kMostLinesPerGroup> initial{};
        std::string variables, lines;
        for (std::size_t i = begin; i < std::min(members.size(), begin + kMostLinesPerGroup); ++i) {
          const std::uint32_t member = members[i];
          gpiod_line* const line = gpiod_chip_get_line(chip_.get(), offsets[member]);
          if (line == nullptr) return refused(specs[member].variable, std::to_string(offsets[member]), errno);
          initial[group.members.size()] = specs[member].initial ? 1 : 0;
          gpiod_line_bulk_add(&group.lines, line);
          group.members.push_back(member);
          variables += (variables.empty() ? "" : ", ") + specs[member].variable;
          lines += (lines.empty() ? "" : ", ") + std::to_string(offsets[member]);
        }
        const gpiod_line_request_config config{
            kConsumer, output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT : GPIOD_LINE_REQUEST_DIRECTION_INPUT, flags};
        if (gpiod_line_request_bulk(&group.lines, &config, initial.data()) != 0)
          return refused(variables, lines, errno);
        groups.push_back(std::move(group));
      }
    }
    return std::nullopt;
  }

  Chip chip_;
  std::vector<Group> inputs_, outputs_;
  std::vector<EdgeLine> edges_;
};

std::optional<Problem> check_lines(const LinesRequest& request) {
  auto planned = plan(request);
  if (!planned) return planned.error();
  return std::nullopt;
}

core::Result<std::unique_ptr<GpioLines>> open_lines(const LinesRequest& request) {
  auto planned = plan(request);
  if (!planned) return planned.error();
  auto lines = std::make_unique<KernelLines>(std::move(planned->chip));
  if (auto problem = lines->request(request, planned->inputs, planned->outputs)) return std::move(*problem);
  return std::unique_ptr<GpioLines>(std::move(lines));
}

}  // namespace

GpioAccess kernel_gpio() { return {check_lines, open_lines}; }

}  // namespace plc::io
