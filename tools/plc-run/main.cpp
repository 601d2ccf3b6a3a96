// plc-run: runs a project or an image in real time until it is told to stop.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/time_zone.h"
#include "io-drivers/config/check_schedule.h"
#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/csv.h"
#include "io-drivers/machine/driver_types.h"
#include "io-drivers/machine/plant.h"
#include "io-drivers/simulated/simulated_device.h"
#include "runtime/sched/realtime.h"
#include "runtime/sched/thread_settings.h"
#include "shadow/arithmetic.h"
#include "tools/command_line.h"
#include "tools/engine.h"
#include "tools/plc-run/allocation_warnings.h"
#include "tools/plc-run/component_faults.h"
#include "tools/plc-run/end_guard.h"
#include "tools/plc-run/engineering_service.h"
#include "tools/plc-run/listeners.h"
#include "tools/plc-run/open_image.h"
#include "tools/plc-run/output.h"
#include "tools/plc-run/plant_folder.h"
#include "tools/plc-run/program_start.h"
#include "tools/plc-run/recording.h"
#include "tools/plc-run/relaunch.h"
#include "tools/plc-run/report.h"
#include "tools/plc-run/retained.h"
#include "tools/plc-run/run_log.h"
#include "tools/plc-run/service.h"
#include "tools/plc-run/signals.h"
#include "tools/plc-run/watch.h"
#include "tools/statistics.h"
#include "tools/taskblock_libraries.h"
#include "tools/version.h"

namespace plc::tools {
namespace {

/// What is printed at the end.
enum class Stats : std::uint8_t {
  kTimes,  ///< what the tasks needed
  kText,   ///< that, histograms, sizes
  kJson,   ///< one JSON document, and nothing else, on stdout
};

struct Run {
  std::string file, plant, duration, stimulus, configuration, modbus, engineering, state, log, record, check;
  std::vector<std::string> watch;
  std::uint64_t cycles = 0;
  Stats stats = Stats::kTimes;
  Engine engine = Engine::kAuto;
  runtime::FaultPolicy on_fault = runtime::FaultPolicy::kSafeState;
  runtime::ProgramOptions program;
  core::CompileOptions options;
  std::vector<std::string> libraries;
  std::optional<io::ListenText> listen;  ///< --modbus
  std::optional<io::ListenText> engineering_listen;
  std::optional<io::OpenSocket> socket;  ///< of the service
  bool simulate = false;                 ///< --simulate-io
  bool repeat = false;                   ///< --repeat
  retain::Start start = retain::Start::kWarm;
  std::optional<LogPlace> log_place;        ///< --log
  std::optional<core::Severity> log_level;  ///< --log-level
};

/// A device is missing or refuses. Another start may succeed: units restart after it (packaging/).
constexpr int kExitDevice = 4;

int code_after_refusal(const core::Diagnostics& diagnostics) {
  const auto mends_itself = [](const core::Diagnostic& found) {
    return found.severity != core::Severity::kError || io::is_about_devices(found.code);
  };
  const auto& all = diagnostics.all();
  return std::all_of(all.begin(), all.end(), mends_itself) ? kExitDevice : kExitErrors;
}

constexpr core::TimeNs kRedrawNs = 200'000'000;

/// The task whose cycle applies the stimulus: the first one whose variables it names, else the fastest.
std::uint32_t stimulus_task(const std::string& path, runtime::Resource& resource) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto rows = io::parse_csv(text, path);
  if (rows && !rows->empty()) {
    const runtime::Access access(resource);
    for (const io::CsvCell& cell : rows->front()) {
      const auto place = access.find_leaf(cell.text);
      if (place && place->task != runtime::Place::kGlobal) return place->task;
    }
  }
  return io::fastest_task(resource.image());
}

/// What the tasks needed so far; they may run.
void print_statistics(const Run& run, const runtime::Resource& resource, const runtime::RealtimeScheduler& scheduler,
                      const shadow::Shadow* shadow, std::ostream& out) {
  const bytecode::Image& image = resource.image();
  if (run.stats == Stats::kJson) return print_json(resource, scheduler, shadow, out);
  if (shadow != nullptr) print_recording(*shadow, out);
  print_times(image, scheduler, out);
  if (run.stats != Stats::kText) return;
  print_engines(resource, out);
  print_histograms(image, scheduler, out);
  print_executions(image, scheduler, out);
}

/// What this machine is to do with the project's tasks.
struct Plan {
  io::Configuration configuration;
  std::vector<runtime::TaskPlan> tasks;
};

/// Nothing after an error, which is in `diagnostics`.
std::optional<Plan> make_plan(const Run& run, io::Configuration configuration, const bytecode::Image& image,
                              core::Diagnostics& diagnostics) {
  Plan plan;
  const std::vector<int> cpus = io::available_cpus();
  auto tasks = io::plan_tasks(configuration, image, cpus, run.on_fault, diagnostics);
  if (tasks) {
    io::check_schedule(configuration, image, *tasks, cpus, diagnostics, run.program.loop_budget);
    plan.tasks = std::move(*tasks);
  }
  plan.configuration = std::move(configuration);
  if (diagnostics.has_errors()) return std::nullopt;
  return plan;
}

/// No task runs, and people are served, until they want a start, or somebody an end. `until_ns`: 0 = for ever.
void wait_for_start(ProgramStart& program, Service& service, EngineeringService& engineering, RunLog& log,
                    core::TimeNs until_ns) {
  core::MonotonicClock clock;
  for (core::TimeNs now = clock.now_ns(); signal_to_stop() == 0 && (until_ns == 0 || now < until_ns);) {
    if (program.wants_start(now)) return;
    service.rests(now);
    engineering.service(now);
    log.service();
    Output::flush();
    clock.sleep_until_ns(now + 20'000'000);
    now = clock.now_ns();
  }
}

/// What a run ends with that had so many `faults`.
int code_after(const runtime::RealtimeScheduler& scheduler, std::size_t faults) {
  // Who stops a plant that got over its faults as its policies say has nothing to mend.
  const auto stops_all = [&](const runtime::TaskFault& fault) {
    return scheduler.plan(fault.task).on_fault == runtime::FaultPolicy::kStop;
  };
  const std::vector<runtime::TaskFault> all = scheduler.faults();
  const bool handled = signal_to_stop() != 0 && std::none_of(all.begin(), all.end(), stops_all);
  return faults == 0 || handled ? kExitOk : kExitErrors;
}

/// What is left for the end when the stop of the tasks took so long.
std::chrono::milliseconds end_patience(core::TimeNs stop_ns) {
  const bool hurries = signal_to_stop() != 0 && Relaunch::instance().has_guardian();
  const auto all = hurries ? EndGuard::kPatienceUnderGuardian : EndGuard::kPatience;
  return std::max(EndGuard::kShortestPatience, all - std::chrono::milliseconds(stop_ns / 1'000'000));
}

/// `diagnostics` are those of the plan: places of the configuration name their file by it. `program`: null when it is
/// only to be seen whether it could run. `folder`: of the state, or empty. `guard` watches the end from here on.
int run_resource(const Run& run, runtime::Resource& resource, Plan plan, core::Diagnostics& diagnostics,
                 std::int64_t duration_ns, core::TimeNs load_ns, Output& output, RunLog& log, ProgramStart* program,
                 const std::string& folder, EndGuard& guard) {
  const bytecode::Image& image = resource.image();
  std::ostream& talk = log.talk();
  const core::TimeNs retain_interval_ns = plan.configuration.retain.interval_ns;
  RecordingSettings recorded = recording_settings(run.record, plan.configuration, folder, run.engine);
  EngineeringRequest asked = engineering_request(plan.configuration, run.engineering_listen, run.file, folder);
  asked.recorded = recorded.mode != io::RecordMode::kOff;
  const auto guardian_ended = [](int code, bool signalled) {
    return Relaunch::instance().guardian_ended(code, signalled);
  };
  auto machine = io::Machine::configure(
      {run.file, std::move(plan.configuration), run.listen, run.socket, run.simulate, program != nullptr,
       guardian_ended, "plc map " + shell_word(run.file) + compile_flags(run.options, run.libraries)},
      resource, diagnostics);
  diagnostics.render_with_lines(std::cerr);
  if (machine == nullptr) return code_after_refusal(diagnostics);
  if (!run.stimulus.empty()) {
    auto device = std::make_unique<io::SimulatedDevice>("--stimulus", run.stimulus,
                                                        stimulus_task(run.stimulus, resource), resource, run.repeat);
    if (const auto problem = machine->add(std::move(device))) return complain(*problem), exit_code_of(*problem);
  }
  if (program == nullptr) return kExitOk;
  LiveView view(run.watch, resource, output);
  if (!run.watch.empty() && view.empty() && program->image_file().empty()) {
    complain("plc-run", fmt::format("no variable matches --watch {}", fmt::join(run.watch, " --watch ")),
             "paths begin with the name of a program instance or a global: --watch '*' shows all of them");
    return kExitUsage;
  }
  print_start(program->title(), image, plan.tasks, load_ns, talk);
  const Retained retained =
      restore_retained(resource, folder, retain_interval_ns, program->start().value_or(run.start), talk, std::cerr);
  if (run.simulate) talk << "--simulate-io: no device is touched, outputs go nowhere\n";
  handle_signals();
  runtime::RealtimeOptions realtime;
  realtime.plan = std::move(plan.tasks);
  realtime.on_thread_start = watch_task_thread;
  realtime.program_time_ns = retained.program_time_ns;
  io::Plant plant(resource, std::move(machine), std::move(realtime));
  EngineeringService engineering(std::move(asked), resource, log, *program);
  plant.machine().set_forces(engineering.forces());
  std::vector<io::Sentence> notes;
  if (const auto problem = plant.prepare([&resource] { name_crashes(resource); }, notes)) {
    return complain(*problem), io::is_about_devices(problem->code) ? kExitDevice : kExitErrors;
  }
  runtime::RealtimeScheduler& scheduler = plant.scheduler();
  if (!view.empty()) scheduler.add_listener(view);
  CycleLimit limit(scheduler, io::fastest_task(image), run.cycles);
  if (run.cycles != 0) scheduler.add_listener(limit);
  log.start();
  print_devices(plant.machine(), talk);
  for (const io::Sentence& note : notes) {
    if (note.severity == core::Severity::kNote) {
      talk << note.text << '\n';
    } else {
      log.say(note);
    }
  }
  std::optional<core::Problem> not_recorded;
  const std::unique_ptr<shadow::Shadow> recording =
      start_shadow(resource, std::move(recorded), run.program.loop_budget, run.program.zone->name(), not_recorded);
  if (recording && !recording->file().empty()) talk << "recording into " << recording->file() << '\n';
  // Nothing but control decides whether control starts.
  if (not_recorded) {
    log.say(core::Severity::kWarning, fmt::format("{}: {}", core::info(not_recorded->code).name, not_recorded->message),
            "record");
  }
  // A program on trial leaves to the one before what that has kept, until it is known which one stays.
  const auto keep = [&] {
    if (retained.keeper && program->settled()) retained.keeper->start();
  };
  keep();
  engineering.prepare(plant, recording.get(), program->start().value_or(run.start) == retain::Start::kWarm);
  let_signals_stop(&plant);
  output.stop_waiting();
  if (const auto problem = plant.start()) return complain(*problem), kExitErrors;
  program->runs(plant.begin_ns());
  engineering.start();
  print_realtime(scheduler.report(), talk);
  talk << std::endl;
  const core::MonotonicClock clock;
  Service service(image, scheduler, clock.now_ns());
  service.ready("runs " + program->title());
  std::size_t faults = 0;
  std::optional<runtime::TaskFault> last_fault;
  const auto show_faults = [&] {
    for (const runtime::TaskFault& fault : scheduler.new_faults()) {
      ++faults;
      last_fault = fault;
      log.say_fault(resource, fault);
    }
  };
  const auto show_retain = [&] {
    if (!retained.keeper) return;
    for (const retain::Message& said : retained.keeper->messages()) log.say(said.severity, said.text, "retain");
  };
  const auto show_recording = [&] {
    if (!recording) return;
    for (const shadow::ShadowMessage& said : recording->messages()) log.say(said.severity, said.text, "record");
  };
  AllocationWarnings allocations(resource);
  core::TimeNs next_view = plant.begin_ns();
  const auto often = [&](core::TimeNs now) {
    service.service(now);
    if (!view.empty() && now >= next_view) {
      view.show(now - plant.begin_ns(), kRedrawNs / 2);
      next_view += kRedrawNs * (1 + (now - next_view) / kRedrawNs);
    }
    show_faults();
    log.say_messages(resource);
    show_retain();
    show_recording();
    allocations.say_new(log);
    engineering.service(now);
    if (program->often(now, last_fault ? fault_text(resource, *last_fault) : "")) plant.request_stop();
    keep();
    if (take_wish_for_report()) {
      print_statistics(run, resource, scheduler, recording.get(), std::cerr);
    }
    log.service();
    Output::flush();
  };
  plant.run(duration_ns, often, [&log](const io::Sentence& said) { log.say(said); });
  if (!program->goes_on()) Service::stopping();
  const core::TimeNs stop_ns = clock.now_ns();
  const std::vector<std::uint32_t> stuck = plant.stop();
  let_signals_stop(nullptr);
  const auto end_code = [&] { return code_after(scheduler, faults); };
  const auto code_if_it_hangs = [&] {
    if (!program->again()) return stuck.empty() && end_code() != kExitOk ? kExitErrors : io::kGuardianExit;
    program->hand_over({}, {});  // then nobody is logged in any more
    return kExitRelaunch;
  };
  show_faults();
  guard.begin(code_if_it_hangs(), end_patience(clock.now_ns() - stop_ns), {Service::alive, Service::alive_every()});
  program->end_keeping();
  keep();
  if (retained.keeper) retained.keeper->stop(stuck);
  if (last_fault) static_cast<void>(program->often(stop_ns, fault_text(resource, *last_fault)));
  if (program->ended(stop_ns) && stuck.empty()) {
    guard.rest();
    wait_for_start(*program, service, engineering, log, duration_ns == 0 ? 0 : plant.begin_ns() + duration_ns);
    guard.go_on();
  }
  guard.expect(code_if_it_hangs());
  if (recording) recording->stop(stuck.empty());
  engineering.stop();  // alarms know the last scans by now
  // After it: who logs out until then is not logged in afterwards.
  if (program->again()) program->hand_over(engineering.handover(), engineering.log_handover());
  output.wait_again([&guard] {
    guard.waits_for_reader();
    return printing_takes_too_long();
  });

  show_faults();
  log.say_messages(resource);
  show_retain();
  show_recording();
  allocations.say_new(log);
  if (program->again() && stuck.empty() && signal_to_stop() == 0) return kExitRelaunch;
  print_events(resource, std::cerr);
  print_end({signal_to_stop(), duration_ns, run.cycles, last_fault ? &*last_fault : nullptr}, resource, scheduler,
            clock.now_ns() - plant.begin_ns(), talk);
  if (engineering.forces() != nullptr) print_forces(*engineering.forces(), talk);
  print_statistics(run, resource, scheduler, recording.get(), std::cout);
  if (run.stats == Stats::kText) {
    std::cout << '\n';
    if (const auto modbus = plant.machine().modbus_statistics()) print_modbus(*modbus, std::cout);
    if (const auto modbus = plant.machine().serial_statistics()) print_modbus(*modbus, std::cout);
    print_link_report(resource, std::cout);
    print_allocations(resource, std::cout);
    print_memory(std::cout);
  }
  if (!stuck.empty()) {
    for (const std::uint32_t task : stuck) {
      complain("plc-run", "task " + image.tasks[task].name + " does not end; its outputs are safe");
    }
    // WHY: it still uses what a return would destroy.
    log.stop();
    Output::flush();
    std::_Exit(io::kGuardianExit);
  }
  return run.stats == Stats::kJson ? output.end_document(end_code()) : end_code();
}

int run_command(int argc, char** argv) {
  const PassedSockets passed = take_passed_sockets();
  Relaunch::instance().keep_sockets(passed.count);
  EndGuard guard;  // outlives all that may wait for a disk
  Output output;
  const Program program(
      "plc-run",
      "Runs a PLC project in real time, one thread per task, until SIGINT, SIGTERM or SIGHUP; then outputs go to "
      "their safe state.\n"
      "\n"
      "Examples:\n"
      "  plc-run plant.xml                                  run until Ctrl-C\n"
      "  plc-run plant.pbc --duration 10s --watch 'Main.*'  ten seconds, with live values\n"
      "  plc-run plant.xml --cycles 1000 --stats            a thousand cycles of the fastest task, with histograms\n"
      "  plc-run plant.xml --duration 1h --stats=json > times.json    what the tasks needed, for scripts\n"
      "  pkill -USR1 -ox plc-run                            what they needed so far, on stderr; it goes on\n"
      "  plc-run plant.xml --stimulus in.csv                with inputs from a script\n"
      "  plc-run plant.xml --state state                    keeps RETAIN and PERSISTENT variables in this folder\n"
      "  plc-run plant.xml --config plc.toml                with the inputs and outputs of this machine\n"
      "  plc-run plant.xml --log json:plant.jsonl           messages as lines of JSON, in a file\n"
      "  plc-run --plant /etc/picard/plant                  as the service picard@plant does\n"
      "  plc-run plant.xml --modbus 0.0.0.0:502             HMIs of the network may connect (default: this machine's)\n"
      "\n"
      "SCHED_FIFO and locked memory need privileges: run as root, or as a service, picard@NAME.service with the plant "
      "in\n"
      "/etc/picard/NAME. Without them it runs, and says so.\n"
      "\n"
      "Exit codes: 0 all is well, or a signal ended what went on after faults; 1 the project has errors or a task "
      "faulted, 2 wrong flags or a file that cannot be opened, 3 the runtime died or hung and the guardian drove the "
      "safe values, or a task did not end, or a disk hung, 4 a device is missing or refused: another start may "
      "succeed.",
      kVersionText);
  Run run;
  const Flag file =
      program.option("FILE", run.file, "PLCopen XML or ST file, source folder, or image made by plc compile");
  program.option("--cycles=N", run.cycles, "stop after N scans of the fastest task").check(wrong_count);
  const Flag duration =
      program
          .option("--duration=T", run.duration,
                  "stop after this time: 500ms, 20s, 1h, a plain number is seconds; given twice, the last counts")
          .last();
  program.option("--stimulus=in.csv", run.stimulus, "inputs as CSV, as plc sim takes it; time 0 is the first cycle");
  program.flag("--repeat", run.repeat, "after its last row the stimulus begins again");
  program.option("--state=DIR", run.state,
                 "folder in which RETAIN and PERSISTENT variables are kept over a restart; made when it is not there");
  program.choice(
      "--start=HOW", run.start,
      {{"warm", retain::Start::kWarm}, {"cold", retain::Start::kCold}, {"origin", retain::Start::kOrigin}},
      "warm: RETAIN and PERSISTENT variables have the values that were kept (default); cold: PERSISTENT ones "
      "alone; origin: none, all begin with initial values");
  const Flag check = program.option("--check=IMAGE", run.check,
                                    "would this image run here in place of FILE? Says what is wrong, and ends before "
                                    "any device is touched");
  program.option("--record=DIR|off|check", run.record,
                 "what each scan takes in is kept for plc replay: the newest scans in memory, by default, and all in "
                 "files of DIR; "
                 "check also executes them again at once and says what differs");
  const Flag log_place = program.option(
      "--log=FORMAT[:FILE]", run.log,
      "where messages of the running plant go: text, json, or journal (that of systemd, with fields); text and json on "
      "stderr, or into a file that is renamed when it is large. Default: journal if stderr is that, else text");
  program.choice(
      "--log-level=LEVEL", run.log_level,
      {{"note", core::Severity::kNote}, {"warning", core::Severity::kWarning}, {"error", core::Severity::kError}},
      "leaves out messages that are less severe; default: note");
  const Flag configuration_flag =
      program
          .option("--config=plc.toml", run.configuration,
                  "drivers, channels, Modbus, guardian and libraries of this machine; plc config init writes one")
          .check(wrong_file_name);
  const Flag plant =
      program.option("--plant=DIR", run.plant,
                     "in place of FILE and --config: the folder with the one project and, where there is "
                     "one, its plc.toml, as /etc/picard/NAME of the service picard@NAME");
  plant.excludes({file, configuration_flag});
  program.flag("--simulate-io", run.simulate,
               "no device of the configuration is touched: outputs go nowhere, and inputs keep their initial values "
               "but for what HMIs and --stimulus write");
  const Flag modbus = program.option(
      "--modbus=ADDR:PORT|off", run.modbus,
      "where HMIs connect, in place of what the configuration says; default 127.0.0.1:502 if it can be had");
  const Flag engineering = program.option("--engineering=ADDR:PORT|off", run.engineering,
                                          "where browsers, scripts and plc remote connect, in place of what the "
                                          "configuration says; default 127.0.0.1:8061; "
                                          "other addresses with TLS");
  program
      .option("--watch=PATTERN", run.watch,
              "show these variables live, five times a second; * and ? match; may be repeated")
      .repeated();
  program.choice("--on-fault=POLICY", run.on_fault,
                 {{"continue", runtime::FaultPolicy::kContinue},
                  {"safe-state", runtime::FaultPolicy::kSafeState},
                  {"stop", runtime::FaultPolicy::kStop}},
                 "what a task fault does: continue, safe-state (the task stops, outputs go safe; default), stop");
  add_loop_budget(program, run.program);
  add_engine_option(program, run.engine);
  program.choice(
      "--stats{text}=[=json]", run.stats, {{"text", Stats::kText}, {"json", Stats::kJson}},
      "also print engines, histograms, memory and code sizes at the end; --stats=json prints the times as one JSON "
      "document on stdout, and all else on stderr");
  add_library_option(program, run.libraries);
  add_compile_options(program, run.options);
  if (const auto code = program.parse(argc, argv)) return *code;

  if (plant.given()) {
    const PlantFolder found = look_into_plant(run.plant);
    if (!found.wrong.empty()) return complain("plc-run", found.wrong, found.help), kExitUsage;
    run.file = found.project;
    run.configuration = found.configuration;
  } else if (!file.given()) {
    complain("plc-run", "FILE is required", "or --plant=DIR, a folder with a project; plc-run --help");
    return kExitUsage;
  }
  if (run.stats == Stats::kJson && !run.watch.empty()) {
    complain("plc-run", "--stats=json and --watch both want stdout", "omit one of them");
    return kExitUsage;
  }
  if (run.repeat && run.stimulus.empty())
    return complain("plc-run", "--repeat is for a stimulus", "--stimulus in.csv --repeat"), kExitUsage;
  if (modbus.given()) {
    run.listen = io::parse_listen(run.modbus);
    if (!run.listen) {
      complain("plc-run", "--modbus \"" + run.modbus + "\" is not an address and a port",
               "write 127.0.0.1:502, 0.0.0.0:502, [::1]:502 or off");
      return kExitUsage;
    }
  }
  if (engineering.given()) {
    run.engineering_listen = io::parse_listen(run.engineering);
    if (!run.engineering_listen) {
      complain("plc-run", "--engineering \"" + run.engineering + "\" is not an address and a port",
               "write 127.0.0.1:8061, 0.0.0.0:8061, [::1]:8061 or off");
      return kExitUsage;
    }
  }
  if (log_place.given()) {
    run.log_place = parse_log_place(run.log);
    if (!run.log_place) {
      complain("plc-run", "--log \"" + run.log + "\" is not a place for messages",
               "write text, json, journal, text:FILE or json:FILE");
      return kExitUsage;
    }
  }
  std::int64_t duration_ns = 0;
  if (duration.given()) {
    const auto parsed = parse_duration_ns(run.duration);
    if (!parsed || *parsed <= 0) {
      complain("plc-run", "--duration \"" + run.duration + "\" is not a duration", "write 500ms, 20s, 1.5min or 1h");
      return kExitUsage;
    }
    duration_ns = *parsed;
  }
  run.socket = passed.modbus;
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  core::Diagnostics diagnostics;
  if (run.options.show_all) diagnostics.show_all();
  const auto give_up = [&diagnostics](int code) {
    diagnostics.render_with_lines(std::cerr);
    return code;
  };
  std::optional<io::Configuration> configuration = io::Configuration{};
  if (!run.configuration.empty()) configuration = io::load_configuration(run.configuration, diagnostics);
  if (!configuration) {
    return give_up(diagnostics.all().front().code == core::Code::P7001 ? kExitUsage : kExitErrors);
  }
  if (check.given()) run.log_place = LogPlace{io::LogFormat::kText, {}};  // for who asked
  // What is said on the way leaves stdout to the document.
  RunLog log(*configuration, run.log_place, run.log_level, output, run.stats == Stats::kJson ? std::cerr : std::cout);
  for (const std::string& sentence : passed.unused) log.say(core::Severity::kWarning, sentence, "service");
  const core::TimeZone zone = core::TimeZone::load(configuration->clock.zone.text).value_or(core::TimeZone());
  run.program.zone = &zone;
  const taskblocks::Registry registry = load_taskblocks(*configuration, diagnostics);
  if (diagnostics.has_errors()) {
    return give_up(diagnostics.all().front().code == core::Code::P7001 ? kExitUsage : kExitErrors);
  }
  run.program.taskblocks = &registry;
  run.program.budget_clock = &clock;
  run.program.start_taskblocks = false;  // the guardian splits the process before
  const std::string folder = state_folder(run.state, *configuration, run.simulate);
  std::optional<ProgramStart> start;
  if (!check.given()) start.emplace(run.file, folder, log);
  const auto end_with = [&start](int code) { return start ? start->exit_code(code, signal_to_stop() != 0) : code; };
  if (start && start->problem()) return complain(*start->problem()), kExitErrors;
  std::unique_ptr<runtime::Resource> resource;
  std::optional<Plan> plan;
  {
    std::optional<bytecode::VerifiedImage> image;
    const std::string& in_place = start ? start->image_file() : run.check;
    const auto code = in_place.empty()
                          ? open_image(program, {run.file, run.options, run.libraries, run.configuration}, image)
                          : open_stored_image(in_place, image);
    if (code) return end_with(*code);
    plan = make_plan(run, std::move(*configuration), image->image(), diagnostics);
    if (!plan) return end_with(give_up(kExitErrors));
    for (const runtime::TaskPlan& task : plan->tasks) run.program.priorities.push_back(task.priority);
    auto loaded = runtime::Resource::load(std::move(*image), run.program);
    if (!loaded) {
      give_up(kExitErrors);
      complain(loaded.error());
      return end_with(kExitErrors);
    }
    resource = std::move(*loaded);
  }
  if (const auto problem = prepare_engine(*resource, run.engine, "plc-run")) {
    complain(*problem);
    return end_with(kExitErrors);
  }
  return end_with(run_resource(run, *resource, std::move(*plan), diagnostics, duration_ns, clock.now_ns() - begin,
                               output, log, start ? &*start : nullptr, folder, guard));
}

}  // namespace
}  // namespace plc::tools

int main(int argc, char** argv) {
  plc::runtime::set_stack_of_threads(plc::runtime::kThreadStackBytes);
  plc::tools::Relaunch& relaunch = plc::tools::Relaunch::instance();
  relaunch.begin(argc, argv);
  return relaunch.end(plc::tools::guarded("plc-run", plc::tools::run_command, argc, argv));
}
