#include "engineering/engineering.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "bytecode/image.h"
#include "engineering/diagram_services.h"
#include "engineering/handover.h"
#include "engineering/health.h"
#include "engineering/kept_forces.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

/// Between attempts at what cannot be had.
constexpr core::TimeNs kAgainNs = 1'000'000'000;
/// Between looks at recordings that nobody looks into any more.
constexpr core::TimeNs kPastNs = 10'000'000'000;
/// How soon limits that were changed in pages.toml by hand hold, whether or not somebody looks at a page.
constexpr core::TimeNs kPagesNs = 5'000'000'000;

Said said_of(const core::Problem& problem, core::Severity severity) {
  return {severity, fmt::format("engineering: {}: {}{}", core::info(problem.code).name, problem.message,
                                problem.help.empty() ? "" : " (" + problem.help + ")")};
}

/// Something that is done on the disk again and again, on another thread: a disk that hangs holds up nothing here.
struct Chore {
  std::atomic<bool> busy{false};
  std::mutex mutex;
  std::string problem;  ///< of the latest time, or empty
  std::string said;     ///< ..as it was said

  /// The problem, when it is another one than it was.
  std::optional<std::string> news() {
    const std::lock_guard lock(mutex);
    if (problem == said) return std::nullopt;
    return said = problem;
  }
};

/// Work of another thread: it ends with this, also when it throws.
struct Busy {
  explicit Busy(std::atomic<bool>& flag) : busy(flag) {}
  ~Busy() { busy = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;
  std::atomic<bool>& busy;
};

std::vector<std::string> names_of_machine(const Options& options) {
  std::array<char, 256> host{};
  std::vector<std::string> names;
  if (::gethostname(host.data(), host.size() - 1) == 0 && host[0] != '\0') names.emplace_back(host.data());
  if (!names.empty() && names[0].find('.') == std::string::npos) names.push_back(names[0] + ".local");
  names.insert(names.end(), options.hosts.begin(), options.hosts.end());
  return names;
}

Identity completed(Identity identity, const bytecode::Image& image) {
  const std::vector<std::byte> bytes = identity.image_hash.empty() ? bytecode::save(image) : std::vector<std::byte>();
  if (identity.image_hash.empty())
    identity.image_hash = sha256({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0) identity.machine = host.data();
  return identity;
}

}  // namespace

struct Engineering::State {
  State(Options given, Identity who, runtime::Resource& resource, ValueSource& values, runtime::ForceList& forced,
        const runtime::RealtimeScheduler& plant, LogBook& book, const core::Clock& monotonic,
        const core::Calendar& dates)
      : options(std::move(given)),
        identity(completed(std::move(who), resource.image())),
        variables(resource, values),
        drawn(resource),
        forces(forced),
        kept_forces(options.folder, forced),
        scheduler(plant),
        log(book),
        clock(monotonic),
        calendar(dates),
        hmi(identity.project_path, variables),
        presses(variables,
                [&plant](std::uint32_t task) -> std::optional<std::uint64_t> {
                  if (task_state(task, plant) == "stopped") return std::nullopt;
                  return plant.statistics(task).scans.load(std::memory_order_acquire);
                }),
        names(names_of_machine(options)),
        hosts(names) {}

  void open(std::vector<Said>& said);
  void listen(std::vector<Said>& said);
  void say_code(std::vector<Said>& said);
  void begin(Chore& chore, std::function<std::string()> work);
  void write_audit(std::vector<Said>& said);
  void keep_forces(std::vector<Said>& said);
  [[nodiscard]] std::string url() const;

  Options options;
  Identity identity;
  Variables variables;
  DiagramServices drawn;
  runtime::ForceList& forces;
  KeptForces kept_forces;  ///< also without a folder
  shadow::Shadow* shadow = nullptr;
  ProgramControl* program = nullptr;
  alarms::Alarms* alarms = nullptr;
  alarms::AlarmStore* alarm_store = nullptr;
  historian::Historian* historian = nullptr;
  DeviceBook devices;
  const runtime::RealtimeScheduler& scheduler;
  LogBook& log;
  const core::Clock& clock;
  const core::Calendar& calendar;
  HmiPages hmi;
  Presses presses;
  std::vector<std::string> names;
  HostRules hosts;
  std::unique_ptr<Users> users;
  std::unique_ptr<Audit> audit;
  Sessions sessions;
  LoginDelay delay;
  FirstCode first_code;
  std::unique_ptr<Context> context;
  std::unique_ptr<Dispatcher> dispatcher;
  std::unique_ptr<Server> server;
  bool listening = false;
  FolderLock folder_lock;
  std::string refusal;                                              ///< why not, as it was said
  std::optional<std::pair<std::string, FailedStart>> failed_start;  ///< for the audit: who has asked for it
  core::TimeNs next_ns = 0, past_ns = 0, pages_ns = 0;
  Chore auditing, keeping;
};

/// Users, audit and certificate, once they can be had.
void Engineering::State::open(std::vector<Said>& said) {
  const auto refused = [&](const core::Problem& problem) {
    if (refusal == problem.message) return;
    refusal = problem.message;
    said.push_back(said_of(problem, core::Severity::kWarning));
    said.back().text += "; it is tried again";
  };
  if (!options.folder.empty()) {
    if (const std::string why = make_private_folder(options.folder); !why.empty()) {
      return refused(
          {core::Code::P7701, why, "users and audit are kept there: --state DIR, or [retain] state in plc.toml"});
    }
    if (const std::string why = folder_lock.take(options.folder); !why.empty()) {
      return refused({core::Code::P7701, why, "give each of them a folder of its own: --state DIR"});
    }
  }
  if (!users) {
    auto opened = Users::open(options.folder);
    if (!opened) return refused(opened.error());
    users = std::move(*opened);
    // What the process before has handed over may be older than what became of its users.
    sessions.keep_if([this](const Session& session) {
      const auto user = users->find(session.user);
      return user && user->role == session.role;
    });
  }
  if (!audit) {
    std::string broken;
    audit = std::make_unique<Audit>(options.folder, calendar, broken);
    if (!broken.empty()) said.push_back({core::Severity::kError, "engineering: " + broken});
  }
  if (const auto start = std::exchange(failed_start, std::nullopt)) {
    const auto& [by, failed] = *start;
    audit->add(by, {}, "program.start.failed", Json{{"image", failed.program.image}, {"why", failed.why}});
  }
  std::optional<Certificate> certificate;
  if (options.always_tls || !is_loopback(options.address)) {
    auto had = options.certificate.empty() ? own_certificate(
                                                 options.folder,
                                                 [this] {
                                                   std::vector<std::string> all = names;
                                                   all.insert(all.end(), {"localhost", "127.0.0.1", "::1"});
                                                   if (options.address != "0.0.0.0" && options.address != "::")
                                                     all.push_back(options.address);
                                                   return all;
                                                 }(),
                                                 calendar.utc_ns())
                                           : read_certificate(options.certificate, options.key);
    if (!had) return refused(had.error());
    certificate = std::move(*had);
    said.push_back({core::Severity::kNote, fmt::format("engineering: certificate {}{}", certificate->fingerprint,
                                                       certificate->made ? ", made now" : "")});
  }
  context = std::make_unique<Context>(Context{identity,
                                              variables,
                                              scheduler,
                                              log,
                                              *users,
                                              sessions,
                                              delay,
                                              first_code,
                                              *audit,
                                              clock,
                                              calendar,
                                              forces,
                                              hmi,
                                              presses,
                                              shadow,
                                              clock.now_ns(),
                                              {},
                                              &drawn,
                                              program,
                                              options.no_force,
                                              options.no_program,
                                              options.folder,
                                              alarms,
                                              alarm_store,
                                              historian,
                                              &devices,
                                              options.folder.empty() ? nullptr : &kept_forces,
                                              options.key});
  dispatcher = std::make_unique<Dispatcher>(*context, hosts, certificate.has_value(), options.pages);
  ServerOptions wanted;
  wanted.address = options.address;
  wanted.port = options.port;
  wanted.max_clients = options.max_clients;
  wanted.certificate = std::move(certificate);
  server = std::make_unique<Server>(*dispatcher, std::move(wanted));
}

std::string Engineering::State::url() const {
  const bool secure = options.always_tls || !is_loopback(options.address);
  const bool six = options.address.find(':') != std::string::npos;
  const bool any = options.address == "0.0.0.0" || options.address == "::";
  return fmt::format("{}://{}:{}", secure ? "https" : "http",
                     any   ? names.empty() ? "localhost" : names.front()
                       : six ? "[" + options.address + "]"
                           : options.address,
                     server->port());
}

void Engineering::State::listen(std::vector<Said>& said) {
  if (!server) open(said);
  if (!server) return;
  if (const auto problem = server->start()) {
    if (refusal == problem->message) return;
    refusal = problem->message;
    said.push_back(said_of(*problem, core::Severity::kWarning));
    said.back().text += "; it is tried again";
    return;
  }
  listening = true;
  said.push_back({core::Severity::kNote, "engineering: " + url()});
  if (users->empty()) {
    first_code.renew();
    if (options.folder.empty()) {
      said.push_back({core::Severity::kNote,
                      "engineering: users are kept until plc-run ends, since there is no folder for them (--state)"});
    }
  }
}

void Engineering::State::say_code(std::vector<Said>& said) {
  const std::string code = first_code.take_shown();
  if (code.empty() || !users->empty()) return;
  said.push_back(
      {core::Severity::kNote,
       fmt::format("engineering: there is no user yet: code of the first one {} (plc remote {} first-user CODE NAME)",
                   code, url())});
}

void Engineering::State::begin(Chore& chore, std::function<std::string()> work) {
  if (chore.busy.exchange(true)) return;
  const bool taken = server->post_file_work([&chore, work = std::move(work)] {
    const Busy done{chore.busy};
    std::string why = work();
    const std::lock_guard lock(chore.mutex);
    chore.problem = std::move(why);
  });
  if (!taken) chore.busy = false;
}

void Engineering::State::write_audit(std::vector<Said>& said) {
  begin(auditing, [this] { return audit->write_waiting(); });
  const auto problem = auditing.news();
  if (!problem) return;
  said.push_back(problem->empty() ? Said{core::Severity::kNote, "engineering: the audit is written again"}
                                  : Said{core::Severity::kWarning,
                                         fmt::format("engineering: {}: the audit {}; records wait in memory",
                                                     core::info(core::Code::P7704).name, *problem)});
}

void Engineering::State::keep_forces(std::vector<Said>& said) {
  if (kept_forces.is_due()) begin(keeping, [this] { return kept_forces.store(); });
  const auto problem = keeping.news();
  if (problem && !problem->empty()) said.push_back({core::Severity::kWarning, "engineering: " + *problem});
}

Engineering::Engineering(Options options, Identity identity, runtime::Resource& resource, ValueSource& values,
                         runtime::ForceList& forces, const runtime::RealtimeScheduler& scheduler, LogBook& log,
                         const core::Clock& clock, const core::Calendar& calendar)
    : state_(std::make_unique<State>(std::move(options), std::move(identity), resource, values, forces, scheduler, log,
                                     clock, calendar)) {}

void Engineering::set_shadow(shadow::Shadow* shadow) {
  state_->shadow = shadow;
  state_->drawn.live.set_shadow(shadow);
}

void Engineering::set_program(ProgramControl* control) {
  state_->program = control;
  if (control->running.image.empty()) control->running.image = state_->identity.image_hash;
}

void Engineering::note_failed_start(std::string by, FailedStart failed) {
  state_->failed_start.emplace(std::move(by), std::move(failed));
}

void Engineering::take_over(std::string_view text) {
  std::uint16_t port = 0;
  engineering::take_over(text, state_->sessions, port);
  // Where any port would do, clients know the one of before.
  if (state_->options.port == 0) state_->options.port = port;
}

std::string Engineering::handover() const {
  const std::uint16_t had = state_->server ? state_->server->port() : std::uint16_t{0};
  return handover_text(state_->sessions, had != 0 ? had : state_->options.port);
}

void Engineering::set_alarms(alarms::Alarms* alarms, alarms::AlarmStore* store) {
  state_->alarms = alarms;
  state_->alarm_store = store;
}

void Engineering::set_historian(historian::Historian* historian) { state_->historian = historian; }

void Engineering::note_devices(Devices devices) { state_->devices.put(std::move(devices)); }

Engineering::~Engineering() { stop(); }

void Engineering::on_sessions(std::function<void(std::string handover)> changed) {
  state_->sessions.on_change([this, changed = std::move(changed)] { changed(handover()); });
}

std::vector<Said> Engineering::force_again(bool warm, bool trial) {
  std::vector<Said> said;
  if (trial) state_->kept_forces.hold();
  if (const std::string why = state_->folder_lock.take(state_->options.folder); !why.empty()) {
    said.push_back({core::Severity::kWarning, "engineering: no kept force is set: " + why});
    return said;
  }
  if (warm) {
    for (std::string& one : engineering::force_again(state_->options.folder, state_->calendar.utc_ns(),
                                                     state_->clock.now_ns(), state_->forces))
      said.push_back({core::Severity::kWarning, "engineering: " + std::move(one)});
  } else {
    for (std::string& one : ended_by_start(state_->options.folder))
      said.push_back({core::Severity::kWarning, "engineering: " + std::move(one)});
    if (const std::string why = state_->kept_forces.store(); !why.empty())
      said.push_back({core::Severity::kWarning, "engineering: " + why});
  }
  return said;
}

void Engineering::confirmed() { state_->kept_forces.release(); }

std::vector<Said> Engineering::start() {
  std::vector<Said> said;
  state_->hmi.read();
  const auto pages = state_->hmi.state();
  for (const std::string& text : pages->texts) {
    // WHY a warning: pages with mistakes are no reason to stop, and not one why the plant would not run.
    said.push_back({core::Severity::kWarning, "engineering: " + text});
  }
  state_->listen(said);
  if (state_->listening) state_->say_code(said);
  state_->next_ns = state_->clock.now_ns() + kAgainNs;
  return said;
}

std::vector<Said> Engineering::service(core::TimeNs now_ns) {
  std::vector<Said> said;
  State& state = *state_;
  for (const runtime::Force& over : state.forces.expire(state.clock.now_ns())) {
    // WHY: it would be forced at the next warm start, if UTC is set back.
    if (over.kept) state.kept_forces.note_change();
    if (state.audit)
      state.audit->add(over.owner, {}, "forces.expire", Json{{"path", over.path}, {"value", over.value}});
  }
  for (const Presses::Ended& over : state.presses.service(now_ns)) {
    if (state.audit) state.audit->add(over.holder.user, {}, "pages.press.expire", Json{{"path", over.path}});
  }
  for (std::string& changed : state.forces.take_changes())
    said.push_back({core::Severity::kWarning, std::move(changed)});
  if (!state.listening && now_ns >= state.next_ns) {
    state.next_ns = now_ns + kAgainNs;
    state.listen(said);
  }
  if (!state.listening) return said;
  state.say_code(said);
  state.write_audit(said);
  state.keep_forces(said);
  state.drawn.diagrams.rest();
  if (now_ns >= state.pages_ns) {
    state.pages_ns = now_ns + kPagesNs;
    state.server->post_file_work([&state] { state.hmi.read(); });
  }
  if (now_ns >= state.past_ns) {
    state.past_ns = now_ns + kPastNs;
    state.server->post_past_work([&state] { state.drawn.past.rest(state.clock.now_ns()); });
  }
  return said;
}

void Engineering::stop() {
  State& state = *state_;
  if (state.program != nullptr) state.program->ending = true;
  if (state.server) state.server->stop();
  // WHY not dropped: what this program was started without would be forced at the next warm start.
  if (state.kept_forces.is_due()) static_cast<void>(state.kept_forces.store());
  state.presses.stop();
  if (std::exchange(state.listening, false)) state.audit->write_waiting();
}

std::uint16_t Engineering::port() const { return state_->listening ? state_->server->port() : 0; }

ServerStatistics Engineering::statistics() const {
  return state_->server ? state_->server->statistics() : ServerStatistics{};
}

}  // namespace plc::engineering
