#include "engineering/client.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/text.h"

namespace plc::engineering {
namespace {

using core::Code;
using core::Problem;

constexpr std::size_t kMostReply = 128'000'000;

/// A text as a part of a query.
std::string encoded(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  return out;
}

std::string query_of(const Json& fields) {
  std::string query;
  const auto add = [&query](const std::string& name, const Json& value) {
    query += (query.empty() ? "?" : "&") + encoded(name) + "=" +
             encoded(value.is_string() ? value.get<std::string>() : value.dump());
  };
  for (const auto& [name, value] : fields.items()) {
    if (!value.is_array()) {
      add(name, value);
      continue;
    }
    for (const Json& one : value) add(name, one);
  }
  return query;
}

/// WHY: OpenSSL writes without MSG_NOSIGNAL, and whoever ends the connection would end this process.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoPipeSignal() {
    constexpr timespec kNow{};
    while (sigismember(&before_, SIGPIPE) == 0 && ::sigtimedwait(&pipe_, nullptr, &kNow) == SIGPIPE) {
    }
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

/// A connection, with TLS or without.
class Link {
 public:
  Link() = default;
  ~Link() {
    if (ssl_ != nullptr) SSL_free(ssl_);
    if (context_ != nullptr) SSL_CTX_free(context_);
    if (socket_ >= 0) ::close(socket_);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// How long a step may take from here on; before, kPatienceMs.
  void set_patience(int ms) {
    const timeval patience{ms / 1000, ms % 1000 * 1000L};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }

  std::optional<Problem> open(const ServerUrl& url) {
    addrinfo wanted{};
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(url.host.c_str(), std::to_string(url.port).c_str(), &wanted, &found);
    if (error != 0) return unreachable(url, ::gai_strerror(error));
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(found, ::freeaddrinfo);
    int why = 0;
    for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
      socket_ = ::socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC, at->ai_protocol);
      set_patience(Client::kPatienceMs);
      if (::connect(socket_, at->ai_addr, at->ai_addrlen) == 0) return std::nullopt;
      why = errno;
      ::close(std::exchange(socket_, -1));
    }
    return unreachable(url, std::strerror(why));
  }

  std::optional<Problem> encrypt(const ServerUrl& url, const std::string& fingerprint) {
    const NoPipeSignal none;
    context_ = SSL_CTX_new(TLS_client_method());
    SSL_CTX_set_min_proto_version(context_, TLS1_2_VERSION);
    SSL_CTX_set_default_verify_paths(context_);
    SSL_CTX_set_verify(context_, SSL_VERIFY_NONE, nullptr);  // what it finds is looked at below
    ssl_ = SSL_new(context_);
    X509_VERIFY_PARAM* const rules = SSL_get0_param(ssl_);
    if (X509_VERIFY_PARAM_set1_ip_asc(rules, url.host.c_str()) != 1) {
      SSL_set1_host(ssl_, url.host.c_str());
      SSL_set_tlsext_host_name(ssl_, url.host.c_str());
    }
    ERR_clear_error();
    SSL_set_fd(ssl_, socket_);
    if (SSL_connect(ssl_) != 1) return unreachable(url, "it does not speak TLS");
    if (SSL_get_verify_result(ssl_) == X509_V_OK) return std::nullopt;
    const std::unique_ptr<X509, decltype(&X509_free)> certificate(SSL_get1_peer_certificate(ssl_), X509_free);
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (certificate) X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size);
    std::string has;
    for (unsigned i = 0; i < size; ++i) has += fmt::format("{}{:02X}", i == 0 ? "" : ":", digest[i]);
    if (!has.empty() && core::iequals(has, fingerprint)) return std::nullopt;
    return Problem{Code::P7731,
                   fingerprint.empty() ? "nobody known has signed the certificate of " + url.text()
                                       : "the certificate of " + url.text() + " is another one than before",
                   "its fingerprint is " + has + ": compare it with what plc-run printed, and say --fingerprint"};
  }

  /// False: the other side does not take all of it. It may have said why.
  bool write(std::string_view bytes) {
    const NoPipeSignal none;
    while (!bytes.empty()) {
      const ssize_t sent =
          ssl_ != nullptr ? SSL_write(ssl_, bytes.data(), static_cast<int>(std::min<std::size_t>(bytes.size(), 65536)))
                          : ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// All up to the end.
  std::string read() {
    std::string all;
    std::array<char, 65536> piece{};
    for (;;) {
      const ssize_t got = ssl_ != nullptr ? SSL_read(ssl_, piece.data(), static_cast<int>(piece.size()))
                                          : ::recv(socket_, piece.data(), piece.size(), 0);
      if (got <= 0 || all.size() > kMostReply) return all;
      all.append(piece.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  static Problem unreachable(const ServerUrl& url, const std::string& why) {
    return {Code::P7730, "cannot reach " + url.text() + ": " + why,
            "does plc-run run there, and with --engineering at this address?"};
  }

  int socket_ = -1;
  SSL_CTX* context_ = nullptr;
  SSL* ssl_ = nullptr;
};

/// The value of a header.
std::string_view header_in(std::string_view head, std::string_view name) {
  while (!head.empty()) {
    const std::size_t end = head.find("\r\n");
    const std::string_view line = head.substr(0, end);
    head = end == std::string_view::npos ? std::string_view{} : head.substr(end + 2);
    const std::size_t colon = line.find(':');
    if (colon != std::string_view::npos && core::iequals(line.substr(0, colon), name))
      return core::trimmed(line.substr(colon + 1));
  }
  return {};
}

}  // namespace

std::string ServerUrl::text() const {
  const bool six = host.find(':') != std::string::npos;
  return fmt::format("{}://{}:{}", secure ? "https" : "http", six ? "[" + host + "]" : host, port);
}

std::optional<ServerUrl> parse_url(std::string_view text) {
  constexpr std::uint16_t kPort = 8061;
  ServerUrl url;
  url.secure = !text.starts_with("http://");
  for (const std::string_view scheme : {std::string_view("http://"), std::string_view("https://")}) {
    if (text.starts_with(scheme)) text.remove_prefix(scheme.size());
  }
  if (text.ends_with('/')) text.remove_suffix(1);
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    url.host = text.substr(1, end - 1);
    port = text.substr(end + 1);
  } else {
    const std::size_t colon = text.find(':');
    url.host = text.substr(0, colon);
    port = colon == std::string_view::npos ? std::string_view{} : text.substr(colon);
  }
  url.port = kPort;
  if (!port.empty()) {
    const auto read = std::from_chars(port.data() + 1, port.data() + port.size(), url.port);
    if (port.front() != ':' || read.ec != std::errc{} || read.ptr != port.data() + port.size() || url.port == 0)
      return std::nullopt;
  }
  const bool good = !url.host.empty() && url.host.find_first_of(" /?#@\\\r\n") == std::string::npos;
  return good ? std::optional(url) : std::nullopt;
}

core::Result<Reply> Client::send(const Call& call, const Json& fields) {
  Link link;
  if (auto problem = link.open(url_)) return *problem;
  if (url_.secure) {
    if (auto problem = link.encrypt(url_, fingerprint_)) return *problem;
  }
  link.set_patience(patience_ms(call));
  const bool get = call.method == Method::kGet;
  const Field* const file = file_field(call);
  Json in_query = get || file != nullptr ? fields : Json::object();
  if (file != nullptr) in_query.erase(std::string(file->name));
  const std::string target = std::string(call.path) + query_of(in_query);
  const std::string url = url_.text();
  std::string request = fmt::format("{} {} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n", get ? "GET" : "POST", target,
                                    url.substr(url.find("://") + 3));
  if (!secret_.empty()) request += "Authorization: Bearer " + secret_ + "\r\n";
  const std::string body = get               ? ""
                           : file != nullptr ? fields.value(std::string(file->name), "")
                                             : fields.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (!get) {
    request += fmt::format("Content-Type: application/{}\r\nContent-Length: {}\r\n",
                           file != nullptr ? "octet-stream" : "json", body.size());
  }
  link.write(request + "\r\n" + body);
  const std::string got = link.read();
  const std::size_t end = got.find("\r\n\r\n");
  Reply reply;
  if (end == std::string::npos || !got.starts_with("HTTP/1.1 ") ||
      std::from_chars(got.data() + 9, got.data() + 12, reply.status).ec != std::errc{}) {
    return Problem{Code::P7730, url + " answers nothing that can be read",
                   "is it an engineering server? with http:// or https://?"};
  }
  const std::string_view head = std::string_view(got).substr(0, end);
  std::size_t length = 0;
  const std::string_view declared = header_in(head, "Content-Length");
  std::from_chars(declared.data(), declared.data() + declared.size(), length);
  reply.body = got.substr(end + 4);
  if (reply.body.size() != length) return Problem{Code::P7730, url + " ended the connection within its answer", {}};
  const std::string_view disposition = header_in(head, "Content-Disposition");
  const std::size_t name = disposition.find("filename=\"");
  if (name != std::string_view::npos)
    reply.file_name = disposition.substr(name + 10, disposition.rfind('"') - name - 10);
  return reply;
}

}  // namespace plc::engineering
