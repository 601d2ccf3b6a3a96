#include "runtime/force_list.h"

#include <algorithm>
#include <utility>

#include "core/text.h"
#include "runtime/link/link.h"
#include "runtime/memory/forces.h"
#include "runtime/value_text.h"

namespace plc::runtime {

using core::Code;
using core::Problem;

namespace {
std::string released(std::string_view by) { return " is released" + (by.empty() ? "" : " by " + std::string(by)); }
}  // namespace

ForceList::ForceList(Resource& resource) : resource_(resource) {
  const bytecode::Image& image = resource.image();
  for (std::uint32_t task = 0; task < resource.task_count(); ++task) {
    static_cast<void>(resource.program(task).forces());
    std::vector<std::uint8_t>& fields =
        exchanged_.emplace_back(image.types[image.global_type].fields.size(), std::uint8_t{0});
    for (const FieldRange& range : exchanged_ranges(image, image.tasks[task].body)) {
      std::fill_n(fields.begin() + range.first, range.count, std::uint8_t{1});
    }
  }
}

core::Result<Force> ForceList::set(Force force) {
  const Access access(resource_);
  const auto place = access.find_leaf(force.path);
  if (!place) return place.error();
  const bytecode::ImageType& type = resource_.image().types[place->type];
  if (place->constant) return Problem{Code::P7106, "the variable is declared CONSTANT", {}};
  if (type.kind == bytecode::TypeKind::kRef)
    return Problem{Code::P7106, "a reference cannot be forced", "force the variable that it refers to"};
  Held held{std::move(force), *place, std::vector<std::byte>(type.size)};
  if (auto problem = parse_value(type, held.force.value, held.bytes)) return *problem;
  held.force.value = shown_value(type, held.bytes.data());
  if (place->task == Place::kGlobal) {
    const GlobalTable& globals = resource_.globals();
    held.force.yields = !globals.exporters(globals.field_of(place->offset)).empty();
  } else {
    held.force.yields = true;
  }
  const std::lock_guard lock(mutex_);
  const auto same = std::find_if(held_.begin(), held_.end(), [&](const Held& one) {
    return one.place.task == place->task && one.place.offset == place->offset;
  });
  if (same == held_.end() && held_.size() == kMost)
    return Problem{Code::P7107, "as many variables are forced as can be", "release some of them"};
  Force out = held.force;
  changes_.push_back("forced " + out.path + " to " + out.value + (out.owner.empty() ? "" : " by " + out.owner) +
                     (out.reason.empty() ? "" : ": " + out.reason));
  if (same == held_.end()) {
    held_.push_back(std::move(held));
  } else {
    *same = std::move(held);
  }
  apply();
  return out;
}

template <class Is>
std::vector<Force> ForceList::remove(Is&& is, const std::string& how) {
  const std::lock_guard lock(mutex_);
  std::vector<Force> removed;
  std::erase_if(held_, [&](Held& one) {
    if (!is(one)) return false;
    changes_.push_back(one.force.path + how);
    removed.push_back(std::move(one.force));
    return true;
  });
  if (!removed.empty()) apply();
  return removed;
}

bool ForceList::release(std::string_view path, std::string_view by) {
  const auto place = Access(resource_).find_leaf(path);
  if (!place) return false;
  return !remove([&](const Held& one) { return one.place.task == place->task && one.place.offset == place->offset; },
                 released(by))
              .empty();
}

std::size_t ForceList::release_all(std::string_view owner, std::string_view by) {
  return remove([owner](const Held& one) { return owner.empty() || one.force.owner == owner; }, released(by)).size();
}

std::vector<Force> ForceList::expire(core::TimeNs now_ns) {
  return remove([now_ns](const Held& one) { return one.force.until_mono_ns && *one.force.until_mono_ns <= now_ns; },
                " is not forced any more: its time is over");
}

std::vector<std::string> ForceList::take_changes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(changes_, {});
}

std::vector<Force> ForceList::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<Force> all;
  for (const Held& one : held_) all.push_back(one.force);
  return all;
}

std::size_t ForceList::size() const {
  const std::lock_guard lock(mutex_);
  return held_.size();
}

bool ForceList::holds(const Place& place) const {
  const std::lock_guard lock(mutex_);
  return std::any_of(held_.begin(), held_.end(),
                     [&](const Held& one) { return one.place.task == place.task && one.place.offset == place.offset; });
}

void ForceList::apply() {
  GlobalTable& globals = resource_.globals();
  std::vector<std::vector<ForcedPlace>> places(resource_.task_count());
  std::vector<std::uint32_t> offsets;
  std::vector<GlobalWrite> writes;
  for (const Held& one : held_) {
    if (one.place.task != Place::kGlobal) {
      places[one.place.task].push_back({one.place.offset, false, false, one.bytes});
      continue;
    }
    const std::uint32_t field = globals.field_of(one.place.offset);
    const std::vector<std::uint32_t> exporters = globals.exporters(field);
    for (std::uint32_t task = 0; task < places.size(); ++task) {
      if (!exchanges(task, field)) continue;
      const bool exported = std::find(exporters.begin(), exporters.end(), task) != exporters.end();
      places[task].push_back({one.place.offset, !exported || exporters.size() > 1, exported, one.bytes});
    }
    offsets.push_back(one.place.offset);
    // What no task publishes alone has the value for HMIs and devices from here.
    if (exporters.size() != 1) writes.push_back({one.place.offset, one.place.type, one.bytes.data(), nullptr});
  }
  globals.set_forced({});
  // One at a time: a driver's input is refused, and is forced in the tasks all the same.
  for (const GlobalWrite& write : writes) static_cast<void>(globals.write({&write, 1}));
  globals.set_forced(std::move(offsets));
  for (std::uint32_t task = 0; task < places.size(); ++task)
    resource_.program(task).forces().set(std::move(places[task]));
}

}  // namespace plc::runtime
