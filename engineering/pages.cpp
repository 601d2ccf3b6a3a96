#include "engineering/pages.h"

#include <algorithm>
#include <string>

#include "core/text.h"
#include "engineering/dispatch.h"

namespace plc::engineering {
namespace {

/// Calls `take` with each part of a header whose parts stand between commas.
template <class Take>
bool any_part(std::string_view header, Take take) {
  while (!header.empty()) {
    const std::size_t end = header.find(',');
    if (take(core::trimmed(header.substr(0, end)))) return true;
    header = end == std::string_view::npos ? std::string_view{} : header.substr(end + 1);
  }
  return false;
}

/// Whoever says nothing takes any coding (RFC 9110, 12.5.3).
bool takes_gzip(std::string_view accepted) {
  if (accepted.empty()) return true;
  return any_part(accepted, [](std::string_view part) {
    const std::size_t end = part.find(';');
    const std::string_view name = core::trimmed(part.substr(0, end));
    if (!core::iequals(name, "gzip") && name != "*") return false;
    if (end == std::string_view::npos) return true;
    const std::string_view weight = core::trimmed(part.substr(end + 1));
    // "q=0", "q=0.000"
    return weight.find_first_not_of("q=0. ") != std::string_view::npos;
  });
}

}  // namespace

std::optional<HttpResponse> page_response(std::span<const PageFile> files, std::string_view path,
                                          const HttpRequest& request) {
  const auto file = std::find_if(files.begin(), files.end(), [path](const PageFile& one) { return one.path == path; });
  if (file == files.end()) return std::nullopt;
  if (request.method != "GET") {
    HttpResponse refused = Dispatcher::refusal(405, core::Code::P7715, "a page is had with GET");
    refused.allow = "GET";
    return refused;
  }
  HttpResponse response;
  response.content_type = file->type;
  response.etag = file->tag;
  response.cache_control = file->named_by_contents ? "public, max-age=31536000, immutable" : "no-cache";
  const bool known = any_part(request.if_none_match, [&](std::string_view tag) {
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    return tag == file->tag || tag == "*";
  });
  if (known) {
    response.status = 304;
    return response;
  }
  if (!takes_gzip(request.accept_encoding)) {
    return Dispatcher::refusal(406, core::Code::P7715, "pages are sent compressed, as gzip");
  }
  response.content_encoding = "gzip";
  response.body.assign(file->gzip.begin(), file->gzip.end());
  return response;
}

}  // namespace plc::engineering
