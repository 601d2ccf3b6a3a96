// The reader of pages.toml; with io-drivers/config the only user of toml++.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/guess.h"
#include "core/text.h"
#include "core/toml_limits.h"
#include "hmi/comments.h"
#include "hmi/document.h"

namespace plc::hmi {
namespace {

using core::Code;
using core::SourceRef;

constexpr std::string_view kPageKeys[] = {"name", "title", "columns", "rows", "element"};
constexpr std::string_view kPlaceKeys[] = {"kind", "x", "y", "width", "height"};

std::string_view type_word(const toml::node& node) {
  // In the order of toml::node_type.
  constexpr std::string_view kWords[] = {
      "nothing", "a table", "a list", "a text", "a whole number", "a number with a fraction", "true or false"};
  const auto type = static_cast<std::size_t>(node.type());
  return type < std::size(kWords) ? kWords[type] : "a date or time";
}

std::string_view type_word(KeyType type) {
  constexpr std::string_view kWords[] = {"a text",        "a whole number", "a number",
                                         "true or false", "a plain value",  "a list of texts"};
  return kWords[static_cast<std::size_t>(type)];
}

bool is_format(std::string_view text) {
  if (text == "16#" || text == "2#" || text == "8#" || text == "0") return true;
  return text.size() >= 3 && text.size() <= 11 && text.starts_with("0.") &&
         text.find_first_not_of('0', 2) == std::string_view::npos;
}

bool is_page_name(std::string_view name) {
  constexpr std::string_view kGood = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  return !name.empty() && name.size() <= 40 && name.find_first_not_of(kGood) == std::string_view::npos;
}

/// A name that stays in its folder.
bool is_picture_name(std::string_view name) {
  if (name.empty() || name.front() == '.' || name.find_first_of("/\\") != std::string_view::npos) return false;
  const std::string folded = core::folded(name);
  constexpr std::string_view kEndings[] = {".png", ".jpg", ".jpeg", ".gif", ".webp", ".svg"};
  return std::any_of(std::begin(kEndings), std::end(kEndings), [&](auto one) { return folded.ends_with(one); });
}

template <class Names>
std::string guess_help(std::string_view wrong, const Names& names) {
  core::Guess guess(wrong);
  std::string all;
  for (const std::string_view name : names) {
    guess.offer(name);
    all += all.empty() ? "" : ", ";
    all += name;
  }
  return guess.best().empty() ? "there are " + all : guess.help();
}

class Reader {
 public:
  Reader(std::uint16_t file, core::Diagnostics& diagnostics) : diagnostics_(diagnostics) { file_at_.file = file; }

  Document read(const toml::table& root) {
    Document document;
    for (const auto& [name, node] : root) {
      if (name.str() != "page") {
        report(Code::P7771, at(node), fmt::format("\"{}\" is no key here", name.str()), "pages begin with [[page]]");
      }
    }
    each_table(root, "page", "[[page]]", kMostPages, file_at_,
               [&](const toml::table& table) { document.pages.push_back(page(table)); });
    check_names(document);
    return document;
  }

 private:
  SourceRef at(const toml::node& node) const {
    SourceRef place = file_at_;
    place.line = node.source().begin.line;
    place.column = node.source().begin.column;
    return place;
  }
  void report(Code code, const SourceRef& place, std::string text, std::string help = {}) {
    diagnostics_.report(code, place, {}, std::move(text), std::move(help));
  }

  /// Calls `take` with each table of a list of tables.
  template <class Take>
  void each_table(const toml::table& in, std::string_view name, std::string_view form, std::size_t most,
                  const SourceRef& place, Take take) {
    const toml::node* const node = in.get(name);
    if (node == nullptr) return;
    const toml::array* const list = node->as_array();
    if (list == nullptr || !std::all_of(list->begin(), list->end(), [](const auto& one) { return one.is_table(); })) {
      return report(Code::P7772, at(*node), fmt::format("{} is {}, and should be tables", name, type_word(*node)),
                    fmt::format("each begins with {}", form));
    }
    if (list->size() > most) {
      return report(Code::P7774, place,
                    fmt::format("there are {} of {}, and at most {} may be", list->size(), form, most));
    }
    for (const toml::node& one : *list) take(*one.as_table());
  }

  Page page(const toml::table& table) {
    Page page;
    page.at = at(table);
    for (const auto& [name, node] : table) {
      if (std::find(std::begin(kPageKeys), std::end(kPageKeys), name.str()) == std::end(kPageKeys)) {
        report(Code::P7771, at(node), fmt::format("\"{}\" is no key of a page", name.str()),
               guess_help(name.str(), kPageKeys));
      }
    }
    page.name = text(table, "name", page.at, true);
    if (table.contains("name") && !is_page_name(page.name)) {
      report(Code::P7772, at(*table.get("name")), fmt::format("\"{}\" is no name of a page", page.name),
             "letters, digits, - and _, at most 40; what people read is its title");
    }
    page.title = text(table, "title", page.at, false);
    page.columns = integer(table, "columns", 1, kMostCells, page.at, kColumns);
    page.rows = integer(table, "rows", 1, kMostCells, page.at, kRows);
    each_table(table, "element", "[[page.element]]", kMostElements, page.at, [&](const toml::table& one) {
      if (auto found = element(one, page)) page.elements.push_back(std::move(*found));
    });
    return page;
  }

  std::string text(const toml::table& table, std::string_view name, const SourceRef& place, bool required) {
    const toml::node* const node = table.get(name);
    if (node == nullptr) {
      if (required) report(Code::P7773, place, fmt::format("{} is missing", name));
      return {};
    }
    if (!node->is_string()) return wrong_type(*node, name, "a text"), std::string();
    return checked(node->as_string()->get(), *node, name);
  }

  std::string checked(const std::string& text, const toml::node& node, std::string_view name) {
    if (text.size() > kMostText) {
      report(Code::P7772, at(node), fmt::format("{} has more than {} characters", name, kMostText));
    }
    return text.substr(0, kMostText);
  }

  std::int64_t integer(const toml::table& table, std::string_view name, std::int64_t low, std::int64_t high,
                       const SourceRef& place, std::optional<std::int64_t> otherwise) {
    const toml::node* const node = table.get(name);
    if (node == nullptr) {
      if (!otherwise) report(Code::P7773, place, fmt::format("{} is missing", name));
      return otherwise.value_or(low);
    }
    if (!node->is_integer()) return wrong_type(*node, name, "a whole number"), low;
    const std::int64_t number = node->as_integer()->get();
    if (number < low || number > high) {
      report(Code::P7774, at(*node), fmt::format("{} is {}, and should be from {} to {}", name, number, low, high));
    }
    return std::clamp(number, low, high);
  }

  void wrong_type(const toml::node& node, std::string_view name, std::string_view wanted) {
    report(Code::P7772, at(node), fmt::format("{} is {}, and should be {}", name, type_word(node), wanted));
  }

  std::optional<Element> element(const toml::table& table, const Page& page) {
    Element element;
    element.at = at(table);
    const std::string kind = text(table, "kind", element.at, true);
    const auto* const row =
        std::find_if(std::begin(kKinds), std::end(kKinds), [&](auto& one) { return one.name == kind; });
    if (row == std::end(kKinds)) {
      if (table.contains("kind")) {
        std::vector<std::string_view> names;
        for (const KindRow& one : kKinds) names.push_back(one.name);
        report(Code::P7771, at(*table.get("kind")), fmt::format("\"{}\" is no kind of element", kind),
               guess_help(kind, names));
      }
      return std::nullopt;
    }
    element.kind = static_cast<Kind>(row - kKinds);
    element.x = integer(table, "x", 0, page.columns - 1, element.at, std::nullopt);
    element.y = integer(table, "y", 0, page.rows - 1, element.at, std::nullopt);
    element.width = integer(table, "width", 1, page.columns, element.at, row->width);
    element.height = integer(table, "height", 1, page.rows, element.at, row->height);
    if (element.x + element.width > page.columns || element.y + element.height > page.rows) {
      report(Code::P7774, element.at,
             fmt::format("the {} ends at column {}, row {}, and page \"{}\" has {} columns, {} rows", row->name,
                         element.x + element.width, element.y + element.height, page.name, page.columns, page.rows));
    }
    keys(table, element);
    return element;
  }

  void keys(const toml::table& table, Element& element) {
    const KindRow& kind = row_of(element.kind);
    for (const auto& [name, node] : table) {
      if (std::find(std::begin(kPlaceKeys), std::end(kPlaceKeys), name.str()) != std::end(kPlaceKeys)) continue;
      const auto* const row =
          std::find_if(std::begin(kKeys), std::end(kKeys), [&n = name](auto& one) { return one.name == n.str(); });
      if (row == std::end(kKeys) || (row->kinds & bit(element.kind)) == 0) {
        std::vector<std::string_view> names;
        for (const KeyRow& one : kKeys) {
          if ((one.kinds & bit(element.kind)) != 0) names.push_back(one.name);
        }
        report(Code::P7771, at(node), fmt::format("\"{}\" is no key of a {}", name.str(), kind.name),
               guess_help(name.str(), names));
        continue;
      }
      const auto position = static_cast<std::size_t>(row - kKeys);
      element.values[position] = value(node, *row);
      element.places[position] = {node.source().begin.line, node.source().begin.column};
    }
    for (std::size_t i = 0; i < kKeyCount; ++i) {
      if ((kKeys[i].required & bit(element.kind)) == 0 || element.values[i].index() != 0) continue;
      if (!table.contains(kKeys[i].name)) {
        report(Code::P7773, element.at, fmt::format("{} of the {} is missing", kKeys[i].name, kind.name));
      }
    }
    check(element);
  }

  Value value(const toml::node& node, const KeyRow& row) {
    const auto number = [&]() -> std::optional<double> {
      if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
      if (const auto* real = node.as_floating_point()) return real->get();
      return std::nullopt;
    };
    const bool any = row.type == KeyType::kValue;
    if ((any || row.type == KeyType::kBoolean) && node.is_boolean()) return node.as_boolean()->get();
    if ((any || row.type == KeyType::kNumber) && number()) {
      if (!std::isfinite(*number())) {
        report(Code::P7772, at(node), fmt::format("{} is no number of use", row.name));
        return {};
      }
      return *number();
    }
    if ((any || row.type == KeyType::kText) && node.is_string()) {
      std::string text = checked(node.as_string()->get(), node, row.name);
      if (!row.choices.empty() && ("|" + std::string(row.choices) + "|").find("|" + text + "|") == std::string::npos) {
        report(Code::P7772, at(node),
               fmt::format("{} is \"{}\", and should be one of {}", row.name, text, row.choices));
      }
      return text;
    }
    if (row.type == KeyType::kTexts && node.is_array()) {
      std::vector<std::string> texts;
      for (const toml::node& one : *node.as_array()) {
        if (!one.is_string()) return wrong_type(one, row.name, "texts"), Value();
        texts.push_back(checked(one.as_string()->get(), one, row.name));
      }
      if (texts.size() > kMostPlotted || texts.empty()) {
        report(Code::P7772, at(node),
               fmt::format("{} has {} entries, and should have 1 to {}", row.name, texts.size(), kMostPlotted));
      }
      return texts;
    }
    wrong_type(node, row.name, type_word(row.type));
    return {};
  }

  /// What keys of one element mean for each other.
  void check(const Element& element) {
    const bool has_scale = ((bits(Kind::kSlider, Kind::kGauge, Kind::kBar, Kind::kTank) & bit(element.kind)) != 0);
    auto low = element.number(key("low")), high = element.number(key("high"));
    if (has_scale) {
      low = low.value_or(kLow);
      high = high.value_or(kHigh);
    }
    if (low && high && *low >= *high) {
      report(Code::P7772, element.place(element.values[key("high")].index() == 0 ? key("low") : key("high")),
             fmt::format("high is {}, and should be more than low, {}", *high, *low));
    }
    for (const std::string_view name : {"step", "seconds"}) {
      const std::size_t which = name == "step" ? key("step") : key("seconds");
      if (const auto number = element.number(which); number && *number <= 0) {
        report(Code::P7772, element.place(which), fmt::format("{} is {}, and should be more than 0", name, *number));
      }
    }
    const std::string_view format = element.text(key("format"));
    if (!format.empty() && !is_format(format)) {
      report(Code::P7772, element.place(key("format")), fmt::format("\"{}\" is no format", format),
             R"("0", "0.0", "0.00" .. for so many places; "16#", "2#", "8#" for bits)");
    }
    const std::string_view file = element.text(key("file"));
    if (element.kind == Kind::kPicture && element.values[key("file")].index() != 0 && !is_picture_name(file)) {
      report(Code::P7772, element.place(key("file")), fmt::format("\"{}\" is no name of a picture", file),
             "a file beside pages.toml, without a folder: .png, .jpg, .gif, .webp or .svg");
    }
  }

  void check_names(const Document& document) {
    std::set<std::string_view> names;
    for (const Page& page : document.pages) {
      if (!page.name.empty() && !names.insert(page.name).second) {
        report(Code::P7775, page.at, fmt::format("there are two pages \"{}\"", page.name));
      }
    }
    for (const Page& page : document.pages) {
      for (const Element& element : page.elements) {
        const std::string_view to = element.text(key("page"));
        if (element.kind == Kind::kLink && !to.empty() && !names.contains(to)) {
          report(Code::P7775, element.place(key("page")), fmt::format("there is no page \"{}\"", to),
                 guess_help(to, names));
        }
      }
    }
  }

  core::Diagnostics& diagnostics_;
  SourceRef file_at_;
};

/// Gives each comment to the table that it stands in, or right before.
void add_comments(std::string_view text, Document& document) {
  struct Table {
    std::uint32_t line;
    std::vector<std::string>* comment;
  };
  std::vector<Table> tables;
  for (Page& page : document.pages) {
    tables.push_back({page.at.line, &page.comment});
    for (Element& element : page.elements) tables.push_back({element.at.line, &element.comment});
  }
  std::stable_sort(tables.begin(), tables.end(), [](const Table& a, const Table& b) { return a.line < b.line; });
  const Lines lines = lines_of(text);
  const auto count = static_cast<std::uint32_t>(lines.used.size());
  // By line: the next one with something other than a comment in it, and the next one without a comment.
  std::vector<bool> is_comment(count, false);
  for (const Comment& comment : lines.comments) is_comment[comment.line] = comment.alone;
  std::vector<std::uint32_t> next_used(count + 1, count), next_other(count + 1, count);
  for (std::uint32_t line = count; line-- > 0;) {
    next_used[line] = lines.used[line] ? line : next_used[line + 1];
    next_other[line] = is_comment[line] ? next_other[line + 1] : line;
  }
  for (const Comment& comment : lines.comments) {
    const auto after = std::upper_bound(tables.begin(), tables.end(), comment.line,
                                        [](std::uint32_t line, const Table& one) { return line < one.line; });
    const bool before_table = comment.alone && after != tables.end() && after->line == next_used[comment.line];
    if (before_table && after == tables.begin()) {
      // A blank line between: it is about the whole file.
      const bool beside = next_other[comment.line] == after->line;
      (beside ? *after->comment : document.comment).push_back(comment.text);
    } else if (before_table) {
      after->comment->push_back(comment.text);
    } else {
      (after == tables.begin() ? document.comment : *std::prev(after)->comment).push_back(comment.text);
    }
  }
}

}  // namespace

std::optional<Document> read_document(std::string_view text, std::string_view file, core::Diagnostics& diagnostics) {
  SourceRef at;
  at.file = diagnostics.add_file(std::string(file));
  const std::size_t before = diagnostics.error_count();
  if (text.size() > core::kMaxTomlBytes) {
    diagnostics.report(Code::P7770, at, {}, fmt::format("file has more than {} bytes", core::kMaxTomlBytes));
    return std::nullopt;
  }
  if (const auto unsafe = core::find_unsafe(text)) {
    at.line = unsafe->line;
    at.column = unsafe->column;
    const bool deep = unsafe->kind == core::TextProblem::Kind::kTooDeep;
    diagnostics.report(Code::P7770, at, {},
                       deep ? fmt::format("nested more than {} deep", core::kMaxTomlDepth)
                            : "a character that has no place outside of texts and comments",
                       deep ? "" : "texts are written in quotes");
    return std::nullopt;
  }
  try {
    const toml::table root = toml::parse(text, file);
    Document document = Reader(at.file, diagnostics).read(root);
    if (diagnostics.error_count() != before) return std::nullopt;
    add_comments(text, document);
    return document;
  } catch (const toml::parse_error& error) {
    at.line = error.source().begin.line;
    at.column = error.source().begin.column;
    std::string message{error.description()};
    if (!message.empty()) message.front() = core::fold(message.front());
    diagnostics.report(Code::P7770, at, {}, std::move(message), "https://toml.io/en/v1.0.0 has the rules");
    return std::nullopt;
  }
}

}  // namespace plc::hmi
