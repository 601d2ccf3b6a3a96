// The folder of a plant, --plant=DIR: which project it holds, and whether it configures the machine.
//
// In: a folder, as /etc/picard/NAME of the service picard@NAME. Out: paths, or what is wrong with the folder. Does not
// belong here: reading the files; folders that are a project themselves (sources/).
#pragma once

#include <string>
#include <string_view>

namespace plc::tools {

struct PlantFolder {
  std::string project;
  std::string configuration;  ///< DIR/plc.toml; empty where there is none
  std::string wrong, help;    ///< why there is no project, else empty
};

/// The one project among the files of the folder: an image, PLCopen XML, a text, a .plcproj or an export. Tests
/// (NAME_test.st) and hidden files do not count. Several are refused: which one was meant would be a guess.
PlantFolder look_into_plant(const std::string& folder);

}  // namespace plc::tools
