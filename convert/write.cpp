#include "convert/write.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

#include "convert/body_writer.h"
#include "convert/declaration_writer.h"
#include "core/text.h"

namespace plc::convert {
namespace {

using core::Code;
using plcopen::Language;

/// The language of a POU's bodies; the first that is not empty decides.
Language language_of(const plcopen::Pou& pou) {
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language != Language::kNone) return body.language;
  }
  return Language::kNone;
}

std::string_view end_of(plcopen::PouKind kind) {
  switch (kind) {
    case plcopen::PouKind::kProgram:
      return "END_PROGRAM";
    case plcopen::PouKind::kFunctionBlock:
      return "END_FUNCTION_BLOCK";
    case plcopen::PouKind::kFunction:
      return "END_FUNCTION";
  }
  return "END_PROGRAM";
}

class Writer {
 public:
  Writer(const plcopen::Project& project, const ir::Module& module, core::Diagnostics& diagnostics)
      : project_(project), module_(module), diagnostics_(diagnostics) {}

  std::optional<WrittenProject> run() {
    out_.text = write_types(project_.data_types);
    for (const plcopen::Pou& pou : project_.pous) {
      if (pou.taskblock == 0) write_pou(pou);
    }
    for (const plcopen::Configuration& configuration : project_.configurations) {
      out_.text += write_configuration(configuration, module_);
    }
    while (out_.text.ends_with("\n\n")) out_.text.pop_back();
    if (failed_) return std::nullopt;
    return std::move(out_);
  }

 private:
  void write_pou(const plcopen::Pou& pou) {
    const auto known = module_.pou_by_name.find(pou.name);
    // A POU that the library has, without a body: it declares what is there.
    const ir::Pou empty;
    const ir::Pou& made = known == module_.pou_by_name.end() ? empty : module_.pous[known->second];
    AddedVariables added(module_, made);
    const std::string body = body_text(pou, &made, made, added, pou.name);
    std::string actions;
    for (const plcopen::Pou& action : pou.actions) {
      const auto index = made.actions.find(action.name);
      const ir::Pou* const lowered = index == made.actions.end() ? nullptr : &module_.pous[index->second];
      actions += "ACTION " + action.name + ":\n" +
                 body_text(action, lowered, made, added, pou.name + "." + action.name) + "END_ACTION\n\n";
    }
    out_.text += write_head(pou);
    out_.text += write_variables(pou.variables);
    out_.text += write_added(added.all(), pou.kind == plcopen::PouKind::kFunction);
    out_.text += body;
    out_.text += std::string(end_of(pou.kind)) + "\n\n" + actions;
    const auto values =
        std::count_if(added.all().begin(), added.all().end(), [](const AddedVariable& one) { return one.temporary; });
    const auto kept = static_cast<std::ptrdiff_t>(added.all().size()) - values;
    if (values != 0) remark(pou.name, values, "for values that are used more than once, or later");
    if (kept != 0) remark(pou.name, kept, "for memory that the drawing has without a name");
  }

  void remark(const std::string& pou, std::ptrdiff_t count, std::string_view what) {
    out_.remarks.push_back({pou, fmt::format("has {} variable{} {}", count, count == 1 ? "" : "s", what)});
  }

  /// The statements of a body. A further language has its case here: what it returns stands between the variables and
  /// the END_ of the POU or action.
  std::string body_text(const plcopen::Pou& pou, const ir::Pou* lowered, const ir::Pou& owner, AddedVariables& added,
                        const std::string& name) {
    if (!pou.unread.empty()) return refuse(pou, name, pou.unread);
    switch (language_of(pou)) {
      case Language::kNone:
        return {};
      case Language::kSt:
      case Language::kIl:
      case Language::kSfc:
        return verbatim(pou, name);
      case Language::kLd:
      case Language::kFbd:
        break;
    }
    if (lowered == nullptr || lowered->stub) return refuse(pou, name, "is not compiled");
    if (lowered->generic) return refuse(pou, name, "has parameters ARRAY [*]: its drawing is compiled for each call");
    const WrittenBody body = write_body(module_, *lowered, owner, added);
    if (!body.problem.empty()) {
      diagnostics_.report(Code::P1211, body.at, name, "drawing of \"" + name + "\" " + body.problem,
                          "draw it otherwise, or write it in ST");
      failed_ = true;
      return {};
    }
    if (body.loop) out_.remarks.push_back({name, "has jumps, which became a loop around a CASE"});
    return body.text;
  }

  /// Texts as they were written. Charts have a form as text, too, which those that come from text have.
  std::string verbatim(const plcopen::Pou& pou, const std::string& name) {
    std::string text;
    for (const plcopen::Body& body : pou.bodies) {
      if (body.language == Language::kSfc && core::trimmed(body.text).empty()) {
        return refuse(pou, name, "is a drawn chart");
      }
      if (body.text.empty()) continue;
      text += body.text;
      if (!text.ends_with('\n')) text += '\n';
    }
    return text;
  }

  std::string refuse(const plcopen::Pou& pou, const std::string& name, const std::string& why) {
    diagnostics_.report(Code::P1211, pou.at, name, "\"" + name + "\" " + why, "write it in ST");
    failed_ = true;
    return {};
  }

  const plcopen::Project& project_;
  const ir::Module& module_;
  core::Diagnostics& diagnostics_;
  WrittenProject out_;
  bool failed_ = false;
};

}  // namespace

std::optional<WrittenProject> write(const plcopen::Project& project, const ir::Module& module,
                                    core::Diagnostics& diagnostics) {
  return Writer(project, module, diagnostics).run();
}

}  // namespace plc::convert
