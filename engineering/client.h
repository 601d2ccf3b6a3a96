// Client: calls a server from another program, by the same rows.
//
// In: "http://127.0.0.1:8061" or "https://..", a secret, calls with their fields. Out: what the server answers. A
// certificate that nobody known has signed is taken by its fingerprint alone. Threads: one; blocks on the network, at
// most patience_ms() a step. Does not belong here: command lines, where secrets are kept (tools/plc/remote.cpp).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.h"
#include "engineering/call.h"

namespace plc::engineering {

struct ServerUrl {
  bool secure = false;
  std::string host;  ///< name or address, without brackets
  std::uint16_t port = 0;
  [[nodiscard]] std::string text() const;
};
/// "http://plant:8061", "https://[::1]"; "plant" alone is https. Nothing for anything else.
std::optional<ServerUrl> parse_url(std::string_view text);

struct Reply {
  int status = 0;
  std::string body;       ///< JSON, or a file
  std::string file_name;  ///< of a file
};

class Client {
 public:
  static constexpr int kPatienceMs = 10'000;
  /// ..for the answer to a file: the server checks it for up to 60 s.
  static constexpr int kFilePatienceMs = 70'000;
  static int patience_ms(const Call& call) { return file_field(call) != nullptr ? kFilePatienceMs : kPatienceMs; }

  /// `secret`: of a session or token, or empty. `fingerprint`: of a certificate that is taken besides those with a
  /// known signer, or empty.
  Client(ServerUrl url, std::string secret, std::string fingerprint)
      : url_(std::move(url)), secret_(std::move(secret)), fingerprint_(std::move(fingerprint)) {}

  /// What the server answers, whatever it is. P7730 when nothing comes, P7731 when the certificate is not known.
  core::Result<Reply> send(const Call& call, const Json& fields);
  void set_secret(std::string secret) { secret_ = std::move(secret); }
  /// Of the certificate that was taken by its fingerprint; else empty.
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }

 private:
  ServerUrl url_;
  std::string secret_, fingerprint_;
};

}  // namespace plc::engineering
