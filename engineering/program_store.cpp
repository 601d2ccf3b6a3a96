#include "engineering/program_store.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/text.h"
#include "engineering/call.h"
#include "engineering/secrets.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

namespace fs = std::filesystem;
using core::Code;
using core::Problem;

/// Of source files, as sources/folder.h reads them; and what lists them.
constexpr std::array<std::string_view, 9> kSources = {".plcproj", ".TcPOU", ".TcGVL", ".TcDUT", ".TcIO",
                                                      ".TcTTO",   ".st",    ".iecst", ".exp"};
constexpr const char* kImage = ".pbc";
constexpr const char* kProject = ".project";
/// What fingerprints begin with.
constexpr std::string_view kOfFile = "file:";
constexpr std::string_view kOfSources = "sources:";
/// An image that is being looked at.
constexpr const char* kChecked = "checked";

Json json_of(const StoredProgram& program) {
  return {{"image", program.image}, {"project", program.project}, {"by", program.by}, {"utc_ns", program.utc_ns}};
}

/// Throws what nlohmann throws.
StoredProgram program_of(const Json& json) {
  StoredProgram program{json.at("image").get<std::string>(), json.at("project").get<std::string>(),
                        json.at("by").get<std::string>(), json.at("utc_ns").get<core::TimeNs>()};
  // It becomes the name of a file.
  if (program.image.size() != 64 || program.image.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw std::invalid_argument("an image that is no hash");
  }
  return program;
}

std::optional<StoredProgram> program_at(const Json& json, const char* name) {
  return json.contains(name) ? std::optional(program_of(json.at(name))) : std::nullopt;
}

Problem not_kept(std::string why) {
  return {Code::P7753, std::move(why),
          "the folder of the state must be writable for the user of plc-run, with room for images"};
}

Problem nothing_waits() {
  return {Code::P7755, "no program was uploaded that waits for its start", "plc remote URL upload FILE"};
}

}  // namespace

core::Result<std::unique_ptr<ProgramStore>> ProgramStore::open(std::string folder) {
  std::unique_ptr<ProgramStore> store(new ProgramStore(std::move(folder)));
  if (const std::string why = store->read(); !why.empty()) {
    return Problem{Code::P7753, why, "delete the folder " + store->folder_ + " to run FILE again"};
  }
  return store;
}

std::string ProgramStore::read() {
  std::string why;
  const auto text = read_whole_file(folder_ + "/chosen.json", why);
  if (!text) return why;
  const Json json = Json::parse(*text, nullptr, false);
  try {
    chosen_.given = json.at("given").get<std::string>();
    chosen_.runs = program_at(json, "runs");
    chosen_.waits = program_at(json, "waits");
    chosen_.trial = program_at(json, "trial");
    chosen_.start = json.at("start").get<std::string>();
    chosen_.tried = json.at("tried").get<bool>();
    if (json.contains("failed")) {
      const Json& failed = json.at("failed");
      chosen_.failed = {program_of(failed.at("program")), failed.at("why").get<std::string>(),
                        failed.at("utc_ns").get<core::TimeNs>()};
    }
  } catch (const std::exception&) {
    return folder_ + "/chosen.json is damaged";
  }
  return {};
}

std::string ProgramStore::replace(Chosen next) {
  Json json = {{"given", next.given}, {"start", next.start}, {"tried", next.tried}};
  if (next.runs) json["runs"] = json_of(*next.runs);
  if (next.waits) json["waits"] = json_of(*next.waits);
  if (next.trial) json["trial"] = json_of(*next.trial);
  if (next.failed) {
    json["failed"] = {
        {"program", json_of(next.failed->program)}, {"why", next.failed->why}, {"utc_ns", next.failed->utc_ns}};
  }
  if (std::string why = make_private_folder(folder_); !why.empty()) return why;
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  if (std::string why = write_private_file(folder_ + "/chosen.json", text); !why.empty()) return why;
  chosen_ = std::move(next);
  unkept_ = false;
  sweep();
  return {};
}

/// Files that nothing names any more.
void ProgramStore::sweep() const {
  std::error_code error;
  for (fs::directory_iterator file(folder_, error), end; !error && file != end; file.increment(error)) {
    const std::string extension = file->path().extension().string();
    if (extension != kImage && extension != kProject && extension != ".new") continue;
    const std::string hash = file->path().stem().string();
    if (hash.starts_with(kChecked)) continue;  // an upload that is under way, on another thread
    const auto is = [&](const std::optional<StoredProgram>& program) {
      return program && program->image == hash && (extension == kImage || !program->project.empty());
    };
    std::error_code ignored;
    if (!is(chosen_.runs) && !is(chosen_.waits) && !is(chosen_.trial)) fs::remove(file->path(), ignored);
  }
}

core::Result<std::optional<ProgramStore::Choice>> ProgramStore::choose(core::TimeNs utc_ns) {
  const std::lock_guard lock(mutex_);
  if (chosen_.trial && chosen_.tried) give_up("it ended before it had run for a second", utc_ns);
  if (chosen_.trial) {
    std::string why = damage_of(*chosen_.trial);
    if (why.empty()) {
      // WHY first: what is tried without that being on the disk would be tried again after each loss of power.
      Chosen next = chosen_;
      next.tried = true;
      why = replace(std::move(next));
    }
    if (why.empty()) return std::optional(Choice{*chosen_.trial, image_file(*chosen_.trial), chosen_.start, true});
    give_up("it was not tried: " + why, utc_ns);
  }
  if (!chosen_.runs) return std::optional<Choice>();
  if (std::string why = damage_of(*chosen_.runs); !why.empty())
    return Problem{Code::P7753, std::move(why), "delete the folder " + folder_ + " to run FILE again"};
  return std::optional(Choice{*chosen_.runs, image_file(*chosen_.runs), {}, false});
}

void ProgramStore::give_up(std::string why, core::TimeNs utc_ns) {
  Chosen next = chosen_;
  next.failed = FailedStart{*chosen_.trial, std::move(why), utc_ns};
  next.trial.reset();
  next.tried = false;
  if (replace(next).empty()) return;
  chosen_ = std::move(next);
  unkept_ = true;
}

bool ProgramStore::tries(std::string_view image) const {
  return chosen_.tried && chosen_.trial && chosen_.trial->image == image;
}

std::string ProgramStore::damage_of(const StoredProgram& program) const {
  const std::string file = image_file(program);
  std::string why;
  const auto bytes = read_whole_file(file, why);
  if (!bytes) return why.empty() ? "there is no file " + file : why;
  return sha256(*bytes) == program.image ? std::string() : file + " is damaged";
}

bool ProgramStore::has_unkept() const {
  const std::lock_guard lock(mutex_);
  return unkept_;
}

std::string ProgramStore::keep() {
  const std::lock_guard lock(mutex_);
  return unkept_ ? replace(chosen_) : std::string();
}

std::string ProgramStore::confirm(std::string_view image) {
  const std::lock_guard lock(mutex_);
  if (!tries(image)) return {};
  Chosen next = chosen_;
  next.runs = std::exchange(next.trial, std::nullopt);
  next.failed.reset();
  return replace(std::move(next));
}

std::string ProgramStore::fail(std::string_view image, std::string why, core::TimeNs utc_ns) {
  const std::lock_guard lock(mutex_);
  if (!tries(image)) return {};
  Chosen next = chosen_;
  next.failed = FailedStart{*chosen_.trial, std::move(why), utc_ns};
  next.trial.reset();
  return replace(std::move(next));
}

std::string ProgramStore::forget() {
  const std::lock_guard lock(mutex_);
  return replace({});
}

core::Result<StoredProgram> ProgramStore::put(std::string_view image, std::string by, core::TimeNs utc_ns,
                                              const std::function<std::string(const std::string& file)>& check) {
  StoredProgram program{sha256(image), {}, std::move(by), utc_ns};
  // Under a name of its own until it is known to be good.
  const std::string seen = folder_ + "/" + kChecked + kImage;
  if (std::string why = make_private_folder(folder_); !why.empty()) return not_kept(std::move(why));
  if (std::string why = write_private_file(seen, image); !why.empty()) return not_kept(std::move(why));
  std::string wrong = check(seen);
  const std::lock_guard lock(mutex_);
  if (!wrong.empty()) {
    std::error_code ignored;
    fs::remove(seen, ignored);
    return Problem{Code::P7750, std::move(wrong), "plc-run --check IMAGE, with the flags of this plant, says the same"};
  }
  std::error_code error;
  fs::rename(seen, image_file(program), error);  // on the disk for good with chosen.json, which comes after it
  if (error) return not_kept(fmt::format("cannot write {}: {}", image_file(program), error.message()));
  Chosen next = chosen_;
  next.waits = program;
  if (std::string why = replace(std::move(next)); !why.empty()) return not_kept(std::move(why));
  return program;
}

core::Result<StoredProgram> ProgramStore::put_project(std::string_view bytes, std::string name) {
  const std::lock_guard lock(mutex_);
  if (!chosen_.waits) return nothing_waits();
  Chosen next = chosen_;
  next.waits->project = std::move(name);
  if (std::string why = write_private_file(project_file(*next.waits), bytes); !why.empty())
    return not_kept(std::move(why));
  if (std::string why = replace(std::move(next)); !why.empty()) return not_kept(std::move(why));
  return *chosen_.waits;
}

std::optional<Problem> ProgramStore::try_next(std::string_view image, std::string start, StoredProgram running,
                                              std::string_view running_image, std::string given) {
  const std::lock_guard lock(mutex_);
  if (!chosen_.waits) return nothing_waits();
  // Uploads come on another thread.
  if (chosen_.waits->image != image) return Problem{Code::P7755, "another program was uploaded just now", {}};
  Chosen next = chosen_;
  if (!next.runs || next.runs->image != running.image) {
    // FILE may be another one by the time at which this one is wanted back.
    if (std::string why = write_private_file(image_file(running), running_image); !why.empty())
      return not_kept(std::move(why));
    next.runs = std::move(running);
  }
  next.given = std::move(given);
  next.trial = std::exchange(next.waits, std::nullopt);
  next.start = std::move(start);
  next.tried = false;
  next.failed.reset();
  if (std::string why = replace(std::move(next)); !why.empty()) return not_kept(std::move(why));
  return std::nullopt;
}

void ProgramStore::wait_again() {
  const std::lock_guard lock(mutex_);
  if (!chosen_.trial || chosen_.tried) return;
  Chosen next = chosen_;
  const auto trial = std::exchange(next.trial, std::nullopt);
  if (!next.waits) next.waits = trial;  // else another one was uploaded meanwhile
  static_cast<void>(replace(std::move(next)));
}

std::optional<StoredProgram> ProgramStore::waiting() const {
  const std::lock_guard lock(mutex_);
  return chosen_.waits;
}

std::optional<FailedStart> ProgramStore::failed() const {
  const std::lock_guard lock(mutex_);
  return chosen_.failed;
}

std::string ProgramStore::given() const {
  const std::lock_guard lock(mutex_);
  return chosen_.runs || chosen_.trial ? chosen_.given : std::string();
}

std::string ProgramStore::note_given(std::string given) {
  const std::lock_guard lock(mutex_);
  Chosen next = chosen_;
  next.given = std::move(given);
  return replace(std::move(next));
}

std::string ProgramStore::image_file(const StoredProgram& program) const {
  return folder_ + "/" + program.image + kImage;
}

std::string ProgramStore::project_file(const StoredProgram& program) const {
  return folder_ + "/" + program.image + kProject;
}

namespace {

bool has_extension(std::string_view path, std::string_view extension) {
  return path.size() > extension.size() && core::iequals(path.substr(path.size() - extension.size()), extension);
}

/// Of the source files below `folder`: their paths from there and their contents.
std::string fingerprint_of_folder(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (it->path().filename().string().starts_with('.')) {
      if (it->is_directory(ignored)) it.disable_recursion_pending();
      continue;
    }
    const std::string name = it->path().lexically_relative(folder).generic_string();
    const bool wanted = std::any_of(kSources.begin(), kSources.end(),
                                    [&](std::string_view extension) { return has_extension(name, extension); });
    if (wanted && it->is_regular_file(ignored)) names.push_back(name);
  }
  if (error) return {};
  std::sort(names.begin(), names.end());
  std::string all;
  for (const std::string& name : names) {
    const std::string hash = sha256_of_file((folder / name).string());
    if (hash.empty()) return {};
    all += name + '\0' + hash + '\n';
  }
  return std::string(kOfSources) + sha256(all);
}

}  // namespace

std::string fingerprint_of(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return fingerprint_of_folder(path);
  if (has_extension(path, ".plcproj")) {
    const fs::path folder = fs::path(path).parent_path();
    return fingerprint_of_folder(folder.empty() ? "." : folder);
  }
  const std::string hash = sha256_of_file(path);
  return hash.empty() ? hash : std::string(kOfFile) + hash;
}

SameFile compare_fingerprints(std::string_view kept, std::string_view now) {
  if (kept == now) return SameFile::kYes;
  if (kept.find(':') != std::string_view::npos) return SameFile::kNo;
  // Of before there were prefixes: the hash of a file, or that of an archive of all that lay in a folder.
  if (now.starts_with(kOfSources)) return SameFile::kUnknown;
  return now == std::string(kOfFile) + std::string(kept) ? SameFile::kYes : SameFile::kNo;
}

}  // namespace plc::engineering
