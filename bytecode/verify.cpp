#include <fmt/format.h>

#include <algorithm>

#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

/// Rules that a sound program breaks by its size alone.
constexpr bool is_limit(std::string_view id) { return id == "V209" || id == "V407" || id == "V415"; }

/// The code of a rule follows from its hundred.
constexpr core::Code code_of(std::string_view id) {
  if (is_limit(id)) return core::Code::P5001;
  switch (id[1]) {
    case '1':
      return core::Code::P6010;
    case '2':
      return core::Code::P6011;
    case '3':
      return core::Code::P6012;
    case '4':
      return core::Code::P6013;
    default:
      return core::Code::P6014;
  }
}

constexpr RuleInfo kRules[] = {
#define PLC_RULE(id, meaning) {#id, meaning, code_of(#id)},
#include "bytecode/rules.def"
};

}  // namespace

std::span<const RuleInfo> rules() { return kRules; }
const RuleInfo& info(Rule rule) { return kRules[static_cast<std::size_t>(rule)]; }

void Report::report(Rule rule, const core::SourceRef& at, std::string_view pou, const std::string& what) {
  if (count_++ >= kMaxReports) return;
  const RuleInfo& broken = info(rule);
  std::string message = fmt::format("{} (rule {}: {})", what, broken.id, broken.meaning);
  diagnostics_.report(broken.code, at, pou, std::move(message),
                      rule == Rule::kV415   ? "let programs of one interval and priority run in one task"
                      : is_limit(broken.id) ? "make arrays smaller, or split the project"
                                            : "compile the project again with this version of PICARD");
}

void Report::broken(Rule rule, const std::string& what) { report(rule, {}, {}, what); }

void Report::broken(Rule rule, const ImagePou& pou, std::size_t word, const std::string& what) {
  const auto after = std::upper_bound(pou.debug.begin(), pou.debug.end(), word,
                                      [](std::size_t at, const DebugEntry& entry) { return at < entry.word; });
  core::SourceRef at;
  std::string place;
  if (after != pou.debug.begin() && (after - 1)->at.file < image_.files.size()) {
    const core::SourceRef& drawn = (after - 1)->at;
    // The image numbers its files itself.
    const std::string& name = image_.files[drawn.file];
    for (std::uint16_t f = 0; f < diagnostics_.file_count() && at.line == 0; ++f) {
      if (diagnostics_.file_name(f) != name) continue;
      at = drawn;
      at.file = f;
    }
    if (at.line == 0) {
      at.kind = drawn.kind;
      at.local_id = drawn.local_id;
      if (drawn.line != 0) place = fmt::format(" ({}:{}:{})", name, drawn.line, drawn.column);
    }
  }
  report(rule, at, pou.name, fmt::format("word {}{}: {}", word, place, what));
}

std::optional<VerifiedImage> verify(Image image, core::Diagnostics& diagnostics) {
  Report report(image, diagnostics);
  verify_types(image, report);
  if (report.clean()) verify_tables(image, report);
  if (report.clean()) verify_library(image, report);
  std::vector<PouFacts> facts;
  if (report.clean()) verify_code(image, report, facts);
  if (report.clean()) verify_probes(image, report);
  std::uint32_t depth = 0;
  if (report.clean()) depth = verify_calls(image, report, facts);
  if (!report.clean()) return std::nullopt;
  return VerifiedImage(std::move(image), depth);
}

}  // namespace plc::bytecode
