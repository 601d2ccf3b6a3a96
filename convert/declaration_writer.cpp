#include "convert/declaration_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "convert/literals.h"
#include "core/text.h"
#include "frontend-st/keywords.h"
#include "frontend-st/lexer.h"

namespace plc::convert {
namespace {

using plcopen::InitialValue;
using plcopen::Section;
using plcopen::TypeSpec;
using plcopen::Variable;

std::string_view word_of(Section section) {
  switch (section) {
    case Section::kInput:
      return "VAR_INPUT";
    case Section::kOutput:
      return "VAR_OUTPUT";
    case Section::kInOut:
      return "VAR_IN_OUT";
    case Section::kLocal:
      return "VAR";
    case Section::kTemp:
      return "VAR_TEMP";
    case Section::kExternal:
      return "VAR_EXTERNAL";
    case Section::kGlobal:
      return "VAR_GLOBAL";
    case Section::kAccess:
      return "VAR_ACCESS";
    case Section::kConfig:
      return "VAR_CONFIG";
    case Section::kInstance:
      return "VAR_INST";
    case Section::kStatic:
      return "VAR_STAT";
    case Section::kGeneric:
      return "VAR_GENERIC";
  }
  return "VAR";
}

std::string bounds(const plcopen::Dimension& dimension) {
  return dimension.lower == "*" ? "*" : dimension.lower + ".." + dimension.upper;
}

std::string write_value(const InitialValue& value) {
  std::string text;
  const auto list = [&](char open, char close) {
    text += open;
    for (std::size_t i = 0; i < value.values.size(); ++i) {
      const InitialValue& one = value.values[i];
      text += i == 0 ? "" : ", ";
      if (!one.member.empty()) text += name_text(one.member) + " := ";
      std::string inner = write_value(one);
      text += one.repetition.empty() ? inner : one.repetition + "(" + inner + ")";
    }
    text += close;
  };
  switch (value.kind) {
    case InitialValue::Kind::kNone:
      break;
    case InitialValue::Kind::kSimple:
      text = core::trimmed(value.text);
      break;
    case InitialValue::Kind::kArray:
      list('[', ']');
      break;
    case InitialValue::Kind::kStruct:
      list('(', ')');
      break;
  }
  return text;
}

/// A text as a comment. What would end it, or begin another inside of it, is taken apart.
std::string comment(std::string_view text) {
  std::string out = "(* ";
  for (const char c : core::trimmed(text)) {
    const bool ends = !out.empty() && ((c == ')' && out.back() == '*') || (c == '*' && out.back() == '('));
    if (ends) out += ' ';
    if (c != '\r') out += c;
  }
  return out + " *)";
}

std::string write_variable(const Variable& variable, const Comments& comments) {
  std::string text;
  if (variable.section == Section::kAccess) {
    return variable.name + " : " + variable.address + " : " + write_type(variable.type, comments) +
           (variable.constant ? " READ_ONLY;" : " READ_WRITE;") + comments.after(variable.at);
  }
  const bool unnamed = variable.name.empty() || variable.name.front() == '%';
  if (!unnamed) {
    // VAR_CONFIG has paths.
    text += variable.section == Section::kConfig ? variable.name : name_text(variable.name);
  }
  if (!variable.address.empty()) text += (unnamed ? "AT " : " AT ") + variable.address;
  text += " : " + write_type(variable.type, comments);
  if (variable.edge != plcopen::Edge::kNone) text += variable.edge == plcopen::Edge::kRising ? " R_EDGE" : " F_EDGE";
  const std::string value = write_value(variable.initial);
  if (!value.empty()) text += " := " + value;
  text += ";";
  if (!core::trimmed(variable.documentation).empty()) text += "  " + comment(variable.documentation);
  text += comments.after(variable.at);
  return text;
}

/// Whether two variables stand in one section.
bool together(const Variable& a, const Variable& b) {
  const bool readable = a.section == Section::kAccess || a.constant == b.constant;
  return a.section == b.section && readable && a.retain == b.retain && a.nonretain == b.nonretain &&
         a.persistent == b.persistent && a.list == b.list && a.prefix == b.prefix;
}

/// Lines of the members of a structure or union.
std::string write_members(const TypeSpec& type, const Comments& comments) {
  std::string text;
  for (const Variable& member : type.members) {
    text += comments.before(member.at, 4) + "    " + write_variable(member, comments) + "\n";
  }
  return text;
}

std::string task_text(const plcopen::Task& task, const ir::Module& module) {
  const auto made = std::find_if(module.tasks.begin(), module.tasks.end(),
                                 [&](const ir::Task& one) { return one.at == task.at && one.at.line != 0; });
  std::vector<std::string> parts;
  const std::string_view single = core::trimmed(task.single);
  if (!single.empty()) parts.push_back("SINGLE := " + std::string(single));
  const std::int64_t period = made == module.tasks.end() ? 0 : made->period_ns;
  if (period != 0) {
    ir::Constant interval;
    interval.type = ir::ref_of(core::TypeId::kTime);
    interval.bits = static_cast<std::uint64_t>(period);
    parts.push_back("INTERVAL := " + literal_text(module.types, interval).value_or("T#20ms"));
  }
  parts.push_back(fmt::format("PRIORITY := {}", made == module.tasks.end() ? 0 : made->priority));
  return fmt::format("TASK {} ({});", task.name, fmt::join(parts, ", "));
}

std::string instance_text(const plcopen::PouInstance& instance, std::string_view task) {
  std::string text = std::string("PROGRAM ") + (instance.retain ? "RETAIN " : "") + instance.name;
  if (!task.empty()) text += " WITH " + std::string(task);
  const std::string_view type = core::trimmed(instance.type_name);
  text += " : " + (type.empty() ? instance.name : std::string(type));
  std::vector<std::string> connections;
  for (const plcopen::InstanceConnection& one : instance.connections) {
    connections.push_back(one.variable + (one.output ? " => " : " := ") + one.other);
  }
  if (!connections.empty()) text += fmt::format(" ({})", fmt::join(connections, ", "));
  return text + ";";
}

}  // namespace

std::string write_type(const TypeSpec& type, const Comments& comments) {
  switch (type.kind) {
    case TypeSpec::Kind::kNamed:
      return std::string(core::trimmed(type.name));
    case TypeSpec::Kind::kString:
      return type.length.empty() ? type.name : type.name + "[" + type.length + "]";
    case TypeSpec::Kind::kArray: {
      std::string text = "ARRAY [";
      for (std::size_t i = 0; i < type.dimensions.size(); ++i)
        text += (i == 0 ? "" : ", ") + bounds(type.dimensions[i]);
      return text + "] OF " + (type.base ? write_type(*type.base, comments) : std::string());
    }
    case TypeSpec::Kind::kStruct: {
      return "STRUCT\n" + write_members(type, comments) + "  END_STRUCT";
    }
    case TypeSpec::Kind::kEnum: {
      std::string text =
          type.base && type.base->kind != TypeSpec::Kind::kMissing ? write_type(*type.base, comments) + " (" : "(";
      const bool lines = std::any_of(type.values.begin(), type.values.end(),
                                     [&](const plcopen::EnumValue& value) { return comments.has(value.at); });
      for (std::size_t i = 0; i < type.values.size(); ++i) {
        const plcopen::EnumValue& value = type.values[i];
        if (lines) text += "\n" + comments.before(value.at, 4) + "    ";
        text += (i == 0 || lines ? "" : ", ") + value.name;
        if (!core::trimmed(value.value).empty()) text += " := " + std::string(core::trimmed(value.value));
        if (lines) text += (i + 1 == type.values.size() ? "" : ",") + comments.after(value.at);
      }
      if (lines) text += "\n  ";
      return text + ")";
    }
    case TypeSpec::Kind::kSubrange:
      return (type.base ? write_type(*type.base, comments) : std::string("INT")) + " (" +
             (type.dimensions.empty() ? std::string() : bounds(type.dimensions[0])) + ")";
    case TypeSpec::Kind::kUnion: {
      return "UNION\n" + write_members(type, comments) + "  END_UNION";
    }
    case TypeSpec::Kind::kPointer:
      return "POINTER TO " + (type.base ? write_type(*type.base, comments) : std::string());
    case TypeSpec::Kind::kReference:
      return "REF_TO " + (type.base ? write_type(*type.base, comments) : std::string());
    case TypeSpec::Kind::kReferenceTo:
      return "REFERENCE TO " + (type.base ? write_type(*type.base, comments) : std::string());
    case TypeSpec::Kind::kMissing:
      break;
  }
  return {};
}

std::string write_types(const std::vector<plcopen::DataType>& types, const Comments& comments) {
  std::string text;
  for (const plcopen::DataType& type : types) {
    text += comments.before(type.at, 0);
    if (type.qualified) text += "{attribute 'qualified_only'}\n";
    const bool extends = type.type.kind == TypeSpec::Kind::kStruct && type.type.base != nullptr;
    text += "TYPE\n  " + type.name + (extends ? " EXTENDS " + type.type.base->name : std::string()) + " : " +
            write_type(type.type, comments);
    const std::string value = write_value(type.initial);
    if (!value.empty()) text += " := " + value;
    text += ";" + comments.after(type.at) + "\nEND_TYPE\n\n";
  }
  return text;
}

std::string write_variables(const std::vector<Variable>& variables, const Comments& comments, std::size_t indent) {
  const std::string margin(indent, ' ');
  std::string text;
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const Variable& variable = variables[i];
    if (i == 0 || !together(variables[i - 1], variable)) {
      const std::string& list = variable.list.empty() ? variable.prefix : variable.list;
      if (variable.section == Section::kGlobal && !list.empty()) {
        if (!variable.list.empty()) text += margin + "{attribute 'qualified_only'}\n";
        text += margin + "{attribute 'global_list' := '" + list + "'}\n";
      }
      text += margin + std::string(word_of(variable.section));
      if (variable.section != Section::kAccess && variable.constant) text += " CONSTANT";
      if (variable.retain) text += " RETAIN";
      if (variable.nonretain) text += " NON_RETAIN";
      if (variable.persistent) text += " PERSISTENT";
      text += "\n";
    }
    text += comments.before(variable.at, indent + 2);
    text += margin + "  " + write_variable(variable, comments) + "\n";
    if (i + 1 == variables.size() || !together(variable, variables[i + 1])) text += margin + "END_VAR\n";
  }
  return text;
}

std::string write_added(const std::vector<AddedVariable>& added, bool in_function) {
  std::string text;
  for (const bool temporary : {false, true}) {
    std::string lines;
    for (const AddedVariable& one : added) {
      if ((one.temporary && !in_function) != temporary) continue;
      lines += "  " + one.name + " : " + one.type + (one.initial.empty() ? "" : " := " + one.initial) + ";\n";
    }
    if (!lines.empty()) text += (temporary ? "VAR_TEMP\n" : "VAR\n") + lines + "END_VAR\n";
  }
  return text;
}

std::string write_head(const plcopen::Pou& pou, const Comments& comments) {
  std::string text = comments.before(pou.at, 0);
  if (!core::trimmed(pou.documentation).empty()) text += comment(pou.documentation) + "\n";
  switch (pou.kind) {
    case plcopen::PouKind::kProgram:
      text += "PROGRAM ";
      break;
    case plcopen::PouKind::kFunctionBlock:
      text += "FUNCTION_BLOCK ";
      break;
    case plcopen::PouKind::kFunction:
      text += "FUNCTION ";
      break;
  }
  text += pou.name;
  if (pou.kind == plcopen::PouKind::kFunction && pou.return_type.kind != TypeSpec::Kind::kMissing) {
    text += " : " + write_type(pou.return_type, comments);
  }
  return text + comments.after(pou.at) + "\n";
}

std::string write_configuration(const plcopen::Configuration& configuration, const ir::Module& module,
                                const Comments& comments) {
  const bool named = !core::trimmed(configuration.name).empty();
  const std::size_t indent = named ? 2 : 0;
  const std::string margin(indent, ' ');
  std::string text;
  // One without a name is no declaration.
  if (named) {
    text += comments.before(configuration.at, 0) + "CONFIGURATION " + configuration.name +
            comments.after(configuration.at) + "\n";
  }
  text += write_variables(configuration.globals, comments, indent);
  for (const plcopen::Resource& resource : configuration.resources) {
    // Nothing refers to the name: where it is none in ST, another one does.
    const bool usable = st::is_identifier(resource.name) && st::keyword_of(resource.name) == st::Keyword::kNone;
    const auto line = [&](const core::SourceRef& at, const std::string& written) {
      text += comments.before(at, indent + 2) + margin + "  " + written + comments.after(at) + "\n";
    };
    // A configuration without RESOURCE is one itself.
    const bool own = !(resource.at == configuration.at);
    if (own) text += comments.before(resource.at, indent);
    text += margin + "RESOURCE " + (usable ? resource.name : "Resource") + " ON PLC" +
            (own ? comments.after(resource.at) : std::string()) + "\n";
    text += write_variables(resource.globals, comments, indent + 2);
    for (const plcopen::Task& task : resource.tasks) line(task.at, task_text(task, module));
    for (const plcopen::Task& task : resource.tasks) {
      for (const plcopen::PouInstance& one : task.instances) line(one.at, instance_text(one, task.name));
    }
    for (const plcopen::PouInstance& one : resource.instances) line(one.at, instance_text(one, {}));
    text += margin + "END_RESOURCE\n";
  }
  text += write_variables(configuration.access, comments, indent);
  text += write_variables(configuration.configs, comments, indent);
  if (named) text += "END_CONFIGURATION\n";
  return text.empty() ? text : text + "\n";
}

}  // namespace plc::convert
