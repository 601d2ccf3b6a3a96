#include "sources/export_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "core/text.h"
#include "core/utf8.h"
#include "frontend-st/lexer.h"
#include "frontend-st/read.h"
#include "plcopen/encoding.h"
#include "sources/object_project.h"

namespace plc::sources {
namespace {

using core::Code;
using plcopen::Fate;

/// Words that open an object, and the one that closes it.
struct Opener {
  std::string_view word;
  std::string_view end;
};
constexpr Opener kOpeners[] = {
    {"FUNCTION", "END_FUNCTION"},
    {"FUNCTION_BLOCK", "END_FUNCTION_BLOCK"},
    {"FUNCTIONBLOCK", "END_FUNCTION_BLOCK"},
    {"PROGRAM", "END_PROGRAM"},
    {"TYPE", "END_TYPE"},
    {"VAR_GLOBAL", "END_VAR"},
    {"VAR_CONFIG", "END_VAR"},
    {"ACTION", "END_ACTION"},
    {"CONFIGURATION", "END_CONFIGURATION"},
};
/// Lines before bodies that are not ST.
struct Drawing {
  std::string_view line;
  std::string_view what;
};
constexpr Drawing kDrawings[] = {
    {"_LD_BODY", "is drawn in LD"},   {"_FBD_BODY", "is drawn in FBD"}, {"_CFC_BODY", "is drawn in CFC"},
    {"_SFC_BODY", "is drawn in SFC"}, {"_IL_BODY", "is written in IL"},
};
/// Parts of exports that are no program: what they are, and how they end where that is not END_ and their name.
struct Setting {
  std::string_view word;
  std::string_view end;
  std::string_view what;
};
constexpr Setting kSettings[] = {
    {"LIBRARY", "END_LIBRARY", "the list of libraries"},
    {"PLC_CONFIGURATION", "PLC_END", "the configuration of the controller"},
    {"VISUALISATION", "END_VISU", "a visualisation"},
};

/// A word of a line, outside of comments and quotes.
struct Word {
  std::string_view text;
  std::size_t begin = 0;
};

class Splitter {
 public:
  Splitter(std::string text, std::uint16_t file, plcopen::Project& out, core::Diagnostics& diagnostics,
           const std::vector<std::string>& defines)
      : text_(std::move(text)), file_(file), out_(out), diagnostics_(diagnostics), defines_(defines) {}

  void run() {
    std::size_t begin = 0;
    while (begin < text_.size()) {
      std::size_t end = text_.find('\n', begin);
      end = end == std::string::npos ? text_.size() : end + 1;
      line(begin, end);
      begin = end;
      ++line_;
    }
    flush(text_.size());
    name_drawings();
  }

 private:
  struct Unread {
    std::string pou;
    std::string action;  ///< or empty
    std::string what;
  };

  [[nodiscard]] std::string_view slice(std::size_t begin, std::size_t end) const {
    return std::string_view(text_).substr(begin, end - begin);
  }

  /// The words of a line, and the comments that say something of the tool. Strings do not span lines, comments do.
  std::vector<Word> words(std::size_t begin, std::size_t end) {
    std::vector<Word> out;
    std::size_t comment = begin;
    for (std::size_t i = begin; i < end;) {
      const std::string_view two = slice(i, std::min(i + 2, end));
      if (two == "(*" && depth_ > 0 && !nested_) {
        text_[i++] = ' ';  // the reader of texts nests comments
      } else if (two == "(*") {
        if (depth_++ == 0) comment = i;
        i += 2;
      } else if (two == "*)" && depth_ > 0) {
        i += 2;
        if (--depth_ == 0) mark(slice(comment, i));
      } else if (depth_ > 0) {
        ++i;
      } else if (two == "//") {
        break;
      } else if (text_[i] == '\'' || text_[i] == '"') {
        const char quote = text_[i++];
        while (i < end && text_[i] != quote) i += text_[i] == '$' ? 2 : 1;
        ++i;
      } else if (st::is_identifier_start(text_[i])) {
        const std::size_t first = i;
        while (i < end && st::is_identifier_char(text_[i])) ++i;
        out.push_back({slice(first, i), first});
      } else {
        ++i;
      }
    }
    return out;
  }

  /// "(* @GLOBAL_VARIABLE_LIST := 'Plant' *)".
  void mark(std::string_view comment) {
    const std::string_view inner = core::trimmed(comment.substr(2, comment.size() - 4));
    if (!inner.starts_with('@')) return;
    const std::size_t key_end = inner.find_first_of(" :", 1);
    const std::string_view key = inner.substr(0, key_end);
    const std::size_t open = inner.find('\'');
    const std::size_t close = open == std::string_view::npos ? open : inner.find('\'', open + 1);
    const bool valued = close != std::string_view::npos;
    if (key == "@GLOBAL_VARIABLE_LIST" && valued) list_ = inner.substr(open + 1, close - open - 1);
    if (key == "@OBJECT_END") list_.clear();
    if (key == "@NESTEDCOMMENTS" && valued) nested_ = !core::iequals(inner.substr(open + 1, close - open - 1), "No");
  }

  void line(std::size_t begin, std::size_t end) {
    if (!setting_end_.empty()) {
      setting_line(begin, end);
      return;
    }
    if (drawn_) {
      drawn_line(begin, end);
      return;
    }
    const std::vector<Word> found = words(begin, end);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::string_view word = found[i].text;
      if (end_.empty()) {
        const std::string_view next = i + 1 < found.size() ? found[i + 1].text : std::string_view();
        if (!open(word, next, begin)) {
          begin_setting(word, begin, end);
          return;
        }
      } else if (core::iequals(word, end_)) {
        close(end);
      } else if (found.size() == 1) {
        const auto* const drawing = std::find_if(std::begin(kDrawings), std::end(kDrawings),
                                                 [&](const Drawing& one) { return core::iequals(one.line, word); });
        if (drawing == std::end(kDrawings)) continue;
        unread_.push_back({pou_, action_, std::string(drawing->what)});
        drawn_ = true;
        blank(begin, end);
      }
    }
  }

  /// Anything may be in a drawing: its object ends with its word at the begin of a line.
  void drawn_line(std::size_t begin, std::size_t end) {
    const std::string_view line = core::trimmed(slice(begin, end));
    if (core::iequals(line.substr(0, line.find_first_of(" \t;")), end_)) {
      close(end);
    } else {
      blank(begin, end);
    }
  }

  bool open(std::string_view word, std::string_view name, std::size_t line_begin) {
    const auto* const opener = std::find_if(std::begin(kOpeners), std::end(kOpeners),
                                            [&](const Opener& one) { return core::iequals(one.word, word); });
    if (opener == std::end(kOpeners)) return false;
    end_ = opener->end;
    const bool globals = opener->end == "END_VAR";
    if (globals && !list_.empty()) {
      flush(line_begin);
      in_list_ = true;
    }
    action_.clear();
    if (opener->word == "ACTION") action_ = name;
    if (opener->end.starts_with("END_F") || opener->end == "END_PROGRAM") pou_ = name;
    return true;
  }

  void close(std::size_t line_end) {
    end_ = {};
    drawn_ = false;
    action_.clear();
    if (!in_list_) return;
    plcopen::Project part;
    st::read_text(slice(first_, line_end), place(), part, diagnostics_, defines_);
    st::name_list(part, list_);
    merge(out_, std::move(part));
    in_list_ = false;
    first_ = line_end;
    first_line_ = line_ + 1;
  }

  /// What was passed over since the last time is declarations and bodies.
  void flush(std::size_t end) {
    const std::string_view text = slice(first_, end);
    // Blanks alone, and comments, declare nothing.
    if (st::Lexer(text).next().kind != st::TokenKind::kEnd) st::read_text(text, place(), out_, diagnostics_, defines_);
    first_ = end;
    first_line_ = line_;
  }

  [[nodiscard]] core::SourceRef place() const { return {.line = first_line_, .column = 1, .file = file_}; }

  void begin_setting(std::string_view word, std::size_t begin, std::size_t end) {
    const auto* const known = std::find_if(std::begin(kSettings), std::end(kSettings),
                                           [&](const Setting& one) { return core::iequals(one.word, word); });
    constexpr std::size_t kShown = 60;
    const std::string name(word.substr(0, kShown));
    setting_end_ = known != std::end(kSettings) ? std::string(known->end) : "END_" + name;
    const core::SourceRef at{.line = line_, .column = 1, .file = file_};
    if (known == std::end(kSettings)) {
      diagnostics_.report(
          Code::P1210, at, {}, fmt::format("\"{}\" begins a part of the export that is not read", name),
          "tasks and settings of the tool are not in exports as text: write a CONFIGURATION, or run one "
          "program with --pou");
    }
    plcopen::Project part;
    part.report.push_back(
        {name, Fate::kIgnored, 1, line_, known != std::end(kSettings) ? std::string(known->what) : "not known here"});
    merge(out_, std::move(part));
    blank(begin, end);
    depth_ = 0;
  }

  /// Anything may be in such a part: it ends with its word, or before the next object.
  void setting_line(std::size_t begin, std::size_t end) {
    const std::string_view line = core::trimmed(slice(begin, end));
    const std::string_view word = line.substr(0, line.find_first_of(" \t;"));
    if (line.starts_with("(* @NESTEDCOMMENTS")) {
      setting_end_.clear();
      this->line(begin, end);
      return;
    }
    if (core::iequals(word, setting_end_)) setting_end_.clear();
    blank(begin, end);
  }

  /// Blanks in place of what is no text of ST: places after it stay what they are. Characters of several bytes are in
  /// lines of their own, whose columns nobody asks for.
  void blank(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (text_[i] != '\n') text_[i] = ' ';
    }
  }

  void name_drawings() {
    for (const Unread& one : unread_) {
      for (plcopen::Pou& pou : out_.pous) {
        if (!core::iequals(pou.name, one.pou)) continue;
        plcopen::Pou* target = one.action.empty() ? &pou : nullptr;
        for (plcopen::Pou& action : pou.actions) {
          if (!one.action.empty() && core::iequals(action.name, one.action)) target = &action;
        }
        if (target == nullptr) continue;
        target->bodies.clear();  // the message names the head
        target->unread = one.what + ", in the format of an export file, which is not read";
      }
    }
  }

  std::string text_;
  std::uint16_t file_;
  plcopen::Project& out_;
  core::Diagnostics& diagnostics_;
  const std::vector<std::string>& defines_;
  std::uint32_t line_ = 1;
  std::size_t first_ = 0;  ///< of what is not read yet
  std::uint32_t first_line_ = 1;
  int depth_ = 0;             ///< of comments
  bool nested_ = true;        ///< comments nest
  std::string_view end_;      ///< the word that closes the open object; empty outside of objects
  bool drawn_ = false;        ///< in a body that is not ST
  bool in_list_ = false;      ///< in VAR_GLOBAL of a list
  std::string list_;          ///< name of the list of globals
  std::string pou_, action_;  ///< open, or the last POU
  std::string setting_end_;   ///< the word that closes a part that is no program
  std::vector<Unread> unread_;
};

std::unique_ptr<plcopen::Project> read_bytes(std::string_view bytes, const std::string& name, std::uint16_t file,
                                             core::Diagnostics& diagnostics, const std::vector<std::string>& defines) {
  const core::SourceRef at{.file = file};
  if (bytes.size() > st::kMaxFileBytes) {
    diagnostics.report(Code::P1006, at, {}, fmt::format("file is longer than {} MiB", st::kMaxFileBytes >> 20));
    return nullptr;
  }
  if (bytes.find('\0') != std::string_view::npos) {
    diagnostics.report(Code::P4047, at, {}, "file contains zero bytes: it is no text",
                       "give a text export: a .lib or .pro of CODESYS 2.3 is none");
    return nullptr;
  }
  std::string text;
  if (bytes.starts_with("\xEF\xBB\xBF")) {
    text = bytes.substr(3);
  } else {
    // WHY: the tools wrote Windows-1252 whatever the bytes look like.
    constexpr auto kKind = plcopen::Encoding::Kind::kWindows1252;
    text.resize(plcopen::utf8_size(bytes, kKind));
    plcopen::to_utf8(bytes, kKind, text.data());
  }
  auto project = std::make_unique<plcopen::Project>();
  project->path = name;
  const std::size_t slash = name.rfind('/');
  project->name = name.substr(slash == std::string::npos ? 0 : slash + 1);
  project->name.resize(project->name.rfind('.') == std::string::npos ? project->name.size() : project->name.rfind('.'));
  project->file = file;
  project->version = plcopen::Version::kText;
  project->product = "CODESYS 2.3 or TwinCAT 2";
  Splitter(std::move(text), file, *project, diagnostics, defines).run();
  return project;
}

}  // namespace

std::unique_ptr<plcopen::Project> read_export_file(const std::string& path, core::Diagnostics& diagnostics,
                                                   const std::vector<std::string>& defines) {
  const std::uint16_t file = diagnostics.add_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    diagnostics.report(Code::P1001, {.file = file}, {}, std::string("file cannot be read: ") + std::strerror(errno));
    return nullptr;
  }
  try {
    std::string bytes;
    std::string block(std::size_t{1} << 16, '\0');
    while (bytes.size() <= st::kMaxFileBytes && in) {
      in.read(block.data(), static_cast<std::streamsize>(block.size()));
      bytes.append(block, 0, static_cast<std::size_t>(in.gcount()));
    }
    return read_bytes(bytes, path, file, diagnostics, defines);
  } catch (const std::bad_alloc&) {
    diagnostics.report(Code::P1001, {.file = file}, {}, "not enough memory to read the file");
    return nullptr;
  }
}

std::unique_ptr<plcopen::Project> read_export_memory(std::string_view bytes, const std::string& name,
                                                     core::Diagnostics& diagnostics,
                                                     const std::vector<std::string>& defines) {
  return read_bytes(bytes, name, diagnostics.add_file(name), diagnostics, defines);
}

}  // namespace plc::sources
