// The program that runs: calls of the subject "program".
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/program_json.h"
#include "engineering/subjects.h"
#include "engineering/tar.h"

namespace plc::engineering {
namespace {

using namespace field;
namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 64'000'000;

constexpr Field kProgramAnswer[] = {
    text("project", "Name of the project, as it calls itself"),
    text("compiler", "That has made the image"),
    text("options", "With which it was compiled, in words"),
    text("image", "SHA-256 of the image that runs"),
    texts("tasks", "Names of the tasks"),
    texts("files", "Files of the project, as the compiler was told"),
    text("file", "Name under which program.project gives the project; empty: none was stored with the image"),
    choice(
        "state", "runs|trial|stopped|ends",
        "runs; trial: for its first second, after program.start; stopped: by program.stop; ends: another one starts"),
    integer("starts", "By program.start, since plc-run was started by hand or as a service"),
    integer("stood_ms", "Control stood for so long before this program; 0: plc-run began with it"),
    optional(record("uploaded", kStoredProgram,
                    "The program that runs was uploaded; without: it is what plc-run was given")),
    optional(record("waits", kStoredProgram, "Uploaded, and to be started")),
    optional(record("failed", kFailedStart, "The last program that was to start and did not")),
};

/// Of the project that belongs to the image that runs.
std::string file_name(const Context& context) {
  const Identity& identity = context.identity;
  if (context.program != nullptr && !context.program->running.by.empty()) return context.program->running.project;
  std::error_code error;
  fs::path path(identity.project_path);
  if (!path.has_filename()) path = path.parent_path();
  const std::string name = path.filename().string();
  return fs::is_directory(identity.project_path, error) ? name + ".tar" : name;
}

void program(Context& context, const Caller&, const Json&, Answer& answer) {
  const bytecode::Image& image = context.variables.image();
  Json& body = answer.body();
  body["project"] = image.project;
  body["compiler"] = image.product;
  body["options"] = context.identity.options;
  body["image"] = context.identity.image_hash;
  Json& tasks = body["tasks"] = Json::array();
  for (const bytecode::ImageTask& task : image.tasks) tasks.push_back(task.name);
  body["files"] = image.files;
  body["file"] = file_name(context);
  const ProgramControl* const control = context.program;
  body["state"] = control == nullptr ? "runs" : word_of(control->state());
  body["starts"] = control == nullptr ? 0 : control->starts;
  body["stood_ms"] = control == nullptr ? 0 : control->stood_ns / 1'000'000;
  if (control == nullptr) return;
  if (!control->running.by.empty()) body["uploaded"] = program_json(control->running);
  if (control->store == nullptr) return;
  if (const auto waits = control->store->waiting()) body["waits"] = program_json(*waits);
  if (const auto failed = control->store->failed()) {
    body["failed"] = failed_json(*failed);
  }
}

void project(Context& context, const Caller& caller, const Json&, Answer& answer) {
  std::string path = context.identity.project_path;
  const std::string name = file_name(context);
  if (const ProgramControl* const control = context.program; control != nullptr && !control->running.by.empty()) {
    if (name.empty()) {
      return answer.refuse(404, core::Code::P7755, "no project was stored with the image that runs", {},
                           "program.store_project does that before program.start");
    }
    path = control->store->project_file(control->running);
  }
  std::error_code error;
  std::string bytes;
  if (fs::is_directory(path, error)) {
    // The state folder may lie in it, or be it, with the users; and the key of the certificate.
    const std::string state = context.folder.empty() ? std::string() : fs::path(context.folder).parent_path().string();
    auto archive = tar_of(path, kMostBytes, {state, context.folder, context.key});
    if (!archive) return answer.refuse(archive.error());
    bytes = std::move(*archive);
  } else {
    std::ifstream in(path, std::ios::binary);
    if (!in || fs::file_size(path, error) > kMostBytes) {
      return answer.refuse(404, core::Code::P7001, "the project's file cannot be read any more, or is too large");
    }
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  context.audit.add(caller.user, caller.address, "program.project", {{"bytes", bytes.size()}});
  answer.give_file(std::move(bytes), name);
}

void image(Context& context, const Caller& caller, const Json&, Answer& answer) {
  const std::vector<std::byte> bytes = bytecode::save(context.variables.image());
  context.audit.add(caller.user, caller.address, "program.image", {{"bytes", bytes.size()}});
  answer.give_file({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, context.identity.plant + ".pbc");
}

constexpr Call kCalls[] = {
    {.name = "program",
     .path = "/api/program",
     .doc = "Which program runs.",
     .response = kProgramAnswer,
     .example = "{}",
     .run = program},
    {.name = "program.project",
     .path = "/api/program/project",
     .right = Right::kEngineer,
     .doc = "The project that was given to plc-run, as a file; a folder of sources as a tar archive. Recorded in the "
            "audit.",
     .example = "{}",
     .run = project,
     .form = Form::kFile,
     .thread = Thread::kFiles},
    {.name = "program.image",
     .path = "/api/program/image",
     .right = Right::kEngineer,
     .doc = "The image that runs, for `plc-run FILE.pbc`. Recorded in the audit.",
     .example = "{}",
     .run = image,
     .form = Form::kFile,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> program_calls() { return kCalls; }

}  // namespace plc::engineering
