#include "tools/plc-run/program_start.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tools/cli.h"
#include "tools/plc-run/relaunch.h"

namespace plc::tools {
namespace {

using Json = nlohmann::json;
using engineering::ProgramControl;
using engineering::StoredProgram;

constexpr std::size_t kMostErrors = 2000;
/// For an image to be looked at: compiled to machine code, and all of plc.toml beside it.
constexpr int kCheckSeconds = 60;
/// Between attempts on a disk that refuses.
constexpr std::chrono::seconds kKeepAgain{1};

std::string short_hash(const StoredProgram& program) { return program.image.substr(0, 8); }

std::string title_of(const StoredProgram& program) {
  if (program.by.empty()) return fmt::format("program {}", short_hash(program));
  return fmt::format("program {} that {} uploaded {:%Y-%m-%d %H:%M:%S} UTC", short_hash(program), program.by,
                     fmt::gmtime(static_cast<std::time_t>(program.utc_ns / 1'000'000'000)));
}

}  // namespace

KeptEnd::int_type KeptEnd::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  const char one = traits_type::to_char_type(character);
  return xsputn(&one, 1) == 1 ? character : traits_type::eof();
}

std::streamsize KeptEnd::xsputn(const char* text, std::streamsize count) {
  text_.append(text, static_cast<std::size_t>(count));
  if (text_.size() > 2 * kMostErrors) text_.erase(0, text_.size() - kMostErrors);
  return before_->sputn(text, count);
}

ProgramStart::ProgramStart(std::string given, const std::string& folder, RunLog& log)
    : given_(std::move(given)), log_(log) {
  if (const auto& handed = Relaunch::instance().handed_over()) {
    restarted_ = true;
    const Json json = Json::parse(*handed, nullptr, false);
    if (json.is_object()) {
      start_ = json.value("start", "");
      control_.starts = json.value("starts", std::uint64_t{0}) + 1;
      handed_stop_ns_ = json.value("stopped_ns", core::TimeNs{0});
      from_server_ = json.value("server", "");
      from_log_ = json.value("log", "");
      asked_by_ = json.value("by", "");
      failed_before_ = json.value("failed", false);
    }
  }
  if (!folder.empty()) choose(folder + "/program");
  control_.store = store_.get();
  control_.given_path = given_;
  control_.running = choice_.program;
  control_.check = [this](const std::string& file) { return check_image(file, control_.ending); };
  if (!choice_.trial) return;
  settled_ = false;
  control_.set_state(ProgramControl::State::kTrial);
  Relaunch::instance().set_trial(true);
  errors_ = std::make_unique<KeptEnd>(std::cerr);
  // Who is logged in stays so, whatever becomes of the program.
  hand_over(from_server_, from_log_);
}

ProgramStart::~ProgramStart() { end_keeping(); }

/// A disk that hangs holds up nothing but this thread.
void ProgramStart::start_keeping() {
  keep_ending_ = false;
  keeping_.start("plc-program", [this] {
    for (;;) {
      std::string why = choice_.trial ? store_->confirm(choice_.program.image) : store_->keep();
      const bool kept = why.empty();
      std::unique_lock lock(keep_mutex_);
      unkept_ = std::move(why);
      if (kept) settled_ = true;
      if (kept || keep_changed_.wait_for(lock, kKeepAgain, [this] { return keep_ending_; })) return;
    }
  });
}

void ProgramStart::end_keeping() {
  {
    const std::lock_guard lock(keep_mutex_);
    keep_ending_ = true;
  }
  keep_changed_.notify_all();
  keeping_.join();
}

void ProgramStart::say_unkept() {
  std::string why;
  {
    const std::lock_guard lock(keep_mutex_);
    why = unkept_;
  }
  if (why == unkept_said_) return;
  unkept_said_ = why;
  if (why.empty()) return log_.say(core::Severity::kNote, "program: it is kept now which one is to start", "program");
  log_.say(core::Severity::kWarning,
           fmt::format("program: {}: it is not kept which one is to start: {}; it is tried again",
                       core::info(core::Code::P7753).name, why),
           "program");
}

void ProgramStart::choose(const std::string& folder) {
  auto store = engineering::ProgramStore::open(folder);
  if (!store) {
    problem_ = store.error();
    return;
  }
  store_ = std::move(*store);
  // A start by hand or by a service is for what lies there now; one by a call is for what was uploaded.
  const std::string given = store_->given();
  const std::string now = given.empty() || restarted_ ? given : engineering::fingerprint_of(given_);
  const engineering::SameFile same =
      now.empty() ? engineering::SameFile::kYes : engineering::compare_fingerprints(given, now);
  if (same == engineering::SameFile::kUnknown) {
    const std::string why = store_->note_given(now);
    log_.say(
        core::Severity::kWarning,
        fmt::format("program: whether {} has changed since a program was uploaded is not known, as another version "
                    "of plc-run has noted it: what was uploaded goes on. If {} is to run: delete the folder {}{}",
                    given_, given_, folder, why.empty() ? "" : " (" + why + ")"));
  }
  if (same == engineering::SameFile::kNo) {
    const std::string why = store_->forget();
    log_.say(
        core::Severity::kWarning,
        fmt::format("program: {} is another one than when a program was uploaded: it runs, and what was uploaded is "
                    "forgotten{}",
                    given_, why.empty() ? "" : " (" + why + ")"));
    return;
  }
  const auto failed_before = store_->failed();
  auto choice = store_->choose(calendar_.utc_ns());
  if (!choice) {
    problem_ = choice.error();
    return;
  }
  if (const auto failed = store_->failed(); failed && (!failed_before || failed->program != failed_before->program)) {
    log_.say(core::Severity::kWarning,
             fmt::format("program: {}: {} does not start: {}", core::info(core::Code::P7752).name,
                         title_of(failed->program), failed->why));
    failed_before_ = true;
  }
  if (!*choice) return;
  choice_ = std::move(**choice);
  if (!choice_.start.empty()) start_ = choice_.start;
  log_.talk() << fmt::format("program: {}, in place of {}\n", title(), given_);
}

std::string ProgramStart::title() const { return choice_.file.empty() ? given_ : title_of(choice_.program); }

std::optional<retain::Start> ProgramStart::start() const {
  if (start_ == "warm") return retain::Start::kWarm;
  if (start_ == "cold") return retain::Start::kCold;
  return std::nullopt;
}

void ProgramStart::runs(core::TimeNs begin_ns) {
  begin_ns_ = begin_ns;
  // Not before: the guardian splits the process while it has one thread.
  if (store_ && !choice_.trial && store_->has_unkept()) start_keeping();
  if (handed_stop_ns_ == 0) return;
  const core::TimeNs stood_ns = begin_ns - handed_stop_ns_;
  control_.stood_ns = stood_ns;
  log_.talk() << fmt::format("program: control stood for {} ms\n", stood_ns / 1'000'000);
}

bool ProgramStart::often(core::TimeNs now_ns, const std::string& fault) {
  if (control_.state() == ProgramControl::State::kTrial) {
    if (!fault.empty()) {
      fail(fault);
      return true;
    }
    if (now_ns - begin_ns_ >= kTrialNs) {
      errors_.reset();
      Relaunch::instance().set_trial(false);
      control_.set_state(ProgramControl::State::kRuns);
      start_keeping();
      log_.talk() << fmt::format("program: {} is the one to start from now on\n", short_hash(choice_.program));
    }
  }
  say_unkept();
  const auto wish = control_.take(now_ns);
  if (wish) take(*wish);
  return wish.has_value();
}

void ProgramStart::take(const ProgramControl::Wish& wish) {
  again_ = wish.start;
  halts_ = !wish.start;
  next_start_ = wish.kind;
  {
    const std::lock_guard lock(hand_over_mutex_);
    asked_by_ = wish.by;
  }
  log_.say(core::Severity::kNote,
           wish.start ? fmt::format("program: {} start, by {}", wish.kind, wish.by)
                      : fmt::format("program: stopped by {}; outputs are in their safe state", wish.by),
           "engineering");
  // The process that follows is to know it.
  if (wish.start && !settled_ && !keeping_.joinable()) start_keeping();
}

void ProgramStart::fail(const std::string& why) {
  control_.set_state(ProgramControl::State::kEnds);
  control_.ending = true;
  {
    const std::lock_guard lock(hand_over_mutex_);
    failed_ = true;
  }
  const std::string unkept = store_->fail(choice_.program.image, why, calendar_.utc_ns());
  log_.say(core::Severity::kWarning, fmt::format("program: {}: {} does not start: {}; the one before starts again{}",
                                                 core::info(core::Code::P7752).name, title_of(choice_.program), why,
                                                 unkept.empty() ? "" : " (" + unkept + ")"));
  again_ = true;
}

bool ProgramStart::ended(core::TimeNs stop_ns) {
  stopped_ns_ = stop_ns;
  if (halts_) control_.set_state(ProgramControl::State::kStopped);
  return halts_;
}

bool ProgramStart::wants_start(core::TimeNs now_ns) {
  const auto wish = control_.take(now_ns);
  if (wish) take(*wish);
  return again_;
}

void ProgramStart::pass_on(const std::string& kind, core::TimeNs stopped_ns, const std::string& from_server,
                           const std::string& from_log) const {
  const Json json = {{"start", kind},     {"starts", control_.starts}, {"stopped_ns", stopped_ns}, {"by", asked_by_},
                     {"failed", failed_}, {"server", from_server},     {"log", from_log}};
  Relaunch::instance().hand_over(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void ProgramStart::hand_over(const std::string& from_server, const std::string& from_log) {
  const std::lock_guard lock(hand_over_mutex_);
  pass_on(next_start_, halts_ ? 0 : stopped_ns_, from_server, from_log);
}

void ProgramStart::hand_over_on_trial(std::string from_server) {
  const std::lock_guard lock(hand_over_mutex_);
  // Afterwards the process that dies is not started anew by this one.
  if (!Relaunch::instance().on_trial()) return;
  from_server_ = std::move(from_server);
  pass_on({}, 0, from_server_, from_log_);
}

int ProgramStart::exit_code(int code, bool asked) {
  if (asked) return code;
  if (again_) return kExitRelaunch;
  if (control_.state() != ProgramControl::State::kTrial || code == kExitOk) return code;
  std::string why = errors_->text().substr(errors_->text().size() - std::min(errors_->text().size(), kMostErrors));
  while (!why.empty() && (why.back() == '\n' || why.back() == ' ')) why.pop_back();
  fail(why.empty() ? fmt::format("exit code {}", code) : why);
  stopped_ns_ = handed_stop_ns_;  // control stands since then
  hand_over(from_server_, from_log_);
  return kExitRelaunch;
}

std::string check_image(const std::string& file, const std::atomic<bool>& ending) {
  std::vector<std::string> words = Relaunch::instance().arguments();
  const std::string program = Relaunch::own_path();
  words.insert(words.begin() + 1, "--check=" + file);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int said = ::memfd_create("picard-check", MFD_CLOEXEC);
  if (said < 0) return std::string("no memory to look at it: ") + std::strerror(errno);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", 0, 0);
  posix_spawn_file_actions_adddup2(&actions, said, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, said, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int refused = ::posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  std::string wrong;
  if (refused != 0) {
    wrong = fmt::format("{} cannot be run to look at it: {}", program, std::strerror(refused));
  } else {
    int status = 0;
    core::MonotonicClock clock;
    const core::TimeNs until = clock.now_ns() + kCheckSeconds * core::TimeNs{1'000'000'000};
    pid_t ended = 0;
    while ((ended = ::waitpid(child, &status, WNOHANG)) == 0) {
      if (clock.now_ns() > until || ending) ::kill(child, SIGKILL);
      clock.sleep_until_ns(clock.now_ns() + 2'000'000);
    }
    if (ended < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != kExitOk) {
      std::array<char, kMostErrors> text{};
      const ssize_t got = ::pread(said, text.data(), text.size(), 0);
      wrong.assign(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
      while (!wrong.empty() && (wrong.back() == '\n' || wrong.back() == ' ')) wrong.pop_back();
      if (wrong.empty())
        wrong =
            WIFSIGNALED(status) ? fmt::format("looking at it ended by signal {}", WTERMSIG(status)) : "it cannot run";
    }
  }
  ::close(said);
  return wrong;
}

}  // namespace plc::tools
