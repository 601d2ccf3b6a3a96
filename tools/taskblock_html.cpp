#include "tools/taskblock_html.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/text.h"
#include "tools/plcopen_text.h"
#include "tools/taskblock_text.h"

namespace plc::tools {
namespace {

constexpr std::string_view kStyle =
    R"(body { font: 16px/1.5 sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { margin-bottom: 0; }
nav, footer { color: #666; font-size: 14px; }
table { border-collapse: collapse; }
th, td { text-align: left; vertical-align: top; padding: .2em 1em .2em 0; border-bottom: 1px solid #ddd; }
pre, code { font: 14px/1.4 monospace; background: #f4f4f4; }
pre { padding: .8em; overflow-x: auto; }
svg { max-width: 100%; height: auto; }
.box { fill: #eef4fb; stroke: #345; }
.wire { stroke: #345; }
.name { font: 14px monospace; fill: #222; }
.title { font: bold 14px monospace; fill: #222; }
.type { font: 12px monospace; fill: #666; }
)";

std::string page(std::string_view title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n"
      "<body>\n{}</body>\n</html>\n",
      xml_escaped(title), kStyle, body);
}

/// `code` and **words** of a line of Markdown; everything else is text.
std::string inline_html(std::string_view text) {
  struct Mark {
    std::string_view sign, element;
  };
  constexpr Mark kMarks[] = {{"`", "code"}, {"**", "b"}};
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto mark = std::find_if(std::begin(kMarks), std::end(kMarks),
                                   [&](const Mark& m) { return text.substr(at).starts_with(m.sign); });
    const std::size_t begin = mark != std::end(kMarks) ? at + mark->sign.size() : at;
    const std::size_t end = mark != std::end(kMarks) ? text.find(mark->sign, begin) : std::string_view::npos;
    if (end == std::string_view::npos) {
      out += xml_escaped(text.substr(at, 1));
      ++at;
      continue;
    }
    out += fmt::format("<{0}>{1}</{0}>", mark->element, xml_escaped(text.substr(begin, end - begin)));
    at = end + mark->sign.size();
  }
  return out;
}

std::string details_html(std::string_view markdown) {
  std::string out;
  bool in_list = false;
  for (const DetailsPart& part : details_parts(markdown)) {
    if (part.item != in_list) out += part.item ? "<ul>\n" : "</ul>\n";
    in_list = part.item;
    out += fmt::format("<{0}>{1}</{0}>\n", part.item ? "li" : "p", inline_html(part.text));
  }
  return in_list ? out + "</ul>\n" : out;
}

std::string table_html(const std::vector<std::vector<std::string>>& lines) {
  std::string out = "<table>\n";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out += "<tr>";
    for (const std::string& cell : lines[i])
      out += fmt::format("<{0}>{1}</{0}>", i == 0 ? "th" : "td", xml_escaped(cell));
    out += "</tr>\n";
  }
  return out + "</table>\n";
}

std::string file_of(const picard_block& block) { return core::folded(block.name); }

std::string block_page(const taskblocks::Registry::Entry& entry) {
  const picard_block& block = *entry.block;
  std::string body =
      fmt::format("<nav><a href=\"index.html\">Taskblocks</a> / {}</nav>\n<h1>{}</h1>\n<p>{}</p>\n{}",
                  xml_escaped(block.group), xml_escaped(block.name), inline_html(block.summary), taskblock_svg(block));
  body += "<h2>Ports</h2>\n" + table_html(port_cells(block));
  if (block.details[0] != '\0') body += "<h2>Details</h2>\n" + details_html(block.details);
  std::string types;
  for (const picard_type* type : taskblocks::data_types_of(block)) types += taskblocks::declaration(*type);
  if (!types.empty()) body += fmt::format("<h2>Data types</h2>\n<pre>{}</pre>\n", xml_escaped(types));
  body += fmt::format("<h2>In ST</h2>\n<pre>{}</pre>\n", xml_escaped(call_text(block)));
  if (taskblock_example(block) != nullptr) {
    body += fmt::format(
        "<p>Drawn example: <a href=\"{0}.xml\">{0}.xml</a>, to run with "
        "<code>plc sim {0}.xml</code> and to import into an editor.</p>\n",
        file_of(block));
  }
  body += fmt::format(
      "<footer>Library {} {}{}</footer>\n", xml_escaped(entry.library->name), xml_escaped(entry.library->version),
      block.budget_ns == 0 ? "" : fmt::format("; time budget {} us", static_cast<double>(block.budget_ns) / 1e3));
  return page(block.name, body);
}

}  // namespace

std::string taskblock_svg(const picard_block& block) {
  constexpr int kRow = 24, kHead = 34, kWire = 30, kLetter = 9, kSmall = 8;
  std::vector<const picard_port*> left, right;
  int left_name = 0, right_name = 0, left_type = 0, right_type = 0;
  for (std::uint32_t i = 0; i < block.port_count; ++i) {
    const picard_port& port = block.ports[i];
    const bool out = port.direction == PICARD_OUTPUT;
    (out ? right : left).push_back(&port);
    int& name = out ? right_name : left_name;
    int& type = out ? right_type : left_type;
    name = std::max(name, kLetter * static_cast<int>(std::string_view(port.name).size()));
    type = std::max(type, kSmall * static_cast<int>(taskblocks::type_text(*port.type).size()));
  }
  // As declarations list them.
  std::stable_partition(left.begin(), left.end(), [](const picard_port* p) { return p->direction != PICARD_CONFIG; });
  const int title = kLetter * static_cast<int>(std::string_view(block.name).size());
  const int x = left_type + kWire + 10;
  const int width = std::max(left_name + right_name + 40, title + 20);
  const int height = kHead + kRow * static_cast<int>(std::max(left.size(), right.size())) + 6;
  const int whole = x + width + kWire + right_type + 10;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-label=\"{2}\">\n<rect class=\"box\" x=\"{3}\" y=\"1\" width=\"{4}\" height=\"{5}\"/>\n"
      "<text class=\"title\" x=\"{6}\" y=\"21\" text-anchor=\"middle\">{2}</text>\n",
      whole, height + 2, xml_escaped(block.name), x, width, height, x + width / 2);
  const auto draw = [&](const std::vector<const picard_port*>& ports, bool on_the_right) {
    int y = kHead + kRow / 2;
    for (const picard_port* port : ports) {
      const int edge = on_the_right ? x + width : x;
      const int sign = on_the_right ? 1 : -1;
      const auto wire = [&](int at) {
        out += fmt::format("<line class=\"wire\" x1=\"{0}\" y1=\"{2}\" x2=\"{1}\" y2=\"{2}\"/>\n", edge,
                           edge + sign * kWire, at);
      };
      if (port->direction == PICARD_CONFIG) {
        wire(y - 2);
        wire(y + 2);
      } else {
        wire(y);
      }
      const char* const inner = on_the_right ? "end" : "start";
      const char* const outer = on_the_right ? "start" : "end";
      out += fmt::format("<text class=\"name\" x=\"{}\" y=\"{}\" text-anchor=\"{}\"><title>{}</title>{}</text>\n",
                         edge - sign * 6, y + 5, inner, xml_escaped(port->summary), xml_escaped(port->name));
      out += fmt::format("<text class=\"type\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                         edge + sign * (kWire + 4), y + 4, outer, xml_escaped(taskblocks::type_text(*port->type)));
      y += kRow;
    }
  };
  draw(left, false);
  draw(right, true);
  return out + "</svg>\n";
}

std::vector<HtmlFile> taskblock_html(const taskblocks::Registry& registry) {
  std::vector<HtmlFile> files = {{"index.html", {}}};
  std::string index =
      "<h1>Taskblocks</h1>\n<p>Components in C++ that drawings and texts use like any function block. "
      "<code>plc blocks</code> prints the same; <code>plc blocks --xml</code> writes a library for editors.</p>\n";
  for (const TaskblockGroup& group : taskblock_groups(registry)) {
    index += fmt::format("<h2>{}</h2>\n<table>\n", xml_escaped(group.title));
    for (const taskblocks::Registry::Entry* entry : group.entries) {
      const picard_block& block = *entry->block;
      index += fmt::format("<tr><td><a href=\"{}.html\">{}</a></td><td>{}</td></tr>\n", file_of(block), block.name,
                           inline_html(block.summary));
      files.push_back({file_of(block) + ".html", block_page(*entry)});
      if (const TaskblockExample* example = taskblock_example(block)) {
        files.push_back({file_of(block) + ".xml", std::string(example->text)});
      }
    }
    index += "</table>\n";
  }
  files.front().text = page("Taskblocks", index);
  return files;
}

}  // namespace plc::tools
