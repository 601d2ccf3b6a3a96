// Engineering: the engineering server of a plant, with all that it needs: users, audit, certificate, values, log.
//
// In: a resource, a scheduler, where to listen, a folder for what is kept. Out: sentences for the operator. Nothing of
// it decides whether control starts: what cannot be had is said, and tried again. Life: constructor -> start() ->
// service() .. -> stop(). Threads: the owner's; log() any. Does not belong here: command lines.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/diagnostics.h"
#include "engineering/context.h"
#include "engineering/pages.h"
#include "engineering/server.h"

namespace plc::engineering {

class Veto;

struct Options {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8061;
  std::uint32_t max_clients = 128;
  std::vector<std::string> hosts;                   ///< further names of this machine
  bool always_tls = false;                          ///< on loopback, too
  std::string certificate, key;                     ///< files in PEM; empty: one made at the first start
  Veto *no_force = nullptr, *no_program = nullptr;  ///< null: never forbidden; they must outlive the server
  std::string folder;                               ///< for users, audit and certificate; empty: nothing is kept
  /// That browsers get; they outlive the server.
  std::span<const PageFile> pages;
};

struct Said {
  core::Severity severity = core::Severity::kNote;
  std::string text;
};

class Engineering {
 public:
  /// All references must outlive it. `values`: made before anything of the plant was started.
  Engineering(Options options, Identity identity, runtime::Resource& resource, ValueSource& values,
              runtime::ForceList& forces, const runtime::RealtimeScheduler& scheduler, LogBook& log,
              const core::Clock& clock, const core::Calendar& calendar);
  ~Engineering();
  Engineering(const Engineering&) = delete;
  Engineering& operator=(const Engineering&) = delete;

  /// What scans are recorded by; before start(). It must outlive the server.
  void set_shadow(shadow::Shadow* shadow);
  /// What takes wishes about the program; before start(). It must outlive the server. Completed with the image that
  /// runs.
  void set_program(ProgramControl* control);
  /// The start before was to try a program, and failed: a record of the audit. `by`: who has asked for it. Before
  /// start().
  void note_failed_start(std::string by, FailedStart failed);
  /// What handover() of the server before gave; before start().
  void take_over(std::string_view text);
  /// For the server that follows. Any time; after stop() nobody logs in or out any more.
  [[nodiscard]] std::string handover() const;
  /// Who is told, on a thread of the server and before whoever asked gets the answer, that somebody has logged in or
  /// out, with what handover() gives then. Before start().
  void on_sessions(std::function<void(std::string handover)> changed);
  /// Before the tasks run. `warm`: what was forced to hold over such a start is forced again; else it is forgotten.
  /// `trial`: what is on the disk stays as it is until confirmed(), so that the program before has it if this one does
  /// not start.
  std::vector<Said> force_again(bool warm, bool trial = false);
  /// The program is on trial no more.
  void confirmed();
  /// What there is beside it; before start(). They must outlive the server.
  void set_alarms(alarms::Alarms* alarms, alarms::AlarmStore* store);
  void set_historian(historian::Historian* historian);
  /// How the devices are now.
  void note_devices(Devices devices);
  /// Opens its files and listens.
  std::vector<Said> start();
  /// About every 100 ms: what has happened since, and another try where something could not be had.
  std::vector<Said> service(core::TimeNs now_ns);
  /// What takes long in a call is given up.
  void stop();

  /// The port listened on; 0 while it cannot be had.
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] ServerStatistics statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plc::engineering
