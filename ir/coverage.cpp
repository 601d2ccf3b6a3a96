#include "ir/coverage.h"

#include "ir/builder.h"

namespace plc::ir {

const CoverKindInfo& info(CoverKind kind) {
  static constexpr CoverKindInfo kKinds[] = {
#define PLC_COVER_KIND(kind, word, first, second) {word, first, second},
#include "ir/cover_kinds.def"
  };
  return kKinds[static_cast<std::size_t>(kind)];
}

void begin_coverage(Module& module) {
  Type type;
  type.kind = TypeKind::kArray;
  type.element = kBoolType;
  module.types.declare(kCoverageName, std::move(type));
  Global global;
  global.variable.name = kCoverageName;
  global.variable.type = *module.types.find(kCoverageName);
  global.from_library = true;
  module.coverage.emplace();
  module.coverage->global = static_cast<std::uint32_t>(module.globals.size());
  module.globals.push_back(std::move(global));
}

std::optional<std::uint32_t> Builder::cover_site(CoverKind kind, const SourceRef& at, std::string_view text,
                                                 std::uint32_t rung) {
  if (!module_.coverage || pou().test || pou().from_library) return std::nullopt;
  Coverage& coverage = *module_.coverage;
  // What is made from a generic function has its name, and its places.
  const Pou& built = module_.pous[pou_index_];
  const std::string& name = built.made_from == Pou::kDeclared ? built.name : module_.pous[built.made_from].name;
  const auto fresh = static_cast<std::uint32_t>(coverage.sites.size());
  const auto [known, added] =
      coverage.known.try_emplace({kind, name, at.file, at.line, at.column, at.local_id, std::string(text)}, fresh);
  if (!added) return known->second;
  coverage.sites.push_back({kind, name, at, std::string(text), rung});
  module_.types.mutable_type(module_.globals[coverage.global].variable.type).upper = 2 * std::int64_t{fresh} + 1;
  return fresh;
}

void Builder::cover(std::optional<std::uint32_t> site, std::uint32_t outcome, std::optional<ValueId> when) {
  if (!site) return;
  const PlaceId seen = element(global(module_.coverage->global), 2 * *site + outcome);
  store(seen, when ? logic(Op::kOr, load(seen), *when) : constant_bool(true));
}

}  // namespace plc::ir
