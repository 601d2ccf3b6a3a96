// The layers, by reading #include lines: a folder may include only what is in its row. Changing a row is an
// architectural decision (docs/internals/layers.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = PLC_SOURCE_DIR;

/// Folders a file of the folder may include from, itself understood. Those with two parts are folders of their own:
/// the runtime links one half of bytecode/ only, and a kind of driver is nobody's business but that of
/// io-drivers/machine.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"core", {}},
    {"log", {"core"}},
    {"hmi", {"core"}},
    {"storage", {"core"}},
    {"stdlib", {"core"}},
    {"plcopen", {"core"}},
    {"ir", {"core", "stdlib"}},
    {"bytecode", {"core", "stdlib"}},
    {"bytecode/codegen", {"core", "stdlib", "ir", "bytecode"}},
    {"frontend-st", {"core", "stdlib", "ir", "plcopen"}},
    {"frontend-il", {"core", "stdlib", "ir", "plcopen", "frontend-st"}},
    {"convert", {"core", "stdlib", "plcopen", "ir", "frontend-st", "frontend-sfc"}},
    {"drawings", {"core", "plcopen", "bytecode", "frontend-st", "frontend-il", "frontend-fbd", "frontend-sfc"}},
    {"pictures", {"core", "bytecode"}},
    {"sources", {"core", "plcopen", "frontend-st"}},
    {"declare", {"core", "stdlib", "ir", "plcopen", "frontend-st"}},
    {"frontend-fbd", {"core", "stdlib", "ir", "plcopen", "frontend-st"}},
    {"frontend-ld", {"core", "stdlib", "ir", "plcopen", "frontend-st", "frontend-fbd"}},
    {"frontend-sfc", {"core", "stdlib", "ir", "plcopen", "frontend-st", "frontend-il", "frontend-ld"}},
    {"taskblocks", {"core"}},
    {"runtime", {"core", "stdlib", "bytecode", "taskblocks"}},
    {"retain", {"core", "stdlib", "bytecode", "runtime"}},
    {"shadow", {"core", "stdlib", "bytecode", "runtime"}},
    {"alarms", {"core", "stdlib", "bytecode", "runtime", "shadow", "storage"}},
    {"historian", {"core", "bytecode", "runtime", "alarms", "storage"}},
    {"native", {"core", "stdlib", "bytecode", "runtime"}},
    {"engineering",
     {"core", "stdlib", "bytecode", "pictures", "runtime", "shadow", "log", "hmi", "taskblocks", "alarms",
      "historian"}},
    {"web", {"engineering"}},
    {"io-drivers", {"core", "stdlib", "bytecode", "runtime"}},
    {"io-drivers/modbus-rtu", {"core"}},
    {"io-drivers/config",
     {"core", "stdlib", "bytecode", "runtime", "alarms", "historian", "io-drivers", "io-drivers/modbus-rtu"}},
    {"io-drivers/gpio", {"core", "stdlib", "bytecode", "runtime", "io-drivers", "io-drivers/config"}},
    {"io-drivers/simulated", {"core", "stdlib", "bytecode", "runtime", "io-drivers", "io-drivers/config"}},
    {"io-drivers/modbus",
     {"core", "stdlib", "bytecode", "runtime", "io-drivers", "io-drivers/config", "io-drivers/modbus-rtu"}},
    {"io-drivers/modbus-client",
     {"core", "stdlib", "bytecode", "runtime", "io-drivers", "io-drivers/config", "io-drivers/modbus-rtu"}},
    {"io-drivers/external", {"core", "bytecode", "runtime", "io-drivers", "io-drivers/config", "taskblocks"}},
    {"io-drivers/guardian", {"core", "runtime", "io-drivers"}},
    {"io-drivers/machine",
     {"core", "stdlib", "bytecode", "runtime", "io-drivers", "io-drivers/config", "io-drivers/gpio",
      "io-drivers/external", "io-drivers/simulated", "io-drivers/modbus", "io-drivers/modbus-client",
      "io-drivers/guardian"}},
    {"doctor",
     {"core", "stdlib", "bytecode", "runtime", "retain", "engineering", "io-drivers", "io-drivers/config",
      "io-drivers/modbus"}},
    {"compiler",
     {"core", "stdlib", "plcopen", "ir", "bytecode", "bytecode/codegen", "frontend-st", "frontend-il", "sources",
      "declare", "drawings", "frontend-fbd", "frontend-ld", "frontend-sfc", "taskblocks"}},
    {"testing",
     {"core", "stdlib", "plcopen", "ir", "bytecode", "frontend-st", "frontend-ld", "compiler", "runtime", "io-drivers",
      "retain", "taskblocks"}},
    {"tools",  // io-drivers/simulated: plc-run --stimulus
     {"alarms",
      "convert",
      "core",
      "stdlib",
      "plcopen",
      "ir",
      "bytecode",
      "frontend-st",
      "frontend-fbd",
      "frontend-ld",
      "frontend-sfc",
      "drawings",
      "pictures",
      "compiler",
      "doctor",
      "engineering",
      "hmi",
      "historian",
      "runtime",
      "native",
      "retain",
      "shadow",
      "io-drivers",
      "io-drivers/config",
      "io-drivers/machine",
      "io-drivers/modbus",
      "io-drivers/modbus-client",
      "io-drivers/modbus-rtu",
      "io-drivers/simulated",
      "log",
      "taskblocks",
      "testing",
      "web"}},
    {"bench",  // tests: the builder of hand-made images
     {"core", "stdlib", "bytecode", "runtime", "native", "retain", "shadow", "historian", "io-drivers",
      "io-drivers/config", "io-drivers/machine", "io-drivers/modbus", "taskblocks", "compiler", "tools", "tests"}},
};

/// Foreign headers that belong to one place: prefix of the include, folders that may use it, and whether in headers
/// too.
struct Foreign {
  std::string prefix;
  std::set<std::string> folders;
  bool in_headers;
};
const std::vector<Foreign> kForeign = {
    {"libxml/", {"plcopen"}, false},
    {"fmt/", {}, false},  // any folder
    {"CLI/", {"tools"}, false},
    {"nlohmann/json.hpp", {"bench", "engineering", "tools"}, false},
    {"nlohmann/json_fwd.hpp", {"engineering", "tools"}, true},
    {"openssl/", {"engineering"}, false},
    {"sodium", {"engineering"}, false},
    {"xxhash", {"bytecode", "retain", "runtime", "shadow"}, false},
    {"zstd", {"bytecode", "historian", "shadow"}, false},
    {"sqlite3", {"storage"}, false},
    {"toml++/", {"io-drivers/config", "hmi"}, false},
    {"boost/", {"engineering", "io-drivers/modbus"}, true},
    {"Eigen/", {"taskblocks"}, true},
    {"gpiod", {"io-drivers/gpio"}, false},
    {"asmjit/", {"native"}, true},
};

struct Include {
  fs::path file;  ///< relative to the root
  int line = 0;
  std::string target;
  bool ours = false;  ///< in quotes
};

/// Where an include of ours is, from the root: the kit of taskblocks is included as its users include it.
std::string path_of(const std::string& target) {
  return target.rfind("picard/", 0) == 0 ? "taskblocks/include/" + target : target;
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find('/');
  const std::string two_parts = path.substr(0, path.find('/', slash + 1));
  return kAllowed.count(two_parts) == 1 ? two_parts : path.substr(0, slash);
}

bool is_header(const fs::path& file) { return file.extension() == ".h" || file.extension() == ".def"; }

std::vector<Include> includes_of(const fs::path& folder) {
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp" && extension != ".def") continue;
    std::ifstream in(entry.path());
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      if (line.rfind("#include ", 0) != 0 || line.size() < 11) continue;
      const bool ours = line[9] == '"';
      const std::size_t end = line.find(ours ? '"' : '>', 10);
      includes.push_back({fs::relative(entry.path(), kRoot), number, line.substr(10, end - 10), ours});
    }
  }
  return includes;
}

TEST(Layering, IncludesFollowTheFlow) {
  std::size_t seen = 0;
  for (const auto& [folder, allowed] : kAllowed) {
    if (folder.find('/') != std::string::npos) continue;
    ASSERT_TRUE(fs::is_directory(kRoot / folder)) << folder << " has a row here but does not exist";
    for (const Include& include : includes_of(folder)) {
      if (!include.ours) continue;
      ++seen;
      const std::string from = folder_of(include.file.generic_string());
      const std::string to = folder_of(path_of(include.target));
      EXPECT_TRUE(to == from || kAllowed.at(from).count(to) == 1)
          << include.file.string() << ':' << include.line << ": " << from << " includes \"" << include.target
          << "\", but it may only include itself and what its row in this test lists";
      const bool generated = include.target == "tools/version.h";
      EXPECT_TRUE(generated || fs::exists(kRoot / path_of(include.target)))
          << include.file.string() << ':' << include.line << ": \"" << include.target
          << "\" is not a path from the root";
    }
  }
  EXPECT_GT(seen, 100u) << "no include lines found: is the source folder right?";
}

TEST(Layering, ForeignLibrariesStayInTheirFolders) {
  for (const auto& [folder, allowed] : kAllowed) {
    if (folder.find('/') != std::string::npos) continue;
    for (const Include& include : includes_of(folder)) {
      if (include.ours) continue;
      for (const Foreign& foreign : kForeign) {
        if (include.target.rfind(foreign.prefix, 0) != 0) continue;
        EXPECT_TRUE(foreign.folders.empty() || foreign.folders.count(folder_of(include.file.generic_string())) == 1)
            << include.file.string() << ':' << include.line << ": <" << include.target << "> in " << folder;
        EXPECT_TRUE(foreign.in_headers || !is_header(include.file))
            << include.file.string() << ':' << include.line << ": <" << include.target << "> in a header";
      }
    }
  }
}

TEST(Layering, EveryFolderWithSourcesHasARow) {
  // Tests may include anything; examples stand alone, as projects of users do.
  const std::set<std::string> without_row = {"tests", "examples"};
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory() || name.front() == '.' || name.rfind("build", 0) == 0 || without_row.count(name))
      continue;
    bool has_sources = false;
    for (const auto& file : fs::recursive_directory_iterator(entry.path())) {
      has_sources = has_sources || file.path().extension() == ".cpp" || file.path().extension() == ".h";
    }
    EXPECT_TRUE(!has_sources || kAllowed.count(name) == 1) << name << " has sources but no row in this test";
  }
}

TEST(Layering, EveryFolderHasARowInItsDocument) {
  std::ifstream in(kRoot / "docs/internals/layers.md");
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  for (const auto& [folder, allowed] : kAllowed) {
    if (folder.find('/') != std::string::npos) continue;
    EXPECT_NE(page.find("\n| `" + folder + "/` |"), std::string::npos)
        << "docs/internals/layers.md has no row of " << folder;
  }
}

TEST(Layering, FilesHaveAtMost600Lines) {
  std::set<std::string> folders = {"tests", "examples"};
  for (const auto& [folder, allowed] : kAllowed) {
    if (folder.find('/') == std::string::npos) folders.insert(folder);
  }
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (!is_header(entry.path()) && entry.path().extension() != ".cpp") continue;
      std::ifstream in(entry.path());
      const auto lines = std::count(std::istreambuf_iterator<char>(in), {}, '\n');
      EXPECT_LE(lines, 600) << fs::relative(entry.path(), kRoot)
                            << ": move a part that has one job to a file of its own";
    }
  }
}

TEST(Layering, HeadersSayWhatTheyAre) {
  for (const auto& [folder, allowed] : kAllowed) {
    if (folder.find('/') != std::string::npos) continue;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream in(entry.path());
      std::string first;
      std::getline(in, first);
      EXPECT_EQ(first.substr(0, 3), "// ")
          << fs::relative(entry.path(), kRoot) << " opens without a comment that says what it is";
    }
  }
}

}  // namespace
