// HostRules: by which names a server may be called, so that a page of another site cannot reach it by way of a browser
// (DNS rebinding, requests and WebSockets across origins).
//
// An IP address and "localhost" are always good: no site has them as its name. Does not belong here: cookies.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plc::engineering {

class HostRules {
 public:
  /// `names`: of this machine, without port.
  explicit HostRules(std::vector<std::string> names) : names_(std::move(names)) {}

  /// Whether the header "Host" names this server.
  [[nodiscard]] bool allows_host(std::string_view host) const;
  /// Whether the header "Origin" is the server that "Host" names.
  [[nodiscard]] static bool is_same_origin(std::string_view origin, std::string_view host, bool secure);

 private:
  std::vector<std::string> names_;
};

}  // namespace plc::engineering
