#include "frontend-il/text.h"

#include <string>

#include "frontend-il/flow.h"
#include "frontend-il/lowering.h"
#include "frontend-il/parser.h"
#include "frontend-st/choosing.h"
#include "frontend-st/text.h"

namespace plc::il {

using core::Code;

namespace {

/// What the list leaves in the accumulator, if `gives_value`; false when there was an error.
bool lower(std::string_view text, const core::SourceRef& at, ir::Builder& builder, bool gives_value,
           std::optional<ir::Operand>& result, const std::vector<std::string>* defines) {
  if (text.size() > st::kMaxTextBytes) {
    builder.report(Code::P4002, at, "the text is longer than " + std::to_string(st::kMaxTextBytes) + " bytes");
    return false;
  }
  const st::SourceText whole(text, at, builder.diagnostics());
  const st::ChosenText chosen = st::choose(whole, builder, defines);
  const st::SourceText source(chosen.text(), at, builder.diagnostics());
  Listing listing = Parser(source, builder.diagnostics(), builder.name()).parse();
  const Flow flow = flow_of(listing, source, gives_value, builder.diagnostics(), builder.name());
  Lowering lowering(builder, source, listing, flow, gives_value);
  const bool lowered = lowering.lower_all();
  builder.set_source(at);
  if (!lowered || listing.failed || flow.failed || !chosen.fine()) return false;
  result = lowering.result();
  return true;
}

}  // namespace

bool lower_instructions(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                        const std::vector<std::string>* defines) {
  std::optional<ir::Operand> unused;
  return lower(text, at, builder, false, unused, defines);
}

std::optional<ir::Operand> lower_value(std::string_view text, const core::SourceRef& at, ir::Builder& builder) {
  std::optional<ir::Operand> result;
  if (!lower(text, at, builder, true, result, nullptr)) return std::nullopt;
  return result;
}

bool lower_list(const plcopen::Body& body, ir::Builder& builder) {
  const core::SourceRef at = body.text_at.line != 0 ? body.text_at : body.at;
  // The third edition, which --strict asks for, has instruction lists.
  if (!builder.module().options.strict) {
    builder.report(Code::P4501, at, "the body is an instruction list, which the fourth edition does not have",
                   "it compiles as it is; ST is the text of later editions");
  }
  return lower_instructions(body.text, at, builder, body.defines.get());
}

bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  ir::Builder builder(module, pou_index, diagnostics);
  st::lower_prologue(builder);
  bool good = diagnostics.error_count() == errors_before;
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language == plcopen::Language::kIl) good = lower_list(body, builder) && good;
  }
  module.pous[pou_index].compiled = good;
  return good;
}

}  // namespace plc::il
