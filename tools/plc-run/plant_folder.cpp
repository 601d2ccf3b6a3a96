#include "tools/plc-run/plant_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "compiler/image_file.h"

namespace plc::tools {
namespace {

namespace fs = std::filesystem;

bool is_project(const fs::path& file) {
  const std::string name = file.filename().string();
  if (name.starts_with('.') || file.stem().string().ends_with("_test")) return false;
  constexpr std::string_view kExtensions[] = {".pbc", ".xml", ".st", ".iecst", ".plcproj", ".exp"};
  return std::any_of(std::begin(kExtensions), std::end(kExtensions),
                     [&](std::string_view extension) { return compiler::has_extension(name, extension); });
}

}  // namespace

PlantFolder look_into_plant(const std::string& folder) {
  PlantFolder plant;
  std::vector<std::string> projects;
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    std::error_code ignored;
    if (is_project(file->path()) && file->is_regular_file(ignored))
      projects.push_back(file->path().filename().string());
  }
  std::sort(projects.begin(), projects.end());
  const fs::path configuration = fs::path(folder) / "plc.toml";
  std::error_code none;
  if (fs::exists(configuration, none)) plant.configuration = configuration.string();
  if (error) {
    plant.wrong = fmt::format("--plant \"{}\" cannot be read: {}", folder, error.message());
    plant.help = "make the folder, with the project and its plc.toml in it, readable for the user that runs plc-run";
  } else if (projects.empty()) {
    plant.wrong = fmt::format("--plant \"{}\" holds no project", folder);
    plant.help = "put one in: PLCopen XML, a .st file, or an image made by plc compile";
  } else if (projects.size() > 1) {
    plant.wrong =
        fmt::format("--plant \"{}\" holds {} projects: {}", folder, projects.size(), fmt::join(projects, ", "));
    plant.help = "leave the one that is to run; libraries become part of an image: plc compile --lib";
  } else {
    plant.project = (fs::path(folder) / projects[0]).string();
  }
  return plant;
}

}  // namespace plc::tools
