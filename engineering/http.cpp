#include "engineering/http.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <iterator>
#include <utility>

namespace plc::engineering {
namespace {

namespace http = boost::beast::http;

std::string only(const HttpMessage& message, http::field name) {
  const auto [first, last] = message.equal_range(name);
  if (first == last) return {};
  if (std::next(first) != last) return "\x7f";  // no value that anything takes
  return std::string(first->value());
}

std::string header(const HttpMessage& message, const char* name) {
  const auto found = message.find(name);
  return found == message.end() ? std::string() : std::string(found->value());
}

/// A name for a header: what could end it is left out.
std::string quotable(const std::string& name) {
  std::string text;
  for (const char c : name) text += c >= 0x20 && c < 0x7f && c != '"' && c != '\\' ? c : '_';
  return text;
}

}  // namespace

HttpRequest request_of(const HttpMessage& message, const std::string& peer) {
  HttpRequest request;
  request.method = std::string(message.method_string());
  request.target = std::string(message.target());
  request.host = only(message, http::field::host);
  request.origin = only(message, http::field::origin);
  request.fetch_site = header(message, "Sec-Fetch-Site");
  request.cookie = only(message, http::field::cookie);
  request.authorization = only(message, http::field::authorization);
  request.content_type = only(message, http::field::content_type);
  request.accept_encoding = header(message, "Accept-Encoding");
  request.if_none_match = header(message, "If-None-Match");
  request.upgrade = boost::beast::websocket::is_upgrade(message);
  request.body = message.body();
  request.address = peer;
  return request;
}

http::response<http::string_body> message_of(HttpResponse given, bool keep_alive) {
  http::response<http::string_body> message;
  message.version(11);
  message.result(static_cast<unsigned>(given.status));
  message.set(http::field::content_type, given.content_type);
  message.set(http::field::cache_control, given.cache_control);
  if (!given.etag.empty()) message.set(http::field::etag, given.etag);
  if (!given.content_encoding.empty()) {
    message.set(http::field::content_encoding, given.content_encoding);
    message.set(http::field::vary, "Accept-Encoding");
  }
  message.set("X-Content-Type-Options", "nosniff");
  message.set("X-Frame-Options", "DENY");
  message.set("Referrer-Policy", "no-referrer");
  message.set("Content-Security-Policy",
              given.is_picture ? "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'; sandbox"
                               : "default-src 'self'; frame-ancestors 'none'");
  if (!given.set_cookie.empty()) message.set(http::field::set_cookie, given.set_cookie);
  if (!given.challenge.empty()) message.set(http::field::www_authenticate, given.challenge);
  if (!given.allow.empty()) message.set(http::field::allow, given.allow);
  if (given.status == 426) message.set(http::field::upgrade, "websocket");
  if (given.retry_after_s != 0) message.set(http::field::retry_after, std::to_string(given.retry_after_s));
  if (!given.file_name.empty()) {
    message.set(http::field::content_disposition, "attachment; filename=\"" + quotable(given.file_name) + "\"");
  }
  message.keep_alive(keep_alive);
  message.body() = std::move(given.body);
  message.prepare_payload();
  return message;
}

std::optional<HttpResponse> refusal_of(const boost::system::error_code& error) {
  using core::Code;
  if (error == http::error::end_of_stream || error == http::error::partial_message) return std::nullopt;
  if (error == http::error::body_limit)
    return Dispatcher::refusal(413, Code::P7717, "the body is larger than 1 MB, or a file than 64 MB");
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return Dispatcher::refusal(431, Code::P7717, "the header is larger than 16 kB");
  }
  if (error.category() == http::make_error_code(http::error::bad_method).category()) {
    return Dispatcher::refusal(400, Code::P7714, "this is not HTTP: " + error.message());
  }
  return std::nullopt;
}

ReadBytes read_http(std::string_view bytes, const std::string& peer) {
  http::request_parser<http::string_body> parser;
  parser.header_limit(kMostHeaderBytes);
  parser.body_limit(kMostBodyBytes);
  parser.eager(true);
  ReadBytes result;
  while (!parser.is_done()) {
    boost::system::error_code error;
    const std::size_t used = parser.put(boost::asio::buffer(bytes.data(), bytes.size()), error);
    bytes.remove_prefix(used);
    if (error == http::error::need_more && used != 0) continue;
    if (error == http::error::need_more) return result;
    if (error) {
      result.refusal = refusal_of(error);
      return result;
    }
    if (used == 0) return result;
  }
  result.request = request_of(parser.get(), peer);
  return result;
}

}  // namespace plc::engineering
