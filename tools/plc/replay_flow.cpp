#include "tools/plc/replay_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "bytecode/drawings.h"
#include "core/text.h"
#include "pictures/picture.h"
#include "tools/command_line.h"

namespace plc::tools {
namespace {

using bytecode::DrawnKey;
using bytecode::DrawnSide;
using shadow::Shown;

void complain_of(std::string message, std::string help) {
  complain({core::Code::P7101, std::move(message), std::move(help)});
}

/// Words for places, from the drawing where the image has it.
class Places {
 public:
  Places(const bytecode::Image& image, const std::string& pou) {
    if (image.drawings.empty()) return;
    auto drawings = bytecode::unpack(image.drawings);
    if (!drawings) return;
    for (bytecode::DrawnBody& body : drawings->bodies) {
      if (core::iequals(body.name, pou)) bodies_.push_back(std::move(body));
    }
    for (const bytecode::DrawnBody& body : bodies_) {
      for (const bytecode::DrawnElement& element : body.elements) add(element);
    }
  }

  [[nodiscard]] std::string words(const DrawnKey& key) const {
    if (key.local_id < 0) return text_at(key);
    if (const auto known = words_.find(key); known != words_.end()) return known->second;
    const char* const side = key.side == DrawnSide::kInput    ? ", input"
                             : key.side == DrawnSide::kOutput ? ", output"
                                                              : "";
    return fmt::format("element {}{}{}", key.local_id, side,
                       key.side == DrawnSide::kWhole && key.pin == 0 ? "" : fmt::format(" {}", key.pin));
  }

 private:
  void add(const bytecode::DrawnElement& element) {
    std::string name = fmt::format("{} {}", core::element_word(element.kind), element.local_id);
    if (!element.text.empty()) name += " " + element.text;
    if (!element.instance.empty()) name += " " + element.instance;
    words_[key_of(0, element)] = name;
    for (const bytecode::DrawnPin& pin : element.pins) {
      std::string& words = words_[key_of(0, element, pin)];
      words = fmt::format("{}, {}{}", name, pin.output ? "output" : "input", pin.name.empty() ? "" : " " + pin.name);
    }
    for (std::size_t a = 0; a < element.actions.size(); ++a) {
      words_[key_of(0, element, a)] =
          fmt::format("{}, action {} {}", name, element.actions[a].qualifier, element.actions[a].text);
    }
    if (element.kind == core::ElementKind::kStep) {
      DrawnKey time = key_of(0, element);
      time.side = DrawnSide::kOutput;
      words_[time] = name + ", time";
    } else if (element.kind == core::ElementKind::kTransition) {
      DrawnKey condition = key_of(0, element);
      condition.side = DrawnSide::kInput;
      words_[condition] = name + ", condition";
    }
  }

  /// The name or number at a place of a text, or its line.
  [[nodiscard]] std::string text_at(const DrawnKey& key) const {
    for (const bytecode::DrawnBody& body : bodies_) {
      if (body.text.empty() || key.line < body.text_line) continue;
      std::string_view rest = body.text;
      std::uint32_t column = body.text_column;
      for (std::uint32_t line = body.text_line; line < key.line && !rest.empty(); ++line, column = 1) {
        const std::size_t end = rest.find('\n');
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
      }
      rest = rest.substr(0, rest.find('\n'));
      if (key.column < column || key.column - column >= rest.size()) continue;
      rest = rest.substr(key.column - column);
      constexpr std::string_view kOfNames = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.[]^%#";
      const std::size_t end = key.side == DrawnSide::kWhole ? rest.size() : rest.find_first_not_of(kOfNames);
      return std::string(
          core::trimmed(rest.substr(0, std::max<std::size_t>(end == std::string_view::npos ? rest.size() : end, 1))));
    }
    return key.side == DrawnSide::kWhole ? "statement" : "value";
  }

  std::vector<bytecode::DrawnBody> bodies_;
  std::map<DrawnKey, std::string> words_;
};

std::string words_of(const Shown& shown, const std::string& value) {
  if (!shown.ran) return "not run";
  if (shown.is_bool && shown.known) {
    if (shown.was_on && shown.was_off) return shown.on ? "on, was off" : "off, was on";
    return shown.on ? "on" : "off";
  }
  if (!value.empty()) return value;
  return shown.is_bool ? "not computed" : "ran";
}

}  // namespace

std::optional<ReplayFlow> ReplayFlow::find(runtime::Resource& resource, const std::string& wanted) {
  const bytecode::Image& image = resource.image();
  const std::size_t colon = wanted.find(':');
  const std::string name = wanted.substr(0, colon);
  const std::string path = colon == std::string::npos ? std::string() : wanted.substr(colon + 1);
  if (image.probes.empty()) {
    complain_of("the recorded image does not say where its drawings have their values",
                "record a project with plc sim --record, or an image that plc compile --drawings made");
    return std::nullopt;
  }
  std::string names, instances;
  std::vector<std::pair<std::uint32_t, shadow::PouInstance>> found;
  for (std::uint32_t p = 0; p < image.pous.size(); ++p) {
    if (image.probes[p].empty()) continue;
    names += (names.empty() ? "" : ", ") + image.pous[p].name;
    if (!core::iequals(image.pous[p].name, name)) continue;
    for (std::uint32_t t = 0; t < resource.task_count(); ++t) {
      for (shadow::PouInstance& one : shadow::instances_of(resource.program(t), p)) {
        if (!path.empty() && !core::iequals(one.path, path)) continue;
        constexpr std::size_t kNamed = 10;
        if (found.size() < kNamed) instances += (instances.empty() ? "" : ", ") + one.path;
        if (found.size() == kNamed) instances += ", ..";
        found.emplace_back(t, std::move(one));
      }
    }
  }
  if (found.empty()) {
    complain_of(path.empty() ? fmt::format("no task executes a POU \"{}\" that has something to see", name)
                             : fmt::format("POU \"{}\" has no instance \"{}\"", name, path),
                "POUs are " + names);
    return std::nullopt;
  }
  if (found.size() > 1) {
    complain_of(fmt::format("POU \"{}\" has several instances: {}", name, instances),
                fmt::format("name one: --flow {}:{}", name, found.front().second.path));
    return std::nullopt;
  }
  return ReplayFlow(found.front().first, std::move(found.front().second));
}

std::optional<shadow::ProbeView> ReplayFlow::look(shadow::Player& player) const {
  runtime::Program& program = player.resource().program(task_);
  const runtime::RecordHead last = player.replicas().replica(task_).head();
  if (last.bytes == 0) {
    complain_of(fmt::format("no scan of task \"{}\" was executed", program.task().name), "see --until and --at");
    return std::nullopt;
  }
  // Once more from before it, and now with probes: until then nobody had to look.
  player.seek(last.now_ns - 1);
  if (const auto problem = program.look_at({&instance_.view, 1})) return complain(*problem), std::nullopt;
  shadow::ProbeView view(program, instance_.view);
  for (auto next = player.upcoming(); next; next = player.upcoming()) {
    view.clear();
    const auto played = player.step();
    if (played->task == task_ && played->scan == last.scan) break;
  }
  return view;
}

std::string ReplayFlow::caption(shadow::Player& player) const {
  const runtime::Program& program = player.resource().program(task_);
  const std::string& pou = program.image().pous[instance_.view.pou].name;
  const runtime::RecordHead& head = player.replicas().replica(task_).head();
  return fmt::format("{}{} in scan {} of task \"{}\", {} after the first recorded one", pou,
                     core::iequals(pou, instance_.path) ? "" : " on " + instance_.path, head.scan, program.task().name,
                     duration_text(static_cast<double>(head.now_ns - *player.begin_ns())));
}

bool ReplayFlow::show(shadow::Player& player, runtime::ValueStyle style, std::ostream& out) const {
  const bytecode::Image& image = player.resource().image();
  const auto view = look(player);
  if (!view) return false;
  out << caption(player) << "\n\n";
  const Places places(image, image.pous[instance_.view.pou].name);
  std::vector<const bytecode::ProbePoint*> points;
  for (const bytecode::ProbePoint& point : view->points()) points.push_back(&point);
  std::stable_sort(points.begin(), points.end(), [](const auto* x, const auto* y) {
    return std::tie(x->key.line, x->key.column) < std::tie(y->key.line, y->key.column);
  });
  std::vector<std::vector<std::string>> rows;
  for (const bytecode::ProbePoint* const point : points) {
    rows.push_back({fmt::format("{}:{}", point->key.line, point->key.column), places.words(point->key),
                    words_of(view->at(*point), view->text(*point, style))});
  }
  out << columns_text(rows);
  return true;
}

bool ReplayFlow::draw(shadow::Player& player, runtime::ValueStyle style, const std::string& svg,
                      std::ostream& out) const {
  const bytecode::Image& image = player.resource().image();
  const std::string& pou = image.pous[instance_.view.pou].name;
  const auto drawings = bytecode::unpack(image.drawings);
  std::vector<pictures::PicturedBody> bodies;
  for (std::size_t b = 0; drawings && b < drawings->bodies.size(); ++b) {
    if (core::iequals(drawings->bodies[b].name, pou)) bodies.push_back({&drawings->bodies[b], {}, instance_.view.pou});
  }
  if (bodies.empty()) {
    complain_of(fmt::format("the recorded image has no drawing of POU \"{}\"", pou),
                "record a project with plc sim --record, or an image that plc compile --drawings made");
    return false;
  }
  const auto view = look(player);
  if (!view) return false;
  pictures::Marks marks;
  for (const bytecode::ProbePoint& point : view->points()) {
    const Shown shown = view->at(point);
    DrawnKey key = point.key;
    key.pou = instance_.view.pou;
    pictures::Mark& mark = marks[key];
    if (!shown.ran) {
      mark.look = pictures::Look::kNotRun;
    } else if (shown.is_bool && shown.known) {
      mark.look = shown.on ? pictures::Look::kOn : pictures::Look::kOff;
    } else {
      mark.text = view->text(point, style);
      // A place alone: a statement, a jump that was taken.
      if (mark.text.empty() && !shown.is_bool) mark.look = pictures::Look::kOn;
    }
  }
  const std::string title = caption(player);
  bodies.front().caption = title;
  const std::string picture = pictures::svg(title, bodies, marks);
  if (svg == "-") {
    out << picture;
    return true;
  }
  std::string why;
  if (write_file(svg, picture, why)) return true;
  complain_of(fmt::format("{} cannot be written: {}", svg, why), {});
  return false;
}

}  // namespace plc::tools
