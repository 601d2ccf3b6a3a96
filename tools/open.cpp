#include "tools/open.h"

#include <iostream>

namespace plc::tools {

std::optional<int> open_or_explain(Command command, const Request& request, Compilation& compilation) {
  if (const auto code = refuse_options_of_image(command, request.path)) return code;
  open(request, compilation);
  compilation.diagnostics.render_with_lines(std::cerr);
  if (!compilation.readable) return kExitUsage;
  if (!compilation.ok()) return kExitErrors;
  return std::nullopt;
}

}  // namespace plc::tools
