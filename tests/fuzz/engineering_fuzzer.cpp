// The engineering server on arbitrary bytes: requests of HTTP and messages of WebSockets. Nobody without login has an
// effect, every answer is JSON and as its row says, nothing crashes.
//
// Input: 'H' and bytes of a request; a token "viewer", "operator", "engineer" or "admin" is that of a session. Or 'W'
// and a message to a stream of values.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "engineering/http.h"
#include "engineering/validate.h"
#include "engineering/value_stream.h"
#include "tests/unit/engineering/rig.h"

namespace {

using namespace plc;

void expect(bool holds, const char* what, const std::string& of) {
  if (holds) return;
  std::fprintf(stderr, "%s: %s\n", what, of.c_str());
  std::abort();
}

void take_request(test::EngineeringRig& rig, engineering::HttpRequest request) {
  std::string role;
  for (const char* name : {"viewer", "operator", "engineer", "admin"}) {
    if (request.authorization != std::string("Bearer ") + name) continue;
    role = name;
    // Sessions may have been ended by what came before.
    request.authorization =
        "Bearer " + rig.sessions.begin(role, engineering::role_named(role), "127.0.0.1", rig.clock.now_ns());
  }
  rig.clock.sleep_until_ns(rig.clock.now_ns() + 1'000'000);
  engineering::Dispatcher dispatcher(rig.context, rig.hosts, false);
  auto ready = dispatcher.check(request);
  if (ready.call == nullptr) {
    expect(ready.response.status >= 400, "a refusal has a status of one", request.target);
    expect(test::body_of(ready.response).contains("code"), "a refusal has a code", ready.response.body);
    return;
  }
  expect(!role.empty() || ready.call->right == engineering::Right::kAnybody, "nobody may call", request.target);
  if (ready.call->form == engineering::Form::kStream) return;
  const auto response = dispatcher.run(ready);
  if (ready.call->form == engineering::Form::kFile && response.status == 200) return;
  const engineering::Json body = test::body_of(response);
  expect(body.is_object(), "an answer is an object", response.body);
  if (response.status != 200) {
    expect(body.contains("code") && body.contains("text"), "a refusal says why", response.body);
  } else if (!ready.call->response.empty()) {
    const auto wrong = engineering::wrong_fields(body, ready.call->response);
    expect(!wrong, "an answer is as its row says", response.body);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static test::EngineeringRig rig;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == 'H') {
    auto read = engineering::read_http(bytes, "127.0.0.1");
    if (read.request) take_request(rig, std::move(*read.request));
    if (read.refusal) expect(read.refusal->status >= 400, "a refusal has a status of one", read.refusal->body);
  } else if (data[0] == 'W') {
    engineering::ValueStream stream(rig.context, 10'000'000);
    const engineering::Json answer = engineering::Json::parse(stream.take(bytes), nullptr, false);
    expect(answer.contains("layout") != answer.contains("code"), "a message is answered with a layout or a refusal",
           std::string(bytes));
    static_cast<void>(stream.next());
    rig.scan();
    static_cast<void>(stream.next());
  }
  return 0;
}
