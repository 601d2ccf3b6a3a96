#include "ir/library.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace plc::ir {
namespace {

bool before(const core::SourceRef& a, const core::SourceRef& b) {
  return std::tie(a.file, a.line, a.column) < std::tie(b.file, b.line, b.column);
}

}  // namespace

void Library::add(const std::vector<std::string>& names, const core::SourceRef& begin, const core::SourceRef& end) {
  Part part;
  if (!names.empty()) part.name = names.front();
  part.begin = begin;
  part.end = end;
  for (const std::string& name : names) names_.emplace_back(name, static_cast<Index>(parts_.size()));
  parts_.push_back(std::move(part));
}

void Library::finish() {
  std::vector<Index> order(parts_.size());
  for (Index i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return before(parts_[a].begin, parts_[b].begin); });
  std::vector<Index> place(parts_.size());
  std::vector<Part> sorted(parts_.size());
  for (Index i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    sorted[i] = std::move(parts_[order[i]]);
  }
  parts_ = std::move(sorted);
  for (const auto& [name, part] : names_) by_name_[name].push_back(place[part]);
  names_.clear();
}

std::optional<Library::Index> Library::at(const core::SourceRef& at) const {
  if (parts_.empty() || at.line == 0) return std::nullopt;
  const auto next = std::upper_bound(parts_.begin(), parts_.end(), at,
                                     [](const core::SourceRef& a, const Part& part) { return before(a, part.begin); });
  if (next == parts_.begin() || before((next - 1)->end, at) || (next - 1)->begin.file != at.file) return std::nullopt;
  return static_cast<Index>(next - 1 - parts_.begin());
}

std::optional<Library::Index> Library::broken(std::string_view name, core::Diagnostics& diagnostics) const {
  const auto found = by_name_.find(name);
  if (found == by_name_.end()) return std::nullopt;
  for (const Index part : found->second) {
    if (parts_[part].broken || diagnostics.error_aside(parts_[part].begin, parts_[part].end) != nullptr) return part;
  }
  return std::nullopt;
}

void Library::need(Index user, Index used) {
  std::vector<Index>& needs = parts_[user].needs;
  if (user != used && std::find(needs.begin(), needs.end(), used) == needs.end()) needs.push_back(used);
}

void Library::reach(Index first, core::Diagnostics& diagnostics) {
  if (parts_[first].reached) return;
  // What is found broken breaks all that is open, as each needs the next.
  struct Frame {
    Index part;
    std::size_t at = 0;
  };
  std::vector<Frame> open;
  const auto enter = [&](Index index) {
    Part& part = parts_[index];
    part.reached = true;
    if (const core::Diagnostic* error = diagnostics.error_aside(part.begin, part.end)) {
      part.broken = any_broken_ = true;
      part.error_at = error->at;
      part.error = error->message;
    }
    diagnostics.release(part.begin, part.end);
    open.push_back({index});
  };
  enter(first);
  while (!open.empty()) {
    Frame& top = open.back();
    const Part& part = parts_[top.part];
    if (top.at < part.needs.size()) {
      const Index next = part.needs[top.at++];
      if (!parts_[next].reached) enter(next);
      continue;
    }
    open.pop_back();
  }
}

bool Library::use(Index index, const core::SourceRef& at, std::string_view pou, core::Diagnostics& diagnostics,
                  std::string_view name) {
  reach(index, diagnostics);
  if (!any_broken_) return true;
  // The nearest declaration that is broken is the reason.
  std::vector<Index> queue = {index};
  std::vector<bool> seen(parts_.size());
  seen[index] = true;
  const Part* reason = nullptr;
  for (std::size_t i = 0; i < queue.size() && reason == nullptr; ++i) {
    const Part& part = parts_[queue[i]];
    if (part.broken) reason = &part;
    for (const Index next : part.needs) {
      if (seen[next]) continue;
      seen[next] = true;
      queue.push_back(next);
    }
  }
  if (reason == nullptr) return true;
  Part& part = parts_[index];
  if (part.reported || at.line == 0 || diagnostics.is_library(at.file)) return false;
  part.reported = true;
  const std::string& file = diagnostics.file_name(reason->begin.file);
  std::string why = reason->error;
  if (reason != &part && !reason->name.empty()) why = fmt::format("it needs \"{}\": {}", reason->name, why);
  if (name.empty()) name = part.name;
  diagnostics.report(
      core::Code::P4060, at, pou,
      fmt::format("\"{}\" of library {} cannot be used: {} (line {})", name, diagnostics.file_name(part.begin.file),
                  why, reason->error_at.line),
      fmt::format("\"plc check {}\" shows all that is wrong in it; what nothing uses does not matter", file));
  return false;
}

void Library::fail(Index index, const core::SourceRef& at, std::string message) {
  Part& part = parts_[index];
  if (part.broken) return;
  part.broken = any_broken_ = true;
  part.error_at = at;
  part.error = std::move(message);
}

}  // namespace plc::ir
