#include "tests/support/problem_page.h"

#include <fstream>
#include <regex>
#include <sstream>

namespace plc::test {
namespace {

std::string default_name(const std::string& language) {
  if (language == "toml") return "plc.toml";
  if (language == "csv") return "stimulus.csv";
  if (language == "ini") return "plc-run.service";
  return "example." + language;
}

/// A drawn POU alone stands for a project that runs its programs in one task.
std::string whole_project(const std::string& text) {
  if (text.rfind("<pou ", 0) != 0) return text;
  std::string instances;
  static const std::regex program(R"re(<pou name="(\w+)" pouType="program")re");
  for (std::sregex_iterator it(text.begin(), text.end(), program), end; it != end; ++it) {
    const std::string name = (*it)[1];
    instances += "<pouInstance name=\"run" + name + "\" typeName=\"" + name + "\"/>";
  }
  return R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="" productName="example" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="example"><coordinateInfo><fbd><scaling x="0" y="0"/></fbd><ld><scaling x="0" y="0"/></ld><sfc><scaling x="0" y="0"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous>
)" + text +
         R"(</pous></types>
<instances><configurations><configuration name="C"><resource name="R"><task name="T" priority="0" interval="T#20ms">)" +
         instances + "</task></resource></configuration></configurations></instances>\n</project>\n";
}

}  // namespace

const char* const kSmallProject = R"(PROGRAM Main
VAR
  Start AT %IX0.0 : BOOL;
  Level AT %IW1 : INT;
  Motor AT %QX0.0 : BOOL;
  Speed AT %QW1 : INT;
END_VAR
  Motor := Start;
  Speed := Level;
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#20ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
)";

Example read_example(const std::string& page, const std::string& heading) {
  Example example;
  std::ifstream in(page, std::ios::binary);
  bool inside = false, fenced = false;
  std::string language, name, text;
  for (std::string line; std::getline(in, line);) {
    if (!fenced && line.rfind("## ", 0) == 0) inside = line == "## " + heading;
    if (line.rfind("```", 0) != 0) {
      if (fenced) text += line + "\n";
      continue;
    }
    fenced = !fenced;
    if (fenced) {
      std::istringstream words(line.substr(3));
      language.clear();
      name.clear();
      words >> language >> name;
      text.clear();
      continue;
    }
    if (!inside || language.empty() || language == "text") continue;
    if (language == "sh") {
      example.commands += text;
    } else {
      example.files[name.empty() ? default_name(language) : name] = language == "xml" ? whole_project(text) : text;
    }
  }
  return example;
}

bool names(const std::string& output, const std::string& code) {
  return std::regex_search(output, std::regex("\\b" + code + "\\b"));
}

}  // namespace plc::test
