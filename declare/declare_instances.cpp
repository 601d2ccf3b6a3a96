// What a configuration says of one program instance: connections of its inputs and outputs, VAR_CONFIG.
#include <charconv>
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/names.h"

namespace plc::st {

using core::Code;
using ir::TypeKind;
using ir::TypeRef;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

std::vector<std::string_view> split_path(std::string_view path) {
  std::vector<std::string_view> out;
  for (std::size_t dot = path.find('.'); dot != std::string_view::npos; dot = path.find('.')) {
    out.push_back(path.substr(0, dot));
    path.remove_prefix(dot + 1);
  }
  out.push_back(path);
  return out;
}

/// The texts between brackets: "a[1,2][3]" has 1, 2 and 3.
std::vector<std::string_view> indices_of(std::string_view element) {
  std::vector<std::string_view> out;
  for (std::size_t at = element.find_first_of("[,"); at != std::string_view::npos; at = element.find_first_of("[,")) {
    element.remove_prefix(at + 1);
    out.push_back(core::trimmed(element.substr(0, element.find_first_of(",]"))));
  }
  return out;
}

}  // namespace

/// The global that `name` means: "X", "GVL.X", either after names of configuration and resource, or an address, which
/// becomes a global of type `type` when nothing is declared there.
std::optional<std::uint32_t> Declarer::global_at(std::string_view name, TypeRef type, const core::SourceRef& at) {
  if (name.starts_with('%')) {
    plcopen::Variable located;
    located.name = located.address = name;
    located.at = at;
    const auto address = address_of(located, type, {{}, located.name, at});
    if (!address || address->unlocated) return std::nullopt;
    const std::string normal = address->text();
    const auto [entry, fresh] =
        module_.global_by_name.emplace(normal, static_cast<std::uint32_t>(module_.globals.size()));
    if (fresh) {
      ir::Global global;
      global.variable.name = global.variable.address = normal;
      global.variable.type = type;
      global.variable.at = at;
      module_.globals.push_back(std::move(global));
    }
    return entry->second;
  }
  while (true) {
    const auto found = module_.global_by_name.find(name);
    if (found != module_.global_by_name.end()) {
      note_use(at, module_.globals[found->second].variable.at, at, {});
      return found->second;
    }
    const std::size_t dot = name.find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    name.remove_prefix(dot + 1);
  }
}

/// PROGRAM p : T (In := x, Out => y).
void Declarer::connect(ir::ProgramInstance& instance, const plcopen::InstanceConnection& connection) {
  const ir::Pou& pou = module_.pous[instance.pou];
  const auto refuse = [&](const core::SourceRef& at, std::string message, std::string help = {}) {
    report(Code::P4048, at, {}, "program instance " + quoted(instance.name) + ": " + message, std::move(help));
  };
  const auto found = pou.by_name.find(connection.variable);
  const ir::Role wanted = connection.output ? ir::Role::kOutput : ir::Role::kInput;
  if (found == pou.by_name.end() || pou.variables[found->second].role != wanted) {
    Guess guess(connection.variable);
    for (const ir::Variable& v : pou.variables) {
      if (v.role == wanted) guess.offer(v.name);
    }
    refuse(
        connection.at,
        "program " + pou.name + " has no " + (connection.output ? "output " : "input ") + quoted(connection.variable),
        guess.help());
    return;
  }
  const std::uint32_t variable = found->second;
  const TypeRef type = pou.variables[variable].type;
  const std::string_view other = core::trimmed(connection.other);
  const auto global = global_at(other, type, connection.other_at);
  if (global) {
    const ir::Variable& target = module_.globals[*global].variable;
    if (target.type != type) {
      refuse(connection.other_at, quoted(connection.variable) + " has type " + types().name_of(type) + ", " +
                                      quoted(other) + " has type " + types().name_of(target.type));
    } else if (connection.output && target.constant) {
      refuse(connection.other_at, quoted(other) + " is a constant and takes no output");
    } else {
      instance.wires.push_back({variable, *global, connection.output});
    }
    return;
  }
  if (other.starts_with('%')) return;  // the address was reported
  if (connection.output) {
    refuse(connection.other_at, quoted(other) + " is no global variable and no address",
           "outputs go to a global variable or an address");
    return;
  }
  const auto value = evaluate_constant(other, connection.other_at, types(), *this, diagnostics_, {}, type);
  std::string problem;
  std::optional<Code> note;
  auto constant = value ? constant_as(*value, type, types(), problem, note) : std::nullopt;
  if (note) report(*note, connection.other_at, {}, quoted(connection.variable) + ": " + problem);
  if (constant) {
    instance.initial.push_back({{variable}, std::move(*constant)});
  } else if (value) {
    refuse(connection.other_at, quoted(connection.variable) + ": " + problem);
  }
}

/// "Resource.Program.Variable AT %QX0.0 : BOOL := TRUE;" in VAR_CONFIG. The names of configuration and resource may be
/// omitted.
void Declarer::configure_variable(const plcopen::Variable& entry) {
  const auto refuse = [&](std::string message, std::string help = {}) {
    report(Code::P4049, entry.at, {}, "VAR_CONFIG " + quoted(entry.name) + ": " + message, std::move(help));
  };
  const std::vector<std::string_view> path = split_path(entry.name);
  ir::ProgramInstance* instance = nullptr;
  InstanceRoot root;
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < path.size() && i < 3 && instance == nullptr; ++i) {
    for (std::uint32_t t = 0; t < module_.tasks.size(); ++t) {
      for (std::uint32_t p = 0; p < module_.tasks[t].programs.size() && instance == nullptr; ++p) {
        ir::ProgramInstance& one = module_.tasks[t].programs[p];
        if (!core::iequals(one.name, path[i])) continue;
        instance = &one;
        root = {t, p};
      }
    }
    next = i + 1;
  }
  if (instance == nullptr) {
    refuse("no program instance has a name in this path", "write Resource.Program.Variable");
    return;
  }
  std::vector<std::uint32_t> steps;
  TypeRef type = module_.pous[instance->pou].instance_type;
  const ir::Variable* variable = nullptr;
  for (; next < path.size(); ++next) {
    const std::string_view name = path[next].substr(0, path[next].find('['));
    const ir::Type& t = types()[type];
    std::optional<std::uint32_t> step;
    if (t.kind == TypeKind::kPou) {
      const ir::Pou& pou = module_.pous[t.pou];
      const auto found = pou.by_name.find(name);
      if (found != pou.by_name.end()) {
        step = found->second;
        variable = &pou.variables[*step];
        type = variable->type;
      }
    } else if (t.kind == TypeKind::kStruct) {
      for (std::uint32_t i = 0; i < t.fields.size() && !step; ++i) {
        if (core::iequals(t.fields[i].name, name)) step = i;
      }
      if (step) type = t.fields[*step].type;
    }
    if (!step) {
      refuse("there is no " + quoted(name) + " in " + types().name_of(type));
      return;
    }
    steps.push_back(*step);
    for (const std::string_view index : indices_of(path[next])) {
      const ir::Type& array = types()[type];
      std::int64_t at = 0;
      const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), at);
      if (error != std::errc{} || end != index.data() + index.size() || array.kind != TypeKind::kArray ||
          at < array.lower || at > array.upper) {
        refuse("there is no element [" + std::string(index) + "] in " + types().name_of(type));
        return;
      }
      steps.push_back(static_cast<std::uint32_t>(at - array.lower));
      type = array.element;
    }
    // What is located at an address, or another's, lies outside of the instance.
    if (variable->role == ir::Role::kExternal && next + 1 < path.size()) {
      refuse(quoted(name) + " does not lie in the instance");
      return;
    }
  }
  if (entry.type.kind != plcopen::TypeSpec::Kind::kMissing) {
    const auto declared = resolve(entry.type, {{}, entry.name, entry.at});
    if (!declared) return;
    // Anonymous ranges and enumerations are equal to nothing but themselves.
    const bool anonymous = entry.type.kind != plcopen::TypeSpec::Kind::kNamed &&
                           types().elementary_of(*declared) == types().elementary_of(type);
    if (*declared != type && !anonymous) {
      refuse("it has type " + types().name_of(*declared) + " here, and " + types().name_of(type) + " in its POU",
             "give it the type that it has in its POU");
      return;
    }
  }
  const bool located = variable->role != ir::Role::kExternal && !variable->address.empty() && type == variable->type;
  const std::string_view given = core::trimmed(entry.address);
  if (!given.empty()) {
    if (!located) {
      refuse("the variable has no address to be filled in, such as %Q*");
      return;
    }
    const auto address = address_of(entry, type, {{}, entry.name, entry.at});
    if (address && address->unlocated) {
      refuse("address " + quoted(given) + " names no place", "write it like %QX0.0");
      return;
    }
    if (address && address->area != variable->address[1]) {
      refuse("the variable is at " + variable->address + ", and gets the address " + address->text(),
             "give it an address of its own area");
      return;
    }
    if (address && !given_addresses_.emplace(std::pair{root, steps}, address->text()).second) {
      refuse("the variable gets an address twice");
      return;
    }
  }
  if (variable->role != ir::Role::kExternal) {
    Items items;
    add_items(entry.initial, type, steps, items, {{}, entry.name, entry.at});
    instance->initial.insert(instance->initial.end(), items.begin(), items.end());
    return;
  }
  ir::Variable& global = module_.globals[variable->global].variable;
  if (entry.initial.kind != plcopen::InitialValue::Kind::kNone) {
    steps.clear();
    Items items;
    add_items(entry.initial, global.type, steps, items, {{}, entry.name, entry.at});
    global.initial = std::move(items);
  }
}

}  // namespace plc::st
