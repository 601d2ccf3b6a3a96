#include "sources/object_project.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include "core/text.h"
#include "frontend-st/lexer.h"
#include "frontend-st/read.h"

namespace plc::sources {
namespace {

using core::Code;
using core::SourceRef;
using plcopen::Language;

/// Names for a message: the first few, and how many more.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kShown) text += fmt::format(" and {} more", names.size() - kShown);
  return text;
}

class Converter {
 public:
  Converter(const ObjectFile& file, const std::vector<std::string>& namespaces, core::Diagnostics& diagnostics,
            const std::vector<std::string>& defines)
      : file_(file), namespaces_(namespaces), diagnostics_(diagnostics), defines_(defines) {
    out_.path = file.path;
    out_.file = file.file;
    out_.version = plcopen::Version::kText;
  }

  plcopen::Project run() {
    for (const Object& object : file_.objects) {
      switch (object.kind) {
        case Object::Kind::kPou:
          pou(object);
          break;
        case Object::Kind::kGlobals:
        case Object::Kind::kType:
          declarations(object);
          break;
        case Object::Kind::kInterface:
          interface(object);
          break;
        case Object::Kind::kTask:
          task(object);
          break;
      }
    }
    return std::move(out_);
  }

 private:
  void report(Code code, const SourceRef& at, const std::string& pou, std::string message, std::string help = {}) {
    diagnostics_.report(code, at, pou, std::move(message), std::move(help));
  }

  void declarations(const Object& object) {
    plcopen::Project part;
    st::read_text(without_namespaces(object.declaration.text, namespaces_), object.declaration.at, part, diagnostics_,
                  defines_);
    st::name_list(part, object.name);
    merge(out_, std::move(part));
  }

  void interface(const Object& object) {
    report(Code::P1203, object.declaration.at, object.name,
           fmt::format("interface \"{}\" belongs to object orientation and is not read", object.name),
           "what names it as a type cannot be compiled");
  }

  void pou(const Object& object) {
    plcopen::Pou pou;
    std::vector<std::string> objects;
    const std::string declaration = without_namespaces(object.declaration.text, namespaces_);
    if (!st::read_head(declaration, object.declaration.at, out_, pou, objects, diagnostics_, defines_)) return;
    members(object, pou, objects);
    if (!object.special.empty()) {
      report(Code::P1206, pou.at, pou.name,
             fmt::format("\"{}\" is called by TwinCAT itself, as {}: here only by what calls it by name", pou.name,
                         object.special),
             "bad indices, divisions by zero and values outside of ranges have a defined result here "
             "(docs/guides/events.md)");
    }
    body(object.implementation, pou.at, pou);
    if (!objects.empty()) {
      pou.unread = "is object-oriented, which is not supported: " + listed(objects);
      pou.object_oriented = true;
      for (plcopen::Pou& action : pou.actions) {
        action.unread = pou.unread;
        action.object_oriented = true;
      }
    }
    // A file has one object: all problems in it are the object's own.
    out_.extents.push_back({{pou.name},
                            {.line = 1, .column = 1, .file = file_.file},
                            {.line = UINT32_MAX, .column = UINT32_MAX, .file = file_.file}});
    out_.pous.push_back(std::move(pou));
  }

  void members(const Object& object, plcopen::Pou& pou, std::vector<std::string>& objects) {
    std::vector<std::string> transitions;
    for (const Member& member : object.members) {
      switch (member.kind) {
        case Member::Kind::kAction: {
          plcopen::Pou action;
          action.name = member.name;
          action.kind = pou.kind;
          action.at = member.at;
          body(member.implementation, member.at, action);
          pou.actions.push_back(std::move(action));
          break;
        }
        case Member::Kind::kMethod:
          objects.push_back("METHOD " + member.name);
          pou.unread_members.push_back(member.name);
          break;
        case Member::Kind::kProperty:
          objects.push_back("PROPERTY " + member.name);
          pou.unread_members.push_back(member.name);
          break;
        case Member::Kind::kTransition:
          transitions.push_back(member.name);
          break;
      }
    }
    if (transitions.empty()) return;
    pou.unread = "has transitions of a chart, in the format of TwinCAT, which are not read: " + listed(transitions);
  }

  /// The body of a POU or action. What is no ST is named when the POU is compiled.
  void body(const Implementation& from, const SourceRef& at, plcopen::Pou& pou) {
    if (from.format.empty()) return;
    plcopen::Body& body = pou.bodies.emplace_back();
    body.at = from.text.at.line != 0 ? from.text.at : at;
    body.text_at = body.at;
    if (from.format != "ST") {
      pou.unread = fmt::format("is drawn or written as {}, in a format of TwinCAT that is not read", from.format);
      return;
    }
    body.text = without_namespaces(from.text.text, namespaces_);
    body.language = st::Lexer(body.text).next().kind == st::TokenKind::kEnd ? Language::kNone : Language::kSt;
  }

  void task(const Object& object) {
    plcopen::Task task;
    task.name = object.name;
    task.at = object.at;
    task.at.kind = core::ElementKind::kTask;
    std::uint64_t microseconds = 0;
    const std::string& cycle = object.cycle_time.text;
    const auto [end, error] = std::from_chars(cycle.data(), cycle.data() + cycle.size(), microseconds);
    if (error != std::errc() || end != cycle.data() + cycle.size() || microseconds == 0) {
      report(Code::P1208, object.cycle_time.at.line != 0 ? object.cycle_time.at : object.at, {},
             fmt::format("CycleTime of task \"{}\" is no number of microseconds: \"{}\"", object.name,
                         cycle.substr(0, 40)),
             "give the task a cycle time in TwinCAT");
      return;
    }
    task.interval =
        microseconds % 1000 == 0 ? fmt::format("T#{}ms", microseconds / 1000) : fmt::format("T#{}us", microseconds);
    task.priority = object.priority.text;
    for (const Text& call : object.calls) {
      plcopen::PouInstance& instance = task.instances.emplace_back();
      const std::string_view name = call.text;
      instance.name = name.substr(name.rfind('.') + 1);
      instance.at = call.at;
      instance.at.kind = core::ElementKind::kInstance;
    }
    if (out_.configurations.empty() || out_.configurations.back().resources.empty()) {
      plcopen::Configuration& configuration = out_.configurations.emplace_back();
      configuration.at = object.at;
      configuration.resources.emplace_back().at = object.at;
    }
    out_.configurations.back().resources.back().tasks.push_back(std::move(task));
  }

  const ObjectFile& file_;
  const std::vector<std::string>& namespaces_;
  core::Diagnostics& diagnostics_;
  const std::vector<std::string>& defines_;
  plcopen::Project out_;
};

struct Attribute {
  std::string_view name;
  std::string_view effect;
};
constexpr Attribute kAttributes[] = {
#define PLC_TOOL_ATTRIBUTE(name, effect) {name, effect},
#include "sources/attributes.def"
};

/// "call_after_init" of "{attribute 'call_after_init'}"; empty of other pragmas.
std::string_view attribute_name(std::string_view pragma) {
  if (!pragma.starts_with('{')) return {};
  pragma = core::trimmed(pragma.substr(1));
  if (pragma.size() < 9 || !core::iequals(pragma.substr(0, 9), "attribute")) return {};
  const std::size_t begin = pragma.find('\'');
  if (begin == std::string_view::npos) return {};
  const std::size_t end = pragma.find('\'', begin + 1);
  return end == std::string_view::npos ? std::string_view() : core::trimmed(pragma.substr(begin + 1, end - begin - 1));
}

template <class T>
void append(std::vector<T>& to, std::vector<T>&& from) {
  std::move(from.begin(), from.end(), std::back_inserter(to));
}

}  // namespace

plcopen::Project to_project(ObjectFile file, const std::vector<std::string>& namespaces, core::Diagnostics& diagnostics,
                            const std::vector<std::string>& defines) {
  plcopen::Project out = Converter(file, namespaces, diagnostics, defines).run();
  out.report = std::move(file.report);
  return out;
}

void merge(plcopen::Project& whole, plcopen::Project&& part) {
  append(whole.data_types, std::move(part.data_types));
  append(whole.pous, std::move(part.pous));
  append(whole.declarations, std::move(part.declarations));
  append(whole.qualified_lists, std::move(part.qualified_lists));
  append(whole.pragmas, std::move(part.pragmas));
  append(whole.attributes, std::move(part.attributes));
  append(whole.comments, std::move(part.comments));
  append(whole.tests, std::move(part.tests));
  append(whole.extents, std::move(part.extents));
  // Tasks of one machine, each in a file of its own, are tasks of one resource.
  for (plcopen::Configuration& configuration : part.configurations) {
    const bool tasks = configuration.name.empty() && configuration.globals.empty() && configuration.access.empty() &&
                       configuration.configs.empty() && configuration.resources.size() == 1 &&
                       configuration.resources[0].name.empty() && configuration.resources[0].globals.empty();
    plcopen::Resource* known = nullptr;
    for (plcopen::Configuration& one : whole.configurations) {
      if (tasks && one.name.empty() && one.resources.size() == 1 && one.resources[0].name.empty()) {
        known = one.resources.data();
      }
    }
    if (known == nullptr) {
      whole.configurations.push_back(std::move(configuration));
      continue;
    }
    append(known->tasks, std::move(configuration.resources[0].tasks));
    append(known->instances, std::move(configuration.resources[0].instances));
  }
  for (plcopen::ReportRow& row : part.report) {
    const auto known = std::find_if(whole.report.begin(), whole.report.end(), [&](const plcopen::ReportRow& one) {
      return one.element == row.element && one.fate == row.fate;
    });
    if (known == whole.report.end()) {
      whole.report.push_back(std::move(row));
    } else {
      known->count += row.count;
    }
  }
}

std::string without_namespaces(std::string text, const std::vector<std::string>& namespaces) {
  if (namespaces.empty() || text.size() > st::kMaxFileBytes) return text;
  const std::string original = text;  // the lexer's tokens are of a text that stays
  st::Lexer lexer(original);
  st::Token before, token = lexer.next();
  while (token.kind != st::TokenKind::kEnd) {
    const st::Token next = lexer.next();
    const std::string_view name = std::string_view(original).substr(token.begin, token.end - token.begin);
    const bool qualifies = token.kind == st::TokenKind::kIdentifier && next.kind == st::TokenKind::kDot &&
                           before.kind != st::TokenKind::kDot &&
                           std::any_of(namespaces.begin(), namespaces.end(),
                                       [&](const std::string& one) { return core::iequals(one, name); });
    before = token;
    token = next;
    if (!qualifies) continue;
    // Characters of several bytes count once in places.
    if (std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; })) continue;
    std::fill(text.begin() + before.begin, text.begin() + before.end, ' ');
    text[token.begin] = ' ';
  }
  return text;
}

void report_attributes(const plcopen::Project& project, core::Diagnostics& diagnostics) {
  for (const plcopen::Pragma& pragma : project.pragmas) {
    const std::string_view name = attribute_name(pragma.text);
    const auto* const known = std::find_if(std::begin(kAttributes), std::end(kAttributes),
                                           [&](const Attribute& one) { return core::iequals(one.name, name); });
    if (known == std::end(kAttributes)) continue;
    diagnostics.report(Code::P1206, pragma.at, {},
                       fmt::format("attribute '{}' {}, and has no effect here", known->name, known->effect),
                       "write in the program what it does, or leave it out");
  }
}

}  // namespace plc::sources
