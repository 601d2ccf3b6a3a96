#include "core/diagnostics.h"

#include <algorithm>
#include <ostream>
#include <tuple>
#include <utility>

namespace plc::core {
namespace {

/// A library of more problems than these has every further one reported at once.
constexpr std::size_t kMaxAside = std::size_t{1} << 16;

/// Messages quote the file, where a name or a literal may have a megabyte. Cut between characters, not inside one.
void shorten(std::string& text) {
  constexpr std::size_t kMaxBytes = 2000;
  if (text.size() <= kMaxBytes) return;
  std::size_t end = kMaxBytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0u) == 0x80u) --end;
  text.resize(end);
  text += "...";
}

}  // namespace

const std::vector<CodeInfo>& all_codes() {
  static const std::vector<CodeInfo> kCodes = {
#define PLC_DIAGNOSTIC(code, severity, title) {#code, Severity::severity, title},
#include "core/diagnostics.def"
  };
  return kCodes;
}

const CodeInfo& info(Code code) { return all_codes()[static_cast<std::size_t>(code)]; }

std::uint16_t Diagnostics::add_file(std::string name) {
  stamps_.push_back(stamp_of(name));
  files_.push_back(std::move(name));
  jumps_.emplace_back();
  return static_cast<std::uint16_t>(files_.size() - 1);
}

void Diagnostics::set_text_jumps(std::uint16_t file, TextJumps jumps) { jumps_.at(file) = std::move(jumps); }

void Diagnostics::mute(Code code) {
  if (info(code).severity != Severity::kError) muted_.push_back(code);
}

void Diagnostics::report(Code code, const SourceRef& at, std::string_view pou, std::string message, std::string help) {
  Severity severity = info(code).severity;
  if (std::find(muted_.begin(), muted_.end(), code) != muted_.end()) return;
  // Without a line it is about the file as a whole.
  const bool of_library = is_library(at.file) && at.line != 0;
  if (of_library && severity != Severity::kError &&
      std::find(unwanted_.begin(), unwanted_.end(), code) != unwanted_.end()) {
    return;
  }
  if (severity == Severity::kNote) {
    if (notes_ == Notes::kHide) return;
    if (notes_ == Notes::kRefuse) severity = Severity::kError;
  }
  const bool set_aside = of_library && sets_aside_ && aside_.size() < kMaxAside;
  shorten(message);
  shorten(help);
  Diagnostic diagnostic{code, severity, at, std::string(pou), std::move(message), std::move(help)};
  if (set_aside) {
    aside_.push_back(std::move(diagnostic));
  } else {
    keep(std::move(diagnostic));
  }
}

void Diagnostics::report_at_once(Code code, const SourceRef& at, std::string_view pou, std::string message,
                                 std::string help) {
  const bool outer = std::exchange(sets_aside_, false);
  report(code, at, pou, std::move(message), std::move(help));
  sets_aside_ = outer;
}

void Diagnostics::keep(Diagnostic diagnostic) {
  const bool error = diagnostic.severity == Severity::kError;
  std::size_t number = ++count_of(diagnostic.severity);
  if (!error) {
    counts_.resize(all_codes().size());
    number = ++counts_[static_cast<std::size_t>(diagnostic.code)];
  }
  if (number <= kMaxKept || (!error && show_all_)) all_.push_back(std::move(diagnostic));
}

void Diagnostics::begin_libraries(std::vector<Code> unwanted) {
  first_library_ = files_.size();
  unwanted_ = std::move(unwanted);
}

std::pair<Diagnostics::Aside::iterator, Diagnostics::Aside::iterator> Diagnostics::aside(const SourceRef& begin,
                                                                                         const SourceRef& end) {
  const auto before = [](const SourceRef& a, const SourceRef& b) {
    return std::tie(a.file, a.line, a.column) < std::tie(b.file, b.line, b.column);
  };
  if (sorted_aside_ != aside_.size()) {
    std::stable_sort(aside_.begin(), aside_.end(),
                     [&](const Diagnostic& a, const Diagnostic& b) { return before(a.at, b.at); });
    sorted_aside_ = aside_.size();
  }
  const auto first = std::lower_bound(aside_.begin(), aside_.end(), begin,
                                      [&](const Diagnostic& d, const SourceRef& at) { return before(d.at, at); });
  const auto last = std::upper_bound(first, aside_.end(), end,
                                     [&](const SourceRef& at, const Diagnostic& d) { return before(at, d.at); });
  return {first, last};
}

const Diagnostic* Diagnostics::error_aside(const SourceRef& begin, const SourceRef& end) {
  const auto [first, last] = aside(begin, end);
  const auto found = std::find_if(first, last, [](const Diagnostic& d) { return d.severity == Severity::kError; });
  return found == last ? nullptr : &*found;
}

void Diagnostics::release(const SourceRef& begin, const SourceRef& end) {
  const auto [first, last] = aside(begin, end);
  if (first == last) return;
  for (auto it = first; it != last; ++it) keep(std::move(*it));
  aside_.erase(first, last);
  sorted_aside_ = aside_.size();
}

std::size_t& Diagnostics::count_of(Severity severity) {
  return severity == Severity::kError ? errors_ : severity == Severity::kWarning ? warnings_ : notes_counted_;
}

void Diagnostics::drop_repeated(std::size_t first) {
  const auto earlier = static_cast<std::ptrdiff_t>(std::min(first, all_.size()));
  const auto repeated = [&](const Diagnostic& d) {
    const bool found = std::any_of(all_.begin(), all_.begin() + earlier, [&](const Diagnostic& e) {
      return e.code == d.code && e.at == d.at && e.message == d.message;
    });
    if (found) --count_of(d.severity);
    if (found && d.severity != Severity::kError) --counts_[static_cast<std::size_t>(d.code)];
    return found;
  };
  all_.erase(std::remove_if(all_.begin() + earlier, all_.end(), repeated), all_.end());
}

std::string Diagnostics::message_line(const Diagnostic& d) const {
  static constexpr std::string_view kWords[] = {"note", "warning", "error"};
  std::string out;
  if (d.at.file < files_.size()) {
    out += files_[d.at.file];
    if (d.at.line != 0) {
      out += ':' + std::to_string(d.at.line);
      if (d.at.column != 0) out += ':' + std::to_string(d.at.column);
    }
    out += ": ";
  }
  out += kWords[static_cast<std::size_t>(d.severity)];
  out += ' ';
  out += info(d.code).name;
  out += ": ";
  // Names come from the user's file: control characters must not reach a terminal or a log.
  for (char c : d.message) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  std::string where;
  if (!d.pou.empty()) where = "POU " + d.pou;
  if (d.at.kind != ElementKind::kNone && d.at.local_id >= 0) {
    if (!where.empty()) where += ", ";
    where += element_word(d.at.kind);
    where += ' ' + std::to_string(d.at.local_id);
  }
  if (!where.empty()) out += " [" + where + "]";
  return out;
}

std::string Diagnostics::render_one(const Diagnostic& d) const {
  return d.help.empty() ? message_line(d) : message_line(d) + "\n  help: " + d.help;
}

template <class One>
void Diagnostics::render_each(std::ostream& out, One one) const {
  std::vector<std::size_t> shown(all_codes().size());
  std::vector<Code> shortened;
  std::size_t errors = 0;
  for (const Diagnostic& d : all_) {
    std::size_t& number = shown[static_cast<std::size_t>(d.code)];
    if (d.severity == Severity::kError) {
      ++errors;
    } else if (!show_all_ && ++number > kMaxShown) {
      if (number == kMaxShown + 1) shortened.push_back(d.code);
      continue;
    }
    one(d);
  }
  for (const Code code : shortened) {
    const std::size_t more = counts_[static_cast<std::size_t>(code)] - kMaxShown;
    out << info(code).name << ": " << more << " more; --all shows them\n";
  }
  if (errors_ > errors) out << "note: " << (errors_ - errors) << " further errors are counted but not shown\n";
}

void Diagnostics::render(std::ostream& out) const {
  render_each(out, [&](const Diagnostic& d) { out << render_one(d) << '\n'; });
}

void Diagnostics::render_with_lines(std::ostream& out) const {
  Excerpts excerpts;
  render_each(out, [&](const Diagnostic& d) {
    out << message_line(d) << '\n';
    if (d.at.file < files_.size()) out << excerpts.of(files_[d.at.file], stamps_[d.at.file], d.at.line, d.at.column);
    if (!d.help.empty()) out << "  help: " << d.help << '\n';
  });
}

}  // namespace plc::core
