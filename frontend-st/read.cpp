#include "frontend-st/read.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/text.h"
#include "core/utf8.h"
#include "frontend-st/declaration_reader.h"
#include "plcopen/encoding.h"

namespace plc::st {

using core::Code;

namespace {

/// The text as UTF-8; `converted` owns it where the file is none.
std::string_view to_text(std::string_view bytes, std::string& converted) {
  using Kind = plcopen::Encoding::Kind;
  Kind kind = Kind::kUtf8;
  if (bytes.starts_with("\xEF\xBB\xBF")) {
    bytes.remove_prefix(3);
  } else if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    kind = bytes[0] == '\xFF' ? Kind::kUtf16Le : Kind::kUtf16Be;
    bytes.remove_prefix(2);
  }
  if (kind == Kind::kUtf8 && core::is_utf8(bytes)) return bytes;
  if (kind == Kind::kUtf8) kind = Kind::kWindows1252;
  converted.resize(plcopen::utf8_size(bytes, kind));
  plcopen::to_utf8(bytes, kind, converted.data());
  return converted;
}

std::string_view file_stem(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  return path.substr(0, path.rfind('.'));
}

void name_globals(plcopen::Project& project, std::string_view name, bool required, bool of_file) {
  for (plcopen::Configuration& configuration : project.configurations) {
    if (!configuration.name.empty()) continue;
    for (plcopen::Variable& variable : configuration.globals) {
      if (!variable.list.empty() || !variable.prefix.empty()) continue;  // it names its list itself
      (required ? variable.list : variable.prefix) = name;
      variable.file_prefix = of_file && !required;
    }
  }
}

/// CODESYS and TwinCAT name a list of globals like its file.
void name_file(plcopen::Project& project, std::string_view path) {
  const bool required = project.qualified_globals;
  if (!required && !project.pous.empty()) return;  // a program with its globals is no list
  name_globals(project, file_stem(path), required, true);
}

std::unique_ptr<plcopen::Project> read_bytes(std::string_view bytes, const std::string& name, std::uint16_t file,
                                             core::Diagnostics& diagnostics, const std::vector<std::string>& defines) {
  core::SourceRef at;
  at.file = file;
  const auto refuse = [&](Code code, std::string message, std::string help) {
    diagnostics.report(code, at, {}, std::move(message), std::move(help));
    return nullptr;
  };
  const auto too_long = [&] {
    return refuse(Code::P1006, "file is longer than " + std::to_string(kMaxFileBytes >> 20) + " MiB",
                  "split it; libraries are given with --lib");
  };
  if (bytes.size() > kMaxFileBytes) return too_long();
  std::string converted;
  const std::string_view text = to_text(bytes, converted);
  if (text.size() > kMaxTextBytes) return too_long();
  if (text.find('\0') != std::string_view::npos) {
    return refuse(Code::P4047, "file contains zero bytes: it is no text",
                  "give a file of Structured Text, or PLCopen XML");
  }
  auto project = std::make_unique<plcopen::Project>();
  project->path = name;
  project->name = file_stem(name);
  project->file = file;
  project->version = plcopen::Version::kText;
  at.line = 1;
  at.column = 1;
  const SourceText whole(text, at, diagnostics);
  const DeclaredText chosen(whole, Defines(defines), diagnostics);
  const SourceText source(chosen.text(), at, diagnostics);
  DeclarationReader(source, *project, diagnostics, &chosen).read_file();
  name_file(*project, name);
  return project;
}

}  // namespace

std::unique_ptr<plcopen::Project> read(const std::string& path, core::Diagnostics& diagnostics,
                                       const std::vector<std::string>& defines) {
  const std::uint16_t file = diagnostics.add_file(path);
  core::SourceRef at;
  at.file = file;
  std::ifstream in(path, std::ios::binary);
  struct stat status {};
  if (!in || ::stat(path.c_str(), &status) != 0) {
    diagnostics.report(Code::P1001, at, {}, std::string("file cannot be read: ") + std::strerror(errno));
    return nullptr;
  }
  try {
    std::string bytes;
    bytes.reserve(std::min(static_cast<std::size_t>(status.st_size), kMaxFileBytes) + 1);
    // One byte more than allowed is enough to refuse a file that grows while it is read.
    std::string block(std::size_t{1} << 16, '\0');
    while (bytes.size() <= kMaxFileBytes && in) {
      in.read(block.data(), static_cast<std::streamsize>(block.size()));
      bytes.append(block, 0, static_cast<std::size_t>(in.gcount()));
    }
    return read_bytes(bytes, path, file, diagnostics, defines);
  } catch (const std::bad_alloc&) {
    diagnostics.report(Code::P1001, at, {}, "not enough memory to read the file");
    return nullptr;
  }
}

std::unique_ptr<plcopen::Project> read_memory(std::string_view bytes, const std::string& name,
                                              core::Diagnostics& diagnostics, const std::vector<std::string>& defines) {
  return read_bytes(bytes, name, diagnostics.add_file(name), diagnostics, defines);
}

namespace {

/// Calls `visit` for each global that is declared outside of POUs.
template <class Visit>
void each_global(plcopen::Project& project, const Visit& visit) {
  for (plcopen::Configuration& configuration : project.configurations) {
    for (plcopen::Variable& variable : configuration.globals) visit(variable);
    for (plcopen::Resource& resource : configuration.resources) {
      for (plcopen::Variable& variable : resource.globals) visit(variable);
    }
  }
}

/// A list of an XML file without the attribute qualified_only need not be named: its variables are called by their own
/// names, from outside too, where no other global goes by that name alone.
void free_lists(plcopen::Project& project) {
  std::unordered_set<std::string, core::NameHash, core::NameEqual> qualified(project.qualified_lists.begin(),
                                                                             project.qualified_lists.end());
  for (const plcopen::PlainDeclaration& declaration : project.declarations) {
    if (declaration.of_list && declaration.text.find("'qualified_only'") != std::string::npos) {
      qualified.insert(declaration.owner);
    }
  }
  each_global(project, [&](plcopen::Variable& variable) {
    if (!variable.list.empty() && !qualified.contains(variable.list))
      variable.prefix = std::exchange(variable.list, {});
  });
  list_shared_names(project);
}

}  // namespace

void read_plain_declarations(plcopen::Project& project, core::Diagnostics& diagnostics,
                             const std::vector<std::string>& defines) {
  std::unordered_set<std::string, core::NameHash, core::NameEqual> lists;
  const auto add_lists = [&](const std::vector<plcopen::Variable>& globals) {
    for (const plcopen::Variable& variable : globals) {
      if (!variable.list.empty()) lists.insert(variable.list);
    }
  };
  for (const plcopen::Configuration& configuration : project.configurations) {
    add_lists(configuration.globals);
    for (const plcopen::Resource& resource : configuration.resources) add_lists(resource.globals);
  }
  std::unordered_map<std::string_view, plcopen::Pou*, core::NameHash, core::NameEqual> pous;
  for (plcopen::Pou& pou : project.pous) pous.try_emplace(pou.name, &pou);
  for (const plcopen::PlainDeclaration& declaration : project.declarations) {
    if (declaration.text.size() > kMaxTextBytes) continue;
    const SourceText whole(declaration.text, declaration.at, diagnostics);
    const DeclaredText chosen(whole, Defines(defines), diagnostics);
    const SourceText source(chosen.text(), declaration.at, diagnostics);
    DeclarationReader reader(source, project, diagnostics, &chosen);
    if (declaration.of_list) {
      if (!lists.insert(declaration.owner).second) {
        reader.read_pragmas();
        continue;
      }
      plcopen::Configuration outside;
      reader.read_globals(outside.globals, declaration.owner);
      project.configurations.push_back(std::move(outside));
      continue;
    }
    const auto pou = pous.find(declaration.owner);
    if (pou != pous.end() && chosen.has_defines()) {
      // What the declaration defines, the bodies ask for.
      const auto defined = std::make_shared<const std::vector<std::string>>(
          chosen.defines_at(static_cast<std::uint32_t>(chosen.text().size())));
      for (plcopen::Body& body : pou->second->bodies) body.defines = defined;
      for (plcopen::Pou& action : pou->second->actions) {
        for (plcopen::Body& body : action.bodies) body.defines = defined;
      }
    }
    if (pou != pous.end() && pou->second->variables.empty()) {
      reader.read_interface(*pou->second);
    } else {
      reader.read_pragmas();
    }
  }
  free_lists(project);
}

void read_text(std::string_view text, const core::SourceRef& at, plcopen::Project& project,
               core::Diagnostics& diagnostics, const std::vector<std::string>& defines) {
  if (text.size() > kMaxTextBytes) {
    diagnostics.report(Code::P1006, at, {}, "text is longer than " + std::to_string(kMaxTextBytes >> 20) + " MiB");
    return;
  }
  const SourceText whole(text, at, diagnostics);
  const DeclaredText chosen(whole, Defines(defines), diagnostics);
  const SourceText source(chosen.text(), at, diagnostics);
  DeclarationReader(source, project, diagnostics, &chosen).read_file();
}

bool read_head(std::string_view text, const core::SourceRef& at, plcopen::Project& project, plcopen::Pou& pou,
               std::vector<std::string>& objects, core::Diagnostics& diagnostics,
               const std::vector<std::string>& defines) {
  const SourceText whole(text, at, diagnostics);
  const DeclaredText chosen(whole, Defines(defines), diagnostics);
  const SourceText source(chosen.text(), at, diagnostics);
  return DeclarationReader(source, project, diagnostics, &chosen).read_head(pou, objects);
}

void list_shared_names(plcopen::Project& project) {
  struct Count {
    std::size_t all = 0;
    std::size_t bare = 0;  // in no list and no file of globals
  };
  std::unordered_map<std::string_view, Count, core::NameHash, core::NameEqual> counts;
  each_global(project, [&](const plcopen::Variable& variable) {
    if (!variable.list.empty()) return;
    Count& count = counts[variable.name];
    ++count.all;
    count.bare += variable.prefix.empty() ? 1 : 0;
  });
  each_global(project, [&](plcopen::Variable& variable) {
    if (variable.prefix.empty()) return;
    const Count& count = counts[variable.name];
    // For the standard a file is no list: the same name in two texts is declared twice.
    if (count.all == 1 || (variable.file_prefix && count.bare != 0)) return;
    variable.list = std::exchange(variable.prefix, {});
    variable.file_prefix = false;
  });
}

void name_list(plcopen::Project& project, std::string_view name) {
  name_globals(project, name, project.qualified_globals, false);
}

bool looks_like_text(std::string_view bytes) {
  std::string converted;
  const std::string_view text = core::trimmed(to_text(bytes, converted));
  return !text.empty() && text.front() != '<';
}

}  // namespace plc::st
