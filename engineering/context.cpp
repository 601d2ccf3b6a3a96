#include "engineering/context.h"

#include <nlohmann/json.hpp>

namespace plc::engineering {

bool Context::is_late(const Json& request) const {
  const auto until = request.find("until_ms");
  return until != request.end() && calendar.utc_ns() / 1'000'000 > until->get<std::int64_t>();
}

}  // namespace plc::engineering
