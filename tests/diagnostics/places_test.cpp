// A place is a line and a column of the file, whatever the file is written like: the same project with other line ends,
// in another encoding, with a byte order mark, sections for entities and comments inside has the same messages at the
// same characters. And every message about any project at hand has a place inside of its file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/utf8.h"
#include "tests/diagnostics/rewriting.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::command_line;
using plc::test::offset_of;
using plc::test::Position;
using plc::test::position_of;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;
using plc::test::Variant;

const char* const kTool = PLC_TOOL;

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Message {
  std::string code, text, element, help;
  Position at;
  friend bool operator==(const Message&, const Message&) = default;
};

std::ostream& operator<<(std::ostream& out, const Message& m) {
  return out << m.at.line << ':' << m.at.column << ' ' << m.code << ' ' << m.text;
}

/// Blanks and line ends of quoted texts count as one blank, and so do comments: a variant may write others.
std::string plain(std::string text) {
  for (std::size_t at = text.find("(*"); at != std::string::npos; at = text.find("(*")) {
    text.erase(at, std::min(text.find("*)", at), text.size() - 2) + 2 - at);
  }
  std::string out;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\r' || c == '\n' || c == '\t';
    if (!blank) out += c;
    if (blank && !out.empty() && out.back() != ' ') out += ' ';
  }
  return out;
}

/// What plc check says of each of `files`, in the order in which it says it.
std::vector<std::vector<Message>> check(const std::vector<std::string>& files,
                                        const std::vector<std::string>& options) {
  std::vector<std::string> arguments = {kTool, "check", "--json", "--lint=all"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  arguments.insert(arguments.end(), files.begin(), files.end());
  const ToolResult result = run_tool(arguments, 300);
  EXPECT_GE(result.code, 0) << command_line(arguments) << "\n" << result.err;
  std::vector<std::vector<Message>> all(files.size());
  const nlohmann::json document = nlohmann::json::parse(result.out, nullptr, false);
  if (document.is_discarded()) {
    ADD_FAILURE() << command_line(arguments) << "\n" << result.out << result.err;
    return all;
  }
  for (const nlohmann::json& one : document["diagnostics"]) {
    const auto file = std::find(files.begin(), files.end(), one["file"].get<std::string>());
    if (file == files.end()) continue;
    const std::string folder = fs::path(*file).parent_path().string() + "/";
    std::string text = plain(one["message"]);
    for (std::size_t i = text.find(folder); i != std::string::npos; i = text.find(folder)) text.erase(i, folder.size());
    all[static_cast<std::size_t>(file - files.begin())].push_back(
        {one["code"], text, one["element"], plain(one["help"]), {one["line"], one["column"]}});
  }
  return all;
}

/// Options of a fixture of diagnostics.
std::vector<std::string> options_of(const fs::path& folder) {
  std::vector<std::string> options;
  std::ifstream in(folder / "expected.txt");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word != "options") continue;
    while (words >> word) options.push_back(word);
  }
  return options;
}

std::vector<fs::path> projects_below(const fs::path& folder) {
  std::vector<fs::path> found;
  if (!fs::is_directory(folder)) return found;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (entry.is_regular_file() && (extension == ".xml" || extension == ".st")) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// A message at column 0 names its line alone.
Position moved(const Position& at, const std::string& original, const Variant& variant) {
  if (at.line == 0) return at;
  const std::size_t offset = offset_of(original, at);
  if (offset == std::string::npos) return {0, 0};
  Position out = position_of(variant.text, variant.map[offset]);
  if (at.column == 0) out.column = 0;
  return out;
}

class WrittenInAnotherWay : public ::testing::TestWithParam<fs::path> {};

TEST_P(WrittenInAnotherWay, HasTheSameMessagesAtTheSameCharacters) {
  std::string original = content(GetParam());
  std::erase(original, '\r');
  if (original.starts_with("\xEF\xBB\xBF")) original.erase(0, 3);
  if (!plc::core::is_utf8(original) || original.find('\0') != std::string::npos) GTEST_SKIP() << "is no text in UTF-8";
  const bool markup = GetParam().extension() == ".xml";
  const std::vector<Variant> variants = plc::test::variants_of(original, markup);

  // Names of files are in messages: one folder for each variant.
  const ScratchFolder scratch;
  std::vector<std::string> files;
  const auto add = [&](const std::string& bytes) {
    const std::string folder = scratch.file(std::to_string(files.size()));
    fs::create_directory(folder);
    files.push_back(folder + "/" + GetParam().filename().string());
    std::ofstream(files.back(), std::ios::binary) << bytes;
  };
  add(original);
  for (const Variant& variant : variants) add(variant.bytes);
  const auto said = check(files, options_of(GetParam().parent_path()));
  for (std::size_t i = 0; i < variants.size(); ++i) {
    std::vector<Message> expected = said[0];
    for (Message& message : expected) message.at = moved(message.at, original, variants[i]);
    EXPECT_EQ(::testing::PrintToString(expected), ::testing::PrintToString(said[i + 1])) << variants[i].name;
  }
}

std::string name_of(const ::testing::TestParamInfo<fs::path>& param) {
  std::string name = std::to_string(param.index) + "_" + param.param.stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Projects, WrittenInAnotherWay, ::testing::ValuesIn(projects_below(PLC_DIAGNOSTICS)), name_of);

/// The first name that a message has in double quotes, or nothing.
std::string quoted_name(const std::string& text) {
  const std::size_t begin = text.find('"');
  if (begin == std::string::npos) return {};
  const std::size_t end = text.find('"', begin + 1);
  std::string name = text.substr(begin + 1, end == std::string::npos ? end : end - begin - 1);
  const bool plain_name = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  });
  return plain_name ? name : std::string();
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Each message has a place inside of the file, and one about a text or a declaration is where the name is.
void expect_places_inside(const std::vector<fs::path>& files, const std::vector<std::string>& options) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.string());
  const auto said = check(names, options);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string text = content(files[i]);
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) continue;
    const std::size_t lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
    for (const Message& message : said[i]) {
      EXPECT_LE(message.at.line, lines) << names[i] << ": " << message;
      if (message.at.line == 0) continue;
      if (plc::core::is_utf8(text)) {
        EXPECT_NE(offset_of(text, message.at), std::string::npos) << names[i] << ": " << message;
      }
      const std::string name = lower(quoted_name(message.text));
      // Messages about arguments quote a parameter, which is declared elsewhere, and those about bodies their POU.
      const bool of_elsewhere = message.code == "P4010" || message.code.starts_with("P410") ||
                                message.code.starts_with("P51") || message.text.starts_with("input ");
      const bool named_there = !of_elsewhere && (message.element == "text" || message.element == "variable");
      if (!named_there || name.empty()) continue;
      const std::size_t begin = offset_of(text, {message.at.line, 0});
      const std::string line = lower(text.substr(begin, text.find('\n', begin) - begin));
      EXPECT_NE(line.find(name), std::string::npos) << names[i] << ": " << message << "\n" << line;
    }
  }
}

TEST(PlacesOfAllMessages, LieInTheFilesOfTheCases) {
  const fs::path cases = PLC_CASES;
  std::vector<fs::path> files;
  for (const fs::path& file : projects_below(cases)) {
    const std::string name = file.filename().string();
    if (name == "project.st" || name == "project.xml") files.push_back(file);
  }
  ASSERT_GT(files.size(), 100u);
  expect_places_inside(files, {"--stub-missing"});
}

TEST(PlacesOfAllMessages, LieInTheFilesOfTheDiagnostics) { expect_places_inside(projects_below(PLC_DIAGNOSTICS), {}); }

TEST(PlacesOfAllMessages, LieInTheFilesOfTheCorpus) {
  const char* chosen = std::getenv("PLC_CORPUS");
  const fs::path corpus = chosen != nullptr ? fs::path(chosen) : fs::path(PLC_CORPUS_DEFAULT);
  if (!fs::is_directory(corpus)) GTEST_SKIP() << "no folder " << corpus << ": set PLC_CORPUS";
  expect_places_inside(projects_below(corpus), {});
  expect_places_inside(projects_below(corpus), {"--stub-missing"});
}

}  // namespace
