#include <fmt/format.h>

#include <algorithm>

#include "hmi/document.h"

namespace plc::hmi {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string value_text(const Value& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
  std::string list;
  for (const std::string& one : std::get<std::vector<std::string>>(value)) {
    list += list.empty() ? "" : ", ";
    list += quoted(one);
  }
  return "[" + list + "]";
}

void add_comment(const std::vector<std::string>& lines, std::string& out) {
  for (const std::string& line : lines) out += "#" + line + "\n";
}

}  // namespace

std::string write_document(const Document& document) {
  std::string out;
  add_comment(document.comment, out);
  for (const Page& page : document.pages) {
    if (!out.empty()) out += '\n';
    add_comment(page.comment, out);
    out += "[[page]]\n";
    out += fmt::format("name = {}\n", quoted(page.name));
    if (!page.title.empty()) out += fmt::format("title = {}\n", quoted(page.title));
    out += fmt::format("columns = {}\nrows = {}\n", page.columns, page.rows);
    for (const Element& element : page.elements) {
      out += '\n';
      add_comment(element.comment, out);
      out += fmt::format("[[page.element]]\nkind = \"{}\"\nx = {}\ny = {}\nwidth = {}\nheight = {}\n",
                         row_of(element.kind).name, element.x, element.y, element.width, element.height);
      for (std::size_t i = 0; i < kKeyCount; ++i) {
        if (element.values[i].index() == 0) continue;
        out += fmt::format("{} = {}\n", kKeys[i].name, value_text(element.values[i]));
      }
    }
  }
  return out;
}

std::string field_of_line(std::string_view written, std::uint32_t line) {
  std::string page, element;
  std::size_t pages = 0, elements = 0;
  for (; line > 0 && !written.empty(); --line) {
    const std::string_view text = written.substr(0, written.find('\n'));
    written.remove_prefix(std::min(text.size() + 1, written.size()));
    if (text == "[[page]]") {
      page = fmt::format("pages[{}]", pages++);
      element.clear();
      elements = 0;
    } else if (text == "[[page.element]]") {
      element = fmt::format(".elements[{}]", elements++);
    }
    if (line > 1) continue;
    const std::size_t end = text.starts_with('#') ? std::string_view::npos : text.find(" = ");
    const bool has_key = end != std::string_view::npos && !page.empty();
    return page + element + (has_key ? "." + std::string(text.substr(0, end)) : std::string());
  }
  return {};
}

}  // namespace plc::hmi
