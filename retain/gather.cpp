#include "retain/gather.h"

#include <algorithm>
#include <cstring>

namespace plc::retain {

Gatherer::Gatherer(runtime::Resource& resource, const Kept& kept) : resource_(resource), kept_(kept) {
  const std::vector<Root>& roots = kept.layout.roots;
  for (std::size_t r = 0; r < roots.size();) {
    const std::uint32_t task = kept.sources[r].task;
    const std::uint64_t first = roots[r].at;
    std::vector<runtime::Handover::Run> runs;
    bool global = false;
    for (; r < roots.size() && kept.sources[r].task == task; ++r) {
      const Source& source = kept.sources[r];
      if (task == Source::kShared) {
        shared_.push_back({roots[r].at, source.offset, size_of(r)});
        continue;
      }
      const std::uint32_t from = source.offset + (source.global ? 0 : resource.program(task).table().layout().instance);
      const auto to = static_cast<std::uint32_t>(roots[r].at - first);
      // Neighbours, with what is between them.
      const bool joined = !runs.empty() && global == source.global && from >= runs.back().from &&
                          from - runs.back().from == to - runs.back().to;
      if (joined) {
        runs.back().bytes = to + size_of(r) - runs.back().to;
      } else {
        runs.push_back({from, to, size_of(r)});
      }
      global = source.global;
    }
    if (task == Source::kShared) continue;
    const std::uint64_t bytes = std::uint64_t{runs.back().to} + runs.back().bytes;
    parts_.push_back({task, first, bytes});
    resource.program(task).keep(std::move(runs), bytes);
  }
  if (!shared_.empty()) reader_.emplace(resource.globals());
}

void Gatherer::copy_initial(std::span<std::byte> values) const {
  std::vector<std::byte> globals(resource_.globals().size());
  resource_.globals().copy(globals.data());
  for (std::size_t r = 0; r < kept_.sources.size(); ++r) {
    const Source& source = kept_.sources[r];
    const std::byte* from = globals.data();
    if (!source.global) {
      const runtime::TaskTable& table = resource_.program(source.task).table();
      from = table.data() + table.layout().instance;
    }
    std::memcpy(values.data() + kept_.layout.roots[r].at, from + source.offset, size_of(r));
  }
}

void Gatherer::restore(std::span<const std::byte> values) {
  std::vector<std::byte> globals(resource_.globals().size());
  resource_.globals().copy(globals.data());
  std::vector<std::vector<std::byte>> instances;
  for (const bytecode::ImageTask& task : resource_.image().tasks) {
    instances.push_back(resource_.image().pous[task.body].instance_initial);
  }
  for (std::size_t r = 0; r < kept_.sources.size(); ++r) {
    const Source& source = kept_.sources[r];
    std::byte* const to = source.global ? globals.data() : instances[source.task].data();
    std::memcpy(to + source.offset, values.data() + kept_.layout.roots[r].at, size_of(r));
  }
  resource_.restore(globals, instances);
}

void Gatherer::ask() noexcept {
  for (const Part& part : parts_) resource_.program(part.task).handover()->ask();
}

bool Gatherer::answered() const noexcept {
  return std::all_of(parts_.begin(), parts_.end(),
                     [this](const Part& part) { return resource_.program(part.task).handover()->answered(); });
}

core::TimeNs Gatherer::take(std::span<std::byte> values) {
  core::TimeNs latest = 0;
  for (const Part& part : parts_) {
    runtime::Handover& handover = *resource_.program(part.task).handover();
    if (!handover.answered()) continue;
    std::memcpy(values.data() + part.at, handover.block().data(), part.bytes);
    latest = std::max(latest, handover.now_ns());
    handover.taken();
  }
  if (reader_) {
    reader_->take();
    for (const Piece& piece : shared_) reader_->read(piece.offset, piece.bytes, values.data() + piece.at);
  }
  return latest;
}

void Gatherer::answer_for(std::uint32_t task) noexcept {
  runtime::Program& program = resource_.program(task);
  if (program.handover() == nullptr) return;
  program.handover()->ask();
  program.offer_kept();
}

}  // namespace plc::retain
