// Context: what calls work on. Caller: who calls.
//
// In: a plant that runs. Out: what rows may use, by thread: a call of Thread::kIo everything, others what is said to
// be for any thread. Does not belong here: HTTP.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "engineering/audit.h"
#include "engineering/call.h"
#include "engineering/device_book.h"
#include "engineering/hmi_pages.h"
#include "engineering/kept_forces.h"
#include "engineering/log_book.h"
#include "engineering/login_delay.h"
#include "engineering/presses.h"
#include "engineering/program_control.h"
#include "engineering/secrets.h"
#include "engineering/sessions.h"
#include "engineering/users.h"
#include "engineering/variables.h"
#include "engineering/veto.h"
#include "runtime/force_list.h"
#include "runtime/sched/realtime.h"
#include "shadow/shadow.h"

namespace plc::alarms {
class Alarms;
class AlarmStore;
}  // namespace plc::alarms
namespace plc::historian {
class Historian;
}

namespace plc::engineering {

struct DiagramServices;

struct Caller {
  std::string user;  ///< empty before login
  Right role = Right::kAnybody;
  std::string address;
  std::uint64_t session = 0;  ///< 0 = none: a token, or nobody
  std::string secret;         ///< of the session
};

/// What the plant is.
struct Identity {
  std::string product;       ///< "PICARD 0.1.0"
  std::string plant;         ///< as people call it: the file without folder and ending
  std::string project_path;  ///< file or folder that was given to plc-run
  std::string options;       ///< of the compiler, in words
  std::string machine;       ///< host name
  std::string image_hash;    ///< SHA-256 of the saved image; empty: Engineering finds it
};

/// The code by which the first user is made: only while there is none.
class FirstCode {
 public:
  /// Shown where nobody but people at the machine read it: console, journal.
  [[nodiscard]] std::string text() const;
  /// A new one; also after kMostWrong wrong ones. `shown` is set until take_shown().
  void renew();
  /// Whether `text` is the code.
  bool matches(std::string_view text);
  /// The code, when it is to be shown (again).
  std::string take_shown();

 private:
  static constexpr int kMostWrong = 10;
  mutable std::mutex mutex_;
  std::string code_;
  bool shown_ = false;
  int wrong_ = 0;
};

struct Context {
  const Identity& identity;
  Variables& variables;                         ///< kIo
  const runtime::RealtimeScheduler& scheduler;  ///< any
  LogBook& log;                                 ///< any
  Users& users;                                 ///< any
  Sessions& sessions;                           ///< any
  LoginDelay& delay;                            ///< any
  FirstCode& first_code;                        ///< any
  Audit& audit;                                 ///< add(), recent(): any
  const core::Clock& clock;                     ///< any
  const core::Calendar& calendar;               ///< any
  runtime::ForceList& forces;                   ///< any
  HmiPages& hmi;                                ///< any
  Presses& presses;                             ///< any
  shadow::Shadow* shadow = nullptr;             ///< any; null when nothing is recorded
  core::TimeNs begin_ns = 0;                    ///< when the plant started, by `clock`
  PasswordCost cost{};
  DiagramServices* drawn = nullptr;           ///< as its members say
  ProgramControl* program = nullptr;          ///< any; null: nobody takes wishes
  Veto* no_force = nullptr;                   ///< any; null: none
  Veto* no_program = nullptr;                 ///< any; null: none
  std::string folder = {};                    ///< any; of the server's files, empty: nothing is kept
  alarms::Alarms* alarms = nullptr;           ///< any; null without alarms
  alarms::AlarmStore* alarm_store = nullptr;  ///< read(): kFiles; null without alarms
  historian::Historian* historian = nullptr;  ///< kFiles; null when nothing is kept
  const DeviceBook* devices = nullptr;        ///< any; null without
  KeptForces* kept_forces = nullptr;          ///< kFiles; null without a folder
  std::string key = {};                       ///< any; file of the certificate's key, where one was given

  /// Whether a request came after its field until_ms, where it has one: by a line that stood still.
  [[nodiscard]] bool is_late(const Json& request) const;
};

}  // namespace plc::engineering
