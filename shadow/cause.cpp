#include "shadow/cause.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "shadow/power_trace.h"

namespace plc::shadow {
namespace {

using bytecode::DrawnElement;
using bytecode::DrawnKey;
using bytecode::DrawnSide;
using bytecode::DrawnStorage;
using runtime::Place;
using std::chrono::steady_clock;
using Kind = CauseLink::Kind;

constexpr std::size_t kMostLinks = 60, kMostFlows = 8;

/// When a variable got its value.
struct Change {
  std::uint32_t task = 0;
  std::uint64_t scan = 0;
  core::TimeNs now_ns = 0, utc_ns = 0;
};

class Search {
 public:
  Search(Past& past, const bytecode::Drawings& drawings, std::chrono::milliseconds limit,
         const std::atomic<bool>* ending)
      : past_(past), writers_(past.resource(), drawings), until_(steady_clock::now() + limit), ending_(ending) {}

  std::vector<CauseLink> run(std::uint32_t task, std::uint64_t scan, PouInstance instance, std::string name);

 private:
  struct Asked {
    Place place;
    std::string name;
    bool value = false;
    std::uint32_t task = 0;  ///< the value counts after this scan of it
    std::uint64_t scan = 0;
  };
  /// Of the writer of a variable in one scan.
  struct Written {
    Writer writer;
    std::optional<bool> value;  ///< nothing: it did not write
  };

  [[nodiscard]] bool is_late() const {
    return steady_clock::now() > until_ || (ending_ != nullptr && ending_->load(std::memory_order_relaxed));
  }
  [[nodiscard]] bool bool_at(const Place& place) {
    const std::byte* const bytes = place.task == Place::kGlobal ? past_.player().replicas().globals().data()
                                                                : past_.resource().program(place.task).table().data();
    return bytes[place.offset] != std::byte{0};
  }
  [[nodiscard]] bool is_bool(const Place& place) {
    const bytecode::ImageType& type = past_.resource().image().types[place.type];
    return type.kind == bytecode::TypeKind::kScalar && type.elementary == core::TypeId::kBool && type.size == 1;
  }
  std::optional<Change> last_change(const Asked& asked);
  std::optional<bool> value_after(const Place& place, std::uint32_t task, std::uint64_t scan);
  const Flow* flow(std::uint32_t task, std::uint64_t scan, const runtime::ProbedPou& view);
  std::optional<bool> written_by(const Writer& writer, const Flow& flow) const;
  CauseLink& link(Kind kind, const Asked& asked, const std::optional<Change>& change);
  static void place_link(CauseLink& link, const Writer& writer, std::uint32_t element);
  /// One step further; false at the end.
  bool step(Asked& asked, PouInstance& instance);

  Past& past_;
  Writers writers_;
  steady_clock::time_point until_;
  const std::atomic<bool>* ending_;
  std::vector<CauseLink> links_;
  std::map<std::tuple<std::uint32_t, std::uint64_t, runtime::ProbedPou>, Flow> flows_;
  std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>> seen_;  ///< places and scans
};

std::optional<Change> Search::last_change(const Asked& asked) {
  const auto blocks = past_.blocks(asked.task);
  std::size_t block = blocks.size();
  while (block > 0 && blocks[block - 1].first_scan > asked.scan) --block;
  bool at_end = true;
  core::TimeNs end_ns = past_.end_ns();
  for (; block > 0 && !is_late(); --block, at_end = false) {
    std::optional<bool> before;
    std::optional<Change> change;
    Change last;
    past_.run(blocks[block - 1].first_ns, end_ns, [&](const PlayedScan* played) {
      const bool now = bool_at(asked.place);
      if (played != nullptr)
        last = {played->task, played->scan, played->now_ns,
                past_.player().replicas().replica(played->task).head().utc_ns};
      if (before && *before != asked.value && now == asked.value) change = last;
      before = now;
      return !(at_end && played != nullptr && played->task == asked.task && played->scan == asked.scan);
    });
    // It had the value in the middle of the scan alone.
    if (at_end && before && *before != asked.value) return last;
    if (change) return change;
    end_ns = blocks[block - 1].first_ns - 1;
  }
  return {};
}

std::optional<bool> Search::value_after(const Place& place, std::uint32_t task, std::uint64_t scan) {
  std::optional<bool> value;
  past_.look(task, scan, {}, [&](const runtime::RecordHead&) { value = bool_at(place); });
  return value;
}

const Flow* Search::flow(std::uint32_t task, std::uint64_t scan, const runtime::ProbedPou& view) {
  const auto key = std::tuple(task, scan, view);
  if (const auto known = flows_.find(key); known != flows_.end()) return &known->second;
  Flow made;
  const bool looked = past_.look(task, scan, {&view, 1}, [&](const runtime::RecordHead&) {
    const ProbeView probes(past_.resource().program(task), view);
    if (!probes.any()) return;
    made.map = &past_.resource().image().probes[view.pou];
    for (const bytecode::ProbePoint& point : probes.points()) made.shown.push_back(probes.at(point));
  });
  if (!looked || made.map == nullptr) return nullptr;
  return &flows_.emplace(key, std::move(made)).first->second;
}

/// The first input pin of an element.
std::optional<std::uint32_t> input_of(const DrawnElement& e) {
  for (std::uint32_t i = 0; i < e.pins.size(); ++i) {
    if (!e.pins[i].output) return i;
  }
  return {};
}

std::optional<bool> Search::written_by(const Writer& writer, const Flow& flow) const {
  if (writer.kind == Writer::Kind::kStatement) {
    return flow.power({0, -1, writer.line, writer.column, 0, DrawnSide::kOutput});
  }
  const DrawnElement& e = writer.body->elements[writer.element];
  switch (writer.kind) {
    case Writer::Kind::kCoil: {
      const auto pin = input_of(e);
      const auto power = pin ? flow.power(bytecode::key_of(0, e, e.pins[*pin])) : std::nullopt;
      if (!power) return flow.power(bytecode::key_of(0, e));
      if (e.modifiers.storage == DrawnStorage::kSet) return *power ? std::optional(true) : std::nullopt;
      if (e.modifiers.storage == DrawnStorage::kReset) return *power ? std::optional(false) : std::nullopt;
      return *power != e.modifiers.negated;
    }
    case Writer::Kind::kVariable:
      if (e.kind == core::ElementKind::kBlock) return flow.power(bytecode::key_of(0, e, e.pins[writer.pin]));
      return flow.power(bytecode::key_of(0, e));
    case Writer::Kind::kAction: {
      const Shown* const shown = flow.at(bytecode::key_of(0, e, writer.pin));
      if (shown == nullptr || !shown->known) return {};
      return shown->on;
    }
    default:
      return {};
  }
}

CauseLink& Search::link(Kind kind, const Asked& asked, const std::optional<Change>& change) {
  CauseLink& made = links_.emplace_back();
  made.kind = kind;
  made.variable = asked.name;
  made.value = asked.value;
  made.task = change ? change->task : asked.task;
  made.scan = change ? change->scan : asked.scan;
  if (change) {
    made.now_ns = change->now_ns;
    made.utc_ns = change->utc_ns;
  }
  return made;
}

void Search::place_link(CauseLink& link, const Writer& writer, std::uint32_t element) {
  link.placed = true;
  link.body = writer.body;
  link.pou = writer.pou;
  link.instance = writer.instance;
  link.element = element;
  link.line = writer.kind == Writer::Kind::kStatement ? writer.line : writer.body->elements[element].line;
}

bool Search::step(Asked& asked, PouInstance& instance) {
  if (is_late() || links_.size() >= kMostLinks) return link(Kind::kTooFar, asked, {}), false;
  if (flows_.size() > kMostFlows) flows_.clear();
  const auto change = last_change(asked);
  if (!change && is_late()) return link(Kind::kTooFar, asked, {}), false;
  const std::uint32_t task = change ? change->task : asked.task;
  const std::uint64_t scan = change ? change->scan : asked.scan;
  if (!seen_.insert({asked.place.task, asked.place.offset, scan}).second)
    return link(Kind::kSeen, asked, change), false;
  if (!change) link(Kind::kAsBegun, asked, {});

  std::optional<Writer> found;
  const Flow* now = nullptr;
  bool any = false;
  for (const Writer& writer : writers_.of(asked.place)) {
    if (writer.task != task) continue;
    const Flow* const seen = flow(task, scan, writer.instance.view);
    any = true;
    if (seen == nullptr) continue;
    const bool block = writer.kind == Writer::Kind::kInstance;
    if (!block && written_by(writer, *seen) != asked.value) continue;
    found = writer;  // the last one counts
  }
  if (!found) {
    // Without a change, what could write it may just not be executed.
    link(any && !change ? Kind::kNotRun : Kind::kOutside, asked, change);
    return false;
  }
  const Flow* before = nullptr;
  if (change && scan > 0 && past_.nearest(task, scan - 1) == scan - 1)
    before = flow(task, scan - 1, found->instance.view);
  now = flow(task, scan, found->instance.view);
  if (now == nullptr) return link(Kind::kNotRun, asked, change), false;
  place_link(link(found->kind == Writer::Kind::kInstance ? Kind::kBlock : Kind::kWrote, asked, change), *found,
             found->element);
  if (found->kind == Writer::Kind::kStatement || found->kind == Writer::Kind::kAction) return false;

  const DrawnElement& e = found->body->elements[found->element];
  PowerTrace trace(*found->body, *now, before);
  std::optional<PowerTrace::End> end;
  if (e.kind == core::ElementKind::kBlock) {
    for (std::uint32_t pin = 0; before != nullptr && pin < e.pins.size() && !end; ++pin) {
      if (e.pins[pin].output) continue;
      const DrawnKey key = bytecode::key_of(0, e, e.pins[pin]);
      const auto is = now->power(key), was = before->power(key);
      if (is && was && *is != *was) end = trace.from(found->element, pin);
    }
    if (!end) return false;
  } else if (const auto pin = input_of(e)) {
    end = trace.from(found->element, *pin);
  }
  if (!end) return false;
  const DrawnElement& at = found->body->elements[end->element];
  const bool rail = at.kind == core::ElementKind::kLeftRail;
  const std::string& name = end->variable.empty() ? end->output : end->variable;
  const auto next = name.empty() ? std::nullopt : place_in(past_.resource(), found->instance.path, name);
  if (!end->value && next && is_bool(*next)) end->value = value_after(*next, task, scan);
  CauseLink& made = link(rail ? Kind::kRail : end->variable.empty() ? Kind::kBlock : Kind::kContact, asked, change);
  place_link(made, *found, end->element);
  made.variable = !end->variable.empty() ? end->variable : at.instance.empty() ? at.text : at.instance;
  if (end->value) made.value = *end->value;
  if (!next || !is_bool(*next) || !end->value) return false;
  if (end->variable.empty()) {
    // Into the block, when it is one that is drawn or written here.
    const auto inside = writers_.of(*next);
    if (inside.empty() || inside.front().kind == Writer::Kind::kInstance) return false;
  }
  asked = {*next, name, *end->value, task, scan};
  instance = found->instance;
  return true;
}

std::vector<CauseLink> Search::run(std::uint32_t task, std::uint64_t scan, PouInstance instance, std::string name) {
  const auto place = place_in(past_.resource(), instance.path, name);
  if (!place || !is_bool(*place)) return {};
  Asked asked{*place, std::move(name), false, task, scan};
  Change change{task, scan, 0, 0};
  const bool there = past_.look(task, scan, {}, [&](const runtime::RecordHead& head) {
    asked.value = bool_at(*place);
    change.now_ns = head.now_ns;
    change.utc_ns = head.utc_ns;
  });
  if (!there) return {};
  link(Kind::kAsked, asked, change);
  while (step(asked, instance)) {
  }
  return std::move(links_);
}

}  // namespace

std::vector<CauseLink> cause_of(Past& past, const bytecode::Drawings& drawings, std::uint32_t task, std::uint64_t scan,
                                const PouInstance& instance, const std::string& name, std::chrono::milliseconds limit,
                                const std::atomic<bool>* ending) {
  return Search(past, drawings, limit, ending).run(task, scan, instance, name);
}

}  // namespace plc::shadow
