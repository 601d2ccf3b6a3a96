#include "io-drivers/gpio/gpio_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <map>
#include <tuple>

#include "core/clock.h"
#include "io-drivers/gpio/gpio_chip.h"

namespace plc::io {
namespace {

using core::Code;
using core::Problem;

/// Lines listed in a help text.
constexpr std::size_t kMostListed = 40;

using Chip = std::unique_ptr<GpioChip>;

Chip open_by_name(const std::string& name) { return open_gpio_chip("/dev/" + name); }

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
    const Chip chip = open_by_name(name);
    list += list.empty() ? name : ", " + name;
    if (chip != nullptr) list += fmt::format(" [{}] ({} lines)", chip->label(), chip->line_count());
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
    Chip chip = open_gpio_chip(name);
    if (chip == nullptr) return no_chip(name, errno);
    return chip;
  }
  // A name counts before a label; a label before the reason why there is nothing of that name.
  Chip found = open_by_name(name);
  if (found != nullptr) return found;
  const int error = errno;
  std::string denied;  // chips whose label cannot be asked for
  int why_denied = 0;
  for (const std::string& candidate : chip_names()) {
    Chip chip = open_by_name(candidate);
    if (chip == nullptr && is_denied(errno)) {
      why_denied = errno;
      denied += (denied.empty() ? "" : ", ") + candidate;
    }
    if (chip == nullptr || name != chip->label()) continue;
    if (found != nullptr) {
      return Problem{
          Code::P7401,
          fmt::format("GPIO chips \"{}\" and \"{}\" are both labelled \"{}\"", found->name(), chip->name(), name),
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

struct Line : LineFacts {
  unsigned offset = 0;
};

std::string lines_help(const GpioChip& chip, const std::vector<Line>& lines) {
  std::string named;
  std::size_t count = 0;
  for (const Line& line : lines) {
    if (line.name.empty() || ++count > kMostListed) continue;
    named += fmt::format("{}{} ({})", named.empty() ? "" : ", ", line.name, line.offset);
  }
  if (count > kMostListed) named += fmt::format(" and {} more", count - kMostListed);
  return fmt::format("{} [{}] has the lines 0 to {}{}", chip.name(), chip.label(), lines.empty() ? 0 : lines.size() - 1,
                     named.empty() ? ", none with a name" : ", by name: " + named);
}

core::Result<std::vector<Line>> lines_of(GpioChip& chip) {
  std::vector<Line> lines;
  for (unsigned offset = 0; offset < chip.line_count(); ++offset) {
    auto facts = chip.facts(offset);
    if (!facts) {
      return Problem{
          Code::P7401, fmt::format("line {} of {} cannot be asked: {}", offset, chip.name(), error_text(errno)), {}};
    }
    lines.push_back({std::move(*facts), offset});
  }
  return lines;
}

core::Result<unsigned> offset_of(const LineSpec& spec, const GpioChip& chip, const std::vector<Line>& lines) {
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
                                 line.offset, chip.name(), spec.line),
                     "give the offset instead of the name"};
    }
    found = &line;
  }
  if (found != nullptr) return found->offset;
  return Problem{Code::P7402, fmt::format("{}: {} has no line \"{}\"", spec.variable, chip.name(), spec.line),
                 lines_help(chip, lines)};
}

Problem busy(const std::string& variable, unsigned offset, const GpioChip& chip, const std::string& consumer) {
  return {Code::P7404,
          fmt::format("{}: line {} of {} is in use{}", variable, offset, chip.name(),
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
  const auto lines = lines_of(*result.chip);
  if (!lines) return lines.error();
  std::map<unsigned, const LineSpec*> bound;
  const auto resolve = [&](const std::vector<LineSpec>& specs,
                           std::vector<unsigned>& offsets) -> std::optional<Problem> {
    for (const LineSpec& spec : specs) {
      const auto offset = offset_of(spec, *result.chip, *lines);
      if (!offset) return offset.error();
      const auto [first, fresh] = bound.emplace(*offset, &spec);
      if (!fresh) {
        return Problem{Code::P7405,
                       fmt::format("{} and {} are both line {} of {}", first->second->variable, spec.variable, *offset,
                                   result.chip->name()),
                       "bind one variable to the line and use it in both places"};
      }
      const Line& line = (*lines)[*offset];
      if (line.used) return busy(spec.variable, *offset, *result.chip, line.consumer);
      offsets.push_back(*offset);
    }
    return std::nullopt;
  };
  if (auto problem = resolve(request.inputs, result.inputs)) return std::move(*problem);
  if (auto problem = resolve(request.outputs, result.outputs)) return std::move(*problem);
  return result;
}

LineSettings settings_of(const LineSpec& spec, bool output) {
  return {output, spec.active_low, spec.bias, output ? LineEdge::kNone : spec.edge,
          output ? spec.drive : Drive::kPushPull};
}

class KernelLines final : public GpioLines {
 public:
  explicit KernelLines(Chip chip) : chip_(std::move(chip)) {}

  std::optional<Problem> request(const LinesRequest& request, const std::vector<unsigned>& inputs,
                                 const std::vector<unsigned>& outputs) {
    if (auto problem = request_groups(request.inputs, inputs, false, inputs_)) return problem;
    return request_groups(request.outputs, outputs, true, outputs_);
  }

  // RT:
  int read(std::span<LineInput> inputs) noexcept override {
    std::array<std::uint8_t, kMostLinesPerGroup> values;
    for (Group& group : inputs_) {
      // WHY value before events: an edge between the two shows now, and not once more in the next cycle.
      if (const int error = group.lines->read(std::span(values).first(group.members.size()))) return error;
      for (std::size_t i = 0; i < group.members.size(); ++i) inputs[group.members[i]] = {values[i], false};
      if (group.level < 0) continue;
      const core::TimeNs seen_before = group.seen_ns;
      if (values[0] == group.level) group.seen_ns = core::MonotonicClock().now_ns();
      const core::TimeNs newest = group.lines->take_edges();
      if (newest < 0) return static_cast<int>(-newest);
      // WHY times: the kernel hands out events from a thread of its own, so the level can be seen before its event.
      // That event, arriving when the level has gone again, would be a second pulse.
      inputs[group.members[0]].edge = newest > seen_before;
    }
    return 0;
  }

  // RT:
  int write(std::span<const std::uint8_t> outputs) noexcept override {
    int first_error = 0;
    std::array<std::uint8_t, kMostLinesPerGroup> values;
    for (Group& group : outputs_) {
      for (std::size_t i = 0; i < group.members.size(); ++i) values[i] = outputs[group.members[i]];
      const int error = group.lines->write(std::span(values).first(group.members.size()));
      if (first_error == 0) first_error = error;
    }
    return first_error;
  }

  // Asks the chip's own handle for a line's description.
  bool gone() noexcept override {
    const std::vector<Group>& side = outputs_.empty() ? inputs_ : outputs_;
    return !side.empty() && !chip_->facts(side.front().first_line) && errno == ENODEV;
  }

 private:
  /// Lines with equal settings; of one with an edge, that line alone.
  struct Group {
    std::unique_ptr<LineGroup> lines;
    std::vector<std::uint32_t> members;  ///< places in the caller's order
    unsigned first_line = 0;
    int level = -1;            ///< after the edge asked for; -1 = none is
    core::TimeNs seen_ns = 0;  ///< when this level was last read
  };

  Problem refused(const std::string& variables, const std::string& lines, int error) const {
    return {Code::P7406,
            fmt::format("{}: line {} of {} is refused: {}", variables, lines, chip_->name(), error_text(error)),
            is_denied(error) ? "run as root, or as a member of the group the device belongs to"
                             : "not every chip has bias, edges and every drive: leave them out and see"};
  }

  std::optional<Problem> request_groups(const std::vector<LineSpec>& specs, const std::vector<unsigned>& offsets,
                                        bool output, std::vector<Group>& groups) {
    std::map<LineSettings, std::vector<std::uint32_t>> by_settings;
    for (std::uint32_t i = 0; i < specs.size(); ++i) by_settings[settings_of(specs[i], output)].push_back(i);
    for (const auto& [settings, members] : by_settings) {
      const std::size_t most = settings.edge == LineEdge::kNone ? kMostLinesPerGroup : 1;
      for (std::size_t begin = 0; begin < members.size(); begin += most) {
        Group group;
        std::vector<unsigned> lines;
        std::vector<std::uint8_t> initial;
        std::string variables, named;
        for (std::size_t i = begin; i < std::min(members.size(), begin + most); ++i) {
          const std::uint32_t member = members[i];
          lines.push_back(offsets[member]);
          initial.push_back(specs[member].initial ? 1 : 0);
          group.members.push_back(member);
          variables += (variables.empty() ? "" : ", ") + specs[member].variable;
          named += (named.empty() ? "" : ", ") + std::to_string(offsets[member]);
        }
        group.lines = chip_->request(settings, lines, initial);
        if (group.lines == nullptr) return refused(variables, named, errno);
        group.first_line = lines.front();
        if (settings.edge != LineEdge::kNone) group.level = settings.edge == LineEdge::kRising ? 1 : 0;
        groups.push_back(std::move(group));
      }
    }
    return std::nullopt;
  }

  Chip chip_;
  std::vector<Group> inputs_, outputs_;
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
