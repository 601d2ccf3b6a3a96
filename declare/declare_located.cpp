// Located variables of POUs: those at an address are one global place, those at %I*, %Q* or %M* one for each instance.
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/names.h"

namespace plc::st {

using core::Code;
using ir::Role;
using ir::TypeKind;
using ir::TypeRef;

namespace {

/// An image's types nest at most 64 deep; tasks and the global table add their own.
constexpr std::uint32_t kMaxInstanceNesting = 60;

/// Each takes a global of its own.
constexpr std::size_t kMaxLocated = 100'000;

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// Whether `v` is a variable that its instance itself holds.
bool lies_in_instance(const ir::Variable& v) {
  return !v.in_frame && v.role != Role::kExternal && v.role != Role::kInOut;
}

}  // namespace

// A variable of a POU at an address is a global place; all variables at one address share it.
bool Declarer::bind_located(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner) {
  const auto address = address_of(variable, out.type, owner);
  if (!address) return false;
  const std::string normal = address->text();
  out.address = normal;
  if (address->unlocated) return true;  // every instance has its own: locate_instances()
  const std::string own_name = std::string(owner.pou) + "." + variable.name;
  const auto known = module_.global_by_name.find(normal);
  if (known != module_.global_by_name.end()) {
    ir::Global& global = module_.globals[known->second];
    if (global.variable.type == out.type) {
      out.role = Role::kExternal;
      out.global = known->second;
      if (owned_by_one_pou_.erase(known->second) != 0) global.variable.name = normal;
      global.variable.retain = global.variable.retain || out.retain;
      global.variable.persistent = global.variable.persistent || out.persistent;
      module_.global_by_name.emplace(own_name, known->second);
      return true;
    }
    if (address->area != 'I') {
      report(Code::P4032, variable.at, owner.pou,
             quoted(variable.name) + " of type " + types().name_of(out.type) + " and " + quoted(global.variable.name) +
                 " of type " + types().name_of(global.variable.type) + " are both at " + normal,
             "give variables at one address one type");
      return false;
    }
  }
  ir::Global global;
  global.variable = out;
  global.from_library = is_library(variable.at);
  global.variable.name = own_name;
  global.variable.role = Role::kLocal;
  const auto index = static_cast<std::uint32_t>(module_.globals.size());
  if (module_.global_by_name.emplace(normal, index).second) owned_by_one_pou_.insert(index);
  module_.global_by_name.emplace(own_name, index);
  module_.globals.push_back(std::move(global));
  out.role = Role::kExternal;
  out.global = index;
  return true;
}

bool Declarer::holds_located(TypeRef type) {
  enum : std::uint8_t { kUnknown, kNo, kYes };
  if (holds_located_.size() < types().size()) holds_located_.resize(types().size(), kUnknown);
  if (holds_located_[type.index] != kUnknown) return holds_located_[type.index] == kYes;
  holds_located_[type.index] = kNo;  // also ends blocks that contain themselves, which ir::check reports
  const ir::Type& t = types()[type];
  bool found = t.kind == TypeKind::kArray && holds_located(t.element);
  if (t.kind == TypeKind::kStruct) {
    for (std::size_t i = 0; i < t.fields.size() && !found; ++i) found = holds_located(t.fields[i].type);
  }
  if (t.kind == TypeKind::kPou) {
    for (const ir::Variable& v : module_.pous[t.pou].variables) {
      found = found || (lies_in_instance(v) && (!v.address.empty() || holds_located(v.type)));
    }
  }
  holds_located_[type.index] = found ? kYes : kNo;
  return found;
}

void Declarer::locate_parts(const InstanceRoot& root, TypeRef type, const std::string& name,
                            std::vector<std::uint32_t>& path, std::vector<ir::LocatedPart>& out) {
  if (!holds_located(type) || out.size() > kMaxLocated) return;
  const ir::Type t = types()[type];
  const auto descend = [&](std::uint32_t step, TypeRef part, const std::string& part_name) {
    path.push_back(step);
    locate_parts(root, part, part_name, path, out);
    path.pop_back();
  };
  if (t.kind == TypeKind::kArray) {
    const std::uint64_t count = static_cast<std::uint64_t>(t.upper) - static_cast<std::uint64_t>(t.lower) + 1;
    for (std::uint32_t i = 0; i < count && out.size() <= kMaxLocated; ++i) {
      descend(i, t.element, name + "[" + std::to_string(t.lower + static_cast<std::int64_t>(i)) + "]");
    }
  }
  for (std::uint32_t i = 0; t.kind == TypeKind::kStruct && i < t.fields.size(); ++i) {
    descend(i, t.fields[i].type, name + "." + t.fields[i].name);
  }
  if (t.kind != TypeKind::kPou) return;
  for (std::uint32_t i = 0; i < module_.pous[t.pou].variables.size(); ++i) {
    const ir::Variable& v = module_.pous[t.pou].variables[i];
    if (!lies_in_instance(v)) continue;
    if (v.address.empty()) {
      descend(i, v.type, name + "." + v.name);
      continue;
    }
    if (out.size() == kMaxLocated) {
      report(Code::P4017, v.at, {},
             "more than " + std::to_string(kMaxLocated) + " variables at %I*, %Q* and %M* in one instance",
             "use arrays");
    }
    if (out.size() >= kMaxLocated) {
      out.push_back({});
      return;
    }
    path.push_back(i);
    out.push_back(locate(root, v, name + "." + v.name, path));
    path.pop_back();
  }
}

ir::LocatedPart Declarer::locate(const InstanceRoot& root, const ir::Variable& v, const std::string& name,
                                 const std::vector<std::uint32_t>& path) {
  ir::LocatedPart part{name, path, 0, !v.address.starts_with("%I")};
  const auto given = given_addresses_.find({root, path});
  const std::string address = given == given_addresses_.end() ? v.address : given->second;
  const auto known = module_.global_by_name.find(address);
  if (known != module_.global_by_name.end()) {
    const ir::Variable& other = module_.globals[known->second].variable;
    if (other.type == v.type) {
      part.global = known->second;
      part.begins = other.initial.empty();
      return part;
    }
    if (part.output) {
      report(Code::P4032, v.at, {},
             quoted(name) + " of type " + types().name_of(v.type) + " and " + quoted(other.name) + " of type " +
                 types().name_of(other.type) + " are both at " + address,
             "give variables at one address one type");
    }
  }
  ir::Global global;
  global.variable = v;
  global.from_library = is_library(v.at);
  global.variable.name = name;
  global.variable.address = address;
  global.variable.role = Role::kLocal;
  global.variable.initial.clear();
  global.variable.references.clear();
  part.global = static_cast<std::uint32_t>(module_.globals.size());
  if (!address.ends_with('*')) module_.global_by_name.emplace(address, part.global);
  module_.global_by_name.emplace(name, part.global);
  module_.globals.push_back(std::move(global));
  return part;
}

// Instances lie in each other by value; whatever walks through them counts on an end.
bool Declarer::check_nesting() {
  enum : std::uint32_t { kUnknown = 0, kOpen = 0xffffffffu };
  std::vector<std::uint32_t> levels(types().size(), kUnknown);
  std::vector<TypeRef> parts;
  const auto collect = [&](TypeRef type) {
    const ir::Type& t = types()[type];
    parts.clear();
    if (t.kind == TypeKind::kArray) parts.push_back(t.element);
    for (const ir::TypeField& field : t.fields) parts.push_back(field.type);
    if (t.kind != TypeKind::kPou) return;
    for (const ir::Variable& v : module_.pous[t.pou].variables) {
      if (lies_in_instance(v)) parts.push_back(v.type);
    }
  };
  bool fine = true, reported = false;
  std::vector<TypeRef> open;
  for (const ir::Pou& pou : module_.pous) {
    if (!pou.instance_type.valid()) continue;
    open.push_back(pou.instance_type);
    while (!open.empty()) {
      const TypeRef type = open.back();
      std::uint32_t& own = levels[type.index];
      const bool second = own == kOpen;
      if (own != kUnknown && !second) {
        open.pop_back();
        continue;
      }
      own = kOpen;
      collect(type);
      std::uint32_t deepest = 0;
      bool waits = false;
      for (const TypeRef part : parts) {
        const std::uint32_t level = levels[part.index];
        if (level == kUnknown) {
          open.push_back(part);
          waits = true;
        } else if (level == kOpen) {
          fine = false;  // contains itself: ir::check reports it
        } else {
          deepest = std::max(deepest, level);
        }
      }
      if (waits) continue;
      own = deepest + 1;
      open.pop_back();
      const ir::Type& t = types()[type];
      if (own <= kMaxInstanceNesting) continue;
      fine = false;
      if (t.kind != TypeKind::kPou || reported) continue;
      reported = true;
      const ir::Pou& deep = module_.pous[t.pou];
      report(Code::P4017, deep.at, deep.name,
             "instances in " + quoted(deep.name) + " are nested more than " + std::to_string(kMaxInstanceNesting) +
                 " levels deep",
             "pass some of them as VAR_IN_OUT");
    }
  }
  return fine;
}

void Declarer::locate_instances() {
  std::vector<std::uint32_t> path;
  for (std::uint32_t t = 0; t < module_.tasks.size(); ++t) {
    for (std::uint32_t p = 0; p < module_.tasks[t].programs.size(); ++p) {
      ir::ProgramInstance& program = module_.tasks[t].programs[p];
      if (program.global != ir::Pou::kDeclared) continue;
      locate_parts({t, p}, module_.pous[program.pou].instance_type, program.name, path, program.located);
    }
  }
  for (std::uint32_t g = 0, count = static_cast<std::uint32_t>(module_.globals.size()); g < count; ++g) {
    const ir::Variable whole = module_.globals[g].variable;
    const std::string& list = module_.globals[g].list;
    std::vector<ir::LocatedPart> parts;
    locate_parts({InstanceRoot::kGlobal, g}, whole.type, (list.empty() ? "" : list + ".") + whole.name, path, parts);
    for (ir::LocatedPart& part : parts) module_.located.push_back({g, std::move(part)});
  }
}

}  // namespace plc::st
