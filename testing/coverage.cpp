#include "testing/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "core/text.h"

namespace plc::tests {
namespace {

using ir::CoverKind;
using ir::CoverSite;

std::uint32_t outcomes_of(CoverKind kind) { return ir::info(kind).second.empty() ? 1 : 2; }
std::string_view word_of(CoverKind kind, std::uint32_t outcome) {
  return outcome == 0 ? ir::info(kind).first : ir::info(kind).second;
}

/// What can be said of an outcome that was not seen.
std::string why_not(CoverKind kind, std::uint32_t outcome, bool other_seen) {
  switch (kind) {
    case CoverKind::kContact:
      if (!other_seen) return "no power reached it";
      return outcome == 0 ? "always open when power reached it" : "always closed when power reached it";
    case CoverKind::kCoil:
      if (!other_seen) return "its rung was never executed";
      return outcome == 0 ? "no power reached it" : "power always reached it";
    case CoverKind::kRung:
      return "always jumped over, or its POU never ran";
    case CoverKind::kBranch:
      return "its condition never held";
  }
  return {};
}

/// One line, not too long: conditions go over several.
std::string short_text(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  std::string out;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!blank) out += c;
    if (blank && !out.empty() && out.back() != ' ') out += ' ';
  }
  return out.size() <= kLongest ? out : out.substr(0, kLongest) + " ..";
}

std::string describe(const CoverSite& site) {
  std::string out = site.pou;
  if (site.rung != 0) out += fmt::format(", rung {}", site.rung);
  if (site.kind == CoverKind::kBranch) return out + ", " + short_text(site.text);
  if (site.kind != CoverKind::kRung) out += fmt::format(", {} \"{}\"", ir::info(site.kind).word, short_text(site.text));
  if (site.at.local_id >= 0) out += fmt::format(" [localId {}]", site.at.local_id);
  return out;
}

bool is_of(const Waiver& waiver, const CoverSite& site, std::string_view outcome) {
  const bool element = core::iequals(waiver.element, site.text) ||
                       (site.at.local_id >= 0 && waiver.element == std::to_string(site.at.local_id));
  return element && core::iequals(waiver.pou, site.pou) && (waiver.outcome.empty() || waiver.outcome == outcome);
}

/// Columns as wide as their widest cell, the first to the left and the others to the right.
std::string table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string out;
  for (const auto& row : rows) {
    out += fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t c = 1; c < row.size(); ++c) out += fmt::format("  {:>{}}", row[c], widths[c]);
    out += '\n';
  }
  return out;
}

}  // namespace

std::vector<Waiver> waivers_of(const std::vector<plcopen::Pragma>& pragmas) {
  static const std::regex kForm(
      R"(\{\s*not_covered\s+([^\s']+)\s+'([^']*)'\s+(?:([a-z]+(?: [a-z]+)*)\s+)?'([^']*)'\s*\})", std::regex::icase);
  std::vector<Waiver> out;
  for (const plcopen::Pragma& pragma : pragmas) {
    std::smatch parts;
    if (!std::regex_match(pragma.text, parts, kForm)) continue;
    out.push_back({parts[1], parts[2], parts[3], parts[4], pragma.at, false});
  }
  return out;
}

CoverageReport::CoverageReport(std::vector<CoverSite> sites, std::vector<bool> seen, std::vector<Waiver> waivers)
    : sites_(std::move(sites)), seen_(std::move(seen)), waivers_(std::move(waivers)) {
  for (std::uint32_t s = 0; s < sites_.size(); ++s) {
    const CoverSite& site = sites_[s];
    auto pou = std::find_if(pous_.begin(), pous_.end(), [&](const CoverageOfPou& one) { return one.pou == site.pou; });
    if (pou == pous_.end()) {
      pous_.emplace_back().pou = site.pou;
      pou = pous_.end() - 1;
    }
    CoverageOfPou::Count& count = pou->by_kind[static_cast<std::size_t>(site.kind)];
    for (std::uint32_t outcome = 0; outcome < outcomes_of(site.kind); ++outcome) {
      ++count.of;
      count.seen += CoverageReport::seen(s, outcome) ? 1 : 0;
      if (CoverageReport::seen(s, outcome)) continue;
      const std::string_view word = word_of(site.kind, outcome);
      const bool other = outcomes_of(site.kind) == 2 && CoverageReport::seen(s, 1 - outcome);
      Unseen one{s, std::string(word), why_not(site.kind, outcome, other), {}};
      for (Waiver& waiver : waivers_) {
        if (!is_of(waiver, site, word)) continue;
        waiver.used = true;
        one.reason = waiver.reason;
      }
      unseen_.push_back(std::move(one));
    }
  }
}

bool CoverageReport::complete(std::uint32_t site) const {
  for (std::uint32_t outcome = 0; outcome < outcomes_of(sites_[site].kind); ++outcome) {
    if (!seen(site, outcome)) return false;
  }
  return true;
}

std::vector<Waiver> CoverageReport::idle_waivers() const {
  std::vector<Waiver> out;
  std::copy_if(waivers_.begin(), waivers_.end(), std::back_inserter(out), [](const Waiver& w) { return !w.used; });
  return out;
}

std::size_t CoverageReport::open_contacts() const {
  return static_cast<std::size_t>(std::count_if(unseen_.begin(), unseen_.end(), [this](const Unseen& one) {
    return sites_[one.site].kind == CoverKind::kContact && one.reason.empty();
  }));
}

std::string CoverageReport::text(const std::vector<std::string>& files) const {
  std::vector<std::vector<std::string>> rows(1);
  rows[0].emplace_back("outcomes seen");
  for (std::uint32_t k = 0; k < ir::kCoverKinds; ++k)
    rows[0].push_back(std::string(ir::info(static_cast<CoverKind>(k)).word) + (k == 3 ? "es" : "s"));
  CoverageOfPou all;
  all.pou = "all";
  const auto add_row = [&rows](const CoverageOfPou& pou) {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(pou.pou);
    for (const CoverageOfPou::Count& count : pou.by_kind)
      row.push_back(count.of == 0 ? std::string("-") : fmt::format("{}/{}", count.seen, count.of));
  };
  for (const CoverageOfPou& pou : pous_) {
    add_row(pou);
    for (std::uint32_t k = 0; k < ir::kCoverKinds; ++k) {
      all.by_kind[k].seen += pou.by_kind[k].seen;
      all.by_kind[k].of += pou.by_kind[k].of;
    }
  }
  if (pous_.size() > 1) add_row(all);
  std::string out = table(rows);
  for (const Unseen& one : unseen_) {
    const CoverSite& site = sites_[one.site];
    const std::string file = site.at.file < files.size() ? files[site.at.file] : std::string();
    out += fmt::format("{}:{}:{}: {}: not seen {}: {}\n", file, site.at.line, site.at.column, describe(site),
                       one.outcome, one.reason.empty() ? one.why : one.why + "; reason: " + one.reason);
  }
  for (const Waiver& waiver : idle_waivers()) {
    const std::string file = waiver.at.file < files.size() ? files[waiver.at.file] : std::string();
    out += fmt::format("{}:{}:{}: {{not_covered {} '{}' ..}} names nothing that was not seen\n", file, waiver.at.line,
                       waiver.at.column, waiver.pou, waiver.element);
  }
  return out;
}

}  // namespace plc::tests
