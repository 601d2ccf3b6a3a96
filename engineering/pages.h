// Pages: files that browsers get from the server, as they lie in the program, compressed.
//
// In: files, a request. Out: a response. Without login: they hold nothing of the plant. Does not belong here: what the
// pages are (web/), calls.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace plc::engineering {

struct HttpRequest;
struct HttpResponse;

struct PageFile {
  std::string_view path;           ///< "/", "/app-0123456789abcdef.js"
  std::string_view type;           ///< for Content-Type
  std::string_view tag;            ///< for ETag, with its quotes
  bool named_by_contents = false;  ///< another file would have another name: browsers may keep it for ever
  std::span<const unsigned char> gzip;
};

/// What a GET of one of the files is answered with; nothing when there is no such file.
std::optional<HttpResponse> page_response(std::span<const PageFile> files, std::string_view path,
                                          const HttpRequest& request);

}  // namespace plc::engineering
