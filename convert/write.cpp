#include "convert/write.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

#include "convert/body_writer.h"
#include "convert/chart_writer.h"
#include "convert/comments.h"
#include "convert/declaration_writer.h"
#include "convert/literals.h"
#include "core/text.h"
#include "frontend-st/conditions.h"
#include "frontend-st/worksheets.h"

namespace plc::convert {
namespace {

using core::Code;
using plcopen::Language;

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

bool has_charts(const plcopen::Pou& pou) {
  const auto is_chart = [](const plcopen::Body& body) { return body.language == Language::kSfc; };
  return std::any_of(pou.bodies.begin(), pou.bodies.end(), is_chart) ||
         std::any_of(pou.actions.begin(), pou.actions.end(), has_charts);
}

class Writer {
 public:
  Writer(const plcopen::Project& project, const ir::Module& module, core::Diagnostics& diagnostics)
      : project_(project), module_(module), diagnostics_(diagnostics), comments_(project) {}

  std::optional<WrittenProject> run() {
    out_.text = write_types(project_.data_types, comments_);
    for (const plcopen::Pou& pou : project_.pous) {
      if (pou.taskblock == 0) write_pou(pou);
    }
    for (const plcopen::Pou& test : project_.tests) write_test(test);
    for (const plcopen::Configuration& configuration : project_.configurations) {
      out_.text += write_configuration(configuration, module_, comments_);
    }
    out_.text += comments_.rest();
    while (out_.text.ends_with("\n\n")) out_.text.pop_back();
    if (failed_) return std::nullopt;
    return std::move(out_);
  }

 private:
  void write_pou(const plcopen::Pou& pou) {
    const auto known = module_.pou_by_name.find(pou.name);
    // A POU that the library has, without a body: it declares what is there.
    const ir::Pou empty;
    const ir::Pou& declared = known == module_.pou_by_name.end() ? empty : module_.pous[known->second];
    const ir::Pou& made = declared.generic ? made_of(declared, known->second) : declared;
    AddedVariables added(module_, made);
    Written written{added, {}};
    const std::string body = body_text(pou, &made, made, written, pou, pou.name);
    std::string actions;
    for (const plcopen::Pou& action : pou.actions) {
      const auto index = made.actions.find(action.name);
      const ir::Pou* const lowered = index == made.actions.end() ? nullptr : &module_.pous[index->second];
      actions += comments_.before(action.at, 0) + "ACTION " + action.name + ":" + comments_.after(action.at) + "\n" +
                 body_text(action, lowered, made, written, pou, pou.name + "." + action.name) + "END_ACTION\n\n";
    }
    if (project_.has_3s_charts && has_charts(pou)) out_.text += "{attribute 'sfc_final_scan'}\n";
    out_.text += write_head(pou, comments_);
    out_.text += write_variables(pou.variables, comments_);
    out_.text += write_added(added.all(), pou.kind == plcopen::PouKind::kFunction);
    out_.text += body;
    out_.text += std::string(end_of(pou.kind)) + "\n\n" + actions + written.actions;
    const auto values =
        std::count_if(added.all().begin(), added.all().end(), [](const AddedVariable& one) { return one.temporary; });
    const auto kept = static_cast<std::ptrdiff_t>(added.all().size()) - values;
    if (values != 0) remark(pou.name, values, "for values that are used more than once, or later");
    if (kept != 0) remark(pou.name, kept, "for memory that the drawing has without a name");
    for (const plcopen::Variable& variable : pou.variables) {
      const std::string text = name_text(variable.name);
      if (text != variable.name) {
        out_.remarks.push_back({pou.name, fmt::format("has {} as {}, which is no keyword", variable.name, text)});
      }
    }
  }

  /// A function that a call of the generic one made; that itself where nothing calls it.
  const ir::Pou& made_of(const ir::Pou& generic, std::uint32_t index) const {
    const auto made = std::find_if(module_.pous.begin(), module_.pous.end(),
                                   [index](const ir::Pou& pou) { return pou.made_from == index; });
    return made == module_.pous.end() ? generic : *made;
  }

  void write_test(const plcopen::Pou& test) {
    out_.text += comments_.before(test.at, 0) + "TEST '" + test.name + "'" + comments_.after(test.at) + "\n";
    out_.text += write_variables(test.variables, comments_);
    out_.text += verbatim(test);
    out_.text += "END_TEST\n\n";
  }

  void remark(const std::string& pou, std::ptrdiff_t count, std::string_view what) {
    out_.remarks.push_back({pou, fmt::format("has {} variable{} {}", count, count == 1 ? "" : "s", what)});
  }

  /// What bodies of a POU need beside their own text.
  struct Written {
    AddedVariables& added;
    std::string actions;
  };

  /// The statements of a body of `owner`. A further language has its case here: what it returns stands between the
  /// variables and the END_ of the POU or action.
  std::string body_text(const plcopen::Pou& pou, const ir::Pou* lowered, const ir::Pou& made, Written& written,
                        const plcopen::Pou& owner, const std::string& name) {
    if (!pou.unread.empty()) return refuse(pou, name, pou.unread);
    if (st::is_mixed(pou)) return refuse(pou, name, "has bodies in several languages");
    if (asks_attributes(pou)) return refuse_attributes(pou, name);
    switch (st::language_of(pou)) {
      case Language::kNone:
      case Language::kSt:
      case Language::kIl:
        return verbatim(pou);
      case Language::kSfc:
        return charts(pou, made, written, owner, name);
      case Language::kLd:
      case Language::kFbd:
        break;
    }
    if (lowered == nullptr || lowered->stub) return refuse(pou, name, "is not compiled");
    if (lowered->generic) return refuse(pou, name, "has parameters ARRAY [*], and nothing calls it");
    const WrittenBody body = write_body(module_, *lowered, made, written.added);
    if (!body.problem.empty()) return refuse_drawing(body.at, name, body.problem);
    if (lowered->made_from != ir::Pou::kDeclared && depends_on_bounds(*lowered, body.text)) {
      return refuse(pou, name, "has parameters ARRAY [*], and its drawing is compiled otherwise for other bounds");
    }
    if (body.loop) out_.remarks.push_back({name, "has jumps, which became a loop around a CASE"});
    return body.text;
  }

  /// Whether the drawing gave other statements for other bounds, or may give them: it asks for them.
  bool depends_on_bounds(const ir::Pou& made, const std::string& text) const {
    return std::any_of(module_.pous.begin(), module_.pous.end(), [&](const ir::Pou& other) {
      if (other.made_from != made.made_from) return false;
      AddedVariables added(module_, other);
      return other.asks_bounds || write_body(module_, other, other, added).text != text;
    });
  }

  /// Charts that are drawn become charts in words; those that come from text stay as they are.
  std::string charts(const plcopen::Pou& pou, const ir::Pou& made, Written& written, const plcopen::Pou& owner,
                     const std::string& name) {
    std::string text;
    for (const plcopen::Body& body : pou.bodies) {
      if (!core::trimmed(body.text).empty() || body.language != Language::kSfc) {
        text += text_of(body);
        continue;
      }
      WrittenChart chart = write_chart(body, owner, name, module_, made, written.added);
      if (!chart.problem.empty()) return refuse_drawing(chart.at, name, chart.problem);
      for (std::string& remark : chart.remarks) out_.remarks.push_back({name, std::move(remark)});
      text += chart.text;
      written.actions += chart.actions;
    }
    return text;
  }

  /// Attributes are not written: what asks for them would do something else.
  [[nodiscard]] bool asks_attributes(const plcopen::Pou& pou) const {
    return !project_.attributes.empty() &&
           std::any_of(pou.bodies.begin(), pou.bodies.end(), [](const plcopen::Body& body) {
             return core::folded(body.text).find("hasattribute") != std::string::npos;
           });
  }

  std::string refuse_attributes(const plcopen::Pou& pou, const std::string& name) {
    diagnostics_.report(Code::P1211, pou.at, name, "\"" + name + "\" asks for attributes, which are not written",
                        "let a define decide: {IF defined (NAME)}");
    failed_ = true;
    return {};
  }

  /// Pragmas for what is defined where a body begins, and is not given by the options, if the body may ask.
  [[nodiscard]] std::string defines_of(const plcopen::Body& body) const {
    const bool asks = body.language != Language::kSfc && body.text.find('{') != std::string::npos;
    if (body.defines == nullptr || !asks) return {};
    const st::Defines given(module_.options.defines);
    const st::Defines here(*body.defines);
    std::string text;
    for (const std::string& entry : here.entries()) {
      const std::size_t assign = std::min(entry.find('='), entry.size());
      const std::string name = entry.substr(0, assign);
      const std::string* const known = given.find(name);
      if (known != nullptr && *known == *here.find(name)) continue;
      text += "  {define " + name + (assign == entry.size() ? "" : " '" + entry.substr(assign + 1) + "'") + "}\n";
    }
    for (const std::string& entry : given.entries()) {
      const std::string name = entry.substr(0, entry.find('='));
      if (here.find(name) == nullptr) text += "  {undefine " + name + "}\n";
    }
    return text;
  }

  /// A body as it was written, with the comments before it.
  std::string text_of(const plcopen::Body& body) const {
    std::string text = comments_.before(body.at, 2) + defines_of(body);
    // The text begins with its first token.
    constexpr std::uint32_t kDeepest = 9;
    if (!body.text.empty() && body.at.column <= kDeepest) text.append(std::max(body.at.column, 1u) - 1, ' ');
    text += body.text;
    if (!text.empty() && !text.ends_with('\n')) text += '\n';
    return text;
  }

  std::string verbatim(const plcopen::Pou& pou) const {
    std::string text;
    for (const plcopen::Body& body : pou.bodies) text += text_of(body);
    return text;
  }

  std::string refuse_drawing(const core::SourceRef& at, const std::string& name, const std::string& why) {
    diagnostics_.report(Code::P1211, at, name, "drawing of \"" + name + "\" " + why,
                        "draw it otherwise, or write it in ST");
    failed_ = true;
    return {};
  }

  std::string refuse(const plcopen::Pou& pou, const std::string& name, const std::string& why) {
    diagnostics_.report(Code::P1211, pou.at, name, "\"" + name + "\" " + why, "write it in ST");
    failed_ = true;
    return {};
  }

  const plcopen::Project& project_;
  const ir::Module& module_;
  core::Diagnostics& diagnostics_;
  Comments comments_;
  WrittenProject out_;
  bool failed_ = false;
};

}  // namespace

std::optional<WrittenProject> write(const plcopen::Project& project, const ir::Module& module,
                                    core::Diagnostics& diagnostics) {
  return Writer(project, module, diagnostics).run();
}

}  // namespace plc::convert
