#include "shadow/replica_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "runtime/access.h"
#include "runtime/link/link.h"
#include "runtime/sched/task.h"

namespace plc::shadow {
namespace {

/// Of variables that one part of a table has.
constexpr std::size_t kMostNames = 8;

}  // namespace

core::Result<std::unique_ptr<ReplicaSet>> ReplicaSet::make(const RecordingHead& head, core::Diagnostics& diagnostics) {
  auto image = bytecode::load(head.image);
  if (!image) return image.error();
  auto verified = bytecode::verify(std::move(*image), diagnostics);
  if (!verified) return core::Problem{core::Code::P7630, "the image of the recording is not sound", {}};
  std::unique_ptr<ReplicaSet> made(new ReplicaSet);
  made->replays_.resize(verified->image().tasks.size());
  runtime::ProgramOptions options;
  options.loop_budget = head.loop_budget;
  made->zone_ = core::TimeZone::load(head.zone);
  if (made->zone_) options.zone = &*made->zone_;
  auto resource = runtime::Resource::load_replicas(std::move(*verified), made->replays_, options);
  if (!resource) return resource.error();
  made->resource_ = std::move(*resource);
  const bytecode::Image& linked = made->resource_->image();
  made->order_ = runtime::priority_order(linked);
  made->globals_ = linked.global_initial;
  made->seen_.resize(linked.tasks.size());
  made->follows_.resize(linked.tasks.size());
  const bytecode::ImageType& globals = linked.types[linked.global_type];
  for (std::uint32_t t = 0; t < linked.tasks.size(); ++t) {
    made->replicas_.emplace_back(made->resource_->program(t), made->replays_[t]);
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(linked, linked.tasks[t].body)) {
      for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
        const std::uint32_t bytes = linked.types[globals.fields[f].type].size;
        const bool of_others = !range.exported && !made->resource_->globals().exporters(f).empty();
        if (bytes != 0 && !of_others) made->seen_[t].push_back({globals.fields[f].offset, bytes});
      }
    }
  }
  return made;
}

void ReplicaSet::take_globals(std::uint32_t task) {
  const std::byte* const local = replicas_[task].program().table().data();
  for (const Part& part : seen_[task]) std::memcpy(&globals_[part.at], local + part.at, part.bytes);
}

bool ReplicaSet::load(std::uint32_t task, std::span<const std::byte> table) {
  if (!replicas_[task].load(table)) return false;
  follows_[task] = 0;
  take_globals(task);
  return true;
}

Replica::Outcome ReplicaSet::run(std::uint32_t task, std::span<const std::byte> record) {
  Replica::Outcome outcome = replicas_[task].run(record);
  follows_[task] = outcome.ran ? 1 : 0;
  if (outcome.slice) {
    const std::uint32_t first = *outcome.slice * runtime::kSliceBytes;
    outcome.differs = variables_at(task, first, first + runtime::kSliceBytes - 1);
  }
  take_globals(task);
  return outcome;
}

std::string ReplicaSet::difference(std::uint32_t task, std::span<const std::byte> table) {
  const Replica& replica = replicas_[task];
  if (table.size() != replica.table_bytes()) return "the size of the table";
  const std::byte* const mine = replica.program().table().data();
  const auto first = std::mismatch(table.begin(), table.end(), mine).first;
  if (first == table.end()) return {};
  const auto at = static_cast<std::uint32_t>(first - table.begin());
  return variables_at(task, at, at);
}

std::string ReplicaSet::variables_at(std::uint32_t task, std::uint32_t first, std::uint32_t last) {
  const bytecode::Image& image = resource_->image();
  const std::size_t globals = image.types[image.global_type].size;
  const runtime::Access access(*resource_);
  std::vector<std::pair<std::uint32_t, std::string>> found;
  // Hidden ones are listed by patterns with a '#' alone.
  for (const char* const pattern : {"*", "*#*"}) {
    for (runtime::Listed& listed : access.list_places(pattern)) {
      const runtime::Place& place = listed.place;
      // A task's copy of the globals lies where they lie in the global table.
      const bool here = place.task == task || (place.task == runtime::Place::kGlobal && place.offset < globals);
      const std::uint32_t bytes = std::max(image.types[place.type].size, 1u);
      if (here && place.offset <= last && place.offset + bytes > first)
        found.emplace_back(place.offset, std::move(listed.path));
    }
  }
  std::sort(found.begin(), found.end());
  if (found.empty()) {
    const runtime::TaskLayout& layout = replicas_[task].program().table().layout();
    for (std::size_t pou = 0; pou < layout.frames.size(); ++pou) {
      const std::uint32_t frame = layout.frames[pou];
      if (frame == runtime::TaskLayout::kAbsent || frame > last) continue;
      if (found.empty() || frame >= found.front().first) found = {{frame, "a value inside of " + image.pous[pou].name}};
    }
    return found.empty() ? fmt::format("the table, bytes {} to {}", first, last) : found.front().second;
  }
  if (found.size() == 1) return found.front().second;
  std::string text = "one of ";
  for (std::size_t i = 0; i < std::min(found.size(), kMostNames); ++i) text += (i == 0 ? "" : ", ") + found[i].second;
  if (found.size() > kMostNames) text += fmt::format(" and {} variables after them", found.size() - kMostNames);
  return text;
}

}  // namespace plc::shadow
