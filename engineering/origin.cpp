#include "engineering/origin.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

#include "core/text.h"

namespace plc::engineering {
namespace {

/// Without the port; nothing of what is no host.
std::string_view name_of(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return {};
    const std::string_view rest = host.substr(end + 1);
    return rest.empty() || rest.front() == ':' ? host.substr(1, end - 1) : std::string_view();
  }
  const std::size_t colon = host.find(':');
  if (colon != std::string_view::npos && host.find(':', colon + 1) != std::string_view::npos) return {};
  return host.substr(0, colon);
}

bool is_address(const std::string& name) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
}

}  // namespace

bool HostRules::allows_host(std::string_view host) const {
  const std::string name(name_of(host));
  if (name.empty()) return false;
  if (is_address(name) || core::iequals(name, "localhost")) return true;
  return std::any_of(names_.begin(), names_.end(), [&name](const std::string& n) { return core::iequals(n, name); });
}

bool HostRules::is_same_origin(std::string_view origin, std::string_view host, bool secure) {
  const std::string_view scheme = secure ? "https://" : "http://";
  if (!origin.starts_with(scheme)) return false;
  return core::iequals(origin.substr(scheme.size()), host);
}

}  // namespace plc::engineering
