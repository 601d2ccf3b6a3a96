#include "io-drivers/config/table_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/duration.h"
#include "core/guess.h"
#include "core/text.h"
#include "core/toml_limits.h"
#include "io-drivers/config/findings.h"

namespace plc::io {
namespace {

using core::Code;
using core::SourceRef;

std::string scalar_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* boolean = node.as_boolean()) return boolean->get() ? "true" : "false";
  return {};
}

std::string heading_of(const FileTable& table) {
  return table.many ? fmt::format("[[{}]]", table.name) : fmt::format("[{}]", table.name);
}

class TableFileReader {
 public:
  TableFileReader(std::uint16_t file, std::span<const FileTable> tables, Findings& findings)
      : tables_(tables), findings_(findings) {
    file_.file = file;
  }

  std::vector<ReadTable> read(const toml::table& root) {
    for (const auto& [key, node] : root) {
      const std::string_view name = key.str();
      const auto table =
          std::find_if(tables_.begin(), tables_.end(), [&](const FileTable& t) { return t.name == name; });
      if (table == tables_.end()) {
        core::Guess guess(name);
        for (const FileTable& known : tables_) guess.offer(known.name);
        findings_.add(Code::P7303, place(key.source()), fmt::format("no table \"{}\" in this file", name),
                      guess.help());
      } else if (table->many ? !node.is_array_of_tables() : !node.is_table()) {
        findings_.add(Code::P7304, place(key.source()),
                      fmt::format("\"{}\" is not {}", name, table->many ? "a list of tables" : "a table"),
                      "write " + heading_of(*table));
      } else if (table->many) {
        for (const toml::node& one : *node.as_array()) read_table(*table, *one.as_table());
      } else {
        read_table(*table, *node.as_table());
      }
    }
    return std::move(read_);
  }

 private:
  [[nodiscard]] SourceRef place(const toml::source_region& region) const {
    SourceRef at = file_;
    at.line = region.begin.line;
    at.column = region.begin.column;
    return at;
  }

  void read_table(const FileTable& table, const toml::table& from) {
    const std::size_t wrong = findings_.size();
    const std::string heading = heading_of(table);
    ReadTable to{&table, place(from.source()), KeyValues(table.keys)};
    for (const auto& [key, node] : from) {
      const std::string_view name = key.str();
      const auto row =
          std::find_if(table.keys.begin(), table.keys.end(), [&](const KeyInfo& k) { return k.name == name; });
      if (row == table.keys.end()) {
        core::Guess guess(name);
        for (const KeyInfo& known : table.keys) guess.offer(known.name);
        findings_.add(Code::P7303, place(key.source()), fmt::format("{} has no key \"{}\"", heading, name),
                      guess.help());
      } else if (check(*row, node)) {
        to.values.set(name, {scalar_text(node), place(node.source())}, texts_of(node));
      }
    }
    for (const KeyInfo& key : table.keys) {
      if (key.fallback.kind != KeyDefault::Kind::kRequired || from.contains(key.name)) continue;
      findings_.add(Code::P7306, to.at, fmt::format("{} has no \"{}\"", heading, key.name),
                    fmt::format("add {} = {}", key.name, key.fallback.toml));
    }
    if (findings_.size() == wrong) read_.push_back(std::move(to));
  }

  std::vector<Placed> texts_of(const toml::node& node) const {
    std::vector<Placed> all;
    if (const toml::array* const list = node.as_array()) {
      for (const toml::node& one : *list) all.push_back({one.as_string()->get(), place(one.source())});
    }
    return all;
  }

  bool check(const KeyInfo& key, const toml::node& node) {
    const auto refuse = [&](Code code) {
      findings_.add(code, place(node.source()),
                    fmt::format("\"{}\" takes {}{}", key.name, type_text(key.type),
                                node.is_value() ? fmt::format(", not {}", scalar_text(node)) : std::string()));
      return false;
    };
    const auto plain = [](std::string_view text) {
      return std::none_of(text.begin(), text.end(),
                          [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
    };
    const auto* const text = node.as_string();
    switch (key.type.kind) {
      case KeyKind::kBoolean:
        return node.is_boolean() || refuse(Code::P7304);
      case KeyKind::kInteger: {
        const auto* const integer = node.as_integer();
        if (integer == nullptr) return refuse(Code::P7304);
        return (integer->get() >= key.type.low && integer->get() <= key.type.high) || refuse(Code::P7305);
      }
      case KeyKind::kText:
        if (text == nullptr) return refuse(Code::P7304);
        if (!plain(text->get())) return refuse(Code::P7305);
        return key.fallback.kind != KeyDefault::Kind::kRequired || !core::trimmed(text->get()).empty() ||
               refuse(Code::P7305);
      case KeyKind::kTexts: {
        const toml::array* const list = node.as_array();
        if (list == nullptr) return refuse(Code::P7304);
        return std::all_of(list->begin(), list->end(),
                           [&](const toml::node& one) {
                             const auto* const each = one.as_string();
                             return each != nullptr && plain(each->get()) && !core::trimmed(each->get()).empty();
                           }) ||
               refuse(Code::P7304);
      }
      case KeyKind::kChoice:
        if (text == nullptr) return refuse(Code::P7304);
        return choice_index(key.type, text->get()) >= 0 || refuse(Code::P7305);
      case KeyKind::kDuration: {
        if (text == nullptr) return refuse(Code::P7304);
        const auto ns = core::parse_duration_ns(text->get());
        const bool unit = !text->get().empty() && core::fold(text->get().back()) >= 'a';
        if (!ns || !unit) return refuse(Code::P7305);
        return (*ns >= *core::parse_duration_ns(key.type.low_text) &&
                *ns <= *core::parse_duration_ns(key.type.high_text)) ||
               refuse(Code::P7305);
      }
      case KeyKind::kValue:
        return node.is_number() || node.is_boolean() || refuse(Code::P7304);
      case KeyKind::kListen:
      case KeyKind::kChannel:
        break;
    }
    return false;
  }

  std::span<const FileTable> tables_;
  Findings& findings_;
  SourceRef file_;
  std::vector<ReadTable> read_;
};

}  // namespace

std::vector<ReadTable> read_table_file(std::string_view text, std::string_view file, std::span<const FileTable> tables,
                                       core::Diagnostics& diagnostics) {
  SourceRef at;
  at.file = diagnostics.add_file(std::string(file));
  if (const auto unsafe = core::find_unsafe(text)) {
    at.line = unsafe->line;
    at.column = unsafe->column;
    const bool deep = unsafe->kind == core::TextProblem::Kind::kTooDeep;
    diagnostics.report(deep ? Code::P7302 : Code::P7301, at, {},
                       deep ? "nested too deep" : "a character that may be in quotes or comments only",
                       deep ? "" : "texts are written in quotes");
    return {};
  }
  Findings findings;
  std::vector<ReadTable> read;
  try {
    read = TableFileReader(at.file, tables, findings).read(toml::parse(text, file));
  } catch (const toml::parse_error& error) {
    at.line = error.source().begin.line;
    at.column = error.source().begin.column;
    findings.add(Code::P7301, at, std::string(error.description()),
                 "texts are written in quotes, tables as [name] or [[name]]");
  }
  findings.report(diagnostics);
  return read;
}

std::optional<std::string> table_file_text(const std::string& path, core::Diagnostics& diagnostics) {
  SourceRef at;
  const auto refuse = [&](Code code, const std::string& why) {
    at.file = diagnostics.add_file(path);
    diagnostics.report(code, at, {}, why);
    return std::nullopt;
  };
  // A pipe or a device is not opened: that may block, or never come to an end.
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return std::nullopt;
    return refuse(Code::P7001, fmt::format("cannot be read: {}", std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) return refuse(Code::P7001, "is no file");
  if (static_cast<std::size_t>(status.st_size) > core::kMaxTomlBytes)
    return refuse(Code::P7302, fmt::format("file has more than {} bytes", core::kMaxTomlBytes));
  std::ifstream in(path, std::ios::binary);
  if (!in) return refuse(Code::P7001, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::string text(static_cast<std::size_t>(status.st_size), '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

}  // namespace plc::io
