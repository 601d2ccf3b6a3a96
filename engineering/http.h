// Between HTTP as Beast has it and requests as the dispatcher takes them.
//
// Does not belong here: sockets (connection.h), calls.
#pragma once

#include <algorithm>  // WHY first: see connection.h
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "engineering/dispatch.h"

namespace plc::engineering {

using HttpMessage = boost::beast::http::request<boost::beast::http::string_body>;

/// A field that is there several times counts as one that is wrong.
HttpRequest request_of(const HttpMessage& message, const std::string& peer);
boost::beast::http::response<boost::beast::http::string_body> message_of(HttpResponse given, bool keep_alive);
/// What to answer when a request cannot be read; nothing when there is nobody to answer.
std::optional<HttpResponse> refusal_of(const boost::system::error_code& error);

/// For fuzzers and tests: what a server makes of these bytes: a request or a refusal; nothing when more is needed.
struct ReadBytes {
  std::optional<HttpRequest> request;
  std::optional<HttpResponse> refusal;
};
ReadBytes read_http(std::string_view bytes, const std::string& peer);

}  // namespace plc::engineering
