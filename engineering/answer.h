// Answer: what a call has to say: a JSON object, bytes, or why not.
//
// Threads: that of the call. Does not belong here: HTTP beyond its numbers (dispatch.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/diagnostics.h"
#include "core/result.h"
#include "engineering/call.h"

namespace plc::engineering {

/// Why a call did nothing.
struct Refusal {
  int status = 400;  ///< of HTTP
  core::Code code = core::Code::P7714;
  std::string text;
  std::string field;  ///< which one was wrong, "values[2].value", or empty
  std::string help;
  std::int64_t retry_after_ns = 0;  ///< it may succeed then; 0 = not by waiting
};

class Answer {
 public:
  Answer();
  ~Answer();
  Answer(const Answer&) = delete;
  Answer& operator=(const Answer&) = delete;

  /// The object of a call of the form kJson; empty at first.
  Json& body() { return *body_; }
  /// The object as text, in place of body(): what is the same for everybody is not made anew. It must outlive the
  /// answer.
  void give_ready(std::string_view text) { ready_ = text; }
  [[nodiscard]] std::string_view ready() const { return ready_; }
  /// Bytes of a call of the form kFile, and the name under which a client may store them.
  void give_file(std::string bytes, std::string name);

  /// Bytes of a picture, which a page shows: "image/png".
  void give_picture(std::string bytes, std::string type);

  /// Nothing was done. The last refusal counts.
  void refuse(int status, core::Code code, std::string text, std::string field = {}, std::string help = {});
  /// The same for a problem of the runtime: P7101 is 404, others are 409.
  void refuse(const core::Problem& problem, std::string field = {});
  void refuse(Refusal refusal);
  [[nodiscard]] bool refused() const { return refused_; }
  [[nodiscard]] const Refusal& refusal() const { return refusal_; }

  /// A session begins with this secret, which becomes a cookie; or ends: empty.
  void set_cookie(std::string secret);
  [[nodiscard]] bool sets_cookie() const { return sets_cookie_; }
  [[nodiscard]] const std::string& cookie() const { return cookie_; }
  /// The bytes, which may be many: they are not there any more afterwards.
  [[nodiscard]] std::string take_file() { return std::exchange(file_, {}); }
  [[nodiscard]] const std::string& file_name() const { return file_name_; }
  /// Of a picture; otherwise empty.
  [[nodiscard]] const std::string& file_type() const { return file_type_; }

 private:
  std::unique_ptr<Json> body_;
  bool refused_ = false, sets_cookie_ = false;
  Refusal refusal_;
  std::string_view ready_;
  std::string cookie_, file_, file_name_, file_type_;
};

}  // namespace plc::engineering
