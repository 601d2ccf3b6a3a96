#include "tools/plc/explain_flow.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <system_error>

#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/flow.h"

namespace plc::tools {

int explain_flow(Command command, const Request& request, const std::string& svg) {
  Compilation compilation;
  if (const auto code = open_or_explain(command, request, compilation)) return *code;
  const bytecode::Image& image = compilation.image->image();
  const DataFlow flow = data_flow(image);
  if (svg.empty()) {
    std::cout << flow_tables(image, flow);
    return kExitOk;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(request.path, svg, ignored)) {
    complain("plc explain", "--svg " + svg + " would overwrite what it is made from", "give another name");
    return kExitUsage;
  }
  if (svg == "-") {
    std::cout << flow_svg(image, flow);
    return kExitOk;
  }
  std::string why;
  if (write_file(svg, flow_svg(image, flow), why)) return kExitOk;
  complain("plc explain", fmt::format("{} cannot be written: {}", svg, why));
  return kExitUsage;
}

}  // namespace plc::tools
