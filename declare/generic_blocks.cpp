#include "declare/generic_blocks.h"

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/text.h"
#include "frontend-st/lexer.h"

namespace plc::st {
namespace {

using core::Code;
using plcopen::Pou;
using plcopen::Section;
using plcopen::TypeSpec;
using plcopen::Variable;
using Names = std::unordered_map<std::string, std::string, core::NameHash, core::NameEqual>;

/// "10" and "(2*n)" of "FB<10,(2*n)>".
std::vector<std::string> values_of(std::string_view name) {
  std::vector<std::string> out;
  std::size_t open = 0;
  std::size_t begin = name.find('<') + 1;
  for (std::size_t i = begin; i < name.size(); ++i) {
    if (name[i] == '(' || name[i] == '[') ++open;
    if ((name[i] == ')' || name[i] == ']') && open != 0) --open;
    if (open != 0 || (name[i] != ',' && i + 1 != name.size())) continue;
    out.emplace_back(core::trimmed(name.substr(begin, i - begin)));
    begin = i + 1;
  }
  return out;
}

/// `text` with the values of the constants that it names.
std::string with_values(std::string_view text, const Names& values) {
  std::string out;
  Lexer lexer(text);
  std::size_t last = 0;
  for (Token token = lexer.next(); token.kind != TokenKind::kEnd; token = lexer.next()) {
    const auto known = token.kind == TokenKind::kIdentifier
                           ? values.find(std::string(text.substr(token.begin, token.end - token.begin)))
                           : values.end();
    if (known == values.end()) continue;
    out.append(text, last, token.begin - last);
    out += known->second;
    last = token.end;
  }
  return out.append(text, last);
}

void each_named(TypeSpec& type, const std::function<void(TypeSpec&)>& visit) {
  if (type.kind == TypeSpec::Kind::kNamed) visit(type);
  if (type.base) each_named(*type.base, visit);
  for (Variable& member : type.members) each_named(member.type, visit);
}

class Maker {
 public:
  Maker(plcopen::Project& project, core::Diagnostics& diagnostics) : project_(project), diagnostics_(diagnostics) {}

  void run() {
    const auto use = [this](TypeSpec& type) { use_type(type); };
    const auto use_all = [&](std::vector<Variable>& variables) {
      for (Variable& variable : variables) each_named(variable.type, use);
    };
    for (plcopen::DataType& type : project_.data_types) each_named(type.type, use);
    for (plcopen::Configuration& configuration : project_.configurations) {
      use_all(configuration.globals);
      for (plcopen::Resource& resource : configuration.resources) use_all(resource.globals);
    }
    const std::size_t declared = project_.pous.size();
    for (std::size_t i = 0; i < declared; ++i) {
      // Blocks are not made of what a generic block holds before its own values are known.
      if (!is_generic(project_.pous[i])) use_all(project_.pous[i].variables);
    }
    for (std::size_t i = 0; i < declared; ++i) {
      if (is_generic(project_.pous[i])) templates_.emplace(i, project_.pous[i]);
    }
    for (std::size_t i = 0; i < wanted_.size(); ++i) make(wanted_[i]);
    for (const std::size_t generic : made_from_) project_.pous[generic].from_library = true;
    // By its plain name a block has the values of its declaration, and so have the blocks that it holds.
    for (const auto& [generic, as_read] : templates_) use_with(project_.pous[generic], declared_values(as_read));
    for (std::size_t i = made_; i < wanted_.size(); ++i) make(wanted_[i]);
  }

 private:
  struct Wanted {
    std::string name;
    core::SourceRef at;
  };

  static bool is_generic(const Pou& pou) {
    for (const Variable& variable : pou.variables) {
      if (variable.section == Section::kGeneric) return true;
    }
    return false;
  }

  void use_type(TypeSpec& type) {
    if (type.name.find('<') == std::string::npos || !known_.emplace(type.name, "").second) return;
    wanted_.push_back({type.name, type.at});
  }

  static Names declared_values(const Pou& pou) {
    Names values;
    for (const Variable& variable : pou.variables) {
      if (variable.section == Section::kGeneric) values.emplace(variable.name, '(' + variable.initial.text + ')');
    }
    return values;
  }

  /// The types that `pou` names become those with the values of its constants.
  void use_with(Pou& pou, const Names& values) {
    for (Variable& variable : pou.variables) {
      each_named(variable.type, [&](TypeSpec& type) {
        if (type.name.find('<') == std::string::npos) return;
        type.name = with_values(type.name, values);
        use_type(type);
      });
    }
  }

  void make(const Wanted wanted) {
    ++made_;
    const std::string_view base = std::string_view(wanted.name).substr(0, wanted.name.find('<'));
    std::size_t found = project_.pous.size();
    for (std::size_t i = 0; i < project_.pous.size(); ++i) {
      if (core::iequals(project_.pous[i].name, base)) found = i;
    }
    if (found == project_.pous.size()) return;  // an unknown type, which is reported as such
    const auto refuse = [&](std::string message, std::string help) {
      diagnostics_.report(Code::P4530, wanted.at, {}, std::move(message), std::move(help));
    };
    const std::vector<std::string> values = values_of(wanted.name);
    std::size_t constants = 0;
    for (const Variable& variable : project_.pous[found].variables) {
      constants += variable.section == Section::kGeneric ? 1 : 0;
    }
    if (values.size() > constants) {
      return refuse('"' + std::string(base) + "\" has " + std::to_string(constants) + " generic constants, and " +
                        std::to_string(values.size()) + " values are given",
                    "generic constants are declared in VAR_GENERIC CONSTANT of a function block");
    }
    if (made_ > kMaxGenericBlocks) {
      if (made_ == kMaxGenericBlocks + 1) {
        refuse("more than " + std::to_string(kMaxGenericBlocks) + " blocks are made from generic ones",
               "a generic block that holds one of itself with other values has no end");
      }
      return;
    }
    const auto as_read = templates_.find(found);
    Pou made = as_read == templates_.end() ? project_.pous[found] : as_read->second;
    made.name = wanted.name;
    Names names;
    std::size_t next = 0;
    for (Variable& variable : made.variables) {
      if (variable.section != Section::kGeneric || next == values.size()) continue;
      const std::string& value = values[next++];
      variable.initial = {};
      variable.initial.kind = plcopen::InitialValue::Kind::kSimple;
      variable.initial.text = value;
      variable.initial.at = wanted.at;
      names.emplace(variable.name, '(' + value + ')');
    }
    use_with(made, names);
    project_.pous.push_back(std::move(made));
    made_from_.push_back(found);
  }

  plcopen::Project& project_;
  core::Diagnostics& diagnostics_;
  Names known_;
  std::vector<Wanted> wanted_;
  std::map<std::size_t, Pou> templates_;  ///< generic blocks as they were read
  std::vector<std::size_t> made_from_;
  std::size_t made_ = 0;
};

}  // namespace

void make_generic_blocks(plcopen::Project& project, core::Diagnostics& diagnostics) {
  Maker(project, diagnostics).run();
}

}  // namespace plc::st
