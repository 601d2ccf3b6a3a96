// Files: what plc.toml, the project and its libraries say; the state folder and what is stored in it.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <system_error>

#include "doctor/check.h"
#include "retain/layout.h"
#include "retain/store.h"

namespace plc::doctor {
namespace {

/// Errors that reading found in libraries of taskblocks, or in all else.
Outcome reported(const Context& c, bool libraries) {
  constexpr std::size_t kMost = 10;
  Outcome outcome;
  const core::Diagnostics& diagnostics = c.subject.diagnostics;
  for (const core::Diagnostic& problem : diagnostics.all()) {
    if ((problem.code == core::Code::P7801) != libraries || problem.severity != core::Severity::kError) continue;
    if (outcome.found.size() == kMost) break;
    std::string text;
    if (problem.at.file < diagnostics.file_count() && problem.at.line != 0) {
      text = fmt::format("{}:{}:{}: ", diagnostics.file_name(problem.at.file), problem.at.line, problem.at.column);
    }
    outcome.found.push_back({text + problem.message, problem.help, problem.code, {}});
  }
  return outcome;
}

/// Folder of retained values, as plc-run chooses it; empty: none.
std::string state_folder(const Context& c) {
  if (!c.subject.state.empty()) return c.subject.state;
  const std::string& named = c.subject.configuration.retain.state.text;
  if (!named.empty()) return c.system.named(c.subject.configuration, named);
  const std::string folders = c.process.environment("STATE_DIRECTORY");
  return folders.substr(0, folders.find(':'));
}

/// The nearest folder at or above that exists.
std::string existing(const Context& c, const std::string& folder) {
  std::filesystem::path path = folder;
  while (!c.system.facts(path.string()) && path.has_parent_path() && path != path.parent_path())
    path = path.parent_path();
  return c.system.facts(path.string()) ? path.string() : folder.starts_with('/') ? "/" : ".";
}

/// What there is to say when files in the folder are not looked at. WHY: a server that does not answer would keep the
/// doctor waiting.
std::optional<Outcome> without_folder(const Context& c, const std::string& folder) {
  if (folder.empty()) return fine("no state folder");
  const auto mount = c.process.mount_of(std::filesystem::absolute(folder).lexically_normal().string());
  for (const char* const type : {"nfs", "nfs4", "cifs", "smb3", "fuse.sshfs", "ceph", "9p", "autofs"}) {
    if (mount && mount->type == type) return unknown(fmt::format("{} is on a network file system ({})", folder, type));
  }
  return std::nullopt;
}

std::string stored_file(const Context& c) {
  return (std::filesystem::path(state_folder(c)) / retain::kFileName).string();
}

}  // namespace

Outcome check_project_files(const Context& c) {
  Outcome outcome = reported(c, false);
  if (!outcome.found.empty()) return outcome;
  std::vector<std::string> files;
  for (const std::string& file : {c.subject.configuration_file, c.subject.project_file}) {
    if (!file.empty()) files.push_back(file);
  }
  return fine(files.empty() ? "none given" : joined(files));
}

Outcome check_taskblock_libraries(const Context& c) {
  Outcome outcome = reported(c, true);
  if (!outcome.found.empty()) return outcome;
  const io::Configuration& configuration = c.subject.configuration;
  for (const io::Placed& library : configuration.taskblocks.libraries) {
    const std::string file = c.system.named(configuration, library.text);
    if (c.system.facts(file)) continue;
    outcome.found.push_back({file + " is not there", "relative paths begin at the folder of plc.toml", {}, {}});
  }
  const std::size_t count = configuration.taskblocks.libraries.size();
  outcome.seen = count == 0 ? "plc.toml names none" : fmt::format("{} can be used", count);
  return outcome;
}

Outcome check_writers(const Context& c) {
  std::vector<std::string> files;
  if (!c.subject.configuration_file.empty()) files.push_back(c.subject.configuration_file);
  if (!c.subject.project_file.empty()) files.push_back(c.subject.project_file);
  std::vector<std::string> open;
  for (const std::string& file : files) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(file, ignored);
    if (!std::filesystem::exists(status)) continue;  // its permissions would be all of them
    if ((status.permissions() & std::filesystem::perms::others_write) != std::filesystem::perms::none) {
      open.push_back(file);
    }
  }
  if (open.empty()) return fine(files.empty() ? "none given" : "nobody but owner and group may write");
  return wrong("every user may write " + joined(open), "`chmod o-w " + open[0] + "`");
}

Outcome check_retain_asked(const Context& c) {
  if (!state_folder(c).empty()) return fine(state_folder(c));
  if (c.subject.resource == nullptr) return fine("no state folder, and no project that needs one");
  std::size_t count = 0;
  for (const retain::Root& root : retain::find_kept(*c.subject.resource).layout.roots) count += root.internal ? 0 : 1;
  if (count == 0) return fine("the project has no retained variables");
  return wrong(fmt::format("the project has {} retained variables, and no folder to keep them in", count),
               "state = \"/var/lib/picard/PLANT\" under [retain] in plc.toml, or StateDirectory= in the service");
}

Outcome check_state_folder(const Context& c) {
  const std::string folder = state_folder(c);
  if (auto outcome = without_folder(c, folder)) return *outcome;
  const std::string at = existing(c, folder);
  const auto facts = c.system.facts(at);
  if (!facts) return unknown(folder + ": nothing above it is there");
  const char* const help = "`chown` it to the user of plc-run, or let the service make it: StateDirectory=";
  if (!S_ISDIR(facts->mode)) return wrong(at + " is no folder", "give another one as `state` under [retain]");
  const auto space = c.system.space(at);
  const auto mount = c.process.mount_of(std::filesystem::absolute(at).lexically_normal().string());
  const bool read_only =
      (space && space->read_only) || (mount && ("," + mount->options + ",").find(",ro,") != std::string::npos);
  if (read_only) {
    return wrong(at + " is on a file system that is mounted read-only",
                 "mount one that can be written, or ReadWritePaths= and StateDirectory= in the service");
  }
  if (!c.process.may(3, *facts)) {
    return wrong(fmt::format("user {} may not write {}, which is of user {} (mode {:04o})", c.process.user(), at,
                             facts->owner, facts->mode & 07777),
                 help);
  }
  const std::string file = stored_file(c);
  const auto stored = c.system.facts(file);
  if (stored && !c.process.may(6, *stored)) {
    return wrong(fmt::format("user {} may not write {}, which is of user {}", c.process.user(), file, stored->owner),
                 help);
  }
  return fine(at == folder ? folder : folder + " will be made");
}

Outcome check_state_file_system(const Context& c) {
  const std::string folder = state_folder(c);
  if (folder.empty()) return fine("no state folder");
  const auto mount = c.process.mount_of(std::filesystem::absolute(folder).lexically_normal().string());
  if (!mount) return unknown("file systems of the machine are not known");
  for (const char* const type : {"tmpfs", "ramfs", "overlay", "rootfs"}) {
    if (mount->type != type) continue;
    return wrong(fmt::format("{} is on {}: what is retained is lost with the {}", folder, type,
                             mount->type == "overlay" ? "container" : "power"),
                 "name a folder on a disk, or a volume of the container");
  }
  return fine(mount->type);
}

Outcome check_disk(const Context& c) {
  constexpr std::uint64_t kEnough = std::uint64_t{64} << 20, kNothing = std::uint64_t{1} << 20;
  const std::string folder = state_folder(c).empty() ? "/var/lib" : state_folder(c);
  if (auto outcome = without_folder(c, folder)) return *outcome;
  const std::string at = existing(c, folder);
  const auto space = c.system.space(at);
  if (!space) return unknown("needs the machine itself");
  if (space->free_bytes >= kEnough && space->free_files >= 100) {
    return fine(fmt::format("{} MiB free at {}", space->free_bytes >> 20, at));
  }
  Outcome outcome =
      wrong(space->free_bytes < kEnough ? fmt::format("{} KiB are free at {}", space->free_bytes >> 10, at)
                                        : fmt::format("{} more files can be made at {}", space->free_files, at),
            "`du -xh --max-depth=2 / | sort -h` shows what fills it; journald: SystemMaxUse= in journald.conf");
  if (space->free_bytes < kNothing) outcome.found[0].severity = core::Severity::kError;
  return outcome;
}

Outcome check_state_in_use(const Context& c) {
  const std::string folder = state_folder(c);
  if (auto outcome = without_folder(c, folder)) return *outcome;
  const auto facts = c.system.facts(folder);
  if (!facts) return fine("not there yet");
  const auto locks = c.system.read("/proc/locks");
  if (!locks) return missing("/proc/locks");
  const std::string place = fmt::format("{:02x}:{:02x}:{}", facts->device_major, facts->device_minor, facts->inode);
  for (const std::string_view line : lines_of(*locks)) {
    // "1: FLOCK  ADVISORY  WRITE 1234 fe:00:131 0 EOF"
    const auto words = words_of(line);
    if (words.size() < 6 || words[1] != "FLOCK" || words[5] != place) continue;
    return wrong(fmt::format("process {} stores in {}", words[4], folder),
                 "right while that plc-run is the one that should run; a second one needs a folder of its own");
  }
  return fine("no");
}

Outcome check_stored(const Context& c) {
  if (auto outcome = without_folder(c, state_folder(c))) return *outcome;
  const std::string file = stored_file(c);
  if (!c.system.facts(file)) return fine("nothing stored yet");
  const auto stored = retain::read_file(c.system.real(file));
  if (stored) {
    return fine(fmt::format("set {} of {:%Y-%m-%d %H:%M:%S} UTC", stored->sequence,
                            fmt::gmtime(static_cast<std::time_t>(stored->time_of_day_ns / 1'000'000'000))));
  }
  Outcome outcome;
  outcome.found.push_back({stored.error().message, stored.error().help, stored.error().code, {}});
  return outcome;
}

Outcome check_stored_project(const Context& c) {
  if (auto outcome = without_folder(c, state_folder(c))) return *outcome;
  if (c.subject.resource == nullptr) return unknown("needs a project");
  const std::string file = stored_file(c);
  if (!c.system.facts(file)) return fine("nothing stored yet");
  const auto stored = retain::read_file(c.system.real(file));
  if (!stored) return unknown("the file cannot be read");
  const std::string& project = c.subject.resource->image().project;
  if (stored->layout.project == project) return fine(project);
  return wrong(fmt::format("{} is of project {}, not of {}", file, stored->layout.project, project),
               "name another folder as `state`; variables of equal names would get the other project's values");
}

}  // namespace plc::doctor
