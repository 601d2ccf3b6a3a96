// EngineeringRig: a small plant with all that calls of the engineering server need, without sockets.
//
// Time is virtual. Users: one of each role, "viewer" to "admin", with the password of the same name and "-password".
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "engineering/diagram_services.h"
#include "engineering/dispatch.h"
#include "engineering/streams.h"
#include "tests/support/run_tool.h"

namespace plc::test {

using engineering::HttpRequest;
using engineering::HttpResponse;
using engineering::Json;
using engineering::Right;

class SetCalendar final : public core::Calendar {
 public:
  [[nodiscard]] core::TimeNs utc_ns() const noexcept override { return now_ns; }
  core::TimeNs now_ns = 1'800'000'000'000'000'000;
};

/// Globals of every elementary type, with limits, addresses and an array of structures, and a task that counts.
bytecode::VerifiedImage engineering_image();

class EngineeringRig {
 public:
  explicit EngineeringRig(bool secure = false, bool with_users = true, const std::string& folder = {},
                          const std::string& project = {});
  explicit EngineeringRig(bytecode::VerifiedImage image, bool secure = false, bool with_users = true,
                          const std::string& folder = {}, const std::string& project = {});
  ~EngineeringRig();
  EngineeringRig(const EngineeringRig&) = delete;
  EngineeringRig& operator=(const EngineeringRig&) = delete;

  /// A request from this machine, as a script makes it.
  [[nodiscard]] HttpRequest request(const std::string& method, const std::string& target,
                                    const std::string& body = {}) const;
  /// One that brings a file.
  HttpResponse post_file(const std::string& target, const std::string& bytes, const std::string& role = "engineer");
  HttpResponse send(const HttpRequest& request);
  /// The secret of a session of this role.
  const std::string& session(const std::string& role);
  HttpResponse get(const std::string& target, const std::string& role = "viewer");
  HttpResponse post(const std::string& target, const Json& body, const std::string& role = "operator");
  /// One scan of the task.
  void scan();
  void forget_sessions() { sessions_.clear(); }

  core::VirtualClock clock;
  SetCalendar calendar;
  engineering::Identity identity{"PICARD test", "plant", {}, "all by default", "here", "0"};
  std::unique_ptr<runtime::Resource> resource;
  engineering::GlobalValues values;
  engineering::Variables variables;
  engineering::DiagramServices drawn;
  runtime::ForceList forces;
  std::uint64_t scans = 0;
  engineering::HmiPages hmi;
  engineering::Presses presses;
  runtime::RealtimeScheduler scheduler;
  engineering::LogBook log;
  std::unique_ptr<engineering::Users> users;
  engineering::Sessions sessions;
  engineering::LoginDelay delay;
  engineering::FirstCode first_code;
  std::string check_says;  ///< of an image that is uploaded: what is wrong with it
  std::string audit_said;
  engineering::Audit audit;
  /// The cheapest that libsodium allows: tests are about who may, not about how long it takes.
  engineering::Context context{identity, variables, scheduler, log, *users,  sessions, delay, first_code, audit,
                               clock,    calendar,  forces,    hmi, presses, nullptr,  0,     {1, 8192},  nullptr};
  engineering::HostRules hosts{{"plant.example"}};
  ScratchFolder programs;
  std::unique_ptr<engineering::ProgramStore> store =
      std::move(*engineering::ProgramStore::open(programs.file("program")));
  engineering::ProgramControl control;

 private:
  std::unique_ptr<engineering::Dispatcher> dispatcher_;
  std::map<std::string, std::string> sessions_;
};

Json body_of(const HttpResponse& response);

}  // namespace plc::test
