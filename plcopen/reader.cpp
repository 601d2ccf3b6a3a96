#include "plcopen/reader.h"

#include <fmt/core.h>

#include <memory>
#include <new>
#include <utility>

#include "plcopen/input_text.h"
#include "plcopen/reader_state.h"
#include "plcopen/xml_stream.h"

namespace plc::plcopen {

namespace {

std::unique_ptr<Project> parse(const InputText& input, const std::string& name, std::uint16_t file,
                               core::Diagnostics& diagnostics, const ReadLimits& limits) {
  auto project = std::make_unique<Project>();
  project->path = name;
  project->file = file;
  XmlParser parser(input, file, diagnostics, limits);
  Reader reader(*project, diagnostics, limits, parser);
  if (!parser.run(reader)) return nullptr;
  reader.finish();
  return project;
}

template <class Load>
std::unique_ptr<Project> read_with(const std::string& name, core::Diagnostics& diagnostics, const ReadLimits& limits,
                                   Load load) {
  const std::uint16_t file = diagnostics.add_file(name);
  try {
    const std::unique_ptr<InputText> input = load(file);
    return input == nullptr ? nullptr : parse(*input, name, file, diagnostics, limits);
  } catch (const std::bad_alloc&) {
    diagnostics.report(core::Code::P1001, {.file = file}, {}, "not enough memory to read the project");
    return nullptr;
  }
}

}  // namespace

const char* language_name(Language language) {
  switch (language) {
    case Language::kNone:
      return "none";
    case Language::kLd:
      return "LD";
    case Language::kFbd:
      return "FBD";
    case Language::kSt:
      return "ST";
    case Language::kIl:
      return "IL";
    case Language::kSfc:
      return "SFC";
  }
  return "none";
}

const char* pou_kind_name(PouKind kind) {
  switch (kind) {
    case PouKind::kProgram:
      return "program";
    case PouKind::kFunctionBlock:
      return "functionBlock";
    case PouKind::kFunction:
      return "function";
  }
  return "program";
}

std::unique_ptr<Project> read(const std::string& path, core::Diagnostics& diagnostics, const ReadLimits& limits) {
  return read_with(path, diagnostics, limits,
                   [&](std::uint16_t file) { return InputText::from_file(path, file, diagnostics, limits); });
}

std::unique_ptr<Project> read_memory(std::string_view xml, const std::string& name, core::Diagnostics& diagnostics,
                                     const ReadLimits& limits) {
  return read_with(name, diagnostics, limits,
                   [&](std::uint16_t file) { return InputText::from_memory(xml, file, diagnostics, limits); });
}

}  // namespace plc::plcopen
