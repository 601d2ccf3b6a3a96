#include "tests/library/project.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '&':
        out += "&amp;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// One drawn POU, elements numbered as they are written. All of them are in one column, each block a row.
class Drawing {
 public:
  explicit Drawing(std::string& out) : out_(out) {}

  void draw(const DrawnBlock& block) {
    std::vector<int> sources;
    for (const DrawnBlock::Pin& pin : block.inputs) {
      sources.push_back(++id_);
      out_ += fmt::format(
          "<inVariable localId=\"{}\"><position x=\"10\" y=\"{}\"/><connectionPointOut/><expression>{}</expression>"
          "</inVariable>\n",
          id_, y(), escaped(pin.variable));
    }
    const int id = ++id_;
    out_ += fmt::format("<block localId=\"{}\" typeName=\"{}\"", id, block.type);
    if (!block.instance.empty()) out_ += fmt::format(" instanceName=\"{}\"", block.instance);
    out_ += fmt::format("><position x=\"100\" y=\"{}\"/><inputVariables>\n", y());
    for (std::size_t i = 0; i < sources.size(); ++i) {
      out_ += fmt::format(
          "<variable formalParameter=\"{}\"><connectionPointIn><connection refLocalId=\"{}\"/></connectionPointIn>"
          "</variable>\n",
          block.inputs[i].name, sources[i]);
    }
    out_ += "</inputVariables><inOutVariables/><outputVariables>\n";
    for (const DrawnBlock::Pin& pin : block.outputs) {
      out_ += fmt::format("<variable formalParameter=\"{}\"><connectionPointOut/></variable>\n", pin.name);
    }
    out_ += "</outputVariables></block>\n";
    for (const DrawnBlock::Pin& pin : block.outputs) {
      out_ += fmt::format(
          "<outVariable localId=\"{}\"><position x=\"200\" y=\"{}\"/><connectionPointIn><connection refLocalId=\"{}\" "
          "formalParameter=\"{}\"/></connectionPointIn><expression>{}</expression></outVariable>\n",
          ++id_, y(), id, pin.name, escaped(pin.variable));
    }
    ++row_;
  }

 private:
  [[nodiscard]] int y() const { return 100 * row_ + 10; }
  std::string& out_;
  int id_ = 0;
  int row_ = 0;
};

/// A type in XML: elementary ones are elements, blocks are derived.
std::string xml_type(const std::string& type) {
  if (type == "STRING") return "<string/>";
  if (type == "WSTRING") return "<wstring/>";
  if (core::type_named(type)) return "<" + type + "/>";
  return "<derived name=\"" + type + "\"/>";
}

}  // namespace

std::string structured_text(const std::vector<ProgramText>& programs) {
  std::string out;
  std::string instances;
  for (std::size_t i = 0; i < programs.size(); ++i) {
    out += fmt::format("PROGRAM P{}\nVAR\n", i);
    for (const Declaration& v : programs[i].variables) {
      out += fmt::format("  {} : {}{}{};\n", v.name, v.type, v.initial.empty() ? "" : " := ", v.initial);
    }
    out += "END_VAR\n";
    for (const std::string& statement : programs[i].statements) out += "  " + statement + "\n";
    out += "END_PROGRAM\n";
    instances += fmt::format("  PROGRAM p{0} WITH t : P{0};\n", i);
  }
  return out + "CONFIGURATION c\nRESOURCE r ON plc\n  TASK t (INTERVAL := T#10ms, PRIORITY := 0);\n" + instances +
         "END_RESOURCE\nEND_CONFIGURATION\n";
}

std::string plcopen_xml(const std::vector<ProgramText>& programs) {
  std::string out =
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">\n"
      "<fileHeader companyName=\"PICARD\" productName=\"test\" productVersion=\"1\" "
      "creationDateTime=\"2024-01-01T00:00:00\"/>\n<contentHeader name=\"library\"><coordinateInfo>"
      "<fbd><scaling x=\"1\" y=\"1\"/></fbd><ld><scaling x=\"1\" y=\"1\"/></ld><sfc><scaling x=\"1\" y=\"1\"/></sfc>"
      "</coordinateInfo></contentHeader>\n<types><dataTypes/><pous>\n";
  std::string instances;
  for (std::size_t i = 0; i < programs.size(); ++i) {
    out += fmt::format("<pou name=\"P{}\" pouType=\"program\"><interface><localVars>\n", i);
    for (const Declaration& v : programs[i].variables) {
      out += fmt::format("<variable name=\"{}\"><type>{}</type></variable>\n", v.name, xml_type(v.type));
    }
    out += "</localVars></interface><body><FBD>\n";
    Drawing drawing(out);
    for (const DrawnBlock& block : programs[i].blocks) drawing.draw(block);
    out += "</FBD></body></pou>\n";
    instances += fmt::format("<pouInstance name=\"p{0}\" typeName=\"P{0}\"/>", i);
  }
  return out +
         "</pous></types>\n<instances><configurations><configuration name=\"c\"><resource name=\"r\">"
         "<task name=\"t\" interval=\"T#10ms\" priority=\"0\">" +
         instances + "</task></resource></configuration></configurations></instances>\n</project>\n";
}

Project::Project(const std::string& file_name, const std::string& text) {
  const ScratchFolder scratch;
  const std::string path = scratch.file(file_name);
  std::ofstream(path, std::ios::binary) << text;
  compiler::Compilation compilation;
  compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
  if (!compilation.ok() || !compilation.image) {
    std::ostringstream problems;
    compilation.diagnostics.render(problems);
    problem_ = problems.str().empty() ? "no image" : problems.str();
    return;
  }
  engines_ = Engines::load(*compilation.image, problem_);
}

std::uint32_t Project::offset(const std::string& path) {
  const auto [it, fresh] = offsets_.emplace(path, 0);
  if (fresh) {
    const auto found = runtime::Access((*engines_)[0]).find_leaf(path);
    if (!found || found->task == runtime::Place::kGlobal) {
      std::cerr << "no variable " << path << "\n";
      std::abort();
    }
    it->second = found->offset;
  }
  return it->second;
}
Value Project::read(const std::string& path, TypeId type) {
  return Cell::read((*engines_)[0].program(0).table().data() + offset(path), type);
}
void Project::write(const std::string& path, const Value& value) {
  for (std::size_t e = 0; e < engines_->size(); ++e) {
    Cell::write((*engines_)[e].program(0).table().data() + offset(path), value);
  }
}
std::string Project::scan(core::TimeNs now_ns) {
  std::string difference = engines_->scan(0, now_ns);
  return difference.empty() && engines_->fault() ? "the cycle ended with a fault" : difference;
}
void Project::restart() {
  for (std::size_t e = 0; e < engines_->size(); ++e) (*engines_)[e].program(0).reset();
}

}  // namespace plc::test
