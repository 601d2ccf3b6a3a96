// Tasks, their intervals, and the program instances they run.
#include <algorithm>
#include <charconv>
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/lexer.h"
#include "frontend-st/literals.h"
#include "frontend-st/names.h"

namespace plc::st {

using core::Code;

namespace {

/// Period of the task that --pou and instances without a task get.
constexpr std::int64_t kDefaultPeriodNs = 20'000'000;
constexpr std::int64_t kSecond = 1'000'000'000;

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// A decimal number at the front of `text` times `unit`; what follows stays in `text`.
std::optional<std::int64_t> take_decimal(std::string_view& text, std::int64_t unit) {
  std::int64_t value = 0;
  std::size_t i = 0;
  while (i < text.size() && is_digit(text[i])) {
    if (__builtin_mul_overflow(value, 10, &value) || __builtin_add_overflow(value, text[i] - '0', &value))
      return std::nullopt;
    ++i;
  }
  if (i == 0 || __builtin_mul_overflow(value, unit, &value)) return std::nullopt;
  if (i < text.size() && (text[i] == '.' || text[i] == ',')) {
    ++i;
    while (i < text.size() && is_digit(text[i])) {
      unit /= 10;
      if (__builtin_add_overflow(value, (text[i] - '0') * unit, &value)) return std::nullopt;
      ++i;
    }
  }
  text.remove_prefix(i);
  return value;
}

// "PT0.02S", "P1DT2H" (ISO 8601; months and years have no fixed length and are refused).
std::optional<std::int64_t> parse_iso(std::string_view text) {
  text.remove_prefix(1);
  std::int64_t total = 0;
  bool time = false;
  bool any = false;
  while (!text.empty()) {
    if (!time && core::upper(text[0]) == 'T') {
      time = true;
      text.remove_prefix(1);
      continue;
    }
    const std::size_t unit_at = text.find_first_not_of("0123456789.,");
    if (unit_at == std::string_view::npos) return std::nullopt;
    std::int64_t unit = 0;
    switch (core::upper(text[unit_at])) {
      case 'W':
        unit = time ? 0 : 7 * (86'400 * kSecond);
        break;
      case 'D':
        unit = time ? 0 : 86'400 * kSecond;
        break;
      case 'H':
        unit = time ? 3'600 * kSecond : 0;
        break;
      case 'M':
        unit = time ? 60 * kSecond : 0;
        break;
      case 'S':
        unit = time ? kSecond : 0;
        break;
      default:
        break;
    }
    const auto part = unit == 0 ? std::nullopt : take_decimal(text, unit);
    if (!part || text.empty() || __builtin_add_overflow(total, *part, &total)) return std::nullopt;
    text.remove_prefix(1);
    any = true;
  }
  return any ? std::optional(total) : std::nullopt;
}

// "00:00:00.100000": hours, minutes, seconds.
std::optional<std::int64_t> parse_clock(std::string_view text) {
  static constexpr std::int64_t kUnits[] = {3'600 * kSecond, 60 * kSecond, kSecond};
  std::int64_t total = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto part = take_decimal(text, kUnits[i]);
    if (!part || __builtin_add_overflow(total, *part, &total)) return std::nullopt;
    if (i == 2) break;
    if (text.empty() || text[0] != ':') return std::nullopt;
    text.remove_prefix(1);
  }
  return text.empty() ? std::optional(total) : std::nullopt;
}

}  // namespace

std::optional<std::int64_t> parse_interval(std::string_view text, std::string_view unit, std::string& problem) {
  text = core::trimmed(text);
  unit = core::trimmed(unit);
  std::optional<std::int64_t> ns;
  const std::size_t hash = text.find('#');
  const bool plain_number = !text.empty() && text.find_first_not_of("0123456789.") == std::string_view::npos;
  problem = "it is none of T#20ms, PT0.02S, 00:00:00.02, 20ms";
  if (hash != std::string_view::npos) {
    const auto literal = parse_literal(text, problem);
    if (literal && literal->kind == Literal::Kind::kScalar && core::in_category(literal->type, core::kAnyDuration)) {
      ns = static_cast<std::int64_t>(literal->bits);
    } else if (literal) {
      problem = "it is no duration";
    }
  } else if (plain_number && !unit.empty()) {
    std::int64_t scale = 0;
    if (core::iequals(unit, "ns")) scale = 1;
    if (core::iequals(unit, "us") || unit == "\xc2\xb5s" || unit == "\xce\xbcs") scale = 1'000;
    if (core::iequals(unit, "ms")) scale = 1'000'000;
    if (core::iequals(unit, "s")) scale = kSecond;
    std::string_view rest = text;
    if (scale != 0) ns = take_decimal(rest, scale);
    if (!ns || !rest.empty()) {
      problem = "its unit " + quoted(unit) + " is none of ns, us, ms, s";
      return std::nullopt;
    }
  } else if (plain_number) {
    problem = "it has no unit";
  } else if (!text.empty() && core::upper(text[0]) == 'P') {
    ns = parse_iso(text);
  } else if (text.find(':') != std::string_view::npos) {
    ns = parse_clock(text);
  } else if (!text.empty()) {
    ns = parse_duration(text, problem);
  }
  if (ns && *ns < 0) {
    problem = "it is negative";
    return std::nullopt;
  }
  return ns;
}

std::string Declarer::pou_list(bool function_blocks) const {
  constexpr std::size_t kShown = 12;
  std::string out;
  std::size_t count = 0;
  for (const ir::Pou& pou : module_.pous) {
    const bool wanted =
        pou.kind == ir::PouKind::kProgram || (function_blocks && pou.kind == ir::PouKind::kFunctionBlock);
    if (!wanted || pou.from_library || pou.taskblock != 0 || pou.test || pou.owner != ir::Pou::kDeclared) continue;
    if (count++ == kShown) return out + ", ..";
    out += (out.empty() ? "" : ", ") + pou.name;
  }
  return out;
}

std::optional<std::string> Declarer::resolve_trigger(std::string_view name) {
  const auto global_named = [this](std::string_view path) {
    const auto global = module_.global_by_name.find(path);
    return global != module_.global_by_name.end() && module_.globals[global->second].variable.type == ir::kBoolType;
  };
  if (!name.empty() && name[0] == '%') {
    std::string problem;
    const auto address = parse_address(name, problem);
    if (!address || address->unlocated || address->size != 'X') return std::nullopt;
    const std::string normal = address->text();
    if (module_.global_by_name.find(normal) == module_.global_by_name.end()) {
      ir::Global global;
      global.variable.name = global.variable.address = normal;
      global.variable.type = ir::kBoolType;
      module_.global_by_name.emplace(normal, static_cast<std::uint32_t>(module_.globals.size()));
      module_.globals.push_back(std::move(global));
    }
    return global_named(normal) ? std::optional(normal) : std::nullopt;
  }
  if (global_named(name)) return std::string(name);
  // "Instance.Variable", with or without the names of configuration and resource before it.
  const std::size_t last = name.rfind('.');
  if (last == std::string_view::npos) return std::nullopt;
  const std::string_view variable_name = name.substr(last + 1);
  const std::string_view owner = name.substr(0, last);
  const std::size_t before = owner.rfind('.');
  const std::string_view instance_name = before == std::string_view::npos ? owner : owner.substr(before + 1);
  for (const ir::Task& task : module_.tasks) {
    for (const ir::ProgramInstance& one : task.programs) {
      if (!core::iequals(one.name, instance_name)) continue;
      // Only what lies in the global table can release a task: a variable at an address.
      const ir::Variable* variable = module_.pous[one.pou].find(variable_name);
      if (variable == nullptr || variable->type != ir::kBoolType) return std::nullopt;
      if (variable->role == ir::Role::kExternal) {
        const ir::Global& global = module_.globals[variable->global];
        if (!variable->address.empty()) return variable->address;
        return global.list.empty() ? global.variable.name : global.list + "." + global.variable.name;
      }
      const std::string path = one.name + "." + variable->name;
      for (const ir::LocatedPart& part : one.located) {
        if (core::iequals(part.name, path)) return module_.globals[part.global].variable.name;
      }
      return std::nullopt;
    }
  }
  if (global_named(variable_name)) return std::string(variable_name);
  return std::nullopt;
}

std::optional<ir::ProgramInstance> Declarer::instance(const plcopen::PouInstance& from) {
  std::string_view type = core::trimmed(from.type_name);
  if (type.empty()) type = from.name;
  const auto found = module_.pou_by_name.find(type);
  if (found != module_.pou_by_name.end() && module_.pous[found->second].kind == ir::PouKind::kProgram) {
    for (const ir::Task& task : module_.tasks) {
      for (const ir::ProgramInstance& other : task.programs) {
        if (!core::iequals(other.name, from.name)) continue;
        report(Code::P4018, from.at, {},
               "program instance " + quoted(from.name) + " is declared twice, first " + first_place(other.at, from.at));
        instance_failed_ = true;
        return std::nullopt;
      }
    }
    note_use(from.at, module_.pous[found->second].at, from.at, {});
    ir::ProgramInstance out{from.name, found->second, from.at, from.retain};
    for (const plcopen::InstanceConnection& connection : from.connections) connect(out, connection);
    return out;
  }
  instance_failed_ = true;
  if (found == module_.pou_by_name.end() && is_broken(type, from.at, from.at, {})) return std::nullopt;
  const std::string programs = pou_list(false);
  std::string help = programs.empty() ? "the file has no program" : "programs of the file: " + programs;
  const std::string runnable = pou_list(true);
  if (!runnable.empty()) help += "; --pou NAME runs one of " + runnable + " alone";
  std::string message = "instance " + quoted(from.name) + " is of the program " + quoted(type) + ", which ";
  if (found == module_.pou_by_name.end()) {
    message += "does not exist";
  } else {
    message += std::string("is a ") +
               (module_.pous[found->second].kind == ir::PouKind::kFunction ? "function" : "function block");
  }
  report(Code::P4027, from.at, {}, std::move(message), std::move(help));
  return std::nullopt;
}

void Declarer::declare_task(const plcopen::Task& from, const std::string& resource) {
  ir::Task task;
  task.name = from.name;
  task.at = from.at;
  task.single = std::string(core::trimmed(from.single));
  for (const ir::Task& other : module_.tasks) {
    if (core::iequals(other.name, task.name)) task.name = resource + "." + from.name;
  }
  for (const ir::Task& other : module_.tasks) {
    if (!core::iequals(other.name, task.name)) continue;
    report(Code::P4018, from.at, {},
           "task " + quoted(from.name) + " is declared twice, first " + first_place(other.at, from.at));
    break;
  }
  const bool freewheeling = core::iequals(core::trimmed(from.kind), "Freewheeling");
  if (!core::trimmed(from.interval).empty() && !freewheeling) {
    std::string problem;
    const auto ns = parse_interval(from.interval, from.interval_unit, problem);
    const std::string_view written = core::trimmed(from.interval);
    if (ns) {
      task.period_ns = *ns;
      if (written.find('#') != std::string_view::npos && written.find_first_of(" \t") != std::string_view::npos) {
        report(Code::P4065, from.at, {},
               "blank inside the interval " + quoted(written) + " of task " + quoted(from.name),
               "write it like T#20ms");
      }
    } else {
      report(Code::P4025, from.at, {},
             "interval " + quoted(from.interval) + " of task " + quoted(from.name) + ": " + problem,
             "write it like T#20ms");
    }
  } else if (core::iequals(core::trimmed(from.kind), "Cyclic") && task.single.empty()) {
    report(Code::P4025, from.at, {}, "cyclic task " + quoted(from.name) + " has no interval", "write it like T#20ms");
  }
  const std::string_view priority = core::trimmed(from.priority);
  if (!priority.empty()) {
    const auto [stop, error] = std::from_chars(priority.data(), priority.data() + priority.size(), task.priority);
    if (error != std::errc{} || stop != priority.data() + priority.size() || task.priority < 0) {
      report(Code::P4026, from.at, {},
             "priority " + quoted(priority) + " of task " + quoted(from.name) + " is no number from 0 up",
             "0 is the highest priority");
      task.priority = 0;
    }
  }
  module_.tasks.push_back(std::move(task));
  const std::size_t index = module_.tasks.size() - 1;
  for (const plcopen::PouInstance& one : from.instances) {
    if (auto made = instance(one)) module_.tasks[index].programs.push_back(std::move(*made));
  }
}

void Declarer::declare_instances(const plcopen::Resource& resource, std::size_t first_task) {
  if (resource.instances.empty()) return;
  const core::SourceRef& at = resource.instances.front().at;
  const std::size_t tasks = module_.tasks.size() - first_task;
  if (tasks == 0) {
    report(Code::P4030, at, {},
           (resource.name.empty() ? "configuration" : "resource " + quoted(resource.name)) +
               " has program instances and no task; they run every 20 ms",
           "declare a task with an interval");
    ir::Task task;
    task.name = "main";
    task.period_ns = kDefaultPeriodNs;
    task.at = resource.at;
    module_.tasks.push_back(std::move(task));
  } else if (tasks > 1) {
    report(Code::P4030, at, {},
           "program instances are declared beside the tasks of " +
               (resource.name.empty() ? "the configuration" : "resource " + quoted(resource.name)) +
               "; the first task, " + quoted(module_.tasks[first_task].name) + ", runs them",
           "move them into the task that shall run them");
  }
  for (const plcopen::PouInstance& one : resource.instances) {
    if (auto made = instance(one)) module_.tasks[first_task].programs.push_back(std::move(*made));
  }
}

void Declarer::declare_single_pou() {
  const auto found = module_.pou_by_name.find(options_.pou);
  if (found == module_.pou_by_name.end() || module_.pous[found->second].kind == ir::PouKind::kFunction) {
    Guess guess(options_.pou);
    for (const ir::Pou& pou : module_.pous) {
      if (pou.kind != ir::PouKind::kFunction && pou.owner == ir::Pou::kDeclared) guess.offer(pou.name);
    }
    const std::string candidates = pou_list(true);
    std::string help = guess.help();
    if (!candidates.empty())
      help += (help.empty() ? "" : " ") + std::string("programs and function blocks: ") + candidates;
    report(Code::P4029, whole_file(), {},
           found == module_.pou_by_name.end() ? "there is no POU " + quoted(options_.pou)
                                              : quoted(options_.pou) + " is a function and has no instance",
           std::move(help));
    return;
  }
  ir::Task task;
  task.name = "main";
  task.period_ns = kDefaultPeriodNs;
  task.at = module_.pous[found->second].at;
  task.programs.push_back({module_.pous[found->second].name, found->second, task.at});
  module_.tasks.push_back(std::move(task));
}

void Declarer::declare_configuration() {
  if (!options_.pou.empty()) {
    declare_single_pou();
    place_programs();
    if (check_nesting()) locate_instances();
    return;
  }
  for (const plcopen::Configuration& configuration : project_.configurations) {
    for (const plcopen::Resource& resource : configuration.resources) {
      const std::size_t first = module_.tasks.size();
      for (const plcopen::Task& task : resource.tasks) declare_task(task, resource.name);
      declare_instances(resource, first);
    }
    for (const plcopen::Variable& entry : configuration.configs) configure_variable(entry);
  }
  place_programs();
  if (check_nesting()) locate_instances();
  std::size_t programs = 0;
  for (ir::Task& task : module_.tasks) {
    programs += task.programs.size();
    if (task.single.empty()) continue;
    if (auto trigger = resolve_trigger(task.single)) {
      task.single = std::move(*trigger);
      continue;
    }
    report(Code::P4026, task.at, {},
           "task " + quoted(task.name) + " waits for " + quoted(task.single) + ", which is no BOOL variable",
           "name a global BOOL variable, a bit address, or a variable of a program that has an address");
  }
  const std::string runnable = pou_list(true);
  // Tests have instances of their own.
  const bool tested =
      std::any_of(module_.pous.begin(), module_.pous.end(), [](const ir::Pou& pou) { return pou.test; });
  if (programs == 0 && !instance_failed_ && !runnable.empty() && !tested) {
    report(Code::P4028, whole_file(), {}, "nothing instantiates any POU",
           "--pou NAME runs one of " + runnable + " alone");
  }
}

}  // namespace plc::st
