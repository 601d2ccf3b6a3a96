// Dispatcher: from a request of HTTP to a call and back: which row, who calls, may they, are the fields right.
//
// In: a request as text, rows (call.h). Out: a response; or a call that is ready to run on its thread. Every refusal is
// a JSON object {"code", "text", "field", "help"}. No sockets: tests and fuzzers use it as the server does. Threads:
// check() one; run() that of the call. Does not belong here: reading HTTP (http.h), what calls do.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/origin.h"
#include "engineering/pages.h"

namespace plc::engineering {

/// Limits of one request.
inline constexpr std::size_t kMostHeaderBytes = 16'384;
inline constexpr std::size_t kMostBodyBytes = 1'048'576;
/// Of a request that brings a file, of who may send one.
inline constexpr std::size_t kMostFileBytes = 64'000'000;
/// Nesting of JSON.
inline constexpr int kMostDepth = 32;

/// What matters of a request.
struct HttpRequest {
  std::string method;  ///< "GET"
  std::string target;  ///< "/api/tasks?..", as it came
  std::string host, origin, fetch_site, cookie, authorization, content_type;
  std::string accept_encoding, if_none_match;
  bool upgrade = false;  ///< to a WebSocket
  std::string body;
  std::string address;  ///< of the peer
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::string set_cookie;  ///< whole header, or empty
  std::string file_name;   ///< of an attachment, or empty
  std::string challenge;   ///< WWW-Authenticate, or empty
  std::string allow;       ///< of 405
  std::int64_t retry_after_s = 0;
  std::string content_encoding;  ///< of the body, or empty
  std::string etag;              ///< with its quotes, or empty
  std::string cache_control = "no-store";
  bool is_picture = false;  ///< of a project: nothing in it may run or load
};

/// A call whose request is good.
struct ReadyCall {
  ReadyCall();
  ~ReadyCall();
  ReadyCall(ReadyCall&&) noexcept;
  ReadyCall& operator=(ReadyCall&&) noexcept;

  const Call* call = nullptr;  ///< null: `response` says why not
  Caller caller;
  std::unique_ptr<Json> request;
  HttpResponse response;
};

class Dispatcher {
 public:
  /// `secure`: clients come by TLS. All must outlive it.
  Dispatcher(Context& context, const HostRules& hosts, bool secure, std::span<const PageFile> pages = {});

  /// How large the body may be of a request of which the head is known: more only for a call that takes a file, from
  /// somebody who may make it.
  [[nodiscard]] std::size_t most_body_bytes(const HttpRequest& head) const;
  ReadyCall check(HttpRequest request);
  /// Any thread that the row allows.
  HttpResponse run(ReadyCall& ready) const;
  /// Whether a stream may go on: the session or token still counts, with this right. A stream keeps its session from
  /// ending for want of calls.
  [[nodiscard]] bool may_go_on(const ReadyCall& ready) const;
  [[nodiscard]] Context& context() { return context_; }

  /// What a request is refused with that never became one: too large, no HTTP.
  static HttpResponse refusal(int status, core::Code code, std::string text);

 private:
  /// Throws what the call throws, and when there is no memory.
  HttpResponse response_to(ReadyCall& ready) const;
  void audit_failure(const ReadyCall& ready, const Refusal& refusal) const;
  [[nodiscard]] Caller caller_of(const HttpRequest& request, bool& by_cookie) const;
  bool is_too_often(const std::string& address);

  struct Bucket {
    double tokens = 0;
    core::TimeNs last_ns = 0;
  };
  Context& context_;
  const HostRules& hosts_;
  bool secure_;
  std::span<const PageFile> pages_;
  std::unordered_map<std::string, Bucket> buckets_;  ///< by address
};

/// The name of the cookie of a session.
std::string_view cookie_name(bool secure);

}  // namespace plc::engineering
