// Libraries: their declarations count when the project uses them. What one names is noted while it is declared; what is
// wrong with one was set aside, and is reported when the project reaches it.
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"

namespace plc::st {

using core::Code;
using plcopen::Section;
using plcopen::TypeSpec;

void Declarer::declare_libraries() {
  for (const plcopen::Extent& extent : project_.library_extents) {
    module_.library.add(extent.names, extent.begin, extent.end);
  }
  module_.library.finish();
  if (!module_.library.empty()) refuse_circular_blocks();
}

void Declarer::note_use(const core::SourceRef& user, const core::SourceRef& used, const core::SourceRef& at,
                        std::string_view pou) {
  const auto part = module_.library.at(used);
  if (!part) return;
  if (const auto own = module_.library.at(user)) {
    module_.library.need(*own, *part);
  } else {
    uses_.push_back({*part, at, std::string(pou), {}});
  }
}

bool Declarer::is_broken(std::string_view name, const core::SourceRef& user, const core::SourceRef& at,
                         std::string_view pou) {
  name = name.substr(name.rfind('.') + 1);
  const auto part = at.line == 0 ? std::nullopt : module_.library.broken(name, diagnostics_);
  if (!part) return false;
  if (const auto own = module_.library.at(user)) {
    module_.library.need(*own, *part);
  } else {
    uses_.push_back({*part, at, std::string(pou), std::string(name)});
  }
  return true;
}

void Declarer::report_uses() {
  for (const Use& use : uses_) module_.library.use(use.part, use.at, use.pou, diagnostics_, use.name);
  diagnostics_.end_setting_aside();
}

// Blocks of a library that contain themselves get no type: nothing could be laid out that has one, used or not. Those
// of the project are found by ir::check.
void Declarer::refuse_circular_blocks() {
  // POUs first, then data types; what contains what by value.
  const auto pous = static_cast<std::uint32_t>(project_.pous.size());
  const auto count = pous + static_cast<std::uint32_t>(project_.data_types.size());
  NameMap<std::uint32_t> nodes;
  for (std::uint32_t i = 0; i < pous; ++i) {
    if (project_.pous[i].kind != plcopen::PouKind::kFunction) nodes.emplace(project_.pous[i].name, i);
  }
  for (std::uint32_t i = pous; i < count; ++i) nodes.emplace(project_.data_types[i - pous].name, i);
  std::vector<std::vector<std::uint32_t>> parts(count);
  const auto collect = [&](std::uint32_t node, const TypeSpec& whole) {
    std::vector<const TypeSpec*> open = {&whole};
    while (!open.empty()) {
      const TypeSpec& spec = *open.back();
      open.pop_back();
      if (spec.kind == TypeSpec::Kind::kArray && spec.base) open.push_back(spec.base.get());
      for (const plcopen::Variable& member : spec.members) open.push_back(&member.type);
      if (spec.kind != TypeSpec::Kind::kNamed) continue;
      const auto found = nodes.find(core::trimmed(spec.name));
      if (found != nodes.end()) parts[node].push_back(found->second);
    }
  };
  for (std::uint32_t i = 0; i < pous; ++i) {
    if (!project_.pous[i].from_library || project_.pous[i].kind == plcopen::PouKind::kFunction) continue;
    for (const plcopen::Variable& v : project_.pous[i].variables) {
      const bool held = v.section == Section::kInput || v.section == Section::kOutput || v.section == Section::kLocal ||
                        v.section == Section::kInstance;
      if (held) collect(i, v.type);
    }
  }
  for (std::uint32_t i = pous; i < count; ++i) collect(i, project_.data_types[i - pous].type);

  enum : std::uint8_t { kNew, kOpen, kDone };
  std::vector<std::uint8_t> state(count, kNew);
  circular_.assign(pous, false);
  std::vector<std::pair<std::uint32_t, std::size_t>> stack;
  for (std::uint32_t start = 0; start < pous; ++start) {
    if (state[start] != kNew || !project_.pous[start].from_library) continue;
    stack.emplace_back(start, 0);
    state[start] = kOpen;
    while (!stack.empty()) {
      auto& [node, next] = stack.back();
      if (next == parts[node].size()) {
        state[node] = kDone;
        stack.pop_back();
        continue;
      }
      const std::uint32_t to = parts[node][next++];
      if (state[to] == kNew) {
        state[to] = kOpen;
        stack.emplace_back(to, 0);
        continue;
      }
      if (state[to] != kOpen) continue;
      std::string path;
      std::vector<std::uint32_t> blocks;
      for (auto it = stack.rbegin(); it != stack.rend(); ++it) {
        if (it->first < pous) blocks.push_back(it->first);
        path = (it->first < pous ? project_.pous[it->first].name : project_.data_types[it->first - pous].name) +
               " -> " + path;
        if (it->first == to) break;
      }
      path += to < pous ? project_.pous[to].name : project_.data_types[to - pous].name;
      for (const std::uint32_t block : blocks) {
        const plcopen::Pou& pou = project_.pous[block];
        circular_[block] = true;
        report(Code::P4202, pou.at, pou.name, "function block contains itself: " + path,
               "pass the other instance as VAR_IN_OUT");
      }
    }
  }
}

}  // namespace plc::st
