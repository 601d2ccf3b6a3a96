// The data flow as a drawing: tasks side by side, the most urgent one on the left; below each a line, and between the
// lines one arrow a flow. Inputs are on the left, outputs on the right, the outside below.
//
// An arrow's label is in the gap beside the line where it starts, which is as wide as the longest label. So nothing
// ever covers a text, however many tasks there are.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "tools/command_line.h"
#include "tools/plc/flow.h"

namespace plc::tools {
namespace {

using bytecode::Image;
using bytecode::ImageTask;

// Sizes in pixels of the drawing. Names are set in a monospaced font: 12 px high, at most 7.3 px wide.
constexpr int kMargin = 24;
constexpr int kTitleHeight = 62;
constexpr int kBoxWidth = 206, kBoxHeight = 96;
constexpr int kPitch = 244;     ///< from one line to the next
constexpr int kSideWidth = 92;  ///< of the boxes of inputs and outputs
constexpr int kLineHeight = 16;
constexpr int kBar = 5;  ///< half the width of a task's line
constexpr int kNotesHeight = 56;
constexpr std::size_t kLabelColumns = 30;  ///< of kPitch, between two lines
constexpr std::size_t kNameColumns = 22;   ///< of a task's name, which is larger
constexpr std::size_t kNamed = 4;          ///< flows of more variables are labelled with their number

constexpr std::string_view kHead = R"(<style>
text { fill: #1f2937; font: 12px "DejaVu Sans", Verdana, sans-serif; }
.name { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; }
.title { font-size: 16px; font-weight: bold; }
.task { font-size: 14px; font-weight: bold; }
.note { fill: #4b5563; font-size: 11px; }
.page { fill: #ffffff; }
.box { fill: #eef2f7; stroke: #374151; }
.bar { fill: #dbe2ea; stroke: #9ca3af; }
.arrow { stroke: #0072b2; stroke-width: 2; fill: none; }
.head { fill: #0072b2; }
text.shared { fill: #c01c1c; }
.arrow.shared { stroke: #c01c1c; }
.head.shared { fill: #c01c1c; }
@media (prefers-color-scheme: dark) {
text { fill: #e5e7eb; }
.note { fill: #b6bdc8; }
.page { fill: #14181f; }
.box { fill: #232a35; stroke: #9ca3af; }
.bar { fill: #374151; stroke: #6b7280; }
.arrow { stroke: #56b4e9; }
.head { fill: #56b4e9; }
text.shared { fill: #ff8080; }
.arrow.shared { stroke: #ff8080; }
.head.shared { fill: #ff8080; }
}
</style>
)";

/// Bytes of the UTF-8 character at the start of `text`; 0 when it is none that XML may hold.
std::size_t character_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4) return 0;
  std::uint32_t code = lead & (0xffu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0u) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr std::array<std::uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  return code < kSmallest[bytes] || code > 0x10ffff || surrogate || (code & 0xfffeu) == 0xfffe ? 0 : bytes;
}

/// Calls visit(character) for each; for bytes that are none, with "?".
template <class Visit>
void for_each_character(std::string_view text, Visit visit) {
  while (!text.empty()) {
    const std::size_t bytes = character_bytes(text);
    visit(bytes == 0 ? std::string_view("?") : text.substr(0, bytes));
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
}

/// Columns of a monospaced font; what lies beyond the alphabets of Europe is taken to be wide.
std::size_t columns_of(std::string_view character) { return character.size() >= 3 ? 2 : 1; }
std::size_t width_of(std::string_view text) {
  std::size_t width = 0;
  for_each_character(text, [&](std::string_view c) { width += columns_of(c); });
  return width;
}

/// `text` with at most `columns`; the middle of a longer one becomes "..": long names often differ at their ends.
std::string cut(std::string_view text, std::size_t columns) {
  if (width_of(text) <= columns) return std::string(text);
  std::vector<std::string_view> characters;
  for_each_character(text, [&](std::string_view c) { characters.push_back(c); });
  std::string head, tail;
  std::size_t width = 2;
  for (std::size_t i = 0; (width += columns_of(characters[i])) <= columns * 3 / 5; ++i) head += characters[i];
  width = 2 + width_of(head);
  for (std::size_t i = characters.size(); (width += columns_of(characters[i - 1])) <= columns; --i) {
    tail.insert(0, characters[i - 1]);
  }
  return head + ".." + tail;
}

std::string escaped(std::string_view text) {
  std::string out;
  for_each_character(text, [&](std::string_view c) {
    out += c == "&" ? "&amp;" : c == "<" ? "&lt;" : c == ">" ? "&gt;" : c == "\"" ? "&quot;" : c;
  });
  return out;
}

/// A piece of a label, in a line of its own.
struct Label {
  std::string text;
  bool shared = false;
};

class Drawing {
 public:
  Drawing(const Image& image, const DataFlow& flow) : image_(image), flow_(flow) {
    order_.resize(image.tasks.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return image.tasks[a].priority < image.tasks[b].priority;
    });
    column_.resize(order_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) column_[order_[i]] = static_cast<int>(i) + 1;
    for (const Flow& one : flow.flows) {
      if (one.from.kind == FlowEnd::Kind::kDevices) has_inputs_ = true;
      if (one.to.kind == FlowEnd::Kind::kDevices) has_outputs_ = true;
      if (one.from.kind == FlowEnd::Kind::kOutside) has_outside_ = true;
    }
  }

  std::string write() {
    lay_out();
    const int last = static_cast<int>(order_.size());
    const int lanes_top = kTitleHeight + kBoxHeight;
    const int lanes_end = lanes_top + 24 + std::accumulate(heights_.begin(), heights_.end(), 0);
    const int outside_top = lanes_end + outside_gap_;
    const int bottom = has_outside_ ? outside_top + 36 : lanes_end;
    const int right_label = has_outside_ ? x(last) + kPitch : 0;
    const int right_box = has_outputs_ ? x(last + 1) + kSideWidth : x(last) + kBoxWidth / 2;
    const int width = std::max({right_box + kMargin, right_label, 620});
    const int height = bottom + kNotesHeight + kMargin;

    put("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\">\n", width, height,
        width, height);
    out_ += kHead;
    put("<title>Data flow between the tasks of {}</title>\n", escaped(project()));
    put("<rect class=\"page\" width=\"{}\" height=\"{}\"/>\n", width, height);
    text("title", kMargin, kMargin + 10, "Data flow between tasks: " + cut(project(), 32));
    text("note", kMargin, kMargin + 28,
         fmt::format("The most urgent task stands on the left. Coherence: {}",
                     coherence_name(image_.options.coherence)));

    if (has_inputs_) side(kMargin, lanes_top, lanes_end, "Inputs");
    if (has_outputs_) side(x(last + 1), lanes_top, lanes_end, "Outputs");
    if (has_outside_) outside(outside_top);
    // Arrows pass behind the lines of tasks that they do not concern; writers are marked on top.
    for_each_lane(lanes_top + 24, [&](const Lane& lane, int y) { draw(lane, y); });
    for (const std::uint32_t t : order_) task(t, lanes_end);
    for_each_lane(lanes_top + 24, [&](const Lane& lane, int y) { mark_writers(lane, y); });
    for (const Flow& one : flow_.flows) {
      if (one.from.kind == FlowEnd::Kind::kOutside) draw_outside(one, outside_top, lanes_end);
    }
    text("note", kMargin, bottom + 28,
         "Age: from the release of the scan that computes a value to that of the first scan that uses it,");
    text("note", kMargin, bottom + 43,
         "when both tasks meet their deadlines. Red: variables that several tasks write.");
    out_ += "</svg>\n";
    return std::move(out_);
  }

 private:
  /// A horizontal line of the drawing: an arrow, or the writers of shared variables.
  struct Lane {
    int from = 0, to = 0;             ///< columns; 0 = inputs, then the tasks, then outputs
    std::vector<int> dots;            ///< columns of the writers of shared variables; empty for an arrow
    std::vector<Label> above, below;  ///< lines of text
    std::string tip;
    bool shared = false;
  };

  [[nodiscard]] std::string project() const { return image_.project.empty() ? "a project" : image_.project; }

  // ---- layout -----------------------------------------------------------------------------------------------------

  /// Where the line of a column is; for the boxes at the sides, the edge that faces the tasks.
  [[nodiscard]] int x(int column) const {
    const int first = has_inputs_ ? kMargin + kSideWidth + kPitch : kMargin + kBoxWidth / 2;
    return first + (column - 1) * kPitch;
  }
  [[nodiscard]] int column_of(const FlowEnd& end, bool is_source) const {
    if (end.kind == FlowEnd::Kind::kTask) return column_[end.task];
    return is_source ? 0 : static_cast<int>(order_.size()) + 1;
  }

  /// Puts each lane into the first row that has room for it.
  void lay_out() {
    std::vector<Lane> lanes;
    for (const Flow& one : flow_.flows) {
      if (one.from.kind != FlowEnd::Kind::kOutside) lanes.push_back(lane_of(one));
    }
    std::stable_sort(lanes.begin(), lanes.end(), [](const Lane& a, const Lane& b) { return a.from < b.from; });
    add_shared(lanes);
    std::vector<std::vector<bool>> taken;  // by row: gaps between columns
    for (Lane& lane : lanes) {
      const auto [low, high] = std::minmax(lane.from, lane.to);
      std::size_t row = 0;
      const auto free = [&, low = low, high = high] {
        return std::none_of(taken[row].begin() + low, taken[row].begin() + high, [](bool t) { return t; });
      };
      while (row < taken.size() && !free()) ++row;
      if (row == taken.size()) {
        taken.emplace_back(order_.size() + 1);
        rows_.emplace_back();
      }
      std::fill(taken[row].begin() + low, taken[row].begin() + high, true);
      rows_[row].push_back(std::move(lane));
    }
    // The line itself lies at the end of its row; what is below it belongs to the next one's height.
    std::size_t below = 0;
    for (const std::vector<Lane>& row : rows_) {
      std::size_t above = 0, next = 0;
      for (const Lane& lane : row) {
        above = std::max(above, lane.above.size());
        next = std::max(next, lane.below.size());
      }
      heights_.push_back(static_cast<int>(above + below) * kLineHeight + 18);
      below = next;
    }
    heights_.push_back(static_cast<int>(below) * kLineHeight + 12);
    for (const Flow& one : flow_.flows) {
      if (one.from.kind != FlowEnd::Kind::kOutside) continue;
      const std::size_t lines = labels(one.globals).size() + 1;
      outside_gap_ = std::max(outside_gap_, static_cast<int>(lines) * kLineHeight + 24);
    }
  }

  [[nodiscard]] Lane lane_of(const Flow& one) const {
    Lane lane;
    lane.from = column_of(one.from, true);
    lane.to = column_of(one.to, false);
    lane.above = labels(one.globals);
    lane.below = facts(one);
    lane.tip = tip(fmt::format("{} to {}", end_text(image_, one.from), end_text(image_, one.to)), one.globals);
    lane.shared = std::any_of(one.globals.begin(), one.globals.end(), [&](std::uint32_t g) { return is_shared(g); });
    return lane;
  }

  /// One lane for each set of tasks that write the same variables.
  void add_shared(std::vector<Lane>& lanes) const {
    std::vector<std::vector<std::uint32_t>> sets;  // of variables
    for (std::uint32_t g = 0; g < flow_.globals.size(); ++g) {
      if (!is_shared(g)) continue;
      const auto same = std::find_if(sets.begin(), sets.end(), [&](const std::vector<std::uint32_t>& set) {
        return flow_.globals[set.front()].writers == flow_.globals[g].writers;
      });
      same == sets.end() ? sets.push_back({g}) : same->push_back(g);
    }
    for (const std::vector<std::uint32_t>& set : sets) {
      Lane lane;
      std::string writers;
      for (const std::uint32_t t : flow_.globals[set.front()].writers) {
        lane.dots.push_back(column_[t]);
        writers += (writers.empty() ? "" : ", ") + image_.tasks[t].name;
      }
      const auto [low, high] = std::minmax_element(lane.dots.begin(), lane.dots.end());
      lane.from = *low;
      lane.to = *high;
      lane.above = labels(set);
      lane.below = {{"several writers:"}, {"the last change wins"}};
      lane.tip = tip("written by " + writers, set);
      lane.shared = true;
      lanes.push_back(std::move(lane));
    }
  }

  [[nodiscard]] bool is_shared(std::uint32_t g) const { return flow_.globals[g].owner == FlowOwner::kShared; }

  /// The names of few variables, the number of many.
  [[nodiscard]] std::vector<Label> labels(const std::vector<std::uint32_t>& globals) const {
    std::vector<Label> lines;
    if (globals.size() > kNamed) {
      const auto shared = std::count_if(globals.begin(), globals.end(), [&](std::uint32_t g) { return is_shared(g); });
      lines.push_back({fmt::format("{} variables", globals.size())});
      if (shared != 0) lines.push_back({fmt::format("{} with several writers", shared), true});
      return lines;
    }
    for (const std::uint32_t g : globals) lines.push_back({cut(flow_.globals[g].name, kLabelColumns), is_shared(g)});
    return lines;
  }

  [[nodiscard]] static std::vector<Label> facts(const Flow& one) {
    const std::size_t count = one.globals.size();
    std::vector<Label> lines = {
        {(count > kNamed ? "" : counted(count, "variable") + ", ") + counted(one.bytes, "byte")}};
    if (one.age_ns) lines.push_back({"age up to " + duration_text(static_cast<double>(*one.age_ns))});
    return lines;
  }

  [[nodiscard]] std::string tip(const std::string& heading, const std::vector<std::uint32_t>& globals) const {
    std::string text = heading;
    for (const std::uint32_t g : globals) {
      const FlowGlobal& global = flow_.globals[g];
      text +=
          fmt::format("\n{}{} : {}", global.name, global.address.empty() ? "" : " AT " + global.address, global.type);
    }
    return text;
  }

  // ---- drawing ----------------------------------------------------------------------------------------------------

  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  void text(std::string_view classes, int at_x, int at_y, std::string_view words, std::string_view anchor = "start") {
    put("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n", classes, at_x, at_y, anchor,
        escaped(words));
  }
  /// Lines of names from `top` down.
  void names(const std::vector<Label>& lines, int at_x, int top, std::string_view anchor) {
    for (const Label& line : lines) {
      text(line.shared ? "name shared" : "name", at_x, top += kLineHeight, line.text, anchor);
    }
  }
  /// An element with a tooltip, until "</g>".
  void group(std::string_view tooltip) {
    out_ += "<g><title>";
    // Line ends stay: a tooltip has a line for each variable.
    for (std::size_t at = 0; at <= tooltip.size();) {
      const std::size_t end = std::min(tooltip.find('\n', at), tooltip.size());
      if (at != 0) out_ += '\n';
      out_ += escaped(tooltip.substr(at, end - at));
      at = end + 1;
    }
    out_ += "</title>\n";
  }

  /// Calls visit(lane, y) with the height at which each lane's line lies; the first row begins at `top`.
  template <class Visit>
  void for_each_lane(int top, Visit visit) {
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      top += heights_[row];
      for (const Lane& lane : rows_[row]) visit(lane, top);
    }
  }

  void side(int left, int top, int end, std::string_view name) {
    put("<rect class=\"box\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\"/>\n", left, top, kSideWidth,
        end - top);
    text("task", left + kSideWidth / 2, top + 24, name, "middle");
    text("note", left + kSideWidth / 2, top + 42, name == "Inputs" ? "%I" : "%Q", "middle");
  }

  void outside(int top) {
    const int left = x(1) - kBoxWidth / 2;
    const int width = x(static_cast<int>(order_.size())) + kBoxWidth / 2 - left;
    group("variables that no task writes: HMIs and other clients may");
    put("<rect class=\"box\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"36\" rx=\"4\"/>\n", left, top, width);
    text("task", left + width / 2, top + 23, "Outside (HMI)", "middle");
    out_ += "</g>\n";
  }

  void task(std::uint32_t t, int lanes_end) {
    const ImageTask& task = image_.tasks[t];
    const int middle = x(column_[t]);
    std::uint64_t owned = 0, owned_bytes = 0, read = 0, read_bytes = 0;
    for (const FlowGlobal& global : flow_.globals) {
      const auto has = [&](const std::vector<std::uint32_t>& tasks) {
        return std::binary_search(tasks.begin(), tasks.end(), t);
      };
      if (has(global.writers)) ++owned, owned_bytes += global.bytes;
      if (has(global.readers) && global.owner != FlowOwner::kConstant) ++read, read_bytes += global.bytes;
    }
    group(fmt::format("{}, {}, priority {}", task.name, release_text(task), task.priority));
    put("<rect class=\"bar\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", middle - kBar,
        kTitleHeight + kBoxHeight, 2 * kBar, lanes_end - kTitleHeight - kBoxHeight);
    put("<rect class=\"box\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\"/>\n", middle - kBoxWidth / 2,
        kTitleHeight, kBoxWidth, kBoxHeight);
    text("name task", middle, kTitleHeight + 24, cut(task.name, kNameColumns), "middle");
    text("name", middle, kTitleHeight + 43, cut(release_text(task), kLabelColumns - 4), "middle");
    text("name", middle, kTitleHeight + 59, fmt::format("priority {}", task.priority), "middle");
    text("note", middle, kTitleHeight + 86,
         fmt::format("{} in ({} B), {} out ({} B)", read, read_bytes, owned, owned_bytes), "middle");
    out_ += "</g>\n";
  }

  void draw(const Lane& lane, int y) {
    const bool right = lane.to > lane.from;
    const char* const shared = lane.shared ? " shared" : "";
    // From the edge of one line to the edge of the other; the boxes at the sides have no line.
    const auto edge = [&](int column, bool faces_right) {
      const bool is_side = column == 0 || column == static_cast<int>(order_.size()) + 1;
      return column == 0 ? kMargin + kSideWidth : is_side ? x(column) : x(column) + (faces_right ? kBar : -kBar);
    };
    const int from = edge(lane.from, right), to = edge(lane.to, !right);
    const int tip = right ? to - 9 : to + 9;
    group(lane.tip);
    put("<path class=\"arrow{}\" d=\"M{} {}H{}\"/>\n", shared, from, y, lane.dots.empty() ? tip : to);
    if (lane.dots.empty()) put("<path class=\"head{}\" d=\"M{} {}L{} {}V{}Z\"/>\n", shared, to, y, tip, y - 5, y + 5);
    const int middle = (from + edge(lane.from + (right ? 1 : -1), !right)) / 2;
    names(lane.above, middle, y - 7 - static_cast<int>(lane.above.size()) * kLineHeight, "middle");
    int below = y + 2;
    for (const Label& line : lane.below) text("note", middle, below += kLineHeight - 2, line.text, "middle");
    out_ += "</g>\n";
  }

  void mark_writers(const Lane& lane, int y) {
    if (lane.dots.empty()) return;
    group(lane.tip);
    for (const int column : lane.dots) {
      put("<circle class=\"head shared\" cx=\"{}\" cy=\"{}\" r=\"6\"/>\n", x(column), y);
    }
    out_ += "</g>\n";
  }

  /// From the box below up to the line of the task; the label beside it.
  void draw_outside(const Flow& one, int top, int end) {
    const int at = x(column_[one.to.task]);
    group(tip("outside to " + image_.tasks[one.to.task].name, one.globals));
    put("<path class=\"arrow\" d=\"M{} {}V{}\"/>\n", at, top, end + 9);
    put("<path class=\"head\" d=\"M{} {}L{} {}H{}Z\"/>\n", at, end, at - 5, end + 9, at + 5);
    const std::vector<Label> lines = labels(one.globals);
    names(lines, at + 12, end + 4, "start");
    std::string fact;
    for (const Label& line : facts(one)) fact += (fact.empty() ? "" : ", ") + line.text;
    text("note", at + 12, end + 4 + static_cast<int>(lines.size() + 1) * kLineHeight, fact);
    out_ += "</g>\n";
  }

  const Image& image_;
  const DataFlow& flow_;
  std::vector<std::uint32_t> order_;  ///< tasks from left to right
  std::vector<int> column_;           ///< by task
  std::vector<std::vector<Lane>> rows_;
  std::vector<int> heights_;  ///< of the rows, and of what is below the last
  int outside_gap_ = 0;
  bool has_inputs_ = false, has_outputs_ = false, has_outside_ = false;
  std::string out_;
};

}  // namespace

std::string flow_svg(const Image& image, const DataFlow& flow) { return Drawing(image, flow).write(); }

}  // namespace plc::tools
