#include "tools/plc/explain_drawing.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <optional>
#include <system_error>
#include <vector>

#include "bytecode/drawings.h"
#include "core/text.h"
#include "drawings/make.h"
#include "pictures/picture.h"
#include "tools/command_line.h"

namespace plc::tools {
namespace {

/// The exit code when there are none.
std::optional<int> drawings_of(Command command, const Request& request, Compilation& compilation,
                               bytecode::Drawings& drawings) {
  if (is_image_path(request.path)) {
    if (const auto code = open_or_explain(command, request, compilation)) return code;
    const std::vector<std::byte>& packed = compilation.image->image().drawings;
    if (packed.empty()) {
      complain("plc explain", request.path + " carries no drawings",
               "give the file it was made from, or make it with plc compile --drawings");
      return kExitErrors;
    }
    auto unpacked = bytecode::unpack(packed);
    if (!unpacked) return complain(unpacked.error()), kExitErrors;
    drawings = std::move(*unpacked);
    return std::nullopt;
  }
  compiler::open(request, compilation);
  compilation.diagnostics.render_with_lines(std::cerr);
  if (!compilation.readable) return kExitUsage;
  if (!compilation.project) return kExitErrors;
  drawings = drawings::make(*compilation.project, compilation.diagnostics);
  return std::nullopt;
}

std::string caption_of(const bytecode::DrawnBody& body) {
  constexpr std::string_view kOwners[] = {"program", "function block", "function", "action", "transition"};
  constexpr std::string_view kLanguages[] = {"LD", "FBD", "ST", "IL", "SFC"};
  return fmt::format("{} {}{} ({})", kOwners[static_cast<std::size_t>(body.owner)], body.name,
                     body.worksheet.empty() ? "" : ", " + body.worksheet,
                     kLanguages[static_cast<std::size_t>(body.language)]);
}

bool is_part_of(std::string_view name, std::string_view pou) {
  return core::iequals(name, pou) ||
         (name.size() > pou.size() && name[pou.size()] == '.' && core::iequals(name.substr(0, pou.size()), pou));
}

}  // namespace

int explain_drawing(Command command, const Request& request, const std::string& pou, const std::string& svg) {
  std::error_code ignored;
  if (std::filesystem::equivalent(request.path, svg, ignored)) {
    complain("plc explain", "--svg " + svg + " would overwrite what it is made from", "give another name");
    return kExitUsage;
  }
  Compilation compilation;
  bytecode::Drawings drawings;
  if (const auto code = drawings_of(command, request, compilation, drawings)) return *code;
  std::vector<pictures::PicturedBody> chosen;
  std::string names;
  for (const bytecode::DrawnBody& body : drawings.bodies) {
    if (names.find(body.name) == std::string::npos) names += (names.empty() ? "" : ", ") + body.name;
    if (pou.empty() || is_part_of(body.name, pou)) chosen.push_back({&body, caption_of(body), 0});
  }
  if (chosen.empty()) {
    complain("plc explain",
             pou.empty() ? request.path + " has no POU with a body"
                         : fmt::format("{} has no drawing of a POU \"{}\"", request.path, pou),
             names.empty() ? "" : "it has: " + names);
    return kExitErrors;
  }
  const std::string title = pou.empty() ? "POUs of " + request.path : chosen.front().body->name;
  const std::string picture = pictures::svg(title, chosen);
  if (svg == "-") {
    std::cout << picture;
    return kExitOk;
  }
  std::string why;
  if (write_file(svg, picture, why)) return kExitOk;
  complain("plc explain", fmt::format("{} cannot be written: {}", svg, why));
  return kExitUsage;
}

}  // namespace plc::tools
