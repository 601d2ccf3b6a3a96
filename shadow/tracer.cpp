#include "shadow/tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "runtime/access.h"

namespace plc::shadow {
namespace {

/// A text as a cell of CSV.
void append_cell(std::string& out, const std::string& text) {
  out += ',';
  if (text.find_first_of(",\"\n\r") == std::string::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

/// Sees the trigger come, scan by scan.
class TriggerWatch {
 public:
  TriggerWatch(const Trigger& trigger, const runtime::Place& place) : trigger_(trigger), place_(place) {}

  bool comes(const runtime::Access& access) {
    text_.clear();
    access.read_to(place_, text_);
    bool now = false;
    if (trigger_.edge == Trigger::Edge::kChange) {
      now = any_ && text_ != before_;
    } else {
      const double value = std::strtod(text_.c_str(), nullptr);
      const bool above = value >= trigger_.level;
      now = any_ && above != above_ && above == (trigger_.edge == Trigger::Edge::kRising);
      above_ = above;
    }
    before_.swap(text_);
    any_ = true;
    return now;
  }

 private:
  const Trigger& trigger_;
  runtime::Place place_;
  std::string text_, before_;
  bool any_ = false, above_ = false;
};

}  // namespace

core::Result<Trace> trace(Player& player, const TraceRequest& request) {
  const auto given_up = [&request] {
    return request.ending != nullptr && request.ending->load(std::memory_order_relaxed);
  };
  const runtime::Access access(player.resource());
  std::vector<runtime::Place> places;
  Trace out;
  out.csv = "scan,time_ms";
  for (const std::string& path : request.paths) {
    const auto place = access.find_leaf(path);
    if (!place) return place.error();
    places.push_back(*place);
    append_cell(out.csv, path);
  }
  out.csv += '\n';
  core::TimeNs from_ns = request.from_ns, until_ns = request.until_ns, zero_ns = request.from_ns;
  if (request.trigger) {
    const auto place = access.find_leaf(request.trigger->path);
    if (!place) return place.error();
    TriggerWatch watch(*request.trigger, *place);
    player.seek(from_ns - 1);
    while (!out.triggered && player.next_ns().value_or(until_ns + 1) <= until_ns) {
      if (given_up()) break;
      const auto played = player.step();
      if (played->task != request.task) continue;
      player.show_globals();
      if (!watch.comes(access)) continue;
      out.triggered = played->scan;
      zero_ns = played->now_ns;
    }
    out.cut = given_up();
    if (!out.triggered || out.cut) return out;
    from_ns = zero_ns - request.before_ns;
    until_ns = zero_ns + request.after_ns;
  }
  player.seek(from_ns - 1);
  std::string cell;
  while (player.next_ns().value_or(until_ns + 1) <= until_ns) {
    const auto played = player.step();
    if (played->task != request.task) continue;
    if (out.rows == request.most_rows || out.csv.size() >= request.most_bytes || given_up()) {
      out.cut = true;
      break;
    }
    player.show_globals();
    out.csv += fmt::format("{},{}", played->scan, static_cast<double>(played->now_ns - zero_ns) / 1e6);
    for (const runtime::Place& place : places) {
      cell.clear();
      access.read_to(place, cell, request.style);
      append_cell(out.csv, cell);
    }
    out.csv += '\n';
    ++out.rows;
  }
  return out;
}

}  // namespace plc::shadow
