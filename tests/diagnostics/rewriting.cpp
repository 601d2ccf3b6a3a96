#include "tests/diagnostics/rewriting.h"

#include <algorithm>
#include <functional>

namespace plc::test {
namespace {

constexpr std::string_view kMark = "\xEF\xBB\xBF";

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

class Rewriting {
 public:
  Rewriting(std::string name, const std::string& original) : from_(original) {
    out_.name = std::move(name);
    out_.map.reserve(original.size() + 1);
  }
  [[nodiscard]] bool done() const { return at() == from_.size(); }
  [[nodiscard]] std::size_t at() const { return out_.map.size(); }
  [[nodiscard]] std::string_view rest() const { return std::string_view(from_).substr(at()); }
  [[nodiscard]] char front() const { return from_[at()]; }

  void keep(std::size_t count = 1) {
    for (const std::size_t end = at() + count; at() < end;) {
      const char c = front();
      out_.map.push_back(out_.text.size());
      out_.text += c;
    }
  }
  void drop(std::size_t count) { out_.map.insert(out_.map.end(), count, out_.text.size()); }
  void insert(std::string_view text) { out_.text += text; }
  /// `count` bytes, which are one character, are written otherwise.
  void replace(std::size_t count, std::string_view text) {
    drop(count);
    insert(text);
  }
  Variant finish() {
    out_.map.push_back(out_.text.size());
    out_.bytes = out_.text;
    return std::move(out_);
  }

 private:
  const std::string& from_;
  Variant out_;
};

/// Goes over the original, markup as it is; `text` is called at each text and each section that holds more than blanks,
/// and goes over `length` bytes.
template <class Text>
Variant over_texts(std::string name, const std::string& original, Text text) {
  constexpr std::string_view kSection = "<![CDATA[";
  Rewriting r(std::move(name), original);
  const auto through = [&r](std::string_view closing) {
    const std::size_t end = r.rest().find(closing);
    r.keep(end == std::string_view::npos ? r.rest().size() : end + closing.size());
  };
  while (!r.done()) {
    const std::string_view rest = r.rest();
    if (rest.starts_with(kSection)) {
      const std::size_t end = rest.find("]]>");
      if (end == std::string_view::npos) {
        r.keep(rest.size());
      } else {
        text(r, kSection.size(), end - kSection.size(), true);
      }
    } else if (rest.starts_with("<!--")) {
      through("-->");
    } else if (rest.starts_with("<?")) {
      through("?>");
    } else if (rest.starts_with("<")) {
      char quote = '\0';
      while (!r.done()) {
        const char c = r.front();
        r.keep();
        if (quote == '\0' && c == '>') break;
        if (quote == c) {
          quote = '\0';
        } else if (quote == '\0' && (c == '"' || c == '\'')) {
          quote = c;
        }
      }
    } else {
      const std::size_t length = std::min(rest.find('<'), rest.size());
      const bool blank = rest.substr(0, length).find_first_not_of(" \t\n") == std::string_view::npos;
      if (blank || rest.size() == length) {
        r.keep(length);
      } else {
        text(r, 0, length, false);
      }
    }
  }
  return r.finish();
}

Variant with_line_ends(std::string name, const std::string& original, std::string_view end) {
  Rewriting r(std::move(name), original);
  while (!r.done()) {
    if (r.front() == '\n') {
      r.replace(1, end);
    } else {
      r.keep();
    }
  }
  return r.finish();
}

Variant with_mark(const std::string& original) {
  Rewriting r("byte order mark", original);
  r.insert(kMark);
  r.keep(original.size());
  return r.finish();
}

/// A CR alone for the blank before an assignment.
Variant with_lone_returns(const std::string& original) {
  Rewriting r("CR alone", original);
  while (!r.done()) {
    if (r.rest().starts_with(" :=")) {
      r.replace(1, "\r");
    } else {
      r.keep();
    }
  }
  return r.finish();
}

Variant in_utf16(const std::string& original) {
  Rewriting r("UTF-16", original);
  r.keep(original.size());
  Variant out = r.finish();
  out.bytes = "\xFF\xFE";
  for (std::size_t i = 0; i < original.size();) {
    std::uint32_t point = static_cast<unsigned char>(original[i++]);
    if (point >= 0xC0) {
      point &= point >= 0xF0 ? 0x07u : point >= 0xE0 ? 0x0Fu : 0x1Fu;
      while (i < original.size() && continues(original[i])) {
        point = point << 6 | (static_cast<unsigned char>(original[i++]) & 0x3Fu);
      }
    }
    const auto unit = [&](std::uint32_t u) {
      out.bytes += static_cast<char>(u & 0xFFu);
      out.bytes += static_cast<char>(u >> 8);
    };
    if (point >= 0x10000) {
      unit(0xD800u + ((point - 0x10000u) >> 10));
      unit(0xDC00u + ((point - 0x10000u) & 0x3FFu));
    } else {
      unit(point);
    }
  }
  return out;
}

struct Entity {
  std::string_view name, character;
};
constexpr Entity kEntities[] = {{"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}, {"&quot;", "\""}, {"&apos;", "'"}};

void keep_entity_or_character(Rewriting& r) {
  const std::size_t end = r.front() == '&' ? r.rest().find(';') : 0;
  r.keep(end == std::string_view::npos ? 1 : end + 1);
}

/// Sections become entities, and so do some characters of all texts.
Variant with_entities(const std::string& original) {
  return over_texts("entities", original, [](Rewriting& r, std::size_t border, std::size_t length, bool section) {
    r.drop(border);
    for (const std::size_t end = r.at() + length; r.at() < end;) {
      const char c = r.front();
      if (!section && c == '&') {
        keep_entity_or_character(r);
      } else if (c == '<') {
        r.replace(1, "&lt;");
      } else if (c == '&') {
        r.replace(1, "&amp;");
      } else if (c == '=') {
        r.replace(1, "&#x3D;");
      } else if (c == ';' || c == '(') {
        r.replace(1, c == ';' ? "&#59;" : "&#40;");
      } else {
        r.keep();
      }
    }
    if (section) r.drop(3);
  });
}

/// Texts become sections, in two parts where they have a semicolon.
Variant with_sections(const std::string& original) {
  return over_texts("sections", original, [](Rewriting& r, std::size_t border, std::size_t length, bool section) {
    if (section) {
      r.keep(border);
    } else {
      r.insert("<![CDATA[");
    }
    for (const std::size_t end = r.at() + length; r.at() < end;) {
      const auto entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                       [&](const Entity& one) { return !section && r.rest().starts_with(one.name); });
      if (entity != std::end(kEntities)) {
        r.replace(entity->name.size(), entity->character);
      } else if (!section && r.front() == '&') {
        r.insert("]]>");
        keep_entity_or_character(r);
        r.insert("<![CDATA[");
      } else {
        const bool part = r.front() == ';';
        r.keep();
        if (part) r.insert("]]><![CDATA[");
      }
    }
    if (section) {
      r.keep(3);
    } else {
      r.insert("]]>");
    }
  });
}

/// Comments of XML, elements and characters of several bytes inside of texts.
Variant with_comments(const std::string& original) {
  return over_texts("comments", original, [](Rewriting& r, std::size_t border, std::size_t length, bool section) {
    r.keep(border);
    for (const std::size_t end = r.at() + length; r.at() < end;) {
      const bool part = r.front() == ';' && r.rest().find_first_of("\n<") != 1;
      if (!section && r.front() == '&') {
        keep_entity_or_character(r);
        continue;
      }
      r.keep();
      if (part) r.insert(section ? " (* \xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80 *)" : "<!-- \xC3\xA4 -->");
    }
    if (section) r.keep(3);
  });
}

/// CR CR LF inside of texts only: what OpenPLC Editor writes on Windows.
Variant with_returns_in_texts(const std::string& original) {
  return over_texts("CR CR LF in texts", original,
                    [](Rewriting& r, std::size_t border, std::size_t length, bool section) {
                      r.keep(border);
                      for (const std::size_t end = r.at() + length; r.at() < end;) {
                        if (r.front() == '\n') {
                          r.replace(1, "\r\r\n");
                        } else {
                          r.keep();
                        }
                      }
                      if (section) r.keep(3);
                    });
}

}  // namespace

Position position_of(std::string_view text, std::size_t offset) {
  Position out;
  for (std::size_t i = text.starts_with(kMark) ? kMark.size() : 0; i < offset && i < text.size(); ++i) {
    if (text[i] == '\n') {
      ++out.line;
      out.column = 1;
    } else if (i + 1 == text.size() || !continues(text[i + 1])) {
      ++out.column;
    }
  }
  return out;
}

std::size_t offset_of(std::string_view text, const Position& position) {
  std::size_t i = text.starts_with(kMark) ? kMark.size() : 0;
  for (std::uint32_t line = 1; line < position.line; ++line) {
    i = text.find('\n', i);
    if (i == std::string_view::npos) return i;
    ++i;
  }
  for (std::uint32_t column = 1; column < position.column; ++column) {
    if (i >= text.size() || text[i] == '\n') return std::string_view::npos;
    ++i;
    while (i < text.size() && continues(text[i])) ++i;
  }
  return i;
}

std::vector<Variant> variants_of(const std::string& original, bool markup) {
  std::vector<Variant> all;
  all.push_back(with_line_ends("CR LF", original, "\r\n"));
  all.push_back(with_line_ends("CR CR LF", original, "\r\r\n"));
  all.push_back(with_mark(original));
  all.push_back(in_utf16(original));
  all.push_back(with_lone_returns(original));
  if (!markup) return all;
  all.push_back(with_returns_in_texts(original));
  all.push_back(with_entities(original));
  all.push_back(with_sections(original));
  all.push_back(with_comments(original));
  return all;
}

}  // namespace plc::test
