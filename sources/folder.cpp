#include "sources/folder.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/text.h"
#include "frontend-st/read.h"
#include "sources/export_file.h"
#include "sources/object_file.h"
#include "sources/object_project.h"
#include "sources/plcproj.h"

namespace plc::sources {
namespace {

namespace fs = std::filesystem;
using core::Code;

/// Namespaces of libraries that projects name without listing them: folders have no list.
constexpr const char* kNamespaces[] = {"Standard",   "Standard64",    "Util",      "Tc2_Standard",
                                       "Tc2_System", "Tc2_Utilities", "Tc3_Module"};

bool has_extension(std::string_view path, std::string_view extension) {
  return path.size() > extension.size() && core::iequals(path.substr(path.size() - extension.size()), extension);
}

bool is_text_path(std::string_view path) { return has_extension(path, ".st") || has_extension(path, ".iecst"); }

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

/// True when `inner`, links followed, is in the folder `outer`, links followed.
bool lies_in(const fs::path& inner, const fs::path& outer) {
  std::error_code error;
  const fs::path real = fs::canonical(inner, error);
  const fs::path base = error ? fs::path() : fs::canonical(outer, error);
  if (error) return false;
  return std::mismatch(base.begin(), base.end(), real.begin(), real.end()).first == base.end();
}

/// The files that end on disk in `step` but for letter case: Windows, where projects come from, does not tell them
/// apart.
std::optional<fs::path> child(const fs::path& folder, const std::string& step) {
  std::error_code error;
  if (fs::exists(folder / step, error)) return folder / step;
  std::optional<fs::path> found;
  for (fs::directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end;
       !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (core::iequals(name, step) && (!found || name < found->filename().string())) found = it->path();
  }
  return found;
}

class FolderReader {
 public:
  FolderReader(core::Diagnostics& diagnostics, const std::vector<std::string>& defines)
      : diagnostics_(diagnostics), defines_(defines) {}

  std::unique_ptr<plcopen::Project> read(const std::string& path) {
    std::error_code error;
    if (has_extension(path, ".plcproj")) return project_file(path);
    if (!fs::is_directory(path, error)) {
      namespaces_.assign(std::begin(kNamespaces), std::end(kNamespaces));
      start(path, fs::path(path).stem().string());
      file(path);
      return finish();
    }
    return folder(path);
  }

 private:
  void report(Code code, const core::SourceRef& at, std::string message, std::string help = {}) {
    diagnostics_.report(code, at, {}, std::move(message), std::move(help));
  }

  void start(const std::string& path, std::string name) {
    project_ = std::make_unique<plcopen::Project>();
    project_->path = path;
    project_->name = std::move(name);
    project_->version = plcopen::Version::kText;
    project_->file = static_cast<std::uint16_t>(diagnostics_.file_count());
  }

  std::unique_ptr<plcopen::Project> finish() {
    if (read_ == 0) return nullptr;
    st::list_shared_names(*project_);
    report_attributes(*project_, diagnostics_);
    return std::move(project_);
  }

  /// All files below the folder that may be source files, in the order of their paths; false when there are too many.
  bool collect(const fs::path& base, std::vector<std::string>& projects, std::vector<std::string>& files) {
    std::error_code error;
    std::size_t seen = 0;
    fs::recursive_directory_iterator it(base, fs::directory_options::skip_permission_denied, error);
    for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
      constexpr std::size_t kMaxSeen = 1'000'000;
      if (++seen > kMaxSeen || files.size() > kMaxFiles) return false;
      if (is_hidden(it->path())) {
        if (it->is_directory(error)) it.disable_recursion_pending();
        continue;
      }
      std::error_code ignored;
      const std::string path = it->path().string();
      const bool wanted =
          has_extension(path, ".plcproj") || is_object_path(path) || is_text_path(path) || has_extension(path, ".exp");
      if (!wanted || !it->is_regular_file(ignored) || (it->is_symlink(ignored) && !lies_in(path, base))) continue;
      (has_extension(path, ".plcproj") ? projects : files).push_back(path);
    }
    std::sort(projects.begin(), projects.end());
    std::sort(files.begin(), files.end());
    return files.size() <= kMaxFiles;
  }

  std::unique_ptr<plcopen::Project> folder(const std::string& path) {
    std::vector<std::string> projects, files;
    const bool all = collect(path, projects, files);
    core::SourceRef at;
    if (!all || projects.size() != 1) at.file = diagnostics_.add_file(path);
    if (!all) {
      report(Code::P1006, at, fmt::format("folder has more than {} source files", kMaxFiles),
             "give the folder of one project");
      return nullptr;
    }
    if (projects.size() == 1) return project_file(projects[0]);
    if (projects.size() > 1) {
      std::string names;
      for (std::size_t i = 0; i < std::min<std::size_t>(projects.size(), 5); ++i)
        names += (i == 0 ? "" : ", ") + projects[i];
      report(Code::P1209, at, fmt::format("folder has {} projects of TwinCAT", projects.size()),
             "give one of them: " + names);
      return nullptr;
    }
    if (files.empty()) {
      report(Code::P1209, at, "folder has no source files",
             "a project is a .plcproj, or files .TcPOU, .TcGVL, .TcDUT, .TcTTO, .st or .EXP; PLCopen XML is given by "
             "its file");
      return nullptr;
    }
    namespaces_.assign(std::begin(kNamespaces), std::end(kNamespaces));
    // "plant/" and "." are folders with a name, too.
    std::error_code error;
    const fs::path real = fs::canonical(path, error);
    start(path, (error ? fs::path(path) : real).filename().string());
    project_->file = at.file;
    for (const std::string& one : files) file(one);
    return finish();
  }

  std::unique_ptr<plcopen::Project> project_file(const std::string& path) {
    const std::optional<PlcProject> listed = read_plcproj(path, diagnostics_);
    if (!listed) return nullptr;
    namespaces_ = listed->namespaces;
    start(path, listed->name.empty() ? fs::path(path).stem().string() : listed->name);
    project_->file = listed->file;
    project_->product = "TwinCAT 3";
    const fs::path base = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
    std::size_t count = 0;
    for (const PlcProject::Entry& entry : listed->entries) {
      if (entry.excluded) {
        this->count("Compile", plcopen::Fate::kIgnored, entry.at.line, "excluded from the build");
        continue;
      }
      if (!is_object_path(entry.path) && !is_text_path(entry.path)) {
        this->count("Compile", plcopen::Fate::kIgnored, entry.at.line, "no source file of a program");
        continue;
      }
      if (++count > kMaxFiles) {
        report(Code::P1006, entry.at, fmt::format("project lists more than {} source files", kMaxFiles));
        return nullptr;
      }
      if (const auto found = locate(base, entry)) file(found->string());
    }
    // A project without files is read, too: what is missing is said where it is compiled.
    ++read_;
    return finish();
  }

  void count(std::string element, plcopen::Fate fate, std::uint32_t line, std::string reason) {
    plcopen::Project part;
    part.report.push_back({std::move(element), fate, 1, line, std::move(reason)});
    merge(*project_, std::move(part));
  }

  /// Where the file of an entry is. Nothing when it is not there or outside of the folder, which is reported.
  std::optional<fs::path> locate(const fs::path& base, const PlcProject::Entry& entry) {
    std::string path = entry.path;
    std::replace(path.begin(), path.end(), '\\', '/');
    const auto refuse = [&] {
      report(Code::P1205, entry.at,
             fmt::format("file \"{}\" is outside of the project's folder", entry.path.substr(0, 200)),
             "move it into the folder, or name it as a library (--lib)");
      return std::nullopt;
    };
    const bool drive = path.size() > 1 && path[1] == ':';
    if (path.find('\0') != std::string::npos || path.starts_with('/') || drive) return refuse();
    fs::path here = base;
    for (const fs::path& step : fs::path(path).lexically_normal()) {
      if (step == "..") return refuse();
      if (step == "." || step.empty()) continue;
      const auto next = child(here, step.string());
      if (!next) {
        report(Code::P1204, entry.at, fmt::format("file \"{}\" is not there", entry.path.substr(0, 200)),
               "copy the whole folder of the project, or take the file out of it");
        return std::nullopt;
      }
      here = *next;
    }
    std::error_code ignored;
    if (!fs::is_regular_file(here, ignored)) {
      report(Code::P1204, entry.at, fmt::format("\"{}\" is no file", entry.path.substr(0, 200)),
             "take it out of the project");
      return std::nullopt;
    }
    if (!lies_in(here, base)) return refuse();
    return here;
  }

  void file(const std::string& path) {
    if (is_object_path(path)) {
      if (auto objects = read_object_file(path, diagnostics_)) {
        merge(*project_, to_project(std::move(*objects), namespaces_, diagnostics_, defines_));
        if (project_->product.empty()) project_->product = "TwinCAT 3";
        ++read_;
      }
      return;
    }
    auto part = has_extension(path, ".exp") ? read_export_file(path, diagnostics_, defines_)
                                            : st::read(path, diagnostics_, defines_);
    if (part == nullptr) return;
    if (project_->product.empty()) project_->product = part->product;
    merge(*project_, std::move(*part));
    ++read_;
  }

  core::Diagnostics& diagnostics_;
  const std::vector<std::string>& defines_;
  std::unique_ptr<plcopen::Project> project_;
  std::vector<std::string> namespaces_;
  std::size_t read_ = 0;  ///< files that were read
};

}  // namespace

bool is_source_path(const std::string& path) {
  std::error_code ignored;
  return has_extension(path, ".plcproj") || is_object_path(path) || has_extension(path, ".exp") ||
         fs::is_directory(path, ignored);
}

std::unique_ptr<plcopen::Project> read(const std::string& path, core::Diagnostics& diagnostics,
                                       const std::vector<std::string>& defines) {
  return FolderReader(diagnostics, defines).read(path);
}

}  // namespace plc::sources
