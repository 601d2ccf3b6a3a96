#include "compiler/libraries.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/text.h"

namespace plc::compiler {
namespace {

using Names = std::unordered_map<std::string, core::SourceRef, core::NameHash, core::NameEqual>;

std::string qualified(const plcopen::Variable& variable) {
  return variable.list.empty() ? variable.name : variable.list + "." + variable.name;
}

class Merger {
 public:
  Merger(plcopen::Project& project, core::Diagnostics& diagnostics) : project_(project), diagnostics_(diagnostics) {
    // Data types and POUs share one space of names: both are types.
    for (const plcopen::DataType& type : project.data_types) types_.try_emplace(type.name, type.at);
    for (const plcopen::Pou& pou : project.pous) types_.try_emplace(pou.name, pou.at);
    const auto add = [this](const std::vector<plcopen::Variable>& globals) {
      for (const plcopen::Variable& variable : globals) globals_.try_emplace(qualified(variable), variable.at);
    };
    for (const plcopen::Configuration& configuration : project.configurations) {
      add(configuration.globals);
      for (const plcopen::Resource& resource : configuration.resources) add(resource.globals);
    }
    for (const plcopen::Pou& pou : project.pous) {
      for (const plcopen::Variable& variable : pou.variables) {
        if (variable.section == plcopen::Section::kGlobal) globals_.try_emplace(qualified(variable), variable.at);
      }
    }
  }

  void add(plcopen::Project&& library) {
    std::move(library.extents.begin(), library.extents.end(), std::back_inserter(project_.library_extents));
    std::move(library.attributes.begin(), library.attributes.end(), std::back_inserter(project_.attributes));
    for (plcopen::DataType& type : library.data_types) {
      if (is_free(types_, "data type", type.name, type.at)) project_.data_types.push_back(std::move(type));
    }
    for (plcopen::Pou& pou : library.pous) {
      pou.from_library = true;
      if (is_free(types_, "POU", pou.name, pou.at)) project_.pous.push_back(std::move(pou));
    }
    plcopen::Configuration globals;
    const auto add_globals = [&](std::vector<plcopen::Variable>& from) {
      for (plcopen::Variable& variable : from) {
        if (is_free(globals_, "global variable", qualified(variable), variable.at)) {
          globals.globals.push_back(std::move(variable));
        }
      }
    };
    for (plcopen::Configuration& configuration : library.configurations) {
      add_globals(configuration.globals);
      for (plcopen::Resource& resource : configuration.resources) add_globals(resource.globals);
    }
    if (!globals.globals.empty()) project_.configurations.push_back(std::move(globals));
  }

 private:
  bool is_free(Names& names, std::string_view what, const std::string& name, const core::SourceRef& at) {
    const auto [known, fresh] = names.try_emplace(name, at);
    // Twice in one file is an error of that file, found when it is declared.
    if (fresh || known->second.file == at.file) return true;
    diagnostics_.report_at_once(
        core::Code::P5110, known->second, {},
        fmt::format("\"{}\" hides the {} of this name in {}:{}", name, what, diagnostics_.file_name(at.file), at.line),
        "rename it if the library's is meant");
    return false;
  }

  plcopen::Project& project_;
  core::Diagnostics& diagnostics_;
  Names types_;
  Names globals_;
};

}  // namespace

void add_library(plcopen::Project& project, plcopen::Project&& library, core::Diagnostics& diagnostics) {
  Merger(project, diagnostics).add(std::move(library));
}

}  // namespace plc::compiler
