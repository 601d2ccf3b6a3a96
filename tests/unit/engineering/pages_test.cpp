// Pages: files for browsers, before login, compressed, kept by their tag.
#include "engineering/pages.h"

#include <array>

#include "tests/unit/engineering/rig.h"

namespace plc {
namespace {

using engineering::HttpRequest;
using engineering::HttpResponse;
using engineering::PageFile;

constexpr std::array<unsigned char, 3> kBytes = {0x1f, 0x8b, 0x00};
constexpr PageFile kFiles[] = {
    {"/", "text/html; charset=utf-8", "\"one\"", false, kBytes},
    {"/app-1.js", "text/javascript", "\"two\"", true, kBytes},
};

class Pages : public testing::Test {
 protected:
  HttpResponse get(const std::string& target, const std::function<void(HttpRequest&)>& change = {}) {
    HttpRequest request = rig.request("GET", target);
    if (change) change(request);
    auto ready = dispatcher.check(request);
    EXPECT_EQ(ready.call, nullptr);
    return ready.response;
  }

  test::EngineeringRig rig;
  engineering::Dispatcher dispatcher{rig.context, rig.hosts, false, kFiles};
};

TEST_F(Pages, AreGivenWithoutLogin) {
  const HttpResponse response = get("/");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.content_type, "text/html; charset=utf-8");
  EXPECT_EQ(response.content_encoding, "gzip");
  EXPECT_EQ(response.etag, "\"one\"");
  EXPECT_EQ(response.cache_control, "no-cache");
  EXPECT_EQ(response.body, std::string("\x1f\x8b\x00", 3));
  EXPECT_EQ(get("/?from=mail").status, 200);
}

TEST_F(Pages, AreKeptForEverWhenTheirNameIsOfTheirContents) {
  EXPECT_EQ(get("/app-1.js").cache_control, "public, max-age=31536000, immutable");
}

TEST_F(Pages, AreNotSentAgain) {
  for (const char* tag : {"\"one\"", "W/\"one\"", "\"other\", \"one\"", "*"}) {
    const HttpResponse response = get("/", [tag](HttpRequest& request) { request.if_none_match = tag; });
    EXPECT_EQ(response.status, 304) << tag;
    EXPECT_EQ(response.body, "");
    EXPECT_EQ(response.etag, "\"one\"");
  }
  EXPECT_EQ(get("/", [](HttpRequest& request) { request.if_none_match = "\"two\""; }).status, 200);
}

TEST_F(Pages, AreForThoseWhoTakeGzip) {
  const auto status = [this](const char* accepted) {
    return get("/", [accepted](HttpRequest& request) { request.accept_encoding = accepted; }).status;
  };
  EXPECT_EQ(status("gzip, deflate, br"), 200);
  EXPECT_EQ(status("br;q=1.0, GZIP;q=0.5"), 200);
  EXPECT_EQ(status("*"), 200);
  EXPECT_EQ(status("br"), 406);
  EXPECT_EQ(status("gzip;q=0"), 406);
  EXPECT_EQ(status("identity"), 406);
}

TEST_F(Pages, LinksOfOtherSitesLeadToThem) {
  EXPECT_EQ(get("/", [](HttpRequest& request) { request.fetch_site = "cross-site"; }).status, 200);
}

TEST_F(Pages, AnswerToTheNamesOfTheServerAlone) {
  EXPECT_EQ(get("/", [](HttpRequest& request) { request.host = "evil.example"; }).status, 403);
}

TEST_F(Pages, AreReadOnly) {
  HttpRequest request = rig.request("POST", "/", "{}");
  const auto ready = dispatcher.check(request);
  EXPECT_EQ(ready.response.status, 405);
  EXPECT_EQ(ready.response.allow, "GET");
}

TEST_F(Pages, OthersAreNotThere) {
  EXPECT_EQ(get("/app-2.js").status, 404);
  EXPECT_EQ(get("/../app-1.js").status, 404);
}

TEST_F(Pages, AServerWithoutThemSaysSo) {
  const HttpResponse response = rig.send(rig.request("GET", "/"));
  EXPECT_EQ(response.status, 404);
  EXPECT_NE(response.body.find("built without its pages"), std::string::npos);
}

}  // namespace
}  // namespace plc
