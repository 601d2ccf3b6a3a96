#include "declare/library_declarations.h"

#include <algorithm>

#include "core/text.h"
#include "frontend-st/lexer.h"
#include "stdlib/library.h"
#include "stdlib/specials.h"

namespace plc::st {
namespace {

using plcopen::Section;
using stdlib::Direction;

/// Comments are no statements, and semicolons, which make an editor take the body, are empty ones.
bool is_empty(const plcopen::Body& body) {
  if (body.drawn_elements != 0) return false;
  Lexer lexer(body.text);
  TokenKind kind = lexer.next().kind;
  while (kind == TokenKind::kSemicolon) kind = lexer.next().kind;
  return kind == TokenKind::kEnd;
}

bool is_direction(Section section, Direction direction) {
  switch (section) {
    case Section::kInput:
      return direction == Direction::kInput;
    case Section::kOutput:
      return direction == Direction::kOutput;
    case Section::kInOut:
      return direction == Direction::kInOut;
    default:
      return false;
  }
}

bool declares(const plcopen::Pou& pou, const stdlib::BlockSpec& block) {
  const auto pins = std::count_if(block.fields.begin(), block.fields.end(),
                                  [](const stdlib::Field& field) { return field.direction != Direction::kState; });
  if (pou.variables.size() != static_cast<std::size_t>(pins)) return false;
  return std::all_of(pou.variables.begin(), pou.variables.end(), [&block](const plcopen::Variable& variable) {
    const stdlib::Field* field = stdlib::field_named(block, variable.name);
    return field != nullptr && is_direction(variable.section, field->direction) &&
           core::type_named(variable.type.name) == field->type;
  });
}

/// Types are not compared: those of an overloaded function are generic, and each editor has a way to say so.
bool declares(const plcopen::Pou& pou, const stdlib::FunctionSpec& function) {
  if (pou.variables.size() < function.param_count) return false;
  return std::all_of(pou.variables.begin(), pou.variables.end(), [&](const plcopen::Variable& variable) {
    if (variable.section != Section::kInput) return false;
    for (std::size_t i = 0; i < pou.variables.size(); ++i) {
      if ((i < function.param_count || function.extensible) &&
          core::iequals(variable.name, stdlib::pin_name(function, i))) {
        return true;
      }
    }
    return false;
  });
}

bool declares(const plcopen::Pou& pou, const stdlib::BundleSpec& bundle) {
  return pou.variables.size() == bundle.outputs.size() + 1 &&
         std::all_of(pou.variables.begin(), pou.variables.end(), [&bundle](const plcopen::Variable& variable) {
           if (variable.section == Section::kInput) return core::iequals(variable.name, bundle.input.name);
           return variable.section == Section::kOutput &&
                  std::any_of(bundle.outputs.begin(), bundle.outputs.end(), [&](const stdlib::FunctionSpec* output) {
                    return core::iequals(variable.name, stdlib::output_name(*output));
                  });
         });
}

bool declares(const plcopen::Pou& pou, const stdlib::SpecialSpec& special) {
  return special.drawn_only && core::iequals(pou.name, special.name) && pou.variables.size() == 1 &&
         pou.variables[0].section == Section::kInput && core::iequals(pou.variables[0].name, stdlib::kDrawnInput);
}

bool is_library_declaration(const plcopen::Pou& pou) {
  if (!declares_only(pou)) return false;
  if (pou.kind == plcopen::PouKind::kFunctionBlock) {
    const stdlib::BlockSpec* block = stdlib::block_named(pou.name);
    return block != nullptr && declares(pou, *block);
  }
  if (pou.kind == plcopen::PouKind::kFunction) {
    const auto specials = stdlib::specials();
    if (std::any_of(specials.begin(), specials.end(), [&pou](const auto& special) { return declares(pou, special); })) {
      return true;
    }
    if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(pou.name)) return declares(pou, *bundle);
    const auto overloads = stdlib::overloads_named(pou.name);
    return std::any_of(overloads.begin(), overloads.end(),
                       [&pou](const stdlib::Overload& overload) { return declares(pou, *overload.spec); });
  }
  return false;
}

}  // namespace

bool declares_only(const plcopen::Pou& pou) {
  return !pou.has_chart && pou.unread.empty() && pou.actions.empty() &&
         std::all_of(pou.bodies.begin(), pou.bodies.end(), is_empty);
}

std::size_t drop_library_declarations(plcopen::Project& project) {
  return std::erase_if(project.pous, is_library_declaration);
}

void warn_of_hidden_names(const plcopen::Project& project, core::Diagnostics& diagnostics) {
  const auto look_at = [&](std::string_view what, const std::string& name, const core::SourceRef& at, bool is_pou) {
    const stdlib::BlockSpec* const block = stdlib::block_named(name);
    const std::span<const stdlib::Overload> functions = stdlib::overloads_named(name);
    const std::string_view clause = block != nullptr     ? block->clause
                                    : !functions.empty() ? functions.front().spec->clause
                                                         : std::string_view{};
    if (stdlib::is_standard(clause)) return;
    const auto specials = stdlib::specials();
    const bool special = std::any_of(specials.begin(), specials.end(),
                                     [&](const stdlib::SpecialSpec& one) { return core::iequals(one.name, name); });
    // A type takes the name of a block, not of a function.
    if (block == nullptr && (!is_pou || (!special && !stdlib::is_function(name)))) return;
    diagnostics.report(core::Code::P4019, at, is_pou ? name : std::string(),
                       std::string(what) + " \"" + name + "\" hides the " +
                           (block != nullptr ? "function block" : "function") + " of this name in the library",
                       "rename it if the library's is meant: plc lib " + name);
  };
  for (const plcopen::Pou& pou : project.pous) {
    // A program cannot be taken for a block: who means the library's gets an error.
    if (pou.from_library || pou.taskblock != 0 || pou.kind == plcopen::PouKind::kProgram) continue;
    look_at(plcopen::pou_kind_name(pou.kind), pou.name, pou.at, true);
  }
  for (const plcopen::DataType& type : project.data_types) {
    if (!diagnostics.is_library(type.at.file)) look_at("data type", type.name, type.at, false);
  }
}

}  // namespace plc::st
