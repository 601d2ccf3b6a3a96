#include "alarms/alarms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/text.h"
#include "shadow/replica_set.h"

namespace plc::alarms {
namespace {

constexpr std::string_view kBlock = "ALARM";
/// A delay that runs while no scan comes is looked at so much later, since scans are known that late.
constexpr core::TimeNs kBehindNs = 300'000'000;
/// Events that wait to be taken; of more the oldest are lost.
constexpr std::size_t kMostWaiting = 100'000;

/// The table of a place in replicas.
const std::byte* base_of(const shadow::ReplicaSet& replicas, std::uint32_t task) {
  return task == runtime::Place::kGlobal ? replicas.globals().data() : replicas.replica(task).program().table().data();
}

const bytecode::ImageField* field_named(const bytecode::ImageType& type, std::string_view name) {
  const auto found = std::find_if(type.fields.begin(), type.fields.end(), [name](const bytecode::ImageField& field) {
    return core::iequals(field.name, name);
  });
  return found == type.fields.end() ? nullptr : &*found;
}

/// Least and greatest of what an integer or a BOOL of this type may be; nothing for other types.
std::optional<std::pair<double, double>> range_of(const bytecode::ImageType& type) {
  if (type.limited) return std::pair(static_cast<double>(type.lower), static_cast<double>(type.upper));
  if (core::in_category(type.elementary, core::kAnyDuration | core::kAnyDate)) return std::nullopt;
  const auto signed_bits = [](int bits) {
    return std::pair(-std::ldexp(1.0, bits - 1), std::ldexp(1.0, bits - 1) - 1);
  };
  const auto unsigned_bits = [](int bits) { return std::pair(0.0, std::ldexp(1.0, bits) - 1); };
  switch (bytecode::rep_of(type)) {
    case core::Rep::kBool:
      return unsigned_bits(1);
    case core::Rep::kI8:
      return signed_bits(8);
    case core::Rep::kU8:
      return unsigned_bits(8);
    case core::Rep::kI16:
      return signed_bits(16);
    case core::Rep::kU16:
      return unsigned_bits(16);
    case core::Rep::kI32:
      return signed_bits(32);
    case core::Rep::kU32:
      return unsigned_bits(32);
    case core::Rep::kI64:
      return signed_bits(64);
    case core::Rep::kU64:
      return unsigned_bits(64);
    default:
      return std::nullopt;
  }
}

/// Why the condition can never hold; nothing when it can.
std::optional<core::Problem> never_holds(const Definition& alarm, const bytecode::ImageType& type) {
  const bool compares = alarm.comparison == Comparison::kAbove || alarm.comparison == Comparison::kBelow;
  if (compares && type.elementary == core::TypeId::kBool) {
    return core::Problem{core::Code::P7322,
                         "\"" + alarm.variable + R"(" has type BOOL, "above" and "below" are for numbers)",
                         "when = true or when = false"};
  }
  const auto never = [&alarm](std::string why) {
    return core::Problem{
        core::Code::P7104, "\"" + alarm.variable + "\" " + std::move(why) + ": the condition never holds", {}};
  };
  const bool equals = alarm.comparison == Comparison::kEqual;
  if (equals && !type.members.empty()) {
    const auto& values = type.member_values;
    const bool is_one = std::any_of(values.begin(), values.end(),
                                    [&](auto value) { return static_cast<double>(value) == alarm.limit; });
    if (!is_one) return never("has no member with this number");
  }
  const auto range = range_of(type);
  if (!range) return std::nullopt;
  const auto [least, greatest] = *range;
  if (alarm.comparison == Comparison::kAbove && alarm.limit >= greatest)
    return never(fmt::format("is at most {}", greatest));
  if (alarm.comparison == Comparison::kBelow && alarm.limit <= least)
    return never(fmt::format("is at least {}", least));
  const bool reached = alarm.limit >= least && alarm.limit <= greatest && alarm.limit == std::floor(alarm.limit);
  if (equals && !reached) return never(fmt::format("is a whole number from {} to {}", least, greatest));
  return std::nullopt;
}

/// Those that need somebody first.
int rank_of(State state) {
  constexpr std::array<int, 7> kRanks = {6, 0, 2, 1, 3, 4, 5};
  return kRanks[static_cast<std::size_t>(state)];
}

}  // namespace

Alarms::Alarms(runtime::Resource& resource, std::vector<Definition> definitions, bool recorded,
               core::Diagnostics& diagnostics)
    : image_(resource.image()), globals_(resource.globals()), reader_(resource.globals()) {
  by_task_.resize(image_.tasks.size());
  for (Definition& definition : definitions) add(resource, std::move(definition), recorded, diagnostics);
  add_blocks(resource, recorded, diagnostics);
}

void Alarms::place_look(Look look) {
  const std::optional<std::uint32_t> task = look.watched.task;
  needs_scans_ = needs_scans_ || task;
  Looks& looks = task ? by_task_[*task].looks : by_time_;
  (look.suppresses ? looks.suppressions : looks.conditions).push_back(look);
}

void Alarms::add(runtime::Resource& resource, Definition definition, bool recorded, core::Diagnostics& diagnostics) {
  const auto refuse = [&](const core::Problem& problem) {
    diagnostics.report(problem.code, definition.at, {},
                       "alarm \"" + definition.name + "\" is left out: " + problem.message, problem.help);
  };
  auto watched = watch(resource, definition.variable, recorded);
  if (!watched) return refuse(watched.error());
  std::optional<Watched> suppress;
  if (!definition.suppress.empty()) {
    auto found = watch(resource, definition.suppress, recorded);
    if (!found) return refuse(found.error());
    if (found->type != core::TypeId::kBool) {
      return refuse({core::Code::P7322,
                     "\"" + definition.suppress + "\" has type " + std::string(core::name_of(found->type)) +
                         ", \"suppress\" takes a BOOL",
                     {}});
    }
    suppress = *found;
  }
  if (const auto wrong = never_holds(definition, image_.types[watched->place.type])) return refuse(*wrong);
  const std::size_t number = items_.size();
  place_look({number, *watched, false});
  if (suppress) place_look({number, *suppress, true});
  Item item;
  item.definition = std::move(definition);
  item.watched = *watched;
  items_.push_back(std::move(item));
}

void Alarms::add_blocks(runtime::Resource& resource, bool recorded, core::Diagnostics& diagnostics) {
  const auto block = std::find_if(image_.blocks.begin(), image_.blocks.end(),
                                  [](const bytecode::ImageBlock& one) { return core::iequals(one.name, kBlock); });
  if (block == image_.blocks.end()) return;
  const bytecode::ImageType& type = image_.types[block->type];
  const runtime::Access access(resource);
  constexpr std::string_view kPort = ".ACTIVE";
  std::size_t unknown = 0;
  for (const runtime::Listed& listed : access.list_places("*" + std::string(kPort))) {
    const std::string path = listed.path.substr(0, listed.path.size() - kPort.size());
    const auto place = access.find(path);
    if (!place || place->type != block->type) continue;
    if (place->task != runtime::Place::kGlobal && !recorded) {
      ++unknown;
      continue;
    }
    auto watched = watch(resource, listed.path, recorded);
    if (!watched) continue;
    Item item;
    item.definition.name = path;
    item.watched = *watched;
    Ports ports;
    ports.place = *place;
    const auto port = [&](std::string_view name, std::uint32_t& offset, std::uint16_t* capacity = nullptr) {
      const bytecode::ImageField* const field = field_named(type, name);
      if (field == nullptr) return;
      offset = field->offset;
      if (capacity != nullptr) *capacity = image_.types[field->type].capacity;
    };
    port("TEXT", ports.text, &ports.text_capacity);
    port("ALARM_CLASS", ports.category, &ports.category_capacity);
    port("FIRST_OUT", ports.group, &ports.group_capacity);
    port("PRIORITY", ports.priority);
    port("LATCH", ports.latch);
    port("VALUE", ports.value);
    item.ports = ports;
    place_look({items_.size(), *watched, false});
    items_.push_back(std::move(item));
  }
  if (unknown != 0) {
    diagnostics.report(core::Code::P7720, {}, {},
                       std::to_string(unknown) + " instances of ALARM are left out: scans are not recorded",
                       "leave [record] mode on");
  }
}

std::vector<std::string> Alarms::do_without_scans() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> left_out;
  Looks all = std::exchange(by_time_, {});
  for (TaskLooks& task : by_task_) {
    for (const auto list : {&Looks::suppressions, &Looks::conditions})
      (all.*list).insert((all.*list).end(), (task.looks.*list).begin(), (task.looks.*list).end());
    task = {};
  }
  std::vector<bool> lost(items_.size());
  for (const auto list : {&Looks::suppressions, &Looks::conditions}) {
    for (const Look& one : all.*list) lost[one.item] = lost[one.item] || !one.watched.is_global();
  }
  std::vector<Item> items;
  std::vector<std::size_t> numbers(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    numbers[i] = items.size();
    if (lost[i]) {
      left_out.push_back(items_[i].definition.name);
    } else {
      items.push_back(std::move(items_[i]));
    }
  }
  items_ = std::move(items);
  for (const auto list : {&Looks::suppressions, &Looks::conditions}) {
    std::erase_if(all.*list, [&lost](const Look& one) { return lost[one.item]; });
    for (Look& one : all.*list) {
      one.item = numbers[one.item];
      one.watched.task.reset();
    }
  }
  by_time_ = std::move(all);
  needs_scans_ = false;
  return left_out;
}

void Alarms::restore(const std::vector<Kept>& all, std::int64_t last_number) {
  const std::lock_guard lock(mutex_);
  last_number_ = last_number;
  for (const Kept& kept : all) {
    Item* const item = find(kept.alarm);
    if (item == nullptr) continue;
    item->state.unpack(kept.packed, kept.shelved_until_ns);
    // It was suppressed, and nobody has seen it: it begins when the plant suppresses it no more.
    if (item->state.is_active() && item->state.state() == State::kNormal) {
      item->state.unpack(kept.packed & ~AlarmState::kPackedActive, kept.shelved_until_ns);
    }
    item->condition.restore(item->state.is_active());
    item->raised.utc_ns = kept.raised_utc_ns;
    item->user = kept.user;
    item->comment = kept.comment;
  }
}

template <class ReadOf>
void Alarms::look_at(const Looks& looks, const Stamp& stamp, ReadOf read_of) {
  // What begins together with its suppression is not seen, nor what ends together with it.
  for (const bool is : {true, false}) {
    for (const Look& one : looks.suppressions) {
      const Read read = read_of(one);
      if (read.value != nullptr && (number_at(read.value, one.watched.type) != 0) == is) {
        suppress(items_[one.item], is, stamp);
      }
    }
    if (!is) break;
    for (const Look& one : looks.conditions) {
      const Read read = read_of(one);
      if (read.value != nullptr) look(items_[one.item], number_at(read.value, one.watched.type), read.ports, stamp);
    }
  }
}

void Alarms::after_scan(const shadow::ReplicaSet& replicas, const shadow::ObservedScan& scan) {
  TaskLooks& mine = by_task_[scan.task];
  if (mine.looks.empty()) return;
  const std::lock_guard lock(mutex_);
  mine.quiet_since_ns.reset();
  if (mine.by_time) return;
  look_at(mine.looks, {scan.now_ns, scan.utc_ns, scan.task, scan.scan}, [&](const Look& one) {
    const runtime::Place& place = one.watched.place;
    const std::optional<Ports>& ports = items_[one.item].ports;
    return Read{base_of(replicas, place.task) + place.offset,
                ports ? base_of(replicas, ports->place.task) + ports->place.offset : nullptr};
  });
}

void Alarms::suppress(Item& item, bool is, const Stamp& stamp) {
  if (is == item.state.is_suppressed()) return;
  item.state.suppress(is);
  happened(item, is ? Happened::kSuppressed : Happened::kUnsuppressed, stamp);
  happened(item, item.state.take_shown(), stamp);
}

void Alarms::look(Item& item, double value, const std::byte* ports, const Stamp& stamp) {
  item.looked_ns = stamp.now_ns;
  if (ports == nullptr) item.shown_value = value;
  const bool changed = item.condition.update(item.definition, value, stamp.now_ns);
  // Once in any case: one that goes on since before a restart does not begin.
  if (ports != nullptr && (!std::exchange(item.pins_read, true) || (changed && item.condition.is()))) {
    read_pins(item, ports);
  }
  if (changed) happened(item, item.state.condition(item.condition.is(), item.definition.latch), stamp);
}

void Alarms::read_pins(Item& item, const std::byte* ports) {
  const Ports& at = *item.ports;
  Definition& definition = item.definition;
  definition.text = text_at(ports + at.text, at.text_capacity);
  definition.category = text_at(ports + at.category, at.category_capacity);
  definition.group = text_at(ports + at.group, at.group_capacity);
  const auto priority = static_cast<int>(number_at(ports + at.priority, core::TypeId::kUsint));
  definition.priority = static_cast<Priority>(std::clamp(priority, 1, 4) - 1);
  definition.latch = number_at(ports + at.latch, core::TypeId::kBool) != 0;
  item.shown_value = number_at(ports + at.value, core::TypeId::kLreal);
}

void Alarms::look_by_time(const Looks& looks, const Stamp& stamp) {
  std::array<std::byte, 8> bytes{};
  std::vector<std::byte> block;
  look_at(looks, stamp, [&](const Look& one) {
    // What a task had for itself ended with it.
    if (!one.watched.is_global()) return Read{};
    reader_.read(one.watched.place.offset, bytes_of(one.watched.type), bytes.data());
    const std::optional<Ports>& ports = items_[one.item].ports;
    if (!ports) return Read{bytes.data(), nullptr};
    block.resize(image_.types[ports->place.type].size);
    reader_.read(ports->place.offset, static_cast<std::uint32_t>(block.size()), block.data());
    return Read{bytes.data(), block.data()};
  });
}

/// Globals of a task that has stopped have safe values, or those that others write: nothing of it is to come any more.
void Alarms::look_after_stopped(const Stamp& stamp) {
  for (std::uint32_t task = 0; task < by_task_.size(); ++task) {
    TaskLooks& one = by_task_[task];
    if (one.looks.empty() || !globals_.has_stopped(task)) continue;
    if (!one.quiet_since_ns) one.quiet_since_ns = stamp.now_ns;
    // Its last scans are known so much later.
    one.by_time = one.by_time || stamp.now_ns - *one.quiet_since_ns > kBehindNs;
    if (one.by_time) look_by_time(one.looks, stamp);
  }
}

void Alarms::service(core::TimeNs now_ns, core::TimeNs utc_ns) {
  const std::lock_guard lock(mutex_);
  const Stamp stamp{now_ns, utc_ns, std::nullopt, 0};
  reader_.take();
  look_by_time(by_time_, stamp);
  look_after_stopped(stamp);
  for (Item& item : items_) {
    if (item.condition.waits() && now_ns - item.looked_ns > kBehindNs &&
        item.condition.pass(item.definition, now_ns - kBehindNs)) {
      happened(item, item.state.condition(item.condition.is(), item.definition.latch), stamp);
    }
    const auto until_ns = item.state.shelved_until_ns();
    // WHY by another clock, too: UTC that is set back would hide the alarm for longer than somebody has asked for.
    if (until_ns && (*until_ns <= utc_ns || now_ns >= item.shelf_end_ns.value_or(INT64_MAX))) {
      item.state.unshelve();
      happened(item, Happened::kUnshelved, stamp);
      happened(item, item.state.take_shown(), stamp);
    }
  }
}

void Alarms::happened(Item& item, Happened what, const Stamp& stamp, const Deed* deed) {
  item.changed = true;
  if (what == Happened::kNothing) return;
  if (what == Happened::kRaised) {
    item.raised = stamp;
    item.user.clear();
    item.comment.clear();
    enter_group(static_cast<std::size_t>(&item - items_.data()));
  }
  if (deed != nullptr) {
    item.user = deed->user;
    item.comment = deed->comment;
  }
  Event event;
  event.number = ++last_number_;
  event.what = what;
  event.alarm = item.definition.name;
  event.text = item.definition.text;
  event.category = item.definition.category;
  event.priority = item.definition.priority;
  event.utc_ns = stamp.utc_ns;
  event.task = task_name(stamp);
  if (stamp.task) event.scan = stamp.scan;
  if (what == Happened::kRaised || what == Happened::kReturned) event.value = item.shown_value;
  if (deed != nullptr) {
    event.user = deed->user;
    event.comment = deed->comment;
  }
  if (events_.size() >= kMostWaiting) events_.erase(events_.begin());
  events_.push_back(std::move(event));
}

std::string Alarms::task_name(const Stamp& stamp) const {
  return stamp.task ? image_.tasks[*stamp.task].name : std::string();
}

void Alarms::enter_group(std::size_t item) {
  const std::string& name = items_[item].definition.group;
  if (name.empty()) return;
  auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& one) { return one.name == name; });
  if (group == groups_.end()) group = groups_.insert(groups_.end(), {name, {}});
  const bool rests = std::none_of(group->raised.begin(), group->raised.end(), [&](const Member& member) {
    return member.item != item && items_[member.item].state.is_shown();
  });
  if (rests) group->raised.clear();
  std::erase_if(group->raised, [item](const Member& member) { return member.item == item; });
  group->raised.push_back({item, items_[item].raised.now_ns});
}

std::vector<std::uint32_t> Alarms::orders() const {
  std::vector<std::uint32_t> all(items_.size());
  std::vector<core::TimeNs> times;
  for (const Group& group : groups_) {
    times.clear();
    for (const Member& member : group.raised) times.push_back(member.now_ns);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    for (const Member& member : group.raised) {
      if (!items_[member.item].state.is_shown() || items_[member.item].definition.group != group.name) continue;
      all[member.item] =
          1 + static_cast<std::uint32_t>(std::lower_bound(times.begin(), times.end(), member.now_ns) - times.begin());
    }
  }
  return all;
}

std::vector<View> Alarms::list(bool all) const {
  const std::lock_guard lock(mutex_);
  std::vector<View> views;
  const std::vector<std::uint32_t> order = orders();
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    const State state = item.state.state();
    if (!all && state == State::kNormal) continue;
    View view;
    view.definition = item.definition;
    view.state = state;
    view.active = item.state.is_active();
    view.value = item.shown_value;
    view.raised = item.raised;
    view.task = task_name(item.raised);
    view.order = order[i];
    view.user = item.user;
    view.comment = item.comment;
    view.until_ns = item.state.shelved_until_ns();
    views.push_back(std::move(view));
  }
  std::stable_sort(views.begin(), views.end(), [](const View& a, const View& b) {
    if (a.state != b.state) return rank_of(a.state) < rank_of(b.state);
    if (a.definition.priority != b.definition.priority) return a.definition.priority > b.definition.priority;
    return a.raised.utc_ns > b.raised.utc_ns;
  });
  return views;
}

Alarms::Item* Alarms::find(const std::string& name) {
  const auto found = std::find_if(items_.begin(), items_.end(),
                                  [&](const Item& item) { return core::iequals(item.definition.name, name); });
  return found == items_.end() ? nullptr : &*found;
}

bool Alarms::has(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return const_cast<Alarms*>(this)->find(name) != nullptr;
}

std::size_t Alarms::acknowledge(const std::vector<std::string>& names, const Deed& deed) {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  const Stamp stamp{deed.now_ns, deed.utc_ns, std::nullopt, 0};
  const auto one = [&](Item& item) {
    const Happened what = item.state.acknowledge();
    if (what == Happened::kNothing) return;
    happened(item, Happened::kAcknowledged, stamp, &deed);
    if (what == Happened::kReturned) happened(item, what, stamp);
    ++count;
  };
  if (names.empty()) {
    for (Item& item : items_) one(item);
  }
  for (const std::string& name : names) {
    if (Item* const item = find(name)) one(*item);
  }
  return count;
}

bool Alarms::shelve(const std::string& name, core::TimeNs until_ns, const Deed& deed) {
  const std::lock_guard lock(mutex_);
  Item* const item = find(name);
  if (item == nullptr) return false;
  item->state.shelve(until_ns);
  item->shelf_end_ns = deed.now_ns + until_ns - deed.utc_ns;
  happened(*item, Happened::kShelved, {deed.now_ns, deed.utc_ns, std::nullopt, 0}, &deed);
  return true;
}

bool Alarms::unshelve(const std::string& name, const Deed& deed) {
  const std::lock_guard lock(mutex_);
  Item* const item = find(name);
  if (item == nullptr) return false;
  if (!item->state.shelved_until_ns()) return true;
  const Stamp stamp{deed.now_ns, deed.utc_ns, std::nullopt, 0};
  item->state.unshelve();
  happened(*item, Happened::kUnshelved, stamp, &deed);
  happened(*item, item->state.take_shown(), stamp);
  return true;
}

bool Alarms::take_out_of_service(const std::string& name, bool is, const Deed& deed) {
  const std::lock_guard lock(mutex_);
  Item* const item = find(name);
  if (item == nullptr) return false;
  if (item->state.is_out_of_service() == is) return true;
  const Stamp stamp{deed.now_ns, deed.utc_ns, std::nullopt, 0};
  item->state.take_out_of_service(is);
  happened(*item, is ? Happened::kOutOfService : Happened::kInService, stamp, &deed);
  happened(*item, item->state.take_shown(), stamp);
  return true;
}

void Alarms::take(std::vector<Event>& events, std::vector<Kept>& states) {
  const std::lock_guard lock(mutex_);
  std::move(events_.begin(), events_.end(), std::back_inserter(events));
  events_.clear();
  for (Item& item : items_) {
    if (!std::exchange(item.changed, false)) continue;
    states.push_back({item.definition.name, item.state.packed(), item.state.shelved_until_ns(), item.raised.utc_ns});
  }
}

}  // namespace plc::alarms
