#include "engineering/dispatch.h"

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/text.h"
#include "engineering/validate.h"

namespace plc::engineering {
namespace {

using core::Code;

constexpr double kCallsPerSecond = 2000;
constexpr double kBurst = 4000;
constexpr std::size_t kMostAddresses = 4096;

std::string dump(const Json& body) { return body.dump(-1, ' ', false, Json::error_handler_t::replace); }

HttpResponse response_of(const Refusal& refusal) {
  Json body;
  body["code"] = core::info(refusal.code).name;
  body["text"] = refusal.text;
  if (!refusal.field.empty()) body["field"] = refusal.field;
  if (!refusal.help.empty()) body["help"] = refusal.help;
  HttpResponse response;
  response.status = refusal.status;
  if (refusal.retry_after_ns != 0) {
    response.retry_after_s = (refusal.retry_after_ns + 999'999'999) / 1'000'000'000;
    body["retry_after_ms"] = (refusal.retry_after_ns + 999'999) / 1'000'000;
  }
  response.body = dump(body) + "\n";
  if (refusal.status == 401) response.challenge = "Bearer";
  return response;
}

/// The value of a cookie in the header; the first of that name.
std::string_view cookie_in(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = header.find(';');
    const std::string_view part = core::trimmed(header.substr(0, end));
    header = end == std::string_view::npos ? std::string_view{} : header.substr(end + 1);
    const std::size_t equals = part.find('=');
    if (equals != std::string_view::npos && part.substr(0, equals) == name) return part.substr(equals + 1);
  }
  return {};
}

/// What was asked for, for the audit: no secrets, of a file its hash, nothing that is long.
Json audited_fields(const Call& call, const Json& request) {
  constexpr std::size_t kLongest = 1000;
  Json details = Json::object();
  for (const Field& field : call.request) {
    const std::string name(field.name);
    const auto value = request.find(name);
    if (value == request.end() || name == "password") continue;
    if (field.type == FieldType::kFile) {
      details[name] = sha256(value->get_ref<const std::string&>());
    } else if (value->is_primitive() &&
               (!value->is_string() || value->get_ref<const std::string&>().size() <= kLongest)) {
      details[name] = *value;
    }
  }
  return details;
}

const char* method_text(Method method) { return method == Method::kGet ? "GET" : "POST"; }

}  // namespace

std::string_view cookie_name(bool secure) { return secure ? "__Host-picard" : "picard"; }

ReadyCall::ReadyCall() = default;
ReadyCall::~ReadyCall() = default;
ReadyCall::ReadyCall(ReadyCall&&) noexcept = default;
ReadyCall& ReadyCall::operator=(ReadyCall&&) noexcept = default;

Dispatcher::Dispatcher(Context& context, const HostRules& hosts, bool secure, std::span<const PageFile> pages)
    : context_(context), hosts_(hosts), secure_(secure), pages_(pages) {}

HttpResponse Dispatcher::refusal(int status, Code code, std::string text) {
  return response_of({status, code, std::move(text), {}, {}, 0});
}

bool Dispatcher::is_too_often(const std::string& address) {
  const core::TimeNs now_ns = context_.clock.now_ns();
  if (buckets_.size() >= kMostAddresses && !buckets_.contains(address)) {
    std::erase_if(buckets_, [now_ns](const auto& entry) { return now_ns - entry.second.last_ns > 10'000'000'000; });
    if (buckets_.size() >= kMostAddresses) buckets_.clear();
  }
  const auto [it, fresh] = buckets_.try_emplace(address, Bucket{kBurst, now_ns});
  Bucket& bucket = it->second;
  bucket.tokens =
      std::min(kBurst, bucket.tokens + static_cast<double>(now_ns - bucket.last_ns) * 1e-9 * kCallsPerSecond);
  bucket.last_ns = now_ns;
  if (bucket.tokens < 1) return true;
  bucket.tokens -= 1;
  return false;
}

Caller Dispatcher::caller_of(const HttpRequest& request, bool& by_cookie) const {
  Caller caller;
  caller.address = request.address;
  by_cookie = false;
  std::string_view secret;
  if (!request.authorization.empty()) {
    constexpr std::string_view kBearer = "bearer ";
    const std::string_view header = request.authorization;
    if (header.size() < kBearer.size() || !core::iequals(header.substr(0, kBearer.size()), kBearer)) return caller;
    secret = core::trimmed(header.substr(kBearer.size()));
  } else {
    secret = cookie_in(request.cookie, cookie_name(secure_));
    by_cookie = !secret.empty();
  }
  if (secret.empty() || secret.size() > 256) return caller;
  if (auto session = context_.sessions.use(secret, context_.clock.now_ns())) {
    caller.user = session->user;
    caller.role = session->role;
    caller.session = session->number;
    caller.secret = secret;
  } else if (!by_cookie) {
    if (const auto token = context_.users.token_of(secret, context_.calendar.utc_ns())) {
      caller.user = token->user;
      caller.role = token->role;
      caller.secret = secret;
    }
  }
  return caller;
}

std::size_t Dispatcher::most_body_bytes(const HttpRequest& head) const {
  const Call* const call = find_call(std::string_view(head.target).substr(0, head.target.find('?')));
  if (call == nullptr || file_field(*call) == nullptr) return kMostBodyBytes;
  bool by_cookie = false;
  return caller_of(head, by_cookie).role >= call->right ? kMostFileBytes : kMostBodyBytes;
}

ReadyCall Dispatcher::check(HttpRequest request) {
  ReadyCall ready;
  const auto refuse = [&ready](const Refusal& refusal) -> ReadyCall&& {
    ready.call = nullptr;
    ready.response = response_of(refusal);
    return std::move(ready);
  };
  if (is_too_often(request.address)) {
    return refuse({429, Code::P7713, "too many calls from this address", {}, {}, 100'000'000});
  }
  if (!hosts_.allows_host(request.host)) {
    return refuse({403, Code::P7716, "\"" + request.host.substr(0, 100) + "\" is not a name of this server", "Host",
                   "call it by its address, or name it as hosts under [engineering] in plc.toml", 0});
  }
  const std::string_view target = request.target;
  const std::size_t mark = target.find('?');
  const std::string_view path = target.substr(0, mark);
  // WHY before what asks where a request comes from: links of other sites may lead to the pages.
  if (auto page = page_response(pages_, path, request)) {
    ready.response = std::move(*page);
    return ready;
  }
  if (!request.origin.empty() && !HostRules::is_same_origin(request.origin, request.host, secure_)) {
    return refuse(
        {403, Code::P7716, "pages of " + request.origin.substr(0, 100) + " may not call this server", "Origin", {}, 0});
  }
  if (request.fetch_site == "cross-site" || request.fetch_site == "same-site") {
    return refuse({403, Code::P7716, "pages of other sites may not call this server", "Sec-Fetch-Site", {}, 0});
  }
  const Call* const call = find_call(path);
  if (call == nullptr) {
    return refuse({404,
                   Code::P7715,
                   "there is no call " + std::string(path.substr(0, 100)),
                   {},
                   path == "/" ? "this server was built without its pages" : "GET /api/openapi.json lists all",
                   0});
  }
  if (request.method != method_text(call->method)) {
    ReadyCall refused =
        refuse({405, Code::P7715, "this call is made with " + std::string(method_text(call->method)), {}, {}, 0});
    refused.response.allow = method_text(call->method);
    return refused;
  }
  if ((call->form == Form::kStream) != request.upgrade) {
    return refuse({call->form == Form::kStream ? 426 : 400,
                   Code::P7715,
                   call->form == Form::kStream ? "this call is made as a WebSocket" : "this call is no WebSocket",
                   {},
                   {},
                   0});
  }
  bool by_cookie = false;
  ready.caller = caller_of(request, by_cookie);
  // Browsers say where a request comes from whenever it changes something, or opens a WebSocket.
  if (by_cookie && (call->method == Method::kPost || request.upgrade) && request.origin.empty()) {
    return refuse({403, Code::P7716, "a cookie counts with a header Origin only", "Origin", {}, 0});
  }
  if (call->right != Right::kAnybody) {
    if (ready.caller.user.empty()) {
      return refuse({401,
                     Code::P7710,
                     "log in first",
                     {},
                     context_.users.empty() ? "there is no user yet: POST /api/first-user" : "POST /api/login",
                     0});
    }
    if (ready.caller.role < call->right) {
      return refuse({403,
                     Code::P7711,
                     "this call is for " + std::string(right_text(call->right)) + ", and " +
                         (ready.caller.session == 0 ? "this token" : ready.caller.user) + " is " +
                         std::string(right_text(ready.caller.role)),
                     {},
                     {},
                     0});
    }
  }
  std::optional<Json> fields;
  const std::string_view query = mark == std::string_view::npos ? std::string_view{} : target.substr(mark + 1);
  const std::string_view type =
      core::trimmed(std::string_view(request.content_type).substr(0, request.content_type.find(';')));
  const Field* const file = file_field(*call);
  if (call->method == Method::kGet) {
    if (!request.body.empty()) return refuse({400, Code::P7714, "a GET has no body", {}, {}, 0});
    fields = query_json(query, call->request);
    if (!fields) return refuse({400, Code::P7714, "the query cannot be read", {}, {}, 0});
  } else if (file != nullptr) {
    if (!core::iequals(type, "application/octet-stream")) {
      return refuse({415, Code::P7714, "the body must be application/octet-stream", "Content-Type", {}, 0});
    }
    fields = query_json(query, call->request);
    if (!fields) return refuse({400, Code::P7714, "the query cannot be read", {}, {}, 0});
    if (fields->contains(file->name)) {
      return refuse({400, Code::P7714, "is the body, not in the query", std::string(file->name), {}, 0});
    }
    (*fields)[std::string(file->name)] = std::move(request.body);
  } else {
    if (!core::iequals(type, "application/json")) {
      return refuse({415, Code::P7714, "the body must be application/json", "Content-Type", {}, 0});
    }
    if (mark != std::string_view::npos) return refuse({400, Code::P7714, "a POST has no query", {}, {}, 0});
    fields = parse_json(request.body);
    if (!fields)
      return refuse({400,
                     Code::P7714,
                     "the body is not JSON",
                     {},
                     "one object in UTF-8, nested at most 32 deep, no name twice, at most 4000 in one object",
                     0});
  }
  if (const auto found = wrong_fields(*fields, call->request)) return refuse(*found);
  ready.call = call;
  ready.request = std::make_unique<Json>(std::move(*fields));
  return ready;
}

HttpResponse Dispatcher::run(ReadyCall& ready) const {
  // WHY: a defect of a call, or memory that it does not get, must not end the process that runs the plant.
  try {
    return response_to(ready);
  } catch (const std::exception& failed) {
    Refusal refusal{500, Code::P9001, std::string(ready.call->name) + " failed: " + failed.what(), {}, {}, 0};
    audit_failure(ready, refusal);
    return response_of(refusal);
  }
}

/// Of who changes what runs, or who may do what: also what came of a call that did not do it.
void Dispatcher::audit_failure(const ReadyCall& ready, const Refusal& refusal) const {
  const Call& call = *ready.call;
  if (call.method != Method::kPost || call.right < Right::kEngineer) return;
  Json details = audited_fields(call, *ready.request);
  details["code"] = core::info(refusal.code).name;
  details["why"] = refusal.text;
  context_.audit.add(ready.caller.user, ready.caller.address, std::string(call.name) + ".failed", details);
}

HttpResponse Dispatcher::response_to(ReadyCall& ready) const {
  Answer answer;
  ready.call->run(context_, ready.caller, *ready.request, answer);
  if (answer.refused()) {
    audit_failure(ready, answer.refusal());
    return response_of(answer.refusal());
  }
  HttpResponse response;
  if (ready.call->form == Form::kFile) {
    response.content_type = "application/octet-stream";
    response.body = answer.take_file();
    response.file_name = answer.file_name();
    if (!answer.file_type().empty()) {
      response.content_type = answer.file_type();
      response.is_picture = true;
    }
  } else if (!answer.ready().empty()) {
    response.body = answer.ready();
  } else {
    response.body = dump(answer.body()) + "\n";
  }
  if (answer.sets_cookie()) {
    response.set_cookie =
        std::string(cookie_name(secure_)) + "=" + answer.cookie() + "; Path=/; HttpOnly; SameSite=Strict";
    if (secure_) response.set_cookie += "; Secure";
    if (answer.cookie().empty()) response.set_cookie += "; Max-Age=0";
  }
  return response;
}

bool Dispatcher::may_go_on(const ReadyCall& ready) const {
  const Caller& caller = ready.caller;
  if (caller.session != 0) return context_.sessions.keep(caller.session, context_.clock.now_ns());
  const auto token = context_.users.token_of(caller.secret, context_.calendar.utc_ns());
  return token && token->role >= ready.call->right;
}

}  // namespace plc::engineering
